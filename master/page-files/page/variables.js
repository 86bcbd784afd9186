/* Variables of the running system and settings of a run, as names and values. */

/* The variables with each element of an array by itself, as the engine names them: `x[1]`, `a[2,1]`. */
export function elements(variables) {
  return variables.flatMap((variable) => {
    let indices = [""];
    for (const size of variable.dimensions ?? []) {
      indices = indices.flatMap((index) => Array.from({ length: size }, (_, k) => (index ? `${index},${k + 1}` : `${k + 1}`)));
    }
    if (indices[0] === "") return variable;
    return indices.map((index, k) => ({ ...variable, name: `${variable.name}[${index}]`, start: [variable.start].flat()[k] ?? [variable.start].flat()[0] }));
  });
}

/* How values are shown: in the variable's display unit, as the model description defines it, else in its unit. */
export function displayOf({ unit, displayUnit }, description) {
  const named = (all, name) => [...all].find((one) => one.getAttribute("name") === name);
  const defined = displayUnit && displayUnit !== unit ? named(description.getElementsByTagName("Unit"), unit) : undefined;
  const found = defined && named(defined.getElementsByTagName("DisplayUnit"), displayUnit);
  const shown = found?.getAttribute("inverse") === "true" ? undefined : found;
  const [factor, offset] = [["factor", 1], ["offset", 0]].map(([name, usual]) => Number(shown?.getAttribute(name) ?? usual));
  return {
    unit: (shown ? displayUnit : unit) ?? "",
    // As many digits as are left after the conversion.
    from: (value) => (shown && Number.isFinite(value) ? Number((factor * value + offset).toPrecision(13)) : value),
    to: (value) => (shown ? (value - offset) / factor : value),
  };
}

/* Whether the engine takes a value of this variable between two steps. */
export const takesEffectAtOnce = ({ causality, variability }) => causality === "input" || (causality === "parameter" && variability === "tunable");

/* The JSON of a part of an address. */
function parsed(name, text) {
  try {
    return JSON.parse(text);
  } catch {
    throw new Error(`The address is damaged: \`${name}\` in it is no JSON.`);
  }
}

/* Settings, ghosts, and changes, each {time, name, value}, that an address asks for; `own` has what belongs to the page, by names with an @. */
export function settingsOf(hash) {
  const { ghosts = "", files, changes = "[]", ...rest } = Object.fromEntries(new URLSearchParams(hash.slice(1)));
  const all = Object.entries(rest);
  const settings = Object.fromEntries(all.filter(([name]) => !name.startsWith("@")));
  if (files) settings.files = parsed("files", files);
  const rows = parsed("changes", changes);
  if (!Array.isArray(rows) || !rows.every((row) => Array.isArray(row) && row.length === 3 && Number.isFinite(row[0]) && typeof row[1] === "string")) {
    throw new Error("The address is damaged: `changes` must be a list of [time, name, value].");
  }
  const own = Object.fromEntries(all.filter(([name]) => name.startsWith("@")));
  return { settings, ghosts: ghosts.split(",").filter(Boolean), changes: rows.map(([time, name, value]) => ({ time, name, value })), own };
}

/* The address of a run. */
export function addressOf(settings, { ghosts = [], changes = [], own = {} } = {}) {
  const text = (value) => (typeof value === "object" ? JSON.stringify(value) : String(value));
  const all = new URLSearchParams(Object.entries(settings).concat(Object.entries(own)).map(([name, value]) => [name, text(value)]));
  if (ghosts.length) all.set("ghosts", ghosts.join(","));
  if (changes.length) all.set("changes", JSON.stringify(changes.map(({ time, name, value }) => [Number(time.toFixed(9)), name, value])));
  return `#${all}`;
}

/* Has the browser copy a text: also where a page may not use the clipboard, as over plain http. */
export async function copied(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const field = Object.assign(document.createElement("textarea"), { value: text });
    document.body.append(field);
    field.select();
    const done = document.execCommand("copy");
    field.remove();
    return done;
  }
}
