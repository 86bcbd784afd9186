//! Outputs, their derivatives and steps of the manipulator allocate nothing, in free motion and in
//! an end stop.
#![allow(non_snake_case)]

use allocation_counter::measure;
use hdrm::{Hdrm, Input, Options, State};
use machine_file::Machine;

#[test]
fn outputs_and_steps_allocate_nothing() {
    let machine = Machine::reference();
    let hdrm = Hdrm::new(&machine, &Options::from_machine(&machine)).expect("works");
    let mut stopped = machine.start.zeta;
    stopped[4] = machine.limits.zeta()[4][1] + 1e-3;
    for zeta in [machine.start.zeta, stopped] {
        let mut state = State {
            zeta,
            zeta_dot: [0.01; 6],
            ..State::default()
        };
        let u = Input {
            f: [100.0, 40e3, 30e3],
            ..Input::default()
        };
        let made = measure(|| {
            for k in 0..100 {
                let start = hdrm.dynamics(&state);
                std::hint::black_box(hdrm.output_at(&start, &u));
                std::hint::black_box(hdrm.output_derivative(&state, &u, &u));
                std::hint::black_box(hdrm.directional_derivative(&state, &u, &u));
                let t = f64::from(k) * 1e-3;
                state = hdrm.step_from(&start, |_| u, t, 1e-3).expect("finite");
            }
        });
        assert_eq!(made.count_total, 0);
    }
    assert_ne!(
        measure(|| drop(std::hint::black_box(vec![0_u8]))).count_total,
        0,
        "it counts"
    );
}
