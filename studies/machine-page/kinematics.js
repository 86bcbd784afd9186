/*
 * Poses of the machine's bodies at its joint angles, for drawing: both closed loops solved in closed form, as crate `hdrm` does (`Tree`, whose
 * constants `tree` are). A pose is { r, q }: place in m and quaternion [x, y, z, w]. The page compares the tip with the FMU's.
 */
const PARENTS = { A2: "T1", C2: "T1", D2: "C2", A3: "A2", C3: "A2", RK: "A2", D3: "C3", CP: "A3", A4: "A3", C4: "A4", D4: "C4", PL: "D4" };

const unit = (angle) => [Math.cos(angle), Math.sin(angle)];
const minus = (a, b) => a.map((v, k) => v - b[k]);
/* `a` turned by the angle of the unit vector `e`, and back. */
const turned = ([x, y], [c, s]) => [c * x - s * y, s * x + c * y];
const relative = ([x, y], [c, s]) => [c * x + s * y, c * y - s * x];

/* The vector as length and direction. */
function polar(v) {
  const length = Math.hypot(...v);
  return { length, e: v.map((x) => x / length) };
}

/* Pins of the tilt mechanism in boom axes: D is where the circles of rocker and coupler meet, on the side away from the tilt joint. */
function fourBar({ A, E, C, d4, d5, side }, angle) {
  const pivot = turned(C, unit(angle));
  const [x, y] = minus(pivot, A);
  const squared = x * x + y * y;
  const along = 0.5 * (1 + (d4 * d4 - d5 * d5) / squared);
  const across = side * Math.sqrt(Math.max(d4 * d4 / squared - along * along, 0));
  const D = [A[0] + along * x + across * y, A[1] + along * y - across * x];
  return { rocker: polar(minus(D, A)).e, coupler: polar(minus(D, pivot)).e, actuator: polar(minus(D, E)) };
}

const about = (axis, r, angle) => {
  const q = [0, 0, 0, Math.cos(angle / 2)];
  q[axis] = Math.sin(angle / 2);
  return { r, q };
};
const aboutZ = (r, [c, s]) => about(2, r, Math.atan2(s, c));

/* Quaternion product, and a vector turned by a quaternion. */
export function product([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz];
}
export function rotated([x, y, z], q) {
  return product(product(q, [x, y, z, 0]), [-q[0], -q[1], -q[2], q[3]]).slice(0, 3);
}

/* Each body's pose in the world, by name, the tip as `T4`; and the strokes of slew, lift and tilt, m. */
export function poses(tree, zeta) {
  const { lift, tilt, e_boom: boom } = tree;
  const [slew, elevation, bend, roll, pitch, turn] = zeta;
  const elbow = unit(elevation - lift.beta2);
  const foot = [lift.foot[0], lift.foot[1]];
  const rod = polar(minus(elbow.map((v) => v * lift.L1), foot));
  const bar = fourBar(tilt, bend);
  const local = {
    T1: about(1, [0, 0, 0], slew),
    A2: aboutZ(tree.r_T1_O, elbow),
    C2: aboutZ([tree.r_T1_O[0] + foot[0], tree.r_T1_O[1] + foot[1], tree.r_T1_O[2]], rod.e),
    D2: about(2, [rod.length - lift.lc, 0, 0], 0),
    A3: aboutZ(tree.r_A2_B, turned(unit(bend), boom)),
    C3: aboutZ(tree.r_A2_E, turned(bar.actuator.e, boom)),
    D3: about(2, [bar.actuator.length - tilt.lc, 0, 0], 0),
    RK: aboutZ(tree.r_A2_A, turned(bar.rocker, boom)),
    CP: aboutZ([...tilt.C, 0], relative(bar.coupler, unit(bend))),
    A4: about(0, tree.r_A3_A4, roll),
    C4: about(2, tree.r_A4_C4, pitch),
    D4: about(0, tree.r_C4_D4, turn),
    PL: about(2, [0, 0, 0], 0),
    T4: about(2, tree.r_D4_T4, 0),
  };
  const world = {};
  for (const [name, { r, q }] of Object.entries(local)) {
    const parent = world[name === "T4" ? "D4" : PARENTS[name]];
    world[name] = parent ? { r: rotated(r, parent.q).map((v, k) => v + parent.r[k]), q: product(parent.q, q) } : { r, q };
  }
  return { world, strokes: [tree.x1_mid + tree.r_B * slew, rod.length - lift.x0, bar.actuator.length - tilt.x0] };
}

/* Where a point of a body is, m. */
export const placeOf = ({ r, q }, point) => rotated(point, q).map((v, k) => v + r[k]);

/* The vector x of A x = b, by elimination with the largest pivots. */
function solved(A, b) {
  const rows = A.map((row, k) => [...row, b[k]]);
  const n = rows.length;
  for (let k = 0; k < n; k += 1) {
    const best = rows.slice(k).reduce((most, row, i) => (Math.abs(row[k]) > Math.abs(rows[most][k]) ? k + i : most), k);
    [rows[k], rows[best]] = [rows[best], rows[k]];
    for (let i = 0; i < n; i += 1) {
      if (i === k) continue;
      const factor = rows[i][k] / rows[k][k];
      for (let j = k; j <= n; j += 1) rows[i][j] -= factor * rows[k][j];
    }
  }
  return rows.map((row, k) => row[n] / row[k]);
}

/* The wrench at the tip, in its axes, that acts on the joints as this force, N, at a point of a body does: both have the same power whatever
 * the machine's motion, J_tip' w = J_point' f. Columns of the Jacobians are central differences. */
export function wrenchAtTip(tree, zeta, name, point, force) {
  const step = 1e-5;
  const columns = zeta.map((_, k) => {
    const [a, b] = [step, -step].map((h) => poses(tree, zeta.map((angle, i) => (i === k ? angle + h : angle))).world);
    const rate = (from, to) => minus(to, from).map((v) => v / (2 * step));
    const turn = product(a.T4.q, [-b.T4.q[0], -b.T4.q[1], -b.T4.q[2], b.T4.q[3]]);
    const spin = turn.slice(0, 3).map((v) => (Math.sign(turn[3]) * v) / step);
    return { tip: [...rate(b.T4.r, a.T4.r), ...spin], point: rate(placeOf(b[name], point), placeOf(a[name], point)) };
  });
  const torques = columns.map((column) => column.point.reduce((sum, v, k) => sum + v * force[k], 0));
  const wrench = solved(columns.map(({ tip }) => tip), torques);
  const [x, y, z, w] = poses(tree, zeta).world.T4.q;
  return [wrench.slice(0, 3), wrench.slice(3)].flatMap((part) => rotated(part, [-x, -y, -z, w]));
}
