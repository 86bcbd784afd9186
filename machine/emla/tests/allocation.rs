//! Outputs, their derivatives and steps of the actuator allocate nothing, and the shipped network
//! takes no memory.
#![allow(non_snake_case)]

use allocation_counter::measure;
use emla::{Drive, Emla, Input, Surrogate};
use machine_file::Machine;

#[test]
fn outputs_and_steps_allocate_nothing() {
    for drive in [Drive::Motion, Drive::Force] {
        let emla = Emla::new(Machine::reference().emla.lift, drive)
            .expect("reference")
            .with_surrogate(Surrogate::reference(), 0.3)
            .with_delay(1);
        let u = Input {
            v_q: 40.0,
            x: 0.3,
            x_dot: 0.02,
            F_ext: 21e3,
            F_hold: 20e3,
            ..Input::default()
        };
        let mut s = emla.start(&u).expect("finite");
        let made = measure(|| {
            for k in 0..100 {
                let t = f64::from(k) * 1e-3;
                s = emla.step(&s, |at| u.moved(at), t, 1e-3).expect("finite");
                std::hint::black_box(emla.output(&s, &u));
                std::hint::black_box(emla.output_dot(&s, &u, &Input::default()));
                std::hint::black_box(emla.output_along(&s, &u, &u));
            }
        });
        assert_eq!(made.count_total, 0, "{drive:?}");
    }
    assert_ne!(
        measure(|| drop(std::hint::black_box(vec![0_u8]))).count_total,
        0,
        "it counts"
    );
}

/// It is compiled in; one that was read is shared by its clones.
#[test]
fn the_shipped_network_takes_no_memory_and_a_read_one_is_shared() {
    let counted = measure(|| drop(Surrogate::reference().clone()));
    assert_eq!(counted.count_total, 0, "{} bytes", counted.bytes_total);
    let read = Surrogate::from_json(&Surrogate::reference().to_json()).expect("valid");
    let counted = measure(|| drop(read.clone()));
    assert_eq!(counted.count_total, 0, "{} bytes", counted.bytes_total);
}
