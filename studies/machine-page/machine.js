/* The live machine: puts engines, scene, levers, panel and scopes together. */
import { Ensemble, WORLDS, forEngine } from "./ensemble.js";
import { LAWS, Panel } from "./controls.js";
import { Levers, LEVER_KEYS } from "./drive.js";
import { rotated } from "./kinematics.js";
import { LiveScene } from "./live_scene.js";
import { Recorder } from "./records.js";
import { Page, element, html, scripted, tickBox } from "./page.js";
import { Monitor } from "./monitor.js";
import { fixed, readable } from "./scopes.js";
import { ACTUATORS, SIGNALS } from "./signals.js";
import { download, json, part } from "./parts.js";
import { addressOf, elements, settingsOf } from "./variables.js";

/* What one sees first: it moves at once, and with all joints. */
const FIRST = { trajectory: "path", "controller.path_file": "six-joints", "controller.settle_time": "0.3" };
const GHOST_LAWS = ["adaptive", "modular", "pd", "modular_integral"];
/* Largest rates of the levers, by kind; the controller limits them too. */
const MOST = { joint: [0.15, 0.1, 0.1, 0.5, 0.5, 0.5], tip: [0.25, 0.25, 0.25, 0.3, 0.3, 0.3] };
const PUSH = { force: 300, duration: 0.2 };
/* Name of the file that the controller is given waypoints in. */
const PATH = "waypoints";

class LivePage extends Page {
  constructor() {
    super();
    document.body.classList.add("starting");
    this.data = json("scene");
    this.log = [];
    this.waypoints = [];
    this.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.levers = new Levers(element("levers"), (kind) => MOST[kind], (kind, rates) => this.command(kind, rates));
    const sheets = Object.fromEntries([...document.querySelectorAll("[data-sheet]")].map((sheet) => [sheet.dataset.sheet, sheet]));
    this.panel = new Panel(sheets, (control, values) => this.change(control, values));
    this.recorder = new Recorder();
    this.monitor = new Monitor(this.data, (rank, text) => this.alarm(rank, text));
    this.buttons();
    this.firstMinute();
    this.takeFiles(["waypoint-file", "settings-file"], "Waypoints or settings");
  }

  async open() {
    this.ensemble = await Ensemble.begin({ engine: part("engine"), system: part("system") });
    // The picture is made while the worker opens the archive and starts the run.
    this.pictured = new Promise((turn) => document.addEventListener("DOMContentLoaded", turn)).then(() => this.picture());
    await Promise.all([this.ensemble.main.opened, this.ofAddress()]);
    window.addEventListener("hashchange", () => this.attempt(() => this.ofAddress()));
  }

  picture() {
    this.scene = new LiveScene(element("stage"), this.data, (force) => this.push(force), (point) => this.addWaypoint(point));
  }

  /* Shows the page, once. Before there is something that moves it would only keep the processor that starts the machine busy: without a
   * graphics processor each picture of the window takes long. */
  reveal() {
    if (!document.body.classList.contains("starting")) return;
    document.body.classList.remove("starting");
    if (this.scene) requestAnimationFrame((now) => this.tick(now));
  }

  ofAddress() {
    const { settings, ghosts } = settingsOf(location.hash);
    return this.start(Object.keys(settings).length ? settings : FIRST, ghosts);
  }

  /* Laws of the ghosts. */
  get laws() {
    return [...this.ensemble.ghosts.keys()];
  }

  /* Starts with these settings, at the joints' present angles where it is `there`, and says why where a reason is given; what is refused
   * leaves the run as it is. */
  async start(settings, ghosts = this.laws, why = "", there = false) {
    const playing = this.playing;
    if (this.settings) await this.pause();
    if (there) SIGNALS.zeta.forEach((name, k) => (settings[name.replace("zeta", "zeta_start")] = this.monitor.now("zeta")[k]));
    try {
      const laws = ghosts.filter((law) => law in LAWS);
      if (laws.join() === this.laws.join()) await this.ensemble.restart(settings);
      else await this.ensemble.beside(laws, settings);
      this.settings = settings;
      [this.log, this.lost, this.pushed, this.commanded] = [[], null, null, new Array(6).fill(0)];
      element("moments").replaceChildren();
      element("broken").hidden = true;
      await this.know();
      await this.watch();
      // It moves before the panel follows.
      if (playing) this.play();
      this.reveal();
      this.panel.build(this.variables);
      await this.follow();
      history.replaceState(null, "", addressOf(settings, this.laws));
      this.say(why);
      await this.judge();
    } finally {
      if (playing && !this.playing) this.play();
    }
  }

  /* The variables of the running system, which are asked for once. */
  async know() {
    const { structure } = forEngine(this.settings);
    this.catalogs ??= new Map();
    if (!this.catalogs.has(structure)) this.catalogs.set(structure, new Map(elements(await this.engine.variables()).map((variable) => [variable.name, variable])));
    this.variables = this.catalogs.get(structure);
  }

  /* The panel shows what the running system has. */
  async follow() {
    await this.panel.follow((name) => this.engine.get(name));
    const { trajectory } = this.settings;
    const file = this.settings["controller.path_file"];
    const kind = this.settings["controller.rate.command"] ?? "joint";
    const path = file && [...element("trajectory").options].some((o) => o.value === `path ${file}`) ? `path ${file}` : "waypoints";
    element("trajectory").value = trajectory === "rates" ? `rates ${kind}` : trajectory === "path" ? path : (trajectory ?? "cubic");
    element("waypoint-tools").hidden = element("trajectory").value !== "waypoints";
    element("world").value = this.settings.world ?? "ideal";
    this.levers.lead(kind);
    this.hanging = this.variables.has("hdrm.load.mass") && (await this.engine.get("hdrm.load.mass")) > 0;
    this.sayHanging();
    for (const box of element("ghosts").querySelectorAll("input")) box.checked = this.ensemble.ghosts.has(box.value);
  }

  /* Tells the engines what to send. */
  async watch() {
    const { main, ghosts } = this.ensemble;
    this.monitor.restart(this.variables, this.laws, this.settings);
    this.recorder.restart(this.monitor.names);
    await this.pictured;
    this.scene.clear();
    this.scene.showGhosts(this.laws.map((_, k) => this.monitor.ghostColor(k)));
    main.onframe = (frame) => this.frame(frame);
    await main.watch(this.monitor.names);
    await Promise.all([...ghosts.values()].map((ghost, k) => {
      ghost.onframe = (frame) => this.monitor.ghostFrame(frame, k);
      return ghost.watch(this.monitor.ghostNames);
    }));
  }

  frame(frame) {
    if (!this.monitor.frame(frame)) return;
    this.recorder.add(frame.history, 1 + this.monitor.names.length);
    this.latest = frame;
    if (frame.error && this.playing) this.ended(frame.error);
    if (this.pushed && frame.time >= this.pushed) this.push([0, 0, 0]);
    if (!frame.error) this.ensemble.tend();
  }

  /* Says it where nothing worse was said. */
  alarm(rank, text) {
    if (rank <= (this.lost?.rank ?? 0)) return;
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
      this.show();
    }
    if (this.latest) this.monitor.draw(this.latest.time);
    this.scene.draw(now, element("show-labels").checked);
    if (now - (this.told ?? 0) > 120) {
      this.told = now;
      this.numbers();
    }
    if (this.settings && now - (this.judged ?? 0) > 1500) {
      this.judged = now;
      this.judge();
    }
  }

  show() {
    const { now, ghosts } = this.monitor;
    const tilt = now("tilt");
    this.scene.show({
      zeta: now("zeta"), tip: now("tip"), strokes: now("stroke"), desired: now("desired"),
      loadMass: now("load")[0] ?? 0, tilt: tilt.length ? tilt : [0, 0], ghosts });
  }

  numbers() {
    if (!this.latest) return;
    const { time, share } = this.latest;
    const wall = performance.now() / 1000;
    if (!(wall - this.mark?.wall < 1)) {
      this.pace = Math.max(time - (this.mark?.time ?? time), 0) / (wall - (this.mark?.wall ?? 0));
      this.mark = { time, wall };
    }
    const { now, ghostErrors } = this.monitor;
    const [forces, currents, [error]] = [now("force"), now("current"), now("error")];
    element("clock").textContent = `${time.toFixed(2)} s`;
    element("factor").textContent = this.playing ? `${this.pace.toPrecision(2)} ×` : "paused";
    element("share").textContent = this.playing ? `${Math.round(100 * share)} %` : "–";
    const lines = ACTUATORS.map((name, k) => {
      const part = Math.abs(forces[k]) / this.data.rated[k];
      return `<tr><td>${name}</td><td>${fixed(forces[k] / 1000, 1)} kN</td><td><meter min="0" max="1.3" high="1" low="0.8" optimum="0" value="${part}"></meter></td><td>${fixed(currents[k], 1)} A</td></tr>`;
    });
    const beside = this.laws.map((law, k) => `<tr style="color:${this.monitor.ghostColor(k)}"><td>${law}</td><td colspan="3">${readable(1000 * ghostErrors[k])} mm</td></tr>`);
    element("readout").innerHTML = `<table>${lines.join("")}<tr><td><b>tip error</b></td><td colspan="3"><b>${readable(1000 * error)} mm</b></td></tr>${beside.join("")}</table>`;
    this.scene.label(ACTUATORS.map((name, k) => `${name} ${fixed(forces[k] / 1000, 1)} kN, ${fixed(currents[k], 0)} A`));
    if (this.levers.padName) element("gamepad").textContent = `Joystick: ${this.levers.padName}. Left stick: slew and lift; right stick: tilt and turn.`;
    element("csv").disabled = this.recorder.count === 0;
  }

  /* The run's verdict, with the worst that the page has seen of the machine. */
  async verdict() {
    const found = await this.engine.verdict();
    if (!this.lost) return found;
    const findings = [...found.findings, { text: this.lost.text, bad: true }];
    const lines = findings.map(({ bad, text }) => `  ${bad ? "!" : "-"} ${text}\n`);
    return { bad: true, text: `verdict: BAD\n${lines.join("")}`, findings };
  }

  async judge() {
    const { bad, text, findings } = await this.verdict();
    const lost = this.lost?.rank === 2;
    const words = lost ? "lost" : bad ? `bad: ${findings.find((finding) => finding.bad).text}` : "good";
    Object.assign(element("verdict"), { textContent: words, className: bad ? "bad" : "good", title: text });
  }

  say(text) {
    if (!text) return;
    element("message").textContent = text;
    element("message").classList.add("shown");
    clearTimeout(this.silence);
    this.silence = setTimeout(() => element("message").classList.remove("shown"), 6000);
  }

  get engine() {
    return this.ensemble?.main;
  }

  /* The machine's engine, or that of the ghost under this law. */
  engineOf(law) {
    if (law === undefined) return this.engine;
    const ghost = this.ensemble.ghosts.get(law);
    if (!ghost) throw new Error(`There is no ghost under the law ${law}.`);
    return ghost;
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

  async advance(seconds) {
    await this.pause();
    await this.ensemble.advance(seconds);
  }

  async set(name, value) {
    await this.ensemble.set(name, value);
    this.log.push({ time: this.ensemble.time, name, value });
  }

  /* A slider or switch of the panel. */
  change(control, values) {
    return this.attempt(async () => {
      if (control.own === "load") return this.hanging ? this.set("hdrm.load.mass", this.panel.own("load")) : undefined;
      if (control.atOnce) {
        for (const [name, value] of Object.entries(values)) await this.set(name, value);
        Object.assign(this.settings, values);
        history.replaceState(null, "", addressOf(this.settings, this.laws));
      } else {
        await this.start({ ...this.settings, ...values }, undefined, `${control.label}: that needs a standstill, so the machine started again.`);
      }
    });
  }

  /* New rates of the levers. What comes while earlier ones are on their way, or while the levers take over, follows them. */
  async command(kind, rates) {
    this.wanted = rates;
    this.done("levers");
    if (this.commanding) return;
    this.commanding = true;
    await this.attempt(async () => {
      if (this.settings.trajectory !== "rates") await this.lead(`rates ${kind}`);
      while (this.commanded.join() !== this.wanted.join()) {
        const before = this.commanded;
        this.commanded = this.wanted;
        for (const [k, rate] of this.commanded.entries()) if (rate !== before[k]) await this.set(`controller.rate.${kind}[${k + 1}]`, rate);
      }
    });
    this.commanding = false;
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
      settings["controller.rate.command"] = detail;
      return this.start(settings, undefined, "You lead now: the levers, or the keys under them.", true);
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
    const settings = { ...this.settings, trajectory: "path", "controller.path_file": PATH, files, "controller.settle_time": 0.3 };
    return this.start(settings, undefined, "The machine follows your waypoints.", true);
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
    const [w, x, y, z] = this.monitor.now("orientation");
    const inTip = rotated(force, [-x, -y, -z, w]);
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
    this.monitor.cut(time);
    this.recorder.cut(time);
    this.scene.clear();
    [this.lost, this.pushed] = [null, null];
    this.commanded = await Promise.all(this.commanded.map((_, k) => this.engine.get(`controller.rate.${this.levers.kind}[${k + 1}]`)));
    element("broken").hidden = true;
    await this.follow();
    if (this.settings.trajectory === "rates") this.command(this.levers.kind, new Array(6).fill(0));
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

  async keepMoment() {
    const state = await this.ensemble.state();
    const button = html`<button title="Back to this moment">${state.time.toFixed(2)} s</button>`;
    button.addEventListener("click", () => this.attempt(async () => {
      await this.pause();
      await this.ensemble.back(state);
      await this.jumped(`Back at ${state.time.toFixed(2)} s.`);
    }));
    element("moments").append(button);
  }

  buttons() {
    this.on("play", () => (this.playing ? this.pause() : this.play()));
    this.on("step", () => this.advance(this.engine.about.step));
    this.on("undo", () => this.undo());
    this.on("restart", () => this.start(this.settings, undefined, "From the start again."));
    this.on("speed", () => this.playing && this.play(), "change");
    this.on("trajectory", () => this.lead(element("trajectory").value), "change");
    this.on("world", () => this.world(element("world").value), "change");
    this.on("push", () => this.pushShortly());
    this.on("hang", () => this.hang());
    this.on("save", () => this.keepMoment());
    this.on("show-labels", () => (this.scene.dirty = true), "change");
    this.on("error-gain", () => { this.scene.gain = Number(element("error-gain").value); this.scene.clear(); }, "change");
    this.on("waypoint-click", () => this.aim(!this.scene.aiming));
    this.on("waypoint-here", () => this.addWaypoint(this.monitor.now("tip")));
    this.on("waypoint-clear", () => { this.waypoints = []; this.sayWaypoints(); });
    this.on("record", () => { element("record").setAttribute("aria-pressed", this.recorder.toggle()); });
    this.on("csv", () => download("machine.csv", this.recorder.csv(), "text/csv"));
    this.on("settings", () => download("machine.json", this.settingsText(), "application/json"));
    this.on("link", async () => { await navigator.clipboard.writeText(location.href); this.say("The link is copied."); });
    document.querySelectorAll("[data-view]").forEach((button) => button.addEventListener("click", () => this.scene.view(button.dataset.view)));
    Object.entries(WORLDS).forEach(([value, { text }]) => element("world").add(new Option(text, value)));
    const chosen = () => this.beside([...element("ghosts").querySelectorAll("input:checked")].map((box) => box.value));
    element("ghosts").append(...GHOST_LAWS.map((law) => tickBox(LAWS[law], false, chosen, law)));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.scene.theme();
      this.monitor.theme();
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
    const keys = { Space: () => element("play").click(), Period: () => this.advance(this.engine.about.step), Backspace: () => this.undo(), KeyP: () => this.pushShortly(), KeyL: () => this.hang(), KeyO: () => this.aim(!this.scene.aiming) };
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

  /* What to try first; each is crossed off when it was done. */
  firstMinute() {
    const steps = { levers: ["Take the levers: hold W, or drag one below", () => this.lead("rates joint")], push: ["Push it: drag the red ball, or press P", () => this.pushShortly()],
      hang: ["Have it pick up 150 kg", () => this.hang()], ghost: ["See a second law beside it", () => this.beside(["modular"])], world: ["Make it a machine as built", () => this.world("real")] };
    const list = element("first-minute");
    list.querySelector("button").addEventListener("click", () => (list.hidden = true));
    this.tried = Object.entries(steps).map(([name, [text, act]]) => {
      const item = html`<li><button>${text}</button></li>`;
      item.firstChild.addEventListener("click", () => this.attempt(act));
      list.querySelector("ol").append(item);
      return [name, item];
    });
  }

  done(name) {
    this.tried.find(([key]) => key === name)?.[1].classList.add("done");
  }
}

const live = new LivePage();
const opened = live.open();
opened.catch((error) => {
  live.playing = false;
  live.reveal();
  live.alarm(2, `The machine cannot be started: ${error.message}`);
});
scripted(live, opened);
