use fmu_export::prelude::*;

#[derive(Output)]
struct Race {
    /// Distance
    #[fmu(unit = "furlong")]
    distance: f64,
    /// Speed
    #[fmu(unit = "m/s", display_unit = "furlong/s")]
    speed: f64,
}

fn main() {}
