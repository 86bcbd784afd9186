/* What runs in the worker: the engine (cosim as a WebAssembly module), the FMUs' modules that it calls, and the commands of `engine.js`.
 *
 * Each instance of an FMU is a WebAssembly.Instance with a memory of its own. The engine imports the functions of FMI 3.0 from here: what
 * their arguments point to is copied from the engine's memory to the instance's, or back. Runs in a Worker of a page and in one of Node. */
"use strict";

(() => {
  const node = typeof self === "undefined" ? require("node:worker_threads").parentPort : null;
  const FATAL = 4;
  const text = new TextDecoder();
  const bytes = new TextEncoder();

  /* What a page carries as text, base64 of a gzip, as a stream of this type. */
  async function unpacked(part, type) {
    const { body } = await fetch(`data:application/octet-stream;base64,${part}`);
    return new Response(body.pipeThrough(new DecompressionStream("gzip")), { headers: { "content-type": type } });
  }

  /* A memory and its views, which a growing memory leaves behind. */
  class Memory {
    constructor(memory, allocate, free) {
      Object.assign(this, { memory, allocate, free });
      this.look();
    }

    /* Views of a memory that has grown have no length any more. */
    look() {
      if (this.u8 !== undefined && this.u8.length !== 0) return this;
      const { buffer } = this.memory;
      this.u8 = new Uint8Array(buffer);
      this.u32 = new Uint32Array(buffer);
      this.f64 = new Float64Array(buffer);
      return this;
    }

    /* The C string at an address, as bytes with its end. */
    string(address) {
      const { u8 } = this.look();
      return u8.subarray(address, u8.indexOf(0, address) + 1);
    }

    /* Own memory with these bytes; whoever asks for it frees it. */
    place(content) {
      const address = this.allocate(content.length);
      if (address === 0 && content.length > 0) throw new Error("no memory is left");
      this.look().u8.set(content, address);
      return address;
    }
  }

  /* Copy as many bytes, all of it in elements of 8 or 4 bytes where that fits. */
  function copy(from, at, to, place, size) {
    if (size > 256 || ((at | place | size) & 3) !== 0) {
      to.u8.set(from.u8.subarray(at, at + size), place);
    } else if (((at | place | size) & 7) === 0) {
      for (let k = 0; k < size >> 3; k += 1) to.f64[(place >> 3) + k] = from.f64[(at >> 3) + k];
    } else {
      for (let k = 0; k < size >> 2; k += 1) to.u32[(place >> 2) + k] = from.u32[(at >> 2) + k];
    }
  }

  /* The host of the FMUs' modules. */
  class Host {
    constructor() {
      this.modules = new Map();
      this.instances = [];
      this.next = 1;
      this.files = {};
    }

    /* What the engine's module imports. What is not known is never called: functions of the standard that the master does not use, and
     * those that wasm-bindgen brings along, which a crate asks for that reads archives. */
    imports(module) {
      const fmi3 = {};
      for (const [name, size] of Object.entries({ Float64: 8, Float32: 4, Int8: 1, UInt8: 1, Int16: 2, UInt16: 2, Int32: 4, UInt32: 4, Int64: 8, UInt64: 8, Boolean: 1 })) {
        fmi3[`fmi3Get${name}`] = this.getter(`fmi3Get${name}`, size);
        fmi3[`fmi3Set${name}`] = this.setter(`fmi3Set${name}`, size);
      }
      for (const name of ["EnterInitializationMode", "ExitInitializationMode", "EnterEventMode", "EnterStepMode", "EnterConfigurationMode", "ExitConfigurationMode", "Terminate", "Reset", "SetFMUState", "EnterContinuousTimeMode", "SetTime"]) {
        fmi3[`fmi3${name}`] = this.plain(`fmi3${name}`);
      }
      // What is pointed to, which goes there and back: [position, size of an element, position of the number, else it is one].
      const calls = {
        SetClock: [[0, 4, 1], [2, 1, 1]],
        GetIntervalDecimal: [[0, 4, 1], [2, 8, 1], [3, 4, 1]],
        GetShiftDecimal: [[0, 4, 1], [2, 8, 1]],
        GetOutputDerivatives: [[0, 4, 1], [2, 4, 1], [3, 8, 4]],
        GetFMUState: [[0, 4]],
        FreeFMUState: [[0, 4]],
        CompletedIntegratorStep: [[1, 1], [2, 1]],
        SetContinuousStates: [[0, 8, 1]],
        GetContinuousStates: [[0, 8, 1]],
        GetContinuousStateDerivatives: [[0, 8, 1]],
        GetEventIndicators: [[0, 8, 1]],
        GetNominalsOfContinuousStates: [[0, 8, 1]],
        GetNumberOfContinuousStates: [[0, 4]],
        GetNumberOfEventIndicators: [[0, 4]],
        GetDirectionalDerivative: [[0, 4, 1], [2, 4, 3], [4, 8, 5], [6, 8, 7]],
      };
      for (const [name, arrays] of Object.entries(calls)) fmi3[`fmi3${name}`] = this.caller(`fmi3${name}`, arrays);
      Object.assign(fmi3, {
        fmi3InstantiateCoSimulation: (name, token, resources, visible, logging, events, early, vr, n, environment) =>
          this.instantiate("fmi3InstantiateCoSimulation", name, token, resources, [visible, logging, events, early, 0, 0], environment, [0]),
        fmi3InstantiateModelExchange: (name, token, resources, visible, logging, environment) =>
          this.instantiate("fmi3InstantiateModelExchange", name, token, resources, [visible, logging], environment, []),
        fmi3DoStep: (key, t, h, keeps, event, ends, early, time) => this.step(key, t, h, keeps, event, ends, early, time),
        fmi3UpdateDiscreteStates: (key, ...told) => this.update(key, told),
        fmi3FreeInstance: (handle) => this.free(handle),
        fmi3SetDebugLogging: (handle, on, n, list) => this.withTexts(handle, "fmi3SetDebugLogging", list, n, (texts) => [on, n, texts]),
        fmi3SetString: (handle, vr, n, list, m) => this.withTexts(handle, "fmi3SetString", list, m, (texts, i) => [i.pass(vr, 4 * n), n, texts, m]),
        fmi3GetString: (handle, vr, n, list, m) => this.getBlocks(handle, "fmi3GetString", vr, n, 0, list, m),
        fmi3SetBinary: (handle, vr, n, sizes, list, m) => this.withTexts(handle, "fmi3SetBinary", list, m, (texts, i) => [i.pass(vr, 4 * n), n, i.pass(sizes, 4 * m), texts, m], sizes),
        fmi3GetBinary: (handle, vr, n, sizes, list, m) => this.getBlocks(handle, "fmi3GetBinary", vr, n, sizes, list, m),
      });
      const host = { load: (at, size) => this.load(at, size), unload: (k) => this.modules.delete(k), exports: (k, at, size) => this.exports(k, at, size) };
      const all = { host, fmi3 };
      for (const { module: from, name } of WebAssembly.Module.imports(module)) {
        (all[from] ??= {})[name] ??= () => { throw new Error(`${name} is not there for the engine`); };
      }
      return all;
    }

    /* The engine's instance has been made. */
    serve(engine) {
      this.engine = engine;
      this.own = new Memory(engine.memory, engine.engine_allocate, engine.engine_free);
    }

    /* Tell the engine what an instance says, or the host (environment 0). */
    say(environment, status, message) {
      const content = bytes.encode(message);
      const address = this.own.place(content);
      this.engine.engine_message(environment, status, address, content.length);
      this.own.free(address, content.length);
    }

    load(at, size) {
      try {
        const key = this.next++;
        const module = new WebAssembly.Module(this.own.look().u8.slice(at, at + size));
        this.modules.set(key, { module, names: new Set(WebAssembly.Module.exports(module).map(({ name }) => name)) });
        return key;
      } catch (error) {
        this.say(0, FATAL, `it is no WebAssembly module: ${error.message}`);
        return -1;
      }
    }

    exports(key, at, size) {
      const name = text.decode(this.own.look().u8.slice(at, at + size));
      return this.modules.get(key).names.has(name) ? 1 : 0;
    }

    /* `resources` names the module: "/3/". */
    instantiate(call, name, token, resources, options, environment, last) {
      const path = text.decode(this.own.string(resources).slice(0, -1));
      const said = (status, message) => this.say(environment, status, message);
      try {
        const instance = new Instance(this, this.modules.get(Number(path.split("/")[1])).module, said);
        const own = (address) => instance.memory.place(this.own.string(address).slice());
        instance.handle = instance.fmu[call](own(name), own(token), own(resources), ...options, 0, instance.fmu.fmu_log_message?.() ?? 0, ...last);
        if (instance.handle === 0) return 0;
        for (const [file, content] of Object.entries(this.files)) instance.file(file, content);
        const key = this.next++;
        this.instances[key] = instance;
        return key;
      } catch (error) {
        said(FATAL, `its WebAssembly failed: ${error.message}`);
        return 0;
      }
    }

    free(key) {
      this.instances[key].call("fmi3FreeInstance", []);
      delete this.instances[key];
    }

    // What every step calls is written out: it makes no lists.

    plain(name) {
      return (key, ...its) => {
        const i = this.instances[key];
        if (i.lost !== undefined) return FATAL;
        try {
          return its.length === 0 ? i.fmu[name](i.handle) : i.fmu[name](i.handle, ...its);
        } catch (error) {
          return i.trap(name, error);
        }
      };
    }

    getter(name, size) {
      return (key, vr, n, values, m) => {
        const i = this.instances[key].begin();
        if (i.lost !== undefined) return FATAL;
        const references = i.pass(vr, 4 * n);
        const room = i.room(size * m);
        let status;
        try {
          status = i.fmu[name](i.handle, references, n, room, m);
        } catch (error) {
          return i.trap(name, error);
        }
        if (status <= 1) copy(i.memory.look(), room, this.own.look(), values, size * m);
        return status;
      };
    }

    setter(name, size) {
      return (key, vr, n, values, m) => {
        const i = this.instances[key].begin();
        if (i.lost !== undefined) return FATAL;
        const references = i.pass(vr, 4 * n);
        const given = i.pass(values, size * m);
        try {
          return i.fmu[name](i.handle, references, n, given, m);
        } catch (error) {
          return i.trap(name, error);
        }
      };
    }

    step(key, t, h, keeps, event, ends, early, time) {
      const i = this.instances[key].begin();
      if (i.lost !== undefined) return FATAL;
      const at = i.cleared(16);
      let status;
      try {
        status = i.fmu.fmi3DoStep(i.handle, t, h, keeps, at, at + 1, at + 2, at + 8);
      } catch (error) {
        return i.trap("fmi3DoStep", error);
      }
      const { u8, f64 } = i.memory.look();
      const own = this.own.look();
      [own.u8[event], own.u8[ends], own.u8[early]] = [u8[at], u8[at + 1], u8[at + 2]];
      own.f64[time >> 3] = f64[(at + 8) >> 3];
      return status;
    }

    update(key, told) {
      const i = this.instances[key].begin();
      if (i.lost !== undefined) return FATAL;
      const at = i.cleared(16);
      let status;
      try {
        status = i.fmu.fmi3UpdateDiscreteStates(i.handle, at, at + 1, at + 2, at + 3, at + 4, at + 8);
      } catch (error) {
        return i.trap("fmi3UpdateDiscreteStates", error);
      }
      const { u8, f64 } = i.memory.look();
      const own = this.own.look();
      for (let k = 0; k < 5; k += 1) own.u8[told[k]] = u8[at + k];
      own.f64[told[5] >> 3] = f64[(at + 8) >> 3];
      return status;
    }

    caller(name, arrays) {
      return (key, ...its) => {
        const i = this.instances[key].begin();
        const sizes = arrays.map(([, size, count]) => size * (count === undefined ? 1 : its[count]));
        const args = its.slice();
        arrays.forEach(([at], k) => { args[at] = i.pass(its[at], sizes[k]); });
        const status = i.call(name, args);
        i.memory.look();
        this.own.look();
        arrays.forEach(([at], k) => copy(i.memory, args[at], this.own, its[at], sizes[k]));
        return status;
      };
    }

    /* A call with texts, or with bytes of these sizes. */
    withTexts(key, name, list, n, args, sizes) {
      const i = this.instances[key].begin();
      const { own } = this;
      own.look();
      const contents = Array.from({ length: n }, (_, k) => {
        const at = own.u32[(list >> 2) + k];
        return sizes === undefined ? own.string(at).slice() : own.u8.slice(at, at + own.u32[(sizes >> 2) + k]);
      });
      const places = contents.map((content) => i.memory.place(content));
      const table = i.room(4 * n);
      i.memory.look().u32.set(places, table >> 2);
      const status = i.call(name, args(table, i));
      contents.forEach((content, k) => i.lost ?? i.memory.free(places[k], content.length));
      return status;
    }

    /* Texts, or bytes with their sizes, which the engine may read until the next call of the kind. */
    getBlocks(key, name, vr, n, sizes, list, m) {
      const i = this.instances[key].begin();
      const [references, lengths, table] = [i.pass(vr, 4 * n), i.room(4 * m), i.room(4 * m)];
      const status = i.call(name, sizes === 0 ? [references, n, table, m] : [references, n, lengths, table, m]);
      if (status > 1) return status;
      const { own } = this;
      i.blocks.splice(0).forEach(([at, size]) => own.free(at, size));
      for (let k = 0; k < m; k += 1) {
        const memory = i.memory.look();
        const at = memory.u32[(table >> 2) + k];
        const content = (sizes === 0 ? (at === 0 ? Uint8Array.of(0) : memory.string(at)) : memory.u8.subarray(at, at + memory.u32[(lengths >> 2) + k])).slice();
        const place = own.place(content);
        i.blocks.push([place, content.length]);
        own.look().u32[(list >> 2) + k] = place;
        if (sizes !== 0) own.u32[(sizes >> 2) + k] = content.length;
      }
      return status;
    }
  }

  /* An instance of an FMU. */
  class Instance {
    constructor(host, module, said) {
      this.host = host;
      this.said = said;
      this.blocks = [];
      const all = {};
      for (const { module: from, name, kind } of WebAssembly.Module.imports(module)) {
        if (kind !== "function") throw new Error(`it imports ${from}.${name}, which a page has not`);
        (all[from] ??= {})[name] = this.imported(from, name);
      }
      this.fmu = new WebAssembly.Instance(module, all).exports;
      this.memory = new Memory(this.fmu.memory, this.fmu.fmu_allocate, this.fmu.fmu_free);
      [this.scratch, this.size] = [0, 0];
      this.begin();
    }

    imported(from, name) {
      const read = (at, size) => text.decode(this.memory.look().u8.slice(at, at + size));
      if (name === "log-message") return (at, size, status, category, categorySize, message, messageSize) => this.said(status, read(message, messageSize));
      if (name === "intermediate-update") return () => {};
      if (name.startsWith("[resource-new]")) return (handle) => handle;
      return () => { throw new Error(`it calls ${from}.${name}, which a page has not`); };
    }

    /* A call begins: all room for what is passed is free again. */
    begin() {
      if (this.lost === undefined && this.wanted > this.size) {
        if (this.scratch !== 0) this.fmu.fmu_free(this.scratch, this.size);
        this.size = 2 * this.wanted;
        this.scratch = this.fmu.fmu_allocate(this.size);
      }
      this.used = 0;
      return this;
    }

    /* Room for what is passed in this call. */
    room(size) {
      const at = this.used;
      this.used += (size + 15) & ~15;
      if (this.used > this.wanted) this.wanted = this.used;
      if (this.used <= this.size) return this.scratch + at;
      // More than ever before: the next call has it in one piece.
      return this.lost === undefined ? this.fmu.fmu_allocate(size) : 0;
    }

    /* The same for answers, all zero. */
    cleared(size) {
      const at = this.room(size);
      this.memory.look().u8.fill(0, at, at + size);
      return at;
    }

    pass(address, size) {
      const place = this.room(size);
      if (this.lost === undefined) copy(this.host.own.look(), address, this.memory.look(), place, size);
      return place;
    }

    call(name, args) {
      if (this.lost !== undefined) return FATAL;
      try {
        return this.fmu[name](this.handle, ...args);
      } catch (error) {
        return this.trap(name, error);
      }
    }

    /* A trap loses the instance: its memory is in no state that is known. */
    trap(name, error) {
      this.lost = error;
      this.said(FATAL, `its WebAssembly failed in ${name}: ${error.message}; this instance is lost`);
      return FATAL;
    }

    file(path, content) {
      const [name, data] = [bytes.encode(path), typeof content === "string" ? bytes.encode(content) : content];
      this.fmu.fmu_place_file?.(this.memory.place(name), name.length, this.memory.place(data), data.length);
    }
  }
  Instance.prototype.wanted = 4096;

  /* The engine and the run that goes on. */
  class Session {
    rows = [];
    planned = [];
    next = 0;
    /* Frames that the page has not seen yet. */
    unseen = 0;

    async open({ engine, system }) {
      this.playing = false;
      const isText = (part) => typeof part === "string";
      const compiled = () => (isText(engine) ? WebAssembly.compileStreaming(unpacked(engine, "application/wasm")) : WebAssembly.compile(engine));
      const [module, archive] = await Promise.all([
        this.module ?? compiled(),
        isText(system) ? unpacked(system, "application/zip").then((all) => all.arrayBuffer()).then((all) => new Uint8Array(all)) : system]);
      const host = new Host();
      const { exports } = await WebAssembly.instantiate(module, host.imports(module));
      host.serve(exports);
      const [before, hostBefore] = [this.engine, this.host];
      [this.engine, this.host] = [exports, host];
      try {
        this.answer(exports.engine_open(this.host.own.place(archive), archive.length));
      } catch (error) {
        [this.engine, this.host] = [before, hostBefore];
        throw error;
      }
      [this.module, this.system, this.columns] = [module, system, 1];
    }

    /* Give the engine bytes for one call. */
    withBytes(content, call) {
      const at = this.host.own.place(content);
      try {
        return call(at, content.length);
      } finally {
        this.broken ?? this.host.own.free(at, content.length);
      }
    }

    text(size) {
      const at = this.engine.answer_address();
      return text.decode(this.host.own.look().u8.slice(at, at + size));
    }

    answer(size) {
      const { ok, error } = JSON.parse(this.text(size));
      if (error !== undefined) throw new Error(error);
      return ok;
    }

    /* What the engine does; where it fails itself, it says so, and `restart` makes another one. */
    guarded(work) {
      if (this.broken) throw this.broken;
      try {
        return work();
      } catch (error) {
        if (!(error instanceof WebAssembly.RuntimeError)) throw error;
        // What it answers then is what its panic says.
        const said = JSON.parse(this.text(this.engine.answer_size())).error;
        this.broken = new Error(`${said ?? error.message}; restart it`);
        throw this.broken;
      }
    }

    command(command, arguments_) {
      const content = bytes.encode(JSON.stringify({ command, ...arguments_ }));
      return this.guarded(() => this.answer(this.withBytes(content, (at, size) => this.engine.engine_command(at, size))));
    }

    async restart({ settings: { files, ...settings } = {} }) {
      if (this.broken) {
        [this.broken, this.engine] = [undefined, undefined];
        await this.open({ system: this.system });
      }
      if (files !== undefined) this.host.files = files;
      const about = this.command("restart", { settings });
      Object.assign(this, { step: about.step, columns: 1 + about.watched.length, rows: [], planned: [], next: 0, error: undefined });
      this.take();
      this.pace();
      return { ...about, time: this.time };
    }

    watch({ names }) {
      this.command("watch", { names });
      Object.assign(this, { columns: 1 + names.length, rows: [] });
      this.take();
      this.report();
      return null;
    }

    restore({ id }) {
      this.command("restore", { id });
      Object.assign(this, { rows: [], error: undefined });
      this.take();
      this.planFrom(this.time);
      this.pace();
      this.report();
      return this.time;
    }

    /* Take over the rows that the engine has made. */
    take() {
      const size = this.engine.history_size();
      if (size === 0) return;
      const at = this.engine.history_address() >> 3;
      const rows = this.host.own.look().f64.slice(at, at + size);
      this.rows.push(rows);
      this.last = rows.subarray(size - this.columns);
      this.time = this.last[0];
    }

    /* Changes of the run that starts, each {time, name, value}: they are made at the communication points of their times. */
    plan({ changes }) {
      this.planned = [...changes].sort((a, b) => a.time - b.time);
      this.planFrom(this.time);
      return null;
    }

    /* What was planned from this time on is to come, again after a step back. */
    planFrom(time) {
      const first = this.planned.findIndex((change) => change.time > time - this.step / 2);
      this.next = first < 0 ? this.planned.length : first;
    }

    /* Make steps; throws where one of them fails, after those that were made. */
    make(steps) {
      for (let left = steps; ; ) {
        while (this.planned[this.next]?.time < this.time + this.step / 2) {
          const { name, value } = this.planned[this.next++];
          this.command("set", { name, value });
        }
        const until = this.planned[this.next]?.time ?? Infinity;
        const n = Math.min(left, Math.max(1, Math.round((until - this.time) / this.step)));
        const size = this.guarded(() => this.engine.engine_advance(n));
        this.take();
        if (size !== 0) this.answer(size);
        left -= n;
        if (left <= 0) return;
      }
    }

    async advance({ seconds }) {
      if (this.step === undefined) this.make(0);
      const steps = Math.max(0, Math.round(seconds / this.step));
      const begin = performance.now();
      let [made, slice] = [0, 16];
      this.stops = false;
      while (made < steps && !this.stops) {
        const from = performance.now();
        const n = Math.min(slice, steps - made);
        this.make(n);
        made += n;
        const took = performance.now() - from;
        slice = Math.max(1, Math.min(4096, Math.round((slice * 20) / Math.max(took, 1))));
        if (performance.now() - (this.reported ?? 0) > FRAME) {
          if (this.isSeen) this.report((made * this.step * 1000) / (performance.now() - begin), 1);
          await breath();
        }
      }
      this.report((made * this.step * 1000) / Math.max(performance.now() - begin, 1e-3), 1);
      this.pace();
      return this.time;
    }

    play({ speed = 1 }) {
      if (this.step === undefined) this.make(0);
      this.speed = speed;
      this.pace();
      if (!this.playing) {
        this.playing = true;
        this.loop();
      }
      return null;
    }

    memory() {
      const memories = [this.host.own, ...this.host.instances.filter(Boolean).map((i) => i.memory)];
      return memories.reduce((sum, { memory }) => sum + memory.buffer.byteLength, 0);
    }

    pause() {
      this.playing = false;
      if (this.step !== undefined) this.report(0, 0);
      return null;
    }

    /* From now on the run keeps pace with the wall clock. */
    pace() {
      [this.began, this.from] = [performance.now(), this.time];
    }

    /* Slices of steps as they fall due; where the machine is too slow, the run falls behind and no debt is kept. */
    async loop() {
      let each = 0.1;
      let last = performance.now();
      while (this.playing) {
        const begin = performance.now();
        const due = this.from + ((begin - this.began) / 1000) * this.speed;
        const wanted = Math.floor((due - this.time) / this.step + 1e-6);
        const able = Math.max(1, Math.floor((0.9 * FRAME) / each));
        const n = Math.min(wanted, able);
        if (n > 0) {
          const before = this.time;
          try {
            this.make(n);
          } catch (error) {
            this.playing = false;
            this.error = error.message;
          }
          const now = performance.now();
          each = 0.8 * each + (0.2 * (now - begin)) / n;
          if (wanted > able) this.pace();
          if (this.isSeen || this.error) this.report(((this.time - before) * 1000) / (now - last), (now - begin) / Math.max(now - last, now - begin));
          last = now;
        }
        await breath(Math.max(0, FRAME - (performance.now() - begin)));
      }
    }

    /* A page that is slow with its frames gets fewer, each with all rows since the one before: in a queue they would be of long ago. */
    get isSeen() {
      return this.unseen < 2;
    }

    /* A frame for the page. */
    report(factor = 0, share = 0) {
      this.reported = performance.now();
      this.unseen += 1;
      const size = this.rows.reduce((n, rows) => n + rows.length, 0);
      const history = new Float64Array(size);
      this.rows.reduce((at, rows) => (history.set(rows, at), at + rows.length), 0);
      this.rows = [];
      post({ frame: { time: this.time, values: this.last?.slice(1) ?? new Float64Array(), history, factor, share, error: this.error } }, [history.buffer]);
    }
  }

  const FRAME = 1000 / 60;
  const channel = new MessageChannel();
  /* Who waits for a turn: a run that plays may be advanced too. */
  const waiting = [];
  channel.port1.onmessage = () => waiting.shift()();
  /* Let other messages in; a timer of 0 would wait 4 ms. */
  const breath = (ms = 0) => new Promise((resolve) => {
    if (ms > 1) setTimeout(resolve, ms);
    else {
      waiting.push(resolve);
      channel.port2.postMessage(0);
    }
  });
  const post = (message, moved) => (node ?? self).postMessage(message, moved);
  const session = new Session();

  const own = ["open", "restart", "watch", "restore", "advance", "play", "pause", "memory", "plan"];
  let turn = Promise.resolve();
  async function obey({ id, command, its }) {
    try {
      const ok = own.includes(command) ? await session[command](its) : session.command(command, its);
      post({ id, ok, time: session.time });
    } catch (error) {
      post({ id, error: error.message, time: session.time });
    }
  }
  const receive = (message) => {
    if (message.seen) {
      session.unseen -= 1;
      return;
    }
    // At once, also while the run advances.
    if (message.command === "pause") session.stops = true;
    turn = turn.then(() => obey(message));
  };
  if (node) node.on("message", receive);
  else {
    self.onmessage = ({ data }) => receive(data);
    // Not before this script has ended: until the page knows that, it keeps what it sends.
    breath().then(() => post({ runs: true }));
  }
})();
