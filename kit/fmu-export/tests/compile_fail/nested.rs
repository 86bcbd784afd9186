use fmu_export::prelude::*;

// Not derived.
struct Winding {
    resistance: f64,
}

#[derive(Parameters)]
struct Parameters {
    /// Winding
    winding: Winding,
}

// Derived for another purpose.
#[derive(Parameters)]
struct Supply {
    /// Voltage
    #[fmu(unit = "V", start = 24.0)]
    voltage: f64,
}

#[derive(Input)]
struct Input {
    /// Supply
    supply: Supply,
}

/// Current
#[derive(State)]
#[fmu(parameters = Parameters, input = Input)]
struct Motor {
    /// Current
    #[fmu(unit = "A")]
    current: f64,
}

impl Ode for Motor {
    fn derivative(&self, p: &Parameters, u: &Input, _t: f64, dx: &mut Self) {
        let voltage = u.supply.voltage - p.winding.resistance * self.current;
        dx.current = voltage;
    }
}

export_fmu!(Motor);

fn main() {}
