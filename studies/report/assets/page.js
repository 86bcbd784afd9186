/* Conditions, and all sections put on the page. */
function conditions() {
  const c = data.conditions;
  const rows = [
    ["made", `${new Date(1e3 * c.made).toISOString().replace(".000", "")} by ${c.program} on ${c.host} (${c.platform}, ${c.processor}, ${c.cores} cores)`],
    ["system", c.system], ["communication step", `${c.step} s, ${c.schedule}`],
    ["machine file", html`${c.machine_file}, SHA-256 <code>${c.machine_sha256}</code>`],
    ["start values set", c.settings.length ? separated(html`<br>`, c.settings) : "none beyond trajectory, controller and inertia"],
    ["largest distance of the drawn tip from the FMU's", `${Math.max(...data.runs.map((r) => r.drawing_error)).toExponential(1)} m`],
  ];
  const parts = c.components.map((p) =>
    html`<tr><td class="left">${p.name}</td><td class="left">${p.source}</td><td class="left">${p.model} ${p.version}</td><td class="left"><code>${p.guid}</code></td><td class="left">${p.tool}</td></tr>`);
  const runs = data.runs.map((r) => {
    const bond = Math.max(...r.bonds.map((b) => b.peak), 0);
    return html`<tr><td class="left">${runName(r)}</td><td>${r.simulated.toFixed(3)}</td><td>${r.motion_start.toFixed(2)}</td><td>${r.real_time_factor.toFixed(0)}</td><td>${bond.toPrecision(3)}</td><td class="left">${separated(html`<br>`, r.warnings)}</td></tr>`;
  });
  show("conditions-table", html`<table class="data">${rows.map(([k, v]) => html`<tr><th class="left">${k}</th><td class="left">${v}</td></tr>`)}</table>
    <h3>FMUs</h3><table class="data"><tr><th class="left">component</th><th class="left">file</th><th class="left">model</th><th class="left">GUID</th><th class="left">made by</th></tr>${parts}</table>
    <h3>Runs shown</h3><table class="data"><tr><th class="left">run</th><th>simulated, s</th><th>motion from, s</th><th>× real time</th><th>peak bond residual, W</th><th class="left">messages</th></tr>${runs}</table>
    <p>Times real time is what the run reached while others ran on the other cores and all signals were recorded. Plots show every 4 ms (tip error) or 20 ms; the tables count every communication point.</p>`);
}

if (OWN) {
  document.title = `Co-simulation report: ${OWN}`;
  document.querySelector("h1").textContent = `${OWN}: an all-electric manipulator`;
  element("papers-column").remove();
}
cards();
tracking();
ownPath();
worlds();
recorded();
robustness();
studies();
chooseRun("signals-run", signals);
chooseRun("adaptation-run", adaptation, (run) => run.mode === "adaptive" && run.scale !== 1);
stability();
energyTable();
electric();
chooseRun("energy-run", energy);
surrogate();
testbed();
conditions();
/* What scrolls sideways can be reached with the keyboard. */
document.querySelectorAll(".scroll").forEach((part) => part.setAttribute("tabindex", "0"));
