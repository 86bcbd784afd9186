//! Integration of the manipulator over one communication step of the FMU `Hdrm`: RK4 with substeps
//! that are shorter near contacts, with stiff friction and in fast motion.

use crate::plant::brakes::SLACK;
use crate::plant::input::Input;
use crate::plant::state::State;
use crate::plant::{Dynamics, Hdrm};
use crate::{DOF, Stroke};
use model_rules::{RATE_STEP, Seconds, substeps};
use nalgebra::Vector6;
use thiserror::Error;

/// Longest substep in free motion, s: RK4 loses some 3e-7 J of 400 J in 10 s of swinging.
const H_MAX: f64 = 1e-3;

/// Largest rotation of a joint per substep, rad, with whose fourth power RK4's relative energy
/// error grows; normal operation (0.3 rad/s) is far below.
const TURN_MAX: f64 = 4e-3;

/// Longest communication step, s: 10⁴ substeps, more in fast motion and in contact.
const STEP_MAX: f64 = 10.0;

/// Largest number of parts of a substep.
const DIVISION_MAX: u32 = 200;

/// Largest angle, rad, and rate, rad/s, of a joint, which only a diverging integration exceeds
/// (friction too stiff for the shortest substep, absurd forces).
const LARGEST: f64 = 1e9;

/// Why a step failed; the caller's state is unchanged.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum StepError {
    /// Unusable step size.
    #[error("t = {} s: step h = {} s must be finite, > 0 and at most {STEP_MAX} s", Seconds(*t), Seconds(*h))]
    BadStep {
        /// Start of the step, s.
        t: f64,
        /// Step, s.
        h: f64,
    },
    /// A joint angle or rate became too large, infinite or NaN.
    #[error("t = {} s: `{signal}` became {value:.3e}; its magnitude must be at most {LARGEST:e}", Seconds(*t))]
    NotFinite {
        /// Start of the step, s.
        t: f64,
        /// Signal and index.
        signal: &'static str,
        /// Its value.
        value: f64,
    },
}

impl Hdrm {
    /// The state after a step from `t` by `h`, both s; `input(s)` are the inputs at `t + s`.
    pub fn step(
        &self,
        state: &State,
        input: impl Fn(f64) -> Input,
        t: f64,
        h: f64,
    ) -> Result<State, StepError> {
        self.step_from(&self.dynamics_with(state, &input(0.0)), input, t, h)
    }

    /// [`Hdrm::step`] from known dynamics at its start.
    pub fn step_from(
        &self,
        start: &Dynamics,
        input: impl Fn(f64) -> Input,
        t: f64,
        h: f64,
    ) -> Result<State, StepError> {
        if !(h > 0.0 && h <= STEP_MAX) {
            return Err(StepError::BadStep { t, h });
        }
        let u = input(0.0);
        if !Self::is_unbraked(&start.state, &u) {
            return self.step_braked(start, &input, &u, t, h);
        }
        self.span(start, &input, [0.0, h], t)
    }

    /// A step in which brakes of the wrist close or act, as `u` commands: a span ends where one
    /// closes.
    #[cold]
    #[inline(never)]
    fn step_braked(
        &self,
        start: &Dynamics,
        input: &impl Fn(f64) -> Input,
        u: &Input,
        t: f64,
        h: f64,
    ) -> Result<State, StepError> {
        let mut now = self.after_braking(start.state, u, [0.0; 3]);
        let mut done = 0.0;
        while done < h {
            let awaited = self.awaited_brakes(&now, u).into_iter().flatten();
            let wait = awaited.fold(f64::INFINITY, f64::min);
            let end = if done + wait < h - SLACK {
                done + wait
            } else {
                h
            };
            let start = self.dynamics_with(&now, &input(done));
            let next = self.span(&start, input, [done, end], t)?;
            now = self.after_braking(next, u, [end - done; 3]);
            done = end;
        }
        Ok(now)
    }

    /// The state after the part of a step at `t` from `begin` to `end` s in it.
    fn span(
        &self,
        start: &Dynamics,
        input: &impl Fn(f64) -> Input,
        [begin, end]: [f64; 2],
        t: f64,
    ) -> Result<State, StepError> {
        let n = substeps(end - begin, H_MAX);
        let dt = (end - begin) / n;
        let mut now = self.substep(start, input, begin, dt);
        check_finite(&now, t)?;
        let mut k = 1.0;
        while k < n {
            let start = self.dynamics_with(&now, &input(begin + k * dt));
            now = self.substep(&start, input, begin + k * dt, dt);
            check_finite(&now, t)?;
            k += 1.0;
        }
        Ok(now)
    }

    /// One substep from `s` by `dt`, divided further in contact and in fast motion.
    fn substep(&self, start: &Dynamics, input: &impl Fn(f64) -> Input, s: f64, dt: f64) -> State {
        let n = self
            .contact_substeps(start, dt)
            .max(self.friction_substeps(start, dt))
            .max(self.brake_substeps(start, dt))
            .max(turning_substeps(&start.state, dt));
        let dt = dt / f64::from(n);
        let first = self.substep_part(start, input, s, dt);
        (1..n).fold(first, |now, k| {
            let s = s + f64::from(k) * dt;
            self.substep_part(&self.dynamics_with(&now, &input(s)), input, s, dt)
        })
    }

    /// One part of a substep: first the wrist's drives with the joints moving at their present
    /// rates, then the rest under their mean torques, which conserves momentum.
    fn substep_part(
        &self,
        start: &Dynamics,
        input: &impl Fn(f64) -> Input,
        s: f64,
        dt: f64,
    ) -> State {
        let Some(drive) = &self.wrist else {
            let mut next = self.rk4(start, input, s, dt);
            for (i, drive) in next.wrist.iter_mut().enumerate().filter(|(_, d)| d.holds) {
                let joint = [next.zeta[3 + i], next.zeta_dot[3 + i]];
                drive.angle = self.anchors[i].slid(drive, joint, dt);
            }
            return next;
        };
        let mut driven = start.clone();
        let (now, input_now) = (&start.state, input(s));
        driven.state.wrist = std::array::from_fn(|i| {
            let joint = [now.zeta[3 + i], now.zeta_dot[3 + i]];
            let command = self.wrist_command(&input_now, i);
            let torques = [command, self.tau_wrist_max[i], self.brake.torque[i]];
            drive.advance(i, &now.wrist[i], torques, joint, dt)
        });
        self.rk4(&driven, input, s, dt)
    }

    /// Number of parts of `dt` that resolve the contacts in reach; 1 without.
    fn contact_substeps(&self, start: &Dynamics, dt: f64) -> u32 {
        let State { zeta, zeta_dot, .. } = &start.state;
        let position = |i: usize| match start.strokes.get(i) {
            Some(&Stroke { x, prime, .. }) => (x, prime),
            None => (zeta[i], 1.0),
        };
        let is_near = |i: &usize| {
            let (y, prime) = position(*i);
            self.stops[*i].is_near(y, prime * zeta_dot[*i], dt)
        };
        let rate: f64 = (0..DOF)
            .filter(is_near)
            .map(|i| {
                let (y, prime) = position(i);
                let mobility = prime * prime * start.factor.mobility(i);
                self.stops[i].rate_ahead(y, prime * zeta_dot[i], mobility, dt)
            })
            .sum();
        parts(dt * (rate + self.plane_rate(start, dt)) / RATE_STEP)
    }

    /// Number of parts of `dt` that resolve the decay by joint friction; 1 with usual friction.
    fn friction_substeps(&self, start: &Dynamics, dt: f64) -> u32 {
        if !self.friction_is_stiff {
            return 1;
        }
        parts(dt * self.friction_rate(start) / RATE_STEP)
    }

    /// Number of parts of `dt` that resolve the swinging of braked joints; 1 without brakes.
    fn brake_substeps(&self, start: &Dynamics, dt: f64) -> u32 {
        let drives = &start.state.wrist;
        if self.wrist.is_some() || drives.iter().all(|drive| !drive.holds) {
            return 1;
        }
        let rate = |i: usize| self.anchors[i].fastest(start.factor.mobility(3 + i));
        let braked = (0..3).filter(|i| drives[*i].holds);
        parts(dt * braked.map(rate).fold(0.0, f64::max) / RATE_STEP)
    }

    /// Upper bound of the rates, 1/s, at which friction slows the joints: the trace of `M⁻¹·D`.
    fn friction_rate(&self, at: &Dynamics) -> f64 {
        (0..DOF)
            .map(|i| (self.joint_viscous[i] + self.joint_dry.steepest(i)) * at.factor.mobility(i))
            .sum()
    }

    /// Whether friction may require shorter substeps. The mobilities change with the pose by far
    /// less than the margin of 100.
    pub(crate) fn has_stiff_friction(&self, start: &Dynamics) -> bool {
        H_MAX * self.friction_rate(start) > 0.01 * RATE_STEP
    }

    /// Classical Runge–Kutta of fourth order.
    fn rk4(&self, start: &Dynamics, input: &impl Fn(f64) -> Input, s: f64, dt: f64) -> State {
        let State { zeta, zeta_dot, .. } = start.state;
        let (q, w) = (Vector6::from(zeta), Vector6::from(zeta_dot));
        // Acceleration, and the power dissipated by the contact.
        let rates = |at: &Dynamics, u: &Input| {
            (self.acceleration(at, u), self.contact_force(at).dissipation)
        };
        let at = |q: Vector6<f64>, w: Vector6<f64>, u: &Input| {
            let state = State {
                zeta: q.into(),
                zeta_dot: w.into(),
                ..start.state
            };
            rates(&self.dynamics_with(&state, u), u)
        };
        let [begin, middle, end] = [0.0, 0.5, 1.0].map(|part| input(s + part * dt));
        let half = 0.5 * dt;
        let (w1, (a1, p1)) = (w, rates(start, &begin));
        let w2 = w + a1 * half;
        let (a2, p2) = at(q + w1 * half, w2, &middle);
        let w3 = w + a2 * half;
        let (a3, p3) = at(q + w2 * half, w3, &middle);
        let w4 = w + a3 * dt;
        let (a4, p4) = at(q + w3 * dt, w4, &end);
        State {
            zeta: (q + (w1 + (w2 + w3) * 2.0 + w4) * (dt / 6.0)).into(),
            zeta_dot: (w + (a1 + (a2 + a3) * 2.0 + a4) * (dt / 6.0)).into(),
            contact_loss: start.state.contact_loss + (p1 + (p2 + p3) * 2.0 + p4) * (dt / 6.0),
            ..start.state
        }
    }
}

/// Number of parts of `dt` that keep each joint's rotation per part below [`TURN_MAX`].
fn turning_substeps(state: &State, dt: f64) -> u32 {
    let fastest = state.zeta_dot.iter().fold(0.0, |w: f64, z| w.max(z.abs()));
    parts(dt * fastest / TURN_MAX)
}

/// `number` rounded up, from 1 to [`DIVISION_MAX`].
fn parts(number: f64) -> u32 {
    (number.ceil() as u32).clamp(1, DIVISION_MAX)
}

fn check_finite(state: &State, t: f64) -> Result<(), StepError> {
    const ZETA: [&str; DOF] = [
        "zeta[1]", "zeta[2]", "zeta[3]", "zeta[4]", "zeta[5]", "zeta[6]",
    ];
    const ZETA_DOT: [&str; DOF] = [
        "zeta_dot[1]",
        "zeta_dot[2]",
        "zeta_dot[3]",
        "zeta_dot[4]",
        "zeta_dot[5]",
        "zeta_dot[6]",
    ];
    let signals = ZETA
        .iter()
        .zip(&state.zeta)
        .chain(ZETA_DOT.iter().zip(&state.zeta_dot));
    for (signal, &value) in signals {
        let is_motion = value.abs() <= LARGEST; // false for NaN
        if !is_motion {
            return Err(StepError::NotFinite { t, signal, value });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One part up to [`TURN_MAX`], then as many as it takes, up to [`DIVISION_MAX`].
    #[test]
    fn turns_are_divided() {
        let parts = |zeta_dot: f64| {
            let mut state = State::at_rest([0.0; DOF]);
            state.zeta_dot[2] = -zeta_dot;
            turning_substeps(&state, 0.5)
        };
        let limit = TURN_MAX / 0.5;
        assert_eq!([0.0, 0.9, 1.1, 2.9].map(|w| parts(w * limit)), [1, 1, 2, 3]);
        assert_eq!(parts(1e9), DIVISION_MAX);
    }

    /// Wherever a substep is divided, RK4 asks for the inputs at the start, the middle and the end
    /// of each part: of 2 ms with the elbow at 9 rad/s two substeps, each of three parts, so every
    /// sixth of a millisecond. Tolerance: rounding of times of a millisecond.
    #[test]
    fn inputs_are_asked_for_at_the_times_of_the_parts() {
        let machine = machine_file::Machine::reference();
        let plant = Hdrm::new(&machine, &crate::Options::from_machine(&machine))
            .expect("the reference machine");
        let mut state = State::at_rest(machine.start.zeta);
        state.zeta_dot[4] = 9.0;
        let asked = std::cell::RefCell::new(Vec::new());
        let input = |s: f64| {
            asked.borrow_mut().push(s);
            Input::default()
        };
        plant.step(&state, input, 0.0, 2e-3).expect("a step");
        let mut asked = asked.into_inner();
        asked.sort_by(f64::total_cmp);
        asked.dedup_by(|a, b| (*a - *b).abs() < 1e-15);
        let expected: Vec<f64> = (0..=12).map(|k| f64::from(k) * 2e-3 / 12.0).collect();
        assert_eq!(asked.len(), expected.len(), "{asked:?}");
        for (a, b) in asked.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-15, "{asked:?}");
        }
    }

    /// From a hundredth of the rate that a whole substep resolves friction counts; the reference
    /// machine's does not.
    #[test]
    fn friction_counts_from_a_hundredth_of_the_largest_rate() {
        let machine = machine_file::Machine::reference();
        let with = |factor: f64| {
            let options = crate::Options::from_machine(&machine);
            let options = crate::Options {
                joint_viscous: options.joint_viscous.map(|d| d * factor),
                ..options
            };
            let plant = Hdrm::new(&machine, &options).expect("valid");
            let start = plant.dynamics(&State::at_rest(machine.start.zeta));
            let share = H_MAX * plant.friction_rate(&start) / RATE_STEP;
            (share, plant.has_stiff_friction(&start))
        };
        let (share, is_stiff) = with(1.0);
        assert!(share > 0.0 && !is_stiff, "{share}");
        assert!(!with(0.009 / share).1);
        assert!(with(0.011 / share).1);
    }
}
