use fmu_export::prelude::*;

// Not derived.
#[derive(Clone, Copy)]
enum Gear {
    First,
    Second,
}

// Not derived.
struct Parameters {
    gear: Choice<Gear>,
}

#[derive(Input)]
struct Input {
    /// Gear
    #[fmu(start = Gear::First)]
    gear: Choice<Gear>,
}

/// A drive
#[derive(State)]
#[fmu(parameters = Parameters, input = Input)]
struct Drive {
    /// Speed
    #[fmu(unit = "rad/s")]
    speed: f64,
}

export_fmu!(Drive);

fn main() {}
