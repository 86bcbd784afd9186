/* Errors of parameters, noise and loads. */
function robustness() {
  const head = MODES.map((mode) => html`<th>${MODE_NAMES[mode]} <small>(max)</small></th>`);
  const rows = data.table.map((row, k) => {
    const first = k === 0 || data.table[k - 1].trajectory !== row.trajectory;
    const span = data.table.filter((r) => r.trajectory === row.trajectory).length;
    const best = Math.min(...row.cells.map((c) => c.rmse ?? Infinity));
    const cells = row.cells.map((c) => html`<td class="${c.rmse === best ? "best" : ""}">${mm(c.rmse, 3)} <small>(${mm(c.max, 3)})</small></td>`);
    return html`<tr>${first ? html`<td class="group" rowspan="${span}">${row.trajectory}</td>` : ""}<td>${percent(row.scale)}</td>${cells}${OWN ? "" : html`<td>${mm(row.paper, 1)}</td>`}</tr>`;
  });
  show("robustness-table",
    html`<table class="data"><tr><th class="left">trajectory</th><th>inertia</th>${head}${OWN ? "" : html`<th>paper, adaptive</th>`}</tr>${rows}</table>`);
  const traces = () => TRAJECTORIES.flatMap((trajectory, column) => {
    const own = data.table.filter((r) => r.trajectory === trajectory);
    const line = (name, color, values, dash) => ({
      type: "scatter", mode: "lines+markers", name, legendgroup: name, showlegend: column === 0, xaxis: `x${column + 1}`, yaxis: `y${column + 1}`,
      x: own.map((r) => 100 * (r.scale - 1)), y: values, line: { color, dash }, marker: { size: 7 },
    });
    return [...MODES.map((mode, k) => line(MODE_NAMES[mode], MODE_COLORS[mode], own.map((r) => r.cells[k].rmse && 1000 * r.cells[k].rmse))),
      ...(OWN ? [] : [line("paper, adaptive", tone.line, own.map((r) => 1000 * r.paper), "dot")])];
  });
  const x = (text) => ({ title: { text }, ticksuffix: " %" });
  const y = { ...MICRO, title: { text: "tip RMSE, mm" } };
  draw(element("robustness-figure"), "robustness-plot", () => [traces(), layout({
    grid: { rows: 1, columns: 2, pattern: "independent", xgap: 0.12 }, xaxis: x("error of all inertias, cubic"), yaxis: y,
    xaxis2: x("error of all inertias, triangular"), yaxis2: MICRO,
  })], "short");
}

/* Heading of each study. */
const STUDY_TITLES = { motor: "Motor and transmission parameters", payload: "Payload", noise: "Sensor noise", "tip-load": "Unknown load on the tip" };

function studies() {
  for (const study of data.errors) {
    const block = added("studies", html`<h3>${STUDY_TITLES[study.study]}</h3><p>${study.varied} ${worstOf(study)}</p>
      <div class="scroll">${studyTable(study)}</div>`);
    block.className = "study";
    studyPlot(block, study);
  }
}

function worstOf({ worst, target }) {
  if (!worst) return "No run of the adaptive controller succeeded.";
  const verdict = target === null ? "" : `; it is to stay below ${mm(target, 1)} mm: ${worst.rmse <= target ? "met" : "not met"}`;
  return `Worst case of the adaptive controller: ${worst.case}, ${worst.trajectory}, RMSE ${mm(worst.rmse, 3)} mm, maximum ${mm(worst.max, 3)} mm${verdict}.`;
}

const casesOf = (study) => [...new Set(study.rows.map((r) => r.case))];
const cellsOf = (study, trajectory, name) => study.rows.find((r) => r.trajectory === trajectory && r.case === name)?.cells ?? [];

/* A case a row, both trajectories side by side. */
function studyTable(study) {
  const groups = TRAJECTORIES.map((t) => html`<th class="middle" colspan="${MODES.length}">${t}: tip RMSE <small>(max)</small>, mm</th>`);
  const modes = TRAJECTORIES.flatMap(() => MODES.map((mode) => html`<th>${MODE_NAMES[mode]}</th>`));
  const rows = casesOf(study).map((name) => {
    const cells = TRAJECTORIES.flatMap((t) => cellsOf(study, t, name)).map((c) => html`<td>${mm(c.rmse, 3)} <small>(${mm(c.max, 3)})</small></td>`);
    return html`<tr><td class="left">${name}</td>${cells}</tr>`;
  });
  return html`<table class="data"><tr><th class="left" rowspan="2">case</th>${groups}</tr><tr>${modes}</tr>${rows}</table>`;
}

/* A case a line of the plot, a trajectory a panel. */
function studyPlot(parent, study) {
  const cases = casesOf(study);
  const traces = TRAJECTORIES.flatMap((trajectory, column) => MODES.map((mode, k) => ({
    type: "scatter", mode: "markers", name: MODE_NAMES[mode], legendgroup: mode, showlegend: column === 0, xaxis: `x${column + 1}`, yaxis: `y${column + 1}`,
    x: cases.map((name) => 1000 * cellsOf(study, trajectory, name)[k]?.rmse || null), y: cases, marker: { color: MODE_COLORS[mode], size: 8 },
  })));
  const range = logRange(traces.flatMap((t) => t.x));
  const x = (trajectory) => ({ ...MICRO, range, title: { text: `${trajectory}: tip RMSE, mm` } });
  const y = { autorange: "reversed", automargin: true };
  const height = 130 + 24 * cases.length;
  draw(parent, `study-${study.study}`, () => [traces, layout({
    height, hovermode: "closest", grid: { rows: 1, columns: 2, pattern: "independent", xgap: 0.1 },
    xaxis: x(TRAJECTORIES[0]), yaxis: y, xaxis2: x(TRAJECTORIES[1]), yaxis2: { ...y, showticklabels: false },
  })], "free").style.height = `${height}px`;
}

/* Ends of a logarithmic axis that holds the values, in powers of ten; a little more, so that the labels at both ends stay inside. */
function logRange(values) {
  const logs = values.filter((v) => v > 0).map(Math.log10);
  return logs.length ? [Math.floor(Math.min(...logs)) - 0.2, Math.ceil(Math.max(...logs)) + 0.2] : [-3, 1];
}
