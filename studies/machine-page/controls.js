/*
 * What can be changed while the machine runs: one table, from which the panel is made. A variable that may be set between steps takes effect at
 * once; all others by a restart, which the sign beside the name says.
 */

import { html } from "./page.js";
import { takesEffectAtOnce } from "./variables.js";

/* Words that an operator says for the laws of `controller.mode`. */
export const LAWS = {
  adaptive: "learns the load (adaptive)",
  adaptive_integral: "learns, with integral",
  modular: "trusts the data sheet (modular)",
  modular_integral: "trusts, with integral",
  pd: "plain springs and dampers (PD)",
  pd_gravity: "PD with gravity",
  pd_gravity_integral: "PD, gravity, integral",
  cascade: "cascade, as drives have it",
  disturbance_observer: "disturbance observer",
  super_twisting: "sliding mode (super-twisting)",
};

const DEGREE = Math.PI / 180;
const AXES = [1, 2, 3];

/*
 * Rows: where (`sheet`), what it is called, unit shown, `factor` from the unit shown to that of the variables, range, what it is at the start
 * (`start`, in the unit shown; left out: what the variable is), and the variables that get the value. Each is left out where the system has no
 * such variable. `perPayload`: range and start are parts of the machine's payload. `list`: names to choose from; `flag`: a switch; `inverse`: the variable is `factor` over what is shown; `hint`: what it does.
 */
export const CONTROLS = [
  { sheet: "load", label: "Payload", unit: "kg", range: [0, 2, 1 / 30], perPayload: true, names: ["hdrm.payload.mass"] },
  { sheet: "load", label: "Load to pick up", unit: "kg", range: [1 / 30, 4 / 3, 1 / 30], start: 0.5, perPayload: true, own: "load" },
  { sheet: "load", label: "All bodies heavier than planned", unit: "%", factor: 0.01, offset: 1, range: [-40, 40, 5], names: ["hdrm.inertia_scale"] },
  { sheet: "load", label: "Base rolls to the side", unit: "°", factor: DEGREE, range: [-10, 10, 0.5], names: ["hdrm.base.tilt[1]"] },
  { sheet: "load", label: "Base tips forward or back", unit: "°", factor: DEGREE, range: [-10, 10, 0.5], names: ["hdrm.base.tilt[2]"] },
  { sheet: "law", label: "Controller", list: LAWS, names: ["controller.mode"] },
  { sheet: "law", label: "Supervisor", flag: true, names: ["controller.supervisor"], hint: "Watches sensors, drives and rods, and stops the machine when something fails. The emergency stop needs it" },
  { sheet: "law", label: "Stiffness of position", unit: "1/s", range: [1, 40, 0.5], names: ["controller.Lambda_position"], hint: "How fast the tip goes back to its place: higher is stiffer, too high swings" },
  { sheet: "law", label: "Stiffness of orientation", unit: "1/s", range: [1, 40, 0.5], names: ["controller.Lambda_orientation"], hint: "The same for how the tip is turned" },
  { sheet: "law", label: "Damping of the bodies", unit: "1/s", range: [2, 80, 1], names: ["controller.kappa_KA"], hint: "How strongly each body is held to the speed that is wanted of it" },
  { sheet: "law", label: "Adaptation speed", unit: "1/kJ", factor: 1000, inverse: true, range: [2, 200, 1], names: ["controller.gamma"], hint: "How fast the controller learns the masses; 1000 over its gain gamma" },
  { sheet: "law", label: "Integral at the tip", unit: "1/s", range: [0, 20, 0.5], names: ["controller.omega_tip"], hint: "How fast a lasting error of the tip is taken away, by the controllers with integral" },
  { sheet: "law", label: "Feedback of speed at the motors", unit: "V·s/m", range: [100, 2000, 20], names: ["controller.K_v"], hint: "How strongly the motors are held to their speed" },
  { sheet: "world", label: "Stiffness of mounting and pins", unit: "N/µm", factor: 1e6, range: [10, 150, 5], names: AXES.map((k) => `emla_${k}.compliance.mount`) },
  { sheet: "world", label: "Play between nut and rod", unit: "µm", factor: 1e-6, range: [0, 200, 10], names: AXES.map((k) => `emla_${k}.backlash.width`) },
  { sheet: "world", label: "Sensor delay", unit: "steps", range: [0, 4, 1], names: ["sensors.delay"] },
  { sheet: "world", label: "Joint encoders count", flag: true, names: ["sensors.joint_encoder"] },
  { sheet: "world", label: "Currents are measured with errors", flag: true, names: ["sensors.current"] },
  { sheet: "world", label: "Seed of the sensors' errors", unit: "", range: [0, 20, 1], names: ["sensors.seed"] },
  { sheet: "world", label: "Wrist drives lag and stick", flag: true, names: ["hdrm.wrist"] },
  { sheet: "world", label: "Motors warm at the start", unit: "°C", offset: 273.15, range: [-20, 120, 5], names: AXES.flatMap((k) => [`emla_${k}.T_winding_start`, `emla_${k}.T_housing_start`]) },
  { sheet: "world", label: "Battery charged at the start", unit: "%", factor: 0.01, range: [5, 100, 5], names: ["dclink.battery.soc_start"] },
  { sheet: "world", label: "Resistance of the battery", unit: "mΩ", factor: 1e-3, range: [20, 1000, 20], names: ["dclink.battery.R_0"] },
  { sheet: "world", label: "The battery gives at most", unit: "A", range: [5, 120, 5], names: ["dclink.battery.discharge_limit"] },
];

export class Panel {
  /* `payload`, kg, is the machine's; `changed(control, values, atOnce)` is told the values by the variables' names. */
  constructor(sheets, payload, changed) {
    const scaled = (part) => Number((part * payload).toPrecision(4));
    const all = CONTROLS.map((control) => (control.perPayload ? { ...control, range: control.range.map(scaled), start: control.start && scaled(control.start) } : control));
    Object.assign(this, { sheets, all, changed, controls: [], usual: new Map() });
  }

  /* Rows for the variables of the running system, in the place of those before. */
  build(variables) {
    this.controls.forEach(({ row }) => row.remove());
    if (variables !== this.variables) this.usual.clear();
    this.variables = variables;
    this.controls = this.all.filter(({ names, own }) => own || variables.has(names[0])).map((control) => ({ ...control }));
    for (const control of this.controls) {
      control.atOnce = Boolean(control.own) || takesEffectAtOnce(variables.get(control.names[0]));
      this.row(control);
      const sheet = this.sheets[control.sheet];
      sheet.insertBefore(control.row, sheet.querySelector(":scope > .buttons, :scope > fieldset"));
    }
  }

  row(control) {
    const { label, unit, range = [], list, flag, atOnce, hint, names } = control;
    control.row = html`<label class="row"><span>${label}</span></label>`;
    const [name] = control.row.children;
    name.title = [hint, atOnce ? "" : "The machine starts again with another value"].filter(Boolean).join(". ");
    if (!atOnce) name.className = "restarts";
    const [min, max, step] = range;
    control.field = list ? html`<select></select>` : flag ? html`<input type="checkbox">` : html`<input type="range" min="${min}" max="${max}" step="${step}">`;
    Object.entries(list ?? {}).forEach(([value, text]) => control.field.add(new Option(text, value)));
    const text = document.createElement("b");
    control.say = () => (text.textContent = `${control.field.value.replace("-", "−")} ${unit}`);
    if (unit !== undefined) control.row.append(text);
    control.row.append(control.field);
    if (hint && !flag) {
      const back = html`<button class="back" title="Back to its usual value" aria-label="${label}: back to its usual value">↺</button>`;
      back.addEventListener("click", (event) => {
        // The label would give the click to the slider.
        event.preventDefault();
        this.put(control, this.shown(control, this.usual.get(names[0]) ?? Number(this.variables.get(names[0]).start)));
        this.tell(control);
      });
      control.row.append(back);
    }
    if (control.start !== undefined) this.put(control, control.start);
    control.field.addEventListener("input", control.say);
    // What takes effect at once follows the slider; a restart waits until it is let go.
    control.field.addEventListener(atOnce ? "input" : "change", () => this.tell(control));
  }

  put(control, value) {
    if (control.flag) control.field.checked = value === true || value === "true" || value === 1;
    else {
      // A gain of a machine of one's own may lie beyond the usual ones.
      if (value > Number(control.field.max)) control.field.max = value;
      if (value < Number(control.field.min)) control.field.min = value;
      control.field.value = value;
    }
    control.say();
  }

  value({ flag, field, list }) {
    return flag ? field.checked : list ? field.value : Number(field.value);
  }

  own(name) {
    return this.value(this.controls.find((control) => control.own === name));
  }

  tell(control) {
    const { factor = 1, offset = 0, list, flag, inverse, names = [] } = control;
    const value = this.value(control);
    const inside = list || flag ? value : Number((inverse ? factor / value : value * factor + offset).toPrecision(12));
    this.changed(control, Object.fromEntries(names.map((name) => [name, inside])));
  }

  /* A variable's number as it is shown. */
  shown({ factor = 1, offset = 0, inverse }, inside) {
    return Number((inverse ? factor / inside : (inside - offset) / factor).toPrecision(9));
  }

  /* Shows what the variables are; `read(name)` gives a value. What the settings do not name is the usual value. */
  async follow(read, settings) {
    for (const control of this.controls) {
      if (control.own) continue;
      const { list, flag, names } = control;
      const inside = await read(names[0]);
      if (!(names[0] in settings || this.usual.has(names[0]))) this.usual.set(names[0], inside);
      if (list) this.put(control, this.variables.get(names[0]).items.find((item) => item.value === inside)?.name);
      else this.put(control, flag ? inside : this.shown(control, inside));
    }
  }
}
