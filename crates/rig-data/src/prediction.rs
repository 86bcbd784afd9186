//! What an actuator's model says that a motion under a load will take: current and efficiency, by
//! physics, hybrid and network.

use emla::{Surrogate, maps};
use machine::Emla;
use rayon::prelude::*;
use serde::Serialize;

use crate::campaign::rms;
use crate::windows::{Truth, magnets, resistance};

/// Rod speed, m/s, below which both powers are small and their ratio says little.
const EFFICIENCY_SPEED: f64 = 0.01;
/// Names of the models, and their shares of the network.
pub const MODELS: [(&str, f64); 3] = [("physics", 0.0), ("hybrid", 0.9), ("network", 1.0)];

/// A model of the actuator: its physics, with a share of the network blended in.
#[derive(Clone, Debug)]
pub struct Model {
    p: Emla,
    network: Surrogate,
    /// Share of the network: 0 physics alone, 1 network alone.
    alpha: f64,
}

/// What a motion under a load takes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Demand {
    /// Quadrature current, A.
    pub i_q: f64,
    /// Torque at constant speed, N·m.
    pub tau: f64,
    /// Efficiency where it is defined, kept in [0, 1].
    pub efficiency: f64,
}

/// What is known of a motion.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Force on the load, N.
    pub F: f64,
    /// Motor speed, rad/s.
    pub w_m: f64,
    /// Motor acceleration, rad/s².
    pub w_m_dot: f64,
    /// Temperatures of winding and housing, K.
    pub T: [f64; 2],
}

impl From<&Truth> for Motion {
    fn from(t: &Truth) -> Self {
        Self {
            F: t.F,
            w_m: t.w_m,
            w_m_dot: t.w_m_dot,
            T: t.T,
        }
    }
}

impl Model {
    /// The physics of `p` with the share `alpha` of the network.
    #[must_use]
    pub fn new(p: Emla, network: Surrogate, alpha: f64) -> Self {
        Self { p, network, alpha }
    }

    /// Force on the load at constant speed by `[paper]` Eq. (eq:residual_blending_hat), N: `F_hyb =
    /// F_qs + α (F_net − F_qs)`, the physics of the difference inside the network's guards.
    #[must_use]
    pub fn force(&self, tau: f64, w: f64) -> f64 {
        let physics = |tau, w| maps::quasi_static_force(&self.p, tau, w);
        let F = physics(tau, w);
        if self.alpha == 0.0 {
            return F;
        }
        F + self.alpha * (self.network.evaluate(tau, w).F - self.network.guard(tau, w, physics))
    }

    /// Torque that gives the force `F` at constant speed: force rises with torque, so halving finds
    /// it. 60 halvings of ±200 N·m end at rounding.
    #[must_use]
    pub fn torque(&self, F: f64, w: f64) -> f64 {
        let (mut low, mut high) = (-200.0, 200.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.force(middle, w) < F {
                low = middle
            } else {
                high = middle
            }
        }
        0.5 * (low + high)
    }

    /// Current and efficiency of a motion.
    ///
    /// Power goes out at the nut: what bends on the way to the load stores energy, and loses none.
    /// The efficiency is that of `[paper]` Eq. (eq:dnn_prediction_efficiency) with the torque at
    /// constant speed: `P_out/(τ w + P_el)` or, where the load drives, `(|τ w| − P_el)/|P_out|`.
    #[must_use]
    pub fn demand(&self, m: &Motion) -> Demand {
        let p = &self.p;
        let tau = self.torque(m.F, m.w_m);
        let per_ampere = 1.5 * f64::from(p.p) * magnets(p, m.T[1]);
        let i_q = (tau + maps::inertia(p, 1.0) * m.w_m_dot) / per_ampere;
        let electrical = self.electrical(i_q, m);
        let out = m.F * maps::travel_per_radian(p) * m.w_m;
        let (shaft, size) = (tau * m.w_m, out.abs());
        let efficiency = if m.w_m > 0.0 {
            size / (shaft + electrical)
        } else {
            (shaft.abs() - electrical) / size
        };
        let efficiency = if shaft * out > 0.0 {
            efficiency.clamp(0.0, 1.0)
        } else {
            0.0
        };
        Demand {
            i_q,
            tau,
            efficiency,
        }
    }

    /// Copper, core and inverter losses by the nominal machine, W.
    fn electrical(&self, i_q: f64, m: &Motion) -> f64 {
        let p = &self.p;
        let w_e = f64::from(p.p) * m.w_m.abs();
        let flux = [magnets(p, m.T[1]), p.L_q * i_q];
        let core = p.core.map_or(0.0, |c| {
            (c.k_h + c.k_e * w_e) * w_e * (flux[0] * flux[0] + flux[1] * flux[1])
        });
        let size = i_q.abs();
        let inverter = p.inverter.map_or(0.0, |c| {
            let drop = std::f64::consts::FRAC_2_PI * (c.v_0 + c.f_sw * c.k_sw * c.v_dc);
            3.0 * size * (drop + 0.5 * c.r_0 * size)
        });
        1.5 * resistance(p, m.T[0]) * i_q * i_q + core + inverter
    }
}

/// Errors of a model on windows, root mean square: current, A, and efficiency, with temperatures
/// known and taken for the reference.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Errors {
    /// Of the current, A: temperatures known, and taken for the reference.
    pub current: [f64; 2],
    /// Of the efficiency; NaN where no window has one.
    pub efficiency: [f64; 2],
}

impl Errors {
    /// As text.
    pub fn cell(&self) -> String {
        let [current, efficiency] = [self.current, self.efficiency.map(|e| 1e2 * e)];
        let power = if efficiency[0].is_nan() {
            "-".into()
        } else {
            format!("{:.2} ({:.2}) %", efficiency[0], efficiency[1])
        };
        format!("{:.3} ({:.3}) A / {power}", current[0], current[1])
    }
}

/// Errors of a model on windows.
#[must_use]
pub fn errors(model: &Model, windows: &[Truth]) -> Errors {
    let reference = rig::Extras::AS_BUILT.temperature.reference;
    let travel = emla::maps::travel_per_radian(&machine::Machine::reference().emla.lift);
    let demands = |known: bool| -> Vec<(f64, Option<f64>)> {
        windows
            .par_iter()
            .map(|w| {
                let mut motion = Motion::from(w);
                if !known {
                    motion.T = [reference; 2];
                }
                let demand = model.demand(&motion);
                let slower = w.x_dot.abs().min(travel * w.w_m.abs());
                let efficiency = w.efficiency().filter(|_| slower > EFFICIENCY_SPEED);
                (
                    demand.i_q - w.i_q,
                    efficiency.map(|truth| demand.efficiency - truth),
                )
            })
            .collect()
    };
    let both = [demands(true), demands(false)];
    Errors {
        current: [0, 1].map(|k: usize| rms(both[k].iter().map(|d| d.0))),
        efficiency: [0, 1].map(|k: usize| rms(both[k].iter().filter_map(|d| d.1))),
    }
}
