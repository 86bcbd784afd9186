//! The start state, in equilibrium with a load or in steady motion, for FMU `Rig` and the studies.

use crate::{Balance, Input, Powers, Rig, State, StepError};
use machine_file::{BrakeState, Dq};

impl Rig {
    /// The state that delivers `F_hold` at rod position `x`, in steady motion at `x_dot` (at rest
    /// all friction is zero), with these temperatures of winding and housing, K. The inverter
    /// already holds the steady-state voltage; a drive that starts disabled or below its
    /// undervoltage carries no current; a brake that is applied at the start acts.
    pub fn start(&self, u: &Input, T: [f64; 2]) -> Result<State, StepError> {
        let (p, travel) = (&self.p, self.travel());
        let w_m = u.x_dot / travel;
        let F_link = u.F_hold + p.C_act * u.x_dot;
        let theta_m = (u.x + self.stretch(F_link, u.x)) / travel;
        let z = self.steady_deflection(u.x_dot, F_link);
        let pairs = f64::from(p.p);
        let per_ampere = 1.5 * pairs * self.magnets(pairs * theta_m, T[1]);
        let i_q = (self.steady_torque(w_m, F_link, z) - self.cogging(theta_m)) / per_ampere;
        let i = Dq { d: 0.0, q: i_q };
        let magnetics = self.magnetics(i, theta_m, T[0], T[1]);
        let w_e = pairs * w_m;
        let v = Dq {
            d: -w_e * magnetics.lambda.q,
            q: magnetics.R * i_q + w_e * magnetics.lambda.d,
        };
        let mut state = State {
            i_d: 0.0,
            i_q,
            theta_m,
            w_m,
            z,
            x: u.x,
            x_dot: u.x_dot,
            T,
            hold: self.steady_hold(v, i, u, theta_m, w_m),
            regulator: [v.d, v.q],
            F_mean: u.F_hold,
            ..State::default()
        };
        state = State {
            energy: Balance::default(),
            ..self.update_gates(&state, u)
        };
        state.braked = self.braked_after(&state, u, f64::INFINITY);
        let now = self.instant(&state, u, &self.conditions(&state, u));
        let supplied = now.supplied(state.current());
        state.i_dc_mean = machine_file::link_current(supplied, self.link_voltage(u));
        state.mean = Powers {
            supplied,
            delivered: now.delivered,
            lost: now.lost(),
        };
        state.check_finite(0.0)?;
        Ok(state)
    }

    /// Torque at which the shaft does not accelerate, N·m; the acceleration is linear in it.
    fn steady_torque(&self, w_m: f64, F_link: f64, z: f64) -> f64 {
        let at = |tau: f64| {
            self.shaft(tau, w_m, F_link, z, BrakeState::Released)
                .w_m_dot
        };
        let (idle, slope) = (at(0.0), at(1.0) - at(0.0));
        -idle / slope
    }
}
