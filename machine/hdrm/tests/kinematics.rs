//! Kinematics against geometry stated another way: closed loops, the paper's printed formulas,
//! and finite differences of the next lower derivative.
use crate::paper_angles::{gamma, lift_angles, tilt_angles};
use hdrm::{BODIES, Body, Configuration, DOF, GeometryError, Tip, Tree};
use machine_file::Machine;
use nalgebra::{Vector3, Vector6};

/// Reference machine and random poses within its joint limits, all seeded.
fn samples(n: usize) -> (Machine, Tree, Vec<[f64; DOF]>) {
    let machine = Machine::reference();
    let tree = Tree::new(&machine).expect("valid reference");
    let mut seed = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = move || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let limits = machine.limits.zeta();
    let poses = (0..n)
        .map(|_| limits.map(|[min, max]| min + (max - min) * random()))
        .collect();
    (machine, tree, poses)
}

fn moved(zeta: &[f64; DOF], i: usize, by: f64) -> [f64; DOF] {
    let mut zeta = *zeta;
    zeta[i] += by;
    zeta
}

/// Both rods end on their pins, rocker and coupler meet the tilt rod in D.
#[test]
fn loops_close() {
    let (machine, tree, poses) = samples(200);
    let g = &machine.geometry;
    for zeta in poses {
        let world = tree.configuration(&zeta).world_poses();
        let at = |body: Body, x: f64, y: f64| {
            let X = world[body as usize];
            X.r + X.R * Vector3::new(x, y, 0.0)
        };
        let [C_x, C_y] = g.C_in_tilt;
        for (what, gap) in [
            (
                "lift pin",
                at(Body::D2, g.lc_2, 0.0) - at(Body::A2, g.L1_2, 0.0),
            ),
            (
                "rocker–rod",
                at(Body::D3, g.lc_3, 0.0) - at(Body::RK, g.d4, 0.0),
            ),
            (
                "coupler–rod",
                at(Body::D3, g.lc_3, 0.0) - at(Body::CP, g.d5, 0.0),
            ),
            (
                "coupler–boom",
                at(Body::CP, 0.0, 0.0) - at(Body::A3, C_x, C_y),
            ),
        ] {
            // Lengths of some 4 m, a dozen rounded operations.
            assert!(gap.norm() < 1e-14, "{what}: {gap} at {zeta:?}");
        }
    }
}

/// The paper's printed arccos formulas, [Eq:3_Bar_3] and [Eq:4_Bar_1] to [Eq:4_Bar_6].
#[test]
fn auxiliary_angles_equal_the_printed_formulas() {
    let (machine, tree, poses) = samples(200);
    let g = &machine.geometry;
    let three_bar = |L1: f64, L2: f64, q: f64| {
        let c = (L1 * L1 + L2 * L2 + 2.0 * L1 * L2 * q.cos()).sqrt();
        let q1 = -((L1 * L1 - c * c - L2 * L2) / (-2.0 * c * L2)).acos();
        let q2 = -((L2 * L2 - c * c - L1 * L1) / (-2.0 * c * L1)).acos();
        (c, q1, q2)
    };
    for zeta in poses {
        let close = |what: &str, a: f64, b: f64| {
            // acos loses digits near 0 and π: √ε-like only at the very ends, 1e-10 here.
            assert!((a - b).abs() < 1e-10, "{what}: {a} vs {b} at {zeta:?}");
        };
        let strokes = tree.configuration(&zeta).strokes;
        let lift = lift_angles(&tree.lift, zeta[1]);
        let (c, q1, q2) = three_bar(g.L1_2, g.L2_2, lift.q);
        let q = zeta[1] - std::f64::consts::FRAC_PI_2 - g.beta1 - g.beta2;
        for (what, a, b) in [
            ("q_2", lift.q, q),
            ("c_2", lift.c, c),
            ("q_1_2", lift.q1, q1),
            ("q_2_2", lift.q2, q2),
            ("x_2", strokes[1].x, c - g.x0_2),
        ] {
            close(what, a, b);
        }

        let tilt = tilt_angles(&tree.tilt, zeta[2]);
        let (gamma_1, gamma_7) = gamma(&tree.tilt);
        let (d1, d2, d4, d5) = (tree.tilt.A.norm(), tree.tilt.C.norm(), g.d4, g.d5);
        let gamma_2 = gamma_1 + std::f64::consts::PI + zeta[2];
        let d3 = (d1 * d1 + d2 * d2 - 2.0 * d1 * d2 * gamma_2.cos()).sqrt();
        let gamma_3 = (d2 * gamma_2.sin()).atan2(d1 - d2 * gamma_2.cos());
        let gamma_4 = ((d3 * d3 + d4 * d4 - d5 * d5) / (2.0 * d3 * d4)).acos();
        let gamma_5 = gamma_3 + gamma_4;
        let L1 = (d1 * d1 + d4 * d4 - 2.0 * d1 * d4 * gamma_5.cos()).sqrt();
        let gamma_6 = ((d2 * d2 + L1 * L1 - d5 * d5) / (2.0 * d2 * L1)).acos();
        let (c, q1, q2) = three_bar(L1, tilt.L2, tilt.q);
        for (what, a, b) in [
            ("L_1_3", tilt.L1, L1),
            ("q_3", tilt.q, zeta[2] - gamma_6 - gamma_7),
            ("c_3", tilt.c, c),
            ("q_1_3", tilt.q1, q1),
            ("q_2_3", tilt.q2, q2),
            ("x_3", strokes[2].x, c - g.x0_3),
        ] {
            close(what, a, b);
        }
    }
}

/// Every gear, its derivatives, x′, x″ and the relative twists of the links against central
/// differences of poses and of the next lower derivative. h = 1e-5: truncation h²·|f‴| and
/// rounding ε/h are both some 1e-10; 1e-7 leaves room for the derivatives' size (up to some 100).
#[test]
fn derivatives_are_exact() {
    let (_, tree, poses) = samples(100);
    let h = 1e-5;
    for zeta in poses {
        let now = tree.configuration(&zeta);
        for body in BODIES {
            let i = body.coordinate();
            let [a, b] = [-h, h].map(|d| tree.configuration(&moved(&zeta, i, d)));
            let of = |c: &Configuration| *c.link(body);
            let (a_k, b_k, link) = (of(&a), of(&b), of(&now));
            let slope = |x: f64, y: f64| (y - x) / (2.0 * h);
            // Relative twist in the body's axes: [Rᵀ r′; vee(Rᵀ R′)] = s_k g_k
            let R_dot = (b_k.pose.R - a_k.pose.R) / (2.0 * h);
            let W = link.pose.R.transpose() * R_dot;
            let v = link.pose.R.transpose() * (b_k.pose.r - a_k.pose.r) / (2.0 * h);
            let twist = Vector6::new(v.x, v.y, v.z, W[(2, 1)], W[(0, 2)], W[(1, 0)]);
            let expected = (body.axis() * link.gear).to_vector();
            for (what, error) in [
                ("pose", (twist - expected).norm()),
                ("g′", link.gear_prime - slope(a_k.gear, b_k.gear)),
                (
                    "g″",
                    link.gear_second - slope(a_k.gear_prime, b_k.gear_prime),
                ),
            ] {
                assert!(error.abs() < 1e-7, "{body:?} {what}: {error:e} at {zeta:?}");
            }
        }
        for i in 0..3 {
            let [a, b] = [-h, h].map(|d| tree.configuration(&moved(&zeta, i, d)).strokes[i]);
            let s = now.strokes[i];
            assert!((s.prime - (b.x - a.x) / (2.0 * h)).abs() < 1e-8, "x_{i}′");
            assert!(
                (s.second - (b.prime - a.prime) / (2.0 * h)).abs() < 1e-7,
                "x_{i}″"
            );
        }
        let [a, b] = [-h, h].map(|d| tilt_angles(&tree.tilt, zeta[2] + d).q);
        assert!((tilt_angles(&tree.tilt, zeta[2]).q_prime - (b - a) / (2.0 * h)).abs() < 1e-8);
    }
}

/// J against central differences of position and orientation, J_dot against those of J.
#[test]
fn tip_jacobian_and_its_rate_are_exact() {
    let (_, tree, poses) = samples(100);
    let h = 1e-5;
    let tip = |zeta: &[f64; DOF]| Tip::new(&tree, &tree.configuration(zeta));
    for (k, zeta) in poses.iter().enumerate() {
        let zeta_dot: [f64; DOF] = std::array::from_fn(|i| ((k + 3 * i) as f64).sin());
        let at = |s: f64| -> [f64; DOF] { std::array::from_fn(|i| zeta[i] + s * zeta_dot[i]) };
        let (a, b, now) = (tip(&at(-h)), tip(&at(h)), tip(zeta));

        let V = now.jacobian() * Vector6::from(zeta_dot);
        let v = (b.position - a.position) / (2.0 * h);
        // w = 2·q_dot·q*
        let q_dot = (Tip::orientation(&at(h)) - Tip::orientation(&at(-h))) / (2.0 * h);
        let w = (q_dot * Tip::orientation(zeta).conjugate()).imag() * 2.0;
        let numeric = Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z);
        assert!((V - numeric).norm() < 1e-8, "{V} vs {numeric} at {zeta:?}");

        let J_dot = (b.jacobian() - a.jacobian()) / (2.0 * h);
        assert!(
            (now.jacobian_dot(&zeta_dot) - J_dot).norm() < 1e-8,
            "J_dot at {zeta:?}"
        );
    }
}

/// An independent prototype of the same machine has its tip at (3.088, 1.014, 0) m at start.
#[test]
fn tip_at_start() {
    let (machine, tree, _) = samples(0);
    let tip = Tip::new(&tree, &tree.configuration(&machine.start.zeta));
    let expected = Vector3::new(3.088, 1.014, 0.0);
    assert!((tip.position - expected).amax() < 5e-4, "{}", tip.position);
}

/// A joint range is refused where an actuator's lever vanishes or the four-bar opens less than 0.05
/// rad beyond its limits, and taken where that happens further out. Where it happens is found by
/// turning the joint by hand from the middle of the range on, in steps of 0.2 mrad.
#[test]
fn loops_must_work_some_way_beyond_the_limits() {
    let (machine, tree, _) = samples(0);
    let limits = machine.limits.zeta();
    let middle = limits.map(|[min, max]| 0.5 * (min + max));
    for joint in [1, 2] {
        for (side, limit) in [(-1.0, 0), (1.0, 1)] {
            let lever = |by: f64| {
                let zeta = moved(&middle, joint, side * by);
                tree.configuration(&zeta).strokes[joint].prime
            };
            let mut steps = (0..20_000).map(|k| 2e-4 * f64::from(k));
            let dead = steps.find(|by| lever(*by) <= 0.0);
            let dead = middle[joint] + side * dead.expect("no loop turns all around");
            for (before, taken) in [(0.04, false), (0.06, true)] {
                let mut narrow = machine.clone();
                let opposite = &mut narrow.limits;
                let ends = [&mut opposite.zeta_min_deg, &mut opposite.zeta_max_deg];
                ends[limit][joint] = (dead - side * before).to_degrees();
                let found = Tree::new(&narrow);
                let refused = matches!(
                    found,
                    Err(GeometryError::DeadPoint { .. } | GeometryError::FourBarOpen { .. })
                );
                assert_eq!(
                    refused, !taken,
                    "joint {joint}, side {side}, {before} rad before {dead}"
                );
            }
        }
    }
}
