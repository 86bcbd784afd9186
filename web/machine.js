/* The live machine: puts engine, scene, levers, panel and scopes together; `window.machine` is the page for scripts. */
import { Ensemble, WORLDS } from "./ensemble.js";
import { LAWS, Panel } from "./controls.js";
import { Levers, LEVER_KEYS } from "./drive.js";
import { LiveScene } from "./live_scene.js";
import { Recorder } from "./records.js";
import { Scope, readable } from "./scopes.js";
import { ACTUATORS, GHOST_SIGNALS, SCOPES, SIGNALS, watched } from "./signals.js";
import { download, json, part } from "./parts.js";
import { addressOf, elements, settingsOf } from "./variables.js";

const element = (id) => document.getElementById(id);
/* What one sees first: it moves at once, and with all joints. */
const FIRST = { trajectory: "path", "controller.path_file": "six-joints", "controller.settle_time": "0.3" };
const GHOST_LAWS = ["adaptive", "modular", "pd", "modular_integral"];
/* Largest rates of the levers, by kind; the controller limits them too. */
const MOST = { joint: [0.15, 0.1, 0.1, 0.5, 0.5, 0.5], tip: [0.25, 0.25, 0.25, 0.3, 0.3, 0.3] };
const PUSH = { force: 300, duration: 0.2 };
const SCOPE_SECONDS = 12;
/* Name of the file that the controller is given waypoints in. */
const PATH = "waypoints";
/* Where a run is lost: the tip this far off, m; a rod with this many times its rated force. */
const LOST_TIP = 0.05;
const LOST_FORCE = 4;

class LivePage {
  constructor() {
    this.data = json("scene");
    this.log = [];
    this.waypoints = [];
    this.playing = false;
    this.scene = new LiveScene(element("stage"), this.data, (force) => this.push(force), (point) => this.addWaypoint(point));
    this.levers = new Levers(element("levers"), (kind) => MOST[kind], (kind, rates) => this.command(kind, rates));
    const sheets = Object.fromEntries([...document.querySelectorAll("[data-sheet]")].map((sheet) => [sheet.dataset.sheet, sheet]));
    this.panel = new Panel(sheets, (control, values) => this.change(control, values));
    this.recorder = new Recorder();
    this.scopes = new Map();
    this.chosen = new Set(SCOPES.filter((scope) => scope.shown).map((scope) => scope.name));
    this.buttons();
    this.firstMinute();
    this.files();
  }

  async open() {
    const [engine, system] = await Promise.all([part("engine"), part("system")]);
    this.ensemble = await Ensemble.open({ engine, system });
    const { settings, ghosts } = settingsOf(location.hash);
    await this.start(Object.keys(settings).length ? settings : FIRST, ghosts);
    requestAnimationFrame((now) => this.tick(now));
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches) this.play();
  }

  /* Laws of the ghosts. */
  get laws() {
    return [...this.ensemble.ghosts.keys()];
  }

  /* Starts with these settings, and says why where a reason is given; what is refused leaves the run as it is. */
  async start(settings, ghosts = this.laws, why = "") {
    const playing = this.playing;
    if (this.settings) await this.pause();
    try {
      const laws = ghosts.filter((law) => law in LAWS);
      if (laws.join() === this.laws.join()) await this.ensemble.restart(settings);
      else await this.ensemble.beside(laws, settings);
    } finally {
      if (playing) this.play();
    }
    this.settings = settings;
    [this.log, this.lost, this.pushed] = [[], null, null];
    element("broken").hidden = true;
    this.variables = new Map(elements(await this.ensemble.main.variables()).map((variable) => [variable.name, variable]));
    this.panel.build(this.variables);
    await this.follow();
    this.watch();
    history.replaceState(null, "", addressOf(this.settings, this.laws));
    this.say(why);
    element("undo").disabled = false;
    await this.judge();
  }

  /* The panel shows what the running system has. */
  async follow() {
    await this.panel.follow((name) => this.ensemble.main.get(name));
    const { trajectory } = this.settings;
    const file = this.settings["controller.path_file"];
    const kind = this.settings["controller.rate.command"] ?? "joint";
    const path = file && [...element("trajectory").options].some((o) => o.value === `path ${file}`) ? `path ${file}` : "waypoints";
    element("trajectory").value = trajectory === "rates" ? `rates ${kind}` : trajectory === "path" ? path : (trajectory ?? "cubic");
    element("waypoint-tools").hidden = element("trajectory").value !== "waypoints";
    element("world").value = this.settings.world ?? "ideal";
    this.levers.lead(kind);
    this.hanging = this.variables.has("hdrm.load.mass") && (await this.ensemble.main.get("hdrm.load.mass")) > 0;
    this.sayHanging();
    for (const box of element("ghosts").querySelectorAll("input")) box.checked = this.ensemble.ghosts.has(box.value);
  }

  /* Tells the engines what to send, and makes the scopes anew. */
  watch() {
    const has = (name) => this.variables.has(name);
    const { names, places } = watched(SIGNALS, has);
    Object.assign(this, { names, places });
    this.ghostPlaces = watched(GHOST_SIGNALS, has);
    this.scene.clear();
    this.recorder.restart(names);
    this.makeScopes();
    const { main, ghosts } = this.ensemble;
    this.ghostValues = [...ghosts].map(() => null);
    this.scene.showGhosts([...ghosts].map((_, k) => this.ghostColor(k)));
    main.onframe = (frame) => this.frame(frame);
    main.watch(names);
    [...ghosts.values()].forEach((ghost, k) => {
      ghost.onframe = (frame) => this.ghostFrame(frame, k);
      ghost.watch(this.ghostPlaces.names);
    });
  }

  ghostColor(k) {
    return getComputedStyle(document.documentElement).getPropertyValue(`--trace-${k + 3}`).trim();
  }

  makeScopes() {
    this.scopes.forEach(({ scope }) => scope.remove());
    this.scopes.clear();
    for (const description of SCOPES) {
      const { name, title, unit, signal, labels, ghosts, truth } = description;
      if (!this.chosen.has(name) || !this.places[signal]) continue;
      const scope = new Scope(element("scopes"), { title, unit, length: SCOPE_SECONDS, scrolls: true });
      const traces = labels.map((label) => scope.add(label));
      const beside = ghosts ? this.laws.map((law, k) => scope.add(law, k + 2)) : [];
      const true_ = truth ? labels.map((label, k) => scope.add("", k, true)) : [];
      this.scopes.set(name, { description, scope, traces, beside, true_ });
    }
    const offered = SCOPES.filter(({ signal }) => this.places[signal]);
    element("scope-choice").replaceChildren(...offered.map(({ name, title }) => this.box(title, this.chosen.has(name), (on) => {
      this.chosen[on ? "add" : "delete"](name);
      this.makeScopes();
    })));
  }

  box(text, checked, changed) {
    const label = document.createElement("label");
    const field = document.createElement("input");
    Object.assign(field, { type: "checkbox", checked });
    field.addEventListener("change", () => changed(field.checked));
    label.append(field, text);
    return label;
  }

  /* Values of a signal of a row that begins with time. */
  of(row, signal, at = 1) {
    return (this.places[signal] ?? []).map((k) => row[at + k]);
  }

  frame(frame) {
    const { history, values } = frame;
    const stride = 1 + this.names.length;
    if (values.length + 1 !== stride) return;
    const masses = this.trueMasses();
    for (let at = 0; at + stride <= history.length; at += stride) {
      const t = history[at];
      for (const { description, traces, true_ } of this.scopes.values()) {
        const { signal, of = (v) => v } = description;
        this.places[signal].forEach((k, j) => traces[j].push(t, of(history[at + 1 + k])));
        true_.forEach((trace, j) => trace.push(t, masses[j]));
      }
      this.watchLimits(t, this.of(history, "force", at + 1), history[at + 1 + this.places.error[0]]);
    }
    this.recorder.add(history, stride);
    this.latest = frame;
    if (frame.error && this.playing) this.ended(frame.error);
    if (this.pushed && frame.time >= this.pushed) this.push([0, 0, 0]);
    this.ensemble.remember();
  }

  ghostFrame({ values, history }, k) {
    const { names, places } = this.ghostPlaces;
    const stride = 1 + names.length;
    const trace = this.scopes.get("error")?.beside[k];
    for (let at = 0; trace && at + stride <= history.length; at += stride) trace.push(history[at], 1000 * history[at + 1 + places.error[0]]);
    this.ghostValues[k] = places.zeta.map((j) => values[j]);
  }

  trueMasses() {
    const scale = Number(this.settings["hdrm.inertia_scale"] ?? 1);
    const payload = this.settings["hdrm.payload.mass"];
    const of = (name) => (name === "PL" && payload !== undefined ? Number(payload) : this.data.bodies.find((body) => body.name === name).mass);
    return SIGNALS.masses.map((name) => scale * of(name.split(".").at(-1)));
  }

  /* Says once when a rod is beyond its rating, and when the machine would have broken. */
  watchLimits(t, forces, error) {
    const shares = forces.map((force, k) => Math.abs(force) / this.data.rated[k]);
    const worst = shares.indexOf(Math.max(...shares));
    const rod = `the ${ACTUATORS[worst]} rod had ${readable(forces[worst] / 1000)} kN, ${shares[worst].toFixed(1)} times what it is rated for`;
    const [rank, text] = shares[worst] >= LOST_FORCE ? [2, `The machine would have broken at ${t.toFixed(2)} s: ${rod}.`]
      : error >= LOST_TIP ? [2, `The controller lost the machine at ${t.toFixed(2)} s: the tip was ${(1000 * error).toFixed(0)} mm off.`]
      : shares[worst] > 1 ? [1, `Overloaded at ${t.toFixed(2)} s: ${rod}.`] : [0, ""];
    if (rank > (this.lost?.rank ?? 0)) this.alarm(rank, text);
  }

  alarm(rank, text) {
    this.lost = { rank, text };
    element("broken").textContent = text;
    element("broken").hidden = false;
  }

  /* The run goes on no more. */
  ended(error) {
    this.alarm(2, `The run ended at ${this.ensemble.time.toFixed(2)} s: ${error}`);
    this.pause();
  }

  /* One picture. */
  tick(now) {
    requestAnimationFrame((next) => this.tick(next));
    this.levers.poll();
    if (this.latest && this.latest !== this.shown) {
      this.shown = this.latest;
      this.show(this.latest);
      // Scopes and numbers at half the rate: nobody reads them faster.
      this.odd = !this.odd;
      if (this.odd) this.scopes.forEach(({ scope }) => scope.draw(this.latest.time));
    }
    this.scene.draw(element("show-labels").checked);
    if (now - (this.told ?? 0) > 120) {
      this.told = now;
      this.numbers();
    }
    if (now - (this.judged ?? 0) > 1500) {
      this.judged = now;
      this.judge();
    }
  }

  show({ values }) {
    const row = (signal) => this.of(values, signal, 0);
    const [loadMass, tilt] = [row("load")[0] ?? 0, row("tilt")];
    this.scene.show({
      zeta: row("zeta"), tip: row("tip"), orientation: row("orientation"), desired: row("desired"), loadMass,
      tilt: tilt.length ? tilt : [0, 0], ghosts: this.ghostValues.map((zeta) => zeta ?? [NaN]) });
  }

  numbers() {
    if (!this.latest) return;
    const { values, factor, share } = this.latest;
    const row = (signal) => this.of(values, signal, 0);
    const [forces, currents, [error]] = [row("force"), row("current"), row("error")];
    element("clock").textContent = `${this.latest.time.toFixed(2)} s`;
    element("factor").textContent = this.playing ? `${readable(factor)} ×` : "paused";
    element("share").textContent = this.playing ? `${Math.round(100 * share)} %` : "–";
    const lines = ACTUATORS.map((name, k) => {
      const part = Math.abs(forces[k]) / this.data.rated[k];
      return `<tr><td>${name}</td><td>${(forces[k] / 1000).toFixed(1).replace("-", "−")} kN</td><td><meter min="0" max="1.3" high="1" low="0.8" optimum="0" value="${part}"></meter></td><td>${currents[k].toFixed(1).replace("-", "−")} A</td></tr>`;
    });
    const beside = this.laws.map((law, k) => {
      const last = this.scopes.get("error")?.beside[k]?.last;
      return last === undefined ? "" : `<tr style="color:${this.ghostColor(k)}"><td>${law}</td><td colspan="3">${readable(last)} mm</td></tr>`;
    });
    element("readout").innerHTML = `<table>${lines.join("")}<tr><td><b>tip error</b></td><td colspan="3"><b>${readable(1000 * error)} mm</b></td></tr>${beside.join("")}</table>`;
    this.scene.label(ACTUATORS.map((name, k) => `${name} ${(forces[k] / 1000).toFixed(1).replace("-", "−")} kN, ${currents[k].toFixed(0).replace("-", "−")} A`));
    if (this.levers.padName) element("gamepad").textContent = `Joystick: ${this.levers.padName}. Left stick: slew and lift; right stick: tilt and turn.`;
    element("csv").disabled = this.recorder.count === 0;
  }

  async judge() {
    const { bad, text } = await this.ensemble.main.verdict();
    const lost = this.lost?.rank === 2;
    element("verdict").textContent = lost ? "lost" : bad ? "bad" : "good";
    element("verdict").className = lost || bad ? "bad" : "good";
    element("verdict").title = text;
  }

  say(text) {
    if (!text) return;
    element("message").textContent = text;
    element("message").classList.add("shown");
    clearTimeout(this.silence);
    this.silence = setTimeout(() => element("message").classList.remove("shown"), 6000);
  }

  /* Does it, and says what stood in the way. */
  async attempt(act) {
    try {
      await act();
    } catch (error) {
      this.say(error.message);
      await this.follow().catch(() => {});
    }
  }

  play() {
    this.playing = true;
    this.ensemble.play(Number(element("speed").value));
    this.sayPlaying();
  }

  async pause() {
    this.playing = false;
    await this.ensemble.pause();
    this.sayPlaying();
  }

  sayPlaying() {
    element("play").textContent = this.playing ? "❚❚ Pause" : "▶ Run";
  }

  async step() {
    await this.pause();
    await this.ensemble.advance(this.ensemble.main.about.step);
  }

  async set(name, value) {
    await this.ensemble.set(name, value);
    this.log.push({ time: this.ensemble.time, name, value });
  }

  /* A slider or switch of the panel. */
  change(control, values) {
    return this.attempt(async () => {
      if (control.own === "load") return this.hanging ? this.set("hdrm.load.mass", this.panel.own("load")) : undefined;
      if (control.own === "told") return this.tell(this.panel.own("told"));
      if (control.atOnce) {
        for (const [name, value] of Object.entries(values)) await this.set(name, value);
        Object.assign(this.settings, values);
        history.replaceState(null, "", addressOf(this.settings, this.laws));
      } else {
        await this.start({ ...this.settings, ...values }, undefined, `${control.label}: that needs a standstill, so the machine started again.`);
      }
    });
  }

  /* Whether the controller knows of the base's tilt. */
  async tell(told) {
    for (const axis of [1, 2]) {
      const name = `base.tilt[${axis}]`;
      await this.set(`controller.${name}`, told ? await this.ensemble.main.get(`hdrm.${name}`) : 0);
    }
  }

  command(kind, rates) {
    this.done("levers");
    return this.attempt(async () => {
      if (this.settings.trajectory !== "rates") {
        if (this.taking) return;
        this.taking = true;
        await this.lead("rates joint").finally(() => (this.taking = false));
      }
      for (const [k, rate] of rates.entries()) await this.set(`controller.rate.${kind}[${k + 1}]`, rate);
    });
  }

  /* Settings that start where the machine stands now. */
  standing() {
    return Object.fromEntries(SIGNALS.zeta.map((name, k) => [name.replace("zeta", "zeta_start"), this.of(this.latest.values, "zeta", 0)[k]]));
  }

  /* Who leads from now on: a value of the select `trajectory`. */
  async lead(choice) {
    const [trajectory, detail] = choice.split(" ");
    const kept = Object.entries(this.settings).filter(([name]) => !/^controller\.(path_file|rate\.|settle_time)|^trajectory$|^files$|zeta_start/.test(name));
    const settings = { ...Object.fromEntries(kept), trajectory, "controller.settle_time": 0.3 };
    if (trajectory === "rates") {
      if (this.settings.trajectory === "rates") {
        this.settings["controller.rate.command"] = detail;
        await this.set("controller.rate.command", detail);
        return this.follow();
      }
      Object.assign(settings, { "controller.rate.command": detail }, this.standing());
      return this.start(settings, undefined, "You lead now: the levers, or the keys under them.");
    }
    if (trajectory === "path") settings["controller.path_file"] = detail;
    if (trajectory !== "waypoints") return this.start(settings, undefined, "The machine started again, on that path.");
    element("waypoint-tools").hidden = false;
    if (this.waypoints.length < 2) return this.say("Click two waypoints or more into the picture, or drop a file.");
    return this.follows({ waypoints: this.waypoints.map((position) => ({ position, dwell: 0.2 })), limits: { speed: 0.2, acceleration: 0.5, jerk: 3 } });
  }

  /* Follows a path from where the machine stands: waypoints, or the text of a file. */
  follows(path) {
    const files = { [PATH]: typeof path === "string" ? path : JSON.stringify(path) };
    const settings = { ...this.settings, ...this.standing(), trajectory: "path", "controller.path_file": PATH, files, "controller.settle_time": 0.3 };
    return this.start(settings, undefined, "The machine follows your waypoints.");
  }

  addWaypoint(point) {
    this.waypoints.push(point.map((v) => Number(v.toFixed(3))));
    this.sayWaypoints();
    if (this.waypoints.length >= 2) this.attempt(() => this.lead("waypoints"));
  }

  sayWaypoints() {
    this.scene.setWaypoints(this.waypoints);
    const last = this.waypoints.at(-1);
    element("waypoint-count").textContent = last ? `${this.waypoints.length}, the last at ${last.join(", ")} m (forward, up, right).` : "No waypoints yet.";
  }

  /* A force at the tip, N, in world axes; it stays until the next one. */
  push(force) {
    this.pushed = null;
    if (force.some((f) => f !== 0)) this.done("push");
    const inTip = this.scene.inTipAxes(force);
    return this.attempt(() => Promise.all(inTip.map((f, k) => this.set(`hdrm.wrench_env[${k + 1}]`, f))));
  }

  pushShortly() {
    this.push([0, 0, PUSH.force]);
    this.pushed = this.ensemble.time + PUSH.duration;
    this.say(`Pushed with ${PUSH.force} N for ${PUSH.duration} s.`);
  }

  hang() {
    this.done("hang");
    return this.attempt(async () => {
      await this.set("hdrm.load.mass", this.hanging ? 0 : this.panel.own("load"));
      this.hanging = !this.hanging;
      this.sayHanging();
    });
  }

  sayHanging() {
    element("hang").setAttribute("aria-pressed", this.hanging);
    element("hang").textContent = this.hanging ? "Set down the load" : "Pick up the load";
  }

  beside(laws) {
    if (laws.length) this.done("ghost");
    return this.attempt(() => this.start(this.settings, laws, "All started again, so that they begin alike."));
  }

  /* After a jump in time nothing later is shown. */
  async jumped(text) {
    const { time } = this.ensemble;
    this.scopes.forEach(({ scope }) => scope.cut(time));
    this.recorder.cut(time);
    this.scene.clear();
    [this.lost, this.pushed] = [null, null];
    element("broken").hidden = true;
    await this.follow();
    this.say(text);
  }

  undo() {
    return this.attempt(async () => {
      const playing = this.playing;
      await this.pause();
      const before = this.ensemble.time;
      const time = await this.ensemble.undo();
      await this.jumped(`Back by ${(before - time).toFixed(1)} s.`);
      if (playing) this.play();
    });
  }

  keepMoment() {
    return this.attempt(async () => {
      const state = await this.ensemble.state();
      const button = document.createElement("button");
      button.textContent = `${state.time.toFixed(2)} s`;
      button.title = "Back to this moment";
      button.addEventListener("click", () => this.attempt(async () => {
        await this.pause();
        await this.ensemble.back(state);
        await this.jumped(`Back at ${state.time.toFixed(2)} s.`);
      }));
      element("moments").append(button);
    });
  }

  buttons() {
    const on = (id, act, event = "click") => element(id).addEventListener(event, () => this.attempt(act));
    on("play", () => (this.playing ? this.pause() : this.play()));
    on("step", () => this.step());
    on("undo", () => this.undo());
    on("restart", () => this.start(this.settings, undefined, "From the start again."));
    on("speed", () => this.playing && this.play(), "change");
    on("trajectory", () => this.lead(element("trajectory").value), "change");
    on("world", () => this.world(element("world").value), "change");
    on("push", () => this.pushShortly());
    on("hang", () => this.hang());
    on("save", () => this.keepMoment());
    on("show-labels", () => (this.scene.dirty = true), "change");
    on("error-gain", () => { this.scene.gain = Number(element("error-gain").value); this.scene.clear(); }, "change");
    on("waypoint-click", () => this.aim(!this.scene.aiming));
    on("waypoint-here", () => this.addWaypoint(this.of(this.latest.values, "tip", 0)));
    on("waypoint-clear", () => { this.waypoints = []; this.sayWaypoints(); });
    on("record", () => { element("record").setAttribute("aria-pressed", this.recorder.toggle()); });
    on("csv", () => download("machine.csv", this.recorder.csv(), "text/csv"));
    on("settings", () => download("machine.json", this.settingsText(), "application/json"));
    on("link", async () => { await navigator.clipboard.writeText(location.href); this.say("The link is copied."); });
    document.querySelectorAll("[data-view]").forEach((button) => button.addEventListener("click", () => this.scene.view(button.dataset.view)));
    Object.entries(WORLDS).forEach(([value, { text }]) => element("world").add(new Option(text, value)));
    const boxes = GHOST_LAWS.map((law) => {
      const label = this.box(LAWS[law], false, () => this.beside([...element("ghosts").querySelectorAll("input:checked")].map((box) => box.value)));
      label.firstChild.value = law;
      return label;
    });
    element("ghosts").append(...boxes);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.scene.theme();
      this.scopes.forEach(({ scope }) => scope.theme());
    });
    this.keys();
  }

  aim(on) {
    this.scene.aiming = on;
    element("waypoint-click").setAttribute("aria-pressed", on);
    this.scene.canvas.classList.toggle("aiming", on);
    if (on) this.say("Click into the picture: the point lies in the boom's plane; with shift at the tip's height.");
  }

  world(world) {
    if (world !== "ideal") this.done("world");
    // Parameters of components that the other world does not have stay behind.
    const kept = Object.entries(this.settings).filter(([name]) => !/^(sensors|dclink|emla_\d)\./.test(name));
    return this.start({ ...Object.fromEntries(kept), world }, undefined, `Started again: ${WORLDS[world].text}.`);
  }

  settingsText() {
    const note = "settings as `cosim run --set` takes them; changes: what was changed while it ran, s after the start";
    return JSON.stringify({ note, settings: this.settings, ghosts: this.laws, changes: this.log }, null, 1);
  }

  keys() {
    const keys = { Space: () => element("play").click(), Period: () => this.step(), Backspace: () => this.undo(), KeyP: () => this.pushShortly(), KeyL: () => this.hang(), KeyO: () => this.aim(!this.scene.aiming) };
    document.addEventListener("keydown", (event) => {
      const inField = event.target.closest?.("input:not([type=range]):not([type=checkbox]), select, textarea");
      const own = event.code === "Space" && event.target.closest?.("button, summary, input, a");
      if (inField || own || event.repeat || event.ctrlKey || event.metaKey || event.altKey || !keys[event.code]) return;
      event.preventDefault();
      this.attempt(keys[event.code]);
    });
    const rows = [["space", "run or pause"], [".", "one step"], ["backspace", "back by ten seconds"], ["P", "push the tip"], ["L", "pick up or set down the load"], ["O", "click waypoints"],
      ...LEVER_KEYS.map((pair, k) => [pair.map((key) => key.slice(3)).join(" "), `lever ${k + 1}`]), ["arrows on the picture", "move the view, with shift turn it"]];
    element("keys").innerHTML = rows.map(([key, text]) => `<tr><td><kbd>${key}</kbd></td><td>${text}</td></tr>`).join("");
  }

  /* A file: settings of this page, else a path. */
  async read(file) {
    const text = await file.text();
    const found = text.trimStart().startsWith("{") ? JSON.parse(text) : null;
    await (found?.settings ? this.start(found.settings, found.ghosts ?? [], "Settings of the file.") : this.follows(text));
  }

  files() {
    const picker = element("file");
    for (const id of ["waypoint-file", "settings-file"]) element(id).addEventListener("click", () => picker.click());
    picker.addEventListener("change", () => picker.files[0] && this.attempt(() => this.read(picker.files[0])));
    document.body.dataset.drop = "Waypoints or settings";
    for (const kind of ["dragover", "dragleave", "drop"]) {
      document.addEventListener(kind, (event) => {
        event.preventDefault();
        document.body.classList.toggle("dropping", kind === "dragover");
        if (kind === "drop" && event.dataTransfer.files[0]) this.attempt(() => this.read(event.dataTransfer.files[0]));
      });
    }
  }

  /* What to try first; each is crossed off when it was done. */
  firstMinute() {
    const steps = { levers: ["Take the levers: hold W, or drag one below", () => this.lead("rates joint")], push: ["Push it: drag the red ball, or press P", () => this.pushShortly()],
      hang: ["Have it pick up 150 kg", () => this.hang()], ghost: ["See a second law beside it", () => this.beside(["modular"])], world: ["Make it a machine as built", () => this.world("real")] };
    const list = element("first-minute");
    list.innerHTML = `<p>Try it <button aria-label="Close">×</button></p>`;
    list.querySelector("button").addEventListener("click", () => (list.hidden = true));
    this.tried = Object.entries(steps).map(([name, [text, act]]) => {
      const item = document.createElement("li");
      const button = document.createElement("button");
      button.textContent = text;
      button.addEventListener("click", () => this.attempt(act));
      item.append(button);
      list.append(item);
      return [name, item];
    });
  }

  done(name) {
    this.tried.find(([key]) => key === name)?.[1].classList.add("done");
  }
}

const page = new LivePage();
const ready = page.open();
ready.catch((error) => {
  element("broken").textContent = `The machine cannot be started: ${error.message}`;
  element("broken").hidden = false;
});
window.machine = {
  ready,
  restart: (settings) => page.start({ ...settings }),
  play: () => page.play(),
  pause: () => page.pause(),
  advance: async (seconds) => {
    await page.pause();
    await page.ensemble.advance(seconds);
  },
  get: (name) => page.ensemble.main.get(name),
  set: (name, value) => page.set(name, value),
  get time() {
    return page.ensemble?.time ?? NaN;
  },
  verdict: () => page.ensemble.main.verdict(),
};
