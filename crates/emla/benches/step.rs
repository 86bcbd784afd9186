//! Time of the actuator's step and outputs: `cargo bench -p emla`.
#![allow(non_snake_case)]

use emla::{Drive, Emla, Input, InputPath, Surrogate};
use std::hint::black_box;
use std::time::Instant;

/// Prints the best of several batches: the least disturbed one.
fn measure(name: &str, mut call: impl FnMut()) {
    const CALLS: u32 = 20_000;
    let batch = |call: &mut dyn FnMut()| {
        let start = Instant::now();
        (0..CALLS).for_each(|_| call());
        start.elapsed().as_secs_f64() / f64::from(CALLS)
    };
    let best = (0..10).map(|_| batch(&mut call)).fold(f64::MAX, f64::min);
    println!("{name}: {:.3} µs", 1e6 * best);
}

fn main() {
    let p = machine::Machine::reference().emla;
    let u = Input {
        v_q: 60.0,
        x: 0.3,
        x_dot: 0.03,
        F_ext: 30e3,
        F_hold: 30e3,
        ..Input::default()
    };
    for drive in [Drive::Motion, Drive::Force] {
        let physics = Emla::new(p, drive).expect("reference");
        let hybrid = physics.clone().with_surrogate(Surrogate::reference(), 0.2);
        for (name, emla) in [("physics", physics), ("with network", hybrid)] {
            let s = emla.start(&u).expect("finite");
            let path = InputPath::held(u);
            measure(&format!("{drive:?}, {name}: step of 1 ms"), || {
                let _ = black_box(emla.step(black_box(&s), black_box(&path), 0.0, 1e-3));
            });
            measure(&format!("{drive:?}, {name}: outputs"), || {
                black_box(emla.output(black_box(&s), black_box(&u)));
            });
        }
    }
}
