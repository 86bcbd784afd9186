/*
 * The machine that is driven and its ghosts: the same system under other laws, each in an engine of its own, on the same commands and
 * disturbances. What is told to one is told to all.
 */
import { Engine } from "./engine.js";
import { json } from "./parts.js";

/* Simulated time between two saved states, s, and how many are kept: a little more than ten seconds. */
const SAVE_EVERY = 1;
const SAVES = 12;
/* How far engines that run side by side may be apart, s. */
const LATE = 0.05;

/* Structure of the package for each world, and what an operator calls it. */
export const WORLDS = {
  ideal: { structure: "SystemStructure.ssd", text: "ideal: as the controller plans" },
  real: { structure: "Real.ssd", text: "as built: with play, friction, sensor errors" },
  electric: { structure: "Electric.ssd", text: "fed by a battery" },
};

/* The components that read a machine file, in each world, and what the file is called for them. */
const [READERS, MACHINE] = [["hdrm", "controller", "emla_1", "emla_2", "emla_3"], "machine.json"];

/* What the FMUs are told of a machine that is not the reference machine: as `hdrm-fmu run --machine`. Fed by a battery the actuators are those of the
 * ideal world. */
function ofMachine(world) {
  const { file, settings } = json("scene");
  if (!file) return {};
  const bound = READERS.flatMap((name) => [[`${name}.machine_file`, MACHINE], ...(/^emla_/.test(name) ? [[`${name}.axis`, Number(name.at(-1))]] : [])]);
  return { ...Object.fromEntries(bound), ...settings[world === "real" ? "real" : "ideal"], files: { [MACHINE]: JSON.stringify(file) } };
}

/* Settings in the engine's words. */
export function forEngine({ world = "ideal", trajectory, files, ...rest }) {
  if (!(world in WORLDS)) throw new Error(`world = ${world}: it must be one of ${Object.keys(WORLDS).join(", ")}.`);
  const { files: own, ...machine } = ofMachine(world);
  return { structure: WORLDS[world].structure, ...machine, ...(trajectory && { "controller.trajectory": trajectory }), ...rest, ...((own || files) && { files: { ...own, ...files } }) };
}

export class Ensemble {
  static async begin(parts) {
    return Object.assign(new Ensemble(), { parts, main: await Engine.begin(parts), ghosts: new Map(), saved: [] });
  }

  get all() {
    return [this.main, ...this.ghosts.values()];
  }

  get time() {
    return this.main.time;
  }

  /* Where the engine is that is furthest. */
  get latest() {
    return Math.max(...this.all.map((engine) => engine.time));
  }

  each(act) {
    return Promise.all(this.all.map(act));
  }

  /* All that were paused from the start, with ghosts under these laws, and with changes to come. What the main engine refuses, changes nothing. */
  async restart(settings, laws, changes = []) {
    await this.main.restart(forEngine(settings));
    const before = this.ghosts;
    this.ghosts = new Map();
    for (const [law, ghost] of before) if (!laws.includes(law)) ghost.close();
    const own = (law) => ({ ...settings, "controller.mode": law });
    for (const law of laws) {
      const ghost = before.get(law) ?? (await Engine.open(this.parts));
      await ghost.restart(forEngine(own(law)));
      this.ghosts.set(law, ghost);
    }
    await this.main.plan(changes);
    const shared = changes.filter(({ name }) => name !== "controller.mode");
    await Promise.all([...this.ghosts.values()].map((ghost) => ghost.plan(shared)));
    this.saved = [];
    await this.keep();
  }

  play(speed) {
    this.plays = true;
    return this.each((engine) => engine.play(speed));
  }

  async pause() {
    this.plays = false;
    await this.each((engine) => engine.pause());
    await this.tending;
  }

  /* All to the same time, so long after that of the one that is furthest. */
  async advance(seconds) {
    const goal = this.latest + seconds;
    await this.each((engine) => engine.advance(goal - engine.time));
    await this.keepInTurn();
  }

  /* A ghost keeps its law. The time at which the machine got the value. */
  async set(name, value) {
    await this.main.set(name, value);
    const { time } = this.main;
    if (name !== "controller.mode") await Promise.all([...this.ghosts.values()].map((ghost) => ghost.set(name, value)));
    return time;
  }

  /* A state of all, as { time, ids }. */
  async state() {
    // While it runs the time is known by the answer.
    const saved = await this.each(async (engine) => ({ id: await engine.save(), time: engine.time }));
    return { time: saved[0].time, ids: saved.map(({ id }) => id) };
  }

  async back({ ids }) {
    await Promise.all(this.all.map((engine, k) => engine.restore(ids[k])));
  }

  drop({ ids }) {
    this.all.forEach((engine, k) => ids[k] !== undefined && engine.forget(ids[k]));
  }

  /* Keeps the present state for `undo`. */
  async keep() {
    this.saved.push(await this.state());
    while (this.saved.length > SAVES) this.drop(this.saved.shift());
  }

  /* A state is kept each second. */
  async keepInTurn() {
    if (this.time >= (this.saved.at(-1)?.time ?? -Infinity) + SAVE_EVERY) await this.keep();
  }

  /* While all play, who is late on a busy machine makes up for it. Called for each frame; a run that has ended says so in its frame, and is
   * not tended. Engines that are advanced or go back by command are at different times on their way, and nobody is late. */
  tend() {
    if (this.plays) this.tending ??= this.look().catch(() => {}).finally(() => (this.tending = null));
  }

  async look() {
    const { latest } = this;
    const late = this.all.filter((engine) => latest - engine.time > LATE);
    await Promise.all(late.map((engine) => engine.advance(latest - engine.time)));
    await this.keepInTurn();
  }

  /* To the state of ten seconds ago, or the oldest one kept since; the time that it is of. */
  async undo(seconds = 10) {
    const goal = this.time - seconds;
    const near = this.saved.reduce((best, state) => (Math.abs(state.time - goal) < Math.abs(best.time - goal) ? state : best));
    while (this.saved.at(-1) !== near) this.drop(this.saved.pop());
    await this.back(near);
    return near.time;
  }
}
