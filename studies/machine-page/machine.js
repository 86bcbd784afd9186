/* The live machine: puts engines, scene, levers, panel and scopes together. */
import { Ensemble, WORLDS, forEngine } from "./ensemble.js";
import { LAWS, Panel } from "./controls.js";
import { LEVERS, Levers, LEVER_KEYS } from "./drive.js";
import { wrenchAtTip } from "./kinematics.js";
import { LiveScene } from "./live_scene.js";
import { Recorder } from "./records.js";
import { Page, element, html, scripted, tickBox } from "./page.js";
import { Monitor } from "./monitor.js";
import { fixed, readable } from "./scopes.js";
import { ACTUATORS, SIGNALS } from "./signals.js";
import { download, json, part } from "./parts.js";
import { addressOf, copied, elements, settingsOf } from "./variables.js";

/* What a visitor's machine has and the paper's has not: a supervisor, and a floor that the tip meets. */
const { floor: FLOOR } = json("scene");
const EQUIPPED = { "controller.supervisor": "true", "hdrm.contact.stiffness": "2e5", "hdrm.contact.damping": "1", "hdrm.contact.friction": "0.3", ...(FLOOR !== 0 && { "hdrm.contact.offset": `${FLOOR}` }) };
/* What one sees first: it moves at once, and with all joints. When a task is done the next one follows, until a visitor does something. */
const TASKS = [
  { settings: { trajectory: "path", "controller.path_file": "six-joints" } },
  { settings: { trajectory: "triangular" } },
  { settings: { trajectory: "path", "controller.path_file": "iso9283-cube:1" }, changes: [{ time: 1, name: "hdrm.load.mass", value: 150 }] },
  { settings: { trajectory: "cubic" } },
].map(({ settings, changes = [] }) => ({ settings: { ...settings, "controller.settle_time": "0.3", ...EQUIPPED }, changes }));
/* A machine of one's own may not reach these paths: its joints move first, then its file's trajectories are tried. */
const swing = (time, rates) => rates.map((value, k) => ({ time, name: `controller.rate.joint[${k + 1}]`, value }));
const OWN_TASKS = [
  { trajectory: "rates", changes: [...swing(0.5, [0.1, 0.05, 0.05]), ...swing(3.5, [-0.1, -0.05, -0.05]), ...swing(6.5, [0, 0, 0])] },
  { trajectory: "triangular" },
  { trajectory: "cubic" },
].map(({ trajectory, changes = [] }) => ({ settings: { trajectory, "controller.settle_time": "0.3", ...EQUIPPED }, changes }));
/* How long the reference rests before the next task begins, s. */
const TASK_RESTS = 1.5;
/* Two runs that explain the machine, each beside another: what is looked at, and what one sees. */
const EXPLAINED = {
  adaptation: { settings: { trajectory: "path", "controller.path_file": "iso9283-cube:1", "controller.mode": "adaptive", "hdrm.inertia_scale": "1.4", "controller.settle_time": "0.3", ...EQUIPPED },
    ghosts: ["modular"], scopes: ["error", "masses"],
    text: "All bodies are 40 % heavier than the controller was told. The machine's controller learns the masses: its curves in Learnt masses move, and its tip error falls. The ghost trusts the data sheet, and keeps its error." },
  play: { settings: { world: "real", trajectory: "path", "controller.path_file": "iso9283-cube:1", "controller.settle_time": "0.5", ...EQUIPPED, ...Object.fromEntries([1, 2, 3].map((k) => [`emla_${k}.backlash.width`, "2e-4"])) },
    ghosts: [], scopes: ["error", "force", "speed"],
    text: "Nut and rod have 200 µm of play, and sensors err. Where a rod's force changes its sign, the nut crosses the gap: look for steps in Rod speeds and in Tip error. Then take the play away under Add play, friction, sensor errors." },
};
/* Changes of a run that an address holds at most; levers make more. */
const MOST_CHANGES = 200;
const GHOST_LAWS = ["adaptive", "modular", "pd", "modular_integral"];
/* Largest rates of the levers, by kind; the controller limits them too. */
const MOST = { joint: [0.15, 0.1, 0.1, 0.5, 0.5, 0.5], tip: [0.25, 0.25, 0.25, 0.3, 0.3, 0.3] };
const PUSH = { force: 300, duration: 0.2 };
/* What is hung on a machine whose file has no payload: half of it, kg. */
const LOAD_WITHOUT = 300;
/* Name of the file that the controller is given waypoints in. */
const PATH = "waypoints";
/* A bar stays this long after its cause has ended, s of the run. */
const BAR_STAYS = 1;
/* From this state on the supervisor stops the machine; why, by the number of its cause. */
const STOPPING = 5;
const CAUSES = {
  2: "a rod swings", 3: "a rod's force stays above what it is rated for", 4: "a drive has tripped", 5: "the tip does not follow its reference",
  6: "a joint's encoder, its motor and its rod tell different motions", 7: "a joint's angle and its rate do not fit", 8: "a sensor's reading no longer changes",
  9: "a motor's torque does not fit the force of its rod: a brake drags, or a sensor errs", 10: "a drive does not give the commanded current", 11: "a joint of the wrist runs away",
};
const RESET_TAKES = 0.1;
/* The input by which a drive tells the supervisor that it has tripped. Where a drive is there to do so, the button overrides it. */
const STOP = "controller.tripped[1]";
const STOP_NEEDS = "The emergency stop needs the supervisor: tick it under Controller.";
/* A joint or rod this near to its limit is at the end of its travel, rad and m; a body this near to the floor is warned of, m. */
const [JOINT_END, STROKE_END, FLOOR_NEAR] = [0.02, 0.01, 0.1];
/* A slider leads its joint with this gain, 1/s; it is where it was put when it is this near, rad. */
const [JOINT_GAIN, JOINT_THERE] = [2, 2e-3];
/* After a script has advanced the run: it rests from so long on; until then a picture comes that often, ms. */
const [SCRIPT_RESTS, SCRIPT_PICTURES] = [60, 500];

class LivePage extends Page {
  constructor() {
    super();
    document.body.classList.add("starting");
    this.data = json("scene");
    Object.assign(this, { log: [], plan: [], wantedLaws: [], waypoints: [], bars: new Map(), tour: null, load: 0 });
    this.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.levers = new Levers(element("levers"), (kind) => MOST[kind], (kind, rates) => this.command(kind, rates), (text) => this.joystick(text));
    const sheets = Object.fromEntries([...document.querySelectorAll("[data-sheet]")].map((sheet) => [sheet.dataset.sheet, sheet]));
    this.tasks = this.data.file ? OWN_TASKS : TASKS;
    this.first = this.tasks[0].settings;
    this.payload = this.data.bodies.find(({ name }) => name === "PL").mass || LOAD_WITHOUT;
    this.panel = new Panel(sheets, this.payload, (control, values) => this.change(control, values));
    this.recorder = new Recorder();
    this.monitor = new Monitor(this.data, (...its) => this.alarm(...its));
    this.buttons();
    this.jointSliders();
    this.firstMinute();
    this.introduce();
    this.takeFiles(["waypoint-file", "settings-file"], "Waypoints or settings");
  }

  async open() {
    const read = new Promise((turn) => document.addEventListener("DOMContentLoaded", turn));
    this.ensemble = await Ensemble.begin({ engine: part("engine"), system: part("system") });
    // The picture is made while the worker opens the archive and starts the run, which it is told first.
    this.pictured = read.then(() => new Promise((turn) => setTimeout(turn))).then(() => this.picture());
    window.addEventListener("hashchange", () => this.attempt(() => this.ofAddress()));
    await Promise.all([this.ensemble.main.opened, this.ofAddress()]);
  }

  /* Replaces, moves or changes the run, each after the one before: any order of clicks is one of whole acts. */
  inTurn(act) {
    const done = (this.turn ?? Promise.resolve()).then(act);
    this.turn = done.catch(() => {});
    return done;
  }

  picture() {
    this.scene = new LiveScene(element("stage"), this.data, (...push) => this.push(...push), (point) => this.addWaypoint(point));
    // Unseen, so that the graphics' programs are compiled when the machine begins to move.
    this.scene.draw(performance.now(), false);
  }

  /* Shows the page, once. Before there is something that moves it would only keep the processor that starts the machine busy: without a
   * graphics processor each picture of the window takes long. */
  reveal() {
    if (!document.body.classList.contains("starting")) return;
    document.body.classList.remove("starting");
    if (this.scene) requestAnimationFrame((now) => this.tick(now));
  }

  ofAddress() {
    if (location.hash.length < 2) {
      this.tour = 0;
      return this.start(this.first, { ghosts: [], changes: this.tasks[0].changes, shows: true });
    }
    const { settings, ghosts, changes } = settingsOf(location.hash);
    return this.start(Object.keys(settings).length ? settings : this.first, { ghosts, changes });
  }

  /* Laws of the ghosts. */
  get laws() {
    return [...this.ensemble.ghosts.keys()];
  }

  /* Starts with these settings, or what this function makes of the present ones, and with changes to come; at the joints' present angles where
   * it is `there`; `again` has the changes that the run before was to have, `shows` keeps the tasks going. Says why where a reason is given. What
   * is refused leaves the run as it is. */
  start(settings, { ghosts, changes = [], again = false, shows = false, why = "", there = false, unless } = {}) {
    if (!shows) this.tour = null;
    return this.inTurn(async () => {
      if (unless?.()) return;
      if (this.settings) await this.ensemble.pause();
      const asked = { ...(typeof settings === "function" ? settings(this.settings) : settings) };
      if (there) SIGNALS.zeta.forEach((name, k) => (asked[name.replace("zeta", "zeta_start")] = this.monitor.now("zeta")[k]));
      const laws = (ghosts ?? this.wantedLaws).filter((law) => law in LAWS);
      try {
        const plan = again ? this.plan : changes;
        await this.ensemble.restart(asked, laws, plan);
        Object.assign(this, { settings: asked, plan, log: [...plan], lost: null, pushed: null, resets: null, commanded: new Array(6).fill(0), load: 0 });
        Object.assign(this, { began: { ...asked }, run: {} });
        if (!there) this.goals.fill(null);
        this.bars.clear();
        element("moments").replaceChildren();
        await this.know();
        await this.watch();
        // It moves before the panel follows.
        this.goOn();
        this.reveal();
        this.panel.build(this.variables);
        history.replaceState(null, "", this.address());
        this.say(why);
      } finally {
        this.wantedLaws = ghosts || !this.settings ? this.laws : this.wantedLaws.filter((law) => this.ensemble.ghosts.has(law) || !laws.includes(law));
        if (this.settings) {
          this.goOn();
          await this.showPanel();
        }
      }
      await this.judge();
    });
  }

  /* Plays where that is wanted. */
  goOn() {
    if (this.playing) this.ensemble.play(Number(element("speed").value)).catch((error) => this.say(error.message));
    this.sayPlaying();
  }

  /* The address of the run; a browser takes only so many in a time. */
  keepAddress() {
    if (this.addressing) return;
    this.addressing = true;
    setTimeout(() => {
      this.addressing = false;
      history.replaceState(null, "", this.address());
    }, 100);
  }

  address() {
    const changes = this.log.length > MOST_CHANGES ? [] : this.log;
    return addressOf(this.began, { ghosts: this.laws, changes });
  }

  /* The variables of the running system, which are asked for once. */
  async know() {
    const { structure } = forEngine(this.settings);
    this.catalogs ??= new Map();
    if (!this.catalogs.has(structure)) this.catalogs.set(structure, new Map(elements(await this.engine.variables()).map((variable) => [variable.name, variable])));
    this.variables = this.catalogs.get(structure);
  }

  /* The panel shows what the running system has. */
  follow() {
    return this.inTurn(() => this.settings && this.showPanel());
  }

  async showPanel() {
    await this.panel.follow((name) => this.engine.get(name), this.settings);
    const { trajectory } = this.settings;
    const file = this.settings["controller.path_file"];
    const kind = this.settings["controller.rate.command"] ?? "joint";
    const path = file && [...element("trajectory").options].some((o) => o.value === `path ${file}`) ? `path ${file}` : "waypoints";
    element("trajectory").value = trajectory === "rates" ? `rates ${kind}` : trajectory === "path" ? path : (trajectory ?? "cubic");
    element("waypoint-tools").hidden = element("trajectory").value !== "waypoints";
    element("world").value = this.settings.world ?? "ideal";
    this.levers.lead(kind);
    this.sayHanging(this.variables.has("hdrm.load.mass") && (await this.engine.get("hdrm.load.mass")) > 0);
    for (const box of element("ghosts").querySelectorAll("input")) box.checked = this.wantedLaws.includes(box.value);
    element("emergency").disabled = !this.canStop;
    element("emergency").title = this.canStop ? "Emergency stop: brakes on, drives off (escape)" : STOP_NEEDS;
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
      ghost.onframe = (frame) => {
        this.monitor.ghostFrame(frame, k);
        // It may come after the machine's last frame was drawn.
        this.shown = null;
      };
      return ghost.watch(this.monitor.ghostNames);
    }));
  }

  frame(frame) {
    if (frame.time !== this.latest?.time && this.monitor.look) this.monitor.lookAt(null);
    if (!this.monitor.frame(frame)) return;
    this.recorder.add(frame.history, 1 + this.monitor.names.length);
    this.latest = frame;
    const load = this.monitor.now("load")[0] ?? 0;
    if (load !== this.load) this.sayHanging((this.load = load) > 0);
    if (frame.error && this.playing) this.ended(frame.error);
    if (this.pushed && frame.time >= this.pushed) this.push([0, 0, 0]);
    if (this.resets && frame.time >= this.resets) this.released();
    if (!frame.error) this.ensemble.tend();
    this.nextTask(frame.time);
  }

  /* The next of the tasks that are shown to who only looks. */
  nextTask(time) {
    if (this.tour === null || !this.playing || time - this.monitor.rests < TASK_RESTS || this.touring) return;
    this.touring = true;
    const task = this.tasks[(this.tour += 1) % this.tasks.length];
    this.attempt(() => this.start(task.settings, { changes: task.changes, shows: true }).finally(() => (this.touring = false)));
  }

  /* A cause for a bar: it is shown until its cause has ended for a second, or until it is closed. The worst one of a run counts for the
   * verdict. */
  alarm(rank, text, kind = "run", time = Infinity) {
    const known = this.bars.get(kind);
    if (known) known.time = time;
    else this.bars.set(kind, { rank, text, time, closed: false });
    if (rank >= 1 && rank > (this.lost?.rank ?? 0)) {
      this.lost = { rank, text };
      if (this.settings) this.attempt(() => this.judge());
    }
    this.showBar();
  }

  showBar() {
    const now = this.latest?.time ?? 0;
    for (const [kind, { time }] of this.bars) if (now - time > BAR_STAYS || (time !== Infinity && time > now + BAR_STAYS)) this.bars.delete(kind);
    const bar = [...this.bars.values()].filter(({ closed }) => !closed).reduce((worst, one) => (one.rank > (worst?.rank ?? -1) ? one : worst), null);
    const { stage, cause } = this.monitor;
    const stopped = stage >= STOPPING && cause in CAUSES;
    const text = stopped ? `Stopped by the supervisor: ${this.emergency ? "the emergency stop was pressed" : CAUSES[cause]}.` : (bar?.text ?? "");
    if (element("broken-text").textContent !== text) element("broken-text").textContent = text;
    element("broken").hidden = !text;
    element("broken").classList.toggle("warning", !stopped && bar?.rank < 1);
    element("reset").hidden = !stopped;
    element("broken-close").hidden = stopped;
  }

  closeBar() {
    this.bars.forEach((bar) => (bar.closed = true));
    this.showBar();
  }

  /* The run goes on no more. */
  ended(error) {
    this.alarm(2, `The run ended at ${this.ensemble.time.toFixed(2)} s: ${error}`);
    this.pause();
  }

  get canStop() {
    return this.variables?.has(STOP) && String(this.settings["controller.supervisor"]) === "true";
  }

  /* As a drive that trips: the supervisor brakes all. */
  stopAll() {
    this.tour = null;
    return this.inTurn(async () => {
      if (!this.canStop) throw new Error(STOP_NEEDS);
      await this.press(true);
    });
  }

  /* Presses the button or lets it go; a drive that is connected to the input is overridden. */
  async press(pressed) {
    const driver = await this.engine.driver(STOP);
    await this.put(STOP, driver === null ? pressed : `override:${pressed || ""}`);
    this.emergency = pressed;
  }

  /* After a stop the machine is ready again where it stands. */
  reset() {
    this.tour = null;
    return this.inTurn(async () => {
      if (this.emergency) await this.press(false);
      await this.put("controller.reset", true);
      this.resets = this.ensemble.time + RESET_TAKES;
      this.say(this.settings.trajectory === "rates" ? "Reset: the levers lead again." : "Reset: it rests here. A lever or a path sets it in motion again.");
    });
  }

  /* The button is let go. */
  released() {
    this.resets = null;
    this.attempt(() => this.set("controller.reset", false));
  }

  /* One picture. */
  tick(now) {
    requestAnimationFrame((next) => this.tick(next));
    this.levers.poll();
    // A script that advances in small pieces waits for no picture: one comes when it rests, and a few meanwhile.
    if (performance.now() - (this.advanced ?? -Infinity) < SCRIPT_RESTS && now - (this.drawn ?? 0) < SCRIPT_PICTURES) return;
    this.drawn = now;
    if (this.latest && (this.monitor.look ?? this.latest) !== this.shown) {
      this.shown = this.monitor.look ?? this.latest;
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
      this.attempt(() => this.judge());
    }
  }

  show() {
    const { seen: now, look } = this.monitor;
    const { ghosts } = look ?? this.monitor;
    const tilt = now("tilt");
    this.scene.show({
      zeta: now("zeta"), tip: now("tip"), strokes: now("stroke"), forces: now("force"), desired: now("desired"), contact: now("contact").length ? now("contact") : [0, 0, 0],
      loadMass: now("load")[0] ?? 0, tilt: tilt.length ? tilt : [0, 0], ghosts });
  }

  /* What is at its end of travel is told on its lever; what comes too near to the floor by a bar. */
  limits(time) {
    const { now } = this.monitor;
    const [zeta, stroke] = [now("zeta"), now("stroke")];
    const end = (value, [least, most], margin) => (value > most - margin ? 1 : value < least + margin ? -1 : 0);
    this.levers.atEnd = this.data.joints.map((range, k) => end(zeta[k], range, JOINT_END) || (k < 3 ? end(stroke[k], this.data.strokes[k], STROKE_END) : 0));
    const { height, title } = this.scene.lowest();
    if (height < FLOOR_NEAR) this.alarm(0.5, height > 0 ? `The ${title} is close to the floor.` : `The ${title} is in the floor, which only the tip meets in this computation.`, "floor", time);
  }

  numbers() {
    if (!this.latest) return;
    const { share, time: present } = this.latest;
    const { time } = this.monitor.look ?? this.latest;
    element("scrub").max = present;
    if (!this.monitor.look) element("scrub").value = present;
    const wall = performance.now() / 1000;
    if (!(wall - this.mark?.wall < 1)) {
      this.pace = Math.max(present - (this.mark?.time ?? present), 0) / (wall - (this.mark?.wall ?? 0));
      this.mark = { time: present, wall };
    }
    const { seen: now, look } = this.monitor;
    const { ghostErrors } = look ?? this.monitor;
    const [forces, currents, [error]] = [now("force"), now("current"), now("error")];
    element("clock").textContent = `${time.toFixed(2)} s`;
    element("factor").textContent = this.playing ? this.pace.toPrecision(2) : "paused";
    element("share").textContent = this.playing ? `${Math.round(100 * share)} %` : "–";
    const lines = ACTUATORS.map((name, k) => {
      const part = Math.abs(forces[k]) / this.data.rated[k];
      return `<tr><td>${name}</td><td>${fixed(forces[k] / 1000, 1)} kN</td><td><meter min="0" max="1.3" high="1" low="0.8" optimum="0" value="${part}"></meter></td><td>${fixed(currents[k], 1)} A</td></tr>`;
    });
    const beside = this.laws.map((law, k) => `<tr style="color:${this.monitor.ghostColor(k)}"><td>${law}</td><td colspan="3">${readable(1000 * ghostErrors[k])} mm</td></tr>`);
    element("readout").innerHTML = `<table>${lines.join("")}<tr><td><b>tip error</b></td><td colspan="3"><b>${readable(1000 * error)} mm</b></td></tr>${beside.join("")}</table>`;
    this.scene.label(ACTUATORS.map((name, k) => `${name} ${forces[k] < 0 ? "pulls" : "pushes"} ${fixed(Math.abs(forces[k]) / 1000, 1)} kN, ${fixed(currents[k], 0)} A`));
    this.limits(present);
    this.followSliders();
    this.showBar();
    const length = this.recorder.seconds;
    element("csv").disabled = this.recorder.count === 0;
    element("csv").textContent = length > 0 ? `Download CSV (${readable(length)} s)` : "Download CSV";
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
    const words = lost ? "machine lost" : bad ? findings.find((finding) => finding.bad).text : "no faults";
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
    return this.inTurn(() => this.settings && this.goOn());
  }

  /* Picture and scopes as they were; the run waits. At its end, and when it goes on, they are at the present. */
  async lookBack(time) {
    if (this.playing) await this.pause();
    this.monitor.lookAt(time > this.ensemble.time - 0.05 ? null : time);
    this.scene.clear();
  }

  async pause() {
    this.playing = false;
    this.sayPlaying();
    await this.inTurn(() => this.ensemble.pause());
  }

  sayPlaying() {
    element("play").textContent = this.playing ? "❚❚ Pause" : "▶ Run";
  }

  advance(seconds) {
    this.tour = null;
    return this.inTurn(async () => {
      if (this.playing) {
        this.playing = false;
        await this.ensemble.pause();
        this.sayPlaying();
      }
      await this.ensemble.advance(seconds);
      this.advanced = performance.now();
    });
  }

  set(name, value) {
    this.tour = null;
    return this.inTurn(() => this.put(name, value));
  }

  /* Sets it now, and remembers it for the address and the settings; what is `kept` is a setting of later runs too. */
  async put(name, value, kept = false) {
    const time = await this.ensemble.set(name, value);
    const last = this.log.at(-1);
    if (last?.name === name && last.time === time) this.log.pop();
    this.log.push({ time, name, value, kept });
    if (kept) this.settings[name] = value;
    this.keepAddress();
  }

  /* A slider or switch of the panel. */
  change(control, values) {
    return this.attempt(async () => {
      if (control.own === "load") return this.hanging ? this.set("hdrm.load.mass", this.panel.own("load")) : undefined;
      if (!control.atOnce) {
        return this.start((now) => ({ ...now, ...values }), { again: true, why: `${control.label}: that needs a standstill, so the machine started again.` });
      }
      this.tour = null;
      return this.inTurn(async () => {
        for (const [name, value] of Object.entries(values)) await this.put(name, value, true);
      });
    });
  }

  /* New rates of the levers. What comes while earlier ones are on their way, or while the levers take over, follows them. */
  async command(kind, rates) {
    this.wanted = rates;
    this.done("levers");
    if (this.commanding) return;
    this.commanding = true;
    await this.attempt(async () => {
      if (this.settings.trajectory !== "rates" || this.tour !== null) await this.lead(`rates ${kind}`);
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
    const others = (settings) => Object.fromEntries(Object.entries(settings).filter(([name]) => !/^controller\.(path_file|rate\.|settle_time)|^trajectory$|^files$|zeta_start/.test(name)));
    const led = (own) => (settings) => ({ ...others(settings), trajectory, "controller.settle_time": 0.3, ...own });
    if (trajectory === "rates") {
      // A task that is shown ends: its changes to come are not the visitor's.
      if (this.settings.trajectory === "rates" && this.tour === null) {
        await this.inTurn(() => this.put("controller.rate.command", detail, true));
        return this.follow();
      }
      return this.start(led({ "controller.rate.command": detail }), { why: "You lead now: the levers, or the keys under them.", there: true });
    }
    if (trajectory !== "waypoints") return this.start(led(trajectory === "path" ? { "controller.path_file": detail } : {}), { why: "The machine started again, on that path." });
    element("waypoint-tools").hidden = false;
    if (this.waypoints.length < 2) return this.say("Click two waypoints or more into the picture, or drop a file.");
    return this.follows({ waypoints: this.waypoints.map((position) => ({ position, dwell: 0.2 })), limits: { speed: 0.2, acceleration: 0.5, jerk: 3 } });
  }

  /* Follows a path from where the machine stands: waypoints, or the text of a file. */
  follows(path) {
    const files = { [PATH]: typeof path === "string" ? path : JSON.stringify(path) };
    const own = { trajectory: "path", "controller.path_file": PATH, files, "controller.settle_time": 0.3 };
    return this.start((settings) => ({ ...settings, ...own }), { why: "The machine follows your waypoints.", there: true });
  }

  /* Another waypoint; one that cannot be reached is taken back. */
  addWaypoint(point) {
    this.waypoints.push(point.map((v) => Number(v.toFixed(3))));
    this.sayWaypoints();
    if (this.waypoints.length < 2) return;
    const taken = this.waypoints.at(-1);
    this.attempt(() => this.lead("waypoints").catch((error) => {
      this.waypoints = this.waypoints.filter((one) => one !== taken);
      this.sayWaypoints();
      throw new Error(this.waypointWords(error.message, taken));
    }));
  }

  /* What is wrong with a waypoint, for people: of all that the check of the path says, what it says first. */
  waypointWords(message, point) {
    const [, joint, stroke, force] = /joint \d \(([\w ]+)\)|stroke of (\w+)|force of (\w+)/.exec(message) ?? [];
    const why = force && !joint ? `the ${force} rod would be overloaded` : joint || stroke ? `${joint ?? stroke} would go beyond its end of travel` : /reach/.test(message) ? "it is out of reach" : message;
    return `The machine cannot reach the point ${point.join(", ")} m (forward, up, right): ${why}. The point is taken back; click nearer to the others.`;
  }

  sayWaypoints() {
    this.scene.setWaypoints(this.waypoints);
    const last = this.waypoints.at(-1);
    element("waypoint-count").textContent = last ? `${this.waypoints.length}, the last at ${last.join(", ")} m (forward, up, right).` : "No waypoints yet.";
  }

  /* A force at a point of a body, or at the tip, N, in world axes; it stays until the next one. The machine has an input at the tip alone: it
   * is given the wrench that acts on the joints in the same way. */
  push(force, { name, point } = { name: "T4", point: [0, 0, 0] }) {
    this.pushed = null;
    const isPushed = force.some((f) => f !== 0);
    if (isPushed) this.done("push");
    const wrench = isPushed ? wrenchAtTip(this.data.tree, this.monitor.now("zeta"), name, point, force) : new Array(6).fill(0);
    Object.assign(this.scene, { arrowForce: force, grip: { name, point }, dirty: true });
    return this.attempt(() => {
      if (!wrench.every(Number.isFinite)) throw new Error("With the wrist stretched like this only the tip can be pushed.");
      return Promise.all(wrench.map((f, k) => this.set(`hdrm.wrench_env[${k + 1}]`, f)));
    });
  }

  pushShortly() {
    this.push([0, 0, PUSH.force]);
    this.pushed = this.ensemble.time + PUSH.duration;
    this.say(`Pushed with ${PUSH.force} N for ${PUSH.duration} s.`);
  }

  hang() {
    this.done("hang");
    this.tour = null;
    return this.attempt(() => this.inTurn(async () => {
      const hangs = !this.hanging;
      await this.put("hdrm.load.mass", hangs ? this.panel.own("load") : 0);
      this.sayHanging(hangs);
    }));
  }

  sayHanging(hangs) {
    this.hanging = hangs;
    element("hang").setAttribute("aria-pressed", hangs);
    element("hang").textContent = hangs ? "Set down the load" : "Pick up the load";
  }

  beside(laws) {
    if (laws.length) this.done("ghost");
    this.wantedLaws = laws;
    const alike = () => [...this.laws].sort().join() === [...this.wantedLaws].sort().join();
    return this.attempt(() => this.start((now) => now, { again: true, shows: true, unless: alike, why: "All started again, so that they begin alike." }));
  }

  /* After a jump in time nothing later is shown. */
  async jumped(text) {
    const { time } = this.ensemble;
    this.monitor.cut(time);
    this.recorder.cut(time);
    this.scene.clear();
    Object.assign(this, { lost: null, pushed: null, resets: null, tour: null });
    this.bars.clear();
    // What was changed later has not happened, but what the run was to have is still to come.
    this.log = this.log.filter((change) => change.time <= time + 1e-9 || this.plan.includes(change));
    this.settings = { ...this.began, ...Object.fromEntries(this.log.filter(({ kept }) => kept).map(({ name, value }) => [name, value])) };
    this.emergency = this.canStop && Boolean(await this.engine.get(STOP));
    this.commanded = await Promise.all(this.commanded.map((_, k) => this.engine.get(`controller.rate.${this.levers.kind}[${k + 1}]`)));
    await this.showPanel();
    this.keepAddress();
    if (this.settings.trajectory === "rates") this.command(this.levers.kind, new Array(6).fill(0));
    this.say(text);
  }

  /* Goes to an earlier state; `jump` tells how, and says it. */
  goBack(jump) {
    return this.attempt(() => this.inTurn(async () => {
      await this.ensemble.pause();
      try {
        await this.jumped(await jump());
      } finally {
        this.goOn();
      }
    }));
  }

  undo() {
    return this.goBack(async () => {
      const before = this.ensemble.time;
      return `Back by ${(before - (await this.ensemble.undo())).toFixed(1)} s.`;
    });
  }

  keepMoment() {
    return this.inTurn(async () => {
      const [state, { run }] = [await this.ensemble.state(), this];
      const button = html`<button title="Back to this moment">${state.time.toFixed(2)} s</button>`;
      button.addEventListener("click", () => {
        this.playing = false;
        this.sayPlaying();
        this.goBack(async () => {
          if (run !== this.run) throw new Error("That moment is of an earlier run.");
          await this.ensemble.back(state);
          return `Back at ${state.time.toFixed(2)} s.`;
        });
      });
      element("moments").append(button);
    });
  }

  buttons() {
    this.on("play", () => (this.playing ? this.pause() : this.play()));
    this.on("scrub", () => this.lookBack(Number(element("scrub").value)), "input");
    this.on("step", () => this.advance(this.engine.about.step));
    this.on("undo", () => this.undo());
    this.on("restart", () => this.start((now) => now, { again: true, why: "From the start again." }));
    this.on("emergency", () => this.stopAll());
    this.on("reset", () => this.reset());
    this.on("full", () => (document.fullscreenElement ? document.exitFullscreen() : element("stage").requestFullscreen()));
    this.on("picture", async () => download("machine.png", await this.scene.picture(), "image/png"));
    this.on("explain-adaptation", () => this.explain("adaptation"));
    this.on("explain-play", () => this.explain("play"));
    for (const id of ["about-link", "about-short"]) this.on(id, () => { element("what").open = true; element("what").scrollIntoView({ block: "start" }); });
    this.on("broken-close", () => this.closeBar());
    this.on("speed", () => this.playing && this.play(), "change");
    this.on("trajectory", () => this.lead(element("trajectory").value), "change");
    this.on("world", () => this.world(element("world").value), "change");
    this.on("push", () => this.pushShortly());
    this.on("hang", () => this.hang());
    this.on("save", () => this.keepMoment());
    this.on("show-labels", () => (this.scene.dirty = true), "change");
    this.on("show-chart", () => this.scene.showChart(element("show-chart").checked), "change");
    this.on("error-gain", () => { this.scene.gain = Number(element("error-gain").value); this.scene.clear(); }, "change");
    this.on("waypoint-click", () => this.aim(!this.scene.aiming));
    this.on("waypoint-here", () => this.addWaypoint(this.monitor.now("tip")));
    this.on("waypoint-back", () => { this.waypoints.pop(); this.sayWaypoints(); return this.waypoints.length > 1 ? this.lead("waypoints") : undefined; });
    this.on("waypoint-clear", () => { this.waypoints = []; this.sayWaypoints(); });
    this.on("pad-reset", () => this.levers.forget());
    this.on("record", () => { element("record").setAttribute("aria-pressed", this.recorder.toggle()); });
    this.on("csv", () => download("machine.csv", this.recorder.csv((name) => this.variables.get(name)?.unit), "text/csv"));
    this.on("settings", () => download("machine.json", this.settingsText(), "application/json"));
    this.on("link", () => this.copyLink());
    this.levers.relabelled = () => this.keyTable();
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

  explain(name) {
    const { settings, ghosts, scopes, text } = EXPLAINED[name];
    element("explanation").textContent = text;
    this.monitor.chosen = new Set(scopes);
    return this.start(settings, { ghosts, why: text });
  }

  /* A slider for each joint, over its range: the machine goes where it is put, as fast as the levers may. */
  jointSliders() {
    this.goals = this.data.joints.map(() => null);
    Object.assign(this, { near: [], followed: 0 });
    this.sliders = this.data.joints.map(([least, most], k) => {
      const row = html`<label class="row"><span>${LEVERS.joint[k].name}</span><b></b><input type="range" min="${least}" max="${most}" step="0.001"></label>`;
      const field = row.querySelector("input");
      field.addEventListener("input", () => (this.goals[k] = Number(field.value)));
      element("joints").append(row);
      return { field, text: row.querySelector("b") };
    });
  }

  /* Sliders show where the joints are, except one that leads its joint there. */
  followSliders() {
    const zeta = this.monitor.now("zeta");
    this.sliders.forEach(({ field, text }, k) => {
      const degrees = (angle) => `${Math.round((180 / Math.PI) * angle)}°`;
      const words = `${degrees(zeta[k])} of ${this.data.joints[k].map(degrees).join(" to ")}`.replaceAll("-", "−");
      if (text.textContent !== words) text.textContent = words;
      if (this.goals[k] === null) field.value = zeta[k];
    });
    if (this.goals.every((goal) => goal === null)) return;
    if (this.levers.kind !== "joint" && !this.commanding) {
      this.levers.lead("joint");
      this.attempt(() => this.lead("rates joint"));
      return;
    }
    const { time } = this.latest;
    if (time === this.followed) return;
    // A rate holds until the next picture: where those come seldom a joint goes more slowly, lest it swings about its goal.
    const gain = Math.min(JOINT_GAIN, 0.25 / Math.abs(time - this.followed));
    this.followed = time;
    const rates = this.goals.map((goal, k) => (goal === null ? 0 : Math.min(Math.max(gain * (goal - zeta[k]), -MOST.joint[k]), MOST.joint[k])));
    // It is there once it is near and slow in two pictures, for one may be of a while ago.
    const near = this.goals.map((goal, k) => goal !== null && Math.abs(goal - zeta[k]) < JOINT_THERE && Math.abs(this.commanded[k]) <= 2 * JOINT_GAIN * JOINT_THERE);
    this.goals = this.goals.map((goal, k) => (near[k] && this.near[k] ? null : goal));
    this.near = near;
    this.command("joint", rates.map((rate, k) => (this.goals[k] === null ? 0 : Number(rate.toPrecision(3)))));
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
    const kept = (settings) => Object.fromEntries(Object.entries(settings).filter(([name]) => !/^(sensors|dclink|emla_\d)\./.test(name)));
    return this.start((settings) => ({ ...kept(settings), world }), { why: `Started again: ${WORLDS[world].text}.` });
  }

  /* The link, and what of the run it does not hold. */
  async copyLink() {
    const link = `${location.href.split("#")[0]}${this.address()}`;
    const held = this.log.length > MOST_CHANGES
      ? `It holds the settings, but not the ${this.log.length} changes made while it ran, most of them by levers: Download settings keeps them all.`
      : this.log.length ? `It holds the settings and the ${this.log.length} changes made while it ran.` : "It holds the settings.";
    if (await copied(link)) this.say(`The link is copied. ${held}`);
    else this.say(`This browser lets no page copy: take the address from the address bar. ${held}`);
  }

  settingsText() {
    const note = "settings as `cosim run --set` takes them; changes: what was changed while it ran, s after the start";
    return JSON.stringify({ note, machine: this.data.name || "reference", settings: this.began, ghosts: this.laws, changes: this.log }, null, 1);
  }

  keys() {
    const keys = { Space: () => element("play").click(), Period: () => this.advance(this.engine.about.step), Backspace: () => this.undo(), Escape: () => this.stopAll(), KeyP: () => this.pushShortly(), KeyL: () => this.hang(), KeyO: () => this.aim(!this.scene.aiming) };
    document.addEventListener("keydown", (event) => {
      const inField = event.target.closest?.("input:not([type=range]):not([type=checkbox]), textarea");
      // A list that has the focus keeps what opens and closes it; letters would choose an entry.
      const own = ["Space", "Escape"].includes(event.code) && event.target.closest?.(event.code === "Space" ? "button, summary, input, a, select" : "select");
      if (inField || own || event.repeat || event.ctrlKey || event.metaKey || event.altKey || !keys[event.code]) return;
      event.preventDefault();
      this.attempt(keys[event.code]);
    });
    this.keyTable();
  }

  keyTable() {
    const letter = (code) => this.levers.letter(code);
    const rows = [["space", "run or pause"], ["escape", "emergency stop"], [".", "one step"], ["backspace", "back by ten seconds"], [letter("KeyP"), "push the tip"], [letter("KeyL"), "pick up or set down the load"], [letter("KeyO"), "click waypoints"],
      ...LEVER_KEYS.map((pair, k) => [pair.map(letter).join(" "), `${LEVERS.joint[k].name}: ${LEVERS.joint[k].ends.join(" or ")}`]), ["arrows on the picture", "move the view, with shift turn it"]];
    element("keys").innerHTML = rows.map(([key, text]) => `<tr><td><kbd>${key}</kbd></td><td>${text}</td></tr>`).join("");
  }

  /* A file: settings of this page, else a path. */
  async read(file) {
    const text = await file.text();
    const found = text.trimStart().startsWith("{") ? JSON.parse(text) : null;
    if (!found?.settings) return this.follows(text);
    return this.start(found.settings, { ghosts: found.ghosts ?? [], changes: found.changes ?? [], why: "Settings of the file." });
  }

  /* What has happened to a joystick, and what leads each lever. */
  joystick(text) {
    this.say(text);
    const { pads } = this.levers;
    element("gamepad").textContent = pads.size ? `Joystick: ${[...pads.values()].join("; ")}.` : "A joystick or gamepad works as soon as you move it.";
    element("pad-map").hidden = !pads.size;
    element("pad-rows").replaceChildren(...this.levers.sources().map(({ name, text: words }, k) => {
      const row = html`<tr><td>${name}</td><td>${words}</td><td><button>Change</button></td></tr>`;
      row.querySelector("button").addEventListener("click", () => {
        this.levers.learns = this.levers.learns === k ? null : k;
        this.joystick("");
      });
      return row;
    }));
  }

  /* A machine of one's own is called by its name, and said to be what it is. */
  introduce() {
    const { name, reach } = this.data;
    if (!name) return;
    document.title = `Live machine: ${name}`;
    document.querySelector("h1").append(`: ${name}`);
    element("subject").textContent = `The machine ${name} under the controller of a`;
    element("size").textContent = `The machine ${name}, which reaches ${reach.toFixed(1)} m; its payload is ${Number(this.payload.toPrecision(4))} kg. It is`;
  }

  /* What to try first; each is crossed off when it was done. */
  firstMinute() {
    const withKeys = matchMedia("(hover: hover)").matches;
    const steps = { levers: [withKeys ? "Take the levers: hold W, or drag one below" : "Take the levers: drag one below", () => this.lead("rates joint")], push: [withKeys ? "Push it: drag any part of it, or press P" : "Push it: drag any part of it", () => this.pushShortly()],
      hang: [`Have it pick up ${Number((this.payload / 2).toPrecision(4))} kg`, () => this.hang()], ghost: ["Compare with another controller", () => this.beside(["modular"])], world: ["Add play, friction, sensor errors", () => this.world("real")] };
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
opened.catch(async (error) => {
  live.playing = false;
  const canRun = await live.ensemble?.main.opened.then(() => true, () => false);
  await live.pictured?.catch(() => {});
  live.reveal();
  live.alarm(2, `The machine cannot be started${location.hash.length > 1 ? " as this address asks" : ""}: ${error.message}`);
  if (!canRun || !live.scene) return;
  const usual = html`<button>Start with the usual settings</button>`;
  usual.addEventListener("click", () => live.attempt(() => {
    live.playing = true;
    usual.remove();
    live.bars.clear();
    return live.start(live.first, { ghosts: [] });
  }));
  element("broken").append(usual);
});
scripted(live, opened);
Object.defineProperties(window.machine, { scene: { get: () => live.scene }, monitor: { get: () => live.monitor }, engine: { get: () => live.engine } });
