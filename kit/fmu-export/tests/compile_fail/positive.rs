use fmu_export::prelude::*;

/// Falls in steps of no length
#[derive(State)]
#[fmu(parameters = (), max_step = 0.0)]
struct Fixed {
    /// Height
    #[fmu(unit = "m")]
    height: f64,
}

impl Ode for Fixed {
    fn derivative(&self, _p: &(), _u: &(), _t: f64, dx: &mut Self) {
        dx.height = -1.0;
    }
}

/// Falls without an error
#[derive(State)]
#[fmu(parameters = (), solver = "stiff", tolerance = -1e-6)]
struct Stiff {
    /// Height
    #[fmu(unit = "m")]
    height: f64,
}

impl Ode for Stiff {
    fn derivative(&self, _p: &(), _u: &(), _t: f64, dx: &mut Self) {
        dx.height = -1.0;
    }
}

const READ_BY_FIXED: f64 = <Fixed as State>::MAX_STEP;
const READ_BY_STIFF: f64 = <Stiff as State>::TOLERANCE;

fn main() {
    println!("{READ_BY_FIXED} {READ_BY_STIFF}");
}
