//! The controller: nominal machine, states, and how they advance.

use crate::adaptation::{Bounds, Estimate, adaptation_direction};
use crate::clik::Singularities;
use crate::error::{ControllerError, STEP_MAX};
use crate::evaluation::{Evaluation, measured};
use crate::load::Load;
use crate::low_level::{Law, LowLevelState};
use crate::rates::{RateLimits, Rates};
use crate::reference::{Desired, Path};
use crate::sampling::{Sampling, Timing};
use crate::speed::JointObserver;
use crate::{Conditions, Input, Mode, Settings, Trajectory};
use capability::Reach;
use emla::{Drive, Emla, Surrogate};
use hdrm::{BODIES, Body, GeometryError, Tip, Tree};
use machine::Machine;
use nalgebra::{Matrix3, UnitQuaternion, Vector6};
use serde::{Deserialize, Serialize};
use spatial::Inertia;
use tip_path::TipPath;

/// The controller and its state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Controller {
    pub(crate) nominal: Nominal,
    pub(crate) path: Option<Path>,
    /// Commanded rates in place of a path.
    pub(crate) rates: Option<Rates>,
    /// A path of a file, where there is no other.
    pub(crate) given: Option<TipPath>,
    /// Pose of the tip when the controller started.
    pub(crate) start: Desired,
    timing: Timing,
    pub(crate) state: State,
}

/// What the controller believes about the machine.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Nominal {
    pub(crate) tree: Tree,
    /// About each body's frame origin.
    pub(crate) inertia: [Inertia; Body::COUNT],
    pub(crate) bounds: [Bounds; Body::COUNT],
    pub(crate) joint_viscous: [f64; 6],
    pub(crate) tau_wrist_max: [f64; 3],
    pub(crate) gravity: f64,
    /// Slew, lift and tilt.
    pub(crate) actuators: [Emla; 3],
    /// The same without the network.
    pub(crate) physics: [Emla; 3],
    pub(crate) reach: Reach,
    pub(crate) singularities: Singularities,
    /// What it is told that the end-effector carries beside the payload.
    pub(crate) load: Load,
    pub(crate) inverse_bounds: [f64; 2],
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct State {
    /// Time that the states belong to, and with them the next evaluation, s: the communication point without `sample_time` and `delay`.
    pub(crate) t: f64,
    /// Time at which the controller started, s.
    pub(crate) t_start: f64,
    pub(crate) estimates: [Estimate; Body::COUNT],
    pub(crate) drives: [LowLevelState; 3],
    /// Integral part z of the tracking error, in the places of [`crate::integral::Errors`].
    pub(crate) integral: Vector6<f64>,
    pub(crate) joints: JointObserver,
    pub(crate) sampling: Sampling,
}

impl Controller {
    /// A controller for `machine` whose actuators follow `surrogate` as far as `settings.alpha` says,
    /// starting at time `t` with the machine as `input` measures it.
    ///
    /// # Errors
    /// Parameters, geometry or inertias that do not make a machine.
    pub fn new(
        machine: &Machine,
        surrogate: &Surrogate,
        trajectory: Trajectory,
        settings: &Settings,
        input: &Input,
        t: f64,
    ) -> Result<Self, ControllerError> {
        machine.check()?;
        settings.gains.check()?;
        let nominal = Nominal::new(machine, surrogate, settings.gains.inverse_bounds)?;
        let configuration = nominal.tree.configuration(&input.zeta);
        let tip = Tip::new(&nominal.tree, &configuration);
        let emla = machine.emla.in_order();
        let drives = std::array::from_fn(|i| LowLevelState::undisturbed(emla[i], input.w_m[i]));
        let estimates = std::array::from_fn(|k| nominal.bounds[k].nominal(nominal.inertia[k]));
        let mut controller = Self {
            path: Path::of(trajectory, &machine.trajectories),
            rates: (trajectory == Trajectory::Rates)
                .then(|| Rates::new(machine, &nominal.tree, &input.zeta)),
            given: None,
            start: Desired::rest(tip.position, orientation(&input.zeta)),
            state: State {
                t,
                t_start: t,
                estimates,
                drives,
                integral: Vector6::zeros(),
                joints: JointObserver::default(),
                sampling: Sampling::default(),
            },
            timing: Timing::default(),
            nominal,
        };
        controller.settle(settings, input)?;
        Ok(controller)
    }

    /// The required currents have been what they are at the start.
    pub(crate) fn settle(
        &mut self,
        settings: &Settings,
        input: &Input,
    ) -> Result<(), ControllerError> {
        let now = self.evaluate(settings, input)?;
        for (drive, command) in self.state.drives.iter_mut().zip(&now.commands) {
            *drive = drive.settled(command.i_qr);
        }
        Ok(())
    }

    /// The same controller with this timing; before its first step.
    #[must_use]
    pub fn with_timing(self, timing: Timing) -> Self {
        Self { timing, ..self }
    }

    /// The same controller with these limits of commanded rates; before its first step.
    ///
    /// # Errors
    /// A limit that is not finite and positive.
    pub fn with_rate_limits(mut self, limits: &RateLimits) -> Result<Self, ControllerError> {
        if let Some(rates) = &mut self.rates {
            rates.set_limits(limits)?;
        }
        Ok(self)
    }

    /// The stability conditions of the low-level law with these gains, at the actuator that meets them with the least margin.
    #[must_use]
    pub fn conditions(&self, settings: &Settings) -> Conditions {
        let of = |emla: &Emla| Conditions::new(emla.params(), &settings.gains);
        Conditions::weakest(self.nominal.actuators.each_ref().map(of))
    }

    /// Advances from the communication point `t` by `h`, both s, with the measurements held; `now` is the evaluation of the present
    /// state and `input`. On error nothing has changed.
    ///
    /// # Errors
    /// A step that is not positive or too long, and as [`Controller::evaluate`].
    pub fn step(
        &mut self,
        now: &Evaluation,
        settings: &Settings,
        input: &Input,
        t: f64,
        h: f64,
    ) -> Result<(), ControllerError> {
        if !(h > 0.0 && h <= STEP_MAX) {
            return Err(ControllerError::BadStep { t, h });
        }
        let input = &self.estimated(settings, input);
        match self.timing {
            Timing { delay: 1.., .. } => self.step_delayed(now, settings, input, t, h)?,
            Timing { sample_time, .. } if sample_time > 0.0 => {
                self.step_sampled(now, settings, input, t, h)?;
            }
            _ => {
                self.advance(now, settings, input, h);
                self.state.t = t + h;
            }
        }
        self.advance_estimates(now, settings, input, h);
        self.hear_of_loads(settings);
        Ok(())
    }

    /// When it samples, and how late its commands act.
    #[must_use]
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// Adaptation and states of the voltage law over an interval of `h` s in which the measurements and commands of `now` are held.
    pub(crate) fn advance(&mut self, now: &Evaluation, settings: &Settings, input: &Input, h: f64) {
        if let (Mode::Adaptive, Some(machine)) = (settings.mode, &now.machine) {
            for (k, motion) in machine.motions.iter().enumerate() {
                let S = adaptation_direction(&motion.w, &motion.V_r, &motion.V, &motion.s());
                let bounds = &self.nominal.bounds[k];
                let gains = &settings.gains;
                self.state.estimates[k].advance(&S, gains.gamma, gains.leakage, h, bounds);
            }
        }
        self.advance_integral(now, h);
        if let Some(rates) = &mut self.rates {
            rates.advance(&self.nominal.tree, settings.rate_command, input, h);
        }
        for (i, drive) in self.state.drives.iter_mut().enumerate() {
            let law = self.nominal.law(settings, i);
            law.advance(drive, &measured(input, i), &now.commands[i], h);
        }
    }
}

impl Nominal {
    /// The law of actuator `i`.
    pub(crate) fn law<'a>(&'a self, settings: &'a Settings, i: usize) -> Law<'a> {
        Law {
            actuator: &self.actuators[i],
            settings,
        }
    }

    fn new(
        machine: &Machine,
        surrogate: &Surrogate,
        inverse_bounds: [f64; 2],
    ) -> Result<Self, ControllerError> {
        let inertia = machine.bodies.in_order().map(|b| {
            let I_com = Matrix3::from_fn(|i, j| b.inertia_com.rows()[i][j]);
            Inertia::from_com(b.mass, b.com.into(), I_com)
        });
        let [slew, lift, tilt] = machine
            .emla
            .in_order()
            .map(|p| Emla::new(*p, Drive::Motion));
        let physics = [slew?, lift?, tilt?];
        let mut bounds = Vec::with_capacity(Body::COUNT);
        for body in BODIES {
            let around = Bounds::around(&inertia[body as usize], inverse_bounds);
            bounds.push(around.ok_or(ControllerError::NotPhysical { body })?);
        }
        let tree = Tree::new(machine)?;
        Ok(Self {
            singularities: Singularities::of(&tree),
            load: Load::default(),
            inverse_bounds,
            tree,
            inertia,
            bounds: bounds.try_into().expect("one per body"),
            joint_viscous: machine.joint_viscous,
            tau_wrist_max: machine.limits.tau_wrist_max,
            gravity: machine.gravity,
            actuators: physics
                .clone()
                .map(|physics| physics.with_surrogate(surrogate.clone(), 0.0)),
            physics,
            reach: Reach::of(&machine.geometry),
        })
    }
}

/// Tip position (m) and orientation (quaternion w, x, y, z) at the joint angles `zeta`, rad.
///
/// # Errors
/// Geometry that is not a working machine.
pub fn tip_pose(machine: &Machine, zeta: &[f64; 6]) -> Result<([f64; 3], [f64; 4]), GeometryError> {
    let tree = Tree::new(machine)?;
    let tip = Tip::new(&tree, &tree.configuration(zeta));
    let q = orientation(zeta);
    Ok((tip.position.into(), [q.w, q.i, q.j, q.k]))
}

pub(crate) fn orientation(zeta: &[f64; 6]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Tip::orientation(zeta))
}
