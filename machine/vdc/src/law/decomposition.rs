//! Virtual decomposition, for the control laws and `controller`: required twists and wrenches of
//! all bodies, and the joint forces that follow from them ([Eq:Base_Required_Kinematics] to
//! [Eq:Actuator_Base_Required_Dynamics2]).
//!
//! The bodies form a tree of geared joints (`hdrm`), so the paper's equations per object become
//! one recursion up the tree for the twists and one down for the wrenches. Projected on the joints
//! it gives the corrected actuator forces (see `docs/machine/departures.md`).

use crate::bodies::{Estimate, HookModel};
use crate::signals::Input;
use crate::tracking::RequiredMotion;
use hdrm::{BODIES, Body, Configuration, DOF, felt_gravity};
use nalgebra::{Vector3, Vector6};
use spatial::{Inertia, Twist, Wrench};

/// Motion of one body, in and about its own frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BodyMotion {
    pub(crate) V: Twist,
    pub(crate) V_r: Twist,
    /// `w = V_r' + V × V_r − a_g`, the twist that the inertia multiplies.
    pub(crate) w: Twist,
}

impl BodyMotion {
    /// `s = V_r − V`.
    pub(crate) fn s(&self) -> Twist {
        self.V_r - self.V
    }
}

/// Motion of the ground according to `input`: at rest with `gravity` along −y, m/s², or tilted,
/// accelerating and rotating.
pub(crate) fn ground(gravity: f64, input: &Input) -> BodyMotion {
    let turn = |w: [f64; 3]| Twist::new(Vector3::zeros(), w.into());
    let V = turn(input.base_angular_velocity);
    let up = match (input.base_tilt, input.base_acceleration) {
        ([0.0, 0.0], [0.0, 0.0, 0.0]) => Vector3::y() * gravity,
        (tilt, acceleration) => {
            -Vector3::from(felt_gravity([0.0, -gravity, 0.0], tilt, acceleration))
        }
    };
    BodyMotion {
        V,
        V_r: V,
        w: Twist::new(up, input.base_angular_acceleration.into()),
    }
}

/// Motions of all bodies.
/// ```text
/// V_k   = X V_p   + s_k g_k ζ̇
/// V_r,k = X V_r,p + s_k g_k ζ̇_r
/// w_k   = X w_p   + s_k (g_k ζ̈_r + g_k' ζ̇ ζ̇_r) + V_k × s_k g_k ζ̇_r
/// ```
/// Frame derivatives use the actual rates, which makes the Coriolis form skew against V.
pub(crate) fn motions(
    configuration: &Configuration,
    zeta_dot: &[f64; DOF],
    required: &RequiredMotion,
    ground: &BodyMotion,
) -> [BodyMotion; Body::COUNT] {
    let mut motions = [BodyMotion::default(); Body::COUNT];
    for body in BODIES {
        let parent = body.parent().map_or(ground, |p| &motions[p as usize]);
        let link = configuration.link(body);
        let (axis, i) = (body.axis(), body.coordinate());
        let (rate, rate_r) = (zeta_dot[i], required.zeta_dot[i]);
        let V = link.pose.twist_to_B(&parent.V) + axis * (link.gear * rate);
        let joint_r = axis * (link.gear * rate_r);
        let drive = link.gear * required.zeta_ddot[i] + link.gear_prime * rate * rate_r;
        motions[body as usize] = BodyMotion {
            V,
            V_r: link.pose.twist_to_B(&parent.V_r) + joint_r,
            w: link.pose.twist_to_B(&parent.w) + axis * drive + V.crm(&joint_r),
        };
    }
    motions
}

/// Generalised forces on the six joints, N·m, that hold bodies with these estimates at rest.
pub(crate) fn holding_forces(
    configuration: &Configuration,
    estimates: &[Estimate; Body::COUNT],
    ground: &BodyMotion,
) -> [f64; DOF] {
    let motions = motions(configuration, &[0.0; DOF], &at_rest(), ground);
    let no_errors = VelocityErrors {
        momenta: [Wrench::zero(); Body::COUNT],
        energy: 0.0,
    };
    joint_forces(configuration, &motions, estimates, &no_errors, 0.0)
}

/// Momenta and energy of the errors `s = V_r − V` with the nominal inertias M.
pub(crate) struct VelocityErrors {
    /// `M s` of each body.
    momenta: [Wrench; Body::COUNT],
    /// Σ ½ sᵀ M s, J.
    pub(crate) energy: f64,
}

/// Momenta and energy of the velocity errors.
pub(crate) fn velocity_errors(
    motions: &[BodyMotion; Body::COUNT],
    nominal: &[Inertia; Body::COUNT],
) -> VelocityErrors {
    let mut energy = 0.0;
    let momenta = std::array::from_fn(|k| {
        let s = motions[k].s();
        let momentum = nominal[k].apply(&s);
        energy += 0.5 * s.power(&momentum);
        momentum
    });
    VelocityErrors { momenta, energy }
}

/// Generalised forces on the six joints, N·m, that the required wrenches
/// `F*_r = Y·θ̂ + K_A·(V_r − V)` ([Eq:Required_Force]) add up to; `K_A = kappa·M_nominal`.
pub(crate) fn joint_forces(
    configuration: &Configuration,
    motions: &[BodyMotion; Body::COUNT],
    estimates: &[Estimate; Body::COUNT],
    errors: &VelocityErrors,
    kappa: f64,
) -> [f64; DOF] {
    projected(configuration, |body, passed_on| {
        let k = body as usize;
        passed_on
            + required_net_wrench(&motions[k], estimates[k].inertia())
            + errors.momenta[k] * kappa
    })
}

/// Feedback over κ on the six joints, `√S M √S s` in N·m·s, with the nominal inertias M, for errors
/// `s` of the joint rates, rad/s, of which `shares` S count; None where each is 1. It takes energy
/// out at any shares.
pub(crate) fn shared_momentum(
    configuration: &Configuration,
    nominal: &[Inertia; Body::COUNT],
    s: &[f64; DOF],
    shares: &[f64; DOF],
) -> Option<[f64; DOF]> {
    if *shares == [1.0; DOF] {
        return None;
    }
    let mut scaled = at_rest();
    scaled.zeta_ddot = Vector6::from_fn(|i, _| shares[i].sqrt() * s[i]);
    let turning = motions(configuration, &[0.0; DOF], &scaled, &BodyMotion::default());
    let momentum = moments(configuration, &turning, |body| {
        Some(&nominal[body as usize])
    });
    Some(std::array::from_fn(|i| shares[i].sqrt() * momentum[i]))
}

/// What is expected to be felt of the hook with this `payload`.
pub(crate) fn hook_model(
    configuration: &Configuration,
    nominal: &[Inertia; Body::COUNT],
    payload: &Inertia,
    ground: &BodyMotion,
    gravity: f64,
) -> HookModel {
    let resting = motions(configuration, &[0.0; DOF], &at_rest(), ground);
    let of_payload = |body| (body == Body::PL).then_some(payload);
    let inertia = inertia_about(configuration, 4, of_payload);
    HookModel {
        own: [3, 4, 5].map(|joint| own_inertia(configuration, nominal, joint)),
        payload: inertia,
        weight: gravity * (payload.m * inertia).sqrt(),
        own_moments: moments(configuration, &resting, |body| {
            (body != Body::PL).then_some(&nominal[body as usize])
        }),
        payload_moments: moments(configuration, &resting, of_payload),
    }
}

/// Inertia of the machine's own bodies about a wrist joint, without what the end-effector carries.
pub(crate) fn own_inertia(
    configuration: &Configuration,
    nominal: &[Inertia; Body::COUNT],
    joint: usize,
) -> f64 {
    inertia_about(configuration, joint, |body| {
        (body != Body::PL).then_some(&nominal[body as usize])
    })
}

/// Inertia of all bodies about a joint.
pub(crate) fn whole_inertia(
    configuration: &Configuration,
    nominal: &[Inertia; Body::COUNT],
    joint: usize,
) -> f64 {
    inertia_about(configuration, joint, |body| Some(&nominal[body as usize]))
}

/// Inertia about a joint of the bodies for which `inertia` gives one.
fn inertia_about<'a>(
    configuration: &Configuration,
    joint: usize,
    inertia: impl Fn(Body) -> Option<&'a Inertia>,
) -> f64 {
    let mut required = at_rest();
    required.zeta_ddot[joint] = 1.0;
    let ground = BodyMotion::default();
    let turning = motions(configuration, &[0.0; DOF], &required, &ground);
    moments(configuration, &turning, inertia)[joint]
}

/// Generalised forces, N·m, for these motions of the bodies for which `inertia` gives one.
fn moments<'a>(
    configuration: &Configuration,
    motions: &[BodyMotion; Body::COUNT],
    inertia: impl Fn(Body) -> Option<&'a Inertia>,
) -> [f64; DOF] {
    projected(configuration, |body, passed_on| match inertia(body) {
        Some(inertia) => passed_on + inertia.apply(&motions[body as usize].w),
        None => passed_on,
    })
}

/// The required motion of a machine at rest.
fn at_rest() -> RequiredMotion {
    RequiredMotion {
        zeta_dot: Vector6::zeros(),
        zeta_ddot: Vector6::zeros(),
    }
}

/// Generalised forces on the six joints, N·m; `net` gives the total wrench of a body, including
/// that of the bodies beyond it.
#[inline(always)]
fn projected(configuration: &Configuration, net: impl Fn(Body, Wrench) -> Wrench) -> [f64; DOF] {
    let mut wrenches = [Wrench::zero(); Body::COUNT];
    let mut Q = [0.0; DOF];
    for body in BODIES.into_iter().rev() {
        let F = net(body, wrenches[body as usize]);
        let link = configuration.link(body);
        Q[body.coordinate()] += link.gear * body.axis().power(&F);
        if let Some(parent) = body.parent() {
            wrenches[parent as usize] += link.pose.wrench_to_A(&F);
        }
    }
    Q
}

/// `Y·θ̂ = M·w + V ×* (M·V_r)`: the form in which `C = M·crm(V) + crf(V)·M` is skew.
fn required_net_wrench(motion: &BodyMotion, inertia: &Inertia) -> Wrench {
    inertia.apply(&motion.w) + motion.V.crf(&inertia.apply(&motion.V_r))
}

#[cfg(test)]
mod tests;
