//! Where a run starts.

use crate::dynamics::{Energy, State};
use crate::input::Input;
use crate::maps;
use crate::residual::Residual;
use crate::{Emla, StepError};

impl Emla {
    /// The state in equilibrium with the load `F_hold` at rod position `x`; with `x_dot` ≠ 0, in steady
    /// motion at that velocity.
    /// ```text
    /// w_m = 2πN/ρ·ẋ,   x_n = x + (F_hold + C_act ẋ)/K_b(x),   i_d = 0,   i_q = τ_e/(3/2·p·λ_m)
    /// ```
    /// with τ_e of [`maps::required_torque`]. At rest all friction is zero.
    ///
    /// # Errors
    /// [`StepError::NotFinite`] for inputs that are not finite.
    pub fn start(&self, u: &Input) -> Result<State, StepError> {
        let p = &self.p;
        let travel = maps::travel_per_radian(p);
        let w_m = u.x_dot / travel;
        let stretch = (u.F_hold + p.C_act * u.x_dot) / maps::stiffness(p, u.x);
        let residual = Residual::default();
        let tau_e = maps::required_torque(p, u.F_hold - self.alpha * residual.dF, w_m, 0.0);
        let state = State {
            i_d: 0.0,
            i_q: tau_e / (1.5 * f64::from(p.p) * p.lambda_m),
            theta_m: (u.x + stretch) / travel,
            w_m,
            x: u.x,
            x_dot: u.x_dot,
            residual,
            F_mean: u.F_hold,
            energy: Energy::default(),
        };
        state.finite(0.0)
    }
}
