//! Advances the controller's state over a communication step, for the FMU: in one interval, from
//! sample to sample, or with delayed commands.

use super::Controller;
use crate::bodies::HookReadings;
use crate::drive::{DriveState, Reading, VoltageLaw};
use crate::error::{ControllerError, STEP_MAX};
use crate::evaluation::{Evaluation, MachineLevel};
use crate::law::{self, TurningJoint};
use crate::measured::{DELAY_MAX, SAMPLES_MAX, SLACK, Timing, predict};
use crate::nominal::Nominal;
use crate::reference::{Motion, Reference, Target, feedback_at_rest};
use crate::settings::{Level, Settings};
use crate::signals::Input;
use crate::state::State;
use crate::supervisor::{CLOSING, Cause, Moment, Observed, Stage};
use crate::tracking::at_joints;
use emla::maps;
use machine_file::Controller as Gains;

impl Controller {
    /// Advances from the communication point `t` by `h`, both s, with the measurements held; `now`
    /// is the evaluation of the present state and `input`. On error the state is unchanged.
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
        let omega = settings.gains.omega_speed;
        let input = &self.state.joints.with_observed_rates(input, omega);
        let evaluated = self.state.motion_time(settings.gains.settle_time);
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
        if let (true, Some(machine)) = (omega > 0.0, &now.machine) {
            let (zeta, rate) = (&input.zeta, &input.zeta_dot);
            let joints = &mut self.state.joints;
            *joints = joints.advanced(zeta, rate, &machine.zeta_ddot_r, omega, h);
        }
        self.learn_lap(now, settings, evaluated, h);
        self.take_over_load(settings);
        Ok(())
    }

    /// Learns from the error of `now`, which was evaluated `t` s after the reference's start, over the step
    /// `h`, s.
    fn learn_lap(&mut self, now: &Evaluation, settings: &Settings, t: f64, h: f64) {
        let (Some(laps), Some(machine)) = (&mut self.laps, &now.machine) else {
            return;
        };
        let counts = self.state.supervisor.stage() < Stage::Frozen
            && !now.is_at_limit(&self.nominal.tau_wrist_max)
            && !now.is_at_force_limit();
        let age = settings.gains.reading_age;
        let error = machine.desired.earlier(age).position - machine.tip;
        laps.add(settings.learning, counts, &error, t - age, h);
    }

    /// Sets the known load to that of the path, if the settings allow.
    #[inline]
    fn take_over_load(&mut self, settings: &Settings) {
        if settings.load_known && settings.level == Level::Machine {
            let t = self.state.motion_time(settings.gains.settle_time);
            let load = self.reference.load(t);
            if let Some(load) = load.filter(|load| load != self.state.bodies.load()) {
                self.set_load(&load);
            }
        }
    }

    /// Advances all states except the joint observer's and the samples by `h` s, with the
    /// measurements and commands of `now` held.
    fn advance(&mut self, now: &Evaluation, settings: &Settings, input: &Input, h: f64) {
        let settings = &*self.effective_settings(settings);
        let Self {
            nominal,
            reference,
            state,
            ..
        } = self;
        let is_blocked = state.motion.is_blocked();
        if let Some(machine) = &now.machine {
            let before = feedback_at_rest(state.standstill.share());
            let lacking = machine.lacking(&input.zeta_dot);
            state.standstill.advance(&machine.desired, &lacking, h);
            if reference.rates().is_none() {
                // Keeps Λ z, which the integral contributes to the required rates.
                let after = feedback_at_rest(state.standstill.share());
                state
                    .integral
                    .fixed_rows_mut::<3>(0)
                    .scale_mut(before / after);
            }
            let is_empty = machine.weighing.as_ref().is_some_and(|hook| {
                let felt = HookReadings {
                    torque: now.output.tau_wrist,
                    rate: [3, 4, 5].map(|j| input.zeta_dot[j]),
                    booms: [1, 2].map(|i| machine.strokes[i].prime * input.F[i]),
                };
                state.bodies.weigh(&felt, hook, h)
            });
            let is_excited = !state.standstill.teaches_nothing();
            let may_learn = is_excited && !is_empty && !now.is_at_force_limit();
            if may_learn && !is_blocked && state.supervisor.stage() < Stage::Frozen {
                let law = settings.mode.law();
                law.learn(&mut state.bodies, &machine.motions, &settings.gains, h);
            }
        }
        let is_at_limit = is_blocked || now.is_at_limit(&nominal.tau_wrist_max);
        if let (Some(machine), false) = (&now.machine, is_at_limit) {
            for (i, rate) in machine.law_integral_rate.into_iter().enumerate() {
                let prime = machine.strokes.get(i).map(|stroke| stroke.prime);
                if !prime.is_some_and(|prime| now.pushes_beyond_limit(i, rate / prime)) {
                    state.law_integral[i] += h * rate;
                }
            }
            let rests = state.standstill.share() > 0.0;
            if !rests && state.supervisor.stage() < Stage::Frozen {
                learn_friction(state, nominal, &settings.gains, machine, input, h);
            }
        }
        let is_braked = state.supervisor.stage() >= Stage::Braking;
        let rests =
            is_braked || is_at_limit || (0..3).any(|i| now.pushes_beyond_limit(i, now.push[i]));
        now.errors.advance(&mut state.integral, rests, h);
        if state.supervisor.stage() != Stage::Off {
            supervise(nominal, reference, state, settings, now, input, h);
        }
        if let Some(rates) = reference.rates() {
            let command = settings.rate_command;
            let bounds = law::reference_bounds(
                nominal,
                &state.bodies,
                &settings.gains,
                input,
                &state.motion.zeta.into(),
                rates.largest(),
            );
            rates.advance(&mut state.motion, &nominal.tree, command, input, &bounds, h);
        }
        for (i, drive) in state.drives.iter_mut().enumerate() {
            let law = VoltageLaw {
                actuator: &nominal.actuators[i],
                settings,
            };
            law.advance(drive, &Reading::from_input(input, i), &now.commands[i], h);
        }
    }

    /// A step with a sample time and without delay: measurements are held from one sample to the
    /// next; a sample inside the step takes `input`.
    fn step_sampled(
        &mut self,
        now: &Evaluation,
        settings: &Settings,
        input: &Input,
        t: f64,
        h: f64,
    ) -> Result<(), ControllerError> {
        let T = self.timing.sample_time;
        if h > SAMPLES_MAX * T {
            return Err(ControllerError::BadStep { t, h });
        }
        let before = self.state.clone();
        let (end, slack) = (t + h, SLACK * T);
        let mut now = *now;
        loop {
            let sampling = &mut self.state.sampling;
            let measured = *sampling.held.get_or_insert(*input);
            let next = self
                .timing
                .sample_instant(self.state.t_start, sampling.count + 1);
            if next > end + slack {
                return Ok(());
            }
            self.advance(&now, settings, &measured, T);
            self.state.t = next;
            self.state.sampling.count += 1;
            self.state.sampling.held = None;
            if next >= end - slack {
                return Ok(());
            }
            match self.evaluate(settings, input) {
                Ok(inside) => now = inside,
                Err(error) => {
                    self.state = before;
                    return Err(error);
                }
            }
        }
    }

    /// A step with delay: the next outputs are computed for the time at which they will act, from
    /// measurements predicted over the delay with the commands that act until then.
    fn step_delayed(
        &mut self,
        now: &Evaluation,
        settings: &Settings,
        input: &Input,
        t: f64,
        h: f64,
    ) -> Result<(), ControllerError> {
        let T = self.timing.sample_time;
        let delay = self.timing.delay.min(DELAY_MAX) as usize;
        let mut sampling = self.state.sampling;
        sampling.plan(delay, now.plan());
        let due = self
            .timing
            .sample_instant(self.state.t_start, sampling.count);
        if T == 0.0 || t >= due - SLACK * T {
            let (mut ahead, mut lead) = sampling.first(input, h);
            for planned in sampling.planned(delay) {
                ahead = predict(&self.nominal, settings.alpha, &ahead, planned, lead, t, h)?;
                lead = 0.0;
            }
            let acts = t + delay as f64 * h;
            let measured = *sampling.held.as_ref().unwrap_or(input);
            self.advance(now, settings, &measured, (acts - self.state.t).max(0.0));
            self.state.t = acts;
            sampling.hold(ahead);
        }
        sampling.pass();
        self.state.sampling = sampling;
        Ok(())
    }
}

/// Time after the start within which an empty hook sets off, s; what moves before does not count.
const SETS_OFF: f64 = 0.1;

/// Current of rod `i` that holds its load and takes its motor's momentum while the brake closes, A:
/// ```text
/// i_qr − J w_m/(T k_t)
/// ```
/// A speed beyond the rated one is a sensor's.
fn closing_current(nominal: &Nominal, i: usize, i_qr: f64, input: &Input) -> f64 {
    let p = nominal.parameters()[i];
    let largest = nominal.ratings[i][1] / maps::travel_per_radian(p);
    let momentum = maps::inertia(p, 1.0) * input.w_m[i].clamp(-largest, largest);
    let per_current = maps::torque(p, 0.0, 1.0);
    (i_qr - momentum / (CLOSING * per_current)).clamp(-p.i_max, p.i_max)
}

/// Advances what is known of the wrist's friction by `h` s, if the law compensates it. Where the
/// reference stands, joints that stick tell of a load only.
fn learn_friction(
    state: &mut State,
    nominal: &Nominal,
    gains: &Gains,
    machine: &MachineLevel,
    input: &Input,
    h: f64,
) {
    let Some(inertia) = &machine.wrist_inertia else {
        return;
    };
    let lacking = machine.lacking(&input.zeta_dot);
    let joints = std::array::from_fn(|j| TurningJoint {
        required: machine.zeta_dot_r[3 + j],
        lacking: lacking[3 + j],
        inertia: inertia[j],
        tau_max: nominal.tau_wrist_max[j],
    });
    let moves = machine.desired.is_moving();
    (state.wrist_friction).learn(gains.omega_friction, moves, &joints, h);
}

/// Advances the supervisor by `h` s, and applies a new stage to the rest of the state.
fn supervise(
    nominal: &Nominal,
    reference: &Reference,
    state: &mut State,
    settings: &Settings,
    now: &Evaluation,
    input: &Input,
    h: f64,
) {
    let (supervisor, ratings) = (&mut state.supervisor, &nominal.ratings);
    let before = supervisor.stage();
    if before < Stage::Braking {
        let currents =
            std::array::from_fn(|i| closing_current(nominal, i, now.output.i_q_required[i], input));
        supervisor.average_commands(&now.output.tau_wrist, &currents, h);
    }
    let tripped = (input.tripped.iter().any(|tripped| *tripped)).then_some(Cause::Tripped);
    // An empty hook sets off with the moment of the nominal payload, until it is found empty; the
    // lighter the payload, the later.
    let sets_off =
        now.weighs() && (state.t - state.t_start < SETS_OFF || state.bodies.feels_empty_hook());
    if sets_off {
        supervisor.forget_swings();
    }
    let plausibility = now.plausibility(state.motion.are_blocked());
    let moment = plausibility.as_ref().map(|now| Moment {
        now,
        nominal,
        settings,
        input,
        is_hook_empty: state.bodies.is_hook_empty(),
        h,
    });
    let implausible = supervisor.monitor(moment.as_ref().filter(|_| !sets_off));
    let observed = Observed {
        errors: now.rod_errors(&input.F),
        is_overloaded: now.is_overloaded(&input.F, ratings),
        alarm: tripped.or(implausible),
        reset: input.reset,
        is_supplied: !input.supply_missing,
    };
    let Some(fall) = supervisor.advance(&observed, ratings, state.t, h) else {
        return;
    };
    // Keeps Λ z, which the integral contributes to the required rates.
    state.integral *= fall;
    let stage = state.supervisor.stage();
    if before == Stage::Stopped || stage < before {
        // Ready again after a reset: first held on closed brakes, then released.
        state.supervisor.stand_at(&input.zeta);
        for (i, drive) in state.drives.iter_mut().enumerate() {
            let rest = DriveState::undisturbed(nominal.parameters()[i], input.w_m[i]);
            *drive = rest.settled(now.commands[i].i_qr);
        }
        if stage == Stage::Watching && reference.rates().is_some() {
            state.motion = Motion::rest(&input.zeta);
            state.supervisor.follow_reference();
        }
        return;
    }
    if stage >= Stage::Stopping && before < Stage::Stopping {
        let gains = &settings.gains;
        let t = state.motion_time(gains.settle_time);
        let held = (state.supervisor.motion()).map(|motion| Target::from_joints(motion, nominal));
        let target = held.map_or_else(|| reference.target(nominal, &state.motion, input, t), Ok);
        let [zeta_dot, integral] = target
            .map(|target| at_joints(&target, nominal, gains, &state.integral, &input.zeta))
            .unwrap_or_default();
        state.integral = integral;
        state.supervisor.begin_stop(input.zeta.into(), zeta_dot);
    }
    if stage >= Stage::Braking {
        state.supervisor.brake_at(&input.zeta);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use emla::Surrogate;
    use machine_file::Machine;

    /// The current beyond that of the load stops the motor within the 50 ms; the speed of a sensor that
    /// failed counts as the rated one, and the drive's largest current is not exceeded.
    #[test]
    fn a_closing_brake_is_helped_by_its_drive() {
        let nominal = Nominal::new(&Machine::reference(), &Surrogate::reference()).expect("valid");
        let p = nominal.parameters()[1];
        let current = |i_qr: f64, w_m: f64| {
            let input = Input {
                w_m: [0.0, w_m, 0.0],
                ..Input::default()
            };
            closing_current(&nominal, 1, i_qr, &input)
        };
        assert_eq!(current(12.0, 0.0), 12.0);
        let torque = maps::torque(p, 0.0, 12.0 - current(12.0, 20.0));
        let slowed = torque / maps::inertia(p, 1.0) * CLOSING;
        assert!((slowed - 20.0).abs() < 1e-12, "{slowed}");
        assert_eq!(current(12.0, 1e6), current(12.0, 1e9));
        assert_eq!(current(-99.0, 150.0), -p.i_max);
    }
}
