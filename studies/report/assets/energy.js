/* Energy, efficiency and the testbed. */
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
    html`<tr>${k ? "" : html`<td class="group" rowspan="${balances.length}">${trajectory}</td>`}<td class="left">${name(b.actuator)}</td>
    ${columns.map(([key]) => html`<td>${(b[key] / 1000).toFixed(3)}</td>`)}<td>${b.efficiency === null ? "–" : `${(100 * b.efficiency).toFixed(1)} %`}</td><td>${(100 * b.throughput).toFixed(1)} %</td></tr>`));
  show("energy-table", html`<h3>Energy over the motion, kJ, adaptive controller</h3>
    <table class="data dense"><tr><th class="left">trajectory</th><th class="left">actuator</th>${columns.map(([, title]) => html`<th>${title}</th>`)}<th>efficiency while work is done</th><th>throughput</th></tr>${rows}</table>`);
}

/* The machine that a battery feeds. */
function electric() {
  if (!data.electric.length) return;
  element("electric").classList.add("present");
  const J = (value) => value === undefined || value === null ? "–" : value.toFixed(2);
  const rows = data.electric.map(({ trajectory, supply: s, open }) => s && row([trajectory, ...[s.source?.battery, s.source?.brake, s.source?.lost, s.source?.stored,
    s.given, s.residual, s.work, s.shift, s.lost, s.stored, open, s.throughput].map(J)])).filter(Boolean);
  const axes = data.electric.flatMap(({ trajectory, sizing }) => sizing.axes.map((a) => row([`${trajectory}, ${a.actuator}`,
    a.torque.rms.toFixed(2), a.continuous.toFixed(1), a.torque.peak.toFixed(2), (a.speed.peak * 30 / Math.PI).toFixed(0), a.current.peak.toFixed(2), a.motor.current.toFixed(0),
    (a.force.peak / 1000).toFixed(2), (a.ratings.force_max / 1000).toFixed(0), (a.temperatures.winding_max - 273.15).toFixed(1), (a.temperatures.housing - 273.15).toFixed(1)])));
  show("electric-table",
    table(["energy, J", "from the pack", "brake resistor", "lost in the link", "stored in the link", "to the drives", "lost at the bonds", "work on the load", "work by the coupling at the rods", "lost in the drives", "stored in the drives", "left open", "through the bonds"], rows),
    table(["motors over the motion", "torque rms, N·m", "may last", "peak", "speed, rpm", "current, A", "limit", "force, kN", "rating", "winding in an hour, °C", "housing"], axes));
  const parent = element("electric-plots");
  const brief = (name) => name.replace(/\.(v_dc|i_battery|i_dc_mean|soc|P_brake)$/, "").replace(".T_", " ");
  const groups = [["voltage of the link", "V", /\.v_dc$/, 1, 0], ["currents of pack and drives", "A", /\.i_(battery|dc_mean)$/, 1, 0], ["state of charge", "%", /\.soc$/, 100, 0],
    ["temperatures", "°C", /\.T_/, 1, -273.15], ["brake resistor", "kW", /\.P_brake$/, 1e-3, 0]];
  for (const run of data.electric) {
    const t = Float64Array.from({ length: run.count }, (_, k) => run.start + k * run.every);
    for (const [title, unit, pattern, factor, offset] of groups) {
      const found = run.curves.filter(({ name }) => pattern.test(name));
      timePlot(parent, `electric-${run.trajectory}-${unit}`, `${run.trajectory}: ${title}`, unit, found.map((c, k) => ({
        t, y: [...whole(decode(c.samples), run.count)].map((v) => factor * v + offset), label: brief(c.name), color: wheel(k, found.length) })), { layout: { legend: { font: { size: 10 } } } });
    }
    for (const m of run.motors) {
      const [w, peak, lasting] = [m.speeds, m.peak, m.continuous].map((s) => [...whole(decode(s), 101)]);
      const around = (y) => [[...w, ...[...w].reverse(), ...w.map((v) => -v), ...w.map((v) => -v).reverse()],
        [...y, ...y.map((v) => -v).reverse(), ...y.map((v) => -v), ...[...y].reverse()]];
      const line = (name, [x, y], k) => ({ type: "scatter", mode: "lines", name, x, y, line: { color: wheel(k, 3), width: 1.4 } });
      draw(parent, `electric-${run.trajectory}-${m.actuator}`, () => [[line("peak", around(peak), 0), line("continuous", around(lasting), 1),
        line("motion", m.motion.map((s) => whole(decode(s), m.count)), 2)],
      layout({ ...titled(`${run.trajectory}: torque and speed of ${m.actuator}`), hovermode: "closest", xaxis: { title: { text: "motor speed, rev/min" } }, yaxis: { title: { text: "torque, N·m" } } })]);
    }
  }
}

function testbed() {
  if (!data.testbed?.axes.length) return;
  document.querySelectorAll("#testbed, nav a[href='#testbed']").forEach((e) => e.classList.add("present"));
  const quantities = [["force", "kN", 1e-3], ["velocity", "mm/s", 1e3], ["position", "mm", 1e3]];
  const rows = data.testbed.axes.map((a) => {
    const cell = ({ rmse, max, peak }, factor) => html`<td>${(rmse * factor).toPrecision(3)}</td><td>${(max * factor).toPrecision(3)}</td><td>${((100 * rmse) / peak).toPrecision(2)} %</td>`;
    return html`<tr><td class="left">${a.axis}, ${a.trajectory}</td>${cell(a.position, 1e3)}${cell(a.velocity, 1e3)}${cell(a.force, 1)}</tr>`;
  });
  const heads = ["position, mm", "velocity, mm/s", "force, N"].map((q) => html`<th>${q}: RMSE</th><th>max</th><th>of peak</th>`);
  show("testbed-table", html`<p>Load emulators with a lag of ${1000 * data.testbed.lag} ms. A simulation: no measurement of a real testbed is public.</p>
    <table class="data dense"><tr><th class="left">axis</th>${heads}</tr>${rows}</table>`);
  for (const a of data.testbed.axes) {
    const x = Float64Array.from({ length: a.count }, (_, k) => a.start + k * a.every);
    for (const [quantity, unit, factor] of quantities) {
      const line = (k, name, color, dash) => ({
        type: "scatter", mode: "lines", name, x, y: whole(decode(a.curves[quantity][k]), a.count).map((v) => v * factor), line: { color, dash, width: 1.5 } });
      draw(element("testbed-plots"), `t-${a.trajectory}-${a.axis}-${quantity}`, () => [[line(1, "measured", ACTUATOR_COLORS[2]), line(0, "desired", tone.line, "dot")],
        layout({ ...titled(`${a.axis}, ${a.trajectory}: ${quantity}`), xaxis: { title: { text: "time, s" } }, yaxis: { title: { text: unit } } })]);
    }
  }
}

/* The map of the actuator FMU with the run's operating points on it. */
function efficiencyMap(run) {
  const map = data.efficiency_map;
  const points = () => ACTUATORS.map((label, k) => {
    const [f, eta, valid] = ["F", "efficiency", "efficiency_valid"].map((n) => series(run, `emla_${k + 1}.${n}`));
    const v = series(run, `hdrm.x_dot[${k + 1}]`);
    if (!f || !v || !eta || !valid) return null;
    const kept = [...f.y.keys()].filter((i) => valid.y[i] > 0.5);
    return {
      type: "scatter", mode: "markers", name: label, marker: { color: ACTUATOR_COLORS[k], size: 4, line: { width: 0.5, color: "#fff" } },
      x: kept.map((i) => 1000 * v.y[i]), y: kept.map((i) => f.y[i] / 1000), text: kept.map((i) => `η ${eta.y[i].toFixed(3)}`),
    };
  }).filter(Boolean);
  const surfaces = map ? [["hybrid", "Actuator as it runs (hybrid)"], ["physics", "Physics alone"], ["network", "Network alone"]] : [];
  for (const [key, title] of surfaces) {
    const cells = whole(decode(map[key]), map.loads.length * map.speeds.length);
    const z = map.loads.map((_, i) => cells.slice(i * map.speeds.length, (i + 1) * map.speeds.length));
    draw(element("efficiency-map"), `map-${key}`, () => [[
      { type: "heatmap", x: map.speeds.map((s) => 1000 * s), y: map.loads.map((l) => l / 1000), z, colorscale: "Viridis", zmin: 0, zmax: 1,
        hovertemplate: "%{x:.1f} mm/s, %{y:.1f} kN: η %{z:.3f}<extra></extra>", colorbar: { title: { text: "η" }, thickness: 14 } },
      ...points(),
    ], layout({ ...titled(title), hovermode: "closest", xaxis: { title: { text: "rod speed, mm/s" } }, yaxis: { title: { text: "load, kN" } } })]);
  }
}
