use fmu_export::prelude::*;

const CELLS: usize = 3;

#[derive(Parameters)]
struct Cell {
    /// Resistance
    #[fmu(unit = "Ohm", start = 1.0)]
    R: f64,
}

#[derive(Parameters)]
struct Parameters {
    /// Without a length
    #[fmu(unit = "K", start = 1.0)]
    vector: Vec<f64>,
    /// With two lengths
    #[fmu(unit = "K", start = 1.0, len = 5)]
    array: [f64; 5],
    /// Without bounds
    #[fmu(structural, start = 5)]
    n: i32,
    /// Not a size
    #[fmu(structural, unit = "1", start = 5.0)]
    x: f64,
    cells: [Cell; CELLS],
}

#[derive(Parameters)]
struct Texts {
    /// Names
    names: Vec<&'static str>,
}

#[derive(Input)]
struct Input {
    /// Too long for the stack
    #[fmu(unit = "K")]
    long: [f64; 100_000],
    /// Too large for the stack
    #[fmu(unit = "K")]
    large: [[f64; 300]; 100],
}

fn main() {}
