/* The page of an FMU or an SSP package with WebAssembly: inputs, parameters, runs over one another. `window.machine` is the page for scripts. */
import { Engine } from "./engine.js";
import { archive, download, part, textOf } from "./parts.js";
import { Recorder } from "./records.js";
import { Scope } from "./scopes.js";
import { addressOf, elements, settingsOf } from "./variables.js";

const element = (id) => document.getElementById(id);
const WASM = /^binaries\/wasm32[^/]*\/.*\.wasm$/;
/* Plots that are shown at first. */
const FIRST_PLOTS = 6;
/* Pieces in which a run is made: so often its curves grow. */
const PIECES = 40;
/* Points of a signal over a run at most; between them an input is held. */
const SIGNAL_POINTS = 2000;

/* Signals that an input can have over time: names of their numbers, and the value at t. */
const SIGNALS = {
  constant: { numbers: [], at: (t, _, value) => value },
  step: { numbers: ["to", "at s"], start: [1, 1], at: (t, [to, when], value) => (t >= when ? to : value) },
  sine: { numbers: ["amplitude", "Hz"], start: [1, 1], at: (t, [amplitude, hertz], value) => value + amplitude * Math.sin(2 * Math.PI * hertz * t) },
  file: { numbers: [], at: (t, _, value, column) => (column ? between(column, t) : value) },
};

/* The column's value at t, straight between its rows. */
function between({ times, values }, t) {
  const k = times.findIndex((time) => time > t);
  if (k < 0) return values.at(-1);
  if (k === 0) return values[0];
  return values[k - 1] + ((t - times[k - 1]) / (times[k] - times[k - 1])) * (values[k] - values[k - 1]);
}

/* Columns of a CSV file by name; the first one is the time. */
function columnsOf(text) {
  const lines = text.replace("\ufeff", "").split(/\r?\n/).filter((line) => line.trim() && !line.startsWith("#"));
  const names = lines[0].split(",").map((name) => name.trim().replace(/^"|"$/g, ""));
  const rows = lines.slice(1).map((line) => line.split(",").map(Number));
  const wrong = rows.findIndex((row) => row.length !== names.length || row.some((v) => !Number.isFinite(v)));
  if (names[0] !== "time" || !rows.length) throw new Error("A CSV file needs a first column `time`, names in its first line, and rows of numbers.");
  if (wrong >= 0) throw new Error(`Row ${wrong + 2} of the CSV file must have ${names.length} numbers: ${lines[wrong + 1]}`);
  const times = rows.map((row) => row[0]);
  return new Map(names.slice(1).map((name, k) => [name, { times, values: rows.map((row) => row[k + 1]) }]));
}

/* FMUs of an archive by name, as archives themselves; what is no FMU or SSP, or lacks WebAssembly, is refused with the reason. */
async function fmusOf(name, bytes) {
  const files = archive(bytes);
  const fmus = new Map();
  if (files.has("modelDescription.xml")) fmus.set(name, files);
  else if (files.has("SystemStructure.ssd")) {
    for (const [path, read] of files) if (path.endsWith(".fmu")) fmus.set(path.split("/").at(-1), archive(await read()));
  } else throw new Error(`${name} is neither an FMU nor an SSP: it holds no modelDescription.xml and no SystemStructure.ssd.`);
  for (const [fmu, inside] of fmus) {
    const paths = [...inside.keys()];
    if (paths.some((path) => WASM.test(path))) continue;
    const platforms = [...new Set(paths.filter((path) => /^binaries\/[^/]+\/./.test(path)).map((path) => path.split("/")[1]))];
    throw new Error(`${fmu} has no WebAssembly, so no page can run it: it holds ${platforms.length ? `libraries for ${platforms.join(", ")}` : "no libraries at all"}. ` +
      "Whoever has its sources in Rust adds it with `cargo fmu pack --target wasm`.");
  }
  return fmus;
}

class ModelPage {
  constructor() {
    Object.assign(this, { runs: [], scopes: new Map(), columns: new Map(), values: {}, signals: new Map() });
    this.buttons();
  }

  async open() {
    this.engineBytes = await part("engine");
    const system = await part("system");
    if (system) await this.load(document.title, system, settingsOf(location.hash).settings);
    else this.say("Drop an FMU or SSP with WebAssembly onto this page.");
  }

  /* Another model in the place of this one. */
  async load(name, bytes, settings = {}) {
    const fmus = await fmusOf(name, bytes);
    const engine = await Engine.open({ engine: this.engineBytes, system: bytes });
    this.engine?.close();
    Object.assign(this, { engine, fmus, runs: [], values: settings, signals: new Map() });
    element("title").textContent = document.title = name.replace(/\.(fmu|ssp)$/, "");
    await engine.restart(settings);
    this.variables = elements(await engine.variables());
    element("stop").value = engine.about.stop;
    element("step").value = engine.about.step;
    this.say("");
    this.fields();
    this.table();
    await this.documents();
    await this.run();
  }

  say(text) {
    element("message").textContent = text;
    element("message").hidden = !text;
  }

  async attempt(act) {
    try {
      await act();
    } catch (error) {
      this.say(error.message);
    }
  }

  /* A name without its component, where there is one component. */
  short(name) {
    const components = new Set(this.variables.map((variable) => variable.name.split(".")[0]));
    return components.size === 1 ? name.slice(name.indexOf(".") + 1) : name;
  }

  of(causality) {
    return this.variables.filter((variable) => variable.causality === causality && variable.type !== "Clock" && variable.type !== "Binary");
  }

  fields() {
    for (const [id, causality] of [["inputs", "input"], ["parameters", "parameter"]]) {
      const sheet = element(id);
      sheet.querySelectorAll(".row").forEach((row) => row.remove());
      const variables = this.of(causality);
      sheet.hidden = variables.length === 0;
      variables.forEach((variable) => sheet.append(this.field(variable)));
    }
    const plotted = [...this.of("output"), ...this.variables.filter((v) => v.causality === "local")].filter((v) => v.type !== "String");
    this.plotted = new Set(plotted.slice(0, FIRST_PLOTS).map((variable) => variable.name));
    element("shown").querySelectorAll("label").forEach((row) => row.remove());
    for (const { name, description } of plotted) {
      const label = document.createElement("label");
      label.className = "row";
      label.title = description ?? "";
      label.append(this.short(name), Object.assign(document.createElement("input"), { type: "checkbox", checked: this.plotted.has(name) }));
      label.lastChild.addEventListener("change", () => {
        this.plotted[label.lastChild.checked ? "add" : "delete"](name);
        this.plots();
      });
      element("shown").append(label);
    }
  }

  /* A row for an input or a parameter: a slider where it has bounds, and the signal of an input. */
  field(variable) {
    const { name, unit, description, type, items, causality } = variable;
    const start = this.values[name] ?? variable.start;
    const row = document.createElement("div");
    row.className = "row";
    const label = document.createElement("label");
    label.textContent = `${this.short(name)}${unit && unit !== "1" ? `, ${unit}` : ""}`;
    label.title = description ?? "";
    let field;
    if (items?.length) {
      field = document.createElement("select");
      items.forEach((item) => field.add(new Option(item.name)));
      field.value = items.find((item) => item.value === start)?.name ?? start;
    } else {
      const kind = type === "Boolean" ? "checkbox" : type === "String" ? "text" : "number";
      field = Object.assign(document.createElement("input"), { type: kind, step: "any", value: start ?? 0 });
      if (kind === "checkbox") field.checked = start === true || start === "true";
      if (Number.isFinite(variable.min)) field.min = variable.min;
      if (Number.isFinite(variable.max)) field.max = variable.max;
    }
    field.id = `field ${name}`;
    label.htmlFor = field.id;
    const value = () => (field.type === "checkbox" ? field.checked : field.type === "number" ? Number(field.value) : field.value);
    const changed = () => {
      if (!field.reportValidity()) return;
      this.values[name] = value();
      if (this.live && (causality === "input" || variable.variability === "tunable")) this.attempt(() => this.engine.set(name, value()));
      history.replaceState(null, "", addressOf(this.values));
    };
    field.addEventListener("change", changed);
    row.append(label, field);
    if (field.type === "number" && field.min !== "" && field.max !== "" && field.max - field.min < 1e5) row.append(this.slider(field, changed));
    if (causality === "input" && field.type === "number") row.append(this.signal(name));
    return row;
  }

  slider(field, changed) {
    const slider = Object.assign(document.createElement("input"), { type: "range", min: field.min, max: field.max, step: (field.max - field.min) / 200, value: field.value });
    slider.setAttribute("aria-label", `${field.id} as a slider`);
    slider.addEventListener("input", () => {
      field.value = slider.value;
      changed();
    });
    field.addEventListener("change", () => (slider.value = field.value));
    return slider;
  }

  /* What an input does over time. */
  signal(name) {
    const box = document.createElement("span");
    box.className = "signal";
    const select = document.createElement("select");
    select.setAttribute("aria-label", `${name} over time`);
    Object.keys(SIGNALS).forEach((kind) => select.add(new Option(kind)));
    box.append(select);
    const chosen = { kind: "constant", numbers: [] };
    this.signals.set(name, Object.assign(chosen, { select }));
    select.addEventListener("change", () => {
      chosen.kind = select.value;
      const { numbers, start = [] } = SIGNALS[chosen.kind];
      chosen.numbers = [...start];
      const fields = numbers.map((text, k) => {
        const label = document.createElement("label");
        const field = Object.assign(document.createElement("input"), { type: "number", step: "any", value: start[k], className: "short" });
        field.addEventListener("change", () => (chosen.numbers[k] = Number(field.value)));
        label.append(`${text} `, field);
        return label;
      });
      box.replaceChildren(select, ...fields);
    });
    return box;
  }

  /* The inputs that change over time, with their values at t. */
  driven(t) {
    const moving = [...this.signals].filter(([, { kind }]) => kind !== "constant");
    return moving.map(([name, { kind, numbers }]) => {
      const value = Number(this.values[name] ?? this.variables.find((v) => v.name === name).start ?? 0);
      return [name, SIGNALS[kind].at(t, numbers, value, this.columns.get(name) ?? this.columns.get(this.short(name)))];
    });
  }

  async run() {
    const [stop, step] = [Number(element("stop").value), Number(element("step").value)];
    if (!(stop > 0 && step > 0)) throw new Error("Stop time and step must be greater than 0.");
    this.say("");
    const ticket = (this.ticket = {});
    this.engine.pause();
    await this.engine.restart({ ...this.values, ...Object.fromEntries(this.driven(0)), step });
    if (!element("over").checked) this.runs = [];
    const names = [...this.of("output"), ...this.variables.filter((v) => v.causality === "local"), ...this.of("input")].filter((v) => v.type !== "String").map((v) => v.name);
    const run = Object.assign(new Recorder(), { on: true, title: `run ${(this.runs.at(-1)?.number ?? 0) + 1}`, number: (this.runs.at(-1)?.number ?? 0) + 1 });
    run.restart(names);
    this.runs.push(run);
    this.plots();
    this.engine.onframe = (frame) => ticket === this.ticket && this.frame(run, frame);
    this.engine.watch(names);
    this.live = element("pace").value === "live";
    await (this.live ? this.inRealTime(ticket, stop) : this.atOnce(ticket, stop, step));
    if (ticket !== this.ticket) return;
    this.scopes.forEach((scope) => scope.draw(stop));
    const verdict = await this.engine.verdict();
    element("verdict").textContent = verdict.bad ? "bad" : "good";
    element("verdict").className = verdict.bad ? "bad" : "good";
    element("verdict").title = verdict.text;
    element("csv").disabled = false;
  }

  /* As fast as it goes, in pieces; where inputs move, they are set anew for each. */
  async atOnce(ticket, stop, step) {
    const moving = this.driven(0).length > 0;
    const steps = Math.round(stop / step);
    const piece = moving ? Math.max(1, Math.round(steps / SIGNAL_POINTS)) : Math.max(1, Math.ceil(steps / PIECES));
    for (let k = 0; k < steps && ticket === this.ticket; k += piece) {
      for (const [name, value] of this.driven(k * step)) await this.engine.set(name, value);
      await this.engine.advance(Math.min(piece, steps - k) * step);
    }
  }

  async inRealTime(ticket, stop) {
    this.engine.play(1);
    while (ticket === this.ticket && this.engine.time < stop) {
      await new Promise((done) => setTimeout(done, 20));
      for (const [name, value] of this.driven(this.engine.time)) await this.engine.set(name, value);
    }
    if (ticket === this.ticket) await this.engine.pause();
    this.live = false;
  }

  frame(run, { time, history, factor }) {
    const stride = 1 + run.names.length;
    run.add(history, stride);
    this.draw(run, history);
    element("clock").textContent = `${Number(time.toPrecision(6))} s`;
    if (factor) element("factor").textContent = `${factor.toPrecision(3)} ×`;
    const now = performance.now();
    if (now - (this.drawn ?? 0) < 50) return;
    this.drawn = now;
    this.scopes.forEach((scope) => scope.draw(time));
  }

  draw(run, rows) {
    const stride = 1 + run.names.length;
    for (const [name, scope] of this.scopes) {
      const [column, trace] = [1 + run.names.indexOf(name), scope.traces[this.runs.indexOf(run)]];
      for (let at = 0; column > 0 && trace && at + stride <= rows.length; at += stride) trace.push(rows[at], rows[at + column]);
    }
  }

  /* All plots anew, with all runs. */
  plots() {
    this.scopes.forEach((scope) => scope.remove());
    this.scopes = new Map([...this.plotted].map((name) => {
      const { unit } = this.variables.find((variable) => variable.name === name);
      const scope = new Scope(element("scopes"), { title: this.short(name), unit: unit === "1" ? "" : unit, length: Number(element("stop").value), scrolls: false });
      this.runs.forEach((run) => scope.add(this.runs.length > 1 ? run.title : "", run.number - 1));
      return [name, scope];
    }));
    for (const run of this.runs) for (const rows of run.chunks) this.draw(run, rows);
    this.scopes.forEach((scope) => scope.draw(0));
  }

  table() {
    const columns = ["name", "causality", "variability", "type", "unit", "start", "min", "max", "description"];
    const wanted = element("find").value.toLowerCase();
    const found = this.variables.filter((v) => `${v.name} ${v.description ?? ""}`.toLowerCase().includes(wanted));
    const cell = (tag, text) => Object.assign(document.createElement(tag), { textContent: text ?? "" });
    const rows = [columns.map((name) => cell("th", name)), ...found.map((v) => columns.map((name) => cell("td", v[name])))];
    element("variables").querySelector("table").replaceChildren(...rows.map((cells) => {
      const row = document.createElement("tr");
      row.append(...cells);
      return row;
    }));
  }

  async documents() {
    const select = element("document");
    select.replaceChildren(...[...this.fmus.keys()].map((name) => new Option(name)));
    select.parentElement.hidden = this.fmus.size < 2;
    const show = async () => {
      const text = await textOf(this.fmus.get(select.value), "documentation/index.html");
      element("documentation").querySelector("iframe").srcdoc = text ?? "<p>This FMU brings no documentation.</p>";
    };
    select.onchange = () => this.attempt(show);
    await show();
  }

  /* A file: another model, or columns for the inputs. */
  async read(file) {
    if (!file.name.endsWith(".csv")) return this.load(file.name, new Uint8Array(await file.arrayBuffer()));
    this.columns = columnsOf(await file.text());
    const driven = [...this.signals].filter(([name]) => this.columns.has(name) || this.columns.has(this.short(name)));
    if (!driven.length) throw new Error(`No column of ${file.name} is named as an input: ${[...this.columns.keys()].join(", ")}.`);
    for (const [, { select }] of driven) {
      select.value = "file";
      select.dispatchEvent(new Event("change"));
    }
    await this.run();
  }

  buttons() {
    const on = (id, act, event = "click") => element(id).addEventListener(event, () => this.attempt(act));
    on("run", () => this.run());
    on("clear", () => { this.runs = []; this.plots(); });
    on("csv", () => download(`${document.title}.csv`, this.runs.at(-1).csv(), "text/csv"));
    on("open", () => element("file").click());
    on("file", () => element("file").files[0] && this.read(element("file").files[0]), "change");
    on("find", () => this.table(), "input");
    document.body.dataset.drop = "An FMU or SSP with WebAssembly, or a CSV file for the inputs";
    for (const kind of ["dragover", "dragleave", "drop"]) {
      document.addEventListener(kind, (event) => {
        event.preventDefault();
        document.body.classList.toggle("dropping", kind === "dragover");
        if (kind === "drop" && event.dataTransfer.files[0]) this.attempt(() => this.read(event.dataTransfer.files[0]));
      });
    }
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.scopes.forEach((scope) => scope.theme()));
  }
}

const page = new ModelPage();
const ready = page.open();
ready.catch((error) => page.say(`This model cannot be started: ${error.message}`));
window.machine = {
  ready,
  restart: (settings) => page.engine.restart(settings),
  play: () => page.engine.play(1),
  pause: () => page.engine.pause(),
  advance: (seconds) => page.engine.advance(seconds),
  get: (name) => page.engine.get(name),
  set: (name, value) => page.engine.set(name, value),
  get time() {
    return page.engine.time;
  },
  verdict: () => page.engine.verdict(),
};
