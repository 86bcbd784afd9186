//! FMU `Battery`: cells in series as an equivalent circuit, with one RC pair and one heat node.

use fmu_export::prelude::*;

/// Open-circuit voltage at charge 0 and 1, V; a straight line between.
const VOLTAGE: [f64; 2] = [3.0, 4.2];

#[derive(Parameters)]
struct Parameters {
    /// Cells in series
    #[fmu(unit = "1", start = 1.0, min = 1.0)]
    cells: f64,
    /// Capacity
    #[fmu(unit = "A.h", start = 50.0, min = 1e-3)]
    capacity: f64,
    /// Series resistance of a cell
    #[fmu(unit = "Ohm", start = 1.5e-3, min = 1e-9)]
    R_0: f64,
    /// Resistance of the RC pair of a cell
    #[fmu(unit = "Ohm", start = 0.8e-3, min = 1e-9)]
    R_1: f64,
    /// Capacitance of the RC pair of a cell
    #[fmu(unit = "F", start = 2.0e4, min = 1e-3)]
    C_1: f64,
    /// Time constant of the filter that loads are behind
    #[fmu(unit = "s", start = 0.05, min = 0.04)]
    T_filter: f64,
    /// Heat capacity of a cell
    #[fmu(unit = "J/K", start = 1000.0, min = 1e-3)]
    heat_capacity: f64,
    /// Heat conductance of a cell to the surroundings
    #[fmu(unit = "W/K", start = 0.5, min = 0.0, tunable)]
    cooling: f64,
}

#[derive(Input)]
struct Input {
    /// Current drawn; negative: charging
    #[fmu(unit = "A")]
    i: f64,
    /// Currents drawn by loads behind a filter, so that the voltage does not depend on them at once
    #[fmu(unit = "A")]
    i_load: [f64; 3],
    /// Temperature of the surroundings
    #[fmu(unit = "K", display_unit = "degC", start = 298.15, min = 1.0)]
    T_ambient: f64,
}

#[derive(Output)]
struct Output {
    /// Voltage at the terminals
    #[fmu(unit = "V", depends_on(i, soc, v_1, i_filter), initially_depends_on(i, R_0, cells))]
    v: f64,
    /// Heat made inside
    #[fmu(unit = "W", depends_on(i, v_1, i_filter), initially_depends_on(i, R_0, R_1, cells))]
    P_loss: f64,
}

/// Lithium-ion cells in series: open-circuit voltage, series resistance, one RC pair, one heat node
#[derive(State)]
#[fmu(parameters = Parameters, input = Input, output = Output, model_exchange, max_step = 0.1, experiment(0.0, 1800.0, 1.0))]
struct Battery {
    /// State of charge
    #[fmu(unit = "1", start = 0.9, rate_depends_on(i, i_filter))]
    soc: f64,
    /// Voltage of the RC pair of a cell
    #[fmu(unit = "V", rate_depends_on(i, i_filter, v_1))]
    v_1: f64,
    /// Current that the filter lets through
    #[fmu(unit = "A", rate_depends_on(i_load, i_filter))]
    i_filter: f64,
    /// Temperature of the cells
    #[fmu(unit = "K", display_unit = "degC", start = 298.15, rate_depends_on(i, T_ambient, i_filter, v_1, T))]
    T: f64,
}

impl Ode for Battery {
    fn derivative(&self, p: &Parameters, u: &Input, _t: f64, dx: &mut Self) {
        let heat = self.outputs(p, u).P_loss / p.cells + p.cooling * (u.T_ambient - self.T);
        let i = u.i + self.i_filter;
        *dx = Self {
            soc: -i / (3600.0 * p.capacity),
            v_1: (i - self.v_1 / p.R_1) / p.C_1,
            i_filter: (u.i_load.iter().sum::<f64>() - self.i_filter) / p.T_filter,
            T: heat / p.heat_capacity,
        };
    }

    fn outputs(&self, p: &Parameters, u: &Input) -> Output {
        let open_circuit = VOLTAGE[0] + (VOLTAGE[1] - VOLTAGE[0]) * self.soc;
        let i = u.i + self.i_filter;
        Output {
            v: p.cells * (open_circuit - p.R_0 * i - self.v_1),
            P_loss: p.cells * (p.R_0 * i * i + self.v_1 * self.v_1 / p.R_1),
        }
    }
}

export_fmu!(Battery);

#[cfg(test)]
mod tests {
    use super::*;

    /// Names, units and dependencies of the variables against what the model does.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<Battery>(), [""; 0]);
    }

    /// Oracle: at a constant current i the charge falls by i t/Q, the RC pair follows R_1 i (1 −
    /// exp(−t/τ)) with τ = R_1 C_1 = 16 s. The solver of order 4 errs by (h/τ)⁴/120 of it, with its
    /// steps of h = 0.1 s: 1.3e-11. The charge is a sum of 400 parts, each rounded.
    #[test]
    fn a_constant_current_discharges_it() {
        let (p, mut u) = <Battery as Model>::defaults();
        u.i = 80.0;
        let mut cell = Battery { soc: 0.9, v_1: 0.0, i_filter: 0.0, T: 298.15 };
        Model::step(&mut cell, &p, &InputPolynomial::held(u), &(), 0.0, 40.0).unwrap();
        let v_1 = -p.R_1 * u.i * (-40.0 / (p.R_1 * p.C_1)).exp_m1();
        let soc = 0.9 - u.i * 40.0 / (3600.0 * p.capacity);
        assert!((cell.v_1 - v_1).abs() < 1e-10 * v_1, "{} {v_1}", cell.v_1);
        assert!((cell.soc - soc).abs() < 400.0 * f64::EPSILON, "{} {soc}", cell.soc);
        let v = 3.0 + 1.2 * soc - p.R_0 * u.i - v_1;
        assert!((cell.outputs(&p, &u).v - v).abs() < 1e-10, "{v}");
    }
}
