//! Cost of the actuator's calls: `cargo bench -p emla`.
#![allow(non_snake_case)]

#[path = "../../../tools/benches/measure.rs"]
mod measure;

use emla::{Drive, Emla, Input, Surrogate};
use std::hint::black_box;

fn main() {
    let bench = measure::Bench::from_arguments();
    let p = machine_file::Machine::reference().emla.lift;
    let u = Input {
        v_q: 60.0,
        x: 0.3,
        x_dot: 0.03,
        F_ext: 30e3,
        F_hold: 30e3,
        ..Input::default()
    };
    let network = Surrogate::reference();
    bench.call("surrogate evaluation, near standstill", || {
        black_box(network.evaluate(black_box(20.0), black_box(2.0)));
    });
    bench.call("surrogate evaluation", || {
        black_box(network.evaluate(black_box(20.0), black_box(90.0)));
    });
    for (drive, moved) in [(Drive::Motion, "motion"), (Drive::Force, "force")] {
        let physics = Emla::new(p, drive).expect("reference");
        let hybrid = physics.clone().with_surrogate(network.clone(), 0.2);
        for (kind, emla) in [("", physics), (", hybrid", hybrid)] {
            let s = emla.start(&u).expect("finite");
            bench.call(
                &format!("actuator step of 1 ms ({moved}-driven{kind})"),
                || {
                    let _ =
                        black_box(emla.step(black_box(&s), |t| black_box(&u).moved(t), 0.0, 1e-3));
                },
            );
            if moved == "motion" && kind.is_empty() {
                bench.call("actuator outputs", || {
                    black_box(emla.output(black_box(&s), black_box(&u)));
                });
            }
        }
    }
}
