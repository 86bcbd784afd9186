//! Integration over one communication step: the classical Runge–Kutta method within a mode, and events where a mode ends.
//!
//! Each substep is tried in its mode. Where its guard is positive at the end, the mode ended inside: the instant is found by the Illinois
//! variant of the secant rule on the length of the substep, to [`SHARP`] of it; the rest of the substep goes on in the new mode.

use crate::circuit::{Mode, Point};
use crate::{DcLink, Energies, Input, Params, State};
use thiserror::Error;

/// Longest substep in units of the fastest time constant. The method errs by at most `z⁴ e^(z−1)/120` of a step response, 7e-7 here.
const SUBSTEP: f64 = 0.12;
/// Most substeps in one step.
const MAX_SUBSTEPS: f64 = 1e6;
/// Part of a substep to which an event is located.
const SHARP: f64 = 1e-13;
/// Most events in one substep that are located; what comes after is taken at the end of the substep.
const MAX_EVENTS: u32 = 64;
/// Most iterations for one event.
const MAX_ITERATIONS: u32 = 60;

/// Why a step could not be completed; the caller's state is untouched.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum StepError {
    /// The step itself is unusable.
    #[error("t = {t} s: step h = {h} s must be finite, > 0 and at most 10⁶ substeps long")]
    BadStep {
        /// Start of the step, s.
        t: f64,
        /// Length of the step, s.
        h: f64,
    },
    /// A quantity became infinite or NaN.
    #[error("t = {t} s: `{signal}` became {value}; it must be finite")]
    NotFinite {
        /// Start of the step, s.
        t: f64,
        /// What became infinite or undefined.
        signal: &'static str,
        /// Its value.
        value: f64,
    },
}

/// Longest substep for these parameters, s.
pub(crate) fn longest_substep(p: &Params) -> f64 {
    let (b, link) = (&p.battery, &p.link);
    let mut fastest = link.C * (b.R_0 + link.R);
    if p.brake.fitted {
        fastest = 1.0 / (1.0 / fastest + 1.0 / (link.C * p.brake.R));
    }
    for k in [0, 1] {
        if b.R[k] > 0.0 {
            fastest = fastest.min(b.tau[k]);
        }
    }
    SUBSTEP * fastest
}

impl DcLink {
    /// The state a time `h` after `s`, both s, under the inputs `u`, which are held. `t` only names the time in an error.
    ///
    /// # Errors
    /// An unusable step, or a result that is not finite.
    pub fn step(&self, s: &State, u: &Input, t: f64, h: f64) -> Result<State, StepError> {
        let n = (h / self.dt_max).ceil();
        if !(h.is_finite() && h > 0.0 && n <= MAX_SUBSTEPS) {
            return Err(StepError::BadStep { t, h });
        }
        let dt = h / n;
        let i_load = u.load();
        let mut x = Point::of(s);
        let mut mode = self.mode(&mut x, s.mode, i_load); // the inputs may have jumped
        for _ in 0..n as u32 {
            self.substep(&mut x, &mut mode, u, i_load, dt);
        }
        let next = State {
            soc: x.soc,
            v: x.v,
            v_c: x.v_c,
            T: x.T,
            mode,
            energy: Energies {
                battery: s.energy.battery + x.battery,
                load: s.energy.load + i_load * x.flux,
                brake: s.energy.brake + x.brake,
                loss: s.energy.loss + x.loss,
            },
            v_mean: x.flux / h,
        };
        match next.not_finite() {
            None => Ok(next),
            Some((signal, value)) => Err(StepError::NotFinite { t, signal, value }),
        }
    }

    fn substep(&self, x: &mut Point, mode: &mut Mode, u: &Input, i_load: f64, dt: f64) {
        let mut left = dt;
        for _ in 0..MAX_EVENTS {
            let end = self.rk4(x, *mode, u, i_load, left);
            if self.guard(&end, *mode, i_load) <= 0.0 {
                *x = end;
                return;
            }
            let (event, at) = self.located(x, *mode, u, i_load, left);
            *x = at;
            *mode = self.mode(x, *mode, i_load);
            left -= event;
            if left <= SHARP * dt {
                return;
            }
        }
        *x = self.rk4(x, *mode, u, i_load, left);
        *mode = self.mode(x, *mode, i_load);
    }

    /// Where the mode ends within `dt`, s after `x`, and the point there, just past the event.
    fn located(&self, x: &Point, mode: Mode, u: &Input, i_load: f64, dt: f64) -> (f64, Point) {
        let guard = |h: f64| {
            let at = self.rk4(x, mode, u, i_load, h);
            (self.guard(&at, mode, i_load), at)
        };
        let (mut low, mut below) = (0.0, self.guard(x, mode, i_load));
        let (mut high, (mut above, mut point)) = (dt, guard(dt));
        let mut last = 0;
        for _ in 0..MAX_ITERATIONS {
            if high - low <= SHARP * dt {
                break;
            }
            // Never nearer to an end than half of what is asked for, so that the bracket closes from both sides.
            let margin = 0.5 * SHARP * dt;
            let secant = high - above * (high - low) / (above - below);
            let h = secant.max(low + margin).min(high - margin);
            let (value, at) = guard(h);
            if value > 0.0 {
                (high, above, point) = (h, value, at);
                below *= if last == 1 { 0.5 } else { 1.0 };
                last = 1;
            } else {
                (low, below) = (h, value);
                above *= if last == -1 { 0.5 } else { 1.0 };
                last = -1;
            }
        }
        (high, point)
    }

    fn rk4(&self, x: &Point, mode: Mode, u: &Input, i_load: f64, h: f64) -> Point {
        let rates = |x: &Point| self.rates(x, mode, i_load, u.T_ambient);
        let k_1 = rates(x);
        let k_2 = rates(&x.moved(&k_1, 0.5 * h));
        let k_3 = rates(&x.moved(&k_2, 0.5 * h));
        let k_4 = rates(&x.moved(&k_3, h));
        let outer = k_1.moved(&k_4, 1.0);
        let inner = k_2.moved(&k_3, 1.0);
        x.moved(&outer.moved(&inner, 2.0), h / 6.0)
    }
}

impl State {
    fn not_finite(&self) -> Option<(&'static str, f64)> {
        let signals = [
            ("soc", self.soc),
            ("v_1", self.v[0]),
            ("v_2", self.v[1]),
            ("v_dc", self.v_c),
            ("T_battery", self.T),
            ("energy.battery", self.energy.battery),
            ("energy.load", self.energy.load),
            ("energy.brake", self.energy.brake),
            ("energy.loss", self.energy.loss),
        ];
        signals.into_iter().find(|(_, value)| !value.is_finite())
    }
}
