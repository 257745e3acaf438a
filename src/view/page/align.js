'use strict';

const shown = showPair(run.pairs[0]);
document.title = `${run.pairs[0].result.verdict}: ${shown.parts.title.textContent}`;
document.addEventListener('keydown', shown.onKey);
