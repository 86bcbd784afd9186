//! Integration over one communication step of the FMU `DcLink`: J. C. Butcher's Runge–Kutta method
//! of order 6 within a mode, and events where a mode ends.
//!
//! Each substep is first integrated in its mode. If the guard is positive at its end, the mode
//! ended inside: the Illinois variant of the secant rule finds the instant, to [`EVENT_TOLERANCE`]
//! of the substep, and the rest is integrated in the new mode.

use crate::circuit::Point;
use crate::input::Input;
use crate::link::DcLink;
use crate::state::{Energies, Mode, State};
use model_rules::{MAX_SUBSTEPS, StepError, check_step, substeps};

/// Part of a substep to which an event is located.
const EVENT_TOLERANCE: f64 = 1e-13;
/// Largest number of events located in one substep; later ones act at the end of the substep.
const MAX_EVENTS: u32 = 64;
const MAX_ITERATIONS: u32 = 60;

impl DcLink {
    /// The state a time `h`, s, after `s`, with the inputs `u` held; `t`, s, is for error messages.
    pub fn step(&self, s: &State, u: &Input, t: f64, h: f64) -> Result<State, StepError> {
        check_step(t, h)?;
        let n = substeps(h, self.dt_max);
        if n > MAX_SUBSTEPS {
            return Err(StepError::BadStep { t, h });
        }
        let dt = h / n;
        let i_load = u.load();
        let mut x = Point::from_state(s);
        let mut mode = self.mode(&mut x, s.mode, i_load); // the inputs may have jumped
        for _ in 0..n as u32 {
            self.substep(&mut x, &mut mode, i_load, dt);
        }
        let next = State {
            soc: x.soc,
            v: x.v,
            v_c: x.v_c,
            T: self.pack.temperature_after(s.T, u.T_ambient, x.heat, h),
            mode,
            energy: Energies {
                battery: s.energy.battery + x.battery,
                load: s.energy.load + i_load * x.flux,
                brake: s.energy.brake + x.brake,
                loss: s.energy.loss + x.loss,
            },
            v_mean: x.flux / h,
        };
        next.check_finite(t)?;
        Ok(next)
    }

    fn substep(&self, x: &mut Point, mode: &mut Mode, i_load: f64, dt: f64) {
        let mut left = dt;
        for _ in 0..MAX_EVENTS {
            let end = self.integrate(x, *mode, i_load, left);
            if self.guard(&end, *mode, i_load) <= 0.0 {
                *x = end;
                return;
            }
            let (event, at) = self.locate_event(x, *mode, i_load, left);
            *x = at;
            *mode = self.mode(x, *mode, i_load);
            left -= event;
            if left <= EVENT_TOLERANCE * dt {
                return;
            }
        }
        *x = self.integrate(x, *mode, i_load, left);
        *mode = self.mode(x, *mode, i_load);
    }

    /// Time from `x` to the end of the mode within `dt`, s, and the point just past it.
    fn locate_event(&self, x: &Point, mode: Mode, i_load: f64, dt: f64) -> (f64, Point) {
        let guard = |h: f64| {
            let at = self.integrate(x, mode, i_load, h);
            (self.guard(&at, mode, i_load), at)
        };
        let (mut low, mut below) = (0.0, self.guard(x, mode, i_load));
        let (mut high, (mut above, mut point)) = (dt, guard(dt));
        let mut last = 0;
        for _ in 0..MAX_ITERATIONS {
            if high - low <= EVENT_TOLERANCE * dt {
                break;
            }
            // Stay half a tolerance away from both ends, so the bracket closes from both sides.
            let margin = 0.5 * EVENT_TOLERANCE * dt;
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

    /// One Runge–Kutta step of length `h`. A kink of the open-circuit voltage inside it takes
    /// effect at its end, an error of microvolts.
    ///
    /// Source: J. C. Butcher, *On Runge–Kutta processes of high order*, J. Austral. Math. Soc. 4
    /// (1964), the sixth-order process of seven stages with abscissae 0, 1/3, 2/3, 1/3, 1/2, 1/2,
    /// 1.
    fn integrate(&self, x: &Point, mode: Mode, i_load: f64, h: f64) -> Point {
        let line = &self.pack.line(x.soc);
        let rates = |x: &Point| self.rates(x, mode, i_load, line);
        let k_1 = &rates(x);
        let k_2 = &rates(&x.moved([(h / 3.0, k_1)]));
        let k_3 = &rates(&x.moved([(h * (2.0 / 3.0), k_2)]));
        let (a, b) = (h / 12.0, h / 16.0);
        let k_4 = &rates(&x.moved([(a, k_1), (4.0 * a, k_2), (-a, k_3)]));
        let k_5 = &rates(&x.moved([(-b, k_1), (18.0 * b, k_2), (-3.0 * b, k_3), (-6.0 * b, k_4)]));
        let c = h / 8.0;
        let k_6 = &rates(&x.moved([
            (9.0 * c, k_2),
            (-3.0 * c, k_3),
            (-6.0 * c, k_4),
            (4.0 * c, k_5),
        ]));
        let d = h / 44.0;
        let k_7 = &rates(&x.moved([
            (9.0 * d, k_1),
            (-36.0 * d, k_2),
            (63.0 * d, k_3),
            (72.0 * d, k_4),
            (-64.0 * d, k_6),
        ]));
        const ENDS: f64 = 11.0 / 120.0;
        const THIRDS: f64 = 27.0 / 40.0;
        const MIDDLE: f64 = -4.0 / 15.0;
        x.advanced(
            h,
            [
                (ENDS, k_1),
                (THIRDS, k_3),
                (THIRDS, k_4),
                (MIDDLE, k_5),
                (MIDDLE, k_6),
                (ENDS, k_7),
            ],
        )
    }
}
