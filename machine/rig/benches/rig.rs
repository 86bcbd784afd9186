//! Cost of the calls of the actuator as built: `cargo bench -p rig`.

#[path = "../../../tools/benches/measure.rs"]
mod measure;

use rig::{Drive, Extras, Input, Rig};
use std::hint::black_box;

fn main() {
    let bench = measure::Bench::from_arguments();
    let p = machine_file::Machine::reference().emla.lift;
    let u = Input {
        v_q: 60.0,
        v_dc: Some(650.0),
        T_ambient: 293.15,
        x: 0.3,
        x_dot: 0.03,
        F_ext: 30e3,
        F_hold: 30e3,
        ..Input::default()
    };
    for (drive, moved) in [(Drive::Motion, "motion"), (Drive::Force, "force")] {
        let all = Extras::AS_BUILT;
        for (kind, extras) in [("", all), (", extras off", all.off())] {
            let rig = Rig::new(p, extras, drive).expect("reference");
            let s = rig.start(&u, [293.15; 2]).expect("finite");
            let name = format!("rig step of 1 ms ({moved}-driven{kind})");
            bench.call(&name, || {
                let _ = black_box(rig.step(black_box(&s), black_box(&u), 0.0, 1e-3));
            });
            if moved == "motion" && kind.is_empty() {
                bench.call("rig outputs", || {
                    black_box(rig.output(black_box(&s), black_box(&u)));
                });
            }
        }
    }
}
