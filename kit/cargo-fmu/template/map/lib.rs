//! FMU `Drive`: a motor whose efficiency is a map from a file, to be replaced by a model of your own.
//!
//! The map is `resources/efficiency.csv`: the one in the archive, if a user has edited it there. An
//! importer may name another file.

use fmu_export::prelude::*;
use fmu_export::read_parameter_file;
use fmu_export::tables::{Between, Column, Map};
use std::path::Path;

/// What the columns of a file are.
const COLUMNS: [Column; 3] = [
    Column::new("speed", "rad/s").within(0.0, 2e3),
    Column::new("torque", "N.m").within(0.0, 1e4),
    Column::new("efficiency", "1").within(0.01, 1.0),
];

fn read(text: &str) -> Result<Map, String> {
    Map::read(text, COLUMNS, Between::Monotone)
}

/// The map that is packed.
fn packed_map() -> Map {
    read(include_str!("../resources/efficiency.csv")).expect("it is read in a test")
}

fn read_file(p: &mut Parameters, path: &str, resources: Option<&Path>) -> Result<(), String> {
    p.efficiency = read_parameter_file(path, resources, read)?;
    path.clone_into(&mut p.map);
    Ok(())
}

#[derive(Parameters)]
struct Parameters {
    /// File with the efficiency over speed and torque
    #[fmu(start = "efficiency.csv", set = read_file)]
    map: String,
    #[fmu(skip, start = packed_map())]
    efficiency: Map,
    /// Heat capacity
    #[fmu(unit = "J/K", start = 5000.0, min = 1.0)]
    capacity: f64,
    /// Heat conductance to the surroundings
    #[fmu(unit = "W/K", start = 20.0, min = 0.0)]
    cooling: f64,
}

#[derive(Input)]
struct Input {
    /// Speed
    #[fmu(unit = "rad/s", display_unit = "rpm")]
    speed: f64,
    /// Torque
    #[fmu(unit = "N.m")]
    torque: f64,
    /// Temperature of the surroundings
    #[fmu(unit = "K", display_unit = "degC", start = 293.15, min = 1.0)]
    T_ambient: f64,
}

#[derive(Output)]
struct Output {
    /// Electrical power
    #[fmu(unit = "W", depends_on(speed, torque), initially_depends_on(speed, torque, map))]
    P: f64,
    /// Losses
    #[fmu(unit = "W", depends_on(speed, torque), initially_depends_on(speed, torque, map))]
    P_loss: f64,
}

/// A motor with the efficiency of a map, and one heat node
#[derive(State)]
#[fmu(parameters = Parameters, input = Input, output = Output, model_exchange, solver = "adaptive", experiment(0.0, 600.0, 1.0))]
struct Drive {
    /// Temperature
    #[fmu(unit = "K", display_unit = "degC", start = 293.15, nominal = 300.0)]
    T: f64,
}

impl Ode for Drive {
    fn derivative(&self, p: &Parameters, u: &Input, _t: f64, dx: &mut Self) {
        dx.T = (self.outputs(p, u).P_loss - p.cooling * (self.T - u.T_ambient)) / p.capacity;
    }

    /// As a generator it gives what is left of the power.
    fn outputs(&self, p: &Parameters, u: &Input) -> Output {
        let efficiency = p.efficiency.at(u.speed.abs(), u.torque.abs());
        let mechanical = u.speed * u.torque;
        let P = if mechanical > 0.0 { mechanical / efficiency } else { mechanical * efficiency };
        Output { P, P_loss: P - mechanical }
    }
}

export_fmu!(Drive);

#[cfg(test)]
mod tests {
    use super::*;

    /// Names, units and dependencies of the variables against what the model does.
    #[test]
    fn the_table_agrees_with_the_model() {
        assert_eq!(fmu_export::check::<Drive>(), [""; 0]);
    }

    /// Oracle: a node of the map, 3000 rpm and 50 N·m: 94 %. The temperature rises towards P_loss over
    /// the conductance with τ = 250 s. Tolerance: ten times that of an internal step, 1e-6 of 300 K.
    #[test]
    fn losses_are_those_of_the_map_and_heat_it() {
        let (p, mut u) = Drive::defaults();
        (u.speed, u.torque) = (100.0 * std::f64::consts::PI, 50.0);
        let mut drive = Drive::initialize(&p, &u, 0.0).unwrap();
        let loss = 5000.0 * std::f64::consts::PI * (1.0 / 0.94 - 1.0);
        assert!((drive.outputs(&p, &u).P_loss - loss).abs() < 1e-10 * loss);
        Model::step(&mut drive, &p, &InputPolynomial::held(u), &(), 0.0, 100.0).unwrap();
        let exact = 293.15 - loss / 20.0 * (-100.0_f64 / 250.0).exp_m1();
        assert!((drive.T - exact).abs() < 10.0 * 1e-6 * 300.0, "{} {exact}", drive.T);
    }

    #[test]
    fn a_wrong_file_is_refused_with_its_line() {
        let error = read("speed [rpm],torque [N.m],efficiency [%]\n0,0,140\n").unwrap_err();
        assert_eq!(error, "line 2: `efficiency` = 1.4 1 must be from 0.01 to 1");
    }
}
