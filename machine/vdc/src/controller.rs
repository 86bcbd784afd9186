//! The whole controller, for the FMU: evaluates the control law stage by stage, from measurements
//! to commands; its module `step` advances its state. Only these two files know all stages.

mod step;

use crate::bodies::Bodies;
use crate::conditions::Conditions;
use crate::drive::{Command, DriveState, Reading, RodDemand, VoltageLaw, residual_forces};
use crate::error::ControllerError;
use crate::evaluation::{Evaluation, MachineLevel};
use crate::laps::LapMemory;
use crate::law::{self, Instant, Rod, WristFriction};
use crate::measured::{JointObserver, Sampling, Timing};
use crate::nominal::Nominal;
use crate::proof;
use crate::reference::{Motion, Reference, Standstill, Target, Trajectory, at_any_pose};
use crate::settings::{Level, Settings};
use crate::signals::Input;
use crate::state::State;
use crate::supervisor::{Stage, Supervisor};
use crate::tracking::{Errors, RodMotion, rod_errors, track};
use crate::warnings::{ReportedWarnings, Warning, first_warning};
use emla::Surrogate;
use hdrm::{DOF, Tip, saturate};
use machine_file::{Controller as Gains, Machine};
use nalgebra::Vector6;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use tip_path::Load;

/// The controller and its state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Controller {
    nominal: Nominal,
    reference: Reference,
    timing: Timing,
    state: State,
    /// What it learns on a path of equal laps.
    laps: Option<LapMemory>,
}

impl Controller {
    /// A controller for `machine` with the network `surrogate` in its actuator models (weight
    /// `settings.alpha`), starting at time `t`, s, with the measurements `input`. An error for
    /// invalid parameters or limits, or a path that the machine cannot follow.
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
        let nominal = Nominal::new(machine, surrogate)?;
        let reference = Reference::new(trajectory, machine, &nominal, &input.zeta)?;
        let laps = reference.laps().filter(|_| settings.learning > 0.0);
        let laps = laps.and_then(LapMemory::new);
        if settings.learning > 0.0 && laps.is_none() {
            return Err(ControllerError::NoLaps(settings.learning));
        }
        let drive = |i: usize| DriveState::undisturbed(nominal.parameters()[i], input.w_m[i]);
        let mut controller = Self {
            state: State {
                t,
                t_start: t,
                joints: JointObserver::default(),
                sampling: Sampling::default(),
                motion: Motion::rest(&input.zeta),
                standstill: Standstill::default(),
                integral: Vector6::zeros(),
                law_integral: [0.0; DOF],
                wrist_friction: WristFriction::default(),
                bodies: Bodies::new(machine, settings.gains.inverse_bounds)?,
                drives: [0, 1, 2].map(drive),
                supervisor: Supervisor::new(
                    settings.supervisor && settings.level == Level::Machine,
                ),
            },
            reference,
            laps,
            timing: Timing::default(),
            nominal,
        };
        // The filters start in steady state with the present required currents.
        let now = controller.evaluate(settings, input)?;
        for (drive, command) in controller.state.drives.iter_mut().zip(&now.commands) {
            *drive = drive.settled(command.i_qr);
        }
        Ok(controller)
    }

    /// Sets sample time and delay; to be called before the first step.
    #[must_use]
    pub fn with_timing(self, timing: Timing) -> Self {
        Self { timing, ..self }
    }

    /// Sample time and delay.
    #[must_use]
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// The voltage law's stability conditions, for the actuator with the smallest margin.
    #[must_use]
    pub fn conditions(&self, gains: &Gains) -> Conditions {
        let conditions = |p| Conditions::new(p, gains);
        Conditions::weakest(self.nominal.parameters().map(conditions))
    }

    /// Evaluates inverse kinematics, control law and voltage law for the present state, with the
    /// measurements `input`, or the held ones (with `sample_time` or `delay`). The result is valid
    /// until the state, the settings or an input other than the forces `F` change.
    pub fn evaluate(
        &self,
        settings: &Settings,
        input: &Input,
    ) -> Result<Evaluation, ControllerError> {
        let Self { nominal, state, .. } = self;
        let settings = &*self.effective_settings(settings);
        let held = state.sampling.held.as_ref();
        let observed = state
            .joints
            .with_observed_rates(input, settings.gains.omega_speed);
        let input = held.unwrap_or(&observed);
        let mut now = Evaluation::with_held(held);
        now.current_loop = settings.current_loop;
        let wrist = match settings.level {
            Level::Machine => self.machine_level(&mut now, settings, input)?,
            Level::Actuator => self.actuator_level(&mut now, settings, input),
        };
        now.commands = self.voltages(&now.demands, settings, input);
        let limit = &nominal.tau_wrist_max;
        now.output.tau_wrist = std::array::from_fn(|j| saturate(wrist[j], limit[j]));
        now.fill_outputs(input);
        let t = state.motion_time(settings.gains.settle_time);
        now.output.motion_end = self.motion_end(settings);
        now.set_gates_and_brakes(&state.supervisor, input);
        now.output.lap = self
            .reference
            .laps()
            .map_or(0, |laps| laps.number(t) as i32);
        now.output.load = self.reference.load(t).unwrap_or_default();
        proof::fill(&mut now, nominal, state, settings, input);
        match now.output.not_finite() {
            Some((signal, value)) => Err(ControllerError::NotFinite {
                t: state.t,
                signal,
                value,
            }),
            None => Ok(now),
        }
    }

    /// `settings` with the gains that apply: lower at rest, under commanded rates, and by the
    /// supervisor.
    fn effective_settings<'a>(&self, settings: &'a Settings) -> Cow<'a, Settings> {
        let watched = self.state.supervisor.effective_settings(settings);
        let share = match self.reference.rates() {
            _ if settings.level == Level::Actuator => 0.0,
            Some(_) => 1.0,
            None => self.state.standstill.share(),
        };
        if share == 0.0 {
            return watched;
        }
        let mut resting = watched.into_owned();
        at_any_pose(&mut resting.gains, share);
        if self.reference.rates().is_some() {
            // With less a machine that stands on something pushes so little that its reference waits
            // too late.
            resting.gains.kappa_share = [1.0; 3];
        }
        Cow::Owned(resting)
    }

    /// The law of the whole machine: from the reference of the tip, or of the joints, to the
    /// demands on the rods and the wrist torques, N·m.
    fn machine_level(
        &self,
        now: &mut Evaluation,
        settings: &Settings,
        input: &Input,
    ) -> Result<[f64; 3], ControllerError> {
        let Self {
            nominal,
            reference,
            state,
            laps,
            ..
        } = self;
        let gains = &settings.gains;
        let t = state.motion_time(gains.settle_time);
        let mut target = reference.target(nominal, &state.motion, input, t)?;
        if let Some(motion) = state.supervisor.motion() {
            target = Target::from_joints(motion, nominal);
        }
        let desired = target.tip;
        if let Some(laps) = laps {
            let shift = laps.shift(t);
            now.output.learnt_shift = shift[0].into();
            if target.joints.is_none() {
                target.tip = desired.shifted(&shift);
            }
        }
        let configuration = nominal.tree.configuration(&input.zeta);
        let tip = Tip::new(&nominal.tree, &configuration);
        let z = settings.integral.then_some(&state.integral);
        let tracking = track(&target, nominal, gains, z, &tip, input);
        let required = &tracking.required;
        let ground = law::ground(nominal.gravity, input);
        let motions = law::motions(&configuration, &input.zeta_dot, required, &ground);
        let errors = law::velocity_errors(&motions, &state.bodies.nominal);
        let rods = std::array::from_fn(|i| {
            let stroke = &configuration.strokes[i];
            RodMotion::from_joint(stroke, input.zeta_dot[i], required, i)
        });
        let [slew, lift, tilt] = gains.kappa_share;
        let s = std::array::from_fn(|i| required.zeta_dot[i] - input.zeta_dot[i]);
        let shared_momentum = law::shared_momentum(
            &configuration,
            &state.bodies.nominal,
            &s,
            &[slew, lift, tilt, 1.0, 1.0, 1.0],
        );
        let instant = Instant {
            nominal,
            bodies: &state.bodies,
            gains,
            configuration: &configuration,
            zeta_dot: &input.zeta_dot,
            required,
            rods: &rods,
            ground: &ground,
            motions: &motions,
            errors: &errors,
            shared_momentum,
            law_integral: &state.law_integral,
        };
        let law = settings.mode.law();
        let mut forces = law.forces(&instant);
        let compensates =
            law.compensates_friction() && gains.omega_friction > 0.0 && reference.rates().is_none();
        if compensates {
            let (known, share) = (&state.wrist_friction, 1.0 - state.standstill.share());
            let torques = known.torques(&required.zeta_dot.into(), share);
            forces.wrist = std::array::from_fn(|j| forces.wrist[j] + torques[j]);
        }
        now.errors = tracking.errors;
        if let (Some(z), true) = (z, settings.force_limit > 0.0) {
            let grown = z + tracking.errors.z_dot;
            let grown = track(&target, nominal, gains, Some(&grown), &tip, input);
            let more = grown.required.zeta_dot - required.zeta_dot;
            now.push = std::array::from_fn(|i| configuration.strokes[i].prime * more[i]);
        }
        now.demands = std::array::from_fn(|i| {
            RodDemand::limited(self.largest_force(settings, i), forces.rods[i], rods[i])
        });
        let weighs = state.t - state.t_start < settings.weighing_time;
        let bodies = &state.bodies;
        let weighing = weighs.then(|| {
            let payload = bodies.payload();
            law::hook_model(
                &configuration,
                &bodies.nominal,
                payload,
                &ground,
                nominal.gravity,
            )
        });
        now.machine = Some(MachineLevel {
            weighing,
            wrist_inertia: compensates
                .then(|| [3, 4, 5].map(|i| law::whole_inertia(&configuration, &bodies.nominal, i))),
            desired,
            rotation_error: tracking.rotation_error,
            tip: tip.position,
            zeta_dot_r: required.zeta_dot.into(),
            zeta_ddot_r: required.zeta_ddot.into(),
            strokes: configuration.strokes,
            motions,
            law_integral_rate: forces.law_integral_rate,
            energy: errors.energy,
            dissipation: instant.dissipation(),
        });
        let supervisor = &state.supervisor;
        if supervisor.stage() < Stage::Braking {
            return Ok(forces.wrist);
        }
        Ok(std::array::from_fn(|j| {
            let own = law::own_inertia(&configuration, &bodies.nominal, 3 + j);
            supervisor.wrist_holding_torque(j, own, gains, input)
        }))
    }

    /// The law of single actuators: demands from the rods' references, no wrist torques.
    fn actuator_level(&self, now: &mut Evaluation, settings: &Settings, input: &Input) -> [f64; 3] {
        let gains = &settings.gains;
        let z = settings.integral.then_some(&self.state.integral);
        now.errors = Errors::new(rod_errors(input, gains.reading_age), z, gains.omega_tip);
        let law = settings.mode.law();
        now.demands = std::array::from_fn(|i| {
            let motion = RodMotion::from_rod_reference(gains, input, &now.errors, i);
            let f_r = law.rod_force(&Rod {
                gains,
                M_act: self.nominal.actuators[i].params().M_act,
                required: &motion,
                x_dot: input.x_dot[i],
                f_d: input.reference_rod_force[i],
            });
            RodDemand::limited(self.largest_force(settings, i), f_r, motion)
        });
        now.push = std::array::from_fn(|i| gains.Lambda_rod * now.errors.z_dot[i]);
        [0.0; 3]
    }

    /// Limit of the required force of rod `i`, N; None: no limit.
    fn largest_force(&self, settings: &Settings, i: usize) -> Option<f64> {
        (settings.force_limit > 0.0).then(|| settings.force_limit * self.nominal.ratings[i][0])
    }

    /// The voltage laws of the three drives.
    fn voltages(
        &self,
        demands: &[RodDemand; 3],
        settings: &Settings,
        input: &Input,
    ) -> [Command; 3] {
        let (actuators, states) = (&self.nominal.actuators, &self.state.drives);
        let readings = [0, 1, 2].map(|i| Reading::from_input(input, i));
        let residual_forces = residual_forces(actuators, settings, readings.each_ref());
        std::array::from_fn(|i| {
            let law = VoltageLaw {
                actuator: &actuators[i],
                settings,
            };
            law.command(&states[i], &demands[i], &readings[i], residual_forces[i])
        })
    }

    /// Sets the known load of the end-effector; a mass that is not finite and ≥ 0 is ignored.
    pub fn set_load(&mut self, load: &Load) {
        self.state.bodies.carry(load, &self.nominal.tree.r_D4_T4);
    }

    /// The next warning about the commands of `now` in a step from `t` by `h`, both s; `reported`
    /// are the conditions already reported.
    pub fn next_warning(
        &self,
        now: &Evaluation,
        settings: &Settings,
        reported: &mut ReportedWarnings,
        t: f64,
        h: f64,
    ) -> Option<Warning> {
        let h = h.max(self.timing.sample_time);
        let rates = self.reference.rates().map(|r| (r, &self.state.motion));
        first_warning(
            now,
            &self.nominal,
            rates,
            &self.state.supervisor,
            settings,
            reported,
            [t, h],
        )
    }

    /// Time at which the reference ends, s; the start time for an external one.
    fn motion_end(&self, settings: &Settings) -> f64 {
        let duration = match settings.level {
            Level::Machine => self.reference.duration(),
            Level::Actuator => None,
        };
        let motion = duration.map_or(0.0, |duration| settings.gains.settle_time + duration);
        self.state.t_start + motion
    }
}

#[cfg(test)]
mod tests;
