use fmu_export::prelude::*;

#[derive(Parameters)]
struct Wrong {
    /// Perhaps a mass
    #[fmu(unit = "kg", start = 1.0)]
    maybe: Option<f64>,
    /// Half a mass
    #[fmu(unit = "kg", start = 1.0)]
    single: isize,
    /// How many
    #[fmu(start = 1)]
    count: usize,
    /// Some masses
    #[fmu(unit = "kg", start = 1.0)]
    many: Vec<f64>,
    /// Names
    #[fmu(start = "a")]
    names: [&'static str; 2],
}

#[derive(Output)]
struct Seen {
    /// What it does
    does: char,
}

#[derive(State)]
struct Gear {
    /// Which one
    number: i32,
}

#[derive(Input)]
struct Pair(f64, f64);

#[derive(Input)]
struct Generic<T> {
    /// Anything
    any: T,
}

fn main() {}
