//! The reference alone, under commands that no operator gives.

use super::*;
use nalgebra::Vector3;

const H: f64 = 1e-3;

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

fn rates(machine: &Machine) -> (Tree, Rates) {
    let tree = Tree::new(machine).expect("a machine");
    let rates = Rates::new(machine, &tree, &machine.start.zeta);
    (tree, rates)
}

/// Levers thrown about for ten minutes a machine, of the joints and of the tip in turns, far beyond what is allowed, each position held for
/// 1 ms to 2 s, and for half a minute rather to one side than to the other: rates and accelerations of all joints keep their limits, the angles keep their ranges, and the rates have no jump (a
/// reference that is cut off at the end of a range would have). Rounding aside exactly: each joint's acceleration is a mean of accelerations
/// within the limit, and the rate comes to its own without swinging over, as the smoothing is critically damped.
#[test]
fn thrown_levers_leave_rates_accelerations_and_ranges_within_their_limits() {
    let (mut random, mut ends) = (Random(0.0), [false; 2 * DOF]);
    for machine in machines() {
        let (tree, mut rates) = rates(&machine);
        let limits = rates.limits;
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
                let before = rates.motion;
                rates.advance(&tree, command, &input, H);
                let now = &rates.motion;
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
                    let [low, high] = rates.range[i];
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

/// A command of the tip that its joints cannot follow at once, from rest: the tip goes straight nevertheless, at the speed that the joints allow.
/// It errs by the smoothing of the accelerations, in which the Jacobian of τ/4 ago counts.
#[test]
fn a_tip_that_is_slowed_goes_straight() {
    let [machine, _] = machines();
    let (tree, mut rates) = rates(&machine);
    rates.limits.tip[0] = 5.0;
    let input = Input {
        rate_tip: [-2.0, -1.0, 1.5, 0.0, 0.0, 0.0],
        ..Input::default()
    };
    let at = |rates: &Rates| rates.desired(&tree).position;
    let (start, along) = (at(&rates), Vector3::new(-2.0, -1.0, 1.5).normalize());
    let mut aside = 0.0_f64;
    for _ in 0..2500 {
        rates.advance(&tree, RateCommand::Tip, &input, H);
        let way = at(&rates) - start;
        aside = aside.max((way - along * way.dot(&along)).norm());
    }
    let way = (at(&rates) - start).dot(&along);
    println!("{way} m, aside {:.3} mm", 1e3 * aside);
    assert!(rates.motion.held.rate.is_some());
    assert!(way > 0.3 && aside < 5e-4, "{way} {aside}");
}

/// Between two points the acceleration is a straight line in time: the rate is its integral, and the angle the integral of that, by Simpson's
/// rule, which is exact for a parabola. Tolerance: the rounding of the angle, of some radians.
#[test]
fn angle_and_rate_are_integrals_of_a_straight_acceleration() {
    let [machine, _] = machines();
    let (tree, mut rates) = rates(&machine);
    let input = Input {
        rate_joint: rates.limits.joint.map(|largest| 0.9 * largest),
        ..Input::default()
    };
    let h = 0.02; // one part of a step, a tenth of the smoothing
    for k in 0..40 {
        let before = rates.motion;
        rates.advance(&tree, RateCommand::Joint, &input, h);
        let now = &rates.motion;
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
    assert!(rates.motion.zeta_ddot.norm() > 1e-3);
}

#[test]
fn limits_that_are_none_are_refused_by_name() {
    let set = |limits: RateLimits| {
        let (_, mut rates) = rates(&Machine::reference());
        let result = rates.set_limits(&limits);
        (result, rates.limits == limits)
    };
    let valid = RateLimits {
        smoothing: 0.3,
        ..RateLimits::default()
    };
    assert!(matches!(set(valid), (Ok(()), true)));
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
            let (result, is_set) = set(limits);
            let text = result.unwrap_err().to_string();
            assert!(
                !is_set && text.starts_with(&format!("`{name}` = {value} ")),
                "{text}"
            );
        }
    }
    let mut nan = valid;
    nan.tip[0] = f64::NAN;
    assert!(set(nan).0.is_err());
}

#[test]
fn the_nearest_end_is_that_of_the_joints_half() {
    let (_, mut rates) = rates(&Machine::reference());
    for i in 0..DOF {
        let [low, high] = rates.range[i];
        for (share, expected) in [(0.4, low), (0.6, high)] {
            rates.motion.zeta[i] = low + share * (high - low);
            assert_eq!(rates.nearest_limit(i), expected, "joint {i}");
        }
    }
}

/// A long step is made of as many short ones as the smoothing needs, a tenth of its time constant each.
#[test]
fn a_long_step_is_many_short_ones() {
    let machine = Machine::reference();
    let (tree, mut long) = rates(&machine);
    let mut short = long.clone();
    let input = Input {
        rate_joint: [0.1, -0.05, 0.07, 0.3, -0.2, 0.4],
        ..Input::default()
    };
    long.advance(&tree, RateCommand::Joint, &input, 0.49);
    for _ in 0..25 {
        short.advance(&tree, RateCommand::Joint, &input, 0.49 / 25.0);
    }
    assert_eq!(long.motion, short.motion);
    assert!(long.motion.zeta_dot.norm() > 0.1);
}

/// Before the end of a range the speed from which a joint brakes with a share of its largest acceleration is the most, `√(lag² + 2 a s) − lag`
/// with `lag = 4 τ a`, solved here for the way: `s = v²/(2 a) + 4 τ v`.
#[test]
fn joints_slow_down_before_the_ends() {
    let (_, mut rates) = rates(&Machine::reference());
    for i in 0..DOF {
        let a = BRAKE_SHARE * rates.limits.joint_acceleration[i];
        for ahead in [0.0, 1e-3, 0.01, 0.03] {
            rates.motion.zeta[i] = rates.range[i][1] - ahead;
            let (v, _) = rates.allowed(i, RateCommand::Joint).high;
            let way = v * v / (2.0 * a) + 4.0 * rates.limits.smoothing * v;
            assert!((way - ahead).abs() < 1e-14, "joint {i}: {way} for {ahead}");
            assert!(v < rates.largest_rate(i));
        }
        let [low, high] = rates.range[i];
        rates.motion.zeta[i] = 0.5 * (low + high);
        let Allowed { low, high } = rates.allowed(i, RateCommand::Joint);
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

/// Required motion by its equation, `ζ̇_d + Λ (e + z)` and its rate; a joint that would exceed its largest rate is held to it, and not accelerated
/// beyond.
#[test]
fn required_rates_follow_the_reference_and_keep_the_limits() {
    let (_, mut rates) = rates(&Machine::reference());
    rates.limits.joint = [0.5; DOF];
    rates.motion.zeta_dot = Vector6::new(0.1, -0.2, 0.3, 0.1, 0.4, -0.4);
    rates.motion.zeta_ddot = Vector6::new(0.5, 0.25, -0.5, 1.0, 2.0, 2.0);
    let errors = crate::integral::Errors {
        e: Vector6::new(0.01, 0.02, -0.03, 0.04, 0.05, -0.05),
        z: Vector6::new(0.02, -0.01, 0.01, 0.02, 0.05, -0.05),
        z_dot: Vector6::new(0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
    };
    let zeta_dot = [0.3, 0.1, -0.2, 0.4, 0.1, -0.1];
    let age = 0.1;
    let found = rates.required(&errors, &zeta_dot, age, [2.0, 4.0]);
    for (i, measured) in zeta_dot.into_iter().enumerate() {
        let Lambda = if i < 3 { 2.0 } else { 4.0 };
        let (v, a) = (rates.motion.zeta_dot[i], rates.motion.zeta_ddot[i]);
        let rate = v + Lambda * (errors.e[i] + errors.z[i]);
        let acceleration = a + Lambda * (v - age * a - measured + errors.z_dot[i]);
        let (rate, acceleration) = match i {
            // Both would go at 0.8 rad/s: one faster still, the other slower.
            4 => (0.5, 0.0),
            5 => (-0.5, acceleration),
            _ => (rate, acceleration),
        };
        assert!((found.zeta_dot[i] - rate).abs() < 1e-15, "{i}: {found:?}");
        let error = (found.zeta_ddot[i] - acceleration).abs();
        assert!(error < 1e-14, "{i}: {found:?} {acceleration}");
    }
    assert!(found.zeta_ddot[5] > 0.0);

    let zeta = std::array::from_fn(|i| rates.motion.zeta[i] - 0.02);
    let error = rates.error(&zeta, age);
    for i in 0..DOF {
        let expected = 0.02 - age * rates.motion.zeta_dot[i];
        assert!((error[i] - expected).abs() < 1e-15);
    }
}

/// A command counts as held where less than half of it is allowed, at either end of each joint.
#[test]
fn commands_are_held_where_less_than_half_is_allowed() {
    let (_, rates) = rates(&Machine::reference());
    let bound = 0.04;
    let allowed = [Allowed {
        low: (-bound, Hold::End),
        high: (bound, Hold::End),
    }; DOF];
    for joint in 0..DOF {
        for (share, is_held) in [(1.9, false), (2.1, true), (-1.9, false), (-2.1, true)] {
            let mut commands = [0.0; DOF];
            commands[joint] = share * bound;
            let (wanted, held) = rates.of_joints(&commands, &allowed, 0.5);
            let mut expected = Held::default();
            expected.joint[joint] = is_held;
            assert_eq!(held, expected);
            assert_eq!(wanted[joint], share * bound / 0.5);
        }
    }
}
