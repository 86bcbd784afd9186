/* The manipulator in motion, drawn by `MachineDrawing`. */
(() => {
  const bodies = data.scene.bodies;
  const drawing = new MachineDrawing(element("machine"), data.scene, { keep: true });
  const { groups, tip } = drawing;
  element("machine").drawing = drawing;
  const desiredLine = drawing.line("#20303f", 0.55);
  const tipLine = drawing.line(TIP_COLOR, 1);
  drawing.label(element("labels"), bodies.map((body) => body.title));

  let run, time = 0, playing = false, before = 0;
  const slider = element("time");

  /* Where the bodies are at this time. */
  function pose() {
    const { world } = poses(data.scene.tree, [1, 2, 3, 4, 5, 6].map((k) => valueAt(run, `hdrm.zeta[${k}]`, time)));
    bodies.forEach(({ name }, k) => {
      groups[k].position.set(...world[name].r);
      groups[k].quaternion.set(...world[name].q);
    });
    tip.position.set(...POSITION.map((name) => valueAt(run, name, time)));
    const every = series(run, POSITION[0])?.every ?? 1;
    tipLine.geometry.setDrawRange(0, Math.floor((time - run.start) / every) + 1);
  }

  /* Before, the machine stands and the controller settles. */
  const begins = () => Math.min(run.motion_start, run.start + run.simulated);

  function readout() {
    const number = (name, factor, digits) => {
      const v = valueAt(run, name, time);
      return Number.isNaN(v) ? "–" : (v * factor).toFixed(digits).replace(/^-(?!.*[1-9])/, "").replace("-", "−");
    };
    const row = (label, i) => html`<tr><td>${label}</td><td>${number(`hdrm.x[${i}]`, 1000, 1)}</td><td>${number(`hdrm.x_dot[${i}]`, 1000, 1)}</td><td>${number(`emla_${i}.F`, 1e-3, 2)}</td><td>${number(`emla_${i}.i_q`, 1, 2)}</td></tr>`;
    show("readout",
      html`<table><tr><td></td><th>stroke, mm</th><th>mm/s</th><th>kN</th><th>A</th></tr>${ACTUATORS.map((label, k) => row(label, k + 1))}
      <tr><td>tip error</td><td colspan="4">${number("controller.tip_error_norm", 1000, 4)} mm</td></tr></table>`);
    element("clock").value = `${time.toFixed(2)} s`;
  }

  function draw() {
    pose();
    readout();
    drawing.render();
    drawing.placeLabels(element("animation-labels").checked);
  }

  function size() {
    drawing.size(element("stage"));
    if (run) draw();
  }

  function view() {
    drawing.view(element("animation-view").value);
    draw();
  }

  function paths() {
    const gain = Number(element("animation-gain").value);
    MachineDrawing.setPoints(desiredLine, path(run, 0));
    MachineDrawing.setPoints(tipLine, path(run, gain));
    draw();
  }

  function tick(now) {
    if (!playing) return;
    const speed = Number(element("animation-speed").value);
    time += (speed * (now - before)) / 1000;
    before = now;
    const end = run.start + run.simulated;
    if (time > end) time = begins();
    slider.value = time;
    draw();
    requestAnimationFrame(tick);
  }

  function play(on) {
    playing = on;
    element("play").textContent = on ? "❚❚ pause" : "▶ play";
    before = performance.now();
    if (on) requestAnimationFrame(tick);
  }

  chooseRun("animation-run", (chosen) => {
    run = chosen;
    slider.min = run.start;
    slider.max = run.start + run.simulated;
    time = Math.min(Math.max(time, begins()), Number(slider.max));
    slider.value = time;
    paths();
  });
  element("play").addEventListener("click", () => play(!playing));
  slider.addEventListener("input", () => {
    time = Number(slider.value);
    if (!playing) draw();
  });
  element("animation-gain").addEventListener("change", paths);
  element("animation-view").addEventListener("change", view);
  element("animation-labels").addEventListener("change", draw);
  drawing.controls.addEventListener("change", () => playing || draw());
  new ResizeObserver(size).observe(element("stage"));
  const theme = () => {
    drawing.surroundings(isDark.matches ? NIGHT : DAY);
    desiredLine.material.color.set(isDark.matches ? "#cfe0f0" : "#20303f");
    draw();
  };
  isDark.addEventListener("change", theme);
  size();
  theme();
  view();
})();
