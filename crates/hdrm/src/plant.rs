//! The manipulator as a plant: equations of motion with drives, friction and end stops.

use crate::boom_frame::{BoomFrame, MovingParts};
use crate::contact::{Contact, Plane};
use crate::end_stop::{EndStop, JOINT_DISSIPATION, STROKE_DISSIPATION};
use crate::factor::Factor;
use crate::gravity::Gravity;
use crate::load::{Load, Payload};
use crate::recursion;
use crate::tree::Stroke;
use crate::{BODIES, Body, DOF, GeometryError, Tree};
use machine::Machine;
use nalgebra::{Matrix3, Matrix6, Vector6};
use serde::{Deserialize, Serialize};
use spatial::{Inertia, Wrench};
use thiserror::Error;

/// What may differ from the machine file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// Factor s on mass, first moment and inertia of every body, payload included.
    pub inertia_scale: f64,
    /// What the end-effector carries at first.
    pub load: Load,
    /// Viscous joint friction on `zeta_dot`, N·m·s/rad.
    pub joint_viscous: [f64; DOF],
    /// Acceleration of gravity in world axes, m/s²: not along −y where the machine does not stand plumb.
    pub gravity: [f64; 3],
    /// A plane that the tip may touch.
    pub contact: Contact,
}

impl Options {
    /// The machine as its file has it.
    #[must_use]
    pub fn of(machine: &Machine) -> Self {
        Self {
            inertia_scale: 1.0,
            load: Load::of(machine),
            joint_viscous: machine.joint_viscous,
            gravity: [0.0, -machine.gravity, 0.0],
            contact: Contact::default(),
        }
    }
}

/// Why a plant could not be built.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum HdrmError {
    /// The mechanism does not work.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A number is out of its range.
    #[error("`{name}` is {value}: it must be {rule}")]
    Value {
        /// Parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        rule: &'static str,
    },
}

/// What acts on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Actuator forces of slew, lift and tilt, N, positive when extending.
    pub f: [f64; 3],
    /// Wrist torques, N·m; beyond the machine's limits they saturate.
    pub tau_wrist: [f64; 3],
    /// Wrench `[f; m]` of the environment on the end-effector at T4 in T4 axes, N and N·m.
    pub wrench_env: [f64; 6],
    /// Acceleration of the base in the machine's world axes, m/s².
    pub base_acceleration: [f64; 3],
    /// Tilt of the base, rad: roll about x, then pitch about its own z.
    pub base_tilt: [f64; 2],
    /// Angular velocity of the base in the machine's world axes, rad/s.
    pub base_angular_velocity: [f64; 3],
    /// Its rate, rad/s².
    pub base_angular_acceleration: [f64; 3],
}

/// Joint angles and rates, and the energies that the machine's own do not show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Joint angles, rad.
    pub zeta: [f64; DOF],
    /// Joint rates, rad/s.
    pub zeta_dot: [f64; DOF],
    /// Energy that the contact has turned into heat, J.
    pub contact_loss: f64,
    /// Energy that changes of the load have brought, J.
    pub load_energy: f64,
}

impl State {
    /// The machine at rest in the pose `zeta`, rad.
    pub(crate) fn at_rest(zeta: [f64; DOF]) -> Self {
        Self {
            zeta,
            ..Self::default()
        }
    }
}

/// The plant; its parameters do not change after [`Hdrm::new`], but for the load ([`Hdrm::reloaded`]).
///
/// ```text
/// M(zeta)·zeta_ddot + h(zeta, zeta_dot) + D·zeta_dot
///     = Jxᵀ·(f + f_stop) + [0, 0, 0, tau + tau_stop] + J_T4ᵀ·(W_env + W_contact)
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hdrm {
    pub(crate) tree: Tree,
    /// In the order of [`BODIES`].
    pub(crate) bodies: [Inertia; Body::COUNT],
    pub(crate) parts: MovingParts,
    pub(crate) payload: Payload,
    pub(crate) load: Load,
    pub(crate) plane: Option<Plane>,
    pub(crate) gravity: Gravity,
    pub(crate) joint_viscous: [f64; DOF],
    /// Whether substeps look at friction.
    pub(crate) friction_is_stiff: bool,
    tau_wrist_max: [f64; 3],
    /// On the strokes of slew, lift, tilt, then on the wrist angles.
    pub(crate) stops: [EndStop; DOF],
}

/// The plant at one state: everything that inputs do not change.
#[derive(Clone, Debug)]
pub struct Dynamics {
    pub(crate) state: State,
    /// As it is felt on the base.
    pub(crate) gravity: Gravity,
    pub(crate) frame: BoomFrame,
    pub(crate) strokes: [Stroke; 3],
    pub(crate) M: Matrix6<f64>,
    pub(crate) factor: Factor,
    /// Bias forces with gravity.
    pub(crate) h: Vector6<f64>,
    /// The machine's momentum along y for each coordinate's unit rate, kg·m.
    pub(crate) momentum_y: Vector6<f64>,
    /// What holds the machine still against gravity.
    pub(crate) holding: Vector6<f64>,
}

impl Hdrm {
    /// Plant of a machine.
    ///
    /// # Errors
    /// A mechanism that does not work over its joint range, or an option out of range.
    pub fn new(machine: &Machine, options: &Options) -> Result<Self, HdrmError> {
        check(options)?;
        let tree = Tree::new(machine)?;
        let payload = Payload::of(machine, options.inertia_scale);
        let bodies = inertias(machine, options, &payload);
        let free = EndStop {
            range: [f64::NEG_INFINITY, f64::INFINITY],
            stiffness: 0.0,
            dissipation: 0.0,
        };
        let mut plant = Self {
            parts: MovingParts::new(&bodies),
            payload,
            load: options.load,
            plane: options.contact.plane()?,
            tree,
            bodies,
            gravity: Gravity::of(options.gravity),
            joint_viscous: options.joint_viscous,
            friction_is_stiff: false,
            tau_wrist_max: machine.limits.tau_wrist_max,
            stops: [free; DOF],
        };
        let start = plant.dynamics(&State::at_rest(machine.start.zeta));
        plant.friction_is_stiff = plant.has_stiff_friction(&start);
        plant.stops = plant.dimension_stops(machine, &start);
        Ok(plant)
    }

    /// Stops of slew, lift and tilt where the stroke ends or the joint range does, whichever comes
    /// first (the tilt linkage has a dead point just below stroke zero, far beyond its joint
    /// range); stops of the wrist at its joint limits. Dimensioned for the mass that each
    /// coordinate feels at `start`.
    fn dimension_stops(&self, machine: &Machine, start: &Dynamics) -> [EndStop; DOF] {
        let limits = machine.limits.zeta();
        let strokes = machine.limits.strokes();
        // x_i depends on zeta_i only, so a pose at all lower limits gives all lower strokes.
        let at_limit = |end: usize| {
            let zeta = limits.map(|range| range[end]);
            self.tree.strokes(zeta[0], &self.tree.solve(&zeta))
        };
        let (low, high) = (at_limit(0), at_limit(1));
        std::array::from_fn(|i| {
            let mobility = start.factor.mobility(i);
            if i < 3 {
                let [min, max] = strokes[i];
                let range = [min.max(low[i].x), max.min(high[i].x)];
                let prime = start.strokes[i].prime;
                let mass = 1.0 / (prime * prime * mobility);
                EndStop::new(range, mass, STROKE_DISSIPATION)
            } else {
                EndStop::new(limits[i], 1.0 / mobility, JOINT_DISSIPATION)
            }
        })
    }

    /// The plant's geometry.
    #[must_use]
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Inertias in the order of [`BODIES`], in body axes about body origins.
    #[must_use]
    pub fn inertias(&self) -> &[Inertia; Body::COUNT] {
        &self.bodies
    }

    /// End stops on the strokes of slew, lift and tilt (m), then on the wrist angles (rad).
    #[must_use]
    pub fn end_stops(&self) -> &[EndStop; DOF] {
        &self.stops
    }

    /// Loops, mass matrix and bias forces at a state, on a base at rest.
    #[must_use]
    pub fn dynamics(&self, state: &State) -> Dynamics {
        self.dynamics_under(state, self.gravity)
    }

    /// The same on a base that moves as `input` says.
    #[must_use]
    pub fn dynamics_with(&self, state: &State, input: &Input) -> Dynamics {
        let mut dynamics = self.dynamics_under(state, self.felt_gravity(input));
        if let Some(turning) = self.turning_forces(state, input) {
            dynamics.h += turning;
        }
        dynamics
    }

    fn dynamics_under(&self, state: &State, gravity: Gravity) -> Dynamics {
        let State { zeta, zeta_dot, .. } = state;
        let solved = self.tree.solve(zeta);
        let frame = BoomFrame::new(&self.tree, &self.parts, &solved);
        let (M, momentum_y) = frame.mass_matrix();
        let mut h = frame.bias(zeta_dot, gravity.along_y);
        let mut holding = momentum_y * gravity.along_y;
        if let Some(sideways) = self.holding_sideways(&gravity, zeta) {
            h += sideways;
            holding += sideways;
        }
        Dynamics {
            state: *state,
            gravity,
            strokes: self.tree.strokes(zeta[0], &solved),
            factor: Factor::new(&M),
            M,
            h,
            momentum_y,
            holding,
            frame,
        }
    }

    /// Mass matrix `M` and bias `h` with gravity, without friction and stops.
    #[must_use]
    pub fn equations_of_motion(&self, state: &State) -> (Matrix6<f64>, Vector6<f64>) {
        let Dynamics { M, h, .. } = self.dynamics(state);
        (M, h)
    }

    /// Joint accelerations, rad/s².
    #[must_use]
    pub fn forward_dynamics(&self, state: &State, input: &Input) -> [f64; DOF] {
        self.acceleration(&self.dynamics_with(state, input), input)
            .into()
    }

    /// `M⁻¹·(Q − h − D·zeta_dot)`.
    pub(crate) fn acceleration(&self, dynamics: &Dynamics, input: &Input) -> Vector6<f64> {
        let Q = self.generalised_forces(dynamics, input);
        dynamics.factor.solve(&(Q - dynamics.h))
    }

    /// Drives, end stops, friction, environment and contact on the coordinates, N·m.
    pub(crate) fn generalised_forces(&self, dynamics: &Dynamics, input: &Input) -> Vector6<f64> {
        let State { zeta, zeta_dot, .. } = &dynamics.state;
        let mut Q = dynamics.frame.tip_forces(&wrench(&input.wrench_env));
        if self.plane.is_some() {
            Q += dynamics.frame.tip_forces_of(&self.touch(dynamics).force);
        }
        for i in 0..DOF {
            let w = zeta_dot[i];
            Q[i] -= self.joint_viscous[i] * w;
            Q[i] += if i < 3 {
                let Stroke { x, prime, .. } = dynamics.strokes[i];
                prime * (input.f[i] + self.stops[i].force(x, prime * w))
            } else {
                self.saturated(i - 3, input.tau_wrist[i - 3]) + self.stops[i].force(zeta[i], w)
            };
        }
        Q
    }

    /// Torque that wrist drive i gives: the ideal source obeys up to its limit.
    fn saturated(&self, i: usize, tau: f64) -> f64 {
        saturate(tau, self.tau_wrist_max[i])
    }

    /// 1 while wrist drive i follows its command, 0 in saturation.
    pub(crate) fn wrist_gain(&self, i: usize, tau: f64) -> f64 {
        f64::from(u8::from(tau.abs() <= self.tau_wrist_max[i]))
    }

    /// Drive forces and torques for which the machine moves with `zeta_ddot`, rad/s², in free
    /// range (end stops left out) under the wrench `wrench_env` on its tip. Independent of the path
    /// that [`Hdrm::forward_dynamics`] takes. Wrist torques are not limited.
    #[must_use]
    pub fn inverse_dynamics(
        &self,
        state: &State,
        zeta_ddot: &[f64; DOF],
        wrench_env: &[f64; 6],
    ) -> ([f64; 3], [f64; 3]) {
        let State { zeta, zeta_dot, .. } = state;
        let configuration = self.tree.configuration(zeta);
        let mut Q = recursion::inverse_dynamics(
            &configuration,
            &self.bodies,
            zeta_dot,
            zeta_ddot,
            &self.gravity,
        )
        .value;
        Q += Vector6::from(self.joint_viscous).component_mul(&Vector6::from(*zeta_dot));
        let W = wrench(wrench_env);
        Q -= recursion::tip_forces(&configuration, &self.tree, zeta_dot, &W).value;
        let f = std::array::from_fn(|i| Q[i] / configuration.strokes[i].prime);
        (f, [Q[3], Q[4], Q[5]])
    }

    /// Forces of the actuators, N, and torques of the wrist, N·m, that hold the machine still in
    /// the pose `zeta` against gravity alone.
    #[must_use]
    pub fn holding(&self, zeta: &[f64; DOF]) -> ([f64; 3], [f64; 3]) {
        self.inverse_dynamics(&State::at_rest(*zeta), &[0.0; DOF], &[0.0; 6])
    }

    /// Kinetic and potential energy, J; the latter is zero with all masses at the height of the
    /// world's origin.
    #[must_use]
    pub fn energies(&self, state: &State) -> (f64, f64) {
        self.energies_of(&self.dynamics(state))
    }

    pub(crate) fn energies_of(&self, dynamics: &Dynamics) -> (f64, f64) {
        let w = Vector6::from(dynamics.state.zeta_dot);
        let kinetic = 0.5 * w.dot(&(dynamics.M * w));
        let along_y = dynamics.gravity.along_y * dynamics.frame.first_moment_y();
        let sideways = self.potential_sideways(&dynamics.gravity, &dynamics.state.zeta);
        (kinetic, along_y + sideways)
    }
}

/// `x` saturated to ±`limit`. Unlike [`f64::clamp`] it does not panic where the limit is senseless, as it may be in a saved state
/// that was damaged. NaN stays NaN.
#[inline(always)]
#[must_use]
pub fn saturate(x: f64, limit: f64) -> f64 {
    if x.abs() > limit {
        limit.copysign(x)
    } else {
        x
    }
}

/// `[f; m]` as a wrench.
pub(crate) fn wrench(components: &[f64; 6]) -> Wrench {
    Wrench::from_vector(&Vector6::from(*components))
}

fn check(options: &Options) -> Result<(), HdrmError> {
    let refuse = |name, value, rule| Err(HdrmError::Value { name, value, rule });
    let not_negative = |value: f64| value.is_finite() && value >= 0.0;
    let &Options {
        inertia_scale,
        load,
        joint_viscous,
        gravity,
        ..
    } = options;
    if !(inertia_scale.is_finite() && inertia_scale > 0.0) {
        return refuse("inertia_scale", inertia_scale, "finite and > 0");
    }
    load.check()?;
    if let Some(&value) = gravity.iter().find(|g| !g.is_finite()) {
        return refuse("gravity", value, "finite");
    }
    match joint_viscous.into_iter().find(|&d| !not_negative(d)) {
        Some(d) => refuse("joint_viscous", d, "finite and ≥ 0"),
        None => Ok(()),
    }
}

/// Inertias about body origins with the options applied.
fn inertias(machine: &Machine, options: &Options, payload: &Payload) -> [Inertia; Body::COUNT] {
    let bodies = machine.bodies.in_order();
    std::array::from_fn(|k| {
        if BODIES[k] == Body::PL {
            return payload.inertia(&options.load);
        }
        let body = bodies[k];
        let [x, y, z] = body.inertia_com.rows();
        let I_com = Matrix3::new(x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]);
        let inertia = Inertia::from_com(body.mass, body.com.into(), I_com);
        inertia * options.inertia_scale
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saturation_is_symmetric_and_senseless_limits_do_not_panic() {
        for x in [-3.0, -2.0, 0.5, 2.0, 7.0] {
            assert_eq!(saturate(x, 2.0), x.clamp(-2.0, 2.0));
        }
        assert!(saturate(f64::NAN, 2.0).is_nan());
        assert!(saturate(1.0, -2.0).is_finite() && saturate(1.0, f64::NAN) == 1.0);
    }
}
