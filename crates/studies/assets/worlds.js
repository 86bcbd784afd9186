/* The worlds side by side. */
function worlds() {
  const cell = (s, scale, digits) =>
    s.worst === null ? "<td>failed</td>" : `<td>${(scale * s.median).toFixed(digits)} <small>(${(scale * s.worst).toFixed(digits)})</small></td>`;
  const table = (world) => {
    const rows = world.laws.map((row) =>
      `<tr><td class="left">${escape(row.law.replaceAll("_", " + "))}</td>${cell(row.known, 1e3, 3)}${cell(row.plant, 1e3, 3)}${cell(row.plant_varying, 1e3, 3)}${cell(row.orientation, 1e3, 2)}${cell(row.rho, 1e3, 2)}</tr>`);
    return `<h3>${world.name}</h3><p>${escape(world.sentence)} ${world.cases} machines, both trajectories.</p>` +
      `<table class="data"><tr><th class="left">controller</th><th>known error, mm</th><th>plant's tip, mm</th><th>less its mean, mm</th><th>angle, mrad</th><th>&rho;, ms</th></tr>${rows.join("")}</table>`;
  };
  element("worlds-table").innerHTML = data.worlds.map(table).join("");
}
