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

/* Settings and ghosts that an address asks for. */
export function settingsOf(hash) {
  const { ghosts = "", files, ...settings } = Object.fromEntries(new URLSearchParams(hash.slice(1)));
  return { settings: files ? { ...settings, files: JSON.parse(files) } : settings, ghosts: ghosts.split(",").filter(Boolean) };
}

/* The address of a run. */
export function addressOf(settings, ghosts = []) {
  const text = (value) => (typeof value === "object" ? JSON.stringify(value) : String(value));
  const all = new URLSearchParams(Object.entries(settings).map(([name, value]) => [name, text(value)]));
  if (ghosts.length) all.set("ghosts", ghosts.join(","));
  return `#${all}`;
}
