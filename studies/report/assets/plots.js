/* What all tables and plots have in common. */
const CONFIG = { responsive: true, ...(innerWidth < 600 && { displayModeBar: false }), displaylogo: false, toImageButtonOptions: { format: "svg" } };
const FONT = { family: "system-ui, Segoe UI, Helvetica Neue, Arial, sans-serif", size: 12 };
const isDark = matchMedia("(prefers-color-scheme: dark)");
/* Colours that are others in the dark, as they are now. */
const tone = {
  of: (day, night) => (isDark.matches ? night : day),
  get ink() { return this.of("#1d2733", "#e6edf4"); },
  get line() { return this.of("#3c3c3c", "#c3ccd6"); },
  get grid() { return this.of("#e6ebf0", "#2c3947"); },
  get axis() { return this.of("#c9d2db", "#51606f"); },
  get card() { return this.of("#ffffff", "#16202b"); },
};

function layout(more) {
  const axis = { gridcolor: tone.grid, zerolinecolor: tone.axis, linecolor: tone.axis, automargin: true };
  const { xaxis, yaxis, xaxis2, yaxis2, ...rest } = more;
  return {
    font: { ...FONT, color: tone.ink }, hoverlabel: { bgcolor: tone.card }, ...(xaxis2 && { xaxis2: { ...axis, ...xaxis2 }, yaxis2: { ...axis, ...yaxis2 } }), margin: { l: 58, r: 14, t: 58, b: 42 }, hovermode: "x unified", modebar: { bgcolor: tone.card, color: tone.axis, activecolor: tone.ink }, paper_bgcolor: tone.card, plot_bgcolor: tone.card,
    legend: { orientation: "h", x: 1, xanchor: "right", y: 1, yanchor: "bottom", font: { size: 11 } },
    xaxis: { ...axis, ...xaxis }, yaxis: { ...axis, ...yaxis }, ...rest,
  };
}

const titled = (text) => ({ title: { text, x: 0, xref: "paper", xanchor: "left", y: 0.985, yref: "container", yanchor: "top", font: { size: 13 } } });

/* What is to be drawn, by element; each is drawn once it comes near the window, and again where it has changed or the colours have. */
const plots = new Map();
const plot = (target) => {
  const its = plots.get(target);
  if (its.drawn) return;
  its.drawn = true;
  const [traces, lay] = its.make();
  Plotly.react(target, traces, lay, CONFIG);
};
const near = new IntersectionObserver((entries) => entries.forEach(({ isIntersecting, target }) => isIntersecting && plot(target)), { rootMargin: "300px" });
const plotAll = () => [...plots.keys()].filter((target) => !target.hidden).forEach(plot);
window.addEventListener("beforeprint", plotAll);
isDark.addEventListener("change", () => plots.forEach(({ make }, target) => wanted(target, make)));

function wanted(target, make) {
  plots.set(target, { make });
  near.unobserve(target);
  near.observe(target);
}

/* A plot in a new or known element of class "plot"; `make` gives its traces and layout when it is seen. */
function draw(parent, id, make, kind = "") {
  let target = document.getElementById(id);
  if (!target) {
    target = document.createElement("div");
    target.id = id;
    target.className = `plot ${kind}`;
    parent.append(target);
  }
  wanted(target, make);
  return target;
}

/* One panel over time: `lines` are { run, name, factor } or { t, y }, with { label, color, dash, unlisted }; lines without data are left out. */
function timePlot(parent, id, title, unit, lines, more = {}) {
  const known = lines.filter(({ run, name, y }) => y || run?.signals[name]);
  document.getElementById(id)?.toggleAttribute("hidden", !known.length);
  if (!known.length) return;
  const y = { title: { text: unit, standoff: 14 }, ...more.yaxis };
  draw(parent, id, () => [known.map(({ run, name, t, y: values, label, color = tone.line, factor = 1, dash, unlisted }) => {
    const s = values ? { t, y: values } : series(run, name, factor);
    return { type: "scatter", mode: "lines", name: label, showlegend: !unlisted, x: s.t, y: more.absolute ? s.y.map(Math.abs) : s.y, line: { color, width: 1.4, dash } };
  }), layout({ ...titled(title), xaxis: { title: { text: "time, s" } }, yaxis: y, ...more.layout })], more.kind);
}

const MICRO = { type: "log", exponentformat: "power", dtick: 1 };
const controllerLines = (trajectory, name, factor) =>
  [...MODES].reverse().map((mode) => ({ run: findRun(trajectory, mode), name, factor, label: MODE_NAMES[mode], color: MODE_COLORS[mode] }));

/* Names of many lines stand beside a plot that is high enough for them. */
const MANY = { kind: "tall", layout: { legend: { font: { size: 10 } } } };
const wheel = (k, n) => `hsl(${(360 * k) / n}, 65%, 42%)`;

const sum = (rows, of) => rows.reduce((total, row) => total + of(row), 0);

/* A table: cells of the head, rows as HTML, number of columns from the left that hold names. */
const table = (head, rows, names = 1) =>
  html`<table class="data"><tr>${head.map((text, k) => html`<th${k < names ? html` class="left"` : ""}>${text}</th>`)}</tr>${rows}</table>`;
const row = (cells, names = 1) =>
  html`<tr>${cells.map((text, k) => html`<td${k < names ? html` class="left"` : ""}>${text}</td>`)}</tr>`;
/* Three significant digits, with an exponent only where it is shorter. */
function short(value) {
  const plain = value === 0 || (Math.abs(value) >= 1e-3 && Math.abs(value) < 1e5);
  return (plain ? (value === 0 ? "0" : Number(value.toPrecision(3)).toString()) : value.toExponential(1)).replaceAll("-", "−");
}
