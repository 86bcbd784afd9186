/* What all tables and plots have in common. */
const CONFIG = { responsive: true, displaylogo: false, toImageButtonOptions: { format: "svg" } };
const FONT = { family: "system-ui, Segoe UI, Helvetica Neue, Arial, sans-serif", size: 12, color: "#1d2733" };

function layout(more) {
  const axis = { gridcolor: "#e6ebf0", zerolinecolor: "#c9d2db", linecolor: "#c9d2db", automargin: true };
  const { xaxis, yaxis, ...rest } = more;
  return {
    font: FONT, margin: { l: 58, r: 14, t: 58, b: 42 }, hovermode: "x unified", paper_bgcolor: "#fff", plot_bgcolor: "#fff",
    legend: { orientation: "h", x: 1, xanchor: "right", y: 1, yanchor: "bottom", font: { size: 11 } },
    xaxis: { ...axis, ...xaxis }, yaxis: { ...axis, ...yaxis }, ...rest,
  };
}

const titled = (text) => ({ title: { text, x: 0, xref: "paper", xanchor: "left", y: 0.985, yref: "container", yanchor: "top", font: { size: 13 } } });

/* Draw into a new or known element of class "plot". */
function draw(parent, id, traces, lay, kind = "") {
  let target = document.getElementById(id);
  if (!target) {
    target = document.createElement("div");
    target.id = id;
    target.className = `plot ${kind}`;
    parent.append(target);
  }
  return Plotly.react(target, traces, lay, CONFIG);
}

/* One panel over time: `lines` are { run, name, factor } or { t, y }, with { label, color, dash, unlisted }; lines without data are left out. */
function timePlot(parent, id, title, unit, lines, more = {}) {
  const traces = [];
  for (const { run, name, t, y, label, color, factor = 1, dash, unlisted } of lines) {
    const s = y ? { t, y } : series(run, name, factor);
    if (!s) continue;
    traces.push({ type: "scatter", mode: "lines", name: label, showlegend: !unlisted, x: s.t, y: more.absolute ? s.y.map(Math.abs) : s.y, line: { color, width: 1.4, dash } });
  }
  document.getElementById(id)?.toggleAttribute("hidden", !traces.length);
  if (!traces.length) return;
  const y = { title: { text: unit, standoff: 14 }, ...more.yaxis };
  draw(parent, id, traces, layout({ ...titled(title), xaxis: { title: { text: "time, s" } }, yaxis: y, ...more.layout }), more.kind);
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
