//! Tests commanded rates without the controller, under commands that no operator gives.

use super::*;
use nalgebra::Vector3;

const H: f64 = 1e-3;
const FREE: [(f64, usize); 2] = [(f64::INFINITY, 0); 2];

/// Reproducible numbers in (0, 1): Weyl's sequence of the golden ratio, hashed by a sine.
struct Random(f64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 += 1.0;
        ((self.0 * 12.9898).sin() * 43_758.545).rem_euclid(1.0)
    }

    /// In (−size, size).
    fn both(&mut self, size: f64) -> f64 {
        size * (2.0 * self.next() - 1.0)
    }
}

/// The reference machine, and the same with its outer boom bent by 40°, whose arm can be stretched.
fn machines() -> [Machine; 2] {
    let straight = Machine::reference();
    let mut bent = straight.clone();
    let (sin, cos) = 40.0_f64.to_radians().sin_cos();
    bent.geometry.r_B_B4 = [1.5 * cos, 1.5 * sin, 0.0];
    [straight, bent]
}

/// The reference and its motion from the machine's start.
#[derive(Clone)]
struct Run {
    tree: Tree,
    rates: Rates,
    motion: Motion,
}

impl Run {
    fn new(machine: &Machine) -> Self {
        let (tree, zeta) = (Tree::new(machine).expect("a machine"), &machine.start.zeta);
        Self {
            rates: Rates::new(machine, &tree, zeta, &RateLimits::default()).expect("valid"),
            tree,
            motion: Motion::rest(zeta),
        }
    }

    fn advance(&mut self, command: RateCommand, input: &Input, h: f64) {
        let Self {
            tree,
            rates,
            motion,
        } = self;
        // The machine follows at once.
        let input = Input {
            zeta: motion.zeta.into(),
            zeta_dot: motion.zeta_dot.into(),
            ..*input
        };
        let bounds = ReferenceBounds {
            ahead: [1.0; DOF],
            room: Room::default(),
        };
        rates.advance(motion, tree, command, &input, &bounds, h);
    }
}

/// Levers thrown about for ten minutes a machine, of the joints and of the tip in turns, far beyond
/// what is allowed, each position held for 1 ms to 2 s, and for half a minute rather to one side
/// than to the other: rates and accelerations of all joints keep their limits, the angles keep
/// their ranges, and the rates have no jump (a reference that is cut off at the end of a range
/// would have). Rounding aside exactly: each joint's acceleration is a mean of accelerations within
/// the limit, and the rate comes to its own without swinging over, as the smoothing is critically
/// damped.
#[test]
fn thrown_levers_leave_rates_accelerations_and_ranges_within_their_limits() {
    let (mut random, mut ends) = (Random(0.0), [false; 2 * DOF]);
    for machine in machines() {
        let mut run = Run::new(&machine);
        let limits = run.rates.limits;
        let (mut slowed, mut fastest) = (false, 0.0_f64);
        let (mut k, mut bias, mut biased) = (0, [0.0; DOF], 0);
        while k < 600_000 {
            if k >= biased {
                bias = std::array::from_fn(|_| random.both(1.0).signum());
                biased = k + 30_000;
            }
            let is_tip = random.next() < 0.6;
            let command = [RateCommand::Joint, RateCommand::Tip][usize::from(is_tip)];
            let input = Input {
                rate_joint: std::array::from_fn(|i| {
                    2.0 * limits.joint[i] * (bias[i] + random.both(2.0))
                }),
                rate_tip: std::array::from_fn(|_| random.both(1.0)),
                ..Input::default()
            };
            for _ in 0..1 + (2000.0 * random.next().powi(2)) as u32 {
                let before = run.motion;
                run.advance(command, &input, H);
                let now = &run.motion;
                slowed |= now.held.rate.is_some();
                for i in 0..DOF {
                    let share = now.zeta_dot[i].abs() / limits.joint[i];
                    fastest = fastest.max(share);
                    assert!(share < 1.0, "{k}: joint {i}: {share} of its rate");
                    let largest = limits.joint_acceleration[i] * (1.0 + 1e-12);
                    let a = now.zeta_ddot[i];
                    assert!(a.abs() <= largest, "{k}: joint {i}: {a} rad/s²");
                    let jump = now.zeta_dot[i] - before.zeta_dot[i];
                    assert!(jump.abs() <= H * largest, "{k}: joint {i}: jumps by {jump}");
                    let [low, high] = run.rates.range[i];
                    let zeta = now.zeta[i];
                    assert!((low..=high).contains(&zeta), "{k}: joint {i}: {zeta} rad");
                    ends[2 * i] |= zeta < low + 1e-3;
                    ends[2 * i + 1] |= zeta > high - 1e-3;
                }
                k += 1;
            }
        }
        println!("at most {fastest} of the rates");
        assert!(slowed && fastest > 0.97, "{fastest}");
    }
    assert_eq!(ends, [true; 2 * DOF], "low and high end of each joint");
}

/// A command of the tip that its joints cannot follow at once, from rest: the tip goes straight
/// nevertheless, at the speed that the joints allow. It errs by the smoothing of the accelerations,
/// in which the Jacobian of τ/4 ago counts.
#[test]
fn a_tip_that_is_slowed_goes_straight() {
    let [machine, _] = machines();
    let mut run = Run::new(&machine);
    run.rates.limits.tip[0] = 5.0;
    let input = Input {
        rate_tip: [-2.0, -1.0, 1.5, 0.0, 0.0, 0.0],
        ..Input::default()
    };
    let at = |run: &Run| run.motion.tip(&run.tree).position;
    let (start, along) = (at(&run), Vector3::new(-2.0, -1.0, 1.5).normalize());
    let mut aside = 0.0_f64;
    for _ in 0..2500 {
        run.advance(RateCommand::Tip, &input, H);
        let way = at(&run) - start;
        aside = aside.max((way - along * way.dot(&along)).norm());
    }
    let way = (at(&run) - start).dot(&along);
    println!("{way} m, aside {:.3} mm", 1e3 * aside);
    assert!(run.motion.held.rate.is_some());
    assert!(way > 0.3 && aside < 5e-4, "{way} {aside}");
}

/// Between two points the acceleration is a straight line in time: the rate is its integral, and
/// the angle the integral of that, by Simpson's rule, which is exact for a parabola. Tolerance: the
/// rounding of the angle, of some radians.
#[test]
fn angle_and_rate_are_integrals_of_a_straight_acceleration() {
    let [machine, _] = machines();
    let mut run = Run::new(&machine);
    let input = Input {
        rate_joint: run.rates.limits.joint.map(|largest| 0.9 * largest),
        ..Input::default()
    };
    let h = 0.02; // one part of a step, a tenth of the smoothing
    for k in 0..40 {
        let before = run.motion;
        run.advance(RateCommand::Joint, &input, h);
        let now = &run.motion;
        for i in 0..DOF {
            let (a, b) = (before.zeta_ddot[i], now.zeta_ddot[i]);
            let rate = |s: f64| before.zeta_dot[i] + s * (a + (b - a) * s / (2.0 * h));
            let moved = h / 6.0 * (rate(0.0) + 4.0 * rate(0.5 * h) + rate(h));
            let error = now.zeta[i] - before.zeta[i] - moved;
            assert!(error.abs() < 1e-15, "step {k}, joint {i}: {error:e} rad");
            let error = now.zeta_dot[i] - rate(h);
            assert!(error.abs() < 1e-16, "step {k}, joint {i}: {error:e} rad/s");
        }
    }
    assert!(run.motion.zeta_ddot.norm() > 1e-3);
}

#[test]
fn limits_that_are_none_are_refused_by_name() {
    let machine = Machine::reference();
    let tree = Tree::new(&machine).expect("a machine");
    let with = |limits: RateLimits| {
        let rates = Rates::new(&machine, &tree, &machine.start.zeta, &limits);
        rates.map(|rates| assert_eq!(rates.limits, limits))
    };
    let valid = RateLimits {
        smoothing: 0.3,
        ..RateLimits::default()
    };
    with(valid).expect("valid");
    for value in [0.0, -1.0, f64::INFINITY] {
        let mut wrong = [valid; 5];
        wrong[0].joint[5] = value;
        wrong[1].joint_acceleration[0] = value;
        wrong[2].tip[1] = value;
        wrong[3].tip_acceleration[0] = value;
        wrong[4].smoothing = value;
        let names = [
            "rate.joint_max",
            "rate.joint_acceleration_max",
            "rate.tip_max",
            "rate.tip_acceleration_max",
            "rate.smoothing",
        ];
        for (limits, name) in wrong.into_iter().zip(names) {
            let text = with(limits).unwrap_err().to_string();
            assert!(text.starts_with(&format!("`{name}` = {value} ")), "{text}");
        }
    }
    let mut nan = valid;
    nan.tip[0] = f64::NAN;
    assert!(with(nan).is_err());
}

#[test]
fn the_nearest_end_is_that_of_the_joints_half() {
    let rates = Run::new(&Machine::reference()).rates;
    for i in 0..DOF {
        let [low, high] = rates.range[i];
        for (share, expected) in [(0.4, low), (0.6, high)] {
            let zeta = low + share * (high - low);
            assert_eq!(rates.nearest_limit(i, zeta), expected, "joint {i}");
        }
    }
}

/// A long step is made of as many short ones as the smoothing needs, a tenth of its time constant
/// each.
#[test]
fn a_long_step_is_many_short_ones() {
    let machine = Machine::reference();
    let mut long = Run::new(&machine);
    let mut short = long.clone();
    let input = Input {
        rate_joint: [0.1, -0.05, 0.07, 0.3, -0.2, 0.4],
        ..Input::default()
    };
    long.advance(RateCommand::Joint, &input, 0.49);
    for _ in 0..25 {
        short.advance(RateCommand::Joint, &input, 0.49 / 25.0);
    }
    assert_eq!(long.motion, short.motion);
    assert!(long.motion.zeta_dot.norm() > 0.1);
}

/// Before the end of a range the speed from which a joint brakes with a share of its largest
/// acceleration is the most, `√(lag² + 2 a s) − lag` with `lag = 4 τ a`, solved here for the way:
/// `s = v²/(2 a) + 4 τ v`.
#[test]
fn joints_slow_down_before_the_ends() {
    let rates = Run::new(&Machine::reference()).rates;
    for i in 0..DOF {
        let a = BRAKE_SHARE * rates.limits.joint_acceleration[i];
        for ahead in [0.0, 1e-3, 0.01, 0.03] {
            let zeta = rates.range[i][1] - ahead;
            let (v, _) = rates.allowed(i, zeta, RateCommand::Joint, FREE).high;
            let way = v * v / (2.0 * a) + 4.0 * rates.limits.smoothing * v;
            assert!((way - ahead).abs() < 1e-14, "joint {i}: {way} for {ahead}");
            assert!(v < rates.largest_rate(i));
        }
        let [low, high] = rates.range[i];
        let middle = 0.5 * (low + high);
        let AllowedRates { low, high } = rates.allowed(i, middle, RateCommand::Joint, FREE);
        assert_eq!([-low.0, high.0], [rates.largest_rate(i); 2]);
    }
}

#[test]
fn a_share_keeps_both_lengths_within_their_limits() {
    let v = Vector6::new(3.0, 0.0, -4.0, 0.0, 2.0, 0.0);
    assert_eq!(share_within(&v, [2.0, 1.9]), 2.0 / 5.0);
    assert_eq!(share_within(&v, [10.0, 0.5]), 0.25);
    assert_eq!(share_within(&v, [5.5, 2.5]), 1.0);
}

/// A command counts as held where less than half of it is allowed, at either end of each joint.
#[test]
fn commands_are_held_where_less_than_half_is_allowed() {
    let Run { rates, motion, .. } = Run::new(&Machine::reference());
    let bound = 0.04;
    let allowed = [AllowedRates {
        low: (-bound, Hold::End),
        high: (bound, Hold::End),
    }; DOF];
    for joint in 0..DOF {
        for (share, is_held) in [(1.9, false), (2.1, true), (-1.9, false), (-2.1, true)] {
            let mut commands = [0.0; DOF];
            commands[joint] = share * bound;
            let (wanted, _, held) = rates.joint_accelerations(&motion, &commands, &allowed, 0.5);
            let mut expected = CommandHolds::default();
            expected.joint[joint] = is_held;
            assert_eq!(held, expected);
            assert_eq!(wanted[joint], share * bound / 0.5);
        }
    }
}

/// Joints that something holds, under a full command: their references wait within the distance
/// that is allowed, and say so. Released, they return to their joints within three seconds and stay;
/// told to go back, they go at once.
#[test]
fn a_reference_waits_for_joints_that_are_held_and_returns() {
    let Run {
        tree,
        rates,
        mut motion,
    } = Run::new(&Machine::reference());
    let held = motion.zeta;
    let bounds = ReferenceBounds {
        ahead: [0.004, 0.003, 0.006, 0.03, 0.02, 0.04],
        room: Room::default(),
    };
    let hold = |share: f64, seconds: f64, motion: &mut Motion| {
        let input = Input {
            zeta: held.into(),
            rate_joint: std::array::from_fn(|i| share * rates.limits.joint[i] * [1.0, -1.0][i % 2]),
            ..Input::default()
        };
        for _ in 0..(seconds / H) as u32 {
            rates.advance(motion, &tree, RateCommand::Joint, &input, &bounds, H);
        }
    };
    let ahead = |motion: &Motion, i: usize| {
        (motion.zeta[i] - held[i]) * [1.0, -1.0][i % 2] / bounds.ahead[i]
    };
    hold(1.0, 3.0, &mut motion);
    for i in 0..DOF {
        let share = ahead(&motion, i);
        assert!((0.95..1.01).contains(&share), "joint {i}: {share}");
        assert_eq!(motion.blocked[i], [1.0, -1.0][i % 2]);
    }
    let mut back = motion;
    hold(0.0, 3.0, &mut motion);
    for i in 0..DOF {
        let share = ahead(&motion, i);
        assert!(share.abs() < 0.15, "joint {i}: {share}");
    }
    assert!(!motion.is_blocked());
    hold(-1.0, 0.3, &mut back);
    for i in 0..DOF {
        let share = ahead(&back, i);
        assert!(share < 0.8, "joint {i}: {share}");
    }
}

/// With the room of a rod the joint stops there, as at the end of its range.
#[test]
fn joints_slow_down_before_a_rod_holds_no_more() {
    let rates = Run::new(&Machine::reference()).rates;
    let zeta = 0.5 * (rates.range[2][0] + rates.range[2][1]);
    let room = [(f64::INFINITY, 0), (0.01, 2)];
    let AllowedRates { low, high } = rates.allowed(2, zeta, RateCommand::Joint, room);
    assert_eq!(-low.0, rates.largest_rate(2));
    let brake = BRAKE_SHARE * rates.limits.joint_acceleration[2];
    assert_eq!(high.0, rates.limits.speed_before(0.01, brake));
    assert!(high.1 == Hold::Rod(2));
}
