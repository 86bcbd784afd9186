//! The controller: nominal machine, states, one evaluation per communication point.

use crate::actuator_level;
use crate::adaptation::{Bounds, Estimate, adaptation_direction};
use crate::clik::{self, TipState};
use crate::decomposition::{self, BodyMotion};
use crate::error::{ControllerError, STEP_MAX};
use crate::low_level::{Command, Law, LowLevelState, Measured, RodDemand};
use crate::reference::{Desired, Path};
use crate::{Conditions, Input, Level, Mode, Output, Settings, Trajectory};
use emla::{Drive, Emla, Surrogate};
use hdrm::{BODIES, Body, Configuration, GeometryError, Tip, Tree, saturate};
use machine::Machine;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use spatial::Inertia;
use std::cell::{RefCell, RefMut};

/// The controller and its state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Controller {
    nominal: Nominal,
    path: Option<Path>,
    /// Pose of the tip when the controller started.
    start: Desired,
    state: State,
    /// The last evaluation: a step begins with the measurements of the last output, and a master asks for outputs
    /// before and after it has passed the forces. Every step ends with none, so it belongs to the present state.
    #[serde(skip)]
    last: RefCell<Option<Evaluated>>,
}

/// What the controller believes about the machine.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Nominal {
    tree: Tree,
    /// About each body's frame origin.
    inertia: [Inertia; Body::COUNT],
    bounds: [Bounds; Body::COUNT],
    joint_viscous: [f64; 6],
    tau_wrist_max: [f64; 3],
    gravity: f64,
    /// All three are equal.
    actuator: Emla,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct State {
    /// Time, s.
    t: f64,
    /// Time at which the controller started, s.
    t_start: f64,
    estimates: [Estimate; Body::COUNT],
    drives: [LowLevelState; 3],
}

/// An evaluation, the outputs, and what they were made of.
#[derive(Clone, Copy, Debug)]
struct Evaluated {
    settings: Settings,
    input: Input,
    evaluation: Evaluation,
    /// But for the virtual power flows.
    output: Output,
}

impl Evaluated {
    /// Whether it holds for these measurements. The forces count in the virtual power flows only.
    fn holds_for(&self, settings: &Settings, input: &Input) -> bool {
        let but_for_forces = Input {
            F: self.input.F,
            ..*input
        };
        self.input == but_for_forces && self.settings == *settings
    }
}

/// Everything between the inputs and the commands at one instant.
#[derive(Clone, Copy, Debug)]
struct Evaluation {
    /// None at [`Level::Actuator`].
    machine: Option<MachineLevel>,
    demands: [RodDemand; 3],
    commands: [Command; 3],
    tau_wrist: [f64; 3],
}

/// What only the level of the machine has.
#[derive(Clone, Copy, Debug)]
struct MachineLevel {
    desired: Desired,
    tip: Vector3<f64>,
    motions: [BodyMotion; Body::COUNT],
    /// Σ ½ sᵀ M s with the nominal inertias, J.
    energy: f64,
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
        let estimates = std::array::from_fn(|k| nominal.bounds[k].nominal(nominal.inertia[k]));
        let mut controller = Self {
            nominal,
            path: Path::of(trajectory, &machine.trajectories),
            start: Desired::rest(tip.position, orientation(&input.zeta)),
            state: State {
                t,
                t_start: t,
                estimates,
                drives: input
                    .w_m
                    .map(|w_m| LowLevelState::undisturbed(&machine.emla, w_m)),
            },
            last: RefCell::new(None),
        };
        let now = controller.evaluate(settings, input)?;
        for (drive, command) in controller.state.drives.iter_mut().zip(&now.commands) {
            *drive = drive.settled(command.i_qr);
        }
        Ok(controller)
    }

    /// The stability conditions of the low-level law with these gains.
    #[must_use]
    pub fn conditions(&self, settings: &Settings) -> Conditions {
        Conditions::new(self.nominal.actuator.params(), &settings.gains)
    }

    /// Commands for the present measurements.
    ///
    /// # Errors
    /// A reference orientation of length zero, or a number that is not finite.
    pub fn output(&self, settings: &Settings, input: &Input) -> Result<Output, ControllerError> {
        let now = self.evaluated(settings, input)?;
        let demands = &now.evaluation.demands;
        Ok(Output {
            vpf: std::array::from_fn(|i| {
                (demands[i].x_r_dot - input.x_dot[i]) * (demands[i].f_r - input.F[i])
            }),
            ..now.output
        })
    }

    /// The last evaluation if it holds for these measurements, else a new one.
    fn evaluated(
        &self,
        settings: &Settings,
        input: &Input,
    ) -> Result<RefMut<'_, Evaluated>, ControllerError> {
        let mut last = self.last.borrow_mut();
        if !(last.as_ref()).is_some_and(|last| last.holds_for(settings, input)) {
            let evaluation = self.evaluate(settings, input)?;
            *last = Some(Evaluated {
                settings: *settings,
                input: *input,
                output: self.outputs(settings, input, &evaluation),
                evaluation,
            });
        }
        Ok(RefMut::map(last, |last| {
            last.as_mut().expect("made where there was none")
        }))
    }

    /// All outputs but the virtual power flows.
    fn outputs(&self, settings: &Settings, input: &Input, now: &Evaluation) -> Output {
        let mut output = Output {
            v_d: now.commands.map(|c| c.v_d),
            v_q: now.commands.map(|c| c.v_q),
            i_q_required: now.commands.map(|c| c.i_qr),
            tau_wrist: now.tau_wrist,
            f_required: now.demands.map(|d| d.f_r),
            x_dot_required: now.demands.map(|d| d.x_r_dot),
            motion_end: self.motion_end(settings),
            ..Output::default()
        };
        if let Some(machine) = &now.machine {
            let tip_error = machine.desired.position - machine.tip;
            output.desired_position = machine.desired.position.into();
            output.tip_error = tip_error.into();
            output.tip_error_norm = tip_error.norm();
        }
        self.lyapunov_terms(settings, input, now, &mut output);
        output
    }

    /// Advances by `h` s with the measurements held; on error nothing has changed.
    ///
    /// # Errors
    /// A step that is not positive or too long, and as [`Controller::output`].
    pub fn step(
        &mut self,
        settings: &Settings,
        input: &Input,
        t: f64,
        h: f64,
    ) -> Result<(), ControllerError> {
        if !(h > 0.0 && h <= STEP_MAX) {
            return Err(ControllerError::BadStep { t, h });
        }
        drop(self.evaluated(settings, input)?);
        let last = self.last.get_mut();
        let now = &last.as_ref().expect("evaluated above").evaluation;
        if let (Mode::Adaptive, Some(machine)) = (settings.mode, &now.machine) {
            for (k, motion) in machine.motions.iter().enumerate() {
                let S = adaptation_direction(&motion.w, &motion.V_r, &motion.V, &motion.s());
                let bounds = &self.nominal.bounds[k];
                self.state.estimates[k].advance(&S, settings.gains.gamma, h, bounds);
            }
        }
        let law = self.nominal.law(settings);
        for (i, drive) in self.state.drives.iter_mut().enumerate() {
            law.advance(drive, &measured(input, i), &now.commands[i], h);
        }
        self.state.t = t + h;
        *last = None;
        Ok(())
    }

    /// Time at which the reference has come to its end, s; the start time for an external one.
    fn motion_end(&self, settings: &Settings) -> f64 {
        let path = self
            .path
            .as_ref()
            .filter(|_| settings.level == Level::Machine);
        let motion = path.map_or(0.0, |path| settings.gains.settle_time + path.duration());
        self.state.t_start + motion
    }

    fn desired(&self, settings: &Settings, input: &Input) -> Result<Desired, ControllerError> {
        let Some(path) = &self.path else {
            return external(input);
        };
        let [x, v, a] = path.at(self.state.t - self.state.t_start - settings.gains.settle_time);
        Ok(Desired {
            position: self.start.position + x,
            velocity: v,
            acceleration: a,
            ..self.start
        })
    }

    fn evaluate(&self, settings: &Settings, input: &Input) -> Result<Evaluation, ControllerError> {
        let (machine, demands, tau) = match settings.level {
            Level::Machine => {
                let (machine, demands, tau) = self.machine_level(settings, input)?;
                (Some(machine), demands, tau)
            }
            Level::Actuator => {
                let mass = self.nominal.actuator.params().M_act;
                let demand = |i| actuator_level::demand(mass, settings, input, i);
                (None, std::array::from_fn(demand), [0.0; 3])
            }
        };
        let law = self.nominal.law(settings);
        let commands: [Command; 3] = std::array::from_fn(|i| {
            law.command(&self.state.drives[i], &demands[i], &measured(input, i))
        });
        let tau_wrist = std::array::from_fn(|j| saturate(tau[j], self.nominal.tau_wrist_max[j]));
        let evaluation = Evaluation {
            machine,
            demands,
            commands,
            tau_wrist,
        };
        self.finite(&evaluation)?;
        Ok(evaluation)
    }

    /// Inverse kinematics and decomposition: what is asked of the rods, and the wrist torques, N·m.
    fn machine_level(
        &self,
        settings: &Settings,
        input: &Input,
    ) -> Result<(MachineLevel, [RodDemand; 3], [f64; 3]), ControllerError> {
        let gains = &settings.gains;
        let desired = self.desired(settings, input)?;
        let configuration = self.nominal.tree.configuration(&input.zeta);
        let tip = Tip::new(&self.nominal.tree, &configuration);
        let state = TipState {
            tip: &tip,
            orientation: orientation(&input.zeta),
            zeta: &input.zeta,
            zeta_dot: &input.zeta_dot,
        };
        let Lambda = [gains.Lambda_position, gains.Lambda_orientation];
        let required = clik::required(&state, &desired, Lambda);
        let motions = decomposition::motions(
            &configuration,
            &input.zeta_dot,
            &required,
            self.nominal.gravity,
        );
        let errors = decomposition::velocity_errors(&motions, &self.nominal.inertia);
        let mut demands = rod_motion(&configuration, input, &required);
        let tau = match settings.mode {
            Mode::Adaptive | Mode::Modular => {
                let mut Q = decomposition::joint_forces(
                    &configuration,
                    &motions,
                    &self.state.estimates,
                    &errors,
                    gains.kappa_KA,
                );
                for (i, Q) in Q.iter_mut().enumerate() {
                    *Q += self.nominal.joint_viscous[i] * required.zeta_dot[i];
                }
                for (i, demand) in demands.iter_mut().enumerate() {
                    demand.f_r = Q[i] / configuration.strokes[i].prime;
                }
                [Q[3], Q[4], Q[5]]
            }
            Mode::Pd => {
                for (i, demand) in demands.iter_mut().enumerate() {
                    let x_dot = configuration.strokes[i].prime * input.zeta_dot[i];
                    demand.f_r = gains.pd_actuator_damping * (demand.x_r_dot - x_dot);
                }
                std::array::from_fn(|j| {
                    gains.pd_wrist_damping[j] * (required.zeta_dot[3 + j] - input.zeta_dot[3 + j])
                })
            }
        };
        let machine = MachineLevel {
            desired,
            tip: tip.position,
            motions,
            energy: errors.energy,
        };
        Ok((machine, demands, tau))
    }

    fn finite(&self, now: &Evaluation) -> Result<(), ControllerError> {
        let signals = [
            ("v_d", now.commands.map(|c| c.v_d)),
            ("v_q", now.commands.map(|c| c.v_q)),
            ("tau_wrist", now.tau_wrist),
        ];
        for (signal, values) in signals {
            if let Some(&value) = values.iter().find(|v| !v.is_finite()) {
                return Err(ControllerError::NotFinite {
                    t: self.state.t,
                    signal,
                    value,
                });
            }
        }
        Ok(())
    }

    /// The accompanying functions of the stability proof.
    fn lyapunov_terms(
        &self,
        settings: &Settings,
        input: &Input,
        now: &Evaluation,
        output: &mut Output,
    ) {
        let gains = &settings.gains;
        if let Some(machine) = &now.machine {
            output.nu_velocity = settings.true_inertia_scale * machine.energy;
            output.dissipation = 2.0 * gains.kappa_KA * machine.energy;
            for (k, estimate) in self.state.estimates.iter().enumerate() {
                let truth = self.nominal.inertia[k] * settings.true_inertia_scale;
                output.mass_hat[k] = estimate.inertia().m;
                output.nu_adaptation += gains.gamma * estimate.divergence(&truth);
            }
        }
        let p = self.nominal.actuator.params();
        let conditions = Conditions::new(p, gains);
        if conditions.hold() {
            output.conditions = conditions; // else they are not defined, and stay 0
        }
        for i in 0..3 {
            let i_d_error = self.state.drives[i].i_dr - input.i_d[i];
            let force_error = now.commands[i].force_error;
            output.force_error[i] = force_error;
            output.nu_actuator[i] = conditions.accompanying(force_error, i_d_error);
            output.dissipation_actuator[i] =
                conditions.dissipation(p, gains, force_error, i_d_error);
        }
    }
}

impl Nominal {
    fn law<'a>(&'a self, settings: &'a Settings) -> Law<'a> {
        Law {
            actuator: &self.actuator,
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
        let mut bounds = Vec::with_capacity(Body::COUNT);
        for body in BODIES {
            let around = Bounds::around(&inertia[body as usize], inverse_bounds);
            bounds.push(around.ok_or(ControllerError::NotPhysical { body })?);
        }
        Ok(Self {
            tree: Tree::new(machine)?,
            inertia,
            bounds: bounds.try_into().expect("one per body"),
            joint_viscous: machine.joint_viscous,
            tau_wrist_max: machine.limits.tau_wrist_max,
            gravity: machine.gravity,
            actuator: Emla::new(machine.emla, Drive::Motion)?
                .with_surrogate(surrogate.clone(), 0.0),
        })
    }
}

/// What drive `i` measures.
fn measured(input: &Input, i: usize) -> Measured {
    Measured {
        i_d: input.i_d[i],
        i_q: input.i_q[i],
        w_m: input.w_m[i],
        F: input.F[i],
    }
}

/// Required rod motion, without the force: `ẋ_r = x'·ζ̇_r`, `ẍ_r = x'·ζ̈_r + x''·ζ̇·ζ̇_r`.
fn rod_motion(
    configuration: &Configuration,
    input: &Input,
    required: &clik::Required,
) -> [RodDemand; 3] {
    std::array::from_fn(|i| {
        let stroke = &configuration.strokes[i];
        let rate_r = required.zeta_dot[i];
        RodDemand {
            f_r: 0.0,
            x_r_dot: stroke.prime * rate_r,
            x_r_ddot: stroke.prime * required.zeta_ddot[i]
                + stroke.second * input.zeta_dot[i] * rate_r,
        }
    })
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

fn orientation(zeta: &[f64; 6]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Tip::orientation(zeta))
}

/// The external reference as the inputs give it.
fn external(input: &Input) -> Result<Desired, ControllerError> {
    let [w, x, y, z] = input.reference_orientation;
    let q = Quaternion::new(w, x, y, z);
    let orientation =
        UnitQuaternion::try_new(q, 1e-3).ok_or(ControllerError::Orientation { norm: q.norm() })?;
    Ok(Desired {
        position: input.reference_position.into(),
        velocity: input.reference_velocity.into(),
        acceleration: input.reference_acceleration.into(),
        orientation,
        angular_velocity: input.reference_angular_velocity.into(),
    })
}
