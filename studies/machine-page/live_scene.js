/*
 * The live machine in three dimensions, on top of `MachineDrawing`: ghosts under other laws, the reference with its shadow on the ground, the
 * way of the tip, forces at the rods, what hangs at the tip, the push that one drags, waypoints.
 */
import { poses } from "./kinematics.js";

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
    const drawing = (this.drawing = new MachineDrawing(this.canvas, data.bodies, { plain: drawsInSoftware() }));
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
    // A cone one metre long, whose point is the tip: scaled it shows the push.
    this.arrow = this.mark(new THREE.CylinderGeometry(0.05, 0.005, 1, 16).translate(0, 0.5, 0), "#ff3b30");
    this.arrow.visible = false;
    this.contact = this.mark(new THREE.CylinderGeometry(0.005, 0.05, 1, 16).translate(0, 0.5, 0), CONTACT);
    this.contact.visible = false;
    this.limits();
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

  /* Somebody 1.8 m tall, for scale, outside the machine's reach to the front. */
  person() {
    const part = (geometry, y) => geometry.translate(0, y, 0);
    const parts = [part(new THREE.CylinderGeometry(0.21, 0.15, 0.72, 16), 1.14), part(new THREE.SphereGeometry(0.12, 16, 12), 1.68),
      ...[-0.1, 0.1].map((z) => part(new THREE.CylinderGeometry(0.08, 0.07, 0.8, 12).translate(0, 0, z), 0.4))];
    const person = new THREE.Mesh(MachineDrawing.merged(parts), this.drawing.surface({ color: "#6d7f8f" }));
    person.position.set(-0.9, 0, -0.4);
    person.castShadow = true;
    this.drawing.scene.add(person);
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

  /* Ranges of slew, lift and tilt as arcs about their joints; the last two turn with what carries them. */
  limits() {
    const { tree, joints } = this.data;
    const arc = ([least, most], radius, place) => {
      const line = this.drawing.line(LIMIT, 0.7);
      line.material.depthTest = true;
      const points = Array.from({ length: 41 }, (_, k) => place(least + (k / 40) * (most - least), k === 0 || k === 40 ? 0.8 * radius : radius));
      MachineDrawing.setPoints(line, [0, 1, 2].map((i) => points.map((point) => point[i])));
      return line;
    };
    const along = (offset) => (angle, radius) => [radius * Math.cos(angle + offset), radius * Math.sin(angle + offset), 0];
    arc(joints[0], 1, (angle, radius) => [radius * Math.cos(angle), 0.01, -radius * Math.sin(angle)]);
    const boom = Math.atan2(tree.e_boom[1], tree.e_boom[0]);
    const elbow = Math.atan2(tree.r_A2_B[1], tree.r_A2_B[0]);
    this.arcs = [[arc(joints[1], 0.5, along(elbow - tree.lift.beta2)), "T1", tree.r_T1_O], [arc(joints[2], 0.4, along(boom)), "A2", tree.r_A2_B]];
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
      return { height: groups[k].position.y + low, title };
    });
    if (this.load.visible) heights.push({ height: this.load.position.y - this.load.scale.y, title: "load" });
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

  /* A frame's values: zeta, tip, strokes, desired, contact, loadMass, tilt, and zeta of each ghost. */
  show({ zeta, tip, strokes, desired, contact, loadMass, tilt, ghosts }) {
    const { drawing } = this;
    const drawn = this.pose(drawing.groups, zeta);
    for (const [line, carrier, at] of this.arcs) {
      const group = drawing.groups[this.data.bodies.findIndex(({ name }) => name === carrier)];
      line.quaternion.copy(group.quaternion);
      line.position.set(...at).applyQuaternion(group.quaternion).add(group.position);
    }
    const force = new THREE.Vector3(...contact);
    this.contact.visible = force.length() > 1;
    if (this.contact.visible) {
      this.contact.position.set(...tip);
      this.contact.scale.y = Math.min(0.1 + force.length() / CONTACT_SCALE, CONTACT_MOST);
      this.contact.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), force.normalize());
    }
    // How far tip and rods are drawn from where the FMU has them, m: another machine would show.
    this.stage.dataset.drawingError = Math.hypot(...[...tip, ...strokes].map((v, k) => v - drawn[k]));
    drawing.tip.position.set(...tip);
    // The reference is drawn where it is; from there all errors are enlarged.
    const enlarged = (place) => desired.map((v, k) => v + this.gain * (place[k] - v));
    this.reference.position.set(...desired);
    this.shadow.position.set(desired[0], 0.006, desired[2]);
    this.drop.position.set(desired[0], 0, desired[2]);
    this.drop.scale.y = Math.max(desired[1], 1e-3);
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

  /* Dragging the tip pushes it; with `aiming` a click sets a waypoint in the boom's vertical plane, or with shift at the tip's height. */
  pointer() {
    const { canvas, drawing } = this;
    // Where the ray through the pointer meets the plane through a point, in the machine's world.
    const meet = (event, normal, through) => {
      const eye = drawing.camera.position;
      const [x, y] = [(2 * event.offsetX) / canvas.clientWidth - 1, 1 - (2 * event.offsetY) / canvas.clientHeight];
      const ray = new THREE.Vector3(x, y, 0.5).unproject(drawing.camera).sub(eye);
      const distance = normal.dot(through.clone().sub(eye)) / normal.dot(ray);
      return distance > 0 ? drawing.base.worldToLocal(eye.clone().addScaledVector(ray, distance)) : null;
    };
    const tip = () => drawing.tip.getWorldPosition(new THREE.Vector3());
    const near = (event) => {
      const p = tip().project(drawing.camera);
      const [x, y] = [(0.5 + 0.5 * p.x) * canvas.clientWidth, (0.5 - 0.5 * p.y) * canvas.clientHeight];
      return Math.hypot(x - event.offsetX, y - event.offsetY) < (event.pointerType === "touch" ? 34 : 18);
    };
    const stop = () => {
      if (!this.dragging) return;
      this.dragging = false;
      drawing.controls.enabled = true;
      this.push([0, 0, 0]);
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (this.aiming) {
        const normal = event.shiftKey ? new THREE.Vector3(0, 1, 0) : new THREE.Vector3(0, 0, 1).applyQuaternion(drawing.groups[0].quaternion);
        const point = meet(event, normal, tip());
        if (point) this.clicked(point.toArray());
      } else if (near(event)) {
        this.dragging = true;
        drawing.controls.enabled = false;
        canvas.setPointerCapture(event.pointerId);
      }
    }, true);
    canvas.addEventListener("pointermove", (event) => {
      if (!this.dragging) return;
      const point = meet(event, drawing.camera.getWorldDirection(new THREE.Vector3()), tip());
      if (point) this.push(point.sub(drawing.tip.position).multiplyScalar(PUSH_STIFFNESS).clampLength(0, PUSH_MOST).toArray());
    });
    canvas.addEventListener("pointerup", stop);
    canvas.addEventListener("pointercancel", stop);
  }

  push(force) {
    this.arrowForce = force;
    this.pushed(force);
    this.dirty = true;
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
    const force = new THREE.Vector3(...(this.arrowForce ?? [0, 0, 0]));
    this.arrow.visible = force.length() > 1;
    if (this.arrow.visible) {
      this.arrow.position.copy(drawing.tip.position);
      this.arrow.scale.y = 0.1 + force.length() / PUSH_STIFFNESS;
      this.arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), force.normalize());
    }
    drawing.render();
    drawing.placeLabels(showLabels);
  }
}
