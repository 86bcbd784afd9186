//! Outputs and steps of the actuator allocate nothing.

use allocation_counter::measure;
use rig::{Drive, Extras, Input, Rig};

#[test]
fn outputs_and_steps_allocate_nothing() {
    for drive in [Drive::Motion, Drive::Force] {
        let p = machine_file::Machine::reference().emla.lift;
        let rig = Rig::new(p, Extras::AS_BUILT, drive).expect("valid");
        let u = Input {
            v_q: 40.0,
            v_dc: Some(650.0),
            T_ambient: 293.15,
            x: 0.3,
            x_dot: 0.02,
            F_ext: 21e3,
            F_hold: 20e3,
            ..Input::default()
        };
        let mut s = rig.start(&u, [293.15; 2]).expect("finite");
        let made = measure(|| {
            for k in 0..100 {
                s = rig.step(&s, &u, f64::from(k) * 1e-3, 1e-3).expect("finite");
                std::hint::black_box(rig.output(&s, &u));
            }
        });
        assert_eq!(made.count_total, 0, "{drive:?}");
    }
}
