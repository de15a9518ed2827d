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
