/*
 * Levers: on the screen, by keys, by gamepads or joysticks. Each is between −1 and 1 and springs back. What they lead, the joints or the tip,
 * is up to the page, which is told the commands as rates.
 */

import { html } from "./page.js";

/* The levers in the order of the screen: names of both ends, keys of the two directions, and what of the rates they are. Positive is the first end. */
export const LEVERS = {
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
/* Axes and pairs of buttons of the first device, for each lever; the sign makes the first end positive. A second one is a stick for the right
 * hand. */
const PAD = [{ axis: 0, sign: 1 }, { axis: 1, sign: -1 }, { axis: 3, sign: -1 }, { buttons: [5, 4] }, { buttons: [12, 13] }, { axis: 2, sign: -1 }];
const SECOND_PAD = [null, null, { axis: 1, sign: -1 }, null, null, { axis: 0, sign: -1 }];
const DEAD_ZONE = 0.12;
/* How long an axis stands still until that is its rest, ms; and from what deflection on it is the one that is meant for a lever. */
const RESTS_AFTER = 1000;
const MEANT = 0.6;
const KEPT = "machine-page.joysticks";

/* Where an axis rests. Browsers show a device once it is moved, so its first reading is not the rest: that is 0, unless the axis stands
 * still elsewhere. Until that is known, and whenever a rest elsewhere comes into doubt since the axis passes 0, it commands nothing. */
class Axis {
  constructor(value, now) {
    Object.assign(this, { rest: 0, known: Math.abs(value) < DEAD_ZONE, value, since: now });
  }

  read(value, now) {
    const isMoved = Math.abs(value - this.value) > 0.02;
    if (isMoved) Object.assign(this, { value, since: now });
    const stands = now - this.since > RESTS_AFTER;
    const isAtZero = Math.abs(value) < DEAD_ZONE;
    if (!this.known) {
      if (isMoved || isAtZero) Object.assign(this, { known: true, rest: 0 });
      else if (stands) Object.assign(this, { known: true, rest: value });
    } else if (this.rest !== 0 && isAtZero) {
      if (stands) this.rest = 0;
      return 0;
    }
    return this.known ? Math.min(Math.max(value - this.rest, -1), 1) : 0;
  }
}

export class Levers {
  /* `rates(kind)` gives the largest rates; `moved(kind, rates)` is told new ones, `told(text)` what happens to joysticks. */
  constructor(parent, rates, moved, told) {
    Object.assign(this, { rates, moved, told, kind: "joint", keys: new Set(), sent: "", pads: new Map(), axes: new Map(), learns: null, atEnd: [] });
    this.own = this.kept();
    this.rows = LEVER_KEYS.map((keys) => {
      const row = html`<label class="lever"><b><span></span><i>0</i></b><kbd title="key"></kbd><input type="range" min="-1" max="1" step="0.01" value="0"><kbd title="key"></kbd></label>`;
      parent.append(row);
      const field = row.querySelector("input");
      // Let go, it springs back: by pointer, by keys, and when the focus leaves.
      for (const event of ["pointerup", "pointercancel", "keyup", "blur"]) field.addEventListener(event, () => (field.value = 0));
      // A pointer that lets go gives the keys back to the view.
      field.addEventListener("pointerup", () => field.blur());
      const [less, more] = row.querySelectorAll("kbd");
      return { row, field, name: row.querySelector("span"), text: row.querySelector("i"), caps: [[more, keys[0]], [less, keys[1]]] };
    });
    document.addEventListener("keydown", (event) => this.key(event, true));
    document.addEventListener("keyup", (event) => this.key(event, false));
    window.addEventListener("blur", () => this.keys.clear());
    this.letters = new Map();
    this.relabel();
    navigator.keyboard?.getLayoutMap?.().then((layout) => {
      layout.forEach((letter, code) => this.letters.set(code, letter.toUpperCase()));
      this.relabel();
    }, () => {});
    this.lead("joint");
  }

  /* What is printed on the key of that place. */
  letter(code) {
    return this.letters.get(code) ?? code.replace("Key", "");
  }

  relabel() {
    this.rows.forEach(({ caps }) => caps.forEach(([cap, code]) => (cap.textContent = this.letter(code))));
    this.relabelled?.();
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
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.("[type=text], [type=number], textarea")) return;
    if (/^Key[A-Z]$/.test(event.code) && /^\p{L}$/u.test(event.key ?? "") && this.letter(event.code) !== event.key.toUpperCase()) {
      // Where the browser does not tell the layout, the keys do.
      this.letters.set(event.code, event.key.toUpperCase());
      this.relabel();
    }
    if (!LEVER_KEYS.flat().includes(event.code)) return;
    this.keys[down ? "add" : "delete"](event.code);
    // A list that has the focus would choose the entry of that letter.
    if (event.target.closest?.("select")) event.preventDefault();
  }

  /* Deflections by what is touched most: screen, keys or joysticks. */
  deflections() {
    const sticks = this.joysticks();
    return this.rows.map(({ field }, k) => {
      const [first, second] = LEVER_KEYS[k].map((key) => Number(this.keys.has(key)));
      return [Number(field.value), first - second, sticks[k]].reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a));
    });
  }

  /* What all joysticks say of each lever. */
  joysticks() {
    const now = performance.now();
    const here = [...(navigator.getGamepads?.() ?? [])].filter((pad) => pad?.connected);
    const keys = here.map((pad) => `${pad.index ?? 0} ${pad.id}`);
    for (const key of [...this.pads.keys()].filter((known) => !keys.includes(known))) {
      this.told(`Joystick unplugged: ${this.pads.get(key)}. Its levers are at rest.`);
      this.pads.delete(key);
      [...this.axes.keys()].filter((axis) => axis.startsWith(`${key}:`)).forEach((axis) => this.axes.delete(axis));
    }
    const readings = here.map((pad, k) => {
      if (!this.pads.has(keys[k])) {
        this.pads.set(keys[k], pad.id);
        this.told(`Joystick: ${pad.id}.`);
      }
      const axes = pad.axes.map((value, axis) => {
        const key = `${keys[k]}:${axis}`;
        if (!this.axes.has(key)) this.axes.set(key, new Axis(value, now));
        return this.axes.get(key).read(value, now);
      });
      return { pad, place: k, axes, buttons: pad.buttons.map((button) => button?.value ?? 0) };
    });
    this.learn(readings);
    return LEVER_KEYS.map((_, k) => {
      const values = readings.map((reading) => this.ofPad(reading, this.sourceOf(reading, k)));
      return values.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a), 0);
    });
  }

  /* What of a device leads a lever: what was chosen for it, else as usual. */
  sourceOf({ pad, place }, k) {
    const own = this.own[k];
    if (own) return own.pad === pad.id ? own : null;
    return [PAD, SECOND_PAD][place]?.[k] ?? null;
  }

  ofPad({ axes, buttons }, source) {
    if (!source) return 0;
    const raw = source.buttons ? (buttons[source.buttons[0]] ?? 0) - (buttons[source.buttons[1]] ?? 0) : source.sign * (axes[source.axis] ?? 0);
    return Math.abs(raw) < DEAD_ZONE ? 0 : Math.sign(raw) * ((Math.abs(raw) - DEAD_ZONE) / (1 - DEAD_ZONE)) ** 1.5;
  }

  /* The next axis that is moved far leads the lever that waits for one; the way it is moved is its first end. */
  learn(readings) {
    if (this.learns === null) return;
    for (const { pad, axes } of readings) {
      const axis = axes.findIndex((value) => Math.abs(value) > MEANT);
      if (axis < 0) continue;
      this.own[this.learns] = { pad: pad.id, axis, sign: Math.sign(axes[axis]) };
      this.learns = null;
      this.keep();
      return;
    }
  }

  /* Where each lever's command comes from, in words. */
  sources() {
    const names = [...this.pads.values()];
    return LEVERS[this.kind].map(({ name, ends }, k) => {
      if (this.learns === k) return { name, text: `move the axis towards “${ends[0]}”…` };
      const words = ({ axis, buttons }) => (buttons ? `buttons ${buttons.map((b) => b + 1).join(" and ")}` : `axis ${axis + 1}`);
      const own = this.own[k];
      const usual = names.map((_, place) => [PAD, SECOND_PAD][place]?.[k] && `${words([PAD, SECOND_PAD][place][k])}${names.length > 1 ? ` of device ${place + 1}` : ""}`);
      const place = names.indexOf(own?.pad);
      return { name, text: own ? `${words(own)}${place >= 0 && names.length > 1 ? ` of device ${place + 1}` : ""}${place < 0 ? ` of ${own.pad}` : ""}` : usual.filter(Boolean).join(", ") || "none" };
    });
  }

  /* A browser may refuse to keep it for a page of a folder: then it holds until the page is closed. */
  keep() {
    try {
      localStorage.setItem(KEPT, JSON.stringify(this.own));
    } catch { /* It holds until then. */ }
    this.told("");
  }

  kept() {
    try {
      const own = JSON.parse(localStorage.getItem(KEPT) ?? "[]");
      return Array.isArray(own) ? own : [];
    } catch {
      return [];
    }
  }

  forget() {
    this.own = [];
    this.keep();
  }

  /* Reads all levers; called for each picture. */
  poll() {
    const deflections = this.deflections();
    const most = this.rates(this.kind);
    const rates = new Array(6).fill(0);
    deflections.forEach((deflection, k) => {
      const [index, sign] = LEVERS[this.kind][k].at;
      rates[index] = sign * deflection * most[index];
      const { text, row } = this.rows[k];
      // Which end of travel the joint is at, +1 or −1, counts for the lever's own direction.
      const end = this.kind === "joint" ? sign * (this.atEnd[index] ?? 0) : 0;
      const words = end !== 0 ? `end of travel ${LEVERS.joint[k].ends[end > 0 ? 0 : 1]}` : deflection === 0 ? "0" : `${LEVERS[this.kind][k].ends[deflection > 0 ? 0 : 1]} ${Math.round(100 * Math.abs(deflection))} %`;
      if (text.textContent !== words) text.textContent = words;
      row.classList.toggle("at-end", end !== 0);
    });
    const now = rates.join();
    if (now === this.sent || (this.sent === "" && rates.every((rate) => rate === 0))) return;
    this.sent = now;
    this.moved(this.kind, rates);
  }
}
