'use strict';

const VERDICT_COLOURS = { good: '#00795a', doubtful: '#9a6700', wrong: '#b3261e', failed: '#59636e' };
const VERDICTS = ['failed', 'wrong', 'doubtful', 'good'];

const { summary, rows } = run;
const parts = instance('batch');
document.getElementById('main').append(parts.root);

/** The pair that is shown, if one is. */
let chosen = null;

/** Draws both clouds from above, after the alignment. */
function drawThumbnail(canvas, pair) {
  const context = canvas.getContext('2d');
  const { low, high } = pair.box;
  const scale = 0.94 * Math.min(canvas.width / (high[0] - low[0] || 1), canvas.height / (high[1] - low[1] || 1));
  const dot = Math.max(1.5, Math.min(4, 60 / Math.sqrt(pair.target.shown)));
  const draw = (xyz, [x_row, y_row], colour) => {
    context.fillStyle = colour;
    for (let i = 0; i < xyz.length; i += 3) {
      const along = (row) => row[0] * xyz[i] + row[1] * xyz[i + 1] + row[2] * xyz[i + 2] + row[3];
      context.fillRect(canvas.width / 2 + scale * (along(x_row) - (low[0] + high[0]) / 2) - dot / 2,
        canvas.height / 2 - scale * (along(y_row) - (low[1] + high[1]) / 2) - dot / 2, dot, dot);
    }
  };
  draw(floats(pair.target.block), [[1, 0, 0, 0], [0, 1, 0, 0]], '#0072b2b0');
  draw(floats(pair.source.block), pair.poses[1].matrix, '#e69f00b0');
}

function choose(row) {
  if (chosen) chosen.close();
  parts.chosen.textContent = '';
  for (const line of parts.pairs.querySelectorAll('tbody tr'))
    line.classList.toggle('chosen', line.dataset.pair === String(row.pair));
  if (row.shown === undefined) {
    chosen = null;
    const why = row.verdict === 'failed' ? row.why
      : 'Its clouds are not in this report, which has as many as fit in, of the worst pairs of the run that made it.';
    parts.chosen.append(element('section', { class: 'card' }, element('h2', {}, `Pair ${row.pair}`), element('p', {}, why)));
  } else {
    chosen = showPair(run.pairs[row.shown], parts.chosen);
  }
  parts.chosen.focus({ preventScroll: true });
  parts.chosen.scrollIntoView({ block: 'start' });
}

function fillPairs() {
  const text = $.fn.dataTable.render.text();
  const file = (path, type) => (type === 'display' ? text.display(fileName(path)) : path);
  const number = (digits) => (value, type) =>
    (type === 'display' ? (value === null || value === undefined ? '' : short(value, digits)) : value === null || value === undefined ? -1 : value);
  const table = $(parts.pairs).DataTable({
    data: rows,
    deferRender: true,
    pageLength: 10,
    order: [],
    dom: 'ftip',
    autoWidth: false,
    language: { search: 'filter:', info: '_START_ to _END_ of _TOTAL_ pairs', infoFiltered: '(of _MAX_)', infoEmpty: 'no pairs' },
    columns: [
      { title: 'from above', data: null, defaultContent: '', orderable: false, className: 'thumbnail' },
      { title: 'pair', data: 'pair', className: 'number' },
      { title: 'verdict', data: 'verdict', render: (value, type) => (type === 'sort' ? VERDICTS.indexOf(value) : text.display(value)) },
      { title: 'source', data: 'source', className: 'file', render: file },
      { title: 'target', data: 'target', className: 'file', render: file },
      { title: 'near', data: 'near', className: 'number', defaultContent: '',
        render: (value, type) => (type === 'display' ? (typeof value === 'number' ? percent(value) : '') : typeof value === 'number' ? value : -1) },
      { title: 'RMSE', data: 'rmse', className: 'number', defaultContent: '', render: number(4) },
      { title: 'iterations', data: 'iterations', className: 'number', defaultContent: '', render: number(7) },
      { title: 'ms', data: 'time_ms', className: 'number', defaultContent: '', render: number(4) },
      { title: 'ended', data: 'status', render: text },
      { title: 'why', data: 'why', defaultContent: '', className: 'why', render: text },
    ],
    createdRow(line, row) {
      line.dataset.pair = row.pair;
      line.tabIndex = 0;
      line.title = `${row.source} onto ${row.target}`;
      const verdict = line.children[2];
      verdict.prepend(element('span', { class: `dot ${row.verdict}` }));
      line.addEventListener('click', () => choose(row));
      line.addEventListener('keydown', (event) => { if (event.key === 'Enter') choose(row); });
      if (row.shown === undefined) return;
      const picture = element('canvas', { width: 192, height: 120 });
      line.children[0].append(picture);
      drawThumbnail(picture, run.pairs[row.shown]);
    },
  });
  return table;
}

function drawOrder() {
  const points = rows.filter((row) => typeof row.near === 'number' || row.verdict === 'failed');
  const sets = VERDICTS.filter((verdict) => points.some((row) => row.verdict === verdict)).map((verdict) => ({
    label: verdict, backgroundColor: VERDICT_COLOURS[verdict], borderColor: VERDICT_COLOURS[verdict],
    pointStyle: { good: 'circle', doubtful: 'triangle', wrong: 'crossRot', failed: 'rect' }[verdict],
    pointRadius: 4, pointHoverRadius: 6, borderWidth: 2, clip: 8,
    data: points.filter((row) => row.verdict === verdict).map((row) => ({ x: row.pair, y: row.near || 0, row })) }));
  const errors = rows.filter((row) => typeof row.rmse === 'number').sort((a, b) => a.pair - b.pair);
  sets.push({ label: 'RMSE', type: 'line', yAxisID: 'rmse', pointStyle: 'line', borderWidth: 1.5,
    showLine: run.trajectory.length > 0, pointRadius: run.trajectory.length ? 0 : 6,
    borderColor: '#8c959f', backgroundColor: '#8c959f', data: errors.map((row) => ({ x: row.pair, y: row.rmse, row })) });
  return new Chart(parts.order, {
    type: 'scatter',
    data: { datasets: sets },
    options: {
      scales: {
        x: { title: { display: true, text: 'pair' }, grid: { color: RULE }, ticks: { precision: 0 } },
        y: { min: 0, max: 1, grid: { color: RULE }, ticks: { callback: percent } },
        rmse: { axis: 'y', position: 'right', min: 0, grid: { display: false }, ticks: { callback: (value) => short(value) } } },
      interaction: { mode: 'nearest', axis: 'xy', intersect: false },
      onClick: (event, found) => { if (found.length) choose(sets[found[0].datasetIndex].data[found[0].index].row); },
      plugins: {
        legend: { labels: { usePointStyle: true, boxWidth: 8, boxHeight: 8 } },
        tooltip: { callbacks: { label: ({ raw }) => `pair ${raw.row.pair}: ${raw.row.source} onto ${raw.row.target}` } } } } });
}

function drawTrajectory() {
  const places = run.trajectory;
  if (places.length < 2) return;
  parts['trajectory-card'].hidden = false;
  const ended = summary.trajectory.ends_before_pair;
  parts['trajectory-note'].textContent =
    `${count(summary.trajectory.poses)} of ${count(summary.trajectory.scans)} scans, x to the right and y up, in the frame of the ` +
    `first and the unit of the files${ended === null ? '' : `; pair ${ended} has no transform`}.`;
  // As much of x as of y to a pixel.
  const equal = (chart) => {
    const { width, height } = chart.chartArea || chart;
    const range = (axis) => [Math.min(...places.map((place) => place[axis])), Math.max(...places.map((place) => place[axis]))];
    const [x, y] = [range(0), range(1)];
    const unit = 1.1 * Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height) || 1;
    const set = (scale, [low, high], pixels) => {
      scale.min = (low + high) / 2 - unit * pixels / 2;
      scale.max = (low + high) / 2 + unit * pixels / 2;
    };
    set(chart.options.scales.x, x, width);
    set(chart.options.scales.y, y, height);
  };
  const ticks = { callback: (value, index, all) => (index === 0 || index === all.length - 1 ? '' : short(value)), maxRotation: 0 };
  const chart = new Chart(parts.trajectory, {
    type: 'line',
    data: { datasets: [
      { label: 'scans', data: places.map(([x, y]) => ({ x, y })), borderColor: '#0072b2', backgroundColor: '#0072b2',
        borderWidth: 2, pointRadius: places.length < 200 ? 3 : 0 },
      { label: 'first', data: [{ x: places[0][0], y: places[0][1] }], backgroundColor: '#e69f00', borderColor: '#e69f00',
        pointRadius: 6, showLine: false }] },
    options: {
      parsing: false,
      onResize: (resized) => { setTimeout(() => { equal(resized); resized.update('none'); }); },
      scales: { x: { type: 'linear', grid: { color: RULE }, ticks }, y: { type: 'linear', grid: { color: RULE }, ticks } },
      plugins: { tooltip: { callbacks: { label: ({ dataIndex }) => `scan ${dataIndex}` } } } } });
  equal(chart);
  chart.update();
}

parts.title.textContent = `${count(summary.pairs)} pairs`;
document.title = `pcl_gpu_icp batch: ${summary.pairs} pairs`;
const number = (name, text, verdict) => parts.numbers.append(element('span', {},
  ...(verdict ? [element('span', { class: `dot ${verdict}` })] : []), `${name} `, element('b', {}, text)));
for (const verdict of ['good', 'doubtful', 'wrong']) number(verdict, count(summary.verdicts[verdict]), verdict);
number('failed', count(summary.failed), 'failed');
number('time', `${short(summary.wall_s)} s`);
if (summary.pairs_per_second) number('pairs a second', short(summary.pairs_per_second));

drawTrajectory();
drawOrder();
fillPairs();
const missing = summary.pairs - rows.length;
parts['pairs-note'].textContent = `The worst pairs come first; a click on a head sorts, a click on a pair shows it. ` +
  `${count(run.pairs.length)} of ${count(summary.pairs)} pairs have their clouds here` +
  (run.pairs.length ? `, up to ${count(Math.max(...run.pairs.map((pair) => pair.target.shown)))} points of each, drawn at random.` : '.') +
  (missing ? ` ${count(missing)} pairs are not in the table: the results file has them.` : '');
document.addEventListener('keydown', (event) => { if (chosen) chosen.onKey(event); });
const first = rows.find((row) => row.shown !== undefined);
if (first) {
  chosen = showPair(run.pairs[first.shown], parts.chosen);
  parts.pairs.querySelector(`tr[data-pair="${first.pair}"]`).classList.add('chosen');
}
