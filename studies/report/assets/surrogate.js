/* The surrogate on the rig: maps, responses, and what it does in the loop. */
function surrogate() {
  const s = data.surrogate;
  if (!s) return;
  document.querySelectorAll("#surrogate, nav a[href='#surrogate']").forEach((e) => e.classList.add("present"));
  const [[load, speed], [rows, columns]] = [s.reach, s.cells];
  const centre = (k, n) => (k + 0.5) / n;
  const x = Array.from({ length: columns }, (_, j) => 1000 * speed * (2 * centre(j, columns) - 1));
  const y = Array.from({ length: rows }, (_, i) => (load / 1000) * (2 * centre(i, rows) - 1));
  for (const [k, map] of s.maps.entries()) {
    const cells = whole(decode(map.values), rows * columns);
    const z = y.map((_, i) => cells.slice(i * columns, (i + 1) * columns));
    draw(element("surrogate-maps"), `sm-${k}`, () => [[{ type: "heatmap", x, y, z, colorscale: "Viridis", zmin: 0, zmax: 1,
      hovertemplate: "%{x:.1f} mm/s, %{y:.1f} kN: η %{z:.3f}<extra></extra>", colorbar: { title: { text: "η" }, thickness: 14 } }],
    layout({ ...titled(map.title), hovermode: "closest", xaxis: { title: { text: "rod speed, mm/s" } }, yaxis: { title: { text: "load, kN" } } })]);
  }
  const colors = [ACTUATOR_COLORS[2], undefined];
  for (const [k, panel] of s.responses.entries()) {
    const lines = panel.lines.map((line, j) => ({ ...broken(decode(line.t), decode(line.y)), label: line.name, color: colors[j], dash: j ? "dot" : undefined }));
    timePlot(element("surrogate-responses"), `sr-${k}`, panel.title, panel.unit, lines);
  }
  // Null where a run is so short that no window counts.
  const number = (value, digits) => (value === null ? "–" : value.toFixed(digits));
  const cell = (e) => `${number(e.current[0], 3)} A, ${number(e.efficiency[0] === null ? null : 100 * e.efficiency[0], 2)} %`;
  const body = s.runs.map((r) => row([r.trajectory, r.sensors, r.model, (1000 * r.tip).toFixed(3), number(r.current, 3), ...r.predicted.map(cell)], 3));
  show("surrogate-table", table(["trajectory", "load cells and rod encoders", "controller reckons with", "tip, mm", "required less true current, A", "physics predicts", "hybrid", "network"], body, 3));
  choose("surrogate-run", s.runs, (r) => `${r.trajectory}, ${r.sensors} load cells, ${r.model}`, surrogateRun);
}

/* Time and value with a gap where windows are missing: a line does not bridge them. */
function broken(t, y) {
  const kept = { t: [], y: [] };
  for (const k of t.keys()) {
    if (k && t[k] - t[k - 1] > 0.03) {
      kept.t.push(t[k]);
      kept.y.push(null);
    }
    kept.t.push(t[k]);
    kept.y.push(y[k]);
  }
  return kept;
}

function surrogateRun(run) {
  const parent = element("surrogate-plots");
  const [t, required, taken] = run.lift_current.map(decode);
  timePlot(parent, "sl-current", "Current of the lift motor", "A", [
    { t, y: taken, label: "true", color: ACTUATOR_COLORS[2] }, { t, y: required, label: "required by the controller", dash: "dot" }]);
  const [at, truth, ...models] = run.lift_efficiency.map(decode);
  const names = ["physics", "hybrid", "network"];
  timePlot(parent, "sl-efficiency", "Efficiency of the lift actuator", "1", [
    { ...broken(at, truth), label: "true" }, ...models.map((y, k) => ({ ...broken(at, y), label: names[k], color: wheel(k, 3) }))]);
  draw(parent, "sl-scatter", () => [[
    { type: "scatter", mode: "lines", name: "equal", x: [0, 1], y: [0, 1], line: { color: tone.line, width: 1 } },
    ...models.map((y, k) => ({ type: "scatter", mode: "markers", name: names[k], x: truth, y, marker: { size: 3, color: wheel(k, 3) } }))],
  layout({ ...titled("Lift: predicted efficiency"), hovermode: "closest", xaxis: { title: { text: "true" } }, yaxis: { title: { text: "predicted" } } })]);
}
