//! The drive's own current loop on an inverter without delay: a PI regulator that samples once a
//! switching period and holds its voltages in rotor coordinates until the next sample.

use crate::actuator::Emla;
use crate::motor;
use crate::state::State;
use limits::{MAX_SUBSTEPS, StepError, check_step};
use machine::{ActuatorInput as Input, CurrentLoop, Dq, link_current};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Part of a span by which it may be missed: clocks are off by rounding.
const SLACK: f64 = 1e-3;

/// State of the current loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Regulator {
    /// Integrals of both axes, V.
    pub integral: [f64; 2],
    /// Voltages that are held until the next sample, V.
    pub held: [f64; 2],
    /// Time to the next sample in [`Emla::step`], s.
    pub left: f64,
}

impl Emla {
    /// How often the drive's own current loop samples, s; None: it has none.
    pub fn sampling_period(&self) -> Option<f64> {
        let f_sw = self.p.inverter.map_or(0.0, |inverter| inverter.f_sw);
        self.electric.current_loop.map(|_| 1.0 / f_sw)
    }

    /// The inputs, or the direction `u` of them, with the voltages that act in state `s`.
    pub(crate) fn acting<'a>(&self, s: &State, u: &'a Input) -> Cow<'a, Input> {
        if self.electric.current_loop.is_none() {
            return Cow::Borrowed(u);
        }
        let [v_d, v_q] = s.regulator.held;
        Cow::Owned(Input { v_d, v_q, ..*u })
    }

    /// The state after a sample of the current loop.
    #[must_use]
    pub fn sampled(&self, s: &State, u: &Input) -> State {
        let mut next = *s;
        if let (Some(gains), Some(T)) = (self.electric.current_loop, self.sampling_period()) {
            let e = CurrentLoop::lack(s.point().current(), u.i_q_required, self.p.i_max);
            let largest = self.p.largest_voltage(self.link_voltage(u));
            let integral = &mut next.regulator.integral;
            let v = gains.voltage(integral, e, T, |v| v.limited(largest));
            next.regulator.held = [v.d, v.q];
        }
        next
    }

    /// The loop in steady motion with these currents at this motor speed: its integrals hold the
    /// voltage.
    pub(crate) fn steady(p: &machine::Emla, i: Dq, w_m: f64) -> Regulator {
        let (lambda, w_e) = (motor::flux(p, i), f64::from(p.p) * w_m);
        let v = [p.R_s * i.d - w_e * lambda.q, p.R_s * i.q + w_e * lambda.d];
        Regulator {
            integral: v,
            held: v,
            left: 0.0,
        }
    }

    /// [`Emla::step`] of a drive that samples its currents each `T` s: from sample to sample.
    pub(crate) fn step_sampled(
        &self,
        s: &State,
        input: impl Fn(f64) -> Input,
        T: f64,
        (t, h): (f64, f64),
    ) -> Result<State, StepError> {
        check_step(t, h)?;
        if h > MAX_SUBSTEPS * T {
            return Err(StepError::BadStep { t, h });
        }
        let (mut next, mut done, mut impulse) = (*s, 0.0, 0.0);
        while h - done > SLACK * T.min(h) {
            let u = input(done);
            if next.regulator.left <= SLACK * T {
                next = self.sampled(&next, &u);
                next.regulator.left += T;
            }
            let span = next.regulator.left.min(h - done);
            let left = next.regulator.left - span;
            let [v_d, v_q] = next.regulator.held;
            let held = |since: f64| Input {
                v_d,
                v_q,
                ..input(done + since)
            };
            next = self.step_held(&next, held, t, span)?;
            next.regulator.left = left;
            impulse += span * next.F_mean;
            done += span;
        }
        next.F_mean = impulse / h;
        next.P_in_mean = (next.energy.supplied - s.energy.supplied) / h;
        next.i_dc_mean = link_current(next.P_in_mean, self.link_voltage(&input(0.0)));
        next.lead = f64::from(self.delay) * h;
        Ok(next)
    }
}
