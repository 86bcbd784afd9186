/* Recorded signals, as CSV; cells of its lines. */

/* Communication points that a recording holds at most: five minutes at 1 ms. */
const MOST_ROWS = 300_000;

/* A text as a cell, quoted if necessary: names of array elements contain commas, `a[1,2]`. */
export const cell = (text) => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/* The cells of a line, without quotes and surrounding blanks. */
export function cells(line) {
  const found = [""];
  let quoted = false;
  for (const [letters] of line.matchAll(/""|[^]/g)) {
    if (letters === '""' && quoted) found[found.length - 1] += '"';
    else if (letters === '"') quoted = !quoted;
    else if (letters === "," && !quoted) found.push("");
    else if (letters !== '""') found[found.length - 1] += letters;
  }
  return found.map((cell) => cell.trim());
}

export class Recorder {
  constructor() {
    Object.assign(this, { on: false, names: [] });
    this.restart([]);
  }

  restart(names) {
    Object.assign(this, { names, chunks: [], count: 0 });
  }

  toggle() {
    this.on = !this.on;
    if (this.on) this.restart(this.names);
    return this.on;
  }

  add(rows, stride) {
    if (!this.on || rows.length === 0 || this.count >= MOST_ROWS) return;
    this.chunks.push(rows);
    this.count += rows.length / stride;
  }

  /* Forgets what is after the time. */
  cut(time) {
    const stride = 1 + this.names.length;
    this.chunks = this.chunks.map((rows) => {
      let end = rows.length;
      while (end > 0 && rows[end - stride] > time + 1e-9) end -= stride;
      return rows.slice(0, end);
    });
    this.count = this.chunks.reduce((sum, rows) => sum + rows.length / stride, 0);
  }

  /* How long the recording is, s. */
  get seconds() {
    const last = this.chunks.at(-1);
    return last?.length ? last[last.length - 1 - this.names.length] - this.chunks[0][0] : 0;
  }

  /* The recording as CSV; `unitOf(name)` gives units to write behind the names. */
  csv(unitOf = () => "") {
    const stride = 1 + this.names.length;
    const named = (name) => (unitOf(name) ? `${name} [${unitOf(name)}]` : name);
    const lines = [["time", ...this.names.map((name) => cell(named(name)))].join(",")];
    for (const rows of this.chunks) {
      for (let at = 0; at < rows.length; at += stride) lines.push(rows.subarray(at, at + stride).join(","));
    }
    return `${lines.join("\n")}\n`;
  }
}
