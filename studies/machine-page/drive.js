/*
 * Levers: on the screen, by keys, by a gamepad or joystick. Each is between −1 and 1 and springs back. What they lead, the joints or the tip,
 * is up to the page, which is told the commands as rates.
 */

import { html } from "./page.js";

/* The levers in the order of the screen: names of both ends, keys of the two directions, and what of the rates they are. Positive is the first end. */
const LEVERS = {
  joint: [
    { name: "Slew", ends: ["right", "left"], at: [0, -1] }, { name: "Lift", ends: ["up", "down"], at: [1, 1] }, { name: "Tilt", ends: ["out", "in"], at: [2, 1] },
    { name: "Wrist roll", ends: ["+", "−"], at: [3, 1] }, { name: "Wrist bend", ends: ["up", "down"], at: [4, 1] }, { name: "Wrist turn", ends: ["+", "−"], at: [5, 1] },
  ],
  tip: [
    { name: "Sideways", ends: ["right", "left"], at: [2, 1] }, { name: "Height", ends: ["up", "down"], at: [1, 1] }, { name: "Reach", ends: ["out", "in"], at: [0, 1] },
    { name: "Roll", ends: ["+", "−"], at: [3, 1] }, { name: "Nod", ends: ["up", "down"], at: [5, 1] }, { name: "Turn", ends: ["left", "right"], at: [4, 1] },
  ],
};
export const LEVER_KEYS = [["KeyD", "KeyA"], ["KeyW", "KeyS"], ["KeyE", "KeyQ"], ["KeyR", "KeyF"], ["KeyT", "KeyG"], ["KeyU", "KeyJ"]];
/* Axes and pairs of buttons of a gamepad with the standard layout, for each lever; the sign makes the first end positive. */
const PAD = [{ axis: 0, sign: 1 }, { axis: 1, sign: -1 }, { axis: 3, sign: -1 }, { buttons: [5, 4] }, { buttons: [12, 13] }, { axis: 2, sign: -1 }];
const DEAD_ZONE = 0.12;

export class Levers {
  /* `rates(kind)` gives the largest rates; `moved(kind, rates)` is told new ones. */
  constructor(parent, rates, moved) {
    Object.assign(this, { rates, moved, kind: "joint", keys: new Set(), sent: "", padName: "" });
    this.rows = LEVER_KEYS.map((keys, k) => {
      const [more, less] = keys.map((key) => key.slice(3));
      const row = html`<label class="lever"><b><span></span><i>0</i></b><kbd title="key">${less}</kbd><input type="range" min="-1" max="1" step="0.01" value="0"><kbd title="key">${more}</kbd></label>`;
      parent.append(row);
      const field = row.querySelector("input");
      // Let go, it springs back: by pointer, by keys, and when the focus leaves.
      for (const event of ["pointerup", "pointercancel", "keyup", "blur"]) field.addEventListener(event, () => (field.value = 0));
      return { field, name: row.querySelector("span"), text: row.querySelector("i") };
    });
    document.addEventListener("keydown", (event) => this.key(event, true));
    document.addEventListener("keyup", (event) => this.key(event, false));
    window.addEventListener("blur", () => this.keys.clear());
    this.lead("joint");
  }

  lead(kind) {
    this.kind = kind;
    this.sent = "";
    this.rows.forEach(({ name, field }, k) => {
      const lever = LEVERS[kind][k];
      name.textContent = lever.name;
      field.setAttribute("aria-label", `${lever.name}, ${lever.ends[1]} to ${lever.ends[0]}; springs back`);
    });
  }

  key(event, down) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.("select, [type=text], [type=number], textarea")) return;
    if (LEVER_KEYS.flat().includes(event.code)) this.keys[down ? "add" : "delete"](event.code);
  }

  /* Deflections by what is touched most: screen, keys or pad. */
  deflections() {
    const pad = navigator.getGamepads?.().find((p) => p?.connected);
    return this.rows.map(({ field }, k) => {
      const [first, second] = LEVER_KEYS[k].map((key) => Number(this.keys.has(key)));
      const choices = [Number(field.value), first - second, pad ? this.ofPad(pad, PAD[k]) : 0];
      return choices.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a));
    });
  }

  ofPad(pad, { axis, sign, buttons }) {
    // Axes rest where they were at first: not all pads have them at 0.
    if (this.padName !== pad.id) [this.padName, this.rest] = [pad.id, [...pad.axes]];
    const raw = buttons ? (pad.buttons[buttons[0]]?.value ?? 0) - (pad.buttons[buttons[1]]?.value ?? 0) : sign * ((pad.axes[axis] ?? 0) - (this.rest[axis] ?? 0));
    return Math.abs(raw) < DEAD_ZONE ? 0 : Math.sign(raw) * ((Math.abs(raw) - DEAD_ZONE) / (1 - DEAD_ZONE)) ** 1.5;
  }

  /* Reads all levers; called for each picture. */
  poll() {
    const deflections = this.deflections();
    const most = this.rates(this.kind);
    const rates = new Array(6).fill(0);
    deflections.forEach((deflection, k) => {
      const [index, sign] = LEVERS[this.kind][k].at;
      rates[index] = sign * deflection * most[index];
      const { text } = this.rows[k];
      const words = deflection === 0 ? "0" : `${LEVERS[this.kind][k].ends[deflection > 0 ? 0 : 1]} ${Math.round(100 * Math.abs(deflection))} %`;
      if (text.textContent !== words) text.textContent = words;
    });
    const now = rates.join();
    if (now === this.sent || (this.sent === "" && rates.every((rate) => rate === 0))) return;
    this.sent = now;
    this.moved(this.kind, rates);
  }
}
