/*
 * The live machine in three dimensions, on top of `MachineDrawing`: ghosts under other laws, the reference with its shadow on the ground, the
 * way of the tip, forces of the rods, load chart, what hangs at the tip, the push that one drags, waypoints.
 */
import { placeOf, poses } from "./kinematics.js";

/* Points of the tip's way that are kept. */
const WAY = 4000;
/* Force of a push per metre dragged, N/m, and the largest, N. */
const PUSH_STIFFNESS = 1500;
const PUSH_MOST = 2000;
const REFERENCE = "#00a6c8";
/* Force of the floor on the tip per metre of its arrow, N/m; the arrow is this long at most, m. */
const [CONTACT_SCALE, CONTACT_MOST] = [2000, 1.5];
const CONTACT = "#1fa35c";
const LIMIT = "#d98800";
/* Forces of the rods: one that pushes, and one that pulls; length of the arrow, m, at no force and what the rated force adds. */
const [PUSHES, PULLS, ARROW, ARROW_RATED] = ["#e8590c", "#1c7ed6", 0.15, 0.6];
/* Colours of the load chart's curves, from the least payload. */
const CHART = ["#c92a2a", "#d9660a", "#b08800", "#5c940d", "#2b8a3e", "#0b7285"];
/* A push that is held follows the machine this often, ms. */
const PUSH_EVERY = 60;
/* Time that a picture takes, ms: more of it means fewer points, less of it more of them; and time without change after which nothing moves. */
const [SLOW, FAST, STILL] = [34, 20, 400];
const ROD_LABELS = { C2: 1, C3: 2, T1: 0 };

/* Whether the browser draws without a graphics processor. */
function drawsInSoftware() {
  const context = document.createElement("canvas").getContext("webgl2");
  const name = context?.getParameter(context.RENDERER) ?? "";
  // Firefox says it at once, Chromium and WebKit when they are asked otherwise.
  const info = /^webkit/i.test(name) ? context.getExtension("WEBGL_debug_renderer_info") : null;
  return /swiftshader|llvmpipe|software|basic render/i.test(info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : name);
}

/* A line to which points are added; the oldest go. */
class Way {
  constructor(line) {
    this.line = line;
    this.points = new Float32Array(3 * WAY);
    this.line.geometry.setAttribute("position", new THREE.BufferAttribute(this.points, 3));
    this.clear();
  }

  clear() {
    this.count = 0;
    this.line.geometry.setDrawRange(0, 0);
  }

  add([x, y, z]) {
    const k = 3 * (this.count - 1);
    if (this.count && Math.hypot(x - this.points[k], y - this.points[k + 1], z - this.points[k + 2]) < 1e-3) return;
    if (this.count === WAY) {
      this.points.copyWithin(0, 3 * 500);
      this.count -= 500;
    }
    this.points.set([x, y, z], 3 * this.count);
    this.count += 1;
    this.line.geometry.attributes.position.needsUpdate = true;
    this.line.geometry.setDrawRange(0, this.count);
  }
}

export class LiveScene {
  /* `data`: bodies and tree of the machine. `pushed(force)` is told the force at the tip in world axes, N; `clicked(point)` a waypoint. */
  constructor(stage, data, pushed, clicked) {
    Object.assign(this, { stage, data, pushed, clicked, ghosts: [], gain: 100, aiming: false, pace: FAST, changed: 0 });
    this.canvas = stage.querySelector("canvas");
    const drawing = (this.drawing = new MachineDrawing(this.canvas, data, { plain: drawsInSoftware() }));
    this.moving = drawing.plain ? 0.75 : 1;
    drawing.label(stage.querySelector("#labels"), data.bodies.map(() => ""));
    this.way = new Way(drawing.line(TIP_COLOR, 1));
    this.desiredWay = new Way(drawing.line("#20303f", 0.5));
    this.reference = this.mark(new THREE.SphereGeometry(0.045, 24, 16), REFERENCE);
    this.reference.material.opacity = 0.35;
    // One drags it: large enough, and over all else that is transparent.
    drawing.tip.material.transparent = true;
    drawing.tip.scale.setScalar(1.3);
    this.drop = drawing.line(REFERENCE, 0.5);
    MachineDrawing.setPoints(this.drop, [[0, 0], [0, 1], [0, 0]]);
    this.shadow = this.mark(new THREE.CylinderGeometry(0.06, 0.06, 0.002, 24), REFERENCE);
    this.load = this.mark(new THREE.SphereGeometry(1, 24, 16), "#7a4f1d");
    this.load.castShadow = true;
    this.load.visible = false;
    this.arrow = this.arrowMark("#ff3b30");
    this.contact = this.arrowMark(CONTACT);
    this.rods = this.data.rated.map(() => this.arrowMark(PUSHES));
    this.limits();
    this.chart();
    this.gripper();
    // Where tip and ghosts' tips are, as far from the reference as the drawn error says.
    this.error = this.mark(new THREE.SphereGeometry(0.03, 16, 12), TIP_COLOR);
    this.errors = [];
    this.waypoints = new THREE.Group();
    drawing.base.add(this.waypoints);
    this.person();
    this.theme();
    this.pointer();
    this.sight = "wide";
    // A view that nobody has turned since fits the new size too: a phone that is held upright shows all of the machine.
    new ResizeObserver(() => { drawing.size(stage); if (this.sight) this.view(this.sight); this.dirty = true; }).observe(stage);
    drawing.size(stage);
    drawing.view(this.sight);
    drawing.controls.addEventListener("start", () => (this.sight = null));
    drawing.controls.addEventListener("change", () => (this.dirty = true));
  }

  mark(geometry, color) {
    const made = new THREE.Mesh(geometry, this.drawing.surface({ color, emissive: color, emissiveIntensity: 0.35, transparent: true, opacity: 0.9 }));
    this.drawing.base.add(made);
    return made;
  }

  /* An arrow of 1 m that is seen through all bodies, for `point`. */
  arrowMark(color) {
    const parts = [new THREE.CylinderGeometry(0.025, 0.025, 0.7, 12).translate(0, 0.35, 0), new THREE.CylinderGeometry(0, 0.075, 0.3, 16).translate(0, 0.85, 0)];
    const made = this.mark(MachineDrawing.merged(parts), color);
    made.material.depthTest = false;
    made.renderOrder = 4;
    made.visible = false;
    return made;
  }

  /* The arrow begins at the point and shows along the vector, `length` m long. */
  point(arrow, at, vector, length) {
    arrow.visible = length > 0;
    if (!arrow.visible) return;
    arrow.position.set(...at);
    arrow.scale.set(1, length, 1);
    arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...vector).normalize());
  }

  /* Somebody 1.8 m tall, for scale, outside the machine's reach to the front. */
  person() {
    const bar = (from, to, radius) => MachineDrawing.shape({ kind: "bar", from, to, radius });
    const sides = (make) => [-1, 1].flatMap(make);
    const clothes = {
      "#f08c00": [new THREE.CylinderGeometry(0.17, 0.15, 0.58, 16).translate(0, 1.16, 0), ...sides((z) => [bar([0, 1.4, 0.2 * z], [0.04, 1.08, 0.25 * z], 0.055)])],
      "#364a5e": sides((z) => [bar([0, 0.06, 0.09 * z], [0, 0.9, 0.08 * z], 0.075), bar([-0.05, 0.04, 0.09 * z], [0.13, 0.04, 0.1 * z], 0.045)]),
      "#c99a77": [new THREE.SphereGeometry(0.105, 16, 12).translate(0, 1.63, 0), ...sides((z) => [bar([0.04, 1.08, 0.25 * z], [0.16, 0.86, 0.24 * z], 0.042)])],
      "#ffe066": [new THREE.SphereGeometry(0.125, 16, 8, 0, 2 * Math.PI, 0, 0.5 * Math.PI).translate(0, 1.66, 0), new THREE.CylinderGeometry(0.15, 0.15, 0.012, 16).translate(0.02, 1.66, 0)],
    };
    for (const [color, parts] of Object.entries(clothes)) {
      const mesh = new THREE.Mesh(MachineDrawing.merged(parts), this.drawing.surface({ color }));
      mesh.position.set(-0.9, this.data.floor, -0.4);
      mesh.castShadow = true;
      this.drawing.scene.add(mesh);
    }
  }

  /* Two jaws at the end of the last body, which have no mass: the tip is between their ends. */
  gripper() {
    const [reach, , ] = this.data.tree.r_D4_T4;
    const bar = (from, to, radius) => MachineDrawing.shape({ kind: "bar", from, to, radius });
    const jaws = [-1, 1].flatMap((side) => [bar([reach - 0.16, 0, 0], [reach - 0.08, 0, 0.07 * side], 0.022), bar([reach - 0.08, 0, 0.07 * side], [reach + 0.02, 0, 0.045 * side], 0.018)]);
    const mesh = new THREE.Mesh(MachineDrawing.merged(jaws), this.drawing.surface({ color: "#2b3541", metalness: 0.3, roughness: 0.5 }));
    mesh.castShadow = true;
    this.drawing.groups[this.data.bodies.findIndex(({ name }) => name === "D4")].add(mesh);
  }

  /* Bands along pieces [x, y, x, y] in the plane z = 0, which shine. */
  bands(pieces, width, color, opacity) {
    const corners = pieces.flatMap(([x, y, u, v]) => {
      const scale = width / 2 / (Math.hypot(u - x, v - y) || 1);
      const [a, b] = [(y - v) * scale, (u - x) * scale];
      return [x + a, y + b, 0, x - a, y - b, 0, u + a, v + b, 0, u + a, v + b, 0, x - a, y - b, 0, u - a, v - b, 0];
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(corners), 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(corners.map((_, k) => (k % 3 === 2 ? 1 : 0))), 3));
    const made = this.mark(geometry, color);
    // Seen from both sides.
    Object.assign(made.material, { opacity, side: 2, depthWrite: false, emissiveIntensity: 0.8 });
    return made;
  }

  /* Ranges of slew, lift and tilt as arcs about their joints; the last two turn with what carries them. */
  limits() {
    const { tree, joints } = this.data;
    const arc = ([least, most], radius, offset) => {
      const at = (k, r) => [Math.cos(offset + least + (k / 40) * (most - least)), Math.sin(offset + least + (k / 40) * (most - least))].map((v) => r * v);
      const round = Array.from({ length: 40 }, (_, k) => [...at(k, radius), ...at(k + 1, radius)]);
      return this.bands([...round, ...[0, 40].map((k) => [...at(k, 0.82 * radius), ...at(k, 1.06 * radius)])], 0.04, LIMIT, 0.6);
    };
    const boom = Math.atan2(tree.e_boom[1], tree.e_boom[0]);
    const elbow = Math.atan2(tree.r_A2_B[1], tree.r_A2_B[0]);
    const slew = arc(joints[0], 1, 0);
    slew.rotation.x = -Math.PI / 2;
    slew.position.y = 0.01;
    this.arcs = [[arc(joints[1], 0.5, elbow - tree.lift.beta2), "T1", tree.r_T1_O], [arc(joints[2], 0.4, boom), "A2", tree.r_A2_B]];
  }

  /* The load chart in the boom's plane: on each curve the tip holds this payload at most. */
  chart() {
    this.curves = this.data.chart.map(({ payload, pieces }, k) => {
      const mesh = this.bands(pieces, 0.02, CHART[k % CHART.length], 0.8);
      const [x, y] = pieces.flatMap(([x, y, u, v]) => [[x, y], [u, v]]).reduce((best, one) => (one[1] > best[1] ? one : best));
      const text = document.createElement("span");
      Object.assign(text, { textContent: `${payload} kg`, hidden: true, className: "payload" });
      text.style.color = CHART[k % CHART.length];
      this.stage.querySelector("#labels").append(text);
      return { mesh, text, place: new THREE.Vector3(x, y + 0.06, 0) };
    });
    this.showChart(false);
  }

  showChart(on) {
    this.charted = on;
    this.curves.forEach(({ mesh }) => (mesh.visible = on));
    this.dirty = true;
  }

  /* The curves turn with the column. */
  placeChart() {
    const { drawing, canvas } = this;
    for (const { mesh, text, place } of this.curves) {
      mesh.quaternion.copy(drawing.groups[0].quaternion);
      const p = place.clone().applyQuaternion(mesh.quaternion).applyMatrix4(drawing.base.matrixWorld).project(drawing.camera);
      text.hidden = !this.charted || p.z > 1 || Math.abs(p.x) > 1 || Math.abs(p.y) > 1;
      [text.style.left, text.style.top] = [`${(0.5 + 0.5 * p.x) * canvas.clientWidth}px`, `${(0.5 - 0.5 * p.y) * canvas.clientHeight}px`];
    }
  }

  bodyPlace(name) {
    return this.drawing.groups[this.data.bodies.findIndex((body) => body.name === name)];
  }

  /* Arrows at what the rods push or pull: at the column's rack, and at the ends of the rods. */
  showForces(forces) {
    const { r_B, lift, tilt } = this.data.tree;
    const ends = [["T1", [0, 0.3, r_B]], ["D2", [lift.lc, 0, 0]], ["D3", [tilt.lc, 0, 0]]];
    this.rods.forEach((arrow, k) => {
      const [name, at] = ends[k];
      const { position, quaternion } = this.bodyPlace(name);
      const share = Math.abs(forces[k]) / this.data.rated[k];
      const along = new THREE.Vector3(Math.sign(forces[k]), 0, 0).applyQuaternion(quaternion);
      const place = new THREE.Vector3(...at).applyQuaternion(quaternion).add(position);
      this.point(arrow, place.toArray(), along.toArray(), share > 0.01 ? ARROW + ARROW_RATED * share : 0);
      for (const part of ["color", "emissive"]) arrow.material[part].set(forces[k] > 0 ? PUSHES : PULLS);
    });
  }

  /* The lowest of the bodies that move, and of what hangs at the tip: its height over the floor, m, and what it is called. */
  lowest() {
    const { bodies, groups } = this.drawing;
    const heights = bodies.map(({ name, title }, k) => {
      if (["T1", "C2", "D2"].includes(name)) return { height: Infinity, title };
      groups[k].geometry.boundingBox ?? groups[k].geometry.computeBoundingBox();
      const { min, max } = groups[k].geometry.boundingBox;
      const up = new THREE.Vector3(0, 1, 0).applyQuaternion(groups[k].quaternion.clone().invert());
      const low = ["x", "y", "z"].reduce((sum, axis) => sum + Math.min(up[axis] * min[axis], up[axis] * max[axis]), 0);
      return { height: groups[k].position.y + low - this.data.floor, title };
    });
    if (this.load.visible) heights.push({ height: this.load.position.y - this.load.scale.y - this.data.floor, title: "load" });
    return heights.reduce((a, b) => (b.height < a.height ? b : a));
  }

  theme() {
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    this.drawing.surroundings(dark ? NIGHT : DAY);
    this.desiredWay.line.material.color.set(dark ? "#cfe0f0" : "#20303f");
    this.dirty = true;
  }

  view(name) {
    this.sight = name;
    this.drawing.view(name);
    this.dirty = true;
  }

  /* Machines beside the driven one, in these colours. */
  showGhosts(colors) {
    if (colors.join() === this.colors?.join()) return;
    this.colors = colors;
    this.ghosts.flat().forEach((group) => this.drawing.base.remove(group));
    this.ghosts = colors.map((color) => this.drawing.machine(() => ({ color, transparent: true, opacity: 0.3, depthWrite: false, polygonOffset: true, polygonOffsetFactor: 4 })));
    this.ghosts.flat().forEach((mesh) => (mesh.castShadow = mesh.receiveShadow = false));
    this.errors.forEach((mark) => this.drawing.base.remove(mark));
    this.errors = colors.map((color) => this.mark(new THREE.SphereGeometry(0.03, 16, 12), color));
    this.dirty = true;
  }

  pose(groups, zeta) {
    const { world, strokes } = poses(this.data.tree, zeta);
    this.data.bodies.forEach(({ name }, k) => {
      groups[k].position.set(...world[name].r);
      groups[k].quaternion.set(...world[name].q);
    });
    return [...world.T4.r, ...strokes];
  }

  /* A frame's values: zeta, tip, strokes, forces, desired, contact, loadMass, tilt, and zeta of each ghost. */
  show({ zeta, tip, strokes, forces, desired, contact, loadMass, tilt, ghosts }) {
    const { drawing } = this;
    const drawn = this.pose(drawing.groups, zeta);
    for (const [line, carrier, at] of this.arcs) {
      const group = this.bodyPlace(carrier);
      line.quaternion.copy(group.quaternion);
      line.position.set(...at).applyQuaternion(group.quaternion).add(group.position);
    }
    const pressed = Math.hypot(...contact);
    this.point(this.contact, tip, contact, pressed > 1 ? Math.min(0.1 + pressed / CONTACT_SCALE, CONTACT_MOST) : 0);
    this.showForces(forces);
    // How far tip and rods are drawn from where the FMU has them, m: another machine would show.
    this.stage.dataset.drawingError = Math.hypot(...[...tip, ...strokes].map((v, k) => v - drawn[k]));
    drawing.tip.position.set(...tip);
    // The reference is drawn where it is; from there all errors are enlarged.
    const enlarged = (place) => desired.map((v, k) => v + this.gain * (place[k] - v));
    this.reference.position.set(...desired);
    this.shadow.position.set(desired[0], this.data.floor + 0.006, desired[2]);
    this.drop.position.set(desired[0], this.data.floor, desired[2]);
    this.drop.scale.y = Math.max(desired[1] - this.data.floor, 1e-3);
    this.error.position.set(...enlarged(tip));
    this.way.add(enlarged(tip));
    this.desiredWay.add(desired);
    this.load.visible = loadMass > 0;
    this.load.scale.setScalar(0.05 + 0.012 * Math.cbrt(loadMass));
    this.load.position.set(...tip);
    // Roll about x, then pitch about its own z.
    drawing.base.rotation.set(tilt[0], 0, tilt[1], "XYZ");
    ghosts.forEach((angles, k) => {
      if (this.ghosts[k] && angles.every(Number.isFinite)) this.errors[k].position.set(...enlarged(this.pose(this.ghosts[k], angles).slice(0, 3)));
    });
    this.dirty = true;
  }

  /* Texts at the actuators. */
  label(texts) {
    this.drawing.bodies.forEach(({ name }, k) => (this.drawing.labels[k].textContent = name in ROD_LABELS ? texts[ROD_LABELS[name]] : ""));
  }

  clear() {
    this.way.clear();
    this.desiredWay.clear();
  }

  setWaypoints(points) {
    this.waypoints.clear();
    points.forEach((point) => {
      const ball = new THREE.Mesh(new THREE.SphereGeometry(0.025, 16, 12), this.drawing.surface({ color: REFERENCE }));
      ball.position.set(...point);
      this.waypoints.add(ball);
    });
    this.dirty = true;
  }

  /* Where a ray, in the base's axes, meets a body first: its name and the point in its axes; none where it meets nothing. */
  hit(origin, ray) {
    let [nearest, found] = [Infinity, null];
    this.drawing.groups.forEach((mesh, k) => {
      const back = mesh.quaternion.clone().invert();
      const [o, d] = [origin.clone().sub(mesh.position).applyQuaternion(back), ray.clone().applyQuaternion(back)];
      const { array } = mesh.geometry.attributes.position;
      for (let i = 0; i < array.length; i += 9) {
        const [a, b, c] = [0, 3, 6].map((at) => new THREE.Vector3(array[i + at], array[i + at + 1], array[i + at + 2]));
        // Point of the triangle: a + u (b − a) + v (c − a) = o + t d.
        const [e, f, s] = [b.sub(a), c.sub(a), o.clone().sub(a)];
        const [p, q] = [d.clone().cross(f), s.clone().cross(e)];
        const [u, v, t] = [s.dot(p), d.dot(q), f.dot(q)].map((x) => x / e.dot(p));
        if (u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < nearest) {
          nearest = t;
          found = { name: this.data.bodies[k].name, point: o.clone().addScaledVector(d, t).toArray() };
        }
      }
    });
    return found;
  }

  /* Dragging a body or the tip pushes it; with `aiming` a click sets a waypoint in the boom's vertical plane, or with shift at the tip's height. */
  pointer() {
    const { canvas, drawing } = this;
    const rayOf = (event) => {
      const [x, y] = [(2 * event.offsetX) / canvas.clientWidth - 1, 1 - (2 * event.offsetY) / canvas.clientHeight];
      return new THREE.Vector3(x, y, 0.5).unproject(drawing.camera).sub(drawing.camera.position);
    };
    // Where the ray through the pointer meets the plane through a point, in the machine's world.
    const meet = (event, normal, through) => {
      const eye = drawing.camera.position;
      const ray = rayOf(event);
      const distance = normal.dot(through.clone().sub(eye)) / normal.dot(ray);
      return distance > 0 ? drawing.base.worldToLocal(eye.clone().addScaledVector(ray, distance)) : null;
    };
    const tip = () => drawing.tip.getWorldPosition(new THREE.Vector3());
    const near = (event) => {
      const p = tip().project(drawing.camera);
      const [x, y] = [(0.5 + 0.5 * p.x) * canvas.clientWidth, (0.5 - 0.5 * p.y) * canvas.clientHeight];
      return Math.hypot(x - event.offsetX, y - event.offsetY) < (event.pointerType === "touch" ? 34 : 18);
    };
    const grasped = (event) => {
      if (near(event)) return { name: "T4", point: [0, 0, 0] };
      const eye = drawing.base.worldToLocal(drawing.camera.position.clone());
      return this.hit(eye, drawing.base.worldToLocal(rayOf(event).add(drawing.camera.position)).sub(eye));
    };
    const stop = () => {
      if (!this.dragging) return;
      this.dragging = false;
      drawing.controls.enabled = true;
      this.push([0, 0, 0]);
    };
    // The force shows from what is held to the pointer, wherever the machine has moved meanwhile.
    this.pull = () => {
      const at = this.gripPlace();
      const goal = meet(this.pointed, drawing.camera.getWorldDirection(new THREE.Vector3()), drawing.base.localToWorld(at.clone()));
      if (goal) this.push(goal.sub(at).multiplyScalar(PUSH_STIFFNESS).clampLength(0, PUSH_MOST).toArray());
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (this.aiming) {
        const normal = event.shiftKey ? new THREE.Vector3(0, 1, 0) : new THREE.Vector3(0, 0, 1).applyQuaternion(drawing.groups[0].quaternion);
        const point = meet(event, normal, tip());
        if (point) this.clicked(point.toArray());
      } else if (event.isPrimary && event.button === 0 && (this.grip = grasped(event))) {
        Object.assign(this, { dragging: true, pointed: null });
        drawing.controls.enabled = false;
        canvas.setPointerCapture(event.pointerId);
      }
    }, true);
    canvas.addEventListener("pointermove", (event) => {
      if (!this.dragging) return;
      this.pointed = { offsetX: event.offsetX, offsetY: event.offsetY };
      this.pull();
    });
    canvas.addEventListener("pointerup", stop);
    canvas.addEventListener("pointercancel", stop);
  }

  push(force) {
    this.pulled = performance.now();
    this.pushed(force, this.grip);
  }

  /* Where what is held is, in the base's axes. */
  gripPlace() {
    const { name, point } = this.grip;
    return name === "T4" ? this.drawing.tip.position.clone() : new THREE.Vector3(...placeOf({ r: this.bodyPlace(name).position.toArray(), q: this.bodyPlace(name).quaternion.toArray() }, point));
  }

  /* Where pictures come slowly they have fewer points, down to half as many in a row, until nothing moves. */
  sharpen(now) {
    const took = now - this.ticked;
    this.ticked = now;
    // The time until the next tick tells what a picture costs.
    if (this.drew) this.pace += 0.05 * (Math.min(took, STILL) - this.pace);
    this.drew = this.dirty;
    if (!this.dirty) {
      this.dirty = now - this.drawn > STILL && this.drawing.sharpness(1);
      return;
    }
    this.drawn = now;
    const step = this.pace > SLOW ? -0.125 : this.pace < FAST ? 0.125 : 0;
    if (step && now - this.changed > STILL) [this.moving, this.changed] = [Math.min(Math.max(this.moving + step, 0.5), 1), now];
    this.drawing.sharpness(this.moving);
  }

  /* The picture as a PNG file, with all points of the screen. */
  async picture() {
    this.drawing.sharpness(1);
    this.drawing.render();
    return new Promise((kept) => this.canvas.toBlob(kept, "image/png"));
  }

  /* The picture of this time, ms, where something has changed. */
  draw(now, showLabels) {
    this.sharpen(now);
    if (!this.dirty) return;
    this.dirty = false;
    const { drawing } = this;
    if (this.dragging && this.pointed && performance.now() - this.pulled > PUSH_EVERY) this.pull();
    const force = this.arrowForce ?? [0, 0, 0];
    if (this.grip) this.point(this.arrow, this.gripPlace().toArray(), force, Math.hypot(...force) > 1 ? 0.1 + Math.hypot(...force) / PUSH_STIFFNESS : 0);
    drawing.render();
    drawing.placeLabels(showLabels);
    this.placeChart();
  }
}
