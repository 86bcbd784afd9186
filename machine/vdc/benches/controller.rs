//! Cost of the controller per communication point, with adaptation: `cargo bench -p vdc`.
#![allow(non_snake_case)]

#[path = "../../../tools/benches/measure.rs"]
mod measure;

use emla::Surrogate;
use machine_file::Machine;
use std::hint::black_box;
use vdc::{Controller, Input, Mode, Settings, Trajectory};

/// Communication step, s.
const H: f64 = 1e-3;
/// Steps after which the controller starts anew: in open loop it must not run out of the numbers.
const STEPS: u32 = 2000;

fn main() {
    let bench = measure::Bench::from_arguments();
    let machine = Machine::reference();
    let input = Input {
        zeta: machine.start.zeta,
        zeta_dot: [0.011, -0.007, 0.013, 0.031, -0.023, 0.017],
        i_q: [2.0, 9.0, 8.0],
        w_m: [5.0, 40.0, 60.0],
        x_dot: [1e-3, 8e-3, 12e-3],
        F: [100.0, 41143.0, 32179.0],
        ..Input::default()
    };
    for (name, mode, alpha) in [
        ("controller output + step (adaptive)", Mode::Adaptive, 0.0),
        (
            "controller output + step (adaptive, hybrid)",
            Mode::Adaptive,
            0.2,
        ),
        ("controller output + step (pd)", Mode::Pd, 0.0),
    ] {
        let settings = Settings {
            mode,
            alpha,
            ..Settings::from_gains(&machine.controller)
        };
        let fresh = Controller::new(
            &machine,
            &Surrogate::reference(),
            Trajectory::Cubic,
            &settings,
            &input,
            0.0,
        )
        .expect("the reference machine works");
        let (mut controller, mut k) = (fresh.clone(), 0);
        bench.call(name, || {
            if k == STEPS {
                (controller, k) = (fresh.clone(), 0);
            }
            let now = controller.evaluate(&settings, black_box(&input));
            let now = now.expect("finite");
            black_box(now.output(&input.F));
            let stepped = controller.step(&now, &settings, &input, f64::from(k) * H, H);
            stepped.expect("finite");
            k += 1;
        });
    }
}
