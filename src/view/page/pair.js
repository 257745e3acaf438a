'use strict';

// A pair of clouds and what their alignment came to.

/** Bars one below the other, each beginning where the one before at its depth ends, within the whole it is part of. */
function fillTimes(root, times, wholes) {
  const whole = times.total ? 'total' : 'align';
  const add = (name, start, depth) => {
    const deep = `deep-${depth}`;
    const bar = element('i', { style: `left:${100 * start / times[whole]}%;width:${100 * times[name] / times[whole]}%` });
    root.append(
      element('span', { class: deep }, name.replace('device_', 'device: ')), element('div', { class: `track ${deep}` }, bar),
      element('span', { class: 'milliseconds' }, milliseconds(times[name])));
    let at = start;
    for (const part of Object.keys(times))
      if (wholes[part] === name) {
        add(part, at, depth + 1);
        at += times[part];
      }
  };
  add(whole, 0, 0);
}

function fillUncertainty(parts, result) {
  const found = result.uncertainty;
  if (!found) return;
  const direction = (axis) => `(${axis.direction.map((value) => short(Math.round(100 * value) / 100 + 0)).join(', ')})`;
  const sure = (axis, unit) => (axis.deviation === null ? 'not determined' : short(axis.deviation) + unit);
  fillTable(parts.uncertainty, ['', 'direction', 'deviation'], [
    ...found.shifts.map((axis) => ['along', direction(axis), sure(axis, '')]),
    ...found.turns_degrees.map((axis) => ['about', direction(axis), sure(axis, '°')])]);
  parts['uncertainty-note'].textContent =
    'One standard deviation, of the noise of the pairs: it does not know whether they are the right ones.';
}

function fillPoints(parts, pair) {
  const { points } = pair.result;
  const row = (role, file) => {
    const dropped = points.dropped && points.dropped[role];
    return [role, file, count(points[role]), ...(dropped ? ['non_finite', 'zero_returns', 'downsampled', 'coincident'].map(
      (why) => count(dropped[why])) : [])];
  };
  fillTable(parts.points, ['', 'file', 'used', 'not finite', 'zero returns', 'merged by --leaf', 'repeat another'].slice(
    0, points.dropped ? 7 : 3), [row('source', pair.result.source), row('target', pair.result.target)]);
  for (const warning of pair.result.warnings || []) parts.warnings.append(element('li', {}, warning));
}

function fillHeader(parts, pair) {
  const { result } = pair;
  parts.verdict.textContent = result.verdict;
  parts.verdict.classList.add(result.verdict);
  parts.title.textContent = `${fileName(result.source)} onto ${fileName(result.target)}`;
  const number = (name, text) => parts.numbers.append(element('span', {}, `${name} `, element('b', {}, text)));
  if (result.rmse !== null) number('RMSE', `${short(result.rmse_before, 4)} → ${short(result.rmse, 4)}`);
  if (result.quality)
    number('near the target', `${percent(result.quality.source_near.before)} → ${percent(result.quality.source_near.after)}`);
  number('iterations', String(result.iterations));
  if (result.times_ms && result.times_ms.total) number('time', milliseconds(result.times_ms.total));
  number('ended', result.ending);
  const tried = result.tried || [];
  if (tried.length > 1)
    number('started from', tried.map((start) => `${start.from} (${start.verdict}${start.taken ? ', taken' : ''})`).join(', '));
  for (const reason of result.why ? [result.why] : result.reasons) parts.reasons.append(element('li', {}, reason));
  for (const advice of result.advice) parts.reasons.append(element('li', {}, `try: ${advice}`));
}

function fillRepeat(parts, pair) {
  parts.command.textContent = run.repeat.command;
  fillTable(parts.facts, null, Object.entries(run.repeat.facts));
  parts.json.textContent = JSON.stringify(pair.result, null, 2);
}

function shownText(pair) {
  const of = (role) => (pair[role].shown === pair[role].all
    ? `all ${count(pair[role].all)} points of the ${role}`
    : `${count(pair[role].shown)} of ${count(pair[role].all)} points of the ${role}, drawn at random`);
  return `Shown: ${of('source')}; ${of('target')}.`;
}

/** Fills the legend and makes the buttons, the slider and the keys work. */
function controlScene(scene, parts, pair) {
  const { root } = parts;
  const button = (name) => root.querySelector(`[data-do="${name}"]`);
  let moving = 0;
  const showTime = (time) => {
    parts.time.value = time;
    scene.setTime(time);
  };
  const moveTo = (goal) => {
    cancelAnimationFrame(moving);
    const from = scene.time, begin = performance.now(), takes = 350;
    const step = (now) => {
      const part = Math.min(1, Math.max(0, (now - begin) / takes));
      showTime(from + (goal - from) * part);
      if (part < 1) moving = requestAnimationFrame(step);
    };
    moving = requestAnimationFrame(step);
  };
  const toggle = (name, act) => {
    const on = button(name).getAttribute('aria-pressed') !== 'true';
    button(name).setAttribute('aria-pressed', on);
    act(on);
  };
  const showLegend = (by_distance) => {
    parts.legend.textContent = '';
    const entry = (colour, text) => {
      const dot = element('span', { class: 'dot' });
      dot.style.background = colour;
      parts.legend.append(element('li', {}, dot, text));
    };
    if (!by_distance)
      pair.poses.slice(1).forEach((pose, i) => {
        if (scene.sources[i].visible)
          entry(i ? 'var(--second)' : 'var(--source)', pair.poses.length > 2 ? `source, ${pose.name}` : 'source');
      });
    entry(by_distance ? '#aab2bb' : 'var(--target)', 'target');
  };
  let by_distance = false;
  const actions = {
    before: () => moveTo(0),
    after: () => moveTo(1),
    above: () => scene.look('above'),
    front: () => scene.look('front'),
    side: () => scene.look('side'),
    reset: () => scene.look('reset'),
    distance: () => toggle('distance', (on) => {
      by_distance = on;
      scene.colourByDistance(on);
      showLegend(on);
      parts.ramp.hidden = !on;
    }),
    arrows: () => toggle('arrows', (on) => {
      scene.showArrows(on);
      parts['arrows-note'].hidden = !on;
    }),
  };
  for (const [name, act] of Object.entries(actions)) button(name).addEventListener('click', act);
  parts.time.addEventListener('input', () => {
    cancelAnimationFrame(moving);
    scene.setTime(Number(parts.time.value));
  });

  if (pair.poses.length > 2) {
    const choices = [[[0], pair.poses[1].name], [[1], pair.poses[2].name], [[0, 1], 'both']];
    const first = run.comparison ? 2 : 0;
    choices.forEach(([shown, name], i) => {
      const choice = element('button', { type: 'button', 'aria-pressed': i === first }, name);
      choice.addEventListener('click', () => {
        for (const other of parts.results.children) other.setAttribute('aria-pressed', other === choice);
        scene.select(shown);
        showLegend(by_distance);
      });
      parts.results.append(choice);
    });
    parts.results.hidden = false;
    scene.select(choices[first][0]);
  }
  showLegend(false);

  const { edges } = pair.histogram;
  const across = (distance) => 100 * Math.log(distance / edges[0]) / Math.log(edges[edges.length - 1] / edges[0]);
  for (const share of [0.12, 0.5, 0.88]) {
    const distance = edges[0] * (edges[edges.length - 1] / edges[0]) ** share;
    const tick = element('span', {}, short(distance, 2));
    tick.style.left = `${across(distance)}%`;
    parts['ramp-ticks'].append(tick);
  }

  const { uncertainty } = pair.result;
  if (uncertainty && scene.uncertainty.children.length) {
    button('arrows').hidden = false;
    const axes = [...uncertainty.shifts, ...uncertainty.turns_degrees];
    const free = axes.some((axis) => axis.deviation === null);
    parts['arrows-note'].textContent =
      `Dark arrows: one standard deviation along each direction, enlarged ${count(scene.enlarged)} times.` +
      (free ? ' Red arrows and rings: motions along and about them are not determined.' : '');
    if (free) actions.arrows();
  }

  const keys = { b: 'before', a: 'after', 1: 'above', 2: 'front', 3: 'side', r: 'reset', d: 'distance' };
  return (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|TEXTAREA|SELECT)$/.test(event.target.tagName)
        && event.target.type !== 'range') return;
    const key = event.key.toLowerCase();
    if (keys[key]) actions[keys[key]]();
    else if (key === 'u' && !button('arrows').hidden) actions.arrows();
    else if (key === ' ' && event.target.tagName !== 'BUTTON' && event.target.tagName !== 'SUMMARY') moveTo(scene.time < 0.5 ? 1 : 0);
    else if (key === '+' || key === '=') scene.zoom(1 / 1.2);
    else if (key === '-') scene.zoom(1.2);
    else return;
    event.preventDefault();
  };
}

/** @return what in the page shows it, what it does with a key, and how to remove it */
function showPair(pair, root = document.getElementById('main')) {
  const parts = instance('pair');
  const { result } = pair;
  root.append(parts.root);
  fillHeader(parts, pair);
  parts.shown.textContent = `${shownText(pair)}`;
  let onKey = () => {}, scene = null;
  try {
    scene = new Scene(parts.view, parts.axes);
    scene.show(pair);
    parts.shown.textContent += ` A square of the grid is ${short(scene.square)} wide.`;
    onKey = controlScene(scene, parts, pair);
    parts.scene.scene = scene;
  } catch (error) {
    parts.view.append(element('p', { class: 'failed' }, `No 3-D view: ${error.message}`));
  }
  const charts = [drawHistogram(parts.histogram, pair)];
  const errors = floats(pair.errors);
  if (errors.length) {
    charts.push(drawIterations(parts.iterations, errors, result.searched || []));
    parts['iterations-note'].textContent = 'Points searched for: those whose match could have changed.';
  } else parts['iterations-card'].hidden = true;
  const matrix = result.transform.map((row) => row.map((value) => value.toFixed(10).padStart(16)).join(' ')).join('\n');
  parts.matrix.textContent = matrix;
  fillUncertainty(parts, result);
  if (result.times_ms) fillTimes(parts.times, result.times_ms, pair.wholes);
  else parts['times-card'].hidden = true;
  fillPoints(parts, pair);
  fillRepeat(parts, pair);
  for (const button of parts.root.querySelectorAll('[data-copy]'))
    button.addEventListener('click', () =>
      copyText(button, button.dataset.copy === 'command' ? run.repeat.command
        : result.transform.map((row) => row.join(' ')).join('\n')));
  const close = () => {
    if (scene) scene.close();
    for (const chart of charts) chart.destroy();
    parts.root.remove();
  };
  return { parts, onKey, close };
}
