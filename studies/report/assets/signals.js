/* Signals of a run, and what the adaptation does. */
const perActuator = (run, name, factor = 1) =>
  ACTUATORS.map((label, i) => ({ run, name: name(i + 1), label, color: ACTUATOR_COLORS[i], factor }));
const JOINT_COLORS = [...ACTUATOR_COLORS, "#0072b2", "#cc79a7", "#8c8c1a"];
const degrees = 180 / Math.PI;

function withRequired(run, actual, required, factor) {
  return [...perActuator(run, actual, factor),
    ...perActuator(run, required, factor).map((l) => ({ ...l, label: `${l.label}, required`, dash: "dot", unlisted: true }))];
}

function signals(run) {
  const parent = element("signal-plots");
  const joints = (from, to) => JOINT_COLORS.slice(from, to).map((color, k) => ({
    run, name: `hdrm.zeta[${from + k + 1}]`, factor: degrees, color, label: ["slew", "lift", "tilt", "wrist 1", "wrist 2", "wrist 3"][from + k],
  }));
  timePlot(parent, "s-joints", "Joint angles", "deg", joints(0, 3));
  timePlot(parent, "s-wrist", "Wrist angles", "deg", joints(3, 6));
  timePlot(parent, "s-force", "Actuator forces (dotted: required)", "kN", withRequired(run, (i) => `emla_${i}.F`, (i) => `controller.f_required[${i}]`, 1e-3));
  timePlot(parent, "s-speed", "Rod velocities (dotted: required)", "mm/s", withRequired(run, (i) => `hdrm.x_dot[${i}]`, (i) => `controller.x_dot_required[${i}]`, 1e3));
  timePlot(parent, "s-stroke", "Strokes", "mm", perActuator(run, (i) => `hdrm.x[${i}]`, 1e3));
  timePlot(parent, "s-torque", "Wrist torques", "N·m", ["wrist 1", "wrist 2", "wrist 3"].map((label, i) => ({
    run, name: `controller.tau_wrist[${i + 1}]`, label, color: JOINT_COLORS[3 + i] })));
  timePlot(parent, "s-iq", "Currents i_q (dotted: required)", "A", withRequired(run, (i) => `emla_${i}.i_q`, (i) => `controller.i_q_required[${i}]`));
  timePlot(parent, "s-id", "Currents i_d", "A", perActuator(run, (i) => `emla_${i}.i_d`));
  timePlot(parent, "s-vq", "Voltages v_q", "V", perActuator(run, (i) => `controller.v_q[${i}]`));
  timePlot(parent, "s-vd", "Voltages v_d", "V", perActuator(run, (i) => `controller.v_d[${i}]`));
  timePlot(parent, "s-motor", "Motor speeds", "rpm", perActuator(run, (i) => `emla_${i}.w_m`, 30 / Math.PI));
  timePlot(parent, "s-power", "Electrical power", "kW", perActuator(run, (i) => `emla_${i}.P_in`, 1e-3));
}

function adaptation(run) {
  const parent = element("adaptation-plots");
  const estimates = Object.keys(run.signals).filter((n) => n.startsWith("controller.mass_hat."));
  const bodies = data.scene.bodies.map((b) => b.name).filter((b) => estimates.includes(`controller.mass_hat.${b}`));
  const lines = bodies.map((b, k) => ({ run, name: `controller.mass_hat.${b}`, label: b, color: wheel(k, bodies.length) }));
  const relative = lines.map((l) => ({ ...l, get factor() { return 1 / (series(run, l.name).y[0] || 1); } }));
  timePlot(parent, "a-mass", "Estimated masses, relative to the start", "ratio", relative, MANY);
  timePlot(parent, "a-mass-kg", "Estimated masses", "kg", lines, MANY);
  const nu = ["nu_velocity", "nu_adaptation", "nu_actuator[1]", "nu_actuator[2]", "nu_actuator[3]"];
  const names = ["ν velocity", "ν adaptation", "ν slew", "ν lift", "ν tilt"];
  timePlot(parent, "a-nu", "Terms of the accompanying function", "J", nu.map((n, k) => ({
    run, name: `controller.lyapunov.${n}`, label: names[k], color: wheel(k, 5) })), { yaxis: { ...MICRO, range: [-8, 2] }, absolute: true });
  timePlot(parent, "a-vpf", "Virtual power flows and dissipation", "W", [
    { run, name: "controller.lyapunov.dissipation", label: "dissipation" },
    ...perActuator(run, (i) => `controller.lyapunov.vpf[${i}]`)]);
}
