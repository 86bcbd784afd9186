//! Inverse dynamics by recursion over the tree of bodies (Newton–Euler), with its time derivative,
//! for the output derivatives and for a tilted or turning base.
//!
//! In this general form an outward pass gives twists and accelerations, an inward pass wrenches
//! (see [`crate::Tree`]). Forward dynamics use [`crate::dynamics::boom_frame`]; tests compare both.

use crate::dynamics::gravity::Gravity;
use crate::{BODIES, Body, Configuration, DOF, Tree};
use nalgebra::{Vector3, Vector6};
use spatial::{Inertia, Pose, Twist, Wrench};

/// A quantity and its time derivative.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WithRate<T> {
    pub value: T,
    pub rate: T,
}

/// Motion of the ground, in and about the world frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ground {
    pub V: Twist,
    /// Rate of V.
    pub A: Twist,
    /// Rate of A.
    pub A_dot: Twist,
}

/// Motion of one body in its own axes.
#[derive(Clone, Copy, Debug, Default)]
struct BodyMotion {
    V: Twist,
    /// Rate of V.
    A: Twist,
    /// Rate of A for `zeta_dddot = 0`.
    A_dot: Twist,
    /// Direction opposite to gravity.
    up: Vector3<f64>,
}

/// Generalised forces `M·zeta_ddot + h` (friction left out) and their time derivative for
/// `zeta_dddot = 0`.
///
/// Per body, with `A^ = A + g·up` (acceleration minus gravity) and `up_dot = −w × up`:
/// ```text
/// F*     = M A^ + crf(V) M V
/// F*_dot = M A^_dot + crf(A) M V + crf(V) M A
/// ```
pub(crate) fn inverse_dynamics(
    configuration: &Configuration,
    bodies: &[Inertia; Body::COUNT],
    zeta_dot: &[f64; DOF],
    zeta_ddot: &[f64; DOF],
    gravity: &Gravity,
) -> WithRate<Vector6<f64>> {
    let rest = Ground::default();
    let motions = outward(configuration, zeta_dot, zeta_ddot, Vector3::y(), &rest);
    let g = gravity.along_y;
    let wrenches = std::array::from_fn(|k| {
        let BodyMotion { V, A, A_dot, up } = motions[k];
        let M = &bodies[k];
        let gravity = Twist::new(up * g, Vector3::zeros());
        let gravity_dot = Twist::new(up.cross(&V.w) * g, Vector3::zeros());
        WithRate {
            value: M.net_wrench(&V, &(A + gravity)),
            rate: M.apply(&(A_dot + gravity_dot)) + A.crf(&M.apply(&V)) + V.crf(&M.apply(&A)),
        }
    });
    let (mut Q, _) = inward(configuration, zeta_dot, wrenches);
    if let Some(up) = gravity.sideways() {
        let sideways = holding_forces(configuration, bodies, zeta_dot, up, 1.0);
        Q.value += sideways.value;
        Q.rate += sideways.rate;
    }
    Q
}

/// The same without gravity on a moving ground, and the ground's wrench in the world frame.
pub(crate) fn inertial_forces(
    configuration: &Configuration,
    bodies: &[Inertia; Body::COUNT],
    zeta_dot: &[f64; DOF],
    zeta_ddot: &[f64; DOF],
    ground: &Ground,
) -> (WithRate<Vector6<f64>>, Wrench) {
    let motions = outward(configuration, zeta_dot, zeta_ddot, Vector3::zeros(), ground);
    let wrenches = std::array::from_fn(|k| {
        let BodyMotion { V, A, A_dot, .. } = motions[k];
        let M = &bodies[k];
        WithRate {
            value: M.net_wrench(&V, &A),
            rate: M.apply(&A_dot) + A.crf(&M.apply(&V)) + V.crf(&M.apply(&A)),
        }
    });
    inward(configuration, zeta_dot, wrenches)
}

/// Generalised forces that hold the machine at rest against gravity, and their time derivative
/// while the pose changes with `zeta_dot`.
pub(crate) fn gravity_forces(
    configuration: &Configuration,
    bodies: &[Inertia; Body::COUNT],
    zeta_dot: &[f64; DOF],
    gravity: &Gravity,
) -> WithRate<Vector6<f64>> {
    let against = |up, g| holding_forces(configuration, bodies, zeta_dot, up, g);
    let mut Q = against(Vector3::y(), gravity.along_y);
    if let Some(up) = gravity.sideways() {
        let sideways = against(up, 1.0);
        Q.value += sideways.value;
        Q.rate += sideways.rate;
    }
    Q
}

/// The same for a gravity vector −`g`·`up`, m/s².
pub(crate) fn holding_forces(
    configuration: &Configuration,
    bodies: &[Inertia; Body::COUNT],
    zeta_dot: &[f64; DOF],
    up: Vector3<f64>,
    g: f64,
) -> WithRate<Vector6<f64>> {
    let rest = Ground::default();
    let motions = outward(configuration, zeta_dot, &[0.0; DOF], up, &rest);
    let wrenches = std::array::from_fn(|k| {
        let BodyMotion { V, up, .. } = motions[k];
        let weight = |up: Vector3<f64>| bodies[k].apply(&Twist::new(up * g, Vector3::zeros()));
        WithRate {
            value: weight(up),
            rate: weight(up.cross(&V.w)),
        }
    });
    inward(configuration, zeta_dot, wrenches).0
}

/// Generalised forces `J_T4ᵀ W` of a constant wrench W on the end-effector, at T4 in T4 axes, and
/// their time derivative.
pub(crate) fn tip_forces(
    configuration: &Configuration,
    tree: &Tree,
    zeta_dot: &[f64; DOF],
    W: &Wrench,
) -> WithRate<Vector6<f64>> {
    let mut wrenches = [WithRate::default(); Body::COUNT];
    wrenches[Body::D4 as usize].value = Pose::translation(tree.r_D4_T4).wrench_to_A(W);
    inward(configuration, zeta_dot, wrenches).0
}

/// Motions of all bodies:
/// ```text
/// V     = X V_p + s q_dot
/// A     = X A_p + s q_ddot + crm(V) s q_dot
/// A_dot = X A_p_dot − crm(s q_dot) X A_p + s q_dddot + crm(A) s q_dot + crm(V) s q_ddot
/// ```
/// with `q_dot = g w`, `q_ddot = g a + g′w²`, `q_dddot = 3g′w a + g″w³` for `w = zeta_c_dot`,
/// `a = zeta_c_ddot`.
fn outward(
    configuration: &Configuration,
    zeta_dot: &[f64; DOF],
    zeta_ddot: &[f64; DOF],
    up: Vector3<f64>,
    &Ground { V, A, A_dot }: &Ground,
) -> [BodyMotion; Body::COUNT] {
    let ground = BodyMotion { V, A, A_dot, up };
    let mut motions = [ground; Body::COUNT];
    for body in BODIES {
        let parent = body.parent().map_or(ground, |p| motions[p as usize]);
        let link = configuration.link(body);
        let (w, a) = (zeta_dot[body.coordinate()], zeta_ddot[body.coordinate()]);
        let s = body.axis();
        let s_dot = s * (link.gear * w);
        let s_ddot = s * (link.gear * a + link.gear_prime * w * w);
        let s_dddot = s * (3.0 * link.gear_prime * w * a + link.gear_second * w * w * w);

        let X = &link.pose;
        let V = X.twist_to_B(&parent.V) + s_dot;
        let X_A = X.twist_to_B(&parent.A);
        let A = X_A + s_ddot + V.crm(&s_dot);
        motions[body as usize] = BodyMotion {
            V,
            A,
            A_dot: X.twist_to_B(&parent.A_dot) - s_dot.crm(&X_A)
                + s_dddot
                + A.crm(&s_dot)
                + V.crm(&s_ddot),
            up: X.R.tr_mul(&parent.up),
        };
    }
    motions
}

/// Accumulates the wrenches towards the ground and projects them on the joints:
/// `Q_i = Σ g_k s_kᵀ F_k`, `F_p += U F`, `d/dt (U F) = U (F_dot + crf(s q_dot) F)`. Also returns
/// the wrench on the ground.
fn inward(
    configuration: &Configuration,
    zeta_dot: &[f64; DOF],
    mut wrenches: [WithRate<Wrench>; Body::COUNT],
) -> (WithRate<Vector6<f64>>, Wrench) {
    let mut Q = WithRate::<Vector6<f64>>::default();
    let mut ground = Wrench::zero();
    for body in BODIES.into_iter().rev() {
        let WithRate {
            value: F,
            rate: F_dot,
        } = wrenches[body as usize];
        let link = configuration.link(body);
        let (i, s) = (body.coordinate(), body.axis());
        Q.value[i] += link.gear * s.power(&F);
        Q.rate[i] += link.gear * s.power(&F_dot) + link.gear_prime * zeta_dot[i] * s.power(&F);
        let Some(parent) = body.parent() else {
            ground += link.pose.wrench_to_A(&F);
            continue;
        };
        let s_dot = s * (link.gear * zeta_dot[i]);
        let parent = &mut wrenches[parent as usize];
        parent.value += link.pose.wrench_to_A(&F);
        parent.rate += link.pose.wrench_to_A(&(F_dot + s_dot.crf(&F)));
    }
    (Q, ground)
}
