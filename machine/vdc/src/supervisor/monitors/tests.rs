use super::*;
use crate::law::Mode;
use crate::supervisor::Supervisor;
use emla::Surrogate;
use machine_file::Machine;

mod wrist;

const H: f64 = 1e-3;
/// Rod travel per angle, m/rad, and the rate of all joints, rad/s.
const PRIMES: [f64; 3] = [0.3, 0.4, 0.25];
const RATE: f64 = 0.05;
/// Forces of the rods, N.
const LOADS: [f64; 3] = [2e3, 40e3, 30e3];

struct Watched {
    monitors: Monitors,
    nominal: Nominal,
    settings: Settings,
    /// Whether a rod swings, and the reference moves.
    swings: bool,
    moves: bool,
    is_hook_empty: bool,
    steps: u32,
}

impl Watched {
    fn new() -> Self {
        let machine = Machine::reference();
        let mut settings = Settings {
            mode: Mode::Adaptive,
            current_loop: true,
            ..Settings::from_gains(&machine.controller)
        };
        let gains = &mut settings.gains;
        (gains.Lambda_position, gains.Lambda_orientation) = (12.0, 12.0);
        gains.omega_tip = 6.0;
        Self {
            monitors: Monitors::default(),
            nominal: Nominal::new(&machine, &Surrogate::reference()).expect("valid"),
            settings,
            swings: false,
            moves: true,
            is_hook_empty: true,
            steps: 0,
        }
    }

    /// What a machine reads whose joints all move at [`RATE`], with noise in currents and forces,
    /// and what its law makes of it.
    fn healthy(&self) -> (Plausibility, Input) {
        let t = H * f64::from(self.steps);
        let noise = f64::from(self.steps % 7) - 3.0;
        let mut input = Input {
            zeta: [0.3 + RATE * t; DOF],
            zeta_dot: [RATE; DOF],
            ..Input::default()
        };
        let mut i_q_required = [0.0; 3];
        for i in 0..3 {
            let p = self.nominal.parameters()[i];
            input.F[i] = LOADS[i] + 70.0 * noise;
            input.x_dot[i] = PRIMES[i] * RATE;
            input.w_m[i] = PRIMES[i] * RATE / maps::travel_per_radian(p);
            let torque = maps::required_torque(p, LOADS[i], input.w_m[i], 0.0);
            i_q_required[i] = torque / maps::torque(p, 0.0, 1.0);
            input.i_d[i] = 0.05 * noise;
            input.i_q[i] = i_q_required[i] - 0.05 * noise;
        }
        let now = Plausibility {
            moves: self.moves,
            primes: PRIMES,
            zeta_dot_r: [RATE; DOF],
            i_q_required,
            ..Plausibility::default()
        };
        (now, input)
    }

    fn moment<'a>(&'a self, now: &'a Plausibility, input: &'a Input) -> Moment<'a> {
        Moment {
            now,
            nominal: &self.nominal,
            settings: &self.settings,
            input,
            is_hook_empty: self.is_hook_empty,
            h: H,
        }
    }

    fn advance(&mut self, now: &Plausibility, input: &Input) -> Option<Cause> {
        self.steps += 1;
        let mut monitors = self.monitors;
        let cause = monitors.advance(&self.moment(now, input), self.swings);
        self.monitors = monitors;
        cause
    }

    /// The first cause within `seconds` if `fault` alters what is read, from the second second on,
    /// and the time that it took, s.
    fn cause(
        &mut self,
        seconds: f64,
        fault: impl Fn(f64, &mut Plausibility, &mut Input),
    ) -> Option<(Cause, f64)> {
        for k in 0..(1000.0 * (1.0 + seconds)) as u32 {
            let (mut now, mut input) = self.healthy();
            let t = H * f64::from(k) - 1.0;
            if t >= 0.0 {
                fault(t, &mut now, &mut input);
            }
            if let Some(cause) = self.advance(&now, &input) {
                assert!(t >= 0.0, "{cause:?} at {t} s, before the fault");
                return Some((cause, t));
            }
        }
        None
    }
}

/// The fault leads to this cause, after some time up to `within`, s; a smaller one to none.
#[track_caller]
fn found(
    cause: Cause,
    within: f64,
    fault: impl Fn(f64, f64, &mut Plausibility, &mut Input),
) -> f64 {
    found_unless(0.1, cause, within, fault)
}

/// The same, where one of the size `small` leads to none.
#[track_caller]
fn found_unless(
    small: f64,
    cause: Cause,
    within: f64,
    fault: impl Fn(f64, f64, &mut Plausibility, &mut Input),
) -> f64 {
    let at = Watched::new().cause(3.0, |t, now, input| fault(1.0, t, now, input));
    let (found, time) = at.expect("an alarm");
    assert!(found == cause && time <= within, "{found:?} after {time} s");
    let none = Watched::new().cause(3.0, |t, now, input| fault(small, t, now, input));
    assert_eq!(none, None);
    time
}

#[test]
fn a_healthy_machine_gives_no_alarm() {
    assert_eq!(Watched::new().cause(5.0, |_, _, _| ()), None);
}

/// A machine that is not watched for a while moves on: what was known before says nothing then.
#[test]
fn after_a_gap_monitors_begin_anew() {
    let (mut watched, mut supervisor) = (Watched::new(), Supervisor::new(true));
    for k in 0..3000 {
        let (now, input) = watched.healthy();
        watched.steps += 1;
        let moment = watched.moment(&now, &input);
        let is_watched = !(1000..1300).contains(&k);
        assert_eq!(
            supervisor.monitor(is_watched.then_some(&moment)),
            None,
            "step {k}"
        );
    }
}

/// 0.25 m/s over Λ = 12 1/s are 20.8 mm, and 0.5 rad/s over it 42 mrad: beyond them at once,
/// beyond 0.7 of them after 3/ω = 0.5 s, and a jump by a quarter in its step.
#[test]
fn an_error_that_is_large_lasts_or_jumps_is_an_alarm() {
    let growing = |size: f64, t: f64| size * 0.022 * (t / 0.2).min(1.0);
    let time = found(Cause::Following, 0.22, |size, t, now, _| {
        now.tip_error[1] = growing(size, t)
    });
    assert!(time > 0.19, "{time}");
    let time = found(Cause::Following, 0.7, |size, t, now, _| {
        now.orientation_error = size * 0.035 * (t / 0.2).min(1.0);
    });
    assert!(time > 0.5, "{time}");
    found(Cause::Following, 0.0, |size, _, now, _| {
        now.tip_error[2] = size * 0.0055
    });
    found(Cause::Following, 0.0, |size, _, now, _| {
        now.orientation_error = size * 0.011
    });
    let mut watched = Watched::new();
    watched.settings.mode = Mode::Pd;
    assert_eq!(
        watched.cause(3.0, |t, now, _| now.tip_error[1] = growing(1.0, t)),
        None
    );
}

/// A rate that is wrong by 0.05 rad/s reaches 2.5 mrad after 50 ms; one that is wrong by 0.5 mrad/s no
/// more than 1.25 mrad over 2.5 s.
#[test]
fn an_angle_that_is_not_the_integral_of_its_rate_is_an_alarm() {
    for j in [3, 4, 5] {
        let time = found(Cause::JointRate, 0.1, |size, _, _, input| {
            input.zeta_dot[j] -= 0.05 * size * size
        });
        assert!(time > 0.045, "{time}");
        // A wrist's angle that jumps by more than 0.2 mrad has a drive that sets off.
        found_unless(0.04, Cause::JointRate, 0.02, |size, _, _, input| {
            input.zeta[j] += 0.004 * size
        });
        // Twice 2.5 mrad need not last.
        found_unless(0.03, Cause::JointRate, 0.0, |size, _, _, input| {
            input.zeta[j] += 0.006 * size
        });
    }
}

/// A motor that stands while the joint moves at 20 mm/s of the rod: half a millimetre after 25 ms;
/// a force that falls by 1 MN/s explains more, as the rod becomes longer, one that rises half of it.
#[test]
fn a_joint_that_moves_without_its_motor_is_an_alarm() {
    let slows = |size: f64, t: f64| 1.0 - size * (t / 0.02).min(1.0);
    found(Cause::JointEncoder, 0.065, |size, t, _, input| {
        input.w_m[1] *= slows(size, t)
    });
    found(Cause::JointEncoder, 0.065, |size, t, _, input| {
        input.x_dot[1] *= slows(size, t)
    });
    let after = |rate: f64| {
        let pressed = Watched::new().cause(0.07, |t, _, input| {
            input.w_m[1] *= slows(1.0, t);
            input.F[1] += rate * t;
        });
        let of_encoder = pressed.filter(|(cause, _)| *cause == Cause::JointEncoder);
        of_encoder.map_or(1.0, |(_, time)| time)
    };
    let [rises, stays, falls] = [1e6, 0.0, -1e6].map(after);
    assert!(
        rises < stays - 0.01 && falls > stays,
        "{rises} {stays} {falls}"
    );
    // The motor's angle shows that its speed is wrong: 0.35 mm after 18 ms and half of 20 ms.
    let turning = |t: f64, _: &mut Plausibility, input: &mut Input| {
        input.theta_m = Some(input.w_m.map(|speed| speed * t));
        input.w_m[1] *= slows(1.0, t);
        input.F[1] -= 1e6 * t;
    };
    let (cause, time) = Watched::new().cause(0.05, turning).expect("an alarm");
    assert!(
        cause == Cause::JointEncoder && time > 0.02,
        "{cause:?} {time}"
    );
}

/// A joint that stands while its motor turns slowly: of 1 mm/s only 0.25 mm are left over 0.25 s, but
/// 0.5 mm over 2.5 s after 0.56 s, by 2.5 mm (1 − e^(−t/2.5 s)).
#[test]
fn a_motor_that_turns_slowly_without_its_joint_is_an_alarm() {
    let nominal = Watched::new().nominal;
    let travel = maps::travel_per_radian(nominal.parameters()[2]);
    let mut watched = Watched::new();
    let creeps = |t: f64, speed: f64, now: &mut Plausibility, input: &mut Input| {
        now.zeta_dot_r[2] = 0.0;
        let slows = (1.0 - t / 0.2).max(0.0);
        input.zeta[2] = 0.3 + RATE * (1.0 + 0.2 * 0.5 * (1.0 - slows * slows));
        input.zeta_dot[2] = RATE * slows;
        input.x_dot[2] = PRIMES[2] * input.zeta_dot[2];
        input.w_m[2] = (input.x_dot[2] + speed * (1.0 - slows)) / travel;
    };
    let found = watched.cause(9.0, |t, now, input| creeps(t, 1e-3, now, input));
    let (cause, time) = found.expect("an alarm");
    assert!(
        cause == Cause::JointEncoder && time < 4.0,
        "{cause:?} {time}"
    );
    let slower = Watched::new().cause(9.0, |t, now, input| creeps(t, 1e-4, now, input));
    assert_eq!(slower, None);
}

/// The encoder of joint `j`, counted from 0, moves on between these times, s, and stands before and after.
fn moves_within(from: f64, to: f64, j: usize, t: f64, input: &mut Input) {
    let moved = t.clamp(from, to) - from;
    input.zeta[j] = 0.3 + RATE * (1.0 + moved);
    if t < from || t >= to {
        input.zeta_dot[j] = 0.0;
    }
}

/// A joint of the wrist whose encoder stands, with its rate, while it is to move at 0.2 rad/s: of one
/// that stuck for 0.04 s before, 25 mrad after 0.17 s, by 0.05 (1 − e^(−t/0.25 s)); of one that never
/// stood 3 mrad, which are there after 0.06 s; and so of a motor. A current that stands while others have
/// noise; at rest without noise nothing is stale.
#[test]
fn a_reading_that_stands_is_an_alarm() {
    let stands = |t: f64, from: f64, now: &mut Plausibility, input: &mut Input| {
        now.zeta_dot_r[4] = if t < 0.1 { 0.0 } else { 0.2 };
        if t >= from {
            (input.zeta[4], input.zeta_dot[4]) = (0.3 + RATE * (1.0 + from), 0.0);
        }
    };
    let sticks = |t: f64, now: &mut Plausibility, input: &mut Input| {
        now.zeta_dot_r[4] = 0.2;
        moves_within(0.04, 0.2, 4, t, input);
    };
    let (cause, time) = Watched::new().cause(1.0, sticks).expect("an alarm");
    assert!(
        cause == Cause::Stale && (0.36..0.38).contains(&time),
        "{cause:?} {time}"
    );
    let frozen = |t: f64, now: &mut Plausibility, input: &mut Input| stands(t, 0.1, now, input);
    let (cause, time) = Watched::new().cause(1.0, frozen).expect("an alarm");
    assert!(
        cause == Cause::Stale && (0.155..0.17).contains(&time),
        "{cause:?} {time}"
    );
    // Joint and motor slow down to a creep, so that the joint's way does not tell when the motor stands.
    let nominal = Watched::new().nominal;
    let ratio = PRIMES[1] / maps::travel_per_radian(nominal.parameters()[1]);
    let motor = |t: f64, _: &mut Plausibility, input: &mut Input| {
        let (creeps, slows) = (0.002, (1.0 - t / 0.2).max(0.0));
        let turned = 0.1 * RATE * (1.0 - slows * slows);
        input.zeta[1] = 0.3 + RATE + turned + creeps * t;
        input.zeta_dot[1] = RATE * slows + creeps;
        input.x_dot[1] = PRIMES[1] * input.zeta_dot[1];
        input.w_m[1] = ratio * (RATE * slows + if t < 1.1 { creeps } else { 0.0 });
        let [first, _, third] = input.w_m.map(|speed| speed * t);
        input.theta_m = Some([first, ratio * (turned + creeps * t.min(1.1)), third]);
    };
    let (cause, time) = Watched::new().cause(2.0, motor).expect("an alarm");
    // At 0.05 rad/s 3 mrad are there after 0.069 s.
    assert!(
        cause == Cause::Stale && (1.16..1.18).contains(&time),
        "{cause:?} {time}"
    );
    let stands =
        |_: f64, now: &mut Plausibility, input: &mut Input| input.i_q[1] = now.i_q_required[1];
    assert_eq!(
        Watched::new().cause(1.0, stands).map(|(cause, _)| cause),
        Some(Cause::Stale)
    );
    let rests = |_: f64, now: &mut Plausibility, input: &mut Input| {
        (input.i_q, input.i_d, input.F) = (now.i_q_required, [0.0; 3], LOADS);
    };
    assert_eq!(Watched::new().cause(1.0, rests), None);
}

/// A joint that has rested for 0.5 s, and never stuck, is to move at 0.2 rad/s but shows the same count: readings
/// may be lost for 0.06 s.
#[test]
fn a_joint_that_rested_has_not_shown_that_it_sticks() {
    let (cause, time) = Watched::new()
        .cause(3.0, |t, now, input| {
            now.zeta_dot_r[4] = if t < 0.5 { 0.0 } else { 0.2 };
            moves_within(0.5, 2.0, 4, t, input);
        })
        .expect("an alarm");
    assert!(
        cause == Cause::Stale && (2.055..2.07).contains(&time),
        "{cause:?} {time}"
    );
}

/// A joint that stands, as it has never done, before the reference has moved for half a second, sticks
/// there; by 40 mrad it has not stood.
#[test]
fn a_joint_may_stick_before_the_reference_moves() {
    let sticks = |rate: f64, sets_off: f64| {
        let mut watched = Watched::new();
        watched.moves = false;
        let found = watched.cause(2.0, |t, now, input| {
            now.moves = t >= sets_off && t < sets_off + 0.6;
            now.zeta_dot_r[3] = rate;
            moves_within(9.0, 9.0, 3, t, input);
        });
        found.map(|(cause, time)| {
            assert_eq!(cause, Cause::Stale);
            time
        })
    };
    // Of 0.1 rad/s 25 mrad are not forgotten, of 0.2 rad/s 40 mrad after 0.4 s.
    assert_eq!(sticks(0.1, 9.0), None);
    let sets_off = sticks(0.1, 0.5).expect("an alarm");
    assert!((0.99..1.01).contains(&sets_off), "{sets_off}");
    let far = sticks(0.2, 9.0).expect("an alarm");
    assert!((0.395..0.41).contains(&far), "{far}");
}

/// A joint that stands is nothing odd, unless a rod swings for as long.
#[test]
fn a_joint_that_stands_while_a_rod_swings_is_an_alarm() {
    for swings in [false, true] {
        let mut watched = Watched::new();
        watched.swings = swings;
        let found = watched.cause(1.0, |t, now, input| {
            now.zeta_dot_r[3] = 0.0;
            moves_within(1.0, 1.0, 3, t, input);
        });
        match found {
            Some((cause, time)) => assert!(
                swings && cause == Cause::Stale && (0.59..0.62).contains(&time),
                "{cause:?} {time}"
            ),
            None => assert!(!swings),
        }
    }
}

/// A brake that drags with 10 N·m: its motor gives them, and the force does not show it.
#[test]
fn a_brake_that_drags_is_an_alarm() {
    found(Cause::Torque, 0.2, |size, _, now, input| {
        let more = 10.0 * size / 1.14;
        input.i_q[2] += more;
        now.i_q_required[2] += more;
    });
}

/// 20 A too few: 5 A after smoothing over 20 ms for 6 ms.
#[test]
fn a_current_that_is_not_the_commanded_one_is_an_alarm() {
    found(Cause::Current, 0.01, |size, _, _, input| {
        input.i_q[0] -= 20.0 * size
    });
    found(Cause::Current, 0.01, |size, _, _, input| {
        input.i_d[0] -= 20.0 * size
    });
}

/// Magnets 40 % stronger or weaker than those of the machine file are no alarm, a torque that changes
/// by half is; nor are friction and forces near zero. The motor gives 1/k of the current.
#[test]
fn a_factor_of_torque_is_found_and_its_change_is_an_alarm() {
    let scaled = |factor: f64, now: &mut Plausibility, input: &mut Input| {
        for i in 0..3 {
            let more = (1.0 / factor - 1.0) * now.i_q_required[i];
            now.i_q_required[i] += more;
            input.i_q[i] += more;
        }
    };
    for factor in [0.6, 1.4] {
        let mut watched = Watched::new();
        let mut found = None;
        for _ in 0..5000 {
            let (mut now, mut input) = watched.healthy();
            scaled(factor, &mut now, &mut input);
            found = found.or(watched.advance(&now, &input));
        }
        assert_eq!(found, None, "{factor}");
    }
    let (cause, time) = Watched::new()
        .cause(1.0, |_, now, input| scaled(0.5, now, input))
        .expect("an alarm");
    assert!(cause == Cause::Torque && time < 0.2, "{cause:?} {time}");
}

/// Speeds of a rod that change by 0.3 of the rated one within a millisecond are those of a sensor.
#[test]
fn a_speed_that_jumps_is_an_alarm() {
    let nominal = Watched::new().nominal;
    let travel = maps::travel_per_radian(nominal.parameters()[1]);
    let rated = nominal.ratings[1][1];
    let by = |share: f64, which: usize| {
        move |_: f64, _: &mut Plausibility, input: &mut Input| {
            let more = share * rated;
            match which {
                0 => input.zeta_dot[1] += more / PRIMES[1],
                1 => input.w_m[1] += more / travel,
                _ => input.x_dot[1] += more,
            }
        }
    };
    for which in 0..3 {
        let (cause, time) = Watched::new()
            .cause(0.01, by(0.3, which))
            .expect("an alarm");
        assert!(
            cause == Cause::JointEncoder && time < 0.0015,
            "{which}: {cause:?} {time}"
        );
        assert_eq!(Watched::new().cause(0.001, by(0.1, which)), None, "{which}");
    }
}

/// Commanded rates wait for a joint that stands on something: an error of 0.2 m is no alarm then, a
/// jump still is.
#[test]
fn a_reference_that_waits_is_followed() {
    let waits = |_: f64, now: &mut Plausibility, _: &mut Input| now.waits[0] = true;
    let far = |t: f64, now: &mut Plausibility, input: &mut Input| {
        waits(t, now, input);
        now.tip_error[1] = 0.2 * t.min(1.0);
    };
    assert_eq!(Watched::new().cause(3.0, far), None);
    let jumps = |t: f64, now: &mut Plausibility, input: &mut Input| {
        waits(t, now, input);
        now.tip_error[1] = if t > 1.0 { 0.2 } else { 0.0 };
    };
    let found = Watched::new().cause(3.0, jumps);
    assert_eq!(found.map(|(cause, _)| cause), Some(Cause::Following));
}
