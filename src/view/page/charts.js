'use strict';

// Histogram and iterations, drawn by Chart.js.

const INK = '#1b1f24', MUTED = '#59636e', RULE = '#e4e7ea';
/** Before, after, and a second result. */
const POSE_COLOURS = ['#8c959f', '#00795a', '#cc79a7'];

Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
Chart.defaults.font.size = 13;
Chart.defaults.color = MUTED;
Chart.defaults.animation = false;
Chart.defaults.maintainAspectRatio = false;
Chart.defaults.interaction = { mode: 'nearest', axis: 'x', intersect: false };
Chart.defaults.elements.point.radius = 0;
Chart.defaults.plugins.legend.align = 'start';
Chart.defaults.plugins.legend.labels.boxWidth = 12;
Chart.defaults.plugins.legend.labels.boxHeight = 12;

/** Labels of 1, 2 and 5 times a power of ten, or only of the powers where there are many. */
function logarithmicTick(value, index, ticks) {
  const decades = Math.log10(ticks[ticks.length - 1].value / ticks[0].value);
  const digit = Number((value / 10 ** Math.floor(Math.log10(value) + 1e-9)).toFixed(6));
  return digit === 1 || (decades < 3 && (digit === 2 || digit === 5)) ? short(value) : '';
}

function drawHistogram(canvas, pair) {
  const { edges, counts, medians } = pair.histogram;
  const all = pair.source.shown;
  const top = Math.max(...counts.flat()) / all;
  const sets = counts.map((bins, pose) => ({
    label: `${pair.poses[pose].name}, median ${short(medians[pose])}`,
    data: edges.map((x, i) => ({ x, y: (i < bins.length ? bins[i] : bins[i - 1]) / all })),
    stepped: 'before', fill: 'origin', borderWidth: 1.5,
    borderColor: POSE_COLOURS[pose], backgroundColor: `${POSE_COLOURS[pose]}40` }));
  const near = pair.result.quality ? 3 * pair.result.quality.spacing : 0;
  if (near > edges[0] && near < edges[edges.length - 1])
    sets.push({ label: `near: three spacings, ${short(near)}`, borderColor: INK, borderDash: [6, 5], borderWidth: 1.5,
      backgroundColor: '#ffffff', data: [{ x: near, y: 0 }, { x: near, y: top }] });
  return new Chart(canvas, {
    type: 'line',
    data: { datasets: sets },
    options: {
      scales: {
        x: { type: 'logarithmic', min: edges[0], max: edges[edges.length - 1], grid: { color: RULE },
          ticks: { callback: logarithmicTick, maxRotation: 0 } },
        y: { min: 0, grid: { color: RULE }, title: { display: true, text: 'share of the points' },
          ticks: { callback: (share) => `${short(100 * share)} %` } } },
      plugins: { tooltip: { enabled: false } } } });
}

function drawIterations(canvas, errors, searched) {
  const line = (label, values, axis, colour) => ({
    label, yAxisID: axis, borderColor: colour, backgroundColor: colour, borderWidth: 2,
    data: Array.from(values, (y, i) => ({ x: i + 1, y })), pointRadius: values.length < 40 ? 2.5 : 0 });
  const sets = [line('RMSE of the pairs', errors, 'error', POSE_COLOURS[1])];
  const scales = {
    x: { type: 'linear', min: 1, max: Math.max(2, errors.length), grid: { color: RULE }, ticks: { precision: 0 },
      title: { display: true, text: 'iteration' } },
    error: { axis: 'y', position: 'left', min: 0, grid: { color: RULE }, ticks: { callback: (value) => short(value) } } };
  if (searched.length) {
    sets.push(line('points searched for', searched, 'searched', '#0072b2'));
    scales.searched = { axis: 'y', position: 'right', min: 0, grid: { display: false }, ticks: { callback: (value) => count(value) } };
  }
  return new Chart(canvas, { type: 'line', data: { datasets: sets }, options: { scales } });
}
