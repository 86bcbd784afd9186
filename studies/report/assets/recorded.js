/* Studies that take hours, from the files that their commands wrote. */
function recorded() {
  const { tournament, margins } = data.recorded;
  if (!tournament && !margins) return;
  document.querySelectorAll(".optional[href='#laws'], #laws").forEach((part) => part.classList.add("present"));
  if (tournament) tournamentTable(tournament);
  if (margins) marginsPlot(margins);
}

const lawName = (law) => law.replaceAll("_", " ");

function tournamentTable({ rows, tuned }) {
  const gainsOf = (law) => tuned.find((t) => t.law === law)?.gains.map(([name, value]) => `${name} ${short(value)}`).join(", ") ?? "";
  const lines = rows.map(({ law, counts, error, ratio }) => row([
    lawName(law), counts.lost, counts.stopped, counts.kept, error.median === null ? "–" : mm(error.median, 3), error.worst === null ? "–" : mm(error.worst, 3),
    ratio ? html`${ratio[0].toFixed(2)} <small>(${ratio[1].toFixed(2)} to ${ratio[2].toFixed(2)})</small>` : "",
  ]));
  const gains = rows.map(({ law }) => html`<b>${lawName(law)}</b> ${gainsOf(law)}`);
  show("tournament-table",
    table(["law", "lost", "stopped", "kept", "median, mm", "worst, mm", "error over that of adaptive integral (95 %)"], lines), html`<p>Tuned gains: ${separated("; ", gains)}.</p>`);
}

/* All places and payloads as small marks, the least as a large one; delay, in steps, has a panel of its own. */
function marginsPlot({ changes, margins }) {
  const laws = [...new Set(margins.map((m) => m.law))];
  const panels = [changes.filter((c) => c.change !== "delay"), changes.filter((c) => c.change === "delay")];
  const symbol = (m) => (!m.beyond ? "triangle-right-open" : m.beyond[1] === "force" ? "square" : "circle");
  const ending = (m) => (!m.beyond ? "the largest that is tried" : m.beyond[1] === "force" ? "beyond, a rod carries more than its rated force" : "beyond, it swings");
  const traces = panels.flatMap((rows, column) => laws.map((law, k) => {
    const own = margins.filter((m) => m.law === law && rows.some((c) => c.change === m.change));
    const least = (m) => own.every((other) => other.change !== m.change || other.stable >= m.stable);
    const line = (m) => rows.findIndex((c) => c.change === m.change) + 0.17 * (k - (laws.length - 1) / 2);
    return {
      type: "scatter", mode: "markers", name: lawName(law), legendgroup: law, showlegend: column === 0, xaxis: `x${column + 1}`, yaxis: `y${column + 1}`,
      x: own.map((m) => m.stable), y: own.map(line), text: own.map((m) => `${m.place}, ${m.payload} kg: ${m.stable.toFixed(2)}; ${ending(m)}`), hoverinfo: "text+name",
      marker: { color: wheel(k, laws.length), symbol: own.map(symbol), size: own.map((m) => (least(m) ? 11 : 5)) },
    };
  }));
  const y = (rows) => ({ tickvals: rows.map((_, k) => k), ticktext: rows.map((c) => c.name), range: [rows.length - 0.5, -0.5], automargin: true, zeroline: false });
  const target = (rows, column) => ({ type: "line", xref: `x${column}`, yref: `y${column} domain`, x0: rows[0].target, x1: rows[0].target, y0: 0, y1: 1, line: { color: tone.line, dash: "dot" } });
  draw(element("margins-figure"), "margins-plot", () => [traces, layout({
    height: 480, hovermode: "closest", shapes: panels.map((rows, k) => target(rows, k + 1)),
    xaxis: { type: "log", domain: [0, 0.62], range: [-0.05, 0.95], tickvals: [1, 2, 4, 8], title: { text: "stable up to this factor" } }, yaxis: y(panels[0]),
    xaxis2: { domain: [0.78, 1], range: [-0.3, 3.4], dtick: 1, title: { text: "steps of 1 ms" } }, yaxis2: { ...y(panels[1]), anchor: "x2" },
  })], "free").style.height = "480px";
}
