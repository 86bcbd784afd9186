//! Evaluations, outputs and steps of the controller allocate nothing, whatever its timing.
#![allow(non_snake_case)]

use allocation_counter::measure;
use emla::Surrogate;
use machine_file::Machine;
use vdc::{Controller, Input, RateCommand, RateLimits, Settings, Timing, Trajectory};

#[test]
fn evaluations_and_steps_allocate_nothing() {
    let machine = Machine::reference();
    let settings = Settings {
        alpha: 0.2,
        ..Settings::from_gains(&machine.controller)
    };
    let u = Input {
        zeta: machine.start.zeta,
        F: [0.0, 41_143.0, 32_179.0],
        ..Input::default()
    };
    let timings = [(0.0, 0), (0.0, 1), (2e-3, 0), (3e-4, 0), (2e-3, 2)];
    let cubic = timings.map(|timing| (timing, Trajectory::Cubic, RateCommand::Joint));
    let rates = [RateCommand::Joint, RateCommand::Tip]
        .map(|command| ((0.0, 0), Trajectory::Rates(RateLimits::default()), command));
    for ((sample_time, delay), path, rate_command) in cubic.into_iter().chain(rates) {
        let network = Surrogate::reference();
        let settings = Settings {
            rate_command,
            ..settings
        };
        let u = Input {
            rate_joint: [0.1; 6],
            rate_tip: [0.1; 6],
            ..u
        };
        let mut controller = Controller::new(&machine, &network, path, &settings, &u, 0.0)
            .expect("works")
            .with_timing(Timing { sample_time, delay });
        let made = measure(|| {
            for k in 0..100 {
                let now = controller.evaluate(&settings, &u).expect("finite");
                std::hint::black_box(now.output(&u.F));
                let t = f64::from(k) * 1e-3;
                controller
                    .step(&now, &settings, &u, t, 1e-3)
                    .expect("finite");
            }
        });
        assert_eq!(made.count_total, 0, "sample {sample_time}, delay {delay}");
    }
    assert_ne!(
        measure(|| drop(std::hint::black_box(vec![0_u8]))).count_total,
        0,
        "it counts"
    );
}
