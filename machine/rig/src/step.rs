//! Integration over one communication step, for the FMU `Rig` and the studies.
//!
//! Each substep is a symmetric composition: half a substep of the bristles, exact at the present
//! speed and load; a whole one of everything else by the classical Runge–Kutta method with the
//! bristles held; the other half of the bristles. Its error is of second order in the substep and
//! only where bristles bend, of fourth order elsewhere. So bristles that relax in a tenth of a
//! millisecond (70 mm/s) or less set no limit to the substep. Substeps end where a switching period
//! ends or a brake closes.

use crate::conditions::Conditions;
use crate::state::Rates;
use crate::{Drive, Input, Rig, State};
use model_rules::{
    MAX_SUBSTEPS, RATE_STEP, RK4_STAGES, StepError, check_finite, check_step, substeps,
};

/// Longest substep, s: half a switching period of 8 kHz, which also resolves the electrical angle
/// to 5° at rated speed.
const DT_MAX: f64 = 62.5e-6;
/// Relative tolerance of time comparisons, for rounding.
const SLACK: f64 = 1e-3;

/// The substep was too long for the electrical frequency.
struct TooCoarse;

impl Rig {
    /// Longest substep for these parameters, s: less than [`DT_MAX`] where a mode is faster.
    pub(crate) fn longest_substep(&self) -> f64 {
        let (p, e) = (&self.p, &self.extra);
        let travel = self.travel();
        let nut = p.J_m / (travel * travel);
        let mass = match self.drive {
            Drive::Motion => nut,
            Drive::Force => 1.0 / (1.0 / nut + 1.0 / p.M_act),
        };
        let K = self.stiffness(0.0).0.max(self.stiffness(p.L_s).0);
        let C_link = if e.damping.on {
            p.C_b.max(e.damping.mount)
        } else {
            p.C_b
        };
        let (half, square) = (0.5 * (C_link + p.C_act) / mass, K / mass);
        let rod = half + (half * half - square).max(0.0).sqrt();
        let L = p.L_d.min(p.L_q * (1.0 - e.saturation.share).powi(2));
        let f_sw = p.inverter.map_or(0.0, |inverter| inverter.f_sw);
        let v_dc = p.inverter.map_or(0.0, |inverter| inverter.v_dc);
        let dead = 4.0 / 3.0 * e.switching.dead_time * f_sw * v_dc / e.switching.i_0;
        let fastest = rod
            .max(square.sqrt())
            .max((p.R_s + if e.switching.on { dead } else { 0.0 }) / L)
            .max((p.C_m + p.tau_C / p.w_C) / p.J_m)
            .max((e.friction.damping + C_link) / nut);
        DT_MAX.min(RATE_STEP / fastest)
    }

    /// The state a time `h`, s, after `s`, with the inputs `u` held, except that the rod of
    /// [`Drive::Motion`] moves with its velocity. `t`, s, is used in error messages only.
    pub fn step(&self, s: &State, u: &Input, t: f64, h: f64) -> Result<State, StepError> {
        let bad_step = StepError::BadStep { t, h };
        check_step(t, h)?;
        let begun = &self.update_gates(s, u);
        let mut dt_max = self.dt_max;
        while h <= MAX_SUBSTEPS * dt_max {
            match self.attempt(begun, u, h, dt_max) {
                Ok(mut next) => {
                    next.mean = next.energy.mean_since(&s.energy, h);
                    next.i_dc_mean =
                        machine_file::link_current(next.mean.supplied, self.link_voltage(u));
                    next.check_finite(t)?;
                    // Powers are products and can overflow even if the states are finite.
                    let lost = self.output(&next, &u.moved(h)).P_loss;
                    check_finite(t, [("P_loss", lost)])?;
                    return Ok(next);
                }
                Err(TooCoarse) => dt_max *= 0.25,
            }
        }
        Err(bad_step)
    }

    /// The step with substeps of at most `dt_max`, s.
    fn attempt(&self, start: &State, u: &Input, h: f64, dt_max: f64) -> Result<State, TooCoarse> {
        let mut s = State {
            F_mean: 0.0,
            ..*start
        };
        let gates = u.enable && !start.tripped;
        let mut done = 0.0;
        while h - done > SLACK * dt_max.min(h) {
            let mut span = h - done;
            if let Some(wait) = self.awaited_brake(&s, u).filter(|wait| *wait > 0.0) {
                span = span.min(wait);
            }
            if let Some(T) = self.switching_period().filter(|_| gates) {
                if s.hold.left <= SLACK * dt_max.min(T) {
                    let requested = self.requested_voltage(&mut s, u, T);
                    s.hold = self.next_period(&s.hold, requested, s.theta_m, s.w_m, T);
                }
                span = span.min(s.hold.left);
                s.hold.left -= span;
            }
            let braked = self.braked_after(&s, u, span);
            let n = substeps(span, dt_max);
            let dt = span / n;
            for k in 0..n as u32 {
                s = self.substep(&s, u, done + f64::from(k) * dt, dt);
                let turned = f64::from(self.p.p) * s.w_m.abs() * dt;
                if turned > RATE_STEP {
                    return Err(TooCoarse);
                }
            }
            s.braked = braked;
            done += span;
        }
        s.F_mean /= h;
        s.lead = f64::from(self.delay) * h;
        Ok(s)
    }

    /// One substep of length `dt`, a time `t` after the start of the step.
    fn substep(&self, s: &State, u: &Input, t: f64, dt: f64) -> State {
        let mut next = self.advance_bristles(s, &u.moved(t), 0.5 * dt);
        let held = self.conditions(&next, &u.moved(t));
        next = self.stop_if_reversed(self.rk4(&next, u, &held, t, dt), &held);
        self.advance_bristles(&next, &u.moved(t + dt), 0.5 * dt)
    }

    /// The state with the bristles advanced by `dt`, s.
    fn advance_bristles(&self, s: &State, u: &Input, dt: f64) -> State {
        if !self.extra.friction.on {
            return *s;
        }
        let F_nut = self.link_at(s, u).0.force;
        State {
            z: self.deflection_after(s.z, self.travel() * s.w_m, F_nut, dt),
            ..*s
        }
    }

    /// One classical Runge–Kutta step. A loop, so that the rates are compiled once.
    fn rk4(&self, s: &State, u: &Input, held: &Conditions, t: f64, dt: f64) -> State {
        let mut next = *s;
        let mut rates = Rates::default();
        for (share, weight) in RK4_STAGES {
            let at = share * dt;
            rates = self.rates(&s.plus(at, &rates), &u.moved(t + at), held);
            next = next.plus(weight * dt, &rates);
        }
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Extras;
    use machine_file::Machine;

    /// Oracle: a drag `V w²` so strong that a substep of h does not resolve it. Runge–Kutta then
    /// multiplies the speed by a polynomial of z = V h/J ≈ 1e12, whose last term z⁴/24 is all that
    /// counts: the one before it is 4/z of that. In the stages the speed stays 6/z below, so that
    /// powers and energies on the way are finite. The losses at the end are finite or not as V
    /// says.
    #[test]
    fn a_step_to_losses_beyond_all_numbers_is_refused() {
        let (t, h, w) = (0.5, 1e-100, 1e99);
        for part in [0.9, 1.1] {
            let V = part * (f64::MAX / w / w);
            let mut extras = Extras::AS_BUILT.off();
            (extras.friction.on, extras.friction.gear_viscous) = (true, V);
            let p = Machine::reference().emla.lift;
            let rig = Rig::new(p, extras, Drive::Motion).expect("valid parameters");
            let u = Input {
                x: 0.3,
                ..Input::default()
            };
            let z = V * h / rig.inertia();
            let start = State {
                w_m: 24.0 * w / z.powi(4),
                ..rig.start(&u, [293.15; 2]).expect("rest")
            };
            let end = rig.step(&start, &u, t, h);
            if part > 1.0 {
                let (signal, value) = ("P_loss", f64::INFINITY);
                assert_eq!(end, Err(StepError::NotFinite { t, signal, value }));
                continue;
            }
            let lost = rig.output(&end.expect("finite"), &u.moved(h)).P_loss;
            assert!((lost / f64::MAX / part - 1.0).abs() < 1e-9, "{lost:e}");
        }
    }
}
