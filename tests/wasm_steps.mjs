// What `trace` of test_wasm.py does to an FMU's plain module, in Node or in a page: steps, before each tenth one the inputs, after it the outputs.
// Gives the SHA-256 of these outputs and what was not done, as [step, status].
export async function trace(bytes, { token, parameters, inputs, outputs, steps, h }) {
  let memory;
  const messages = [];
  const text = (at, size) => new TextDecoder().decode(new Uint8Array(memory.buffer, at, size));
  const { instance } = await WebAssembly.instantiate(bytes, {
    "fmi:fmi3/callbacks@3.0.0": {
      "log-message": (instance, instanceSize, status, category, categorySize, message, size) => messages.push(text(message, size)),
    },
    "fmi:fmi3/intermediate-update-callbacks@3.0.0": { "intermediate-update": () => {} },
    "[export]fmi:fmi3/co-simulation@3.0.0": { "[resource-new]co-simulation-instance": (handle) => handle },
    "[export]fmi:fmi3/model-exchange@3.0.0": { "[resource-new]model-exchange-instance": (handle) => handle },
  });
  const fmu = instance.exports;
  memory = fmu.memory;

  function string(s) {
    const bytes = new TextEncoder().encode(`${s}\0`);
    const at = fmu.fmu_allocate(bytes.length);
    new Uint8Array(memory.buffer, at, bytes.length).set(bytes);
    return at;
  }
  const c = fmu.fmi3InstantiateCoSimulation(
    string("steps"), string(token), 0, 0, 1, 0, 0, 0, 0, string("steps"), fmu.fmu_log_message(), 0,
  );
  if (c === 0) throw new Error(messages.at(-1));

  /* Memory for values of these variables, as [[value reference, length], ...], and a call that sets or gets them. */
  function reals(variables) {
    const references = variables.map(([vr]) => vr);
    const n = variables.reduce((sum, [, length]) => sum + length, 0);
    const [at, place] = [fmu.fmu_allocate(4 * references.length), fmu.fmu_allocate(8 * n)];
    new Uint32Array(memory.buffer, at, references.length).set(references);
    const call = (name) => fmu[name](c, at, references.length, place, n);
    const values = () => new Float64Array(memory.buffer, place, n);
    return { n, values, get: () => call("fmi3GetFloat64"), set: (numbers) => (values().set(numbers), call("fmi3SetFloat64")) };
  }
  function must(status) {
    if (status !== 0) throw new Error(`status ${status}: ${messages.at(-1)}`);
  }

  for (const [variable, value] of parameters) must(reals([variable]).set([value]));
  must(fmu.fmi3EnterInitializationMode(c, 0, 0, 0, 0, 0));
  must(fmu.fmi3ExitInitializationMode(c));
  const places = inputs.flatMap(({ start, scale }, j) => start.map((s, i) => [s, scale, (i + j) * 104729]));
  const moved = (k) => {
    const values = places.map(([s, scale, own]) => s + (scale * (((k * 7919 + own) % 2001) - 1000)) / 1000);
    if (k % 97 === 96) values[k % values.length] = NaN;
    return values;
  };
  const [given, put, answers] = [reals(inputs.map(({ variable }) => variable)), reals(outputs), fmu.fmu_allocate(16)];
  const rows = new Float64Array(Math.ceil(steps / 10) * put.n);
  const lost = [];
  for (let k = 0; k < steps; k += 1) {
    const did = (status) => status !== 0 && lost.push([k, status]);
    if (k % 10 === 0) did(given.set(moved(k / 10)));
    did(fmu.fmi3DoStep(c, k * h, h, 1, answers, answers + 1, answers + 2, answers + 8));
    if (k % 10 !== 0) continue;
    must(put.get());
    rows.set(put.values(), (k / 10) * put.n);
  }
  fmu.fmi3FreeInstance(c);
  const hash = new Uint8Array(await crypto.subtle.digest("SHA-256", rows));
  return [[...hash].map((byte) => byte.toString(16).padStart(2, "0")).join(""), lost];
}
