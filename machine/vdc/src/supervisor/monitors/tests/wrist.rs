//! Of the wrist.

use super::*;

/// Smoothed over 20 ms, 1.5 rad/s, reached in 6 ms, exceed 0.35 rad/s after 8 ms; ringing at 233 rad/s does not with 1 rad/s,
/// since 1/4.8 of it passes.
#[test]
fn a_wrist_that_runs_away_is_an_alarm() {
    let time = found(Cause::WristRate, 0.010, |size, t, _, input| {
        input.zeta_dot[4] = RATE + 1.5 * size * (t / 0.006).min(1.0);
        input.zeta[4] += 1.5 * size * (t - 0.003).max(0.0);
    });
    assert!(time > 0.007, "{time}");
    let rings = |t: f64, _: &mut Plausibility, input: &mut Input| {
        input.zeta_dot[4] += (233.0 * t).sin();
        input.zeta[4] += (1.0 - (233.0 * t).cos()) / 233.0;
    };
    let cause = Watched::new().cause(1.0, rings).map(|(cause, _)| cause);
    assert_ne!(cause, Some(Cause::WristRate));
}

/// A wrist joint whose drive sets off with 600 rad/s² turns by 0.3 mrad in a millisecond, and its rate, filtered
/// over 5 ms, does not show it yet; a coarse encoder or lost readings make such steps, too.
#[test]
fn a_wrist_that_sets_off_is_an_alarm_before_its_rate_shows_it() {
    let sets_off = |rate: f64, shift: fn(u32) -> f64| {
        let mut watched = Watched::new();
        (0..3000).find(|k| {
            let (mut now, mut input) = watched.healthy();
            let t = (H * f64::from(*k) - 2.0).max(0.0);
            now.zeta_dot_r[4] = rate;
            input.zeta[4] = rate * H * f64::from(*k) + shift(*k) + 300.0 * t * t;
            input.zeta_dot[4] = rate + 600.0 * t * (t / 0.01).min(1.0);
            watched.advance(&now, &input).is_some()
        })
    };
    assert_eq!(sets_off(0.05, |_| 0.0), Some(2001));
    // Counts of 0.4 mrad.
    let coarse = |k: u32| -0.05 * H * f64::from(k % 8);
    assert!(sets_off(0.05, coarse) > Some(2001));
    // From 1.5 s on every 100th reading is lost.
    let lost = |k: u32| {
        if k > 1500 && k.is_multiple_of(100) {
            -0.3 * H
        } else {
            0.0
        }
    };
    assert!(sets_off(0.3, lost) > Some(2000));
}

/// A wrist joint that its drive accelerates with 500 rad/s² is an alarm in the next step, long before
/// its smoothed rate is; with 250 rad/s² it is not yet.
#[test]
fn a_wrist_that_jumps_is_an_alarm() {
    let starts = |acceleration: f64| {
        move |t: f64, _: &mut Plausibility, input: &mut Input| {
            let duration = t.min(0.002);
            input.zeta_dot[4] += acceleration * duration;
            input.zeta[4] += acceleration * duration * (t - 0.5 * duration);
        }
    };
    let (cause, time) = Watched::new().cause(0.02, starts(500.0)).expect("an alarm");
    assert!(
        cause == Cause::WristRate && time < 0.0015,
        "{cause:?} {time}"
    );
    let slower = Watched::new().cause(0.01, starts(250.0));
    assert_eq!(slower, None);
}

/// Commanded rates wait for a wrist that does not follow: where a rod's force shows that it stands on
/// something it is left to, else something errs.
#[test]
fn a_wrist_that_is_waited_for_stands_on_something() {
    let is_far = |push: f64| {
        let mut watched = Watched::new();
        (0..2000).any(|k| {
            let (mut now, mut input) = watched.healthy();
            if k >= 1000 {
                now.waits[1] = true;
                now.tip_error[1] = 4e-5 * f64::from(k - 1000);
                input.F[1] += push;
            }
            watched.steps += 1;
            let Watched {
                monitors,
                nominal,
                settings,
                ..
            } = &mut watched;
            let at = Moment {
                now: &now,
                nominal,
                settings,
                input: &input,
                is_hook_empty: false,
                h: H,
            };
            if k == 0 {
                monitors.begin(&at);
            }
            monitors.following(&at)
        })
    };
    assert!(is_far(0.0) && !is_far(-60e3));
}

/// A law that does not adapt carries an unknown load by an error of the joints' rates: what grows to
/// 0.45 rad/s in 2 s is no alarm then; of one that adapts, or within 10 ms, it is.
#[test]
fn a_load_that_is_not_known_is_carried_by_an_error() {
    let cause = |mode: Mode, time: f64| {
        let mut watched = Watched::new();
        watched.settings.mode = mode;
        let cause = watched.cause(4.0, |t, now, _| {
            now.zeta_dot_r[4] = RATE + 0.45 * (t / time).min(1.0);
        });
        cause.map(|(cause, _)| cause)
    };
    assert_eq!(cause(Mode::Modular, 2.0), None);
    assert_eq!(cause(Mode::Adaptive, 2.0), Some(Cause::WristRate));
    assert_eq!(cause(Mode::Modular, 0.01), Some(Cause::WristRate));
}

/// A wrist joint that a push turns at 0.6 rad/s for 0.2 s and that comes back in 0.5 s is no alarm where the
/// reference has stood, with an empty hook; one that does not come back is after 2 s, and one that has been
/// commanded, or of a hook with a load, or that is faster, at once.
#[test]
fn a_push_at_rest_is_no_alarm() {
    let cause = |moves: bool, is_hook_empty: bool, rates: [f64; 2]| {
        let mut watched = Watched::new();
        (watched.moves, watched.is_hook_empty) = (moves, is_hook_empty);
        let mut angle = 0.0;
        (0..5000).find_map(|k| {
            let (mut now, mut input) = watched.healthy();
            let t = H * f64::from(k) - 1.0;
            let rate = match t {
                0.0..0.2 => rates[0] * (t / 0.05).min(1.0),
                0.2..0.7 => rates[1],
                _ => 0.0,
            };
            angle += H * rate;
            input.zeta_dot[4] += rate;
            input.zeta[4] += angle;
            now.tip_error[0] = 0.5 * angle;
            watched.advance(&now, &input).map(|cause| (cause, t))
        })
    };
    assert_eq!(cause(false, true, [0.6, -0.21]), None);
    let (_, time) = cause(false, true, [0.6, 0.0]).expect("an alarm");
    assert!(time > 2.0 && time < 2.1, "{time}");
    for (moves, is_hook_empty, rate) in [(true, true, 0.6), (false, false, 0.6), (false, true, 1.0)]
    {
        let (_, time) = cause(moves, is_hook_empty, [rate, -0.21]).expect("an alarm");
        assert!(time < 0.07, "{time}");
    }
}
