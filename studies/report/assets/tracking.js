/* Headline numbers and tip tracking. */
function cards() {
  const cards = [];
  for (const trajectory of TRAJECTORIES) {
    const row = data.table.find((r) => r.trajectory === trajectory && r.scale === 1);
    for (const cell of row.cells.filter((c) => c.mode === "adaptive")) {
      cards.push([`Tip error (RMSE) on the ${trajectory} path`, "adaptive controller that knows all parameters", `${mm(cell.rmse)} mm`, `${mm(row.paper, 1)} mm`]);
    }
  }
  const inertia = worstOfTable();
  if (inertia) cards.push(["The largest with wrong inertias", `adaptive controller; ${inertia.case}, ${inertia.trajectory}`, `${mm(inertia.rmse, 3)} mm`, `${mm(inertia.paper, 1)} mm`]);
  const other = largest(data.errors.map((e) => e.worst).filter(Boolean));
  if (other) cards.push(["The largest of the other errors", `adaptive controller; ${other.case}, ${other.trajectory}`, `${mm(other.rmse, 3)} mm`, "not in it"]);
  const bonds = Math.max(...data.runs.map((r) => sum(r.bonds, (b) => Math.abs(b.energy)) / sum(r.bonds, (b) => b.turnover)));
  cards.push(["Energy that the coupling loses or makes", "of what passes its power bonds; worst run shown", `${(100 * bonds).toPrecision(2)} %`, "not in it"]);
  show("cards", cards.map(([what, how, here, paper]) => html`<div class="card"><h2>${what}</h2><p>${how}</p><dl><div><dt>here, simulated</dt><dd>${here}</dd></div>${OWN ? "" : html`<div><dt>in the paper</dt><dd>${paper}</dd></div>`}</dl></div>`));
  element("settling").textContent = settling();
  if (data.failures.length) {
    element("failures").hidden = false;
    show("failures", html`<b>Runs that failed:</b><br>`, separated(html`<br>`, data.failures));
  }
}

const largest = (cases) => cases.reduce((worst, c) => (worst && worst.rmse >= c.rmse ? worst : c), null);

/* The adaptive controller's worst cell of the inertia table. */
const worstOfTable = () => largest(data.table.flatMap((row) => row.cells.filter((c) => c.mode === "adaptive" && c.rmse !== null)
  .map((c) => ({ ...c, trajectory: row.trajectory, case: `inertia ${percent(row.scale)}`, paper: row.paper }))));

/* What the errors leave out. */
function settling() {
  const runs = data.runs.filter((r) => r.mode === "adaptive");
  const worst = runs.reduce((a, b) => (a && a.whole_max >= b.whole_max ? a : b), null);
  if (!worst) return "";
  return `All errors count from the moment the reference begins to move, t = ${worst.motion_start} s. The time before is left out: the machine stands and the controller ` +
    `settles from its start values. With that time the largest error of the adaptive runs shown is ${mm(worst.whole_max)} mm (${runName(worst)}), without it ${mm(Math.max(...runs.map((r) => r.max)))} mm.`;
}

const POSITION = ["hdrm.tip.position[1]", "hdrm.tip.position[2]", "hdrm.tip.position[3]"];
const DESIRED = ["controller.desired.position[1]", "controller.desired.position[2]", "controller.desired.position[3]"];

/* Desired path, or the tip's with its error magnified: [x, y, z] in world axes. */
function path(run, gain) {
  const [p, d] = [POSITION, DESIRED].map((names) => names.map((name) => series(run, name)?.y));
  if (d.some((v) => !v)) return null;
  return gain === 0 ? d : d.map((axis, i) => axis.map((v, k) => v + gain * (p[i][k] - v)));
}

/* Axes with one scale that hold all traces. A path in a plane would have an axis of no length, for which Plotly's own aspect zooms in
   without limit: no axis is shorter than a third of the longest. */
function boxOf(traces) {
  const ends = ["x", "y", "z"].map((axis) => {
    const all = traces.map((t) => t[axis]);
    return [Math.min(...all.map((v) => v.reduce((a, b) => Math.min(a, b)))), Math.max(...all.map((v) => v.reduce((a, b) => Math.max(a, b))))];
  });
  const longest = 1.1 * Math.max(...ends.map(([low, high]) => high - low), 1e-3);
  const lengths = ends.map(([low, high]) => Math.max(1.1 * (high - low), longest / 3));
  const ranges = ends.map(([low, high], k) => [0.5 * (low + high - lengths[k]), 0.5 * (low + high + lengths[k])]);
  const [x, y, z] = lengths.map((length) => length / longest);
  return { ranges, ratio: { x, y, z } };
}

function pathPlot(parent, trajectory, gain) {
  const line = (xyz, name, color, width, dash) =>
    // Plotly's vertical axis is z; the machine's is y.
    ({ type: "scatter3d", mode: "lines", name, x: xyz[0], y: xyz[2].map((v) => -v), z: xyz[1], line: { color, width, dash }, hoverinfo: "name" });
  const makeTraces = () => {
    const traces = [];
    for (const mode of [...MODES].reverse()) {
      const xyz = path(findRun(trajectory, mode), gain);
      if (xyz) traces.push(line(xyz, MODE_NAMES[mode], MODE_COLORS[mode], 4));
    }
    const any = MODES.map((mode) => findRun(trajectory, mode)).find(Boolean);
    const desired = any && path(any, 0);
    if (desired) traces.push(line(desired, "desired", tone.line, 3, "dash"));
    return traces;
  };
  const name = gain === 1 ? `Tip path, ${trajectory}` : `Tip path, ${trajectory}: error × ${gain}`;
  draw(parent, `path-${trajectory}`, () => {
    const traces = makeTraces();
    const box = boxOf(traces);
    const axis = (text, k) => ({ title: { text }, range: box.ranges[k], gridcolor: tone.grid, zerolinecolor: tone.grid, backgroundcolor: tone.card, showbackground: true });
    return [traces, {
      ...layout({ ...titled(name), hovermode: "closest" }), margin: { l: 0, r: 0, t: 58, b: 0 }, uirevision: "keep",
      scene: {
        aspectmode: "manual", aspectratio: box.ratio, xaxis: axis("x, m", 0), yaxis: axis("−z, m", 1), zaxis: axis("y, m", 2),
        camera: { eye: { x: -1.15, y: -1.6, z: 0.8 }, center: { x: 0, y: 0, z: -0.08 } },
      },
    }];
  }, "tall");
}

function tracking() {
  const parent = element("tracking-plots");
  for (const trajectory of TRAJECTORIES) {
    const block = added("tracking-plots", html`<h3>${capital(trajectory)} trajectory</h3>${trackingTable(trajectory)}<div class="grid"></div><div class="grid"></div>`);
    const [paths, errors] = block.querySelectorAll(".grid");
    pathPlot(paths, trajectory, Number(element("path-gain").value));
    const lines = controllerLines(trajectory, "controller.tip_error_norm", 1000);
    timePlot(paths, `norm-${trajectory}`, "Norm of the tip error", "mm", lines, { kind: "tall", yaxis: { ...MICRO, range: [-4.5, 1.6] } });
    for (const [i, axis] of ["x", "y", "z"].entries()) {
      timePlot(errors, `error-${trajectory}-${axis}`, `Tip error in ${axis}`, "mm", controllerLines(trajectory, `controller.tip_error[${i + 1}]`, 1000));
    }
    timePlot(errors, `error-${trajectory}-adaptive`, "Tip error of the adaptive controller alone", "mm",
      ["x", "y", "z"].map((axis, i) => ({
        run: findRun(trajectory, "adaptive"), name: `controller.tip_error[${i + 1}]`, factor: 1000, label: axis, color: ["#0072b2", "#009e73", "#cc79a7"][i],
      })));
  }
  element("path-gain").addEventListener("change", (e) => {
    for (const trajectory of TRAJECTORIES) pathPlot(parent, trajectory, Number(e.target.value));
  });
}

function trackingTable(trajectory) {
  const paper = data.table.find((r) => r.trajectory === trajectory && r.scale === 1).paper;
  const rows = MODES.map((mode) => findRun(trajectory, mode)).filter(Boolean).map((run) =>
    row([MODE_NAMES[run.mode], mm(run.rmse), ...(OWN ? [] : [run.mode === "adaptive" ? mm(paper, 1) : "–"]), mm(run.max), mm(run.whole_rmse), mm(run.whole_max)]));
  const head = ["controller", "RMSE, mm", ...(OWN ? [] : ["paper, RMSE, mm"]), "max, mm", "RMSE with settling, mm", "max with settling, mm"];
  return html`<div class="scroll">${table(head, rows)}</div>`;
}
