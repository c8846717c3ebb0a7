"use strict";
// The viewer of a run. RUN is the data that the page carries (plot/html.rs); times are
// microseconds, places millimetres, rates steps per second.

const POINT = 5; // numbers of a point: time, x, y, z, rate
const AXES = ["x", "y", "z"];
const byId = (id) => document.getElementById(id);
const color = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

const state = { now: RUN.end, zoom: null, bySpeed: false, hover: null, playing: null, time: [0, RUN.end] };

// ---- the run -----------------------------------------------------------------------------

const curves = RUN.curves.map(([style, line, flags, data, power]) => ({
  style, line, power, arc: (flags & 1) !== 0, home: (flags & 2) !== 0, data, count: data.length / POINT,
  from: data[0], to: data[data.length - POINT],
}));
const topRate = curves.reduce((top, curve) => {
  for (let i = 4; i < curve.data.length; i += POINT) top = Math.max(top, curve.data[i]);
  return top;
}, 1);

// The machine's place at a time: each axis where the last curve that moves it has brought it.
function placeAt(time) {
  let last = null;
  for (const curve of curves) {
    if (curve.from > time) break;
    last = curve;
  }
  if (!last) return curves.length ? curves[0].data.slice(1, 4) : [0, 0, 0];
  return interpolate(last, Math.min(time, last.to)).slice(1, 4);
}

function interpolate(curve, time) {
  const d = curve.data;
  let i = 0;
  while (i + 2 < curve.count && d[(i + 1) * POINT] < time) i++;
  const a = i * POINT, b = Math.min(i + 1, curve.count - 1) * POINT;
  const part = d[b] > d[a] ? Math.min(1, Math.max(0, (time - d[a]) / (d[b] - d[a]))) : 1;
  return [0, 1, 2, 3, 4].map((k) => d[a + k] + (d[b + k] - d[a + k]) * part);
}

// The line that runs at a time: the last stretch that has begun. At the end it is the last one.
function lineAt(time) {
  let low = 0, high = RUN.running.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (RUN.running[middle][0] > time || (RUN.running[middle][0] === time && time === RUN.end)) high = middle;
    else low = middle + 1;
  }
  return low ? RUN.running[low - 1][2] : null;
}

// Steps per second of each axis between two points of a curve, with the sign of its direction.
function axisRates(curve, i) {
  const d = curve.data, a = i * POINT, b = a + POINT;
  const steps = AXES.map((_, k) => (d[b + 1 + k] - d[a + 1 + k]) * RUN.scale[k]);
  const whole = curve.arc ? Math.hypot(...steps) : Math.max(...steps.map(Math.abs));
  const at = (rate) => steps.map((s) => (whole > 0 ? (rate * s) / whole : 0));
  return [at(d[a + 4]), at(d[b + 4])];
}

// ---- canvases ----------------------------------------------------------------------------

function canvas(id) {
  const element = byId(id), context = element.getContext("2d");
  return {
    element, context,
    begin() {
      const box = element.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
      if (element.width !== Math.round(box.width * ratio) || element.height !== Math.round(box.height * ratio)) {
        element.width = Math.round(box.width * ratio);
        element.height = Math.round(box.height * ratio);
      }
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, box.width, box.height);
      context.font = "11px " + getComputedStyle(document.body).fontFamily;
      return [box.width, box.height];
    },
  };
}

const top_ = canvas("top"), side = canvas("side"), rate = canvas("rate"), rows = canvas("rows");
const PAD = { left: 52, right: 14, top: 8, bottom: 22 };
// Left edge of the charts over time: the rows have names. A phone has no room for wide ones.
const names = () => (window.innerWidth < 600 ? 96 : 120);

// Reference runs begin at an unknown place: they count only when there is nothing else.
const shown = curves.some((curve) => !curve.home) ? curves.filter((curve) => !curve.home) : curves;
function extent(k, least) {
  let low = Infinity, high = -Infinity;
  for (const curve of shown)
    for (let i = 1 + k; i < curve.data.length; i += POINT) {
      low = Math.min(low, curve.data[i]);
      high = Math.max(high, curve.data[i]);
    }
  if (k < 2) for (const shape of RUN.cell || [])
    for (const point of shape.points) {
      low = Math.min(low, point[k]);
      high = Math.max(high, point[k]);
    }
  if (low > high) low = high = 0;
  const room = Math.max((least - (high - low)) / 2, 0) + (high - low) * 0.06;
  return [low - room, high + room];
}
// A machine without Z, and a run that never moves it, has no view from the front.
const hasZ = RUN.scale[2] > 0 && curves.some((curve) => {
  for (let i = 3; i < curve.data.length; i += POINT) if (curve.data[i] !== curves[0].data[3]) return true;
  return false;
});
const range = [extent(0, 1), extent(1, 1), extent(2, 0.5)];

function ticks([low, high], most) {
  const rough = (high - low) / Math.max(most, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= rough) || rough;
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const list = [];
  for (let n = Math.ceil(low / step); n * step <= high; n++) list.push(n * step);
  return list.map((value) => [value, (value || 0).toFixed(digits)]);
}

// A plotting area with grid; gives the functions from values to pixels.
function frame(c, size, xRange, yRange, yTicks, left = PAD.left) {
  const [width, height] = size, g = c.context;
  const box = [left, PAD.top, width - PAD.right, height - PAD.bottom];
  const x = (v) => box[0] + ((v - xRange[0]) / (xRange[1] - xRange[0])) * (box[2] - box[0]);
  const y = (v) => box[3] - ((v - yRange[0]) / (yRange[1] - yRange[0])) * (box[3] - box[1]);
  g.lineWidth = 1;
  g.fillStyle = color("soft");
  const rule = (value, x1, y1, x2, y2) => {
    g.strokeStyle = Math.abs(value) < 1e-9 ? color("zero") : color("grid");
    g.beginPath(); g.moveTo(x1, y1); g.lineTo(x2, y2); g.stroke();
  };
  g.textAlign = "center"; g.textBaseline = "top";
  for (const [value, text] of ticks(xRange, (box[2] - box[0]) / 80)) {
    rule(value, x(value), box[1], x(value), box[3]);
    g.fillText(text, x(value), box[3] + 6);
  }
  g.textAlign = "right"; g.textBaseline = "middle";
  for (const [value, text] of yTicks === 0 ? [] : ticks(yRange, yTicks || (box[3] - box[1]) / 44)) {
    rule(value, box[0], y(value), box[2], y(value));
    g.fillText(text, box[0] - 7, y(value));
  }
  return { x, y, box };
}

// Perceptually even blue to yellow, for the speed.
const RAMP = [[68, 57, 131], [49, 104, 142], [33, 145, 140], [83, 197, 104], [246, 211, 45]];
function speedColor(value) {
  const at = Math.min(0.9999, Math.max(0, value / topRate)) * (RAMP.length - 1), i = Math.floor(at);
  const mix = RAMP[i].map((c, k) => Math.round(c + (RAMP[i + 1][k] - c) * (at - i)));
  return `rgb(${mix.join(",")})`;
}

// A laser's power as grey, on paper as on a dark page.
function powerColor(power) {
  const [faint, full] = matchMedia("(prefers-color-scheme: dark)").matches ? [70, 255] : [225, 15];
  const grey = Math.round(faint + (full - faint) * power);
  return `rgb(${grey},${grey},${grey})`;
}

// Draws the path up to the present time strongly and what is still to come faintly.
function drawPath(g, x, y, kx, ky) {
  const names = RUN.styles.map((style) => style[0]);
  for (let style = 0; style < names.length; style++) {
    g.lineJoin = g.lineCap = "round";
    g.setLineDash(names[style] === "rapid" ? [5, 4] : []);
    g.lineWidth = names[style] === "rapid" ? 1.1 : 2;
    for (const done of [false, true]) {
      g.globalAlpha = done ? 1 : 0.16;
      g.strokeStyle = color(names[style]);
      g.beginPath();
      for (const curve of curves) {
        if (curve.style !== style || (done ? curve.from > state.now : curve.to <= state.now)) continue;
        if (done && state.bySpeed) drawBySpeed(g, curve, x, y, kx, ky);
        else if (RUN.full && names[style] === "cut") {
          g.stroke();
          g.beginPath();
          g.strokeStyle = powerColor(curve.power);
          trace(g, curve, x, y, kx, ky, done ? state.now : Infinity);
          g.stroke();
          g.beginPath();
        } else trace(g, curve, x, y, kx, ky, done ? state.now : Infinity);
      }
      g.stroke();
    }
  }
  g.globalAlpha = 1;
  g.setLineDash([]);
}

function trace(g, curve, x, y, kx, ky, until) {
  const d = curve.data;
  g.moveTo(x(d[1 + kx]), y(d[1 + ky]));
  for (let i = 1; i < curve.count; i++) {
    if (d[i * POINT] > until) {
      const at = interpolate(curve, until);
      g.lineTo(x(at[1 + kx]), y(at[1 + ky]));
      return;
    }
    g.lineTo(x(d[i * POINT + 1 + kx]), y(d[i * POINT + 1 + ky]));
  }
}

function drawBySpeed(g, curve, x, y, kx, ky) {
  const d = curve.data;
  for (let i = 0; i + 1 < curve.count && d[i * POINT] <= state.now; i++) {
    const a = i * POINT, end = Math.min(d[a + POINT], state.now);
    const to = end < d[a + POINT] ? interpolate(curve, end) : d.slice(a + POINT, a + 2 * POINT);
    g.stroke();
    g.beginPath();
    g.strokeStyle = speedColor((d[a + 4] + to[4]) / 2);
    g.moveTo(x(d[a + 1 + kx]), y(d[a + 1 + ky]));
    g.lineTo(x(to[1 + kx]), y(to[1 + ky]));
    g.stroke();
    g.beginPath();
  }
}

// The cell from above: what is there at the present time.
const LOOKS = {
  stock: ["zero", 0.25], belt: ["zero", 0.15], place: ["on", 0], fixture: ["soft", 0.25], thing: ["in", 0.45], sensor: ["probe", 0],
  hole: ["text", 0.8], bead: ["on", 0], hit: ["fault", 0],
};
function drawCell(g, x, y) {
  for (const shape of RUN.cell || []) {
    if (shape.from > state.now || (shape.to < state.now && shape.to < RUN.end)) continue;
    const [name, fill] = LOOKS[shape.kind];
    g.beginPath();
    shape.points.forEach(([px, py], i) => (i ? g.lineTo(x(px), y(py)) : g.moveTo(x(px), y(py))));
    g.strokeStyle = g.fillStyle = color(name);
    g.lineWidth = shape.kind === "bead" || shape.kind === "hit" ? 3 : 1;
    g.globalAlpha = fill;
    if (fill) g.fill();
    g.globalAlpha = 1;
    g.stroke();
  }
}

// Strokes of Z alone are points from above: a ring, filled once it is done.
function drawHoles(g, x, y) {
  for (const curve of curves) {
    if (!isVertical(curve)) continue;
    const style = RUN.styles[curve.style][0];
    if (style === "rapid") continue;
    g.beginPath();
    g.arc(x(curve.data[1]), y(curve.data[2]), 4.5, 0, 2 * Math.PI);
    g.strokeStyle = g.fillStyle = color(style);
    g.lineWidth = 1.5;
    g.globalAlpha = curve.from <= state.now ? 0.22 : 0.06;
    g.fill();
    g.globalAlpha = curve.from <= state.now ? 1 : 0.3;
    g.stroke();
  }
  g.globalAlpha = 1;
}

function isVertical(curve) {
  const d = curve.data, e = d.length - POINT;
  return d[1] === d[e + 1] && d[2] === d[e + 2] && d[3] !== d[e + 3];
}

function dot(g, x, y, radius, fill) {
  g.beginPath();
  g.arc(x, y, radius, 0, 2 * Math.PI);
  g.fillStyle = fill; g.fill();
  g.strokeStyle = color("card"); g.lineWidth = 2; g.stroke();
}

let topMap = null;
function drawTop() {
  const size = top_.begin();
  const area = [size[0] - PAD.left - PAD.right, size[1] - PAD.top - PAD.bottom];
  if (!state.zoom) {
    const per = Math.max((range[0][1] - range[0][0]) / area[0], (range[1][1] - range[1][0]) / area[1]);
    state.zoom = { x: (range[0][0] + range[0][1]) / 2, y: (range[1][0] + range[1][1]) / 2, per, fitted: true };
  }
  const z = state.zoom, half = [(area[0] * z.per) / 2, (area[1] * z.per) / 2];
  const f = frame(top_, size, [z.x - half[0], z.x + half[0]], [z.y - half[1], z.y + half[1]]);
  topMap = f;
  const g = top_.context;
  g.save();
  g.beginPath(); g.rect(f.box[0], f.box[1], f.box[2] - f.box[0], f.box[3] - f.box[1]); g.clip();
  drawCell(g, f.x, f.y);
  drawPath(g, f.x, f.y, 0, 1);
  drawHoles(g, f.x, f.y);
  if (state.hover) {
    g.strokeStyle = color("on"); g.lineWidth = 4; g.beginPath();
    trace(g, state.hover, f.x, f.y, 0, 1, Infinity);
    g.stroke();
  }
  const at = placeAt(state.now);
  dot(g, f.x(at[0]), f.y(at[1]), 6, color("x"));
  g.restore();
  return [z.x - half[0], z.x + half[0]];
}

function drawSide(xRange) {
  const f = frame(side, side.begin(), xRange, range[2], 4);
  const g = side.context;
  g.save();
  g.beginPath(); g.rect(f.box[0], f.box[1], f.box[2] - f.box[0], f.box[3] - f.box[1]); g.clip();
  drawPath(g, f.x, f.y, 0, 2);
  const at = placeAt(state.now);
  dot(g, f.x(at[0]), f.y(at[2]), 5, color("x"));
  g.restore();
}

const timeRange = () => [state.time[0] / 1e6, state.time[1] / 1e6];
let timeMap = null;
// What lies before or behind the time that is shown is not drawn over the names.
function clipTime(g, f) {
  g.save();
  g.beginPath();
  g.rect(f.box[0], 0, f.box[2] - f.box[0] + 1, f.box[3] + 1);
  g.clip();
}

function drawRate() {
  const f = frame(rate, rate.begin(), timeRange(), [-topRate * 1.08, topRate * 1.08], 6, names());
  timeMap = f;
  const g = rate.context;
  clipTime(g, f);
  AXES.forEach((axis, k) => {
    if (!RUN.scale[k]) return;
    g.strokeStyle = color(axis);
    g.lineWidth = 1.3;
    g.beginPath();
    for (const curve of curves) {
      if (curve.to < state.time[0]) continue;
      if (curve.from > state.time[1]) break;
      let begun = false;
      for (let i = 0; i + 1 < curve.count; i++) {
        const [a, b] = axisRates(curve, i).map((rates) => rates[k]);
        if (!a && !b) continue;
        const ta = f.x(curve.data[i * POINT] / 1e6), tb = f.x(curve.data[(i + 1) * POINT] / 1e6);
        if (!begun) { g.moveTo(ta, f.y(0)); begun = true; }
        g.lineTo(ta, f.y(a));
        g.lineTo(tb, f.y(b));
      }
      if (begun) g.lineTo(f.x(curve.to / 1e6), f.y(0));
    }
    g.stroke();
    g.fillStyle = color(axis);
    g.textAlign = "left";
    g.fillText(axis.toUpperCase(), f.box[0] + 8 + 16 * k, f.box[1] + 8);
  });
  cursor(g, f);
  g.restore();
}

const ROW = 20, FIRST = 1 + (RUN.prints.length ? 1 : 0); // rows before the outputs
function drawRows() {
  const f = frame(rows, rows.begin(), timeRange(), [0, 1], 0, names());
  const g = rows.context;
  const place = (row) => f.box[1] + row * ROW;
  const name = (row, text) => {
    g.fillStyle = color("text");
    g.textAlign = "right"; g.textBaseline = "middle";
    g.fillText(text, f.box[0] - 8, place(row) + ROW / 2, f.box[0] - 10);
  };
  name(0, "line");
  if (RUN.prints.length) name(1, "print");
  RUN.rows.forEach(([text], i) => name(FIRST + i, text));
  clipTime(g, f);
  const bar = (row, from, to) =>
    g.fillRect(f.x(from / 1e6), place(row) + 3, Math.max(1, f.x(to / 1e6) - f.x(from / 1e6)), ROW - 6);
  const seen = ([from, to]) => to >= state.time[0] && from <= state.time[1];
  g.textAlign = "center"; g.textBaseline = "middle";
  for (const [from, to, line] of RUN.running.filter(seen)) {
    g.fillStyle = color(from <= state.now && state.now < to ? "on" : "zero");
    bar(0, from, Math.max(from, to - (state.time[1] - state.time[0]) / 2000));
    const left = Math.max(f.x(from / 1e6), f.box[0]), right = Math.min(f.x(to / 1e6), f.box[2]);
    if (right - left < 20) continue;
    g.fillStyle = color("text");
    g.fillText(line, (left + right) / 2, place(0) + ROW / 2);
  }
  g.textAlign = "left";
  let written = -Infinity;
  RUN.prints.forEach(([time, , text], i) => {
    const x = f.x(time / 1e6), next = i + 1 < RUN.prints.length ? f.x(RUN.prints[i + 1][0] / 1e6) : f.box[2];
    if (time < state.time[0] || time > state.time[1]) return;
    g.fillStyle = color("soft");
    g.fillRect(x, place(1) + 3, 1, ROW - 6);
    const width = g.measureText(text).width + 8;
    if (x < written || x + width > next) return;
    g.fillText(text, x + 4, place(1) + ROW / 2);
    written = x + width;
  });
  RUN.rows.forEach(([, output, spans], i) => {
    g.fillStyle = color(output ? "on" : "in");
    for (const [from, to] of spans.filter(seen)) bar(FIRST + i, from, to);
  });
  if (RUN.fault) {
    const x = f.x(RUN.end / 1e6);
    g.fillStyle = color("fault");
    g.fillRect(x - 1, f.box[1], 2, f.box[3] - f.box[1]);
    g.textAlign = "right"; g.textBaseline = "bottom";
    g.fillText(RUN.fault, x - 5, f.box[3] - 1);
  }
  cursor(g, f);
  g.restore();
}

function cursor(g, f) {
  g.strokeStyle = color("x"); g.lineWidth = 1;
  g.beginPath();
  g.moveTo(f.x(state.now / 1e6), f.box[1]);
  g.lineTo(f.x(state.now / 1e6), f.box[3]);
  g.stroke();
}

let marked = null;
function draw() {
  const across = drawTop();
  if (hasZ) drawSide(across);
  drawRate();
  drawRows();
  const at = placeAt(state.now);
  const places = AXES.map((axis, k) => (RUN.scale[k] ? `${axis.toUpperCase()} ${at[k].toFixed(3)}` : ""));
  byId("readout").textContent = `${(state.now / 1e6).toFixed(3)} s   ${places.filter(Boolean).join("  ")}`;
  byId("time").value = RUN.end ? Math.round((state.now / RUN.end) * 10000) : 10000;
  const line = state.hover ? state.hover.line : lineAt(state.now);
  if (line !== marked) {
    byId("source").querySelectorAll(".now").forEach((old) => old.classList.remove("now"));
    const row = byId("source").children[line - 1];
    if (row) { row.classList.add("now"); row.scrollIntoView({ block: "nearest" }); }
    marked = line;
  }
}
let asked = false;
function redraw() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => { asked = false; draw(); });
}

// ---- what the user does ------------------------------------------------------------------

function nearest(px, py) {
  const f = topMap;
  let best = null, least = 10;
  for (const curve of curves) {
    const d = curve.data;
    for (let i = 0; i + 1 < curve.count; i++) {
      const a = i * POINT, b = a + POINT;
      const x1 = f.x(d[a + 1]), y1 = f.y(d[a + 2]), x2 = f.x(d[b + 1]), y2 = f.y(d[b + 2]);
      const l2 = (x2 - x1) ** 2 + (y2 - y1) ** 2;
      const t = l2 ? Math.min(1, Math.max(0, ((px - x1) * (x2 - x1) + (py - y1) * (y2 - y1)) / l2)) : 0;
      const far = Math.hypot(px - x1 - t * (x2 - x1), py - y1 - t * (y2 - y1));
      // Work lies over travel: at the same place it is the one that is meant.
      const score = far - (RUN.styles[curve.style][0] === "rapid" ? 0 : 2);
      if (score < least) { least = score; best = curve; }
    }
  }
  return best;
}

function tip(event, text) {
  const box = byId("tip");
  box.hidden = !text;
  if (!text) return;
  box.textContent = text;
  box.style.left = Math.min(event.clientX + 14, window.innerWidth - box.offsetWidth - 8) + "px";
  box.style.top = Math.min(event.clientY + 16, window.innerHeight - box.offsetHeight - 8) + "px";
}

let drag = null;
top_.element.addEventListener("pointermove", (event) => {
  if (drag) {
    const z = state.zoom;
    z.x = drag.x - (event.offsetX - drag.px) * z.per;
    z.y = drag.y + (event.offsetY - drag.py) * z.per;
    z.fitted = false;
    return redraw();
  }
  const curve = nearest(event.offsetX, event.offsetY);
  if (curve !== state.hover) { state.hover = curve; redraw(); }
  const d = curve && curve.data, e = curve && d.length - POINT;
  tip(event, curve && `line ${curve.line}: ${(RUN.source[curve.line - 1] || "").trim()}\n` +
    `to X ${d[e + 1].toFixed(3)}  Y ${d[e + 2].toFixed(3)}  Z ${d[e + 3].toFixed(3)} mm, ` +
    `${((curve.to - curve.from) / 1e6).toFixed(3)} s from ${(curve.from / 1e6).toFixed(3)} s`);
});
top_.element.addEventListener("pointerleave", (event) => { state.hover = null; tip(event, ""); redraw(); });
top_.element.addEventListener("pointerdown", (event) => {
  drag = { x: state.zoom.x, y: state.zoom.y, px: event.offsetX, py: event.offsetY };
  top_.element.setPointerCapture(event.pointerId);
});
top_.element.addEventListener("pointerup", (event) => {
  const still = drag && Math.hypot(event.offsetX - drag.px, event.offsetY - drag.py) < 3;
  drag = null;
  if (still && state.hover) { state.now = state.hover.to; redraw(); }
});
top_.element.addEventListener("dblclick", () => { state.zoom = null; redraw(); });
top_.element.addEventListener("wheel", (event) => {
  event.preventDefault();
  const z = state.zoom, factor = 1.0015 ** event.deltaY, f = topMap;
  const dx = (event.offsetX - (f.box[0] + f.box[2]) / 2) * z.per;
  const dy = -(event.offsetY - (f.box[1] + f.box[3]) / 2) * z.per;
  z.x += dx * (1 - factor); z.y += dy * (1 - factor); z.per *= factor; z.fitted = false;
  redraw();
}, { passive: false });
byId("fit").onclick = () => { state.zoom = null; redraw(); };
byId("by-speed").onchange = (event) => {
  state.bySpeed = event.target.checked;
  byId("speed-scale").hidden = !state.bySpeed;
  redraw();
};
byId("time").oninput = (event) => { state.now = (event.target.value / 10000) * RUN.end; redraw(); };

// Shows the time from `from` on, `width` long, as far as the run goes.
function showTime(from, width) {
  width = Math.min(RUN.end, Math.max(1000, width));
  from = Math.min(RUN.end - width, Math.max(0, from));
  state.time = [from, from + width];
  redraw();
}
function zoomTime(at, factor) {
  const [from, to] = state.time;
  showTime(at - (at - from) * factor, (to - from) * factor);
}
const timeAt = (x) => {
  const part = (x - timeMap.box[0]) / (timeMap.box[2] - timeMap.box[0]);
  return state.time[0] + Math.min(1, Math.max(0, part)) * (state.time[1] - state.time[0]);
};
// One finger or the mouse sets the time, two fingers zoom it.
for (const c of [rate, rows]) {
  const fingers = new Map();
  const apart = () => {
    const [a, b] = [...fingers.values()];
    return [Math.max(20, Math.abs(a - b)), (a + b) / 2];
  };
  c.element.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, event.offsetX);
    c.element.setPointerCapture(event.pointerId);
    if (fingers.size === 1) { state.now = timeAt(event.offsetX); redraw(); }
  });
  c.element.addEventListener("pointermove", (event) => {
    const before = fingers.size === 2 ? apart() : null;
    if (!fingers.has(event.pointerId)) return;
    fingers.set(event.pointerId, event.offsetX);
    if (before) {
      const [width, middle] = apart();
      zoomTime(timeAt(middle), before[0] / width);
    } else { state.now = timeAt(event.offsetX); redraw(); }
  });
  for (const end of ["pointerup", "pointercancel"])
    c.element.addEventListener(end, (event) => fingers.delete(event.pointerId));
  c.element.addEventListener("wheel", (event) => {
    event.preventDefault();
    const [from, to] = state.time;
    if (event.shiftKey || event.deltaX) showTime(from + (event.deltaX || event.deltaY) * (to - from) / 1000, to - from);
    else zoomTime(timeAt(event.offsetX), 1.0015 ** event.deltaY);
  }, { passive: false });
  c.element.addEventListener("dblclick", () => showTime(0, RUN.end));
}
byId("closer").onclick = () => zoomTime(state.now, 0.5);
byId("farther").onclick = () => zoomTime(state.now, 2);

function play() {
  if (state.playing) { cancelAnimationFrame(state.playing); state.playing = null; }
  else {
    if (state.now >= RUN.end) state.now = 0;
    let before = performance.now();
    const step = (time) => {
      state.now = Math.min(RUN.end, state.now + (time - before) * 1000 * Number(byId("pace").value));
      before = time;
      draw();
      state.playing = state.now < RUN.end ? requestAnimationFrame(step) : null;
      byId("play").textContent = state.playing ? "\u23f8" : "\u25b6";
    };
    state.playing = requestAnimationFrame(step);
  }
  byId("play").textContent = state.playing ? "\u23f8" : "\u25b6";
}
byId("play").onclick = play;
window.addEventListener("keydown", (event) => {
  if (event.target !== document.body) return;
  const step = (state.time[1] - state.time[0]) / 100;
  const seek = (to) => { state.now = Math.min(RUN.end, Math.max(0, to)); redraw(); };
  if (event.code === "Space") { event.preventDefault(); play(); }
  else if (event.key === "ArrowLeft") seek(state.now - step);
  else if (event.key === "ArrowRight") seek(state.now + step);
  else if (event.key === "+") zoomTime(state.now, 0.5);
  else if (event.key === "-") zoomTime(state.now, 2);
});
window.addEventListener("resize", () => { if (state.zoom && state.zoom.fitted) state.zoom = null; redraw(); });
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);

// ---- the page ----------------------------------------------------------------------------

byId("title").textContent = RUN.title;
byId("subtitle").textContent = RUN.subtitle;
const used = new Set(curves.map((curve) => curve.style));
RUN.styles.forEach(([name, text], i) => {
  // A laser's work is told by its power.
  if (!used.has(i) || (RUN.full && name === "cut")) return;
  const item = document.createElement("span");
  item.className = name;
  item.textContent = text;
  item.style.setProperty("--swatch", `var(--${name})`);
  byId("legend").append(item);
});
if (RUN.full) {
  const item = document.createElement("span");
  item.className = "power";
  item.textContent = `laser: S0 to S${RUN.full}`;
  item.style.setProperty("--ramp", `linear-gradient(to right, ${powerColor(0)}, ${powerColor(1)})`);
  byId("legend").append(item);
}
byId("speed-scale").textContent = `0 to ${Math.round(topRate)} steps/s`;
byId("speed-scale").style.setProperty("--ramp",
  `linear-gradient(to right, ${RAMP.map((c) => `rgb(${c.join(",")})`).join(", ")})`);
const firstTime = new Map();
for (const [, to, line] of RUN.running) if (!firstTime.has(line)) firstTime.set(line, to);
RUN.source.forEach((text, i) => {
  const row = document.createElement("div");
  row.dataset.n = i + 1;
  row.textContent = text;
  const time = firstTime.get(i + 1);
  if (time !== undefined) {
    row.className = "moves";
    // Just before the next one begins.
    row.onclick = () => { state.now = Math.max(0, time - 1); redraw(); };
  }
  byId("source").append(row);
});
byId("rows-card").style.height = `${(RUN.rows.length + FIRST + (RUN.fault ? 1 : 0)) * ROW + 60}px`;
document.body.classList.toggle("flat", !hasZ);
draw();
