//! Integration over one communication step: classical Runge–Kutta with a fixed substep.

use crate::dynamics::{Point, Rates, State};
use crate::heat::Kinds;
use crate::held::Held;
use crate::input::Input;
use crate::maps;
use crate::{Drive, Emla};
use machine::{Holding, link_current};
use thiserror::Error;

/// Largest error of the force by the integration, N, while the load keeps its sign; see [`dt_of_error`].
const FORCE_ERROR: f64 = 0.05;
/// Time in which the voltage changes by `v_max`, s, for which [`FORCE_ERROR`] holds: some 20 times as fast as the reference motions
/// ask for.
const VOLTAGE_SWEEP: f64 = 0.1;
/// Longest substep with a free rod, s.
const DT_MAX_FORCE: f64 = 0.125e-3;
/// Largest `rate·dt` of a linear mode. RK4 is stable to 2.78 on the real and 2.83 on the imaginary
/// axis; 1 keeps it accurate too.
const RATE_STEP: f64 = 1.0;
/// Most substeps in one step, half a second of computing. Normal operation takes 2 to 12 per millisecond.
const MAX_SUBSTEPS: f64 = 1e6;
/// Part of a step by which the substeps may be longer than the longest: an importer's clock may be off by so much, and a nanosecond
/// more than a millisecond must not cost another substep.
const TIME_SLACK: f64 = 1e-3;

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

/// Substep with which RK4 misses the force by [`FORCE_ERROR`], s, when the rod's motion is prescribed and the voltage changes at the
/// rate `v̇ = v_max/VOLTAGE_SWEEP`.
///
/// RK4 misses `e^z` by `z⁵/120`. For a linear system `y' = A·y + B·v` whose voltage is held over each communication step but grows
/// at the mean rate `v̇`, the errors of all substeps add up to `A²·B·v̇·dt⁴/120` in the steady state, whatever the
/// communication step. For the force the leading term is
/// ```text
/// δF = ω₀²·(β₁/L)·v̇·dt⁴/120,   ω₀² = K_b·(ρ/(2πN))²/J
/// ```
/// `β₁/L·v̇` is how the voltage bends the force (N/s²), ω₀ the natural frequency of rotor and screw on the spring.
///
/// Where the load changes sign, the gear factor k jumps by at most `1/η − η`, and the inertia `J_m + k·J_s/N²` with it. RK4 expects
/// smooth rates: in the substep that holds the jump it misses up to a third of its effect,
/// `δF = (1/η − η)·(J_s/N²)·ẇ_m·ω₀·(2πN/ρ)·dt/3`, some 0.2 N in usual motion, which decays with the spring's oscillation. No
/// substep of reasonable length would bring this below [`FORCE_ERROR`].
fn dt_of_error(p: &machine::Emla, K_b: f64) -> f64 {
    let travel = maps::travel_per_radian(p);
    let w_0_squared = K_b * travel * travel / maps::inertia(p, 1.0);
    let bend = maps::beta_1(p, 0.0) / p.L_d.min(p.L_q) * p.v_max / VOLTAGE_SWEEP;
    (120.0 * FORCE_ERROR / (w_0_squared * bend)).sqrt().sqrt()
}

/// Longest substep for these parameters, s: that of the error bound, or less where a mode is faster.
pub(crate) fn longest_substep(p: &machine::Emla, drive: Drive) -> f64 {
    let travel = maps::travel_per_radian(p);
    let nut_mass = p.J_m / (travel * travel);
    let K_max = maps::stiffness(p, 0.0).max(maps::stiffness(p, p.L_s));
    let (accurate, mass) = match drive {
        Drive::Motion => (dt_of_error(p, K_max), nut_mass),
        Drive::Force => (DT_MAX_FORCE, 1.0 / (1.0 / nut_mass + 1.0 / p.M_act)),
    };
    let rate = fast_rate(mass, p.C_b + p.C_act, K_max)
        .max(p.R_s / p.L_d.min(p.L_q))
        .max(maps::motor_friction_slope(p, 0.0) / p.J_m);
    accurate.min(RATE_STEP / rate)
}

/// The electrical mode turned faster than the substep of an attempt resolves, at this motor speed in rad/s (or not a number).
struct TooCoarse {
    w_m: f64,
}

impl Emla {
    /// The state a time `h` after `s`, both times s. `input` gives the inputs a time after the start of the step;
    /// `t` only names the time in an error.
    ///
    /// The substep shrinks (the whole step is taken again) when `p·|w_m|·dt` exceeds 1, beyond the reference motor's rated speed:
    /// with any bounded voltage and motion the currents stay on the stable side of RK4.
    ///
    /// # Errors
    /// An unusable step, or a result that is not finite.
    pub fn step(
        &self,
        s: &State,
        input: impl Fn(f64) -> Input,
        t: f64,
        h: f64,
    ) -> Result<State, StepError> {
        let bad_step = StepError::BadStep { t, h };
        if !(h.is_finite() && h > 0.0) {
            return Err(bad_step);
        }
        let u = &input(0.0);
        let switched;
        let mut begun = s;
        if !u.enable || s.tripped || self.link_voltage(u) < self.electric.undervoltage {
            switched = self.switched(s, u);
            begun = &switched;
        }
        let mut n = self.substeps(h);
        let mut last = s.w_m;
        while n <= MAX_SUBSTEPS {
            match self.attempt(begun, u, &input, h, n as u32) {
                Ok(mut next) => {
                    next.P_in_mean = (next.energy.supplied - s.energy.supplied) / h;
                    next.i_dc_mean = link_current(next.P_in_mean, self.link_voltage(u));
                    if self.electric.heat {
                        let warmed = self.warmed(s, &next, u.T_ambient, h);
                        next.thermal = warmed.ok_or(bad_step)?;
                    }
                    next.check_finite(t)?;
                    return Ok(next);
                }
                // How much too coarse is not known: the currents may have run away already.
                Err(TooCoarse { w_m }) => (n, last) = (4.0 * n, w_m),
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

    /// In how many substeps a step of `h`, s, is taken, unless the motor is too fast for them.
    #[must_use]
    pub fn substeps(&self, h: f64) -> f64 {
        (h * (1.0 - TIME_SLACK) / self.dt_max).ceil().max(1.0)
    }

    /// The step in `n` substeps; means of the electrical side and temperatures are those of the start. What is rare is decided once: heat,
    /// gates that are off, a brake.
    #[inline(always)]
    fn attempt(
        &self,
        start: &State,
        u: &Input,
        input: &impl Fn(f64) -> Input,
        h: f64,
        n: u32,
    ) -> Result<State, TooCoarse> {
        let p = &*self.at_temperature(&start.thermal);
        let held = self.held(p, start, u);
        let dt = h / f64::from(n);
        let (point, mut kinds) = (start.point(), start.kinds);
        let substeps = (n, dt);
        let s = match self.drive {
            _ if !held.is_plain() || self.electric.heat => {
                self.braked(point, input, (p, &held), substeps, &mut kinds)?
            }
            Drive::Motion => self.plain::<true>(point, input, (p, &held), substeps)?,
            Drive::Force => self.plain::<false>(point, input, (p, &held), substeps)?,
        };
        Ok(State {
            i_d: s.i_d,
            i_q: s.i_q,
            theta_m: s.theta_m,
            w_m: s.w_m,
            x: s.x,
            x_dot: s.x_dot,
            residual: self.residual(maps::torque(p, s.i_d, s.i_q), s.w_m),
            F_mean: s.impulse / h,
            lead: f64::from(self.delay) * h,
            energy: s.energy,
            kinds,
            ..*start
        })
    }

    /// `n` substeps of `dt` with the inverter at work, the shaft free, and the rod moved from outside or not.
    ///
    /// A function that is not inlined: what its arguments refer to changes for nobody, so the compiler takes all that depends on parameters
    /// only, some 25 divisions, out of the loops. Inlined, it does not know.
    #[inline(never)]
    fn plain<const MOTION: bool>(
        &self,
        mut s: Point,
        input: &impl Fn(f64) -> Input,
        (p, held): (&machine::Emla, &Held),
        (n, dt): (u32, f64),
    ) -> Result<Point, TooCoarse> {
        let held = Held {
            p,
            drive: if MOTION { Drive::Motion } else { Drive::Force },
            gates: true,
            brake: Holding::Released,
            ..*held
        };
        for j in 0..n {
            s = self.rk4(&s, input, &held, f64::from(j) * dt, dt, |_, _| ());
            s.check_resolved(p, dt)?;
        }
        Ok(s)
    }

    /// The same with what is rare: heat, gates off, a brake. A brake that slips stops a shaft that would turn back within the substep:
    /// what is left of its energy is lost there, and the next substep finds it at rest.
    #[cold]
    #[inline(never)]
    fn braked(
        &self,
        mut s: Point,
        input: &impl Fn(f64) -> Input,
        (p, held): (&machine::Emla, &Held),
        (n, dt): (u32, f64),
        kinds: &mut Kinds,
    ) -> Result<Point, TooCoarse> {
        let mut held = Held { p, ..*held };
        for j in 0..n {
            let t = f64::from(j) * dt;
            if held.brake != Holding::Released {
                held.brake = self.braking(&s, &input(t), &held);
            }
            s = self.rk4(&s, input, &held, t, dt, |dt, rates| {
                kinds.copper += dt * rates.copper;
                kinds.inverter += dt * rates.inverter;
            });
            if held.brake.has_stopped(s.w_m) {
                s.energy.lost += 0.5 * maps::inertia(&self.p, 1.0) * s.w_m * s.w_m;
                s.w_m = 0.0;
            }
            s.check_resolved(p, dt)?;
        }
        Ok(s)
    }

    /// One classical Runge–Kutta step of length `dt`, a time `t` after the start of the step; `count` is given the losses by kind and for how
    /// long they count. A loop, because one place where the rates are computed lets the compiler move everything that depends on parameters
    /// only out of it.
    #[inline(always)]
    fn rk4(
        &self,
        s: &Point,
        input: &impl Fn(f64) -> Input,
        held: &Held,
        t: f64,
        dt: f64,
        mut count: impl FnMut(f64, &Kinds),
    ) -> Point {
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
            rates = self.rates(&s.advanced(at, &rates), &input(t + at), held);
            next = next.advanced(weight * dt, &rates);
            count(weight * dt, &rates.kinds);
        }
        next
    }
}

impl Point {
    /// That the substep of `dt` resolves the electrical angle.
    fn check_resolved(&self, p: &machine::Emla, dt: f64) -> Result<(), TooCoarse> {
        let is_resolved = f64::from(p.p) * self.w_m.abs() * dt <= RATE_STEP;
        if is_resolved {
            Ok(())
        } else {
            Err(TooCoarse { w_m: self.w_m })
        }
    }
}

impl State {
    /// That all of it is finite: 0·v is 0, unless v is infinite or NaN.
    pub(crate) fn check_finite(&self, t: f64) -> Result<(), StepError> {
        let values = [
            ("i_d", self.i_d),
            ("i_q", self.i_q),
            ("theta_m", self.theta_m),
            ("w_m", self.w_m),
            ("x", self.x),
            ("x_dot", self.x_dot),
            ("residual.dF", self.residual.dF),
            ("F_mean", self.F_mean),
            ("i_dc_mean", self.i_dc_mean),
            ("energy.supplied", self.energy.supplied),
            ("energy.delivered", self.energy.delivered),
            ("energy.shift", self.shift),
            ("energy.lost", self.energy.lost),
            ("T_winding", self.thermal.T_winding),
            ("T_housing", self.thermal.T_housing),
            ("energy.heat", self.thermal.given),
        ];
        if values.iter().map(|(_, value)| 0.0 * value).sum::<f64>() == 0.0 {
            return Ok(());
        }
        let is_wrong = |(_, value): &(&str, f64)| !value.is_finite();
        match values.into_iter().find(is_wrong) {
            None => Ok(()),
            Some((signal, value)) => Err(StepError::NotFinite { t, signal, value }),
        }
    }
}
