//! The network's correction of the quasi-static force (the paper's hybrid model), for this model
//! and the controller; outside the trained range a warning for the FMU, and the force cut off.

use crate::actuator::Emla;
use crate::maps;
use crate::state::{Residual, State};
use crate::surrogate::{MinMax, Surrogate, SurrogateOutput};

/// Warning: an operating point outside the network's trained range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "torque tau_e = {tau_e:.3} N.m, speed w_m = {w_m:.2} rad/s: the network was trained for {}..{} N.m in the direction of motion and up to {} rad/s, \
     outside it gives the value at the edge of that range", .torque.min, .torque.max, .w_m_max
)]
pub struct UntrainedPoint {
    /// Torque, N·m.
    pub tau_e: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Trained torques, positive in the direction of motion, N·m.
    pub torque: MinMax,
    /// Largest trained speed, rad/s.
    pub w_m_max: f64,
}

impl Emla {
    /// Warning if state `s` is outside the network's trained range and the network acts. Speeds
    /// below the trained ones are excepted: every motion begins and ends there.
    pub fn untrained(&self, s: &State) -> Option<UntrainedPoint> {
        let surrogate = self.surrogate.as_ref().filter(|_| self.alpha > 0.0)?;
        let (ranges, w_m) = (surrogate.ranges(), s.w_m);
        let tau_e = maps::torque(&self.at_temperature(&s.thermal), s.i_d, s.i_q);
        let trained = w_m.abs() <= ranges.w_m.max
            && (w_m.abs() < ranges.w_m.min || surrogate.in_trained_range(tau_e, w_m));
        (!trained).then_some(UntrainedPoint {
            tau_e,
            w_m,
            torque: ranges.tau_e,
            w_m_max: ranges.w_m.max,
        })
    }

    /// Physical force, N, beyond what the network's guards admit at torque `tau_e`, N·m, and motor
    /// speed `w_m`, rad/s; 0 in the trained range.
    pub fn force_held_back(&self, surrogate: &Surrogate, tau_e: f64, w_m: f64) -> f64 {
        let physics = |tau, w| maps::quasi_static_force(&self.p, tau, w);
        if surrogate.in_trained_range(tau_e, w_m) {
            return 0.0;
        }
        physics(tau_e, w_m) - surrogate.guard(tau_e, w_m, physics)
    }

    /// The residual at torque `tau_e`, N·m, and motor speed `w_m`, rad/s.
    pub fn residual(&self, tau_e: f64, w_m: f64) -> Residual {
        let Some(surrogate) = &self.surrogate else {
            return Residual::default();
        };
        self.residual_from(surrogate, surrogate.evaluate(tau_e, w_m), [tau_e, w_m])
    }

    /// The residuals of three actuators at the points `[tau_e, w_m]`, N·m and rad/s. A shared
    /// network, as the controller's nominal actuators have, is evaluated for all three at once.
    pub fn residuals(actuators: &[Self; 3], points: [[f64; 2]; 3]) -> [Residual; 3] {
        if let [Some(a), Some(b), Some(c)] = actuators.each_ref().map(|a| a.surrogate.as_ref())
            && a.is_shared_with(b)
            && a.is_shared_with(c)
        {
            let nets = a.evaluate_three(points);
            return std::array::from_fn(|i| actuators[i].residual_from(a, nets[i], points[i]));
        }
        std::array::from_fn(|i| actuators[i].residual(points[i][0], points[i][1]))
    }

    /// The residual for the network's output `net`.
    #[inline]
    fn residual_from(
        &self,
        surrogate: &Surrogate,
        net: SurrogateOutput,
        [tau_e, w_m]: [f64; 2],
    ) -> Residual {
        let F_qs = surrogate.guard(tau_e, w_m, |tau, w| {
            maps::quasi_static_force(&self.p, tau, w)
        });
        Residual {
            dF: net.F - F_qs,
            F_net: net.F,
            x_dot_net: net.x_dot,
            in_trained_range: net.in_trained_range,
        }
    }
}
