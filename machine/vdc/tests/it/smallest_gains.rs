//! Gains next to zero are allowed, and must not take the numbers out of their range.

use emla::Surrogate;
use machine_file::Machine;
use vdc::{Controller, Input, Settings, Trajectory};

#[test]
fn the_smallest_gains_keep_outputs_finite() {
    let machine = Machine::reference();
    let input = Input {
        zeta: machine.start.zeta,
        i_q: [2.0, 9.0, 8.0],
        w_m: [5.0, 40.0, -60.0],
        F: [1e8, -1e8, 3e4],
        ..Input::default()
    };
    for (omega_d, K_v) in [(f64::MIN_POSITIVE, 900.0), (5e-324, 900.0), (300.0, 1e-307)] {
        let mut settings = Settings::from_gains(&machine.controller);
        (settings.gains.omega_d, settings.gains.K_v) = (omega_d, K_v);
        let surrogate = Surrogate::reference();
        let path = Trajectory::Cubic;
        let mut controller =
            Controller::new(&machine, &surrogate, path, &settings, &input, 0.0).expect("works");
        for k in 0..3 {
            let now = controller.evaluate(&settings, &input).expect("numbers");
            let y = now.output(&input.F);
            let outputs = y.v_d.iter().chain(&y.v_q).chain(&y.nu_actuator);
            for value in outputs.chain(&y.dissipation_actuator) {
                assert!(
                    value.is_finite(),
                    "omega_d = {omega_d:e}, K_v = {K_v:e}: {value}"
                );
            }
            let t = f64::from(k) * 1e-3;
            controller
                .step(&now, &settings, &input, t, 1e-3)
                .expect("a step");
        }
    }
}
