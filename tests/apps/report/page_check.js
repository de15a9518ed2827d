// Runs inside a page under test and leaves what it finds in <pre id="check">.
(async function () {
'use strict';
const found = {};
const pause = () => new Promise(done => setTimeout(done, 30));

function luminance([r, g, b]) {
  const part = v => v <= 10.3 ? v / 3294.6 : ((v / 255 + 0.055) / 1.055) ** 2.4;
  return 0.2126 * part(r) + 0.7152 * part(g) + 0.0722 * part(b);
}
const rgba = text => (text.match(/[\d.]+/g) || []).map(Number);

function contrast(one, other) {
  const a = luminance(one), b = luminance(other);
  return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
}

function ground(node) {
  for (let at = node; at; at = at.parentElement) {
    const colour = rgba(getComputedStyle(at).backgroundColor);
    if (colour.length < 4 || colour[3] > 0.99) return colour;
  }
  return [255, 255, 255];
}

// Text whose contrast is below 4.5, or 3 where it is large.
function faint() {
  const bad = [];
  const judge = (node, value, least) => {
    if (value < least) {
      bad.push(node.textContent.slice(0, 40) + ' ' + value.toFixed(2));
    }
  };
  document.querySelectorAll('body *').forEach(node => {
    if (node.closest('svg, script, #check') || !node.offsetParent) return;
    const own = Array.from(node.childNodes).some(
        child => child.nodeType === 3 && child.textContent.trim());
    if (!own) return;
    const style = getComputedStyle(node);
    judge(node, contrast(rgba(style.color), ground(node)),
          parseFloat(style.fontSize) >= 24 ? 3 : 4.5);
  });
  // The lightest colours of Okabe and Ito have 2.2 : 1 on white; lines differ
  // in width and dashes, too.
  const colour = node => rgba(getComputedStyle(node).color);
  document.querySelectorAll('svg.drawing').forEach(svg => {
    const behind = colour(svg.querySelector('.ground'));
    svg.querySelectorAll('text').forEach(text => {
      judge(text, contrast(colour(text), behind), 4.5);
    });
    svg.querySelectorAll('.series').forEach(series => {
      judge(series, contrast(colour(series), behind), 1.9);
    });
  });
  return bad;
}

const place = box => [box.left, box.top, box.right, box.bottom].map(
    at => at.toFixed(1)).join(' ');

// Texts of a figure that lie over each other or stand out of it, in this
// browser's font.
function overlapping() {
  const bad = [];
  document.querySelectorAll('svg.drawing').forEach(svg => {
    const whole = svg.getBoundingClientRect();
    const texts = Array.from(svg.querySelectorAll('text'), node => ({
      words: node.textContent, box: node.getBoundingClientRect(),
    }));
    texts.forEach(({words, box: a}, i) => {
      if (a.left < whole.left - 1 || a.right > whole.right + 1 ||
          a.top < whole.top - 3 || a.bottom > whole.bottom + 3) {
        bad.push('outside: ' + words);
      }
      texts.slice(i + 1).forEach(({words: others, box: b}) => {
        const high = 0.25 * Math.min(a.height, b.height);
        if (a.left < b.right - 1 && b.left < a.right - 1 &&
            a.top < b.bottom - high && b.top < a.bottom - high) {
          bad.push(words + ' over ' + others + ', ' + place(a) + ' over ' +
                   place(b));
        }
      });
    });
  });
  return bad;
}

// The smallest letters of the figures, in pixels.
function smallest() {
  return Array.from(document.querySelectorAll('svg.drawing text')).filter(
      text => text.getBoundingClientRect().width > 0).reduce(
      (least, text) => Math.min(
          least, parseFloat(getComputedStyle(text).fontSize) *
              text.getScreenCTM().a || least), Infinity);
}

// What the line above the first figure shows with the pointer in its middle.
function readout() {
  const panel = Array.from(document.querySelectorAll('.panel')).find(
      one => one.getBoundingClientRect().width > 0);
  if (!panel) return '';
  const box = panel.querySelector('.grid').getBoundingClientRect();
  panel.dispatchEvent(new PointerEvent('pointermove', {
    bubbles: true, clientX: box.left + box.width / 2,
    clientY: box.top + box.height / 2,
  }));
  return panel.closest('figure').querySelector('.readout').textContent;
}

// What is cut: tables wider than their box, which then scrolls.
const cut = () => Array.from(document.querySelectorAll('.scroll.table')).filter(
    box => box.scrollWidth > box.clientWidth + 1).length;

// Whether a node stands in one of a table's many rows, but for the first and last
// twenty, and not in every tenth.
function isInManyRows(node) {
  const row = node.closest('tbody tr');
  if (!row) return false;
  const at = row.sectionRowIndex;
  return at >= 20 && at < row.parentElement.rows.length - 20 && at % 10 !== 0;
}

// What a keyboard does not reach, or reaches without a visible outline: links,
// folds, buttons, and boxes that scroll. Every step takes the layout of the
// whole page, so of many rows some are tried.
function unreachable() {
  const targets = document.querySelectorAll(
      'a[href], summary, button, .scroll, input:not([type=hidden]), select');
  return Array.from(targets).filter(target => {
    if (isInManyRows(target)) return false;
    if (getComputedStyle(target).display === 'none') return false;
    target.focus({focusVisible: true, preventScroll: true});
    const style = getComputedStyle(target);
    return document.activeElement !== target || target.tabIndex < 0 ||
        style.outlineStyle === 'none' || parseFloat(style.outlineWidth) < 1;
  }).map(target => target.outerHTML.slice(0, 100));
}

// Another task, for which the browser's clock does not go on.
function task() {
  return new Promise(done => {
    const channel = new MessageChannel();
    channel.port1.onmessage = () => {
      channel.port1.close();
      done();
    };
    channel.port2.postMessage(null);
  });
}

// What the first button that copies says and offers, after a click. The
// clipboard answers in the time of the machine, which pause() does not wait for.
async function copied() {
  const button = document.querySelector('button.copy');
  if (!button) return null;
  const before = button.textContent;
  button.click();
  for (let i = 0; i < 50000 && button.textContent === before; ++i) await task();
  return {text: button.dataset.text, says: button.textContent};
}

// What the fields above a table do, and its first header.
function filtered() {
  const box = document.querySelector('.filtered');
  if (!box) return null;
  const rows = box.querySelector('table').tBodies[0].rows;
  const input = box.querySelector('input');
  const choice = box.querySelector('select');
  const shown = () => Array.from(rows).filter(
      row => row.getClientRects().length > 0).length;
  const change = (field, value) => {
    field.value = value;
    field.dispatchEvent(new Event('input', {bubbles: true}));
    return {shown: shown(), says: box.querySelector('output').textContent};
  };
  const first = () => rows[0].cells[0].textContent;
  const found = {rows: rows.length, shown: shown(), first: first()};
  found.searched = change(input, first().toUpperCase());
  found.nothing = change(input, 'not to be found');
  found.cleared = change(input, '');
  found.choices = Array.from(choice.options, option => option.textContent);
  found.chosen = change(choice, choice.options[1].value);
  found.all = change(choice, '');
  const button = box.querySelector('button.sort');
  button.click();
  found.ascending = first();
  button.click();
  found.descending = first();
  return found;
}

await pause();
found.height = document.querySelector('main').getBoundingClientRect().height;
found.folds = document.querySelectorAll('details').length;
found.open = document.querySelectorAll('details[open]').length;
found.badge = (document.querySelector('.badge') || {}).textContent;
found.cut = cut();
found.overflow_folded = document.documentElement.scrollWidth - window.innerWidth;
found.faint_folded = faint();
found.copied = await copied();
found.filtered = filtered();
// Everything else is looked at with all folds open.
document.querySelectorAll('details').forEach(fold => { fold.open = true; });
await pause();
found.cut_open = cut();
found.figures = document.querySelectorAll(
    '.picture:not(.narrow) > svg').length;
found.panels = document.querySelectorAll(
    '.picture:not(.narrow) .panel').length;
found.texts = Array.from(document.querySelectorAll('svg.drawing text'),
                         text => text.textContent);
found.injected = document.querySelectorAll('[data-injected]').length;
found.requests = performance.getEntriesByType('resource').map(r => r.name);
found.width = window.innerWidth;
found.dark = matchMedia('(prefers-color-scheme: dark)').matches;
found.overflow = document.documentElement.scrollWidth - window.innerWidth;
found.faint = faint();
// Once in hundreds of visits, on a busy machine, one text lay over another for a
// moment: what lies there must do so twice.
found.overlapping = overlapping();
if (found.overlapping.length > 0) {
  await pause();
  found.overlapping = overlapping();
}
found.smallest = smallest();
found.readout = readout();
found.unreachable = unreachable();
const out = document.createElement('pre');
out.id = 'check';
out.hidden = true;
out.textContent = JSON.stringify(found);
(window.frameElement ? window.parent.document : document).body.append(out);
})();
