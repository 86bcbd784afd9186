/* The manipulator in motion. World axes as in the models: x forward, y up. */
(() => {
  const METAL = {
    T1: "#56687a", A2: "#ffb400", C2: "#3d5063", D2: "#e8edf2", A3: "#ffb400", C3: "#3d5063", D3: "#e8edf2",
    RK: "#e04848", CP: "#2f95dc", A4: "#8494a5", C4: "#b3c0cc", D4: "#8494a5", PL: "#a9814f",
  };
  const bodies = data.scene.bodies;
  const canvas = element("machine");
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  renderer.shadowMap.enabled = true;
  const scene = new THREE.Scene();
  scene.background = new THREE.Color("#dfe7ef");
  scene.fog = new THREE.Fog("#dfe7ef", 14, 32);
  const camera = new THREE.PerspectiveCamera(35, 1, 0.05, 60);
  const controls = new THREE.OrbitControls(camera, canvas);
  controls.enableDamping = false;
  controls.maxPolarAngle = 0.52 * Math.PI;
  controls.listenToKeyEvents(canvas);

  scene.add(new THREE.HemisphereLight("#ffffff", "#b9c3cd", 2.1));
  const sun = new THREE.DirectionalLight("#fff6e6", 3);
  sun.position.set(2.5, 7, 4.5);
  sun.target.position.set(1.5, 1, 0);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  Object.assign(sun.shadow.camera, { left: -5, right: 5, top: 5, bottom: -5, near: 1, far: 20 });
  sun.shadow.bias = -0.0005;
  sun.shadow.normalBias = 0.02;
  scene.add(sun, sun.target);
  const ground = new THREE.Mesh(new THREE.PlaneGeometry(80, 80), new THREE.MeshStandardMaterial({ color: "#cfd8e1", roughness: 1 }));
  ground.rotation.x = -Math.PI / 2;
  ground.receiveShadow = true;
  const grid = new THREE.GridHelper(40, 40, "#aab6c2", "#bcc7d2");
  grid.position.y = 0.002;
  scene.add(ground, grid);

  function shape(description, material) {
    let geometry;
    const { kind } = description;
    if (kind === "plate") {
      const outline = new THREE.Shape();
      description.outline.forEach(([x, y], k) => (k ? outline.lineTo(x, y) : outline.moveTo(x, y)));
      const [z0, z1] = description.z;
      const bevel = Math.min(0.008, 0.2 * (z1 - z0));
      geometry = new THREE.ExtrudeGeometry(outline, {
        depth: z1 - z0 - 2 * bevel, bevelSize: bevel, bevelThickness: bevel, bevelOffset: -bevel, bevelSegments: 2 });
      geometry.translate(0, 0, z0 + bevel);
    } else if (kind === "bar") {
      const [from, to] = [new THREE.Vector3(...description.from), new THREE.Vector3(...description.to)];
      const axis = to.clone().sub(from);
      geometry = new THREE.CylinderGeometry(description.radius, description.radius, axis.length(), 36);
      geometry.applyQuaternion(new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), axis.normalize()));
      geometry.translate(...from.add(to).multiplyScalar(0.5).toArray());
    } else {
      geometry = new THREE.BoxGeometry(...description.size);
      geometry.translate(...description.centre);
    }
    const mesh = new THREE.Mesh(geometry, material);
    mesh.castShadow = mesh.receiveShadow = true;
    return mesh;
  }

  const groups = bodies.map((body) => {
    const rod = body.name.startsWith("D") && body.name !== "D4";
    const material = new THREE.MeshStandardMaterial({
      color: METAL[body.name] ?? "#888888", metalness: rod ? 0.4 : 0.05, roughness: rod ? 0.3 : 0.55,
      transparent: body.name === "PL", opacity: body.name === "PL" ? 0.45 : 1 });
    const group = new THREE.Group();
    body.shapes.forEach((s) => group.add(shape(s, material)));
    scene.add(group);
    return group;
  });
  const tip = new THREE.Mesh(new THREE.SphereGeometry(0.03, 24, 16), new THREE.MeshStandardMaterial({ color: "#d4145a", emissive: "#d4145a", emissiveIntensity: 0.5, depthTest: false }));
  tip.renderOrder = 3;
  scene.add(tip);

  /* A line through points [x, y, z]; drawn over everything. */
  function line(color, opacity) {
    const material = new THREE.LineBasicMaterial({ color, transparent: true, opacity, depthTest: false });
    const made = new THREE.Line(new THREE.BufferGeometry(), material);
    made.frustumCulled = false;
    made.renderOrder = 2;
    scene.add(made);
    return made;
  }
  const desiredLine = line("#20303f", 0.55);
  const tipLine = line("#d4145a", 1);
  function setPoints(target, xyz) {
    const points = new Float32Array(3 * (xyz ? xyz[0].length : 0));
    xyz?.forEach((axis, i) => axis.forEach((v, k) => (points[3 * k + i] = v)));
    target.geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
  }

  const labels = bodies.map((body) => {
    const span = document.createElement("span");
    span.textContent = body.title;
    element("labels").append(span);
    return span;
  });
  /* Middle of what is drawn of a body, in body axes. */
  const middles = groups.map((group) => {
    const main = group.children[0].geometry;
    main.computeBoundingSphere();
    return main.boundingSphere.center.clone();
  });

  const frameCache = new Map();
  let run, frames, time = 0, playing = false, before = 0;
  const slider = element("time");
  const [a, b] = [new THREE.Quaternion(), new THREE.Quaternion()];

  /* Poses between the two frames around the time. */
  function pose() {
    const count = frames.length / (7 * bodies.length);
    const at = Math.min((time - run.start) / run.frames_every, count - 1);
    const k = Math.min(Math.floor(at), count - 2);
    const part = at - k;
    groups.forEach((group, j) => {
      const [o, p] = [7 * (k * bodies.length + j), 7 * ((k + 1) * bodies.length + j)];
      const mix = (i) => frames[o + i] + part * (frames[p + i] - frames[o + i]);
      group.position.set(mix(0), mix(1), mix(2));
      a.fromArray(frames, o + 3);
      b.fromArray(frames, p + 3);
      group.quaternion.copy(a.slerp(b, part));
    });
    tip.position.set(...POSITION.map((name) => valueAt(run, name, time)));
    const every = series(run, POSITION[0])?.every ?? 1;
    tipLine.geometry.setDrawRange(0, Math.floor((time - run.start) / every) + 1);
  }

  function place() {
    const show = element("animation-labels").checked;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const placed = [];
    labels.forEach((span, j) => {
      const p = middles[j].clone().applyQuaternion(groups[j].quaternion).add(groups[j].position).project(camera);
      span.hidden = !show || p.z > 1 || Math.abs(p.x) > 1 || Math.abs(p.y) > 1;
      if (span.hidden) return;
      const at = { x: (0.5 + 0.5 * p.x) * width, y: (0.5 - 0.5 * p.y) * height, reach: 3.6 * span.textContent.length };
      // Names that would cover each other move down.
      while (placed.some((o) => Math.abs(o.y - at.y) < 16 && Math.abs(o.x - at.x) < o.reach + at.reach)) at.y += 4;
      placed.push(at);
      span.style.left = `${at.x}px`;
      span.style.top = `${at.y}px`;
    });
  }

  function readout() {
    const number = (name, factor, digits) => {
      const v = valueAt(run, name, time);
      return Number.isNaN(v) ? "–" : (v * factor).toFixed(digits);
    };
    const row = (label, i) => `<tr><td>${label}</td><td>${number(`hdrm.x[${i}]`, 1000, 1)}</td><td>${number(`hdrm.x_dot[${i}]`, 1000, 1)}</td><td>${number(`emla_${i}.F`, 1e-3, 2)}</td><td>${number(`emla_${i}.i_q`, 1, 2)}</td></tr>`;
    element("readout").innerHTML =
      `<table><tr><th></th><th>stroke, mm</th><th>mm/s</th><th>kN</th><th>A</th></tr>${ACTUATORS.map((label, k) => row(label, k + 1)).join("")}` +
      `<tr><td>tip error</td><td colspan="4">${number("controller.tip_error_norm", 1000, 4)} mm</td></tr></table>`;
    element("clock").value = `${time.toFixed(2)} s`;
  }

  function draw() {
    pose();
    readout();
    renderer.render(scene, camera);
    place();
  }

  function size() {
    const { clientWidth, clientHeight } = element("stage");
    renderer.setSize(clientWidth, clientHeight, false);
    camera.aspect = clientWidth / clientHeight;
    camera.updateProjectionMatrix();
    if (run) draw();
  }

  function view() {
    const at = tip.position;
    const views = {
      whole: [[2.6, 1.9, 5.6], [1.55, 1.3, 0]], linkages: [[1.7, 2, 2.9], [1.35, 1.9, 0]],
      tip: [[at.x + 0.9, at.y + 0.7, at.z + 1.3], [at.x - 0.1, at.y + 0.1, at.z]], side: [[1.6, 1.5, 5.9], [1.6, 1.4, 0]],
    };
    const [eye, target] = views[element("animation-view").value];
    camera.position.set(...eye);
    controls.target.set(...target);
    controls.update();
    draw();
  }

  function paths() {
    const gain = Number(element("animation-gain").value);
    setPoints(desiredLine, path(run, 0));
    setPoints(tipLine, path(run, gain));
    draw();
  }

  function tick(now) {
    if (!playing) return;
    const speed = Number(element("animation-speed").value);
    time += (speed * (now - before)) / 1000;
    before = now;
    const end = run.start + run.simulated;
    if (time > end) time = run.start;
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
    if (!frameCache.has(run)) frameCache.set(run, decode(run.frames));
    frames = frameCache.get(run);
    slider.min = run.start;
    slider.max = run.start + run.simulated;
    time = Math.min(Math.max(time, run.start), Number(slider.max));
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
  controls.addEventListener("change", () => playing || draw());
  new ResizeObserver(size).observe(element("stage"));
  size();
  view();
})();
