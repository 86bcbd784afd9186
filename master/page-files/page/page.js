/* What both pages have: elements, messages, files that are dropped. */

export const element = (id) => document.getElementById(id);

const escaped = (value) => String(value ?? "").replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);

/* The element of a template; values are texts, whatever they hold. */
export function html(parts, ...values) {
  const template = document.createElement("template");
  template.innerHTML = String.raw({ raw: parts }, ...values.map(escaped)).trim();
  return template.content.firstElementChild;
}

/* A box to tick. */
export function tickBox(text, checked, changed, value = "") {
  const label = html`<label><input type="checkbox" value="${value}">${text}</label>`;
  const [field] = label.children;
  field.checked = checked;
  field.addEventListener("change", () => changed(field.checked));
  return label;
}

export class Page {
  /* Does it, and says what stood in the way; then the page shows what is, not what was wanted. */
  async attempt(act) {
    try {
      await act();
    } catch (error) {
      this.say(error.message);
      await this.follow?.();
    }
  }

  /* What is done at an event of the element. */
  on(id, act, event = "click") {
    element(id).addEventListener(event, () => this.attempt(act));
  }

  /* Files that are dropped onto the page, or picked after a click on one of these buttons, are given to `read`. */
  takeFiles(buttons, hint) {
    const picker = element("file");
    buttons.forEach((id) => this.on(id, () => picker.click()));
    this.on("file", () => picker.files[0] && this.read(picker.files[0]), "change");
    document.body.dataset.drop = hint;
    for (const kind of ["dragover", "dragleave", "drop"]) {
      document.addEventListener(kind, (event) => {
        event.preventDefault();
        document.body.classList.toggle("dropping", kind === "dragover");
        if (kind === "drop" && event.dataTransfer.files[0]) this.attempt(() => this.read(event.dataTransfer.files[0]));
      });
    }
  }
}

/* `window.machine`: a page for scripts. `its` has `engine`, `engineOf(ghost)`, `start(settings)`, `play()`, `pause()`, `advance(seconds)`,
 * `set(name, value)`, and may have a `verdict()` that knows more than the engine's. */
export function scripted(its, ready) {
  window.machine = {
    ready,
    restart: (settings) => its.start({ ...settings }),
    play: () => its.play(),
    pause: () => its.pause(),
    advance: (seconds) => its.advance(seconds),
    get: async (name, ghost) => its.engineOf(ghost).get(name),
    set: (name, value) => its.set(name, value),
    get time() {
      return its.engine?.time ?? NaN;
    },
    verdict: () => (its.verdict ? its.verdict() : its.engine.verdict()),
  };
}
