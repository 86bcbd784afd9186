//! A model of the actuator (physics, look-up map, network or hybrid): current and efficiency for a
//! motion under a load, and their errors. For judgement, `loop`, `report` and `experiments`.

use emla::{Surrogate, maps};
use machine_file::Emla;
use rayon::prelude::*;
use serde::Serialize;

use crate::measurement::campaign::rms;
use crate::measurement::windows::{Motion, Truth, data_sheet, magnets, resistance};
use crate::prediction::lookup::LookUp;

/// Rod speed, m/s, below which both powers are too small for a meaningful efficiency.
pub const EFFICIENCY_SPEED: f64 = 0.01;
/// Names of the models, and their shares of the network.
pub const MODELS: [(&str, f64); 3] = [("physics", 0.0), ("hybrid", 0.9), ("network", 1.0)];

/// What gives a model's force at constant speed.
#[derive(Clone, Debug)]
enum Map {
    Physics,
    LookUp(Box<LookUp>),
    /// Blended into the physics with this share; 1 is the network alone.
    Network(Surrogate, f64),
}

/// A model of the actuator: its electrical side, and a map of its forces.
#[derive(Clone, Debug)]
pub struct Model {
    p: Emla,
    map: Map,
}

/// A model's prediction for a motion under a load.
#[derive(Clone, Copy, Debug, Default)]
pub struct Demand {
    /// Quadrature current, A.
    pub i_q: f64,
    /// Torque at constant speed, N·m.
    pub tau: f64,
    /// Electrical losses, W.
    pub electrical: f64,
    /// Efficiency, kept in [0, 1].
    pub efficiency: f64,
}

impl Model {
    /// The physics of `p` with the share `alpha` of the network.
    pub fn new(p: Emla, network: Surrogate, alpha: f64) -> Self {
        let map = if alpha == 0.0 {
            Map::Physics
        } else {
            Map::Network(network, alpha)
        };
        Self { p, map }
    }

    /// The physics of `p` alone.
    pub fn physics(p: Emla) -> Self {
        let map = Map::Physics;
        Self { p, map }
    }

    /// A look-up map with the electrical side of `p`.
    pub fn look_up(p: Emla, map: LookUp) -> Self {
        let map = Map::LookUp(Box::new(map));
        Self { p, map }
    }

    /// Parameters of its physics.
    pub fn params(&self) -> &Emla {
        &self.p
    }

    /// Force on the load at constant speed, N. With a network by `[paper]` Eq.
    /// (eq:residual_blending_hat), `F_hyb = F_qs + α (F_net − F_qs)`, the physics of the difference
    /// inside the network's guards.
    pub fn force(&self, tau: f64, w: f64) -> f64 {
        let physics = |tau, w| maps::quasi_static_force(&self.p, tau, w);
        match &self.map {
            Map::Physics => physics(tau, w),
            Map::LookUp(map) => map.force(tau, w),
            Map::Network(network, alpha) => {
                let residual = network.evaluate(tau, w).F - network.guard(tau, w, physics);
                physics(tau, w) + alpha * residual
            }
        }
    }

    /// Torque that gives the force `F` at constant speed, found between ±200 N·m to 1 mN by the
    /// Illinois variant of false position, since the force rises with the torque.
    pub fn torque(&self, F: f64, w: f64) -> f64 {
        let excess = |tau: f64| self.force(tau, w) - F;
        let (mut low, mut high) = ([-200.0, excess(-200.0)], [200.0, excess(200.0)]);
        let mut tau = 0.0;
        let mut side = 0.0;
        for _ in 0..60 {
            tau = (low[0] * high[1] - high[0] * low[1]) / (high[1] - low[1]);
            let e = excess(tau);
            if e.abs() < 1e-3 {
                break;
            }
            // The value of an end that stays twice is halved, else the other end would creep.
            let (moved, other) = if e < 0.0 {
                (&mut low, &mut high)
            } else {
                (&mut high, &mut low)
            };
            *moved = [tau, e];
            if e.signum() == side {
                other[1] *= 0.5;
            }
            side = e.signum();
        }
        tau
    }

    /// Current and efficiency of a motion.
    ///
    /// The output power is that at the nut: bending between nut and load stores energy without
    /// loss. The efficiency is that of `[paper]` Eq. (eq:dnn_prediction_efficiency) with the torque
    /// at constant speed: the mechanical losses are `τ w − P_out`.
    pub fn demand(&self, m: &Motion) -> Demand {
        let p = &self.p;
        let tau = self.torque(m.F, m.w_m);
        let per_ampere = 1.5 * f64::from(p.p) * magnets(p, m.T[1]);
        let i_q = (tau + maps::inertia(p, 1.0) * m.w_m_dot) / per_ampere;
        let electrical = self.electrical(i_q, m);
        let out = m.F * maps::travel_per_radian(p) * m.w_m;
        let shaft = tau * m.w_m;
        Demand {
            i_q,
            tau,
            electrical,
            efficiency: rig::efficiency(out, shaft - out + electrical, shaft),
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

/// Root mean square errors of a model on windows: first with the true temperatures, then with the
/// data sheet's reference temperature.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Errors {
    /// Of the current, A.
    pub current: [f64; 2],
    /// Of the efficiency; NaN if no window has one.
    pub efficiency: [f64; 2],
}

impl Errors {
    /// The cell of a table.
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

/// Evaluates a model on windows.
pub fn errors(model: &Model, windows: &[Truth]) -> Errors {
    let reference = data_sheet(&model.p).reference;
    let travel = maps::travel_per_radian(&model.p);
    let demands = |known: bool| -> Vec<(f64, Option<f64>)> {
        windows
            .par_iter()
            .map(|w| {
                let mut motion = w.motion;
                if !known {
                    motion.T = [reference; 2];
                }
                let demand = model.demand(&motion);
                let slower = w.x_dot.abs().min(travel * motion.w_m.abs());
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
