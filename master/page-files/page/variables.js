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
