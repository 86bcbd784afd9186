// Steps an FMU's WebAssembly module by the C functions of FMI 3.0 and prints a SHA-256 of all that it put out.
// node wasm_steps.mjs MODULE.wasm PLAN.json
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";

const [, , path, plan] = process.argv;
const { token, parameters, inputs, outputs, steps, h } = JSON.parse(readFileSync(plan, "utf8"));
let memory;
const messages = [];
const text = (at, size) => new TextDecoder().decode(new Uint8Array(memory.buffer, at, size));
const { exports: fmu } = new WebAssembly.Instance(new WebAssembly.Module(readFileSync(path)), {
  "fmi:fmi3/callbacks@3.0.0": {
    "log-message": (instance, instanceSize, status, category, categorySize, message, size) => messages.push(text(message, size)),
  },
  "fmi:fmi3/intermediate-update-callbacks@3.0.0": { "intermediate-update": () => {} },
  "[export]fmi:fmi3/co-simulation@3.0.0": { "[resource-new]co-simulation-instance": (handle) => handle },
});
memory = fmu.memory;

function string(s) {
  const bytes = new TextEncoder().encode(`${s}\0`);
  const at = fmu.fmu_allocate(bytes.length);
  new Uint8Array(memory.buffer, at, bytes.length).set(bytes);
  return at;
}
function call(name, ...args) {
  const status = fmu[name](c, ...args);
  if (status !== 0) throw new Error(`${name} returned ${status}: ${messages.at(-1)}`);
}

const c = fmu.fmi3InstantiateCoSimulation(
  string("steps"), string(token), 0, 0, 1, 0, 0, 0, 0, string("steps"), fmu.fmu_log_message(), 0,
);
if (c === 0) throw new Error(messages.at(-1));
const vr = fmu.fmu_allocate(4), values = fmu.fmu_allocate(8 * 64), answers = fmu.fmu_allocate(16);
const one = (reference) => new Uint32Array(memory.buffer, vr, 1).fill(reference) && vr;
function set(reference, numbers) {
  new Float64Array(memory.buffer, values, numbers.length).set(numbers);
  call("fmi3SetFloat64", one(reference), 1, values, numbers.length);
}
for (const [reference, numbers] of parameters) set(reference, numbers);
call("fmi3EnterInitializationMode", 0, 0, 0, 0, 0);
call("fmi3ExitInitializationMode");
const hash = createHash("sha256");
for (let k = 0; k < steps; k += 1) {
  for (const [reference, n, scale] of inputs) {
    set(reference, Array.from({ length: n }, (_, j) => (((k * 7919 + j * 104729) % 2001) - 1000) * scale));
  }
  call("fmi3DoStep", k * h, h, 1, answers, answers + 1, answers + 2, answers + 8);
  for (const [reference, n] of outputs) {
    call("fmi3GetFloat64", one(reference), 1, values, n);
    hash.update(new Uint8Array(memory.buffer, values, 8 * n));
  }
}
call("fmi3Terminate");
fmu.fmi3FreeInstance(c);
console.log(hash.digest("hex"));
