/* The worlds side by side. */
function worlds() {
  const cell = (s, scale, digits) =>
    s === null ? "<td>&ndash;</td>" : s.worst === null ? "<td>failed</td>" : `<td>${(scale * s.median).toFixed(digits)} <small>(${(scale * s.worst).toFixed(digits)})</small></td>`;
  const table = (world) => {
    const command = `<code>${escape(world.command)}</code>`;
    if (world.cases === 0) return `<h3>${world.name}</h3><p>${escape(world.sentence)} Not run for this page: ${command}.</p>`;
    const rows = world.laws.map((row) =>
      `<tr><td class="left">${escape(row.law.replaceAll("_", " + "))}</td>${cell(row.known, 1e3, 3)}${cell(row.plant, 1e3, 3)}${cell(row.plant_varying, 1e3, 3)}${cell(row.sag, 1e3, 2)}${cell(row.orientation, 1e3, 2)}${cell(row.rho, 1e3, 2)}</tr>`);
    return `<h3>${world.name}</h3><p>${escape(world.sentence)} Machines: ${world.cases}, both trajectories; more of them by ${command}.</p>` +
      `<table class="data"><tr><th class="left">controller</th><th>known error, mm</th><th>plant's tip, mm</th><th>less its mean, mm</th><th>sag, mm</th><th>angle, mrad</th><th>&rho;, ms</th></tr>${rows.join("")}</table>`;
  };
  element("worlds-table").innerHTML = data.worlds.map(table).join("");
}
