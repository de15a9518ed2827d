// Draws the page's figures as charts: zoom, pan, values under the cursor,
// series on and off. Each <figure> brings its data as JSON beside a static
// picture, which stays for printing and for pages read without scripts.
(function () {
'use strict';

const superscripts = '⁰¹²³⁴⁵⁶⁷⁸⁹';

function number(value) {
  if (!Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (value === 0 || (size >= 1e-3 && size < 1e6)) {
    return String(parseFloat(value.toPrecision(4))).replace('-', '−');
  }
  const [mantissa, exponent] = value.toExponential(3).split('e');
  const digits = exponent.replace('+', '').replace('-', '⁻').replace(
      /\d/g, d => superscripts[d]);
  const factor = String(parseFloat(mantissa)).replace('-', '−');
  if (factor === '1') return '10' + digits;
  return factor + '×10' + digits;
}

function element(name, css, text) {
  const node = document.createElement(name);
  if (css) node.className = css;
  if (text) node.textContent = text;
  return node;
}

const shapes = {
  circle(c, x, y, r) { c.arc(x, y, r, 0, 2 * Math.PI); },
  disc(c, x, y, r) { c.arc(x, y, r, 0, 2 * Math.PI); },
  square(c, x, y, r) { c.rect(x - r, y - r, 2 * r, 2 * r); },
  diamond(c, x, y, r) {
    c.moveTo(x, y - r); c.lineTo(x + r, y); c.lineTo(x, y + r);
    c.lineTo(x - r, y); c.closePath();
  },
  triangle(c, x, y, r) {
    c.moveTo(x, y - r); c.lineTo(x + r, y + r); c.lineTo(x - r, y + r);
    c.closePath();
  },
  cross(c, x, y, r) {
    c.moveTo(x - r, y - r); c.lineTo(x + r, y + r);
    c.moveTo(x + r, y - r); c.lineTo(x - r, y + r);
  },
  plus(c, x, y, r) {
    c.moveTo(x - r, y); c.lineTo(x + r, y); c.moveTo(x, y - r);
    c.lineTo(x, y + r);
  },
};

// The page's style sheet has a colour for each role, one in light and one in
// dark mode.
function look(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(
      '--' + name).trim();
}
const colourOf = item => look('role-' + item.colour);

function drawShape(context, name, x, y, size, colour) {
  context.save();
  context.setLineDash([]);
  context.beginPath();
  shapes[name](context, x, y, size / 2);
  context.strokeStyle = context.fillStyle = colour;
  context.lineWidth = 1.8;
  if (name === 'disc') context.fill();
  context.stroke();
  context.restore();
}

// A sample of a series' look, for the legend.
function swatch(item) {
  const canvas = element('canvas', 'swatch');
  const scale = window.devicePixelRatio || 1;
  canvas.width = 30 * scale;
  canvas.height = 14 * scale;
  const context = canvas.getContext('2d');
  context.scale(scale, scale);
  context.strokeStyle = context.fillStyle = colourOf(item);
  context.lineWidth = Math.max(item.width, 1.5);
  if (item.shaded) {
    context.globalAlpha = 0.25;
    context.fillRect(1, 1, 28, 12);
  } else if (item.line) {
    context.setLineDash(item.dash);
    context.beginPath();
    context.moveTo(1, 7);
    context.lineTo(29, 7);
    context.stroke();
  }
  if (item.marker) drawShape(context, item.marker, 15, 7, 8, colourOf(item));
  canvas.setAttribute('aria-hidden', 'true');
  return canvas;
}

// All series of a panel, its markers among them, over one ascending x. null
// where a series has no point, NaN where its line is broken.
function rows(panel, banded) {
  const places = new Map();
  const all = panel.series;
  const shown = x => x !== null && !(panel.x.log && x <= 0);
  all.forEach(s => s.x.forEach(x => { if (shown(x)) places.set(x, 0); }));
  const xs = Array.from(places.keys()).sort((a, b) => a - b);
  xs.forEach((x, i) => places.set(x, i));
  const table = xs.map(x => [x].concat(Array(all.length).fill(null)));
  const usable = y => y !== null && !(panel.y.log && y <= 0) ? y : NaN;
  all.forEach((s, column) => s.x.forEach((x, i) => {
    if (!shown(x)) return;
    const y = usable(s.y[i]);
    table[places.get(x)][column + 1] = !banded ? y :
        s.lower ? [usable(s.lower[i]), y, usable(s.upper[i])] : [y, y, y];
  }));
  return table;
}

// Where x is, in pixels; toDomXCoord knows no logarithmic axis.
function place(chart, area, x) {
  return area.x + area.w * chart.toPercentXCoord(x);
}

// Stretches shaded and lines across the whole panel.
function drawLines(panel, hidden) {
  return function (context, area, chart) {
    panel.spans.forEach(span => {
      if (hidden.has(span.label)) return;
      const end = x => Math.min(Math.max(place(chart, area, x), area.x),
                                area.x + area.w);
      const from = end(span.from), to = end(span.to);
      context.save();
      context.globalAlpha = 0.16;
      context.fillStyle = colourOf(span);
      context.fillRect(from, area.y, to - from, area.h);
      context.globalAlpha = 0.5;
      context.strokeStyle = colourOf(span);
      context.strokeRect(from, area.y - 1, to - from, area.h + 2);
      context.restore();
    });
    panel.lines.forEach(line => {
      if (hidden.has(line.label)) return;
      context.save();
      context.beginPath();
      context.rect(area.x, area.y, area.w, area.h);
      context.clip();
      context.strokeStyle = colourOf(line);
      context.lineWidth = line.width;
      context.setLineDash(line.dash);
      context.beginPath();
      if (line.vertical) {
        const x = place(chart, area, line.value);
        context.moveTo(x, area.y);
        context.lineTo(x, area.y + area.h);
      } else {
        const y = chart.toDomYCoord(line.value);
        context.moveTo(area.x, y);
        context.lineTo(area.x + area.w, y);
      }
      context.stroke();
      context.restore();
    });
  };
}

function options(panel, hidden, readout) {
  const series = {};
  panel.series.forEach((s, i) => {
    const colour = colourOf(s);
    series[i] = {
      color: colour,
      strokeWidth: s.line ? s.width : 0,
      strokePattern: s.dash.length ? s.dash : null,
      stepPlot: s.steps,
      drawPoints: Boolean(s.marker),
      pointSize: s.size / 2,
      // Points between gaps are drawn, too, where there are no markers.
      drawPointCallback: (chart, name, context, x, y) =>
          drawShape(context, s.marker || 'disc', x, y, s.marker ? s.size : 1.5,
                    colour),
      drawHighlightPointCallback: (chart, name, context, x, y) =>
          drawShape(context, s.marker || 'disc', x, y, s.marker ? s.size : 6,
                    colour),
    };
  });
  const banded = panel.series.some(s => s.lower);
  const axis = {
    axisLabelFormatter: number, pixelsPerLabel: 46, drawGrid: true,
  };
  const ticker = ({log, names}) => names.length ? {ticker: namedTicks(names)} :
      log ? {ticker: logTicks} : {};
  return {
    labels: ['x'].concat(panel.series.map((s, i) => String(i))),
    series,
    customBars: banded,
    fillAlpha: 0.16,
    connectSeparatedPoints: true,
    xlabel: panel.x.label.replace(/[&<>]/g, c => `&#${c.charCodeAt(0)};`),
    ylabel: panel.y.label.replace(/[&<>]/g, c => `&#${c.charCodeAt(0)};`),
    logscale: panel.y.log,
    axes: {
      x: Object.assign({logscale: panel.x.log}, axis, ticker(panel.x)),
      y: Object.assign({axisLabelWidth: 62}, axis, {pixelsPerLabel: 34},
                       ticker(panel.y)),
    },
    legend: 'never',
    gridLineColor: look('chart-grid'),
    axisLineColor: look('chart-axis'),
    highlightCircleSize: 3,
    underlayCallback: drawLines(panel, hidden),
    highlightCallback: (event, x, points) => {
      const values = points.filter(p => Number.isFinite(p.yval)).map(p => {
        const s = panel.series[Number(p.name)];
        return s.label ? s.label + ' ' + number(p.yval) : number(p.yval);
      });
      readout.textContent = [panel.x.name + ' ' + number(x)].concat(
          values).join(' · ');
    },
    unhighlightCallback: () => { readout.textContent = ''; },
  };
}

// One at each place that has a name.
function namedTicks(names) {
  return (low, high) => names.map((label, v) => ({v, label})).filter(
      ({v}) => v >= low && v <= high);
}

// Ticks of a logarithmic axis: powers of ten, where there is room 2 and 5 as
// well, and lines without a label at the other whole multiples.
function logTicks(low, high, pixels) {
  const decades = Math.log10(high / low);
  const each = Math.max(1, Math.ceil(decades * 46 / pixels));
  const labelled = decades * 120 < pixels ? [1, 2, 5] : [1];
  const ticks = [];
  const first = Math.floor(Math.log10(low)), last = Math.ceil(Math.log10(high));
  for (let exponent = first; exponent <= last; ++exponent) {
    for (let digit = 1; digit < 10; ++digit) {
      const v = digit * 10 ** exponent;
      if (v < low || v > high) continue;
      const named = exponent % each === 0 && labelled.includes(digit);
      ticks.push(named ? {v, label: number(v)} : {v});
    }
  }
  return ticks;
}

// What holds all `values` that can be shown, and a little room, `pad` of it.
function extent(values, log, pad) {
  let low = Infinity, high = -Infinity;
  values.forEach(v => {
    if (v === null || !Number.isFinite(v) || (log && v <= 0)) return;
    low = Math.min(low, v);
    high = Math.max(high, v);
  });
  if (!(low <= high)) return null;
  if (log) {
    const factor = Math.max((high / low) ** pad, 1.1);
    return [low / factor, high * factor];
  }
  const room = high > low ? pad * (high - low) : Math.abs(high) || 1;
  return [low - room, high + room];
}

// What the data, the lines across and the stretches need.
function ranges(panel) {
  const xs = [], ys = [];
  panel.spans.forEach(s => xs.push(s.from, s.to));
  panel.series.forEach(s => {
    s.x.forEach(v => xs.push(v));
    [s.y, s.lower || [], s.upper || []].forEach(
        part => part.forEach(v => ys.push(v)));
  });
  panel.lines.forEach(l => (l.vertical ? xs : ys).push(l.value));
  const named = axis => axis.names.length ? [-0.5, axis.names.length - 0.5]
                                          : axis.range;
  return {
    dateWindow: named(panel.x) || extent(xs, panel.x.log, 0.01),
    valueRange: named(panel.y) || extent(ys, panel.y.log, 0.06),
  };
}

// Shows `part` of the present range about its middle, moved by `shift` ranges.
function view(chart, axis, part, shift, log) {
  const range = axis === 'x' ? chart.xAxisRange() : chart.yAxisRange();
  const to = log ? Math.log : v => v, from = log ? Math.exp : v => v;
  const low = to(range[0]), high = to(range[1]), half = (high - low) / 2;
  const middle = (low + high) / 2 + shift * 2 * half;
  const window = [from(middle - part * half), from(middle + part * half)];
  chart.updateOptions(axis === 'x' ? {dateWindow: window}
                                   : {valueRange: window});
}

function addPanel(grid, panel, hidden, alt) {
  const box = element('div', 'panel');
  const head = element('div', 'panel-head');
  head.append(element('span', 'panel-title', panel.title));
  const readout = element('output', 'readout');
  const canvas = element('div', 'chart');
  canvas.tabIndex = 0;
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', (panel.title ? panel.title + '. ' : '') +
      alt + ' Plus and minus zoom, arrow keys move, 0 resets.');
  box.append(head, canvas, readout);
  grid.append(box);
  const whole = ranges(panel);
  const settings = Object.assign(options(panel, hidden, readout), whole);
  const chart =
      new Dygraph(canvas, rows(panel, settings.customBars), settings);
  const reset = () => chart.updateOptions(whole);
  const zoom = part => {
    view(chart, 'x', part, 0, panel.x.log);
    view(chart, 'y', part, 0, panel.y.log);
  };
  const tools = element('span', 'tools');
  [['−', 'Zoom out', () => zoom(1.6)], ['+', 'Zoom in', () => zoom(0.625)],
   ['⟲', 'Show all', reset]].forEach(([text, name, act]) => {
    const button = element('button', '', text);
    button.type = 'button';
    button.title = name;
    button.setAttribute('aria-label',
                        name + (panel.title ? ': ' + panel.title : ''));
    button.addEventListener('click', act);
    tools.append(button);
  });
  head.append(tools);
  const keys = {
    '+': () => zoom(0.625), '=': () => zoom(0.625), '-': () => zoom(1.6),
    '0': reset,
    'ArrowLeft': () => view(chart, 'x', 1, -0.15, panel.x.log),
    'ArrowRight': () => view(chart, 'x', 1, 0.15, panel.x.log),
    'ArrowUp': () => view(chart, 'y', 1, 0.15, panel.y.log),
    'ArrowDown': () => view(chart, 'y', 1, -0.15, panel.y.log),
  };
  canvas.addEventListener('keydown', event => {
    if (!keys[event.key] || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    keys[event.key]();
  });
  canvas.addEventListener('dblclick', reset);
  return {panel, chart};
}

// A button for each label; it switches all that bears it.
function addLegend(holder, data, hidden, charts) {
  const items = new Map();
  data.panels.forEach(p => p.series.concat(p.lines, p.spans).forEach(s => {
    if (s.label && !items.has(s.label)) items.set(s.label, s);
  }));
  items.forEach((item, label) => {
    const button = element('button', 'legend-item');
    button.type = 'button';
    button.setAttribute('aria-pressed', 'true');
    button.append(swatch(item), element('span', '', label));
    button.addEventListener('click', () => {
      const off = !hidden.has(label);
      if (off) hidden.add(label); else hidden.delete(label);
      button.setAttribute('aria-pressed', String(!off));
      charts.forEach(({panel, chart}) => {
        const visibility = {};
        panel.series.forEach((s, i) => {
          if (s.label === label) visibility[i] = !off;
        });
        chart.setVisibility(visibility);
      });
    });
    holder.append(button);
  });
}

function draw(figure) {
  const source = figure.querySelector('script.chart-data');
  const data = JSON.parse(source.textContent);
  const alt = figure.querySelector('figcaption').textContent;
  const charts = [], hidden = new Set();
  const holder = element('div', 'charts');
  const legend = element('div', 'legend');
  const grid = element('div', 'grid');
  grid.style.setProperty('--columns', String(data.columns));
  holder.append(legend, grid);
  figure.insertBefore(holder, figure.firstChild);
  figure.classList.add('drawn');
  data.panels.forEach(p => charts.push(addPanel(grid, p, hidden, alt)));
  if (data.legend) addLegend(legend, data, hidden, charts);
  return charts;
}

// One figure after the other, so that the first can be seen at once. For tests
// and for those who look under the bonnet: window.mleCharts has the charts,
// window.mleChartsDrawn is fulfilled when all are drawn.
let drawing = 0;

async function start() {
  const mine = ++drawing;
  window.mleCharts = [];
  for (const figure of document.querySelectorAll('figure.has-chart')) {
    window.mleCharts.push(...draw(figure).map(({chart}) => chart));
    await new Promise(next => setTimeout(next));
    if (mine !== drawing) return;
  }
}

function begin() {
  window.mleChartsDrawn = start();
}

// The same in the colours of the other mode.
function startAgain() {
  window.mleCharts.forEach(chart => chart.destroy());
  document.querySelectorAll('figure .charts').forEach(old => old.remove());
  begin();
}
matchMedia('(prefers-color-scheme: dark)').addEventListener(
    'change', startAgain);

if (document.readyState === 'loading') {
  document.addEventListener('DOMContentLoaded', begin);
} else {
  begin();
}
})();
