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
