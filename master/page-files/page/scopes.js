/*
 * Scopes: curves over time on a canvas, scrolling or of fixed length. Of all values in a short stretch of time a trace keeps the least and the
 * greatest: no peak is lost, and as much is drawn whatever the communication step.
 */

import { html } from "./page.js";

/* Stretches of time across a scope. */
const STRETCHES = 500;
/* Stretches that a trace keeps at most: beyond it the older half becomes half as fine, so that a run of hours needs no more memory. */
const MOST_STRETCHES = 30_000;

class Trace {
  constructor({ label, color, dashed = false }, stretch) {
    Object.assign(this, { label, color, dashed, stretch, indices: [], low: [], high: [], last: NaN });
  }

  push(t, y) {
    if (!Number.isFinite(y)) return;
    this.last = y;
    const index = Math.floor(t / this.stretch + 1e-6);
    const k = this.indices.length - 1;
    if (this.indices[k] === index) {
      this.low[k] = Math.min(this.low[k], y);
      this.high[k] = Math.max(this.high[k], y);
    } else {
      this.indices.push(index);
      this.low.push(y);
      this.high.push(y);
      if (k + 2 > MOST_STRETCHES) this.thin();
    }
  }

  /* Two stretches of the older half become one. */
  thin() {
    const half = MOST_STRETCHES / 4;
    const [low, high] = [this.low, this.high];
    for (let k = 0; k < half; k += 1) {
      this.indices[k] = this.indices[2 * k];
      [low[k], high[k]] = [Math.min(low[2 * k], low[2 * k + 1]), Math.max(high[2 * k], high[2 * k + 1])];
    }
    for (const list of [this.indices, low, high]) list.splice(half, half);
  }

  /* Forgets what is after the time. */
  cut(time) {
    const end = this.place(time + this.stretch);
    for (const name of ["indices", "low", "high"]) this[name].length = end;
  }

  /* Place of the first stretch that is not before the time's. */
  place(t) {
    const index = Math.floor(t / this.stretch + 1e-6);
    let [least, most] = [0, this.indices.length];
    while (least < most) {
      const middle = (least + most) >> 1;
      if (this.indices[middle] < index) least = middle + 1;
      else most = middle;
    }
    return least;
  }

  /* Places of what is shown between two times: from the first to before the second. */
  between(from, to) {
    return [Math.max(this.place(from) - 1, 0), Math.min(this.place(to) + 1, this.indices.length)];
  }

  at(t) {
    const k = this.place(t);
    return k < this.indices.length ? 0.5 * (this.low[k] + this.high[k]) : NaN;
  }
}

/* A round number near `span / count`. */
function roundStep(span, count) {
  const raw = span / count;
  const ten = 10 ** Math.floor(Math.log10(raw));
  return ten * [1, 2, 5, 10].find((m) => m * ten >= raw * 0.999);
}

/* The number with so many decimals. */
export const fixed = (value, digits) => value.toFixed(digits).replace(/^-(?=.*[1-9])/, "−").replace("-", "");

/* The number with as many digits as one can use. */
export function readable(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e6)) return value.toExponential(2).replaceAll("-", "−");
  return fixed(value, size >= 1000 ? 0 : size >= 100 ? 1 : size >= 1 ? 2 : 4);
}

const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export class Scope {
  /* `length` in s; `scrolls`: the newest `length` seconds are shown, else the first ones. */
  constructor(parent, { title, unit, length, scrolls }) {
    Object.assign(this, { title, unit, length, scrolls, traces: [], pointer: null, shown: 0 });
    this.element = html`<div class="scope"><h3 aria-level="2"></h3><canvas role="img"></canvas></div>`;
    [this.legend, this.canvas] = this.element.children;
    parent.append(this.element);
    this.canvas.addEventListener("pointermove", (event) => this.point(event.offsetX));
    this.canvas.addEventListener("pointerleave", () => this.point(null));
    // One that scrolls shows more or less of the run by the wheel, and again as usual by a double click.
    const zoom = (event, length) => {
      event.preventDefault();
      this.zoomed(Math.min(Math.max(length, 0.5), 600));
    };
    this.zoomed = (shown) => this.zoom(shown);
    if (scrolls) {
      this.canvas.addEventListener("wheel", (event) => zoom(event, this.length * 1.15 ** Math.sign(event.deltaY)), { passive: false });
      this.canvas.addEventListener("dblclick", (event) => zoom(event, length));
    }
    this.observer = new ResizeObserver(() => this.draw(this.end ?? 0));
    this.observer.observe(this.canvas);
    this.theme();
  }

  remove() {
    this.observer.disconnect();
    this.element.remove();
  }

  theme() {
    this.ink = { soft: style("--soft"), line: style("--line") };
    this.palette = [1, 2, 3, 4, 5, 6].map((k) => style(`--trace-${k}`));
    this.draw(this.end ?? 0);
  }

  add(label, color = this.traces.length, dashed = false) {
    const trace = new Trace({ label, color, dashed }, this.length / STRETCHES);
    this.traces.push(trace);
    this.labels();
    return trace;
  }

  /* Names of the traces, once; their values follow in `draw`. */
  labels() {
    this.legend.textContent = this.unit ? `${this.title}, ${this.unit}` : this.title;
    for (const trace of this.traces) {
      trace.text = html`<span class="${trace.dashed ? "dashed" : ""}">${trace.label}</span>`;
      this.legend.append(trace.text);
    }
    this.canvas.setAttribute("aria-label", `${this.legend.textContent} over time`);
  }

  /* After a jump back to `time`. */
  cut(time) {
    this.traces.forEach((trace) => trace.cut(time));
  }

  /* Shows this much, s. */
  zoom(length) {
    this.length = length;
    this.range = null;
    this.draw(this.end ?? 0);
  }

  point(x) {
    this.pointer = x;
    this.draw(this.end ?? 0);
  }

  /* Least and greatest value shown, a little beyond the curves; it shrinks slowly. */
  bounds(from) {
    let [low, high] = [Infinity, -Infinity];
    for (const trace of this.traces) {
      const [begin, end] = trace.between(from, from + this.length);
      for (let k = begin; k < end; k += 1) [low, high] = [Math.min(low, trace.low[k]), Math.max(high, trace.high[k])];
    }
    if (low > high) [low, high] = [0, 1];
    const margin = 0.06 * (high - low) || 0.1 * Math.abs(high) || 1;
    const now = [low - margin, high + margin];
    const before = this.range;
    const tight = !this.scrolls || !before || before[1] - before[0] > 3 * (now[1] - now[0]);
    this.range = tight ? now : [Math.min(now[0], before[0] + 0.02 * (now[0] - before[0])), Math.max(now[1], before[1] + 0.02 * (now[1] - before[1]))];
    return this.range;
  }

  draw(end) {
    this.end = end;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const ratio = Math.min(window.devicePixelRatio, 2);
    const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this.canvas.width !== w || this.canvas.height !== h) [this.canvas.width, this.canvas.height] = [w, h];
    // So the processor draws the curves itself: a renderer in software takes thirty times as long for them.
    const context = this.canvas.getContext("2d", { willReadFrequently: true });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const from = this.scrolls ? Math.max(end - this.length, 0) : 0;
    const [low, high] = this.bounds(from);
    const box = { left: 46, right: width - 6, top: 6, bottom: height - 16 };
    const x = (t) => box.left + ((t - from) / this.length) * (box.right - box.left);
    const y = (v) => box.bottom - ((v - low) / (high - low)) * (box.bottom - box.top);
    this.grid(context, box, [from, low, high], x, y);
    context.save();
    context.beginPath();
    context.rect(box.left, 0, box.right - box.left, height);
    context.clip();
    this.traces.forEach((trace) => this.curve(context, trace, trace.between(from, from + this.length), x, y));
    context.restore();
    this.values(context, box, from, x);
  }

  grid(context, box, [from, low, high], x, y) {
    context.font = "10px system-ui, sans-serif";
    context.strokeStyle = this.ink.line;
    context.fillStyle = this.ink.soft;
    context.lineWidth = 1;
    const count = Math.max((box.bottom - box.top) / 30, 2);
    let step = roundStep(high - low, count);
    // One number by itself would be no scale.
    if (Math.floor(high / step) <= Math.ceil(low / step)) step = roundStep(high - low, 2 * count);
    // Large and small numbers have their power of ten once, at the top.
    // What changes little compared with its size is shown from a number on.
    const isNarrow = step < 1e-4 * Math.max(Math.abs(low), Math.abs(high));
    const offset = isNarrow ? Math.floor(low / (10 * step)) * 10 * step : 0;
    const most = Math.max(Math.abs(low - offset), Math.abs(high - offset));
    const power = most >= 1e5 || step < 1e-4 ? Math.floor(Math.log10(most) + 1e-9) : 0;
    const digits = Math.min(Math.max(0, power - Math.floor(Math.log10(step) + 1e-9)), 12);
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.beginPath();
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) {
      context.moveTo(box.left, y(v));
      context.lineTo(box.right, y(v));
      const text = (Math.abs(v - offset) < 1e-6 * step ? 0 : (v - offset) / 10 ** power).toFixed(digits);
      context.fillText(text.replace("-", "−"), box.left - 4, y(v));
    }
    const every = roundStep(this.length, Math.max((box.right - box.left) / 70, 2));
    if (power || isNarrow) {
      context.textAlign = "left";
      const scale = `${isNarrow ? `${Number(offset.toPrecision(10))} + ` : ""}${power ? `×10^${power}` : ""}`;
      context.fillText(scale.replace("-", "−"), box.left + 3, box.top + 6);
    }
    context.textAlign = "center";
    context.textBaseline = "alphabetic";
    for (let t = Math.ceil(from / every) * every; t <= from + this.length; t += every) {
      context.moveTo(x(t), box.top);
      context.lineTo(x(t), box.bottom);
      context.fillText(`${Number(t.toPrecision(6))} s`, Math.min(x(t), box.right - 12), box.bottom + 12);
    }
    context.stroke();
  }

  curve(context, { indices, low, high, stretch, color, dashed }, [begin, end], x, y) {
    context.strokeStyle = this.palette[color % this.palette.length];
    context.lineWidth = 1.5;
    context.setLineDash(dashed ? [5, 3] : []);
    context.beginPath();
    for (let k = begin; k < end; k += 1) {
      const at = x((indices[k] + 0.5) * stretch);
      // The nearer end first, so that a curve that rises or falls shows no teeth.
      const falls = k > begin && low[k] + high[k] < low[k - 1] + high[k - 1];
      context.lineTo(at, y(falls ? high[k] : low[k]));
      if (high[k] > low[k]) context.lineTo(at, y(falls ? low[k] : high[k]));
    }
    context.stroke();
    context.setLineDash([]);
  }

  /* Values in the legend: the newest, or those under the pointer. */
  values(context, box, from, x) {
    const isUnder = this.pointer !== null && this.pointer >= box.left && this.pointer <= box.right;
    const pointed = isUnder || Number.isFinite(this.cursor);
    const t = isUnder ? from + ((this.pointer - box.left) / (box.right - box.left)) * this.length : this.cursor;
    if (pointed) {
      context.strokeStyle = this.ink.soft;
      context.beginPath();
      context.moveTo(x(t), box.top);
      context.lineTo(x(t), box.bottom);
      context.stroke();
      context.fillStyle = this.ink.soft;
      context.fillText(`${t.toFixed(2)} s`, Math.min(Math.max(x(t), box.left + 18), box.right - 18), box.top + 8);
    }
    const now = performance.now();
    // The values of another time go at once.
    if (!pointed && !this.pointed && this.scrolls && now - this.shown < 150) return;
    Object.assign(this, { shown: now, pointed });
    for (const trace of this.traces) {
      trace.text.style.setProperty("--color", this.palette[trace.color % this.palette.length]);
      trace.text.textContent = `${trace.label} ${readable(pointed ? trace.at(t) : trace.last)}`;
    }
  }
}
