'use strict';

// What the scripts of a page share. Text from outside comes into the page as text alone.

const run = JSON.parse(document.getElementById('run').textContent);

/** The little-endian floats of a data block. */
function floats(id) {
  const text = atob(document.getElementById(id).textContent.trim());
  const bytes = Uint8Array.from(text, (character) => character.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

/** A copy of a template, and what in it has a data-id, by that. */
function instance(template) {
  const root = document.importNode(document.getElementById(template).content, true).firstElementChild;
  const parts = { root };
  for (const part of root.querySelectorAll('[data-id]')) parts[part.dataset.id] = part;
  return parts;
}

/** An element with text or other elements in it. */
function element(name, attributes = {}, ...content) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...content.map((part) => (part instanceof Node ? part : String(part))));
  return made;
}

/** A number for reading, with so many digits. */
function short(value, digits = 3) {
  if (value === null || value === undefined) return 'undefined';
  const text = Number(value.toPrecision(digits));
  return Math.abs(text) >= 1e6 || (text !== 0 && Math.abs(text) < 1e-4) ? text.toExponential() : String(text);
}

/** The last part of a path. */
const fileName = (path) => path.replace(/\/+$/, '').split('/').pop();

const percent = (share) => `${Math.round(100 * share)} %`;
const count = (number) => number.toLocaleString('en');
const milliseconds = (time) => `${time.toFixed(1)} ms`;

/** The rows of a table, each with its head in the first place; numbers stand right in a table with a head of its own. */
function fillTable(table, head, rows) {
  const numeric = (cell) => (head && typeof cell === 'string' && /^[-+]?[\d.,]+(e[-+]?\d+)?( ms| %|°)?$/.test(cell) ? { class: 'number' } : {});
  if (head) {
    const columns = head.map((text, i) => element('th', rows.length && i ? numeric(rows[0][i]) : {}, text));
    table.append(element('thead', {}, element('tr', {}, ...columns)));
  }
  const body = rows.map((row) =>
    element('tr', {}, ...row.map((cell, i) => element(i ? 'td' : 'th', i ? numeric(cell) : { scope: 'row' }, cell))));
  table.append(element('tbody', {}, ...body));
}

/** Puts text on the clipboard, also where a page from a file may not use it. */
async function copyText(button, text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch (refused) {
    const area = element('textarea', {}, text);
    document.body.append(area);
    area.select();
    document.execCommand('copy');
    area.remove();
  }
  button.textContent = 'copied';
  setTimeout(() => { button.textContent = 'copy'; }, 1500);
}
