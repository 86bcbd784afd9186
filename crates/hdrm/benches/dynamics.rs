//! Cost of the plant's calls on one core, median of repeated batches:
//! `cargo bench -p hdrm`.

use hdrm::{Hdrm, Input, Options, State};
use machine::Machine;
use std::hint::black_box;
use std::time::Instant;

const BATCHES: usize = 101;
const CALLS: u32 = 2000;

/// Prints the median time per call, ns.
fn measure(name: &str, mut call: impl FnMut()) {
    let mut times: Vec<f64> = (0..BATCHES)
        .map(|_| {
            let start = Instant::now();
            for _ in 0..CALLS {
                call();
            }
            start.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS)
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let (low, median) = (times[0], times[BATCHES / 2]);
    println!("{name:<24} {median:8.1} ns   (fastest batch {low:.1} ns)");
}

fn main() {
    let machine = Machine::reference();
    let hdrm = Hdrm::new(&machine, &Options::of(&machine)).expect("valid reference");
    let state = State {
        zeta: machine.start.zeta,
        zeta_dot: [0.11, -0.07, 0.13, 0.31, -0.23, 0.17],
    };
    let input = Input {
        f: [100.0, 41143.0, 32179.0],
        tau_wrist: [-90.2, 147.2, 0.0],
        wrench_env: [10.0, 20.0, 30.0, 4.0, 5.0, 6.0],
    };
    measure("forward dynamics", || {
        black_box(hdrm.forward_dynamics(black_box(&state), black_box(&input)));
    });
    measure("inverse dynamics (tree)", || {
        black_box(hdrm.inverse_dynamics(black_box(&state), &[0.1; 6], &[0.0; 6]));
    });
    measure("configuration (tree)", || {
        black_box(hdrm.tree().configuration(black_box(&state.zeta)));
    });
    measure("step of 1 ms (RK4)", || {
        let input = black_box(input);
        let _ = black_box(hdrm.step(black_box(&state), |_| input, 0.0, 1e-3));
    });
    measure("outputs", || {
        black_box(hdrm.output(black_box(&state), black_box(&input)));
    });
    measure("output derivatives", || {
        let input = black_box(input);
        black_box(hdrm.output_derivative(black_box(&state), &input, &input));
    });
}
