//! One evaluation of the control law: from measurements to commands, and all outputs.

use crate::actuator_level;
use crate::clik::{self, TipState};
use crate::controller::{Controller, orientation};
use crate::decomposition::{self, BodyMotion};
use crate::error::ControllerError;
use crate::given_path::given_at;
use crate::integral::Errors;
use crate::low_level::{Command, Measured, RodDemand, residual_forces};
use crate::reference::Desired;
use crate::{Conditions, Input, Level, Mode, Output, Settings};
use hdrm::{Body, Configuration, DOF, Stroke, Tip, saturate};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use tip_path::TipPath;

/// Everything between the measurements and the commands at one instant. The forces `F` count in the virtual power flows only.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// None at [`Level::Actuator`].
    pub(crate) machine: Option<MachineLevel>,
    pub(crate) errors: Errors,
    pub(crate) demands: [RodDemand; 3],
    pub(crate) commands: [Command; 3],
    /// Required minus measured rod velocities, m/s.
    rate_error: [f64; 3],
    /// Forces where measurements are held, N.
    F: Option<[f64; 3]>,
    /// Without the virtual power flows.
    output: Output,
}

/// What only the level of the machine has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MachineLevel {
    desired: Desired,
    /// From the present to the desired orientation, rad.
    rotation_error: Vector3<f64>,
    tip: Vector3<f64>,
    /// Required joint accelerations, rad/s².
    pub(crate) zeta_ddot_r: [f64; DOF],
    pub(crate) strokes: [Stroke; 3],
    pub(crate) motions: [BodyMotion; Body::COUNT],
    /// Σ ½ sᵀ M s with the nominal inertias, J.
    energy: f64,
}

impl Evaluation {
    /// Wrist torques, N·m.
    pub(crate) fn tau_wrist(&self) -> [f64; 3] {
        self.output.tau_wrist
    }

    /// Outputs where the actuators deliver the forces `F`, N.
    #[must_use]
    pub fn output(&self, F: &[f64; 3]) -> Output {
        let F = self.F.as_ref().unwrap_or(F);
        let flow = |i: usize| self.rate_error[i] * (self.demands[i].f_r - F[i]);
        Output {
            vpf: std::array::from_fn(flow),
            ..self.output
        }
    }
}

impl Controller {
    /// Time at which the reference has come to its end, s; the start time for an external one.
    fn motion_end(&self, settings: &Settings) -> f64 {
        let duration = match (&self.path, &self.given) {
            _ if settings.level != Level::Machine => None,
            (Some(path), _) => Some(path.duration()),
            (None, given) => given.as_ref().map(TipPath::duration),
        };
        let motion = duration.map_or(0.0, |duration| settings.gains.settle_time + duration);
        self.state.t_start + motion
    }

    fn desired(&self, settings: &Settings, input: &Input) -> Result<Desired, ControllerError> {
        if let Some(rates) = &self.rates {
            return Ok(rates.desired(&self.nominal.tree));
        }
        let Some(path) = &self.path else {
            return match &self.given {
                Some(given) => Ok(given_at(given, self.path_time(settings))),
                None => external(input),
            };
        };
        let [x, v, a] = path.at(self.path_time(settings));
        Ok(Desired {
            position: self.start.position + x,
            velocity: v,
            acceleration: a,
            ..self.start
        })
    }

    /// Inverse kinematics, decomposition and voltage law for the present state, with the measurements `input`; while measurements are
    /// held (`sample_time`, `delay`), with those. It holds until the state, the settings or an input other than the forces `F` change.
    ///
    /// # Errors
    /// A reference orientation of length zero, or a number that is not finite.
    pub fn evaluate(
        &self,
        settings: &Settings,
        input: &Input,
    ) -> Result<Evaluation, ControllerError> {
        let held = self.state.sampling.held();
        let estimated = self.estimated(settings, input);
        let input = held.unwrap_or(&estimated);
        let (machine, errors, demands, tau) = match settings.level {
            Level::Machine => {
                let (machine, errors, demands, tau) = self.machine_level(settings, input)?;
                (Some(machine), errors, demands, tau)
            }
            Level::Actuator => {
                let errors = self.errors(
                    settings,
                    actuator_level::errors(input, settings.gains.reading_age),
                );
                let demand = |i: usize| {
                    let mass = self.nominal.actuators[i].params().M_act;
                    actuator_level::demand(mass, settings, input, &errors, i)
                };
                (None, errors, std::array::from_fn(demand), [0.0; 3])
            }
        };
        let drives = [0, 1, 2].map(|i| measured(input, i));
        let residual_forces = residual_forces(&self.nominal.actuators, settings, drives.each_ref());
        let commands: [Command; 3] = std::array::from_fn(|i| {
            let law = self.nominal.law(settings, i);
            let state = &self.state.drives[i];
            law.command(state, &demands[i], &drives[i], residual_forces[i])
        });
        let tau_wrist = std::array::from_fn(|j| saturate(tau[j], self.nominal.tau_wrist_max[j]));
        let mut evaluation = Evaluation {
            machine,
            errors,
            demands,
            commands,
            rate_error: std::array::from_fn(|i| demands[i].x_r_dot - input.x_dot[i]),
            F: held.map(|held| held.F),
            output: Output {
                tau_wrist,
                ..Output::default()
            },
        };
        self.fill(settings, input, &mut evaluation);
        self.finite(&evaluation.output)?;
        Ok(evaluation)
    }

    /// Inverse kinematics and decomposition: what is asked of the rods, and the wrist torques, N·m.
    fn machine_level(
        &self,
        settings: &Settings,
        input: &Input,
    ) -> Result<(MachineLevel, Errors, [RodDemand; 3], [f64; 3]), ControllerError> {
        let gains = &settings.gains;
        let desired = self.desired(settings, input)?;
        let configuration = self.nominal.tree.configuration(&input.zeta);
        let tip = Tip::new(&self.nominal.tree, &configuration);
        let state = TipState {
            tip: &tip,
            singularities: &self.nominal.singularities,
            orientation: orientation(&input.zeta),
            zeta: &input.zeta,
            zeta_dot: &input.zeta_dot,
        };
        let Lambda = [gains.Lambda_position, gains.Lambda_orientation];
        let age = gains.reading_age;
        let (tracking, required, rotation_error) = if let Some(rates) = &self.rates {
            let tracking = self.errors(settings, rates.error(&input.zeta, age));
            let required = rates.required(&tracking, &input.zeta_dot, age, Lambda);
            let turned = clik::rotation_error(&desired.orientation, &state.orientation);
            (tracking, required, turned)
        } else {
            let seen = match age {
                0.0 => desired,
                age => desired.earlier(age),
            };
            let tracking = self.errors(settings, clik::pose_error(&state, &seen));
            let required = clik::required(&state, &desired, &seen, &tracking, Lambda);
            (tracking, required, tracking.e.fixed_rows::<3>(3).into())
        };
        let ground = decomposition::ground(self.nominal.gravity, input);
        let motions = decomposition::motions(&configuration, &input.zeta_dot, &required, &ground);
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
            Mode::Pd | Mode::PdGravity => {
                let Q = match settings.mode {
                    Mode::PdGravity => decomposition::holding_forces(
                        &configuration,
                        &self.state.estimates,
                        &ground,
                    ),
                    _ => [0.0; DOF],
                };
                for (i, demand) in demands.iter_mut().enumerate() {
                    let prime = configuration.strokes[i].prime;
                    let x_dot = prime * input.zeta_dot[i];
                    demand.f_r =
                        Q[i] / prime + gains.pd_actuator_damping * (demand.x_r_dot - x_dot);
                }
                std::array::from_fn(|j| {
                    let error = required.zeta_dot[3 + j] - input.zeta_dot[3 + j];
                    Q[3 + j] + gains.pd_wrist_damping[j] * error
                })
            }
        };
        let machine = MachineLevel {
            desired,
            rotation_error,
            tip: tip.position,
            zeta_ddot_r: required.zeta_ddot.into(),
            strokes: configuration.strokes,
            motions,
            energy: errors.energy,
        };
        Ok((machine, tracking, demands, tau))
    }

    /// Numbers of measurements and settings far beyond any machine's overflow, in the commands or in what is told of them.
    fn finite(&self, output: &Output) -> Result<(), ControllerError> {
        let scalar = std::slice::from_ref;
        let signals: [(&'static str, &[f64]); 11] = [
            ("v_d", &output.v_d),
            ("v_q", &output.v_q),
            ("tau_wrist", &output.tau_wrist),
            ("f_required", &output.f_required),
            ("x_dot_required", &output.x_dot_required),
            ("nu_velocity", scalar(&output.nu_velocity)),
            ("nu_adaptation", scalar(&output.nu_adaptation)),
            ("nu_actuator", &output.nu_actuator),
            ("dissipation", scalar(&output.dissipation)),
            ("dissipation_actuator", &output.dissipation_actuator),
            ("force_error", &output.force_error),
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

    /// All outputs besides the wrist torques and the virtual power flows.
    fn fill(&self, settings: &Settings, input: &Input, now: &mut Evaluation) {
        let output = &mut now.output;
        output.v_d = now.commands.map(|c| c.v_d);
        output.v_q = now.commands.map(|c| c.v_q);
        output.i_q_required = now.commands.map(|c| c.i_qr);
        output.f_required = now.demands.map(|d| d.f_r);
        output.x_dot_required = now.demands.map(|d| d.x_r_dot);
        output.motion_end = self.motion_end(settings);
        output.load = self.carried(settings).unwrap_or_default();
        if let Some(machine) = &now.machine {
            let tip_error = machine.desired.position - machine.tip;
            output.desired_position = machine.desired.position.into();
            output.tip_error = tip_error.into();
            output.tip_error_norm = tip_error.norm();
            let q = machine.desired.orientation;
            output.desired_orientation = [q.w, q.i, q.j, q.k];
            let half_sine = 0.5 * machine.rotation_error.norm();
            output.orientation_error_norm = 2.0 * libm::asin(half_sine.min(1.0));
        }
        self.lyapunov_terms(settings, input, now);
    }

    /// The accompanying functions of the stability proof.
    fn lyapunov_terms(&self, settings: &Settings, input: &Input, now: &mut Evaluation) {
        let (gains, output) = (&settings.gains, &mut now.output);
        if let Some(machine) = &now.machine {
            output.nu_velocity = settings.true_inertia_scale * machine.energy;
            output.dissipation = 2.0 * gains.kappa_KA * machine.energy;
            for (k, estimate) in self.state.estimates.iter().enumerate() {
                let truth = self.nominal.inertia[k] * settings.true_inertia_scale;
                output.mass_hat[k] = estimate.inertia().m;
                output.nu_adaptation += gains.gamma * estimate.divergence(&truth);
            }
        }
        let actuators = self.nominal.actuators.each_ref().map(emla::Emla::params);
        let each = actuators.map(|p| Conditions::new(p, gains));
        let weakest = Conditions::weakest(each);
        if weakest.hold() {
            output.conditions = weakest; // else they are not defined, and stay 0
        }
        for i in 0..3 {
            let (p, conditions) = (actuators[i], &each[i]);
            let i_d_error = self.state.drives[i].i_dr - input.i_d[i];
            let force_error = now.commands[i].force_error;
            output.force_error[i] = force_error;
            output.nu_actuator[i] = conditions.accompanying(force_error, i_d_error);
            output.dissipation_actuator[i] =
                conditions.dissipation(p, gains, force_error, i_d_error);
        }
    }
}

/// What drive `i` measures.
pub(crate) fn measured(input: &Input, i: usize) -> Measured {
    Measured {
        i_d: input.i_d[i],
        i_q: input.i_q[i],
        w_m: input.w_m[i],
        F: input.F[i],
        v_dc: input.v_dc,
        T_winding: input.T_winding[i],
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Trajectory, reference};
    use emla::Surrogate;
    use machine::Machine;

    /// Joints, and the reference of the tip, on smooth ways; the orientations meet at t = 0, where the law's derivative is exact.
    fn at(machine: &Machine, t: f64) -> Input {
        let wave = |i: usize| (0.9 + 0.2 * i as f64, 0.4 * i as f64, 0.05 + 0.01 * i as f64);
        let zeta = |i: usize| {
            let (w, phase, size) = wave(i);
            machine.start.zeta[i] + size * ((w * t + phase).sin() - phase.sin())
        };
        let rate = |i: usize| {
            let (w, phase, size) = wave(i);
            size * w * (w * t + phase).cos()
        };
        let (position, [w, x, y, z]) =
            crate::tip_pose(machine, &machine.start.zeta).expect("works");
        let (v, a) = ([0.11, -0.06, 0.08], [-0.3, 0.2, 0.4]);
        let turning = Vector3::new(0.2, -0.1, 0.15);
        let q = reference::turn(turning * t).into_inner() * Quaternion::new(w, x, y, z);
        Input {
            zeta: std::array::from_fn(zeta),
            zeta_dot: std::array::from_fn(rate),
            reference_position: std::array::from_fn(|k| {
                position[k] + 0.01 + t * (v[k] + 0.5 * t * a[k])
            }),
            reference_velocity: std::array::from_fn(|k| v[k] + t * a[k]),
            reference_acceleration: a,
            reference_orientation: [q.w, q.i, q.j, q.k],
            reference_angular_velocity: turning.into(),
            ..Input::default()
        }
    }

    /// The required accelerations of rods and joints are the rates of the required velocities, with reference and machine in motion: central
    /// differences over 0.1 ms, which err by 1e-9 of the third derivatives and ε/δ.
    #[test]
    fn required_accelerations_are_rates_of_the_required_velocities() {
        let machine = Machine::reference();
        let mut settings = Settings {
            mode: Mode::Modular,
            ..Settings::of(&machine.controller)
        };
        (
            settings.gains.Lambda_position,
            settings.gains.Lambda_orientation,
        ) = (4.0, 3.0);
        let network = Surrogate::reference();
        let controller = Controller::new(
            &machine,
            &network,
            Trajectory::External,
            &settings,
            &at(&machine, 0.0),
            0.0,
        )
        .expect("works");
        let of = |t: f64| {
            let now = controller.evaluate(&settings, &at(&machine, t));
            now.expect("finite").demands
        };
        let d = 1e-4;
        let [before, now, after] = [-d, 0.0, d].map(of);
        for i in 0..3 {
            let rate = (after[i].x_r_dot - before[i].x_r_dot) / (2.0 * d);
            let error = (now[i].x_r_ddot - rate).abs();
            assert!(rate.abs() > 0.05, "{rate}");
            assert!(
                error < 1e-6 * rate.abs().max(1.0),
                "rod {}: {rate} m/s², off by {error:e}",
                i + 1
            );
        }
    }
}
