/* The page of an FMU or an SSP package with WebAssembly: inputs, parameters, runs over one another. */
import { Engine } from "./engine.js";
import { Page, element, html, scripted, tickBox } from "./page.js";
import { archive, download, part, textOf, unpacked } from "./parts.js";
import { Recorder, cells } from "./records.js";
import { Scope } from "./scopes.js";
import { addressOf, copied, displayOf, elements, settingsOf } from "./variables.js";

const WASM = /^binaries\/wasm32[^/]*\/.*\.wasm$/;
/* Plots that are shown at first. */
const FIRST_PLOTS = 6;
/* Pieces in which a run is made: so often its curves grow. Where inputs move there are more of them; in each one they are held. */
const PIECES = 40;
const MOVING_PIECES = 2000;
/* Bounds that are wider than this make no slider. */
const WIDEST_SLIDER = 1e5;

/* What an input can do over time: names of its two numbers, and the value at t; `rest` is the value in its field. */
const SIGNALS = {
  constant: { numbers: [] },
  step: { numbers: ["to", "at, s"], at: (t, [to, when], rest) => (t >= when ? to : rest) },
  sine: { numbers: ["± ", "Hz"], at: (t, [amplitude, hertz], rest) => rest + amplitude * Math.sin(2 * Math.PI * hertz * t) },
  file: { numbers: [], at: (t, _, rest, column) => (column ? between(column, t) : rest) },
};

/* The column's value at t, straight between its rows; two rows of one time are a jump. */
function between({ times, values }, t) {
  const k = times.findIndex((time) => time > t);
  if (k < 0) return values.at(-1);
  if (k === 0) return values[0];
  return values[k - 1] + ((t - times[k - 1]) / (times[k] - times[k - 1])) * (values[k] - values[k - 1]);
}

/* What a number may be, in words. */
function bounds(min, max) {
  const [low, high] = [min, max].map((bound) => (Number.isFinite(bound) ? String(bound).replace("-", "−") : null));
  return low && high ? `${low} to ${high}` : low ? `at least ${low}` : high ? `at most ${high}` : "";
}

/* Columns of a CSV file by name; the first one is the time. */
function columnsOf(text) {
  const lines = text.replace("\ufeff", "").split(/\r?\n/).filter((line) => line.trim() && !line.startsWith("#"));
  const names = cells(lines[0]);
  const words = { true: 1, True: 1, false: 0, False: 0, "": NaN };
  const rows = lines.slice(1).map((line) => cells(line).map((cell) => words[cell] ?? Number(cell)));
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
  if (files.has("modelDescription.xml")) fmus.set(name || "this FMU", files);
  else if (files.has("SystemStructure.ssd")) {
    for (const [path, read] of files) if (path.endsWith(".fmu")) fmus.set(path.split("/").at(-1), archive(await read()));
  } else throw new Error(`${name} is neither an FMU nor an SSP: it holds no modelDescription.xml and no SystemStructure.ssd.`);
  for (const [fmu, inside] of fmus) {
    const paths = [...inside.keys()];
    if (paths.some((path) => WASM.test(path))) continue;
    if (/fmiVersion\s*=\s*["']2/.test(await textOf(inside, "modelDescription.xml"))) {
      throw new Error(`${fmu} is of FMI 2.0, for which there is no WebAssembly: take the FMU of FMI 3.0 in its place. ` +
        "For a model in Rust with fmu-export, `cargo fmu pack --target wasm` puts it into the folder fmi3/.");
    }
    const platforms = [...new Set(paths.filter((path) => /^binaries\/[^/]+\/./.test(path)).map((path) => path.split("/")[1]))];
    throw new Error(`${fmu} has no WebAssembly, so no page can run it: it holds ${platforms.length ? `libraries for ${platforms.join(", ")}` : "no libraries at all"}. ` +
      "Whoever has its sources in Rust adds it with `cargo fmu pack --target wasm`.");
  }
  return fmus;
}

class ModelPage extends Page {
  constructor() {
    super();
    Object.assign(this, { runs: [], scopes: new Map(), columns: new Map() });
    this.on("run", () => this.run());
    this.on("halt", () => this.halt());
    this.on("link", () => this.copyLink());
    this.on("search", () => this.filter(), "input");
    this.on("clear", () => this.plots((this.runs = [])));
    this.on("csv", () => download(`${document.title}.csv`, this.runs.at(-1).csv(), "text/csv"));
    this.on("find", () => this.table(), "input");
    this.on("document", () => this.documentation(), "change");
    this.takeFiles(["open"], "An FMU or SSP with WebAssembly, or a CSV file for the inputs");
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.scopes.forEach((scope) => scope.theme()));
  }

  async open() {
    const system = part("system");
    if (system) {
      const { settings, own } = settingsOf(location.hash);
      await this.load("", await unpacked(system), settings, own);
    }
    else this.say("Drop an FMU or SSP with WebAssembly onto this page.");
  }

  say(text) {
    element("message").textContent = text;
    element("message").hidden = !text;
  }

  /* The model of a file, in the place of the one before. */
  async load(name, bytes, settings = {}, own = {}) {
    const fmus = await fmusOf(name, bytes);
    const engine = await Engine.open({ engine: part("engine"), system: bytes });
    await engine.restart(settings);
    this.engine?.close();
    Object.assign(this, { engine, fmus, runs: [], values: settings, signals: new Map() });
    const { components, name: system } = engine.about;
    document.title = element("title").textContent = components.length === 1 ? components[0].model : system;
    await this.list();
    element("stop").value = own["@until"] ?? engine.about.stop;
    element("step").value = own["@step"] ?? engine.about.step;
    this.recall(own["@signals"]);
    element("document").replaceChildren(...[...fmus.keys()].map((fmu) => new Option(fmu)));
    await this.documentation();
    await this.run();
  }

  /* Fields and table of the variables of what the engine runs. */
  async list() {
    const { engine } = this;
    this.variables = elements(await engine.variables()).filter(({ type }) => type !== "Clock" && type !== "Binary");
    // A name without its component, where there is one component.
    const lone = new Set(this.variables.map((variable) => variable.name.split(".")[0])).size === 1;
    this.variables.forEach((variable) => (variable.short = lone ? variable.name.slice(variable.name.indexOf(".") + 1) : variable.name));
    await this.displays();
    // An input that a connection drives is refused.
    const isFree = ({ name }) => engine.get(name).then((value) => engine.set(name, value)).then(() => true, () => false);
    this.free = new Set();
    for (const input of this.of("input")) if (await isFree(input)) this.free.add(input);
    this.fields();
    this.table();
  }

  /* Says of each variable how its values are shown. */
  async displays() {
    const descriptions = new Map();
    this.named = new Set();
    for (const { name, source } of this.engine.about.components) {
      const fmu = this.fmus.get(source.split("/").at(-1)) ?? [...this.fmus.values()][0];
      await this.find(name, fmu);
      descriptions.set(name, new DOMParser().parseFromString(await textOf(fmu, "modelDescription.xml"), "text/xml"));
    }
    for (const variable of this.variables) variable.display = displayOf(variable, descriptions.get(variable.name.split(".")[0]) ?? new Document());
    this.shown = new Map(this.variables.map(({ name, display }) => [name, display]));
  }

  /* Outputs that the FMU's terminals have, or that its documentation names as code. */
  async find(component, fmu) {
    const parse = (text, type) => new DOMParser().parseFromString(text ?? "", type);
    const terminals = parse((await textOf(fmu, "terminalsAndIcons/terminalsAndIcons.xml")) ?? "<none/>", "text/xml");
    const members = [...terminals.getElementsByTagName("TerminalMemberVariable")].map((member) => member.getAttribute("variableName"));
    const codes = [...parse(await textOf(fmu, "documentation/index.html"), "text/html").querySelectorAll("code")].map((code) => code.textContent.trim());
    for (const name of members.length ? members : codes) this.named.add(`${component}.${name}`);
  }

  /* Starts anew with other sizes of arrays, whose variables are others; other values are dropped. */
  async resize() {
    const sizes = this.of("structuralParameter").map(({ name }) => [name, this.values[name]]).filter(([, value]) => value !== undefined);
    Object.assign(this, { runs: [], values: Object.fromEntries(sizes), signals: new Map() });
    await this.engine.restart(this.values);
    await this.list();
    await this.run();
  }

  of(...causalities) {
    return this.variables.filter((variable) => causalities.includes(variable.causality));
  }

  /* Variables that have curves. */
  get curves() {
    return this.of("output", "local").filter(({ type }) => type !== "String");
  }

  fields() {
    for (const [id, ...causalities] of [["inputs", "input"], ["parameters", "structuralParameter", "parameter"]]) {
      const rows = this.of(...causalities).filter((variable) => id !== "inputs" || this.free.has(variable)).map((variable) => this.field(variable));
      element(id).querySelectorAll(":scope > .row, :scope > .group").forEach((row) => row.remove());
      element(id).append(...this.grouped(rows, ({ dataset }) => dataset.component));
      element(id).hidden = rows.length === 0;
    }
    this.plotted = new Set(this.firstCurves().map(({ name }) => name));
    const boxes = this.curves.map(({ name, short, description }) => {
      const box = tickBox(short, this.plotted.has(name), (on) => {
        this.plotted[on ? "add" : "delete"](name);
        this.plots();
      });
      Object.assign(box.dataset, { name, component: name.split(".")[0], search: `${name} ${description ?? ""}`.toLowerCase() });
      return box;
    });
    element("plotted").replaceChildren(...this.grouped(boxes, ({ dataset }) => dataset.component));
    this.filter();
  }

  /* Rows in a group for each component, where there are several. */
  grouped(rows, componentOf) {
    const groups = rows.reduce((all, row) => all.set(componentOf(row), [...(all.get(componentOf(row)) ?? []), row]), new Map());
    if (groups.size < 2) return this.folded(rows);
    return [...groups].map(([component, own]) => {
      const group = html`<details class="group"><summary>${component} (${own.length})</summary></details>`;
      group.append(...this.folded(own));
      return group;
    });
  }

  /* An array is one row, which opens to those of its elements. */
  folded(rows) {
    const all = [];
    for (const row of rows) {
      const [, array] = /^(.*)\[[\d,]+\]$/.exec(row.dataset.name) ?? [];
      const last = all.at(-1);
      if (array && last?.dataset.array === array) last.append(row);
      else if (array) {
        const fold = html`<details class="group" data-array="${array}"><summary></summary></details>`;
        fold.append(row);
        all.push(fold);
      } else all.push(row);
    }
    for (const { dataset, children } of all) {
      if (dataset.array) children[0].textContent = `${dataset.array.slice(dataset.array.indexOf(".") + 1)} [${children.length - 1}]`;
    }
    return all;
  }

  /* The curves that are shown first: outputs that terminals or the documentation name come before the others. */
  firstCurves() {
    const isNamed = ({ name }) => this.named.has(name);
    return [...this.curves.filter(isNamed), ...this.curves.filter((one) => !isNamed(one))].slice(0, FIRST_PLOTS);
  }

  /* A row for an input or a parameter: a slider too where it has bounds, and for an input what it does over time. */
  field({ name, short, description, type, items, causality, display, ...variable }) {
    const { unit, from, to } = display;
    const isNumeric = !items?.length && type !== "Boolean" && type !== "String";
    const [start, min, max] = [this.values[name] ?? variable.start ?? 0, variable.min, variable.max].map((value) => (isNumeric && value !== null ? from(Number(value ?? NaN)) : value));
    const text = `${short}${unit && unit !== "1" ? `, ${unit}` : ""}`;
    const row = html`<div class="row" data-name="${name}" data-component="${name.split(".")[0]}" data-search="${`${name} ${description ?? ""}`.toLowerCase()}"><label title="${description}"><span>${text}</span></label></div>`;
    const field = items?.length ? html`<select></select>` : html`<input type="${{ Boolean: "checkbox", String: "text" }[type] ?? "number"}" step="any" value="${start}">`;
    items?.forEach((item) => field.add(new Option(item.name)));
    if (items?.length) field.value = items.find((item) => item.value === start)?.name ?? start;
    field.checked = String(start) === "true";
    const isNumber = field.type === "number";
    if (isNumber) Object.assign(field, { min: min ?? "", max: max ?? "" });
    const changed = () => {
      if (!field.reportValidity()) return;
      this.values[name] = field.type === "checkbox" ? field.checked : isNumber ? to(Number(field.value)) : field.value;
      this.keepAddress();
      if (causality === "structuralParameter") this.resize().catch((error) => this.say(error.message));
    };
    field.addEventListener("change", changed);
    row.firstChild.append(field);
    if (isNumber && [min, max].every(Number.isFinite) && max - min < WIDEST_SLIDER) {
      const slider = html`<input type="range" min="${min}" max="${max}" step="${(max - min) / 200}" value="${start}" aria-label="${text}">`;
      slider.addEventListener("input", () => {
        field.value = slider.value;
        changed();
      });
      field.addEventListener("change", () => (slider.value = field.value));
      row.append(slider);
    }
    if (isNumber && bounds(min, max)) row.append(html`<small>${bounds(min, max)}</small>`);
    if (isNumber && causality === "input") row.append(this.signal(name, short, field, to));
    return row;
  }

  /* What an input does over time; `to` converts what is shown to its unit, in which files are. */
  signal(name, short, rest, to) {
    const box = html`<span class="signal"><select aria-label="${short} over time"></select><label><span></span><input type="number" step="any" value="1"></label><label><span></span><input type="number" step="any" value="1"></label></span>`;
    const [select, ...labels] = box.children;
    Object.keys(SIGNALS).forEach((kind) => select.add(new Option(kind)));
    const show = () => labels.forEach((label, k) => {
      label.firstChild.textContent = SIGNALS[select.value].numbers[k];
      label.hidden = k >= SIGNALS[select.value].numbers.length;
    });
    select.addEventListener("change", show);
    show();
    const at = (t) => {
      const value = SIGNALS[select.value].at(t, labels.map((label) => Number(label.lastChild.value)), Number(rest.value), this.columns.get(name) ?? this.columns.get(short));
      return select.value === "file" ? value : to(value);
    };
    const numbers = () => labels.map((label) => Number(label.lastChild.value));
    const put = (kind, values) => {
      select.value = kind;
      values.forEach((value, k) => labels[k] && (labels[k].lastChild.value = value));
      show();
    };
    this.signals.set(name, { select, short, at, numbers, put });
    return box;
  }

  /* The inputs that move, with their values at t. */
  moving(t) {
    return [...this.signals].filter(([, { select }]) => select.value !== "constant").map(([name, { at }]) => [name, at(t)]);
  }

  /* Starts a run, whose curves are kept; what tells it from later ones. */
  async start(settings) {
    const [before, ticket] = [this.ticket, {}];
    this.ticket = ticket;
    try {
      await this.engine.restart(settings);
    } catch (error) {
      this.ticket = before;
      throw error;
    }
    if (ticket !== this.ticket) return ticket;
    const number = (this.runs.at(-1)?.number ?? 0) + 1;
    if (!element("over").checked) this.runs = [];
    const run = Object.assign(new Recorder(), { on: true, number, values: { ...settings } });
    const earlier = this.runs.at(-1);
    run.label = earlier ? this.runName(earlier.values, run.values) : "";
    run.restart([...this.curves, ...this.of("input").filter(({ type }) => type !== "String")].map(({ name }) => name));
    this.runs.push(run);
    this.plots();
    this.engine.onframe = (frame) => ticket === this.ticket && this.frame(run, frame);
    await this.engine.watch(run.names);
    return ticket;
  }

  /* What must be said of the stop time and the step before a run. */
  span() {
    const [stop, step] = [Number(element("stop").value), Number(element("step").value)];
    const { start } = this.engine.about;
    if (!(step > 0)) throw new Error(`Step: ${element("step").value || "nothing"} s must be greater than 0 s.`);
    if (!(stop > start)) throw new Error(`Until: ${element("stop").value || "nothing"} s must be after the start at ${start} s.`);
    if (step > stop - start) throw new Error(`Step: ${step} s is longer than the run, which ends at ${stop} s.`);
    const steps = Math.round((stop - start) / step);
    const end = start + steps * step;
    const isWhole = Math.abs(end - stop) < 1e-9 * Math.max(Math.abs(stop), step);
    return { start, stop, step, steps, note: isWhole ? "" : `${stop} s is no whole number of steps of ${step} s: the run ends at ${Number(end.toPrecision(9))} s.` };
  }

  async run() {
    const { start, stop, step, steps, note } = this.span();
    this.say(note);
    const ticket = await this.start({ ...this.values, ...Object.fromEntries(this.moving(start)), step });
    this.keepAddress();
    element("halt").disabled = false;
    const piece = Math.ceil(steps / (this.moving(start).length ? MOVING_PIECES : PIECES));
    try {
      for (let k = 0; k < steps && !ticket.halted; k += piece) {
        for (const [name, value] of this.moving(start + k * step)) await this.engine.set(name, value);
        // A later run has begun: what goes on is that one.
        if (ticket !== this.ticket) return;
        await this.engine.advance(Math.min(piece, steps - k) * step);
      }
    } finally {
      if (ticket === this.ticket) element("halt").disabled = true;
    }
    if (ticket !== this.ticket) return;
    if (ticket.halted) this.say(`Stopped at ${Number(this.engine.time.toPrecision(6))} s.`);
    this.scopes.forEach((scope) => scope.draw(stop));
    const { bad, text, findings } = await this.engine.verdict();
    Object.assign(element("verdict"), { textContent: bad ? findings.find((finding) => finding.bad).text : "no faults", className: bad ? "bad" : "good", title: text });
    element("csv").disabled = false;
  }

  /* Ends the run where it is; its curves stay. */
  halt() {
    if (!this.ticket) return undefined;
    this.ticket.halted = true;
    return this.engine.pause();
  }

  /* What the address holds besides the values: stop, step, and what inputs do over time. Columns of a file are not in it. */
  own() {
    const signals = [...this.signals].filter(([, { select }]) => select.value !== "constant").map(([name, { select, numbers }]) => [name, select.value, ...numbers()]);
    return { "@until": element("stop").value, "@step": element("step").value, ...(signals.length && { "@signals": JSON.stringify(signals) }) };
  }

  keepAddress() {
    history.replaceState(null, "", addressOf(this.values, { own: this.own() }));
  }

  /* Inputs over time as the address has them. */
  recall(text = "[]") {
    let signals = null;
    try {
      signals = JSON.parse(text);
    } catch { /* Said below. */ }
    if (!Array.isArray(signals)) throw new Error("The address is damaged: `@signals` in it is no list.");
    for (const [name, kind, ...numbers] of signals) {
      if (!this.signals.has(name) || !(kind in SIGNALS)) throw new Error(`The address has a signal of ${name}, ${kind}: this model has no such input, or the page no such signal.`);
      this.signals.get(name).put(kind, numbers);
    }
  }

  async copyLink() {
    this.keepAddress();
    const usesFile = [...this.signals.values()].some(({ select }) => select.value === "file");
    const held = usesFile ? "It holds values, stop, step and signals, but not the columns of the CSV file: send that too." : "It holds values, stop, step and signals.";
    this.say(`${(await copied(location.href)) ? "The link is copied." : "Copy the link from the address bar."} ${held}`);
  }

  /* Shows the rows whose names or descriptions have the text, with their groups. */
  filter() {
    const wanted = element("search").value.trim().toLowerCase();
    for (const row of element("panel").querySelectorAll("[data-search]")) row.hidden = !row.dataset.search.includes(wanted);
    for (const group of element("panel").querySelectorAll("details.group")) {
      group.hidden = !group.querySelector("[data-search]:not([hidden])");
      if (wanted) group.open = true;
    }
  }

  /* What of the values differs from one run to the next, as the name of a run. */
  runName(before, values) {
    const names = [...new Set([...Object.keys(before), ...Object.keys(values)])].filter((name) => String(before[name]) !== String(values[name]));
    const short = (name) => this.variables.find((variable) => variable.name === name)?.short ?? name;
    const shown = (name) => {
      const variable = this.variables.find((one) => one.name === name);
      const value = values[name] ?? variable?.start;
      return typeof value === "number" && variable ? variable.display.from(value) : value;
    };
    return names.slice(0, 2).map((name) => `${short(name)} = ${shown(name)}`).join(", ") + (names.length > 2 ? ", …" : "");
  }

  frame(run, { time, history, factor, error }) {
    if (error) this.say(error);
    run.add(history, 1 + run.names.length);
    this.draw(run, history);
    element("clock").textContent = `${Number(time.toPrecision(6))} s`;
    if (factor) element("factor").textContent = Number(factor.toPrecision(3));
    if (performance.now() - (this.drawn ?? 0) < 50) return;
    this.scopes.forEach((scope) => scope.draw(time));
    this.drawn = performance.now();
  }

  draw(run, rows) {
    const stride = 1 + run.names.length;
    for (const [name, scope] of this.scopes) {
      const { from } = this.shown.get(name);
      const [column, trace] = [1 + run.names.indexOf(name), scope.traces[this.runs.indexOf(run)]];
      for (let at = 0; trace && at + stride <= rows.length; at += stride) trace.push(rows[at], from(rows[at + column]));
    }
  }

  /* All plots anew, with all runs. */
  plots() {
    this.scopes.forEach((scope) => scope.remove());
    this.scopes = new Map(this.curves.filter(({ name }) => this.plotted.has(name)).map(({ name, short, display: { unit } }) => {
      const scope = new Scope(element("scopes"), { title: short, unit: unit === "1" ? "" : unit, length: Number(element("stop").value), scrolls: false });
      this.runs.forEach((run) => scope.add(this.runs.length > 1 ? `run ${run.number}${run.label ? `: ${run.label}` : ""}` : "", run.number - 1));
      return [name, scope];
    }));
    for (const run of this.runs) run.chunks.forEach((rows) => this.draw(run, rows));
    this.scopes.forEach((scope) => scope.draw(0));
  }

  table() {
    const wanted = element("find").value.toLowerCase();
    const found = this.variables.filter(({ name, description }) => `${name} ${description ?? ""}`.toLowerCase().includes(wanted));
    const rows = found.map((v) => html`<table><tr><td>${v.name}</td><td>${v.causality}</td><td>${v.variability}</td><td>${v.type}</td><td>${v.unit}</td><td>${v.start}</td><td>${v.min}</td><td>${v.max}</td><td>${v.description}</td></tr></table>`);
    element("variables").querySelector("tbody").replaceChildren(...rows.map((table) => table.querySelector("tr")));
  }

  async documentation() {
    const text = await textOf(this.fmus.get(element("document").value), "documentation/index.html");
    element("documentation").querySelector("iframe").srcdoc = text ?? "<p>This FMU brings no documentation.</p>";
  }

  /* A file: another model, or columns for the inputs. */
  async read(file) {
    if (!file.name.endsWith(".csv")) return this.load(file.name, new Uint8Array(await file.arrayBuffer()));
    this.columns = columnsOf(await file.text());
    const driven = [...this.signals].filter(([name, { short }]) => this.columns.has(name) || this.columns.has(short));
    if (!driven.length) throw new Error(`No column of ${file.name} is named as an input: ${[...this.columns.keys()].join(", ")}.`);
    for (const [, { select }] of driven) {
      select.value = "file";
      select.dispatchEvent(new Event("change"));
    }
    return this.run();
  }

  engineOf() {
    return this.engine;
  }

  play() {
    return this.engine.play(1);
  }

  pause() {
    return this.engine.pause();
  }

  advance(seconds) {
    return this.engine.advance(seconds);
  }

  set(name, value) {
    return this.engine.set(name, value);
  }
}

const model = new ModelPage();
const opened = model.open();
opened.catch((error) => model.say(`This model cannot be started: ${error.message}`));
scripted(model, opened);
