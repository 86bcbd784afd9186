"use strict";
/*
 * The machine in three dimensions, for the report's animation and for the live page: bodies, ground, light, camera, lines, names.
 * World axes as in the models: x forward, y up. A plain script, as the report has no modules; it asks for three.js as `THREE`.
 */
const METAL = {
  T1: "#56687a", A2: "#ffb400", C2: "#3d5063", D2: "#e8edf2", A3: "#ffb400", C3: "#3d5063", D3: "#e8edf2",
  RK: "#e04848", CP: "#2f95dc", A4: "#8494a5", C4: "#b3c0cc", D4: "#8494a5", PL: "#a9814f",
};
const TIP_COLOR = "#d4145a";
const DAY = { sky: "#dce6f0", ground: "#aeb8c0", slab: "#a3adb6" };
const NIGHT = { sky: "#141c26", ground: "#222d38", slab: "#293642" };
/* three.js's `BasicShadowMap`: without soft edges. */
const BASIC_SHADOWS = 0;
/* Length of the reference machine's chain of bodies from the ground to the tip, m. */
const REFERENCE_LENGTH = 5.9533;
/* Where the eye is and what it looks at, for the reference machine; `at` is the tip. */
const VIEWS = {
  whole: () => [[2.6, 1.9, 5.6], [1.55, 1.3, 0]],
  wide: () => [[2.9, 2.2, 7.2], [1.6, 1.55, 0]],
  linkages: () => [[1.7, 2, 2.9], [1.35, 1.9, 0]],
  tip: (at) => [[at.x + 0.9, at.y + 0.7, at.z + 1.3], [at.x - 0.1, at.y + 0.1, at.z]],
  side: () => [[1.6, 1.5, 5.9], [1.6, 1.4, 0]],
  top: () => [[1.6, 7.5, 0.01], [1.6, 0, 0]],
};

class MachineDrawing {
  /* `bodies` and `tree` as crate `report` describes them; `keep` lets the picture be read after it was drawn; `plain` draws it in a third of the time.
   * The context has no alpha, so that nothing under the canvas is drawn. */
  constructor(canvas, { bodies, tree, floor }, { keep = false, plain = false }) {
    const chain = ["r_T1_O", "r_A2_B", "r_A3_A4", "r_A4_C4", "r_C4_D4", "r_D4_T4"];
    /* How much larger than the reference machine this one is. */
    const scale = chain.reduce((sum, name) => sum + Math.hypot(...tree[name]), 0) / REFERENCE_LENGTH;
    Object.assign(this, { canvas, bodies, plain, scale, floor });
    const context = canvas.getContext("webgl2", { alpha: false, antialias: !plain, preserveDrawingBuffer: keep });
    if (!context) throw new Error("This browser has no WebGL 2, or it is switched off: nothing can be drawn in three dimensions.");
    this.renderer = new THREE.WebGLRenderer({ canvas, context });
    this.sharpness(1);
    Object.assign(this.renderer.shadowMap, { enabled: true, autoUpdate: !plain }, plain && { type: BASIC_SHADOWS });
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.05, 60 * Math.max(scale, 1));
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.maxPolarAngle = 0.52 * Math.PI;
    this.controls.listenToKeyEvents(canvas);
    this.light();
    this.surroundings(DAY);
    /* What stands on the base: everything but the ground. */
    this.base = new THREE.Group();
    this.scene.add(this.base);
    this.groups = this.machine(() => ({}));
    this.tip = new THREE.Mesh(
      new THREE.SphereGeometry(0.03, 24, 16),
      this.surface({ color: TIP_COLOR, emissive: TIP_COLOR, emissiveIntensity: 0.5, depthTest: false }));
    this.tip.renderOrder = 3;
    this.base.add(this.tip);
    /* Middle of what is drawn of a body, in body axes. */
    this.middles = bodies.map((body) => {
      const main = MachineDrawing.shape(body.shapes[0]);
      main.computeBoundingSphere();
      return main.boundingSphere.center;
    });
  }

  /* A surface; a plain one has no highlights. */
  surface({ metalness = 0, roughness = 1, ...look }) {
    return this.plain ? new THREE.MeshLambertMaterial(look) : new THREE.MeshStandardMaterial({ metalness, roughness, ...look });
  }

  light() {
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#b9c3cd", 2.1));
    const sun = new THREE.DirectionalLight("#fff6e6", 3);
    sun.position.set(2.5, 7, 4.5).multiplyScalar(this.scale);
    sun.target.position.set(1.5, 1, 0).multiplyScalar(this.scale);
    sun.castShadow = true;
    sun.shadow.mapSize.setScalar(this.plain ? 512 : 2048);
    const [side, near, far] = [5, 1, 20].map((length) => length * this.scale);
    Object.assign(sun.shadow.camera, { left: -side, right: side, top: side, bottom: -side, near, far });
    sun.shadow.bias = -0.0005;
    sun.shadow.normalBias = 0.02;
    this.scene.add(sun, sun.target);
  }

  /* Colours of sky and ground; may be called again. */
  surroundings({ sky, ground, slab }) {
    this.scene.background = new THREE.Color(sky);
    this.scene.fog = new THREE.Fog(sky, 14 * this.scale, 32 * this.scale);
    if (this.ground) this.scene.remove(this.ground);
    this.ground = new THREE.Group();
    // Slabs of 1 m in two colours: thin lines would break where pictures have few points.
    const half = 12 * Math.ceil(this.scale - 0.01);
    const slabs = Array.from({ length: 4 * half * half }, (_, k) => [k % (2 * half) - half, Math.floor(k / (2 * half)) - half]).filter(([x, z]) => (x + z) % 2 === 0);
    const squares = slabs.map(([x, z]) => new THREE.PlaneGeometry(1, 1).translate(x + 0.5, z + 0.5, 0.002));
    for (const [geometry, color] of [[new THREE.PlaneGeometry(80, 80), ground], [MachineDrawing.merged(squares), slab]]) {
      const floor = new THREE.Mesh(geometry, this.surface({ color }));
      floor.rotation.x = -Math.PI / 2;
      floor.receiveShadow = true;
      this.ground.add(floor);
    }
    this.ground.position.y = this.floor;
    if (this.floor < 0) {
      // What carries a base that is above the ground.
      const stand = new THREE.Mesh(new THREE.BoxGeometry(0.8, -this.floor, 0.8).translate(0, -this.floor / 2, 0), this.surface({ color: slab }));
      stand.castShadow = stand.receiveShadow = true;
      this.ground.add(stand);
    }
    this.scene.add(this.ground);
  }

  /* The bodies once more, each a mesh, which is drawn by one call; `look` gives what a body's material has other than usual. */
  machine(look) {
    return this.bodies.map((body) => {
      const rod = body.name.startsWith("D") && body.name !== "D4";
      const material = this.surface({
        color: METAL[body.name] ?? "#888888", metalness: rod ? 0.4 : 0.05, roughness: rod ? 0.3 : 0.55,
        transparent: body.name === "PL", opacity: body.name === "PL" ? 0.45 : 1, ...look(body) });
      const mesh = new THREE.Mesh(MachineDrawing.merged(body.shapes.map(MachineDrawing.shape)), material);
      mesh.castShadow = mesh.receiveShadow = true;
      this.base.add(mesh);
      return mesh;
    });
  }

  static shape({ kind, ...its }) {
    if (kind === "plate") {
      const outline = new THREE.Shape();
      its.outline.forEach(([x, y], k) => (k ? outline.lineTo(x, y) : outline.moveTo(x, y)));
      const [z0, z1] = its.z;
      const bevel = Math.min(0.008, 0.2 * (z1 - z0));
      return new THREE.ExtrudeGeometry(outline, {
        depth: z1 - z0 - 2 * bevel, bevelSize: bevel, bevelThickness: bevel, bevelOffset: -bevel, bevelSegments: 2,
      }).translate(0, 0, z0 + bevel);
    }
    if (kind === "box") return new THREE.BoxGeometry(...its.size).translate(...its.centre);
    const [from, to] = [new THREE.Vector3(...its.from), new THREE.Vector3(...its.to)];
    const axis = to.clone().sub(from);
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), axis.clone().normalize());
    return new THREE.CylinderGeometry(its.radius, its.radius, axis.length(), 36).applyQuaternion(turn).translate(...from.add(to).multiplyScalar(0.5).toArray());
  }

  /* Geometries as one. */
  static merged(geometries) {
    const all = geometries.map((geometry) => (geometry.index ? geometry.toNonIndexed() : geometry));
    const merged = new THREE.BufferGeometry();
    for (const name of ["position", "normal"]) {
      const values = all.flatMap((geometry) => [...geometry.attributes[name].array]);
      merged.setAttribute(name, new THREE.BufferAttribute(new Float32Array(values), 3));
    }
    return merged;
  }

  /* A line through points [x, y, z]; drawn over everything. */
  line(color, opacity) {
    const material = new THREE.LineBasicMaterial({ color, transparent: true, opacity, depthTest: false });
    const made = new THREE.Line(new THREE.BufferGeometry(), material);
    made.frustumCulled = false;
    made.renderOrder = 2;
    this.base.add(made);
    return made;
  }

  static setPoints(line, xyz) {
    const points = new Float32Array(3 * (xyz ? xyz[0].length : 0));
    xyz?.forEach((axis, i) => axis.forEach((v, k) => (points[3 * k + i] = v)));
    line.geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
  }

  /* Spans with the given texts in `parent`, to be placed at the bodies. */
  label(parent, texts) {
    this.labels = texts.map((text) => {
      const span = document.createElement("span");
      span.textContent = text;
      parent.append(span);
      return span;
    });
  }

  /* Each text that is to be shown at its body; those that would cover each other move down. */
  placeLabels(show) {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const placed = [];
    this.labels.forEach((span, j) => {
      const p = this.middles[j].clone().applyMatrix4(this.groups[j].matrixWorld).project(this.camera);
      span.hidden = !show || !span.textContent || p.z > 1 || Math.abs(p.x) > 1 || Math.abs(p.y) > 1;
      if (span.hidden) return;
      const reach = 3.6 * span.textContent.length;
      const at = { x: Math.min(Math.max((0.5 + 0.5 * p.x) * width, reach), width - reach), y: (0.5 - 0.5 * p.y) * height, reach };
      while (placed.some((o) => Math.abs(o.y - at.y) < 16 && Math.abs(o.x - at.x) < o.reach + at.reach)) at.y += 4;
      placed.push(at);
      span.style.left = `${at.x}px`;
      span.style.top = `${at.y}px`;
    });
  }

  /* Draws this part of the points that the screen has in a row; true where it was another part before. */
  sharpness(part) {
    if (part === this.part) return false;
    this.part = part;
    this.renderer.setPixelRatio(part * (this.plain ? 1 : Math.min(window.devicePixelRatio, 2)));
    return true;
  }

  /* The picture fills the element. */
  size({ clientWidth, clientHeight }) {
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
  }

  view(name) {
    const [eye, target] = VIEWS[name](this.tip.position.clone().divideScalar(this.scale)).map((point) => point.map((v) => v * this.scale));
    this.controls.target.set(...target);
    // In a picture higher than wide the eye goes back until the width fits; over a low ground, until the machine fits from it upward.
    const low = name === "tip" ? 0 : this.floor / 2;
    const back = Math.max(1, 1.15 / this.camera.aspect) * (1 - low / (2 * this.scale));
    this.camera.position.set(...eye).sub(this.controls.target).multiplyScalar(back).add(this.controls.target);
    for (const place of [this.camera.position, this.controls.target]) place.y += low;
    this.controls.update();
    // Who points at the machine before the next picture points by this view.
    this.camera.updateMatrixWorld();
  }

  render() {
    if (this.plain) this.renderer.shadowMap.needsUpdate = this.odd = !this.odd;
    this.renderer.render(this.scene, this.camera);
  }
}
