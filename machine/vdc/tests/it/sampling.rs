//! A controller with a sample time of its own gives the same outputs whatever the communication
//! steps.

use emla::Surrogate;
use machine_file::Machine;
use vdc::{Controller, Input, Output, Settings, Timing, Trajectory};

/// Time between two samples, s.
const T: f64 = 2e-3;
/// Samples that are looked at.
const SAMPLES: u32 = 20;

/// Measurements that change from sample to sample, so that all states of the law move.
fn measured(machine: &Machine, t: f64) -> Input {
    let slow = (37.0 * t).sin();
    Input {
        zeta: machine.start.zeta.map(|zeta| zeta + 1e-4 * slow),
        zeta_dot: [0.011, -0.007, 0.013, 0.031, -0.023, 0.017].map(|rate| rate * slow),
        i_q: [2.0, 9.0 + slow, 8.0],
        w_m: [5.0, 40.0 * slow, 60.0],
        x_dot: [1e-3, 8e-3, 12e-3],
        F: [100.0, 41_143.0, 32_179.0 + 500.0 * slow],
        ..Input::default()
    }
}

/// Outputs at the end of each step of `h`, s, where inputs are set at the samples only.
fn run(h: f64, timing: Timing) -> Vec<Output> {
    let mut machine = Machine::reference();
    machine.controller.settle_time = 0.0;
    let settings = Settings::from_gains(&machine.controller);
    let surrogate = Surrogate::reference();
    let mut u = measured(&machine, 0.0);
    let mut controller =
        Controller::new(&machine, &surrogate, Trajectory::Cubic, &settings, &u, 0.0)
            .expect("works")
            .with_timing(timing);
    let steps = (f64::from(SAMPLES) * T / h).round() as u32;
    let mut outputs = Vec::new();
    for k in 0..steps {
        let t = f64::from(k) * h;
        if (t / T - (t / T).round()).abs() < 1e-6 {
            u = measured(&machine, t);
        }
        let now = controller.evaluate(&settings, &u).expect("finite");
        controller.step(&now, &settings, &u, t, h).expect("finite");
        let now = controller.evaluate(&settings, &u).expect("finite");
        outputs.push(now.output(&u.F));
    }
    outputs
}

#[test]
fn outputs_at_the_samples_do_not_depend_on_the_steps() {
    let sampled = Timing {
        sample_time: T,
        delay: 0,
    };
    let whole = run(T, sampled);
    assert_ne!(whole[3].v_q, whole[4].v_q, "the outputs change");
    let unsampled = run(T, Timing::default())[0].v_q;
    for parts in [2_usize, 4] {
        let h = T / parts as f64;
        let finer = run(h, sampled);
        for (k, at_sample) in whole.iter().enumerate() {
            let last = parts * (k + 1) - 1;
            assert_eq!(finer[last], *at_sample, "{parts} steps, sample {k}");
        }
        // What the sample time is for: without it they differ.
        assert_ne!(run(h, Timing::default())[parts - 1].v_q, unsampled);
    }
}

/// A sample at every communication point is the controller without a sample time, up to the
/// rounding of its clock.
#[test]
fn a_sample_at_each_step_takes_its_measurements() {
    let sampled = Timing {
        sample_time: T,
        delay: 0,
    };
    for (k, (a, b)) in run(T, sampled)
        .iter()
        .zip(run(T, Timing::default()))
        .enumerate()
    {
        for (a, b) in a.v_q.iter().zip(b.v_q) {
            assert!(
                (a - b).abs() < 1e-9 * b.abs().max(1.0),
                "step {k}: {a} and {b} V"
            );
        }
    }
}

/// Between two samples nothing changes, and a clock that is off by rounding meets the samples.
#[test]
fn outputs_change_at_the_samples_only() {
    for delay in [0, 1] {
        let timing = Timing {
            sample_time: T,
            delay,
        };
        let outputs = run(T / 4.0, timing);
        let mut changes = 0;
        for (k, pair) in outputs.windows(2).enumerate() {
            // At a sample the outputs are those of the old measurements first, then of those that
            // are set there. With a delay they appear after the step that begins with the sample.
            let end = k + 2;
            let is_sample = end % 4 == 1 || (delay == 0 && end % 4 == 0);
            let changed = pair[0].v_q != pair[1].v_q;
            assert!(is_sample || !changed, "delay {delay}, step {end}");
            changes += u32::from(changed);
        }
        assert!(changes >= SAMPLES - 1, "delay {delay}: {changes} changes");
    }
}

/// Samples inside a step are taken with the inputs of that step.
#[test]
fn a_step_may_hold_several_samples() {
    let of = |h: f64, sample_time: f64| {
        let timing = Timing {
            sample_time,
            delay: 0,
        };
        run(h, timing).last().copied().expect("steps were made")
    };
    assert_eq!(of(T, T / 4.0), of(T / 2.0, T / 4.0));
    assert_ne!(of(T, T / 4.0), of(T, T));
}

/// With a delay of d steps the outputs after a step belong to the time at which they act: after
/// step k the reference is that of the time `(k + d) h`, which a controller without delay has after
/// step `k + d − 1`.
#[test]
fn delayed_outputs_belong_to_the_time_at_which_they_act() {
    let undelayed = run(T, Timing::default());
    for delay in [1, 2, 4] {
        let timing = Timing {
            delay,
            ..Timing::default()
        };
        let delayed = run(T, timing);
        let ahead = delay as usize - 1;
        for (k, output) in delayed.iter().take(SAMPLES as usize - ahead).enumerate() {
            let expected = undelayed[k + ahead].desired_position;
            for (a, b) in output.desired_position.iter().zip(expected) {
                // Rounding of the clock at 0.04 m/s, and of the position.
                assert!((a - b).abs() < 1e-15, "delay {delay}, step {k}: {a} {b} m");
            }
        }
        let last = |outputs: &[Output]| outputs.last().expect("steps").desired_position;
        assert!(ahead == 0 || last(&delayed) != last(&undelayed));
    }
}
