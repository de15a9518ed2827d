#include "apps/report/page_style.h"

namespace mle::report {

std::string_view ReadoutScript() {
  return R"js(
'use strict';
function axis(text) {
  const [low, high, log] = text.split(' ');
  const from = log ? Math.log(low) : +low, to = log ? Math.log(high) : +high;
  const decimals = Math.max(0, Math.ceil(2 - Math.log10(to - from)));
  return {
    at: part => log ? Math.exp(from + part * (to - from))
                    : from + part * (to - from),
    show: value => (log || decimals > 6 ? String(+value.toPrecision(3))
        : value.toFixed(decimals).replace(/^-(0\.?0*)$/, '$1')
        ).replace(/-/g, '−'),
  };
}
function dates(text) {
  const [origin, unit, zone] = text.split(' ');
  return value => new Date(1000 * (+origin + value * unit)).toLocaleString(
      'sv-SE', {timeZone: zone});
}
// The points of a path stand behind its capital letters; M starts a line.
function points(path) {
  let x = 0, y = 0;
  return Array.from(path.getAttribute('d').matchAll(
      /([MLHV])([-\d.]+)(?: ([-\d.]+))?/g), ([, letter, a, b]) => {
    if (letter === 'V') y = +a; else x = +a;
    if (b !== undefined) y = +b;
    return {x, y, starts: letter === 'M'};
  });
}
// How high a curve is at x: on its last line over x, else at its nearest point.
function height(all, x, near) {
  for (let i = all.length - 1; i > 0; --i) {
    const a = all[i - 1], b = all[i];
    if (b.starts || a.x > x || b.x < x) continue;
    return b.x > a.x ? a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x) : b.y;
  }
  const point = all.reduce((a, b) =>
      Math.abs(b.x - x) < Math.abs(a.x - x) ? b : a);
  return Math.abs(point.x - x) < near ? point.y : null;
}
function prepare(panel) {
  const size = panel.querySelector('.plot');
  const x = axis(panel.dataset.x);
  return {
    panel, width: +size.getAttribute('width'),
    tall: +size.getAttribute('height'),
    x, y: axis(panel.dataset.y),
    date: panel.dataset.dates ? dates(panel.dataset.dates) : x.show,
    curves: Array.from(panel.querySelectorAll('.series'), group => ({
      label: (group.querySelector('title') || group).textContent.trim(),
      all: Array.from(group.querySelectorAll('path:not(.band)')).flatMap(
          points),
    })),
  };
}
function readout({panel, width, tall, x, y, date, curves}, event) {
  const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(
      panel.getScreenCTM().inverse());
  if (at.x < 0 || at.x > width || at.y < 0 || at.y > tall) return '';
  return ['at ' + date(x.at(at.x / width))].concat(curves.map(curve => {
    const py = height(curve.all, at.x, 0.01 * width);
    return py === null ? '' : curve.label + ' ' + y.show(y.at(1 - py / tall));
  })).filter(Boolean).join(' · ');
}
document.querySelectorAll('figure').forEach(figure => {
  const line = document.createElement('output');
  line.className = 'readout';
  figure.querySelector('.picture').after(line);
  let panels = null;
  figure.addEventListener('pointermove', event => {
    panels = panels ||
        Array.from(figure.querySelectorAll('.panel'), prepare);
    line.textContent = panels.map(p => readout(p, event)).find(Boolean) || '';
  });
});
)js";
}

namespace {

// The colours of text on ground have a contrast of at least 4.5 : 1 in both
// modes; figures have a style sheet of their own (svg.h).
constexpr std::string_view kStyle = R"css(
:root {
  color-scheme: light dark;
  --ground: #ffffff; --card: #f5f7f9; --text: #1c2126; --soft: #55606b;
  --rule: #d5dbe1; --accent: #00578a; --warn: #8a3c00; --warn-ground: #fdf1e7;
  --good: #1a6b3c; --changed: #9a4a00; --unknown: #55606b; --on-badge: #ffffff; --picture: #ffffff;
  --edge: #9aa5b0;
  --level-1: #e6f1f8; --level-2: #cbe2f1; --level-3: #a9cfe8; --level-4: #86bade;
}
@media (prefers-color-scheme: dark) {
  :root {
    --ground: #14181c; --card: #1e242a; --text: #e4e8ec; --soft: #a4afba;
    --rule: #39424b; --accent: #6cbcf0; --warn: #f5b27a; --warn-ground: #33261b;
    --good: #7fd6a2; --changed: #f5b27a; --unknown: #a4afba; --on-badge: #14181c; --picture: #1a1f24;
    --edge: #5d6a76;
    --level-1: #1c2f3e; --level-2: #1f3f57; --level-3: #244f70; --level-4: #2b5f88;
  }
}
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; text-size-adjust: 100%; }
body {
  margin: 0; background: var(--ground); color: var(--text);
  font: 1rem/1.55 system-ui, "Helvetica Neue", Helvetica, Arial, "DejaVu Sans", sans-serif;
}
main { max-width: 76rem; margin: 0 auto; padding: 1.5rem clamp(1rem, 4vw, 2.5rem) 4rem; }
h1, h2, h3 { line-height: 1.25; text-wrap: balance; overflow-wrap: anywhere; }
h1 { font-size: clamp(1.5rem, 1.2rem + 1.5vw, 2.1rem); margin: .5rem 0 1.25rem; }
h2 { font-size: 1.35rem; margin: 2rem 0 .6rem; padding-top: .8rem; border-top: 1px solid var(--rule); }
h3 { font-size: 1.1rem; margin: 2rem 0 .5rem; }
p, ul { max-width: 44rem; margin: .75rem 0; overflow-wrap: anywhere; }
a { color: var(--accent); }
a:focus-visible, [tabindex]:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
.verdict { background: var(--card); border-left: 6px solid var(--unknown); border-radius: 4px; padding: .8rem 1.2rem; margin: 0 0 1.25rem; }
.verdict.good { border-color: var(--good); } .verdict.changed { border-color: var(--changed); }
.verdict .title { color: var(--soft); margin: 0; font-size: .95rem; }
.verdict h1 { text-wrap: wrap; margin: .35rem 0 .6rem; font-size: clamp(1.3rem, 1.1rem + 1vw, 1.8rem); }
.verdict p { margin: .35rem 0; max-width: 60rem; }
.badge { display: inline-block; background: var(--unknown); color: var(--on-badge); border-radius: 1em; padding: .1em .75em; margin-right: .3em; font-size: .62em; font-weight: 600; letter-spacing: .02em; vertical-align: .16em; white-space: nowrap; }
.good .badge { background: var(--good); } .changed .badge { background: var(--changed); }
details { border-top: 1px solid var(--rule); }
details + h2, details + p { margin-top: 1.5rem; }
summary { cursor: pointer; padding: .55rem 0; color: var(--accent); font-weight: 600; }
summary:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
details[open] { padding-bottom: 1rem; }
.flag { white-space: nowrap; }
.copied { position: relative; }
.copy { font: inherit; font-size: .9rem; color: var(--accent); background: var(--card); border: 1px solid var(--rule); border-radius: 4px; padding: .25rem .8rem; cursor: pointer; }
.copy:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
.copied .table { margin-top: .6rem; }
.sort { font: inherit; color: inherit; background: none; border: 0; padding: 0; cursor: pointer; text-align: inherit; text-decoration: underline dotted; }
.sort:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
[aria-sort=ascending] .sort::after { content: " ▲"; } [aria-sort=descending] .sort::after { content: " ▼"; }
.filter, form { display: flex; flex-wrap: wrap; gap: .5rem 1.2rem; align-items: baseline; margin: .75rem 0; }
.filter label, form label { color: var(--soft); font-size: .95rem; }
.filter output { color: var(--soft); font-size: .95rem; font-variant-numeric: tabular-nums; }
input, select, form button { font: inherit; color: var(--text); background: var(--ground); border: 1px solid var(--edge); border-radius: 4px; padding: .3rem .6rem; max-width: 100%; }
form button { color: var(--accent); background: var(--card); cursor: pointer; }
input:focus-visible, select:focus-visible, form button:focus-visible { outline: 2px solid var(--accent); outline-offset: 2px; }
@media (scripting: none) { .copy, .filter { display: none; } .sort { text-decoration: none; cursor: auto; } }
.level-1 { background: var(--level-1); } .level-2 { background: var(--level-2); }
.level-3 { background: var(--level-3); } .level-4 { background: var(--level-4); }
.summary { background: var(--card); border-left: 4px solid var(--accent); border-radius: 4px; padding: .6rem 1.1rem; margin: 1.25rem 0; }
.summary p { font-size: 1.06rem; margin: .45rem 0; max-width: none; }
.warning { background: var(--warn-ground); border-left: 4px solid var(--warn); border-radius: 4px; padding: .6rem 1.1rem; margin: 1rem 0; }
.warning p { margin: .2rem 0; max-width: none; }
.warning strong { color: var(--warn); }
nav { margin: 1.25rem 0; font-size: .95rem; }
nav ul { list-style: none; padding: 0; display: flex; flex-wrap: wrap; gap: .35rem 1.4rem; max-width: none; }
nav a { display: inline-block; padding: .2rem 0; }
.scroll { overflow-x: auto; max-width: 100%; }
.table { margin: 1rem 0; }
/* A shadow at each side where a table or a picture goes on: the ground hides it at the ends. */
@media screen {
  .scroll {
    --under: var(--ground);
    background:
      linear-gradient(to right, var(--under) 40%, transparent) 0 0 / 2.5rem 100% no-repeat local,
      linear-gradient(to left, var(--under) 40%, transparent) 100% 0 / 2.5rem 100% no-repeat local,
      linear-gradient(to right, var(--edge), transparent) 0 0 / .6rem 100% no-repeat scroll,
      linear-gradient(to left, var(--edge), transparent) 100% 0 / .6rem 100% no-repeat scroll;
  }
  .picture { --under: var(--picture); background-color: var(--picture); }
  .picture .ground { fill-opacity: 0; }
}
table { border-collapse: collapse; font-size: .95rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--soft); padding: 0 0 .5rem; min-width: min(24rem, 80vw); max-width: min(44rem, 88vw); }
th, td { padding: .35rem .8rem; border-bottom: 1px solid var(--rule); vertical-align: baseline; }
th:first-child, td:first-child { padding-left: .1rem; }
thead th, thead td { border-bottom: 2px solid var(--soft); vertical-align: bottom; }
tbody th { font-weight: 600; }
.left { text-align: left; } .center { text-align: center; } .right { text-align: right; }
td.right, .date { white-space: nowrap; } th.right { min-width: 5.8em; }
figure { margin: 1.75rem 0; position: relative; }
.picture { border: 1px solid var(--rule); border-radius: 4px; padding: .6rem; }
.picture > svg { display: block; width: 100%; height: auto; margin: 0 auto; }
.readout { position: absolute; bottom: 100%; left: 0; right: 0; background: var(--ground); font-size: .85rem; color: var(--soft); overflow-wrap: anywhere; font-variant-numeric: tabular-nums; }
figcaption { color: var(--soft); font-size: .95rem; margin-top: .5rem; max-width: 44rem; overflow-wrap: anywhere; }
pre, code { font-family: ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace; font-size: .88rem; }
pre { background: var(--card); border: 1px solid var(--rule); border-radius: 4px; padding: .8rem 1rem; margin: .75rem 0; white-space: pre-wrap; overflow-wrap: anywhere; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .3rem 1.2rem; margin: .75rem 0; }
dt { color: var(--soft); } dd { margin: 0; overflow-wrap: anywhere; }
@media (max-width: 30rem) {
  dl { grid-template-columns: 1fr; gap: 0; } dd { margin-bottom: .5rem; }
  th, td { padding: .35rem .5rem; }
  tbody th.left { min-width: 7rem; }
}
.narrow { display: none; }
.filtered tbody th.left { min-width: 9rem; overflow-wrap: anywhere; }
.filtered td:last-child { min-width: 16rem; }
@media screen and (max-width: 40rem) {
  .wide { display: none; } .narrow { display: block; }
  .stacked .scroll { overflow: visible; background: none; }
  .stacked :is(table, caption, tbody, tr, th) { display: block; }
  .stacked thead { display: none; }
  .stacked tbody tr { padding: .5rem .5rem; border-bottom: 1px solid var(--rule); }
  .stacked :is(tbody th, td) { border: 0; padding: 0; text-align: left; min-width: 0; }
  .stacked td { display: inline-block; margin-right: 1rem; }
  .stacked td:empty { display: none; }
  .stacked td::before { content: attr(data-label) ": "; color: var(--soft); }
  .filtered .scroll { overflow: visible; background: none; }
  .filtered :is(table, caption, thead, tbody, tr, th) { display: block; }
  .filtered tr[hidden] { display: none; }
  .filtered thead tr { display: flex; flex-wrap: wrap; gap: .3rem 1rem; padding: .3rem 0; border-bottom: 2px solid var(--soft); }
  .filtered thead th { border: 0; padding: 0; min-width: 0; }
  .filtered tbody tr { padding: .6rem 0; border-bottom: 1px solid var(--rule); }
  .filtered :is(tbody th, td) { border: 0; padding: 0; text-align: left; min-width: 0; }
  .filtered td { display: inline-block; margin-right: 1rem; }
  .filtered td:last-child { display: block; margin: .15rem 0 0; }
  .filtered td::before { content: attr(data-label) ": "; color: var(--soft); }
  .filtered td:last-child::before { content: none; }
}
@page { size: A4; margin: 18mm 16mm; }
@media print {
  :root {
    color-scheme: light;
    --ground: #ffffff; --card: #ffffff; --text: #000000; --soft: #444444;
    --rule: #bbbbbb; --accent: #00578a; --warn: #8a3c00; --warn-ground: #ffffff;
  }
  body { font-size: 10pt; }
  main { max-width: none; padding: 0; }
  nav { display: none; }
  .copy, .filter, form { display: none; }
  .verdict { border: 1px solid var(--rule); border-left-width: 6px; }
  .badge { color: #000000; background: none !important; border: 1px solid #000000; }
  h1, h2, h3, caption { break-after: avoid; }
  figure, tr, .table, .summary, .warning { break-inside: avoid; }
  thead { display: table-header-group; }
  .scroll { overflow: visible; }
  table { font-size: 8.5pt; }
  th, td { padding: .2rem .4rem; }
  th.right { min-width: 0; }
  thead th { overflow-wrap: anywhere; }
  td.right:not(.date) { white-space: normal; }
  .picture { border: 0; padding: 0; }
  .picture > svg { min-width: 0 !important; max-height: 240mm; }
  .readout { display: none; }
  caption { min-width: 0; }
  p, ul, caption, figcaption { max-width: none; orphans: 3; widows: 3; }
}
)css";

}  // namespace

std::string_view PageStyle() { return kStyle; }

}  // namespace mle::report
