/* The stability proof in numbers. */
const stabilityName = (r) => `${r.trajectory}, ${r.law} law, ${short(1000 * r.step)} ms`;

function stability() {
  const { runs, conditions, gains, inertia_scale } = data.stability;
  element("stability-scale").textContent = percent(inertia_scale);
  if (!runs.length) return;
  const of = (values) => values.map(short);
  const power = ({ mean, max }) => of([mean, max]);
  show("stability-functions", grouped(["½ sᵀMs of the bodies, J", "γ D_F of the adaptation, J", "Σ ν_a of the actuators, J"], ["first", "largest", "last"],
    runs.map((r) => row([stabilityName(r), ...[r.nu_velocity, r.nu_adaptation, r.nu_actuators].flatMap(of)]))));
  show("stability-bound", grouped(["dissipation B, W", "excess ν̇ + B, W", "of it: bodies, W", "of it: actuators, W", "of it: cuts, W"], ["mean", "largest"],
    runs.map((r) => row([stabilityName(r), `${(100 * r.exceeded).toFixed(1)} %`, ...[r.dissipation, r.excess, r.bodies, r.actuators, r.cuts].flatMap(power)])),
    "share of time with ν̇ > −B"));
  show("stability-gains", table(["condition", "weight ε, A/N", "value", "must be at least", "unit", "verdict"], conditions.map((c) =>
    row([c.statement, short(c.weight), short(c.value), short(c.bound), c.unit, html`<b class="${c.holds ? "pass" : "fail"}">${c.holds ? "holds" : "fails"}</b>`]))));
  element("stability-constants").textContent = `At the largest current β₁ = ${short(gains.beta_1)} N/A and |β₂| = ${short(gains.beta_2)} N/A. The first condition is shown ` +
    `as printed, where Young's inequality has the weight 1 A/N, and with half of the largest weight for which it holds, ε_max = ${short(gains.epsilon_max)} A/N. ` +
    `K₂ is chosen as twice its least value for that weight, and K₁ = L_q/(β₁ K_v) = ${short(gains.K_1)} m/N is an equality, so with positive gains both hold by construction.`;
  choose("stability-run", runs, stabilityName, stabilityPlots, (r) => r.law === "shipped");
}

/* A table of groups of columns; `first` is a column of its own before them. */
function grouped(groups, columns, rows, first) {
  const extra = first ? html`<th class="wrap" rowspan="2">${first}</th>` : "";
  const heads = groups.map((text) => html`<th class="middle" colspan="${columns.length}">${text}</th>`);
  const names = groups.flatMap(() => columns.map((text) => html`<th>${text}</th>`));
  return html`<table class="data dense"><tr><th class="left" rowspan="2">run</th>${extra}${heads}</tr><tr>${names}</tr>${rows}</table>`;
}

function stabilityPlots(run) {
  const parent = element("stability-plots");
  const t = Float64Array.from({ length: run.count }, (_, k) => run.start + k * run.every);
  const values = (name) => whole(decode(run.curves[name]), run.count);
  const line = (name, label, color, more = {}) => ({ t, y: values(name), label, color, ...more });
  timePlot(parent, "l-nu", "Accompanying functions", "J", [
    line("nu_velocity", "½ sᵀMs", "#0072b2"), line("nu_adaptation", "γ D_F", "#009e73"), line("nu_actuators", "Σ ν_a", "#d55e00"),
  ], { absolute: true, yaxis: { ...MICRO } });
  timePlot(parent, "l-rate", "Derivative and its bound, means over 20 ms", "W", [
    line("nu_dot", "ν̇", "#0072b2"), { ...line("dissipation", "bound −B", undefined, { dash: "dot" }), y: values("dissipation").map((v) => -v) },
  ]);
  timePlot(parent, "l-excess", "Largest excess ν̇ + B in each 20 ms", "W", [line("excess_max", "excess", "#cc3355")], { yaxis: { rangemode: "tozero" } });
  timePlot(parent, "l-parts", "Where the excess comes from, means over 20 ms", "W", [
    line("bodies", "bodies", "#0072b2"), line("actuators", "actuators", "#d55e00"), line("cuts", "cuts at the rods", "#7b61bf"),
  ]);
}
