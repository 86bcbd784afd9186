use fmu_export::prelude::*;

#[derive(Parameters)]
struct Motor {
    #[fmu(unit = "kg.m2", start = 0.1)]
    inertia: f64,
    /// Resistance
    #[fmu(start = 0.5)]
    resistance: f64,
    /// Pole pairs
    pole_pairs: i32,
}

#[derive(Input)]
struct Voltages {
    /// Voltage
    u: [f64; 3],
    enable: bool,
}

#[derive(State)]
#[fmu(parameters = Motor, input = Voltages)]
struct Currents {
    /// Current
    #[fmu(unit = "A")]
    i: f64,
}

fn main() {}
