use fmu_export::prelude::*;

#[derive(Input)]
struct Input {
    /// Voltage
    #[fmu(unit = "V", tunable)]
    u: f64,
    /// Gear
    #[fmu(unit = "1")]
    gear: i32,
    /// Current
    #[fmu(unit = "A", units = "A")]
    i: f64,
    /// Charge
    #[fmu(unit = "A.s", unit = "A.h")]
    q: f64,
    /// Torque
    #[fmu(unit = "N.m", depends_on(u))]
    tau: f64,
}

#[derive(Output)]
struct Output {
    /// Voltage
    #[fmu(unit = "V", start = 1.0)]
    u: f64,
    /// Current
    #[fmu(unit = "A", depends_on(u + 1))]
    i: f64,
    #[fmu(unit = "A")]
    inner: Inner,
}

#[derive(Output)]
struct Inner {}

#[derive(State)]
#[fmu(step = 0.1)]
struct State {}

/// Solver that there is not
#[derive(State)]
#[fmu(input = Input, solver = "implicit")]
struct Solved {}

/// Tolerance of fixed steps
#[derive(State)]
#[fmu(input = Input, tolerance = 1e-4)]
struct Tolerant {}

fn main() {}
