/* What of the running system the page looks at: variables by what they are shown as, and the scopes. */
const three = (name) => [1, 2, 3].map((k) => name.replace("#", k));
export const SIGNALS = {
  zeta: [1, 2, 3, 4, 5, 6].map((k) => `hdrm.zeta[${k}]`),
  tip: three("hdrm.tip.position[#]"),
  orientation: [1, 2, 3, 4].map((k) => `hdrm.tip.orientation[${k}]`),
  desired: three("controller.desired.position[#]"),
  aim: [1, 2, 3, 4].map((k) => `controller.desired.orientation[${k}]`),
  error: ["controller.tip_error_norm"],
  force: three("emla_#.F"),
  current: three("emla_#.i_q"),
  power: three("emla_#.P_in"),
  winding: three("emla_#.T_winding"),
  stroke: three("hdrm.x[#]"),
  speed: three("hdrm.x_dot[#]"),
  load: ["hdrm.load.mass"],
  contact: three("hdrm.contact.force[#]"),
  tilt: ["hdrm.base.tilt[1]", "hdrm.base.tilt[2]"],
  masses: ["T1", "A2", "A3", "D4", "PL"].map((body) => `controller.mass_hat.${body}`),
  stage: ["controller.supervisor.state"],
  cause: ["controller.supervisor.cause"],
  link: ["dclink.v_dc"],
  charge: ["dclink.soc"],
  pack: ["dclink.i_battery"],
};
/* What is looked at of a ghost. */
export const GHOST_SIGNALS = { zeta: SIGNALS.zeta, error: SIGNALS.error };

export const ACTUATORS = ["Slew", "Lift", "Tilt"];
const celsius = (kelvin) => kelvin - 273.15;

/* Scopes: `signal` of SIGNALS, names of its curves, and how a value is shown. */
export const SCOPES = [
  { name: "error", title: "Tip error", unit: "mm", signal: "error", labels: ["this machine"], of: (v) => 1000 * v, ghosts: true, shown: true },
  { name: "force", title: "Rod forces", unit: "kN", signal: "force", labels: ACTUATORS, of: (v) => v / 1000, shown: true },
  { name: "current", title: "Motor currents", unit: "A", signal: "current", labels: ACTUATORS, shown: true },
  { name: "speed", title: "Rod speeds", unit: "mm/s", signal: "speed", labels: ACTUATORS, of: (v) => 1000 * v },
  { name: "power", title: "Electrical power", unit: "kW", signal: "power", labels: ACTUATORS, of: (v) => v / 1000 },
  { name: "winding", title: "Winding temperatures", unit: "°C", signal: "winding", labels: ACTUATORS, of: celsius },
  { name: "masses", title: "Learnt masses (dashed: the true ones)", unit: "kg", signal: "masses", labels: ["column", "lift boom", "tilt boom", "wrist", "payload"], truth: true },
  { name: "link", title: "DC link", unit: "V", signal: "link", labels: ["voltage"] },
  { name: "charge", title: "Battery charge", unit: "%", signal: "charge", labels: ["charge"], of: (v) => 100 * v },
  { name: "pack", title: "Battery current", unit: "A", signal: "pack", labels: ["current"] },
];

/* Names to be watched of those that the system has, and where each signal's values are among them. */
export function watched(signals, has) {
  const [names, places] = [[], {}];
  for (const [signal, variables] of Object.entries(signals)) {
    if (!variables.every(has)) continue;
    places[signal] = variables.map((name) => names.push(name) - 1);
  }
  return { names, places };
}
