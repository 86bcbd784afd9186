/* A coupled system that runs in a worker: `Engine.open`, then `restart`, and the rest. Every command is a promise, which rejects with the
 * master's message; values pass at communication points. The text of `worker.js` comes in `parts.worker`, else in the page's element
 * `part-worker`, because a page that was opened from a folder may start no worker from another file. */

export class Engine {
  #worker;
  #waiting = new Map();
  #next = 1;
  /* Of the last answer or frame, s. */
  time = NaN;
  /* Called with {time, values, history, factor, share, error} up to 60 times a second; less often where that takes long. */
  onframe = null;
  /* Of what runs: name, structures, parameters, components, start, stop, step. */
  about = null;
  /* A promise: the archive has been opened. */
  opened = null;

  /* Begin to open a packed system or an FMU: engine is the master's module, system the archive, each as bytes or as the text that a page
   * carries. Commands may follow at once; they wait for their turn. */
  static async begin({ engine, system, worker = document.getElementById("part-worker").textContent }) {
    const own = new Engine();
    own.#worker = await started(worker);
    own.#worker.onmessage = (message) => own.#receive(message);
    own.#worker.onerror = (error) => own.#fail(new Error(error.message ?? String(error)));
    own.opened = own.#ask("open", { engine, system });
    return own;
  }

  /* The same, opened. */
  static async open(parts) {
    const own = await Engine.begin(parts);
    try {
      await own.opened;
    } catch (error) {
      own.close();
      throw error;
    }
    return own;
  }

  #receive({ id, ok, error, time, frame }) {
    this.time = frame?.time ?? time ?? this.time;
    if (frame) {
      try {
        this.onframe?.(frame);
      } finally {
        this.#worker.postMessage({ seen: true });
      }
      return;
    }
    const { resolve, reject } = this.#waiting.get(id);
    this.#waiting.delete(id);
    if (error === undefined) resolve(ok);
    else reject(new Error(error));
  }

  #fail(error) {
    for (const { reject } of this.#waiting.values()) reject(error);
    this.#waiting.clear();
  }

  #ask(command, its = {}) {
    return new Promise((resolve, reject) => {
      const id = this.#next++;
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ id, command, its });
    });
  }

  /* Start anew. Settings: start values by names of variables; `structure` (a .ssd of the package), `parameters` (a .ssv or several, applied in
   * this order), `schedule`, `step` (s), `files` ({path: text or bytes} for parameters that name files). The run before goes on where this
   * is refused. */
  async restart(settings = {}) {
    this.about = await this.#ask("restart", { settings });
    return this.about;
  }

  /* What else it does, and what each takes: `advance` so many seconds, as fast as it goes; `play` in step with the wall clock, so many times as
   * fast; `get` the present value of a variable (a number, true or false, a text) and `set` an input that nothing drives, or a tunable
   * parameter (others are refused with the reason; "override:VALUE" replaces what a connection gives an input, "override:" ends that); `driver` names the output that a connection gives an input its value from, or null; `watch` says which values the frames carry from now on; `save` the state of the whole,
   * which gives its number. `variables` gives name, description, causality, variability, type, unit, displayUnit, start, min, max, items of
   * all; `verdict` {bad, text, findings: [{text, bad}]} of the run so far; `memory` that of engine and all instances of FMUs, bytes; `plan` makes
   * changes, each {time, name, value}, when the run that has started gets there. */
  static {
    const commands = {
      advance: ["seconds"], play: ["speed"], pause: [], get: ["name"], driver: ["name"], set: ["name", "value"], watch: ["names"],
      save: [], restore: ["id"], forget: ["id"], variables: [], verdict: [], memory: [],
      plan: ["changes"] };
    for (const [command, names] of Object.entries(commands)) {
      this.prototype[command] = function (...values) {
        return this.#ask(command, Object.fromEntries(names.map((name, k) => [name, values[k]])));
      };
    }
  }

  /* End the worker. */
  close() {
    this.#fail(new Error("the engine is closed"));
    return this.#worker.terminate();
  }
}

/* A worker with this source, of a page or of Node, once it runs: a browser starts none while its page is busy. */
async function started(source) {
  if (globalThis.Worker) {
    const address = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
    const worker = new Worker(address);
    await new Promise((runs, fails) => Object.assign(worker, { onmessage: runs, onerror: ({ message }) => fails(new Error(message ?? "the browser starts no worker")) }));
    const own = { postMessage: (message) => worker.postMessage(message), terminate: () => worker.terminate() };
    worker.onmessage = ({ data }) => own.onmessage(data);
    worker.onerror = (error) => own.onerror(error);
    URL.revokeObjectURL(address);
    return own;
  }
  const { Worker: Thread } = await import("node:worker_threads");
  const thread = new Thread(source, { eval: true });
  const own = { postMessage: (message) => thread.postMessage(message), terminate: () => thread.terminate() };
  thread.on("message", (message) => own.onmessage(message));
  thread.on("error", (error) => own.onerror(error));
  return own;
}
