"use strict";
/* The data of the page, and how a value is looked up in it. */
const data = JSON.parse(document.getElementById("data").textContent);
const element = (id) => document.getElementById(id);
const MODES = ["adaptive", "modular", "pd"];
const MODE_NAMES = { adaptive: "adaptive", modular: "modular", pd: "PD" };
const MODE_COLORS = { adaptive: "#0072b2", modular: "#e69f00", pd: "#cc3355" };
const ACTUATORS = ["slew", "lift", "tilt"];
const ACTUATOR_COLORS = ["#7b61bf", "#00966e", "#d55e00"];
/* Cells of a study as rows of three controllers. */
const inRows = (cells) => Array.from({ length: cells.length / MODES.length }, (_, k) => {
  const own = cells.slice(k * MODES.length, (k + 1) * MODES.length);
  const { trajectory, case: name, inertia_scale: scale, paper_adaptive_rmse_m: paper } = own[0];
  return { trajectory, case: name, scale, paper, cells: own.map((c) => ({ mode: c.mode, rmse: c.rmse_m ?? null, max: c.max_m ?? null })) };
});
data.table = inRows(data.table);
for (const study of data.errors) study.rows = inRows(study.cells);
/* Another machine than the paper's has its name in the title, and none of the paper's numbers next to its own. */
const OWN = data.conditions.own_machine;
const TRAJECTORIES = [...new Set(data.table.map((row) => row.trajectory))];

/* Base64 of little-endian 32-bit floats, as a typed array. */
function decode(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Float32Array.from({ length: bytes.length / 4 }, (_, k) => view.getFloat32(4 * k, true));
}

/* Of `count` samples some were kept: their values, then as bytes how far each is from the one before. Straight lines lie between them. */
function filled(text, count) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const n = Math.ceil(bytes.length / 5);
  const view = new DataView(bytes.buffer);
  const values = new Float32Array(count).fill(view.getFloat32(0, true));
  for (let k = 1, at = 0; k < n; k += 1) {
    const [from, to, gap] = [view.getFloat32(4 * k - 4, true), view.getFloat32(4 * k, true), bytes[4 * n + k - 1]];
    for (let j = 1; j <= gap; j += 1) values[at + j] = from + (j / gap) * (to - from);
    at += gap;
  }
  return values;
}

/* A signal that never changes is stored as one value. */
const whole = (kept, count) => (kept.length === 1 ? new Float32Array(count).fill(kept[0]) : kept);

const decoded = new Map();
/* Times and values of a signal of a run, the values times `factor`; nothing where the system has no such signal. */
function series(run, name, factor = 1) {
  const signal = run?.signals[name];
  if (!signal) return null;
  if (!decoded.has(signal)) {
    const count = Math.floor(run.simulated / signal.every + 1e-6) + 1;
    const t = Float64Array.from({ length: count }, (_, k) => run.start + k * signal.every);
    decoded.set(signal, { t, y: filled(signal.sparse, count), every: signal.every });
  }
  const { t, y, every } = decoded.get(signal);
  return { t, y: factor === 1 ? y : y.map((v) => v * factor), every };
}

/* Value of a signal at time t, interpolated. */
function valueAt(run, name, t) {
  const s = series(run, name);
  if (!s) return NaN;
  const at = Math.min(Math.max((t - run.start) / s.every, 0), s.y.length - 1);
  const k = Math.min(Math.floor(at), s.y.length - 2);
  return s.y[k] + (at - k) * (s.y[k + 1] - s.y[k]);
}

const findRun = (trajectory, mode, scale = 1) =>
  data.runs.find((r) => r.trajectory === trajectory && r.mode === mode && r.scale === scale);
const runName = (run) =>
  `${run.trajectory}, ${MODE_NAMES[run.mode]}` + (run.scale === 1 ? "" : `, inertia ${percent(run.scale)}`);
const percent = (scale) => `${scale > 1 ? "+" : scale < 1 ? "−" : ""}${Math.abs(Math.round(100 * (scale - 1)))} %`;
const mm = (m, digits = 4) => (m === null || m === undefined ? "failed" : (1000 * m).toFixed(digits));

const capital = (text) => text[0].toUpperCase() + text.slice(1);

/* Markup of the page. What is put into it is escaped, except markup and lists of it. */
class Markup {
  constructor(text) {
    this.text = text;
  }
}
const html = (parts, ...values) => new Markup(String.raw({ raw: parts }, ...values.map(inserted)));
const separated = (separator, items) => items.flatMap((item, k) => (k ? [separator, item] : [item]));
function inserted(value) {
  if (value instanceof Markup) return value.text;
  if (Array.isArray(value)) return value.map(inserted).join("");
  return String(value).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
}

/* Makes `markup` the content of the element `id`. */
function show(id, ...markup) {
  element(id).innerHTML = inserted(markup);
}

/* A new block with `markup` at the end of the element `id`. */
function added(id, markup) {
  const block = document.createElement("div");
  block.innerHTML = inserted(markup);
  element(id).append(block);
  return block;
}

/* Fill a <select> with the items; `changed` is told the chosen one, now and after each change. */
function choose(id, items, name, changed, preferred = () => false) {
  const select = element(id);
  items.forEach((item, k) => select.add(new Option(name(item), k)));
  select.value = Math.max(items.findIndex(preferred), 0);
  const tell = () => changed(items[select.value]);
  select.addEventListener("change", tell);
  tell();
}

const chooseRun = (id, changed, preferred) => choose(id, data.runs, runName, changed, preferred);
