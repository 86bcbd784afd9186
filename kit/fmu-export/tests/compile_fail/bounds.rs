use fmu_export::prelude::*;

#[derive(Parameters)]
struct Wrong {
    /// Mass
    #[fmu(unit = "kg", start = -1.0, min = 0.0)]
    mass: f64,
    /// Corners
    #[fmu(unit = "m", start = [0.5, 2.5], max = 1)]
    corners: [f64; 2],
    /// Level
    #[fmu(start = 3, min = 5, max = -5)]
    level: i32,
}

fn main() {}
