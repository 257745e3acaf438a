'use strict';

const { comparison } = run;
const shown = showPair(run.pairs[0]);
const { parts } = shown;

const runs = [comparison.stock, comparison.plugin];
const row = (name, text) => [name, ...runs.map((one) => (one ? text(one) : 'no answer'))];
fillTable(parts['comparison-table'], ['', 'stock PCL', 'pcl_gpu_icp'], [
  row('time', (one) => milliseconds(one.time_ms)),
  row('iterations', (one) => String(one.iterations)),
  row('ended by', (one) => one.reason),
  row('RMSE', (one) => short(one.rmse, 9)),
  row('fitness', (one) => short(one.fitness_score, 9))]);

const { difference, tolerance } = comparison;
parts['comparison-note'].textContent = difference
  ? `${short(comparison.speedup)} times as fast, the device's start (${milliseconds(comparison.plugin.start_ms)}) included. ` +
    `The transforms differ by ${short(difference.degrees)} degrees and, at the source's centroid, ` +
    `${short(difference.metres)}: ${comparison.agree ? 'within' : 'more than'} ${tolerance.degrees} degrees and ${tolerance.metres}.`
  : `Stock PCL has no answer: ${comparison.stock_failure}.`;
parts.comparison.hidden = false;

document.title = `stock PCL and pcl_gpu_icp: ${parts.title.textContent}`;
document.addEventListener('keydown', shown.onKey);
