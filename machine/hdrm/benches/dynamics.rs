//! Cost of the plant's calls: `cargo bench -p hdrm`.

#[path = "../../../tools/benches/measure.rs"]
mod measure;

use hdrm::{Hdrm, Input, Options, State};
use machine_file::Machine;
use std::hint::black_box;

fn main() {
    let bench = measure::Bench::from_arguments();
    let machine = Machine::reference();
    let hdrm = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("valid reference");
    let state = State {
        zeta: machine.start.zeta,
        zeta_dot: [0.11, -0.07, 0.13, 0.31, -0.23, 0.17],
        ..State::default()
    };
    let input = Input {
        f: [100.0, 41143.0, 32179.0],
        tau_wrist: [-90.2, 147.2, 0.0],
        wrench_env: [10.0, 20.0, 30.0, 4.0, 5.0, 6.0],
        ..Input::default()
    };
    bench.call("forward dynamics", || {
        black_box(hdrm.forward_dynamics(black_box(&state), black_box(&input)));
    });
    bench.call("inverse dynamics (tree)", || {
        black_box(hdrm.inverse_dynamics(black_box(&state), &[0.1; 6], &[0.0; 6]));
    });
    bench.call("manipulator step of 1 ms (RK4)", || {
        let input = black_box(input);
        let _ = black_box(hdrm.step(black_box(&state), |_| input, 0.0, 1e-3));
    });
    bench.call("manipulator outputs", || {
        black_box(hdrm.output(black_box(&state), black_box(&input)));
    });
    bench.call("manipulator outputs + step of 1 ms (as coupled)", || {
        let input = black_box(input);
        let dynamics = hdrm.dynamics(black_box(&state));
        black_box(hdrm.output_at(&dynamics, &input));
        let _ = black_box(hdrm.step_from(&dynamics, |_| input, 0.0, 1e-3));
    });
    bench.call("manipulator output derivatives", || {
        let input = black_box(input);
        black_box(hdrm.output_derivative(black_box(&state), &input, &input));
    });
}
