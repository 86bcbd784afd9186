//! Tests of the supervisor's stages, gains and torques.

use super::swing::BAND;
use super::*;
use machine_file::Machine;
use std::f64::consts::TAU;

const H: f64 = 1e-3;
const RATINGS: [[f64; 2]; 3] = [[70e3, 0.07]; 3];
const QUIET: Observed = Observed {
    errors: [[0.0; 2]; 3],
    is_overloaded: false,
    alarm: None,
    reset: false,
    is_supplied: true,
};

/// Root mean square of what passes of a sine of amplitude 1 at `f` Hz.
fn passed(f: f64) -> f64 {
    let mut swing = Swing::default();
    for k in 0..10_000 {
        swing.add((TAU * f * H * f64::from(k)).sin(), H);
    }
    swing.square.sqrt()
}

/// Closed form of two high-passes and a low-pass of first order; tolerance: half the
/// ripple of the mean square, 1/(2·2π·f·0.3 s) of it, and 1 % for half a sample's phase.
#[test]
fn what_swings_is_what_lies_in_the_band() {
    for f in [3.0, 5.6, 9.0] {
        let [low, high] = BAND;
        let gain = f * f / (f * f + low * low) / (1.0 + (f / high).powi(2)).sqrt();
        let expected = gain / 2.0_f64.sqrt();
        let found = passed(f);
        assert!(
            (found / expected - 1.0).abs() < 0.5 / (2.0 * TAU * f * MEAN) + 0.01,
            "{f} Hz: {found}, {expected}"
        );
    }
    assert!(passed(0.3) < 0.03, "{}", passed(0.3));
}

/// Advances for `seconds` with errors of force and velocity whose amplitudes have the power
/// `share` of the rated one; what began, and when.
fn run(watch: &mut Supervisor, from: f64, seconds: f64, share: f64) -> Vec<(Stage, f64)> {
    let mut begun = Vec::new();
    // Of 5.6 Hz passes 0.855, twice; a product of amplitudes is twice that of its roots.
    let size = (2.0 * share).sqrt() / 0.855;
    for k in 0..(seconds / H) as u32 {
        let t = from + H * f64::from(k);
        let wave = size * (TAU * 5.6 * t).sin();
        let errors = [[0.0; 2], RATINGS[1].map(|rated| wave * rated), [0.0; 2]];
        let observed = Observed { errors, ..QUIET };
        if watch.advance(&observed, &RATINGS, t, H).is_some() {
            begun.push((watch.stage(), t + H));
        }
    }
    begun
}

/// An action after the other, each after the time that the one before was given; the stop along
/// the ramp and the closing of the brakes take their own times.
#[test]
fn what_goes_on_swinging_is_stopped_step_by_step() {
    let mut watch = Supervisor::new(true);
    let begun = run(&mut watch, 0.0, 8.0, 2.0 * UPPER);
    let stages: Vec<Stage> = begun.iter().map(|(stage, _)| *stage).collect();
    let expected = [
        Stage::Frozen,
        Stage::Lowered,
        Stage::Stopping,
        Stage::Braking,
        Stage::Stopped,
    ];
    assert_eq!(stages, expected);
    for (k, time) in [PATIENCE[0], PATIENCE[1], RAMP, CLOSING]
        .into_iter()
        .enumerate()
    {
        let waited = begun[k + 1].1 - begun[k].1;
        assert!(
            (waited - time).abs() < 1.5 * H,
            "{stages:?} {k}: {waited} s"
        );
    }
    // The more it swings, the faster; a machine that runs away is braked at once.
    let begun = run(&mut Supervisor::new(true), 0.0, 2.0, 7.2 * UPPER);
    let waited = begun[1].1 - begun[0].1;
    assert!((waited - 0.25 * PATIENCE[0]).abs() < 1.5 * H, "{waited} s");
    let mut watch = Supervisor::new(true);
    let begun = run(&mut watch, 0.0, 2.0, 40.0 * UPPER);
    let stages: Vec<Stage> = begun.iter().map(|(stage, _)| *stage).collect();
    assert_eq!(stages[stages.len() - 2..], [Stage::Braking, Stage::Stopped]);
    assert!(!stages.contains(&Stage::Stopping), "{stages:?}");
    assert_eq!(watch.cause(), Cause::Swinging);
}

#[test]
fn what_no_longer_swings_is_left_as_it_is() {
    let mut watch = Supervisor::new(true);
    assert_eq!(run(&mut watch, 0.0, 5.0, 0.8 * UPPER), []);
    assert_eq!(watch.stage(), Stage::Watching);
    let mut t = 0.0;
    while watch.stage() == Stage::Watching {
        run(&mut watch, t, 0.1, 2.0 * UPPER);
        t += 0.1;
    }
    // Between both thresholds it still swings, below the lower one no longer.
    let mut other = watch;
    assert_eq!(run(&mut watch, t, 9.0, 0.3 * LOWER), []);
    assert_eq!(watch.stage(), Stage::Frozen);
    assert_eq!(run(&mut other, t, 9.0, 0.8 * UPPER).len(), 4);
    let mut off = Supervisor::new(false);
    assert_eq!(run(&mut off, 0.0, 5.0, 50.0 * UPPER), []);
}

/// A rod that keeps its largest force is braked at once, however steady it is.
#[test]
fn a_load_beyond_the_machine_is_braked() {
    let mut watch = Supervisor::new(true);
    let mut steps = 0;
    while watch.stage() == Stage::Watching {
        let observed = Observed {
            errors: [[7e3, 0.0]; 3],
            is_overloaded: true,
            ..QUIET
        };
        watch.advance(&observed, &RATINGS, H * f64::from(steps), H);
        steps += 1;
    }
    assert_eq!(watch.stage(), Stage::Braking);
    assert!(
        (H * f64::from(steps) - OVERLOADED).abs() < 1.5 * H,
        "{steps}"
    );
}

/// A trip is braked at once, also during a stop along the ramp; a reset works by its rising edge,
/// once the trip is over and the supply is there, and opens the brakes after their closing time.
#[test]
fn a_trip_brakes_and_a_reset_makes_ready_again() {
    let tripped = Observed {
        alarm: Some(Cause::Tripped),
        ..QUIET
    };
    let reset = Observed {
        reset: true,
        ..QUIET
    };
    let mut watch = Supervisor::new(true);
    let mut k = 0;
    let mut steps = |watch: &mut Supervisor, observed: Observed, n: u32| {
        for _ in 0..n {
            watch.advance(&observed, &RATINGS, H * f64::from(k), H);
            k += 1;
        }
        (watch.stage(), watch.cause())
    };
    assert_eq!(
        steps(&mut watch, tripped, 1),
        (Stage::Braking, Cause::Tripped)
    );
    assert_eq!(
        steps(&mut watch, tripped, 60),
        (Stage::Stopped, Cause::Tripped)
    );
    let early = Observed {
        reset: true,
        ..tripped
    };
    assert_eq!(steps(&mut watch, early, 60).0, Stage::Stopped);
    // Held since, it is no edge.
    assert_eq!(steps(&mut watch, reset, 60).0, Stage::Stopped);
    steps(&mut watch, QUIET, 1);
    let dead = Observed {
        is_supplied: false,
        ..reset
    };
    assert_eq!(steps(&mut watch, dead, 5).0, Stage::Stopped);
    steps(&mut watch, QUIET, 1);
    assert_eq!(steps(&mut watch, reset, 1), (Stage::Braking, Cause::None));
    assert_eq!(steps(&mut watch, reset, 40).0, Stage::Braking);
    assert_eq!(steps(&mut watch, reset, 20), (Stage::Watching, Cause::None));
    let mut stopping = Supervisor {
        stage: Stage::Stopping,
        ..watch
    };
    assert_eq!(steps(&mut stopping, tripped, 1).0, Stage::Braking);
}

#[test]
fn gains_are_those_asked_for_until_they_are_lowered() {
    let settings = Settings::from_gains(&Machine::reference().controller);
    let at = |stage| Supervisor {
        stage,
        ..Supervisor::default()
    };
    for stage in [Stage::Off, Stage::Watching, Stage::Frozen] {
        assert!(matches!(
            at(stage).effective_settings(&settings),
            Cow::Borrowed(_)
        ));
    }
    let asked = &settings.gains;
    let lowered = at(Stage::Lowered).effective_settings(&settings).gains;
    assert_eq!(lowered.Lambda_position, 0.5 * asked.Lambda_position);
    assert_eq!(lowered.kappa_KA, 0.5 * asked.kappa_KA);
    assert_eq!(lowered.K_v, 0.5 * asked.K_v);
    assert_eq!(lowered.K_i, asked.K_i);
}

/// The joints come to rest along a ramp: half the way that they would have gone.
#[test]
fn the_joints_come_to_rest_in_half_the_way() {
    let mut watch = Supervisor {
        stage: Stage::Stopping,
        ..Supervisor::default()
    };
    let [zeta, rate] = [0.3, -0.2].map(Vector6::repeat);
    watch.begin_stop(zeta, rate);
    run(&mut watch, 0.0, RAMP, 0.0);
    let Motion {
        zeta: end,
        zeta_dot,
        zeta_ddot,
        ..
    } = watch.motion;
    assert!((end - (zeta + rate * (0.5 * RAMP))).norm() < 1e-12, "{end}");
    assert_eq!((zeta_dot, zeta_ddot), (Vector6::zeros(), Vector6::zeros()));
}

/// The wrist is held by the mean of a torque that swings, and by its own inertia.
#[test]
fn the_wrist_is_held_by_what_held_it_on_average() {
    let mut watch = Supervisor::default();
    for k in 0..3000 {
        let wave = 900.0 * (TAU * 7.0 * H * f64::from(k)).sin();
        watch.average_commands(&[150.0 + wave, -90.0, 5.0], &[0.0; 3], H);
    }
    watch.motion.zeta[5] = 0.2;
    let mut gains = Machine::reference().controller;
    (gains.kappa_KA, gains.Lambda_orientation) = (8.0, 3.0);
    let mut input = Input::default();
    (input.zeta[5], input.zeta_dot[5]) = (0.15, -0.4);
    let of = |j| watch.wrist_holding_torque(j, 0.5, &gains, &input);
    // What is left of the wave: 1/(2π·7·0.3) of it.
    assert!((of(0) - 150.0).abs() < 900.0 / 13.0, "{}", of(0));
    assert!((of(1) + 90.0).abs() < 1e-9);
    assert!((of(2) - (5.0 + 8.0 * 0.5 * (3.0 * 0.05 + 0.4))).abs() < 1e-9);
}
