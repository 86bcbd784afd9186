//! One communication step by Runge–Kutta in equal substeps, for the FMU and the controller.

use crate::actuator::Emla;
use crate::conditions::Conditions;
use crate::maps;
use crate::state::{LossKinds, Point, Rates, State};
use machine_file::{ActuatorInput as Input, BrakeState, Drive, link_current};
use model_rules::{MAX_SUBSTEPS, RATE_STEP, RK4_STAGES, StepError, check_step};

/// The substep was too long for the electrical frequency at this motor speed, rad/s (or NaN).
struct TooCoarse {
    w_m: f64,
}

impl Emla {
    /// The state a time `h`, s, after `s`. `input(s)` gives the inputs `s` seconds into the step;
    /// `t`, s, is used in error messages only.
    ///
    /// If `p·|w_m|·dt` exceeds 1 (beyond the reference motor's rated speed), the whole step is
    /// repeated with shorter substeps, so that the currents stay in RK4's stability region.
    pub fn step(
        &self,
        s: &State,
        input: impl Fn(f64) -> Input,
        t: f64,
        h: f64,
    ) -> Result<State, StepError> {
        check_step(t, h)?;
        let u = &input(0.0);
        let switched;
        let mut begun = s;
        let is_low = self.link_voltage(u) < self.electric.undervoltage;
        if !u.enable || s.tripped || is_low || s.braked > 0.0 {
            switched = self.update_gates(s, u);
            begun = &switched;
        }
        let wait = self.awaited_brake(begun, u);
        if wait > 0.0 {
            let attempt = |n: f64| self.attempt_to_brake(begun, &input, wait, h, n);
            return self.repeated(s, u, [t, h], attempt);
        }
        self.repeated(s, u, [t, h], |n| {
            self.attempt(begun, u, &input, h, n as u32)
        })
    }

    /// The state after the first `attempt` at the step whose number of substeps is enough.
    #[inline(always)]
    fn repeated(
        &self,
        s: &State,
        u: &Input,
        [t, h]: [f64; 2],
        attempt: impl Fn(f64) -> Result<State, TooCoarse>,
    ) -> Result<State, StepError> {
        let bad_step = StepError::BadStep { t, h };
        let mut n = self.substeps(h);
        let mut last = s.w_m;
        while n <= MAX_SUBSTEPS {
            match attempt(n) {
                Ok(mut next) => {
                    next.P_in_mean = (next.energy.supplied - s.energy.supplied) / h;
                    next.i_dc_mean = link_current(next.P_in_mean, self.link_voltage(u));
                    if self.electric.heat {
                        let warmed = self.temperatures_after(s, &next, u.T_ambient, h);
                        next.thermal = warmed.ok_or(bad_step)?;
                    }
                    next.check_finite(t)?;
                    return Ok(next);
                }
                // By how much dt is too long is not known: the currents may have diverged already.
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

    /// Number of substeps in a step of `h`, s, unless the motor is too fast for them.
    pub fn substeps(&self, h: f64) -> f64 {
        model_rules::substeps(h, self.dt_max)
    }

    /// The step in about `n` substeps while a commanded brake closes after `wait`, s.
    #[cold]
    #[inline(never)]
    fn attempt_to_brake(
        &self,
        start: &State,
        input: &impl Fn(f64) -> Input,
        wait: f64,
        h: f64,
        n: f64,
    ) -> Result<State, TooCoarse> {
        let first = wait.min(h);
        let part = |h_part: f64| (n * h_part / h).ceil().max(1.0) as u32;
        let u = &input(0.0);
        let mut before = self.attempt(start, u, input, first, part(first))?;
        before.braked = self.braked_after(start, u, first);
        if first == h {
            return Ok(before);
        }
        let (rest, later) = (h - first, |s: f64| input(first + s));
        let mut next = self.attempt(&before, &later(0.0), &later, rest, part(rest))?;
        next.F_mean = (first * before.F_mean + rest * next.F_mean) / h;
        next.lead = f64::from(self.delay) * h;
        Ok(next)
    }

    /// The step in `n` substeps, without updating electrical means and temperatures. Heat, gates
    /// off and brake, which are rare, have a loop of their own.
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
        let held = self.conditions(p, start, u);
        let dt = h / f64::from(n);
        let (point, mut kinds) = (start.point(), start.kinds);
        let substeps = (n, dt);
        let s = match self.drive {
            _ if !held.is_plain() || self.electric.heat => {
                self.substeps_with_brake(point, input, (p, &held), substeps, &mut kinds)?
            }
            Drive::Motion => self.substeps_plain::<true>(point, input, (p, &held), substeps)?,
            Drive::Force => self.substeps_plain::<false>(point, input, (p, &held), substeps)?,
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

    /// `n` substeps of `dt` with gates on, brake released and heat not modelled. Not inlined, so
    /// that the compiler knows that its arguments are constant and moves some 25 divisions of
    /// parameters out of the loop.
    #[inline(never)]
    fn substeps_plain<const MOTION: bool>(
        &self,
        mut s: Point,
        input: &impl Fn(f64) -> Input,
        (p, held): (&machine_file::Emla, &Conditions),
        (n, dt): (u32, f64),
    ) -> Result<Point, TooCoarse> {
        let held = Conditions {
            p,
            drive: if MOTION { Drive::Motion } else { Drive::Force },
            gates: true,
            brake: BrakeState::Released,
            ..*held
        };
        for j in 0..n {
            s = self.rk4(&s, input, &held, f64::from(j) * dt, dt, |_, _| ());
            s.check_resolved(p, dt)?;
        }
        Ok(s)
    }

    /// `n` substeps of `dt` with heat, gates off or a brake. A slipping brake stops a shaft that
    /// would reverse within the substep; the rest of its kinetic energy is lost there.
    #[cold]
    #[inline(never)]
    fn substeps_with_brake(
        &self,
        mut s: Point,
        input: &impl Fn(f64) -> Input,
        (p, held): (&machine_file::Emla, &Conditions),
        (n, dt): (u32, f64),
        kinds: &mut LossKinds,
    ) -> Result<Point, TooCoarse> {
        let mut held = Conditions { p, ..*held };
        for j in 0..n {
            let t = f64::from(j) * dt;
            if held.brake != BrakeState::Released {
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

    /// One classical Runge–Kutta step of length `dt`, a time `t` after the start of the step;
    /// `count` receives the losses by kind with their weights. A loop, because with a single call
    /// of `rates` the compiler moves parameter-only expressions out of it.
    #[inline(always)]
    fn rk4(
        &self,
        s: &Point,
        input: &impl Fn(f64) -> Input,
        held: &Conditions,
        t: f64,
        dt: f64,
        mut count: impl FnMut(f64, &LossKinds),
    ) -> Point {
        let mut next = *s;
        let mut rates = Rates::default();
        for (share, weight) in RK4_STAGES {
            let at = share * dt;
            rates = self.rates(&s.advanced(at, &rates), &input(t + at), held);
            next = next.advanced(weight * dt, &rates);
            count(weight * dt, &rates.kinds);
        }
        next
    }
}

impl Point {
    /// Checks that the substep `dt` resolves the electrical angle.
    fn check_resolved(&self, p: &machine_file::Emla, dt: f64) -> Result<(), TooCoarse> {
        let is_resolved = f64::from(p.p) * self.w_m.abs() * dt <= RATE_STEP;
        is_resolved.then_some(()).ok_or(TooCoarse { w_m: self.w_m })
    }
}
