// Runs inside a page under test and leaves what it finds in <pre id="check">.
(async function () {
'use strict';
const found = {};
const pause = () => new Promise(done => setTimeout(done, 30));

function painted(chart) {
  return chart.canvas_ && Array.from(
      chart.graphDiv.querySelectorAll('canvas')).some(canvas => {
    const pixels = canvas.getContext('2d').getImageData(
        0, 0, canvas.width, canvas.height).data;
    let count = 0;
    for (let i = 3; i < pixels.length; i += 4) count += pixels[i] > 100;
    return count > 50;
  });
}

function luminance([r, g, b]) {
  const part = v => v <= 10.3 ? v / 3294.6 : ((v / 255 + 0.055) / 1.055) ** 2.4;
  return 0.2126 * part(r) + 0.7152 * part(g) + 0.0722 * part(b);
}
const rgba = text => (text.match(/[\d.]+/g) || []).map(Number);

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
  document.querySelectorAll('body *').forEach(node => {
    if (node.closest('svg, script, #check') || !node.offsetParent) return;
    const own = Array.from(node.childNodes).some(
        child => child.nodeType === 3 && child.textContent.trim());
    if (!own) return;
    const style = getComputedStyle(node);
    const a = luminance(rgba(style.color)), b = luminance(ground(node));
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const large = parseFloat(style.fontSize) >= 24;
    if (contrast < (large ? 3 : 4.5)) {
      bad.push(node.className + ' "' + node.textContent.slice(0, 40) + '" ' +
               contrast.toFixed(2));
    }
  });
  return bad;
}

// Labels of one axis that lie over each other, and text outside its panel.
function overlapping() {
  let count = 0;
  document.querySelectorAll('.chart').forEach(chart => {
    ['.dygraph-axis-label-x', '.dygraph-axis-label-y'].forEach(kind => {
      const boxes = Array.from(chart.querySelectorAll(kind)).filter(
          label => label.textContent).map(label => {
        const range = document.createRange();
        range.selectNodeContents(label);
        return range.getBoundingClientRect();
      });
      boxes.forEach((a, i) => boxes.slice(i + 1).forEach(b => {
        count += a.left < b.right - 1 && b.left < a.right - 1 &&
            a.top < b.bottom - 1 && b.top < a.bottom - 1;
      }));
    });
  });
  return count;
}

function mouse(target, type, x, y) {
  const box = target.getBoundingClientRect();
  target.dispatchEvent(new MouseEvent(type, {
    bubbles: true, cancelable: true, view: window, button: 0, detail: 1,
    clientX: box.left + x * box.width, clientY: box.top + y * box.height,
    screenX: box.left + x * box.width, screenY: box.top + y * box.height,
  }));
}

const length = range => range[1] - range[0];

async function checkFirst(chart) {
  const panel = chart.graphDiv.closest('.panel');
  const key = name => chart.graphDiv.dispatchEvent(
      new KeyboardEvent('keydown', {key: name, bubbles: true}));
  const whole = chart.xAxisRange();
  key('+');
  found.keyZooms = length(chart.xAxisRange()) < 0.9 * length(whole);
  const left = chart.xAxisRange()[0];
  key('ArrowRight');
  found.keyMoves = chart.xAxisRange()[0] > left;
  key('0');
  found.keyResets = Math.abs(length(chart.xAxisRange()) / length(whole) - 1) <
      1e-9;
  panel.querySelectorAll('.tools button')[1].click();
  found.buttonZooms = length(chart.xAxisRange()) < 0.9 * length(whole);
  panel.querySelectorAll('.tools button')[2].click();
  const surface = chart.graphDiv.querySelectorAll('canvas')[1];
  mouse(surface, 'mousedown', 0.3, 0.4);
  mouse(surface, 'mousemove', 0.45, 0.42);
  mouse(surface, 'mousemove', 0.7, 0.42);
  mouse(surface, 'mouseup', 0.7, 0.42);
  await pause();
  found.dragZooms = length(chart.xAxisRange()) < 0.9 * length(whole);
  key('0');
  mouse(surface, 'mousemove', 0.5, 0.5);
  found.readout = panel.querySelector('.readout').textContent;

  const button = panel.closest('.charts').querySelector('.legend-item');
  button.click();
  found.legendHides = button.getAttribute('aria-pressed') === 'false' &&
      chart.visibility().includes(false);
  button.click();
  found.legendShows = button.getAttribute('aria-pressed') === 'true' &&
      !chart.visibility().includes(false);
}

await pause();
await window.mleChartsDrawn;
const charts = window.mleCharts;
found.figures = document.querySelectorAll('figure.has-chart').length;
found.charts = charts.length;
found.painted = charts.filter(painted).length;
found.legend = Array.from(document.querySelectorAll('.legend-item')).map(
    item => item.textContent);
found.injected = document.querySelectorAll('[data-injected]').length;
found.requests = performance.getEntriesByType('resource').map(r => r.name);
found.width = window.innerWidth;
found.dark = matchMedia('(prefers-color-scheme: dark)').matches;
found.overflow = document.documentElement.scrollWidth - window.innerWidth;
found.faint = faint();
found.overlapping = overlapping();
if (charts.length) await checkFirst(charts[0]);
const out = document.createElement('pre');
out.id = 'check';
out.hidden = true;
out.textContent = JSON.stringify(found);
(window.frameElement ? window.parent.document : document).body.append(out);
})();
