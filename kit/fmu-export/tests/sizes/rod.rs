//! A rod of cells that conduct heat, as many as a parameter says, and beside it a field of each
//! shape.

use fmu_export::prelude::*;

#[derive(Parameters)]
pub struct Winding {
    /// Resistance
    #[fmu(unit = "Ohm", start = 0.5)]
    pub R: f64,
}

#[derive(Parameters)]
pub struct Motor {
    pub winding: Winding,
}

#[derive(Parameters)]
pub struct Parameters {
    /// Number of cells
    #[fmu(structural, start = 5, min = 1, max = 200_000)]
    pub n: i32,
    /// Number of sensors
    #[fmu(structural, start = 2, min = 1, max = 4)]
    pub m: i32,
    /// Rate of exchange between neighbours
    #[fmu(unit = "1/s", start = 0.25, min = 0.0)]
    pub rate: f64,
    /// Temperatures at the start
    #[fmu(unit = "K", start = 280.0 + i as f64, len = p.n, min = 1.0)]
    pub T_0: Vec<f64>,
    /// Weights of the first cells in what sensors show
    #[fmu(unit = "1", start = 0.25 + i as f64, len = (p.m, 3))]
    pub weights: Vec<f64>,
    /// Numbers of a table
    #[fmu(unit = "1", start = 1.5)]
    pub table: [f64; 1000],
    /// A matrix
    #[fmu(unit = "1", start = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])]
    pub matrix: [[f64; 3]; 2],
    /// Flags
    #[fmu(start = true)]
    pub flags: [bool; 40],
    /// Counts
    #[fmu(start = -3, len = p.m)]
    pub counts: Vec<i32>,
    pub motor: [Motor; 2],
}

#[derive(Input)]
pub struct Input {
    /// Heating of each cell
    #[fmu(unit = "K/s", len = p.n, min = -1e3, max = 1e3, nominal = 1e3)]
    pub heating: Vec<f64>,
    /// How each cell is switched
    #[fmu(len = p.n, min = -5.0, max = 1e6)]
    pub switches: Vec<i32>,
}

#[derive(Output)]
pub struct Output {
    /// Heating of a cell and of the one before it
    #[fmu(unit = "K/s", len = p.n, depends_on(heating[i - 1], heating[i], T[i]), initially_depends_on(heating[i - 1], heating[i]))]
    pub pairs: Vec<f64>,
    /// What sensors show
    #[fmu(unit = "K", len = p.m, depends_on(T), initially_depends_on(T_0, weights))]
    pub shown: Vec<f64>,
}

/// A rod of cells
#[derive(State)]
#[fmu(parameters = Parameters, input = Input, output = Output, max_step = 0.1, experiment(0.0, 1.0, 0.1), model_exchange)]
pub struct Rod {
    /// Temperature of each cell
    #[fmu(unit = "K", start = p.T_0[i], len = p.n, rate_depends_on(T[i - 1], T[i], T[i + 1], heating[i]))]
    pub T: Vec<f64>,
}

impl Ode for Rod {
    fn derivative(&self, p: &Parameters, u: &Input, _t: f64, dx: &mut Self) {
        let (n, T) = (self.T.len(), &self.T);
        for i in 0..n {
            let (before, after) = (T[i.saturating_sub(1)], T[(i + 1).min(n - 1)]);
            dx.T[i] = p.rate * (before - 2.0 * T[i] + after) + u.heating[i];
        }
    }

    fn outputs_into(&self, p: &Parameters, u: &Input, y: &mut Output) {
        for (i, pair) in y.pairs.iter_mut().enumerate() {
            *pair = u.heating[i] + if i > 0 { u.heating[i - 1] } else { 0.0 };
        }
        for (shown, weights) in y.shown.iter_mut().zip(p.weights.chunks(3)) {
            *shown = weights.iter().zip(&self.T).map(|(w, T)| w * T).sum();
        }
    }
}

export_fmu!(Rod);
