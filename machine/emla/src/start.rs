//! The start state, in equilibrium with a load or in steady motion, for the FMU `Emla`.

use crate::actuator::Emla;
use crate::maps;
use crate::state::{Balance, LossKinds, Residual, State, Thermal};
use machine_file::ActuatorInput as Input;
use model_rules::StepError;

/// Largest number of secant steps for the start torque; the residual is smooth, a few suffice.
const STEADY_STEPS: u32 = 20;

impl Emla {
    /// The state in equilibrium with the load `F_hold` at rod position `x`; with `x_dot` ≠ 0, in
    /// steady motion at that velocity.
    /// ```text
    /// w_m = 2πN/ρ·ẋ,   x_n = x + (F_hold + C_act ẋ)/K_b(x),   i_d = 0,   i_q = τ_e/(3/2·p·λ_m)
    /// ```
    /// with τ_e of [`maps::required_torque`]. At rest all friction is zero.
    pub fn start(&self, u: &Input) -> Result<State, StepError> {
        let reference = self.temperature().reference;
        self.start_at(u, [reference; 2])
    }

    /// [`Emla::start`] with these temperatures of winding and housing, K. A drive that starts
    /// disabled or below its undervoltage carries no current; a brake that is applied at the start
    /// acts.
    pub fn start_at(
        &self,
        u: &Input,
        [T_winding, T_housing]: [f64; 2],
    ) -> Result<State, StepError> {
        let thermal = Thermal {
            T_winding,
            T_housing,
            given: 0.0,
        };
        let p = &*self.at_temperature(&thermal);
        let travel = maps::travel_per_radian(p);
        let w_m = u.x_dot / travel;
        let stretch = (u.F_hold + p.C_act * u.x_dot) / maps::stiffness(p, u.x);
        let (tau_e, residual) = self.steady_torque(u.F_hold, w_m);
        let mut state = State {
            i_d: 0.0,
            i_q: tau_e / (1.5 * f64::from(p.p) * p.lambda_m),
            theta_m: (u.x + stretch) / travel,
            w_m,
            x: u.x,
            x_dot: u.x_dot,
            residual,
            F_mean: u.F_hold,
            thermal,
            ..State::default()
        };
        state = State {
            energy: Balance::default(),
            kinds: LossKinds::default(),
            ..self.update_gates(&state, u)
        };
        state.braked = self.braked_after(&state, u, f64::INFINITY);
        let now = self.output(&state, u);
        (state.P_in_mean, state.i_dc_mean) = (now.P_in, now.i_dc);
        state.check_finite(0.0)?;
        Ok(state)
    }

    /// Torque for the steady force `F` at speed `w_m`, and the residual there: secant steps on
    /// `F_qs(τ) + α·dF(τ) = F`. Without a network the first is exact.
    fn steady_torque(&self, F: f64, w_m: f64) -> (f64, Residual) {
        let p = &self.p;
        let at = |tau_e: f64| {
            let residual = self.residual(tau_e, w_m);
            let F_hyb = maps::quasi_static_force(p, tau_e, w_m) + self.alpha * residual.dF;
            (tau_e, F_hyb - F, residual)
        };
        let mut old = at(maps::required_torque(p, F, w_m, 0.0));
        if self.alpha * old.2.dF == 0.0 {
            return (old.0, old.2);
        }
        let mut new = at(maps::required_torque(p, F - old.1, w_m, 0.0));
        for _ in 0..STEADY_STEPS {
            let slope = (new.1 - old.1) / (new.0 - old.0);
            let next = new.0 - new.1 / slope;
            if !next.is_finite() {
                break; // two equal points: converged to the last bit
            }
            (old, new) = (new, at(next));
        }
        (new.0, new.2)
    }
}
