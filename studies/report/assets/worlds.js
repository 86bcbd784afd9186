/* The worlds side by side. */
function worlds() {
  const cell = (s, scale, digits) =>
    s === null ? html`<td>–</td>` : s.worst === null ? html`<td>failed</td>` : html`<td>${(scale * s.median).toFixed(digits)} <small>(${(scale * s.worst).toFixed(digits)})</small></td>`;
  const table = (world) => {
    const command = html`<code>${world.command}</code>`;
    if (world.cases === 0) return html`<h3>${world.name}</h3><p>${world.sentence} Not run for this page: ${command}.</p>`;
    const rows = world.laws.map((row) =>
      html`<tr><td class="left">${row.law.replaceAll("_", " + ")}</td>${cell(row.known, 1e3, 3)}${cell(row.plant, 1e3, 3)}${cell(row.plant_varying, 1e3, 3)}${cell(row.sag, 1e3, 2)}${cell(row.orientation, 1e3, 2)}${cell(row.rho, 1e3, 2)}</tr>`);
    return html`<h3>${world.name}</h3><p>${world.sentence} Machines: ${world.cases}, both trajectories; more of them by ${command}.</p>
      <table class="data"><tr><th class="left">controller</th><th>known error, mm</th><th>plant's tip, mm</th><th>less its mean, mm</th><th>sag, mm</th><th>angle, mrad</th><th>&rho;, ms</th></tr>${rows}</table>`;
  };
  show("worlds-table", data.worlds.map(table));
}
