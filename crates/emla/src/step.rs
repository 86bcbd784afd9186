//! Integration over one communication step: classical Runge–Kutta with a fixed substep.

use crate::dynamics::{Rates, State};
use crate::input::InputPath;
use crate::maps;
use crate::{Drive, Emla};
use thiserror::Error;

/// Longest substep with the rod's motion prescribed, s: 4 substeps per millisecond.
const DT_MAX_MOTION: f64 = 0.25e-3;
/// Longest substep with a free rod, s.
const DT_MAX_FORCE: f64 = 0.125e-3;
/// Largest `rate·dt` of a linear mode. RK4 is stable to 2.78 on the real and 2.83 on the imaginary
/// axis; 1 keeps it accurate too.
const RATE_STEP: f64 = 1.0;
/// Most substeps in one step, half a second of computing. Normal operation takes 4 to 12 per millisecond.
const MAX_SUBSTEPS: f64 = 1e6;

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

/// Rate of the faster mode of a mass `m` on spring `k` and damper `c`, 1/s.
fn fast_rate(m: f64, c: f64, k: f64) -> f64 {
    let (half, w2) = (0.5 * c / m, k / m);
    let discriminant = half * half - w2;
    if discriminant > 0.0 {
        half + discriminant.sqrt()
    } else {
        w2.sqrt()
    }
}

/// Longest substep for these parameters, s: the fixed limit, or less where a mode is faster.
pub(crate) fn longest_substep(p: &machine::Emla, drive: Drive) -> f64 {
    let travel = maps::travel_per_radian(p);
    let nut_mass = p.J_m / (travel * travel);
    let K_max = maps::stiffness(p, 0.0).max(maps::stiffness(p, p.L_s));
    let (fixed, mass) = match drive {
        Drive::Motion => (DT_MAX_MOTION, nut_mass),
        Drive::Force => (DT_MAX_FORCE, 1.0 / (1.0 / nut_mass + 1.0 / p.M_act)),
    };
    let rate = fast_rate(mass, p.C_b + p.C_act, K_max)
        .max(p.R_s / p.L_d.min(p.L_q))
        .max(maps::motor_friction_slope(p, 0.0) / p.J_m);
    fixed.min(RATE_STEP / rate)
}

/// What one attempt at a step came to.
enum Attempt {
    Done(State),
    /// The electrical mode turned faster than the substep resolves, at this motor speed in rad/s
    /// (or not a number).
    TooCoarse(f64),
}

impl Emla {
    /// The state a time `h` after `s`, both times s. `path` gives the inputs in between; `t` only names the
    /// time in an error.
    ///
    /// The substep shrinks (the whole step is taken again) when `p·|w_m|·dt` exceeds 1, at more than
    /// three times the reference motor's rated speed: with any bounded voltage and motion the currents
    /// stay on the stable side of RK4.
    ///
    /// # Errors
    /// An unusable step, or a result that is not finite.
    pub fn step(&self, s: &State, path: &InputPath, t: f64, h: f64) -> Result<State, StepError> {
        let bad_step = StepError::BadStep { t, h };
        if !(h.is_finite() && h > 0.0) {
            return Err(bad_step);
        }
        // 1e-9: a step that is a whole number of substeps up to rounding gets that number.
        let mut n = (h / self.dt_max - 1e-9).ceil().max(1.0);
        let mut last = s.w_m;
        while n <= MAX_SUBSTEPS {
            match self.attempt(s, path, h, n as u32) {
                Attempt::Done(next) => return next.finite(t),
                // How much too coarse is not known: the currents may have run away already.
                Attempt::TooCoarse(w_m) => (n, last) = (4.0 * n, w_m),
            }
        }
        if last.is_finite() {
            return Err(bad_step);
        }
        Err(StepError::NotFinite {
            t,
            signal: "w_m",
            value: last,
        })
    }

    fn w_e(&self, w_m: f64) -> f64 {
        f64::from(self.p.p) * w_m.abs()
    }

    /// The step in `n` substeps.
    fn attempt(&self, start: &State, path: &InputPath, h: f64, n: u32) -> Attempt {
        let dt = h / f64::from(n);
        let mut s = State {
            F_mean: 0.0,
            ..*start
        };
        for j in 0..n {
            s = self.rk4(&s, path, f64::from(j) * dt, dt);
            let resolved = self.w_e(s.w_m) * dt <= RATE_STEP;
            if !resolved {
                return Attempt::TooCoarse(s.w_m);
            }
        }
        s.F_mean /= h;
        s.residual = self.residual(maps::torque(&self.p, s.i_d, s.i_q), s.w_m);
        Attempt::Done(s)
    }

    /// One classical Runge–Kutta step of length `dt`, a time `t` after the start of the path. A loop, because
    /// one place where the rates are computed lets the compiler move everything that depends on parameters
    /// only out of it.
    fn rk4(&self, s: &State, path: &InputPath, t: f64, dt: f64) -> State {
        // Share of dt at which the rates are taken, and their weight.
        const STAGES: [(f64, f64); 4] = [
            (0.0, 1.0 / 6.0),
            (0.5, 1.0 / 3.0),
            (0.5, 1.0 / 3.0),
            (1.0, 1.0 / 6.0),
        ];
        let mut next = *s;
        let mut rates = Rates::default();
        for (share, weight) in STAGES {
            let at = share * dt;
            rates = self.rates(&s.advanced(at, &rates), &path.at(t + at));
            next = next.advanced(weight * dt, &rates);
        }
        next
    }
}

impl State {
    /// Itself when all of it is finite.
    pub(crate) fn finite(self, t: f64) -> Result<Self, StepError> {
        for (signal, value) in [
            ("i_d", self.i_d),
            ("i_q", self.i_q),
            ("theta_m", self.theta_m),
            ("w_m", self.w_m),
            ("x", self.x),
            ("x_dot", self.x_dot),
            ("residual.dF", self.residual.dF),
            ("F_mean", self.F_mean),
            ("energy.supplied", self.energy.supplied),
            ("energy.delivered", self.energy.delivered),
            ("energy.lost", self.energy.lost),
        ] {
            if !value.is_finite() {
                return Err(StepError::NotFinite { t, signal, value });
            }
        }
        Ok(self)
    }
}
