/* Follows the values of a run: scopes, the newest values by what they are, ghosts, and when the machine is asked too much. */
import { element, tickBox } from "./page.js";
import { Scope, readable } from "./scopes.js";
import { ACTUATORS, GHOST_SIGNALS, SCOPES, SIGNALS, watched } from "./signals.js";

const SCOPE_SECONDS = 12;
/* How often values of all signals are kept to look back at, s of the run. */
const PAST_EVERY = 0.1;
/* So many moments at most: beyond it every other one of the older half goes. */
const MOST_PAST = 12_000;
/* Colours of the page that ghosts have come after those of the machine. */
const FIRST_GHOST_COLOR = 2;
/* Where a run is lost: the tip this far off, m; a rod with this many times its rated force. */
const LOST_TIP = 0.05;
const LOST_FORCE = 4;
/* A rod swings as studies/experiments/src/measures/swinging.rs has it: force less its moving mean, in the root mean square over a second, at
 * rest for two seconds before, in two seconds in a row. */
const [SWINGS, MEAN, WINDOW, SETTLES, RESTS] = [0.01, 0.25, 1, 2, 1e-4];

export class Monitor {
  /* `machine` has its bodies and rated forces; `alarm(rank, text, kind, time)` is told that it is overloaded (1) or lost (2), as long as it is. */
  constructor(machine, alarm) {
    Object.assign(this, { machine, alarm, scopes: new Map(), chosen: new Set(SCOPES.filter(({ shown }) => shown).map(({ name }) => name)) });
    Object.assign(this, { rests: 0, stage: 0, cause: 0 });
    this.now = (signal) => (this.places[signal] ?? []).map((k) => this.values[k]);
    /* The same of the moment that is looked at. */
    this.seen = (signal) => (this.places[signal] ?? []).map((k) => (this.look ?? this).values[k]);
  }

  /* Another run, of a system with these variables, with ghosts under these laws. */
  restart(variables, laws, settings) {
    const has = (name) => variables.has(name);
    const [own, ghost] = [watched(SIGNALS, has), watched(GHOST_SIGNALS, has)];
    Object.assign(this, { laws, settings, names: own.names, places: own.places, ghostNames: ghost.names, ghostPlaces: ghost.places });
    Object.assign(this, { rests: Infinity, swings: undefined, stage: 0, cause: 0, past: [], look: null });
    [this.ghosts, this.ghostErrors] = [laws.map(() => [NaN]), laws.map(() => NaN)];
    this.scopes.forEach(({ scope }) => scope.remove());
    this.scopes.clear();
    this.makeScopes();
    element("scope-choice").replaceChildren(...this.offered.map(({ name, title }) => tickBox(title, this.chosen.has(name), (on) => {
      this.chosen[on ? "add" : "delete"](name);
      this.makeScopes();
    })));
  }

  /* The scopes that the system has signals for. */
  get offered() {
    return SCOPES.filter(({ signal }) => this.places[signal]);
  }

  ghostColor(k) {
    return getComputedStyle(document.documentElement).getPropertyValue(`--trace-${k + 1 + FIRST_GHOST_COLOR}`).trim();
  }

  /* The scopes that are chosen; those that are there stay. */
  makeScopes() {
    for (const description of this.offered) {
      const { name, title, unit, labels, ghosts, truth } = description;
      if (this.scopes.has(name) === this.chosen.has(name)) continue;
      this.scopes.get(name)?.scope.remove();
      if (this.scopes.delete(name)) continue;
      const scope = new Scope(element("scopes"), { title, unit, length: SCOPE_SECONDS, scrolls: true });
      scope.zoom(this.shown ?? SCOPE_SECONDS);
      scope.zoomed = (length) => {
        this.shown = length;
        this.scopes.forEach((other) => other.scope.zoom(length));
      };
      const traces = labels.map((label) => scope.add(label));
      const beside = ghosts ? this.laws.map((law, k) => scope.add(law, k + FIRST_GHOST_COLOR)) : [];
      const planned = truth ? labels.map((_, k) => scope.add("", k, true)) : [];
      this.scopes.set(name, { description, scope, traces, beside, planned });
    }
  }

  /* Takes a frame of the machine; false for one of other variables. */
  frame({ history, values }) {
    const stride = 1 + this.names.length;
    if (values.length + 1 !== stride) return false;
    this.values = values;
    [[this.stage], [this.cause]] = [this.now("stage"), this.now("cause")];
    const masses = this.trueMasses();
    for (let at = 0; at + stride <= history.length; at += stride) {
      if (history[at] > (this.past.at(-1)?.time ?? -Infinity) + PAST_EVERY - 5e-4) {
        this.past.push({ time: history[at], values: Float32Array.from(history.subarray(at + 1, at + stride)), ghosts: [...this.ghosts], ghostErrors: [...this.ghostErrors] });
        if (this.past.length > MOST_PAST) this.past = this.past.filter((_, k) => k % 2 === 0 || k > MOST_PAST / 2);
      }
      const [t, row] = [history[at], (signal) => this.places[signal].map((k) => history[at + 1 + k])];
      for (const { description, traces, planned } of this.scopes.values()) {
        const { signal, of = (v) => v } = description;
        row(signal).forEach((v, k) => traces[k].push(t, of(v)));
        planned.forEach((trace, k) => trace.push(t, masses[k]));
      }
      this.judge(t, row("force"), row("error")[0]);
      this.watchSwings(t, row("force"), [...row("desired"), ...row("aim")]);
    }
    return true;
  }

  ghostFrame({ values, history }, k) {
    const stride = 1 + this.ghostNames.length;
    const [error] = this.ghostPlaces.error;
    const trace = this.scopes.get("error")?.beside[k];
    for (let at = 0; trace && at + stride <= history.length; at += stride) trace.push(history[at], 1000 * history[at + 1 + error]);
    this.ghosts[k] = this.ghostPlaces.zeta.map((j) => values[j]);
    this.ghostErrors[k] = values[error];
  }

  /* Masses of the bodies that the machine has, beside those that the controller estimates. */
  trueMasses() {
    const scale = Number(this.settings["hdrm.inertia_scale"] ?? 1);
    const payload = this.settings["hdrm.payload.mass"];
    const of = (name) => (name === "PL" && payload !== undefined ? Number(payload) : this.machine.bodies.find((body) => body.name === name).mass);
    return SIGNALS.masses.map((name) => scale * of(name.split(".").at(-1)));
  }

  judge(t, forces, error) {
    const shares = forces.map((force, k) => Math.abs(force) / this.machine.rated[k]);
    const share = Math.max(...shares);
    if (share <= 1 && error < LOST_TIP) return;
    const rod = shares.indexOf(share);
    const text = `the ${ACTUATORS[rod].toLowerCase()} rod had ${readable(forces[rod] / 1000)} kN, ${share.toFixed(1)} times what it is rated for.`;
    if (share >= LOST_FORCE) this.alarm(2, `The machine would have broken at ${t.toFixed(2)} s: ${text}`, "broken", t);
    else if (error >= LOST_TIP) this.alarm(2, `The controller lost the machine at ${t.toFixed(2)} s: the tip was ${(1000 * error).toFixed(0)} mm off.`, "lost", t);
    else this.alarm(1, `Overloaded at ${t.toFixed(2)} s: ${text}`, "overload", t);
  }

  /* Closes a window each second, and names a rod that swung in two in a row. */
  watchSwings(t, forces, reference) {
    const parts = forces.map((force, k) => force / this.machine.rated[k]);
    const restart = () => ({ t, start: t, rests: t, reference, mean: parts, squares: parts.map(() => 0), windows: parts.map(() => 0) });
    if (!(this.swings?.t < t)) this.swings = restart();
    const its = this.swings;
    const dt = t - its.t;
    its.t = t;
    if (reference.some((value, k) => Math.abs(value - its.reference[k]) > RESTS)) Object.assign(its, { reference, rests: t });
    this.rests = its.rests;
    its.mean = its.mean.map((mean, k) => mean + Math.min(dt / MEAN, 1) * (parts[k] - mean));
    its.squares = its.squares.map((sum, k) => sum + (parts[k] - its.mean[k]) ** 2 * dt);
    const window = t - its.start;
    if (window <= WINDOW - dt / 2) return;
    const settled = its.start - its.rests > SETTLES - dt / 2;
    its.squares.forEach((sum, k) => {
      const share = Math.sqrt(sum / window);
      its.windows[k] = settled && share > SWINGS ? its.windows[k] + 1 : 0;
      if (its.windows[k] > 1) this.alarm(1.5, `The ${ACTUATORS[k].toLowerCase()} rod swings since ${(its.start - WINDOW).toFixed(2)} s, by ${(100 * share).toFixed(1)} % of its rated force at rest.`, "swing", t);
    });
    Object.assign(its, { start: t, squares: parts.map(() => 0) });
  }

  /* One scope a picture, in turn: three of them at a third of the rate are faster than one reads. */
  draw(present) {
    const time = this.look ? Math.min(present, Math.max(this.look.time + 0.5 * (this.shown ?? SCOPE_SECONDS), this.shown ?? SCOPE_SECONDS)) : present;
    const next = [...this.scopes].find(([, { scope }]) => scope.end !== time);
    if (!next) return;
    this.scopes.delete(next[0]);
    this.scopes.set(...next);
    next[1].scope.draw(time);
  }

  /* After a jump back to `time`. */
  cut(time) {
    this.past = this.past.filter((moment) => moment.time <= time + 1e-9);
    this.scopes.forEach(({ scope }) => scope.cut(time));
  }

  /* Looks at the kept moment that is nearest to the time, or again at the present one. */
  lookAt(time) {
    const near = (best, moment) => (Math.abs(moment.time - time) < Math.abs(best.time - time) ? moment : best);
    this.look = time === null || !this.past.length ? null : this.past.reduce(near);
    this.scopes.forEach(({ scope }) => Object.assign(scope, { cursor: this.look?.time, end: NaN }));
    return this.look;
  }

  theme() {
    this.scopes.forEach(({ scope }) => scope.theme());
  }
}
