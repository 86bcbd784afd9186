/* Tables and plots. */
const CONFIG = { responsive: true, displaylogo: false, toImageButtonOptions: { format: "svg" } };
const FONT = { family: "system-ui, Segoe UI, Helvetica Neue, Arial, sans-serif", size: 12, color: "#1d2733" };

function layout(more) {
  const axis = { gridcolor: "#e6ebf0", zerolinecolor: "#c9d2db", linecolor: "#c9d2db", automargin: true };
  const { xaxis, yaxis, ...rest } = more;
  return {
    font: FONT, margin: { l: 58, r: 14, t: 54, b: 42 }, hovermode: "x unified", paper_bgcolor: "#fff", plot_bgcolor: "#fff",
    legend: { orientation: "h", x: 1, xanchor: "right", y: 1.02, yanchor: "bottom", font: { size: 11 } },
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

/* One panel over time: `lines` are { run, name, label, color, factor, dash }; lines without data are left out. */
function timePlot(parent, id, title, unit, lines, more = {}) {
  const traces = [];
  for (const { run, name, label, color, factor = 1, dash } of lines) {
    const s = series(run, name, factor);
    if (!s) continue;
    traces.push({ type: "scatter", mode: "lines", name: label, x: s.t, y: more.absolute ? s.y.map(Math.abs) : s.y, line: { color, width: 1.4, dash } });
  }
  document.getElementById(id)?.toggleAttribute("hidden", !traces.length);
  if (!traces.length) return;
  const y = { title: { text: unit }, ...more.yaxis };
  draw(parent, id, traces, layout({ ...titled(title), xaxis: { title: { text: "time, s" } }, yaxis: y, ...more.layout }), more.kind);
}

const MICRO = { type: "log", exponentformat: "power", dtick: 1 };
const controllerLines = (trajectory, name, factor) =>
  [...MODES].reverse().map((mode) => ({ run: findRun(trajectory, mode), name, factor, label: MODE_NAMES[mode], color: MODE_COLORS[mode] }));

const sum = (rows, of) => rows.reduce((total, row) => total + of(row), 0);

function cards() {
  const cards = [];
  for (const trajectory of TRAJECTORIES) {
    const row = data.table.find((r) => r.trajectory === trajectory && r.scale === 1);
    for (const cell of row.cells.filter((c) => c.mode === "adaptive")) {
      cards.push([`${mm(cell.rmse)} mm`, `tip RMSE, ${trajectory}, adaptive (paper: ${mm(row.paper, 1)} mm)`]);
    }
  }
  const adaptive = data.table.flatMap((r) => r.cells).filter((c) => c.mode === "adaptive" && c.rmse !== null);
  cards.push([`${mm(Math.max(...adaptive.map((c) => c.rmse)), 3)} mm`, "worst adaptive RMSE of the ten cells (paper: 6.0 mm)"]);
  const worst = Math.max(...data.runs.map((r) => sum(r.bonds, (b) => Math.abs(b.energy)) / sum(r.bonds, (b) => b.turnover)));
  cards.push([`${(100 * worst).toPrecision(2)} %`, "energy lost or created by the coupling, of the energy that its power bonds pass (worst run shown)"]);
  element("cards").innerHTML = cards.map(([big, small]) => `<div class="card"><b>${big}</b><span>${escape(small)}</span></div>`).join("");
  if (data.failures.length) {
    element("failures").hidden = false;
    element("failures").innerHTML = "<b>Runs that failed:</b><br>" + data.failures.map(escape).join("<br>");
  }
}

const POSITION = ["hdrm.tip.position[1]", "hdrm.tip.position[2]", "hdrm.tip.position[3]"];
const DESIRED = ["controller.desired.position[1]", "controller.desired.position[2]", "controller.desired.position[3]"];

/* Desired path, or the tip's with its error magnified: [x, y, z] in world axes. */
function path(run, gain) {
  const [p, d] = [POSITION, DESIRED].map((names) => names.map((name) => series(run, name)?.y));
  if (d.some((v) => !v)) return null;
  return gain === 0 ? d : d.map((axis, i) => axis.map((v, k) => v + gain * (p[i][k] - v)));
}

function pathPlot(parent, trajectory, gain) {
  const line = (xyz, name, color, width, dash) =>
    // Plotly's vertical axis is z; the machine's is y.
    ({ type: "scatter3d", mode: "lines", name, x: xyz[0], y: xyz[2].map((v) => -v), z: xyz[1], line: { color, width, dash }, hoverinfo: "name" });
  const traces = [];
  for (const mode of [...MODES].reverse()) {
    const xyz = path(findRun(trajectory, mode), gain);
    if (xyz) traces.push(line(xyz, MODE_NAMES[mode], MODE_COLORS[mode], 4));
  }
  const any = MODES.map((mode) => findRun(trajectory, mode)).find(Boolean);
  const desired = any && path(any, 0);
  if (desired) traces.push(line(desired, "desired", "#3c3c3c", 3, "dash"));
  const axis = (text) => ({ title: { text }, gridcolor: "#dde3ea", zerolinecolor: "#dde3ea", backgroundcolor: "#fafbfc", showbackground: true });
  const name = gain === 1 ? `Tip path, ${trajectory}` : `Tip path, ${trajectory}: error × ${gain}`;
  draw(parent, `path-${trajectory}`, traces, {
    ...layout({ ...titled(name), hovermode: "closest" }), margin: { l: 0, r: 0, t: 38, b: 0 }, uirevision: "keep",
    scene: {
      aspectmode: "data", xaxis: axis("x, m"), yaxis: axis("−z, m"), zaxis: axis("y, m"),
      camera: { eye: { x: -1.2, y: -1.7, z: 0.8 } },
    },
  }, "tall");
}

function tracking() {
  const parent = element("tracking-plots");
  for (const trajectory of TRAJECTORIES) {
    const block = document.createElement("div");
    block.innerHTML = `<h3>${trajectory} trajectory</h3>${trackingTable(trajectory)}<div class="grid"></div><div class="grid"></div>`;
    parent.append(block);
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
  const rows = MODES.map((mode) => findRun(trajectory, mode)).filter(Boolean).map((run) => {
    const paper = run.mode === "adaptive" ? mm(data.table.find((r) => r.trajectory === trajectory && r.scale === 1).paper, 1) : "–";
    return `<tr><td class="left">${MODE_NAMES[run.mode]}</td><td>${mm(run.rmse)}</td><td>${mm(run.max)}</td><td>${paper}</td></tr>`;
  });
  return `<table class="data"><tr><th class="left">controller</th><th>RMSE, mm</th><th>max, mm</th><th>paper, RMSE, mm</th></tr>${rows.join("")}</table>`;
}

function robustness() {
  const head = MODES.map((mode) => `<th>${MODE_NAMES[mode]} <small>(max)</small></th>`).join("");
  const rows = data.table.map((row, k) => {
    const first = k === 0 || data.table[k - 1].trajectory !== row.trajectory;
    const span = data.table.filter((r) => r.trajectory === row.trajectory).length;
    const best = Math.min(...row.cells.map((c) => c.rmse ?? Infinity));
    const cells = row.cells.map((c) => `<td class="${c.rmse === best ? "best" : ""}">${mm(c.rmse, 3)} <small>(${mm(c.max, 3)})</small></td>`);
    return `<tr>${first ? `<td class="group" rowspan="${span}">${row.trajectory}</td>` : ""}<td>${percent(row.scale)}</td>${cells.join("")}<td>${mm(row.paper, 1)}</td></tr>`;
  });
  element("robustness-table").innerHTML =
    `<table class="data"><tr><th class="left">trajectory</th><th>inertia</th>${head}<th>paper, adaptive</th></tr>${rows.join("")}</table>`;
  const traces = [];
  TRAJECTORIES.forEach((trajectory, column) => {
    const own = data.table.filter((r) => r.trajectory === trajectory);
    const line = (name, color, values, dash) => ({
      type: "scatter", mode: "lines+markers", name, legendgroup: name, showlegend: column === 0, xaxis: `x${column + 1}`, yaxis: `y${column + 1}`,
      x: own.map((r) => 100 * (r.scale - 1)), y: values, line: { color, dash }, marker: { size: 7 },
    });
    MODES.forEach((mode, k) => traces.push(line(MODE_NAMES[mode], MODE_COLORS[mode], own.map((r) => r.cells[k].rmse && 1000 * r.cells[k].rmse))));
    traces.push(line("paper, adaptive", "#3c3c3c", own.map((r) => 1000 * r.paper), "dot"));
  });
  const x = (text) => ({ title: { text }, gridcolor: "#e6ebf0", zerolinecolor: "#c9d2db", ticksuffix: " %" });
  const y = { ...MICRO, gridcolor: "#e6ebf0", title: { text: "tip RMSE, mm" } };
  const target = element("robustness-plot");
  Plotly.react(target, traces, layout({
    grid: { rows: 1, columns: 2, pattern: "independent", xgap: 0.12 }, xaxis: x("error of all inertias, cubic"), yaxis: y,
    xaxis2: x("error of all inertias, triangular"), yaxis2: y,
  }), CONFIG);
}

const perActuator = (run, name, factor = 1) =>
  ACTUATORS.map((label, i) => ({ run, name: name(i + 1), label, color: ACTUATOR_COLORS[i], factor }));
const JOINT_COLORS = [...ACTUATOR_COLORS, "#0072b2", "#cc79a7", "#8c8c1a"];
const degrees = 180 / Math.PI;

function withRequired(run, actual, required, factor) {
  return [...perActuator(run, actual, factor),
    ...perActuator(run, required, factor).map((l) => ({ ...l, label: `${l.label}, required`, dash: "dot" }))];
}

function signals(run) {
  const parent = element("signal-plots");
  const joints = (from, to) => JOINT_COLORS.slice(from, to).map((color, k) => ({
    run, name: `hdrm.zeta[${from + k + 1}]`, factor: degrees, color, label: ["slew", "lift", "tilt", "wrist 1", "wrist 2", "wrist 3"][from + k],
  }));
  timePlot(parent, "s-joints", "Joint angles", "deg", joints(0, 3));
  timePlot(parent, "s-wrist", "Wrist angles", "deg", joints(3, 6));
  timePlot(parent, "s-force", "Actuator forces", "kN", withRequired(run, (i) => `emla_${i}.F`, (i) => `controller.f_required[${i}]`, 1e-3));
  timePlot(parent, "s-speed", "Rod velocities", "mm/s", withRequired(run, (i) => `hdrm.x_dot[${i}]`, (i) => `controller.x_dot_required[${i}]`, 1e3));
  timePlot(parent, "s-stroke", "Strokes", "mm", perActuator(run, (i) => `hdrm.x[${i}]`, 1e3));
  timePlot(parent, "s-torque", "Wrist torques", "N·m", ["wrist 1", "wrist 2", "wrist 3"].map((label, i) => ({
    run, name: `controller.tau_wrist[${i + 1}]`, label, color: JOINT_COLORS[3 + i] })));
  timePlot(parent, "s-iq", "Currents i_q", "A", withRequired(run, (i) => `emla_${i}.i_q`, (i) => `controller.i_q_required[${i}]`));
  timePlot(parent, "s-id", "Currents i_d", "A", perActuator(run, (i) => `emla_${i}.i_d`));
  timePlot(parent, "s-vq", "Voltages v_q", "V", perActuator(run, (i) => `controller.v_q[${i}]`));
  timePlot(parent, "s-vd", "Voltages v_d", "V", perActuator(run, (i) => `controller.v_d[${i}]`));
  timePlot(parent, "s-motor", "Motor speeds", "rpm", perActuator(run, (i) => `emla_${i}.w_m`, 30 / Math.PI));
  timePlot(parent, "s-power", "Electrical power", "kW", perActuator(run, (i) => `emla_${i}.P_in`, 1e-3));
}

/* Names of many lines stand beside the plot. */
const MANY = { layout: { legend: { font: { size: 10 } } } };
const wheel = (k, n) => `hsl(${(360 * k) / n}, 65%, 42%)`;

function adaptation(run) {
  const parent = element("adaptation-plots");
  const estimates = Object.keys(run.signals).filter((n) => n.startsWith("controller.mass_hat."));
  const bodies = data.scene.bodies.map((b) => b.name).filter((b) => estimates.includes(`controller.mass_hat.${b}`));
  const lines = bodies.map((b, k) => ({ run, name: `controller.mass_hat.${b}`, label: b, color: wheel(k, bodies.length) }));
  const relative = lines.map((l) => ({ ...l, factor: 1 / (series(run, l.name).y[0] || 1) }));
  timePlot(parent, "a-mass", "Estimated masses, relative to the start", "ratio", relative, MANY);
  timePlot(parent, "a-mass-kg", "Estimated masses", "kg", lines, MANY);
  const nu = ["nu_velocity", "nu_adaptation", "nu_actuator[1]", "nu_actuator[2]", "nu_actuator[3]"];
  const names = ["ν velocity", "ν adaptation", "ν slew", "ν lift", "ν tilt"];
  timePlot(parent, "a-nu", "Terms of the accompanying function", "J", nu.map((n, k) => ({
    run, name: `controller.lyapunov.${n}`, label: names[k], color: wheel(k, 5) })), { yaxis: { ...MICRO, range: [-8, 2] }, absolute: true });
  timePlot(parent, "a-vpf", "Virtual power flows and dissipation", "W", [
    { run, name: "controller.lyapunov.dissipation", label: "dissipation", color: "#3c3c3c" },
    ...perActuator(run, (i) => `controller.lyapunov.vpf[${i}]`)]);
}

function energy(run) {
  const parent = element("energy-plots");
  for (const [k, label] of ACTUATORS.entries()) {
    const kinds = ["copper", "core", "inverter", "mechanical"];
    timePlot(parent, `e-loss-${k}`, `Losses, ${label}`, "W", kinds.map((n, j) => ({
      run, name: `emla_${k + 1}.loss.${n}`, label: n, color: wheel(j, 4) })));
  }
  timePlot(parent, "e-machine", "Energy of the manipulator", "kJ", ["kinetic", "potential"].map((n, k) => ({
    run, name: `hdrm.energy.${n}`, label: n, factor: 1e-3, color: wheel(k, 2) })));
  efficiencyMap(run);
}

/* Balances of the adaptive controller's runs with nominal inertias. */
function energyTable() {
  const columns = [["electrical", "electrical in"], ["regenerated", "fed back"], ["work", "work on the load"], ["returned", "work of the load"],
    ["copper", "copper"], ["core", "core"], ["inverter", "inverter"], ["mechanical", "mechanical"], ["stored", "stored"]];
  const name = (actuator) => ACTUATORS[Number(actuator.split("_")[1]) - 1] ?? actuator;
  const rows = data.energy.flatMap(({ trajectory, balances }) => balances.map((b, k) =>
    `<tr>${k ? "" : `<td class="group" rowspan="${balances.length}">${trajectory}</td>`}<td class="left">${escape(name(b.actuator))}</td>` +
    `${columns.map(([key]) => `<td>${(b[key] / 1000).toFixed(3)}</td>`).join("")}<td>${(100 * b.efficiency).toFixed(1)} %</td></tr>`));
  element("energy-table").innerHTML = "<h3>Energy over the motion, kJ, adaptive controller</h3>" +
    `<table class="data"><tr><th class="left">trajectory</th><th class="left">actuator</th>${columns.map(([, title]) => `<th>${title}</th>`).join("")}<th>efficiency</th></tr>${rows.join("")}</table>`;
}

function testbed() {
  if (!data.testbed?.axes.length) return;
  document.querySelectorAll("#testbed, nav a[href='#testbed']").forEach((e) => e.classList.add("present"));
  const quantities = [["force", "kN", 1e-3], ["velocity", "mm/s", 1e3], ["position", "mm", 1e3]];
  const rows = data.testbed.axes.map((a) => {
    const cell = ({ rmse, max, peak }, factor) => `<td>${(rmse * factor).toPrecision(3)}</td><td>${(max * factor).toPrecision(3)}</td><td>${((100 * rmse) / peak).toPrecision(2)} %</td>`;
    return `<tr><td class="left">${a.axis}, ${a.trajectory}</td>${cell(a.position, 1e3)}${cell(a.velocity, 1e3)}${cell(a.force, 1)}</tr>`;
  });
  const heads = ["position, mm", "velocity, mm/s", "force, N"].map((q) => `<th>${q}: RMSE</th><th>max</th><th>of peak</th>`).join("");
  element("testbed-table").innerHTML = `<p>Load emulators with a lag of ${1000 * data.testbed.lag} ms. A simulation: no measurement of a real testbed is public.</p>` +
    `<table class="data"><tr><th class="left">axis</th>${heads}</tr>${rows.join("")}</table>`;
  for (const a of data.testbed.axes) {
    const x = Float64Array.from({ length: a.count }, (_, k) => a.start + k * a.every);
    for (const [quantity, unit, factor] of quantities) {
      const line = (k, name, color, dash) => ({
        type: "scatter", mode: "lines", name, x, y: whole(decode(a.curves[quantity][k]), a.count).map((v) => v * factor), line: { color, dash, width: 1.5 } });
      draw(element("testbed-plots"), `t-${a.trajectory}-${a.axis}-${quantity}`, [line(1, "measured", ACTUATOR_COLORS[2]), line(0, "desired", "#3c3c3c", "dot")],
        layout({ ...titled(`${a.axis}, ${a.trajectory}: ${quantity}`), xaxis: { title: { text: "time, s" } }, yaxis: { title: { text: unit } } }));
    }
  }
}

/* Map of the actuator with the run's operating points on it. */
function efficiencyMap(run) {
  const parent = element("efficiency-map");
  const points = ACTUATORS.map((label, k) => {
    const [f, eta, valid] = ["F", "efficiency", "efficiency_valid"].map((n) => series(run, `emla_${k + 1}.${n}`));
    const v = series(run, `hdrm.x_dot[${k + 1}]`);
    if (!f || !v || !eta || !valid) return null;
    const kept = [...f.y.keys()].filter((i) => valid.y[i] > 0.5);
    return {
      type: "scatter", mode: "markers", name: label, marker: { color: ACTUATOR_COLORS[k], size: 4, line: { width: 0.5, color: "#fff" } },
      x: kept.map((i) => 1000 * Math.abs(v.y[i])), y: kept.map((i) => Math.abs(f.y[i]) / 1000), text: kept.map((i) => `η ${eta.y[i].toFixed(3)}`),
    };
  }).filter(Boolean);
  const map = data.efficiency_map;
  const surfaces = map ? [["physics", "Physics"], ["hybrid", "Hybrid"], ["testbed", "Virtual testbed (a simulation)"]] : [];
  parent.className = "grid";
  for (const [key, title] of surfaces) {
    const cells = decode(map[key]);
    const z = map.loads.map((_, i) => cells.slice(i * map.speeds.length, (i + 1) * map.speeds.length));
    draw(parent, `map-${key}`, [
      { type: "heatmap", x: map.speeds.map((s) => 1000 * s), y: map.loads.map((l) => l / 1000), z, colorscale: "Viridis", zmin: 0, zmax: 0.9, colorbar: { title: { text: "η" } } },
      ...points,
    ], layout({ ...titled(`Efficiency, ${title}`), hovermode: "closest", xaxis: { title: { text: "rod speed, mm/s" } }, yaxis: { title: { text: "load, kN" } } }), "tall");
  }
  if (!map) {
    const hint = document.createElement("p");
    hint.innerHTML = "The map itself is drawn where the report is made with <code>--efficiency-map</code> and the file of <code>surrogate map</code>.";
    if (!document.getElementById("map-points")) parent.append(hint);
    draw(parent, "map-points", points, layout({ ...titled("Operating points where the efficiency is defined"), hovermode: "closest", xaxis: { title: { text: "rod speed, mm/s" } }, yaxis: { title: { text: "load, kN" } } }));
  }
}

function conditions() {
  const c = data.conditions;
  const rows = [
    ["made", `${c.date} by ${c.program} on ${c.host} (${c.platform}, ${c.processor}, ${c.cores} cores)`],
    ["system", c.system], ["communication step", `${c.step} s, ${c.schedule}`],
    ["machine file", `${c.machine_file}, SHA-256 <code>${c.machine_sha256}</code>`],
    ["start values set", c.settings.length ? c.settings.map(escape).join("<br>") : "none beyond trajectory, controller and inertia"],
    ["largest distance of the drawn tip from the FMU's", `${Math.max(...data.runs.map((r) => r.drawing_error)).toExponential(1)} m`],
  ];
  const parts = c.components.map((p) =>
    `<tr><td class="left">${escape(p.name)}</td><td class="left">${escape(p.source)}</td><td class="left">${escape(p.model)} ${escape(p.version)}</td><td class="left"><code>${escape(p.guid)}</code></td><td class="left">${escape(p.tool)}</td></tr>`);
  const runs = data.runs.map((r) => {
    const bond = Math.max(...r.bonds.map((b) => b.peak), 0);
    return `<tr><td class="left">${runName(r)}</td><td>${r.simulated.toFixed(3)}</td><td>${r.motion_start.toFixed(2)}</td><td>${r.real_time_factor.toFixed(0)}</td><td>${bond.toPrecision(3)}</td><td class="left">${r.warnings.map(escape).join("<br>")}</td></tr>`;
  });
  element("conditions-table").innerHTML =
    `<table class="data">${rows.map(([k, v]) => `<tr><th class="left">${k}</th><td class="left">${v}</td></tr>`).join("")}</table>` +
    `<h3>FMUs</h3><table class="data"><tr><th class="left">component</th><th class="left">file</th><th class="left">model</th><th class="left">GUID</th><th class="left">made by</th></tr>${parts.join("")}</table>` +
    `<h3>Runs shown</h3><table class="data"><tr><th class="left">run</th><th>simulated, s</th><th>motion from, s</th><th>× real time</th><th>peak bond residual, W</th><th class="left">messages</th></tr>${runs.join("")}</table>` +
    "<p>Times real time is what the run reached while others ran on the other cores and all signals were recorded. Plots show every 4 ms (tip error) or 20 ms; the tables count every communication point.</p>";
}

cards();
tracking();
robustness();
chooseRun("signals-run", signals);
chooseRun("adaptation-run", adaptation, (run) => run.mode === "adaptive" && run.scale !== 1);
energyTable();
chooseRun("energy-run", energy);
testbed();
element("stability-text").textContent = data.stability.text;
element("stability-scale").textContent = percent(data.stability.inertia_scale);
conditions();
