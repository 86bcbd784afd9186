//! Time law of `legs`: double S-curve from rest to rest with limited speed, acceleration and jerk.

use serde::{Deserialize, Serialize};

/// The double S-curve from 0 to 1 in closed form (Biagiotti and Melchiorri, "Trajectory Planning
/// for Automatic Machines and Robots", 2008, section 3.4, for rest at both ends): constant jerk j
/// for `t_j`, constant acceleration to the end of `t_a`, constant speed to the middle; the second
/// half is the first one backwards.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// 1/s³.
    jerk: f64,
    /// Time of the first constant jerk, s.
    t_j: f64,
    /// Time in which the speed is reached, s.
    t_a: f64,
    /// Whole time, s.
    duration: f64,
}

impl Profile {
    /// The fastest profile with at most these rates, 1/s, 1/s² and 1/s³, all greater than 0.
    pub fn fastest(v: f64, a: f64, j: f64) -> Self {
        // Where the acceleration is not reached: t_a = 2 t_j.
        let (mut t_j, mut t_a) = if v * j < a * a {
            let t_j = (v / j).sqrt();
            (t_j, 2.0 * t_j)
        } else {
            (a / j, a / j + v / a)
        };
        let mut duration = 1.0 / v + t_a;
        if v * t_a > 1.0 {
            // The speed is not reached: both halves are acceleration and its end only.
            t_j = a / j;
            (t_j, t_a) = if 2.0 * a * t_j * t_j <= 1.0 {
                (t_j, 0.5 * t_j + (0.25 * t_j * t_j + 1.0 / a).sqrt())
            } else {
                let t_j = libm::cbrt(0.5 / j);
                (t_j, 2.0 * t_j)
            };
            duration = 2.0 * t_a;
        }
        Self {
            jerk: j,
            t_j,
            t_a,
            duration,
        }
    }

    /// The same profile stretched to the longer `duration`, s.
    pub fn stretched(&self, duration: f64) -> Self {
        let k = duration / self.duration;
        Self {
            jerk: self.jerk / (k * k * k),
            t_j: self.t_j * k,
            t_a: self.t_a * k,
            duration,
        }
    }

    /// Duration from rest to rest, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Times at which acceleration and speed are largest, s, ascending.
    pub fn extremes(&self) -> [f64; 5] {
        let Self {
            t_j,
            t_a,
            duration: T,
            ..
        } = *self;
        [t_j, t_a - t_j, 0.5 * T, T - t_a + t_j, T - t_j]
    }

    /// Part of the way and its first two derivatives at `t`, s; at rest outside the duration.
    pub fn at(&self, t: f64) -> [f64; 3] {
        if t <= 0.0 {
            return [0.0; 3];
        }
        if t >= self.duration {
            return [1.0, 0.0, 0.0];
        }
        if t <= 0.5 * self.duration {
            return self.first_half(t);
        }
        let [s, v, a] = self.first_half(self.duration - t);
        [1.0 - s, v, -a]
    }

    fn first_half(&self, t: f64) -> [f64; 3] {
        let Self { jerk, t_j, t_a, .. } = *self;
        let a = jerk * t_j;
        let v = a * (t_a - t_j);
        if t < t_j {
            [jerk * t * t * t / 6.0, 0.5 * jerk * t * t, jerk * t]
        } else if t < t_a - t_j {
            [
                a * (0.5 * t * (t - t_j) + t_j * t_j / 6.0),
                a * (t - 0.5 * t_j),
                a,
            ]
        } else if t < t_a {
            let left = t_a - t;
            let s = v * (t - 0.5 * t_a) + jerk * left * left * left / 6.0;
            [s, v - 0.5 * jerk * left * left, jerk * left]
        } else {
            [v * (t - 0.5 * t_a), v, 0.0]
        }
    }

    /// Time from rest to the part `s` ≤ 1/2 of the way, s; the same from 1 − s to rest.
    pub fn time_to(&self, s: f64) -> f64 {
        let (mut early, mut late) = (0.0, 0.5 * self.duration);
        for _ in 0..60 {
            let t = 0.5 * (early + late);
            if self.at(t)[0] < s {
                early = t;
            } else {
                late = t;
            }
        }
        late
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Limits of which some bind and others do not: with cruise, without, without constant
    /// acceleration, without both.
    const CASES: [[f64; 3]; 5] = [
        [0.31, 0.7, 2.3],
        [5.0, 0.7, 2.3],
        [0.31, 0.9, 0.7],
        [7.0, 11.0, 2.3],
        [0.9, 50.0, 1e3],
    ];

    /// Rates stay within the limits and one of them is reached; position, speed and acceleration
    /// are continuous and each the derivative of the one before: differences over δ = 1e-6 s err by
    /// δ²/6 of the next but one derivative, here by rounding, 1e-16/δ, where speed and acceleration
    /// are smooth, and by j·δ where the jerk jumps.
    #[test]
    fn a_profile_keeps_its_limits_and_is_smooth() {
        for [v_max, a_max, j_max] in CASES {
            let p = Profile::fastest(v_max, a_max, j_max);
            let duration = p.duration();
            let (mut v_top, mut a_top): (f64, f64) = (0.0, 0.0);
            let d = 1e-6;
            for k in 1..4000 {
                let t = duration * f64::from(k) / 4000.0;
                let [[s0, v0, _], [_, v, a], [s1, v1, _]] = [p.at(t - d), p.at(t), p.at(t + d)];
                assert!(
                    ((s1 - s0) / (2.0 * d) - v).abs() < 1e-9 + j_max * d * d,
                    "{t}"
                );
                assert!(
                    ((v1 - v0) / (2.0 * d) - a).abs() < 1e-9 + 2.0 * j_max * d,
                    "{t}"
                );
                (v_top, a_top) = (v_top.max(v), a_top.max(a.abs()));
            }
            assert!(v_top <= v_max * (1.0 + 1e-12) && a_top <= a_max * (1.0 + 1e-12));
            assert_eq!([p.at(0.0), p.at(duration)], [[0.0; 3], [1.0, 0.0, 0.0]]);
            let near = |x: f64, limit: f64| x > 0.999 * limit;
            let jerk_only = (p.t_a - 2.0 * p.t_j).abs() < 1e-12;
            assert!(
                near(v_top, v_max) || near(a_top, a_max) || jerk_only,
                "{v_top} {a_top}"
            );
        }
    }

    /// Closed forms by hand: with cruise the time is 1/v + v/a + a/j, without any plateau
    /// 4·(1/(2j))^(1/3).
    #[test]
    fn durations_are_the_closed_forms() {
        let duration = Profile::fastest(0.25, 0.5, 2.0).duration();
        assert!((duration - (4.0 + 0.5 + 0.25)).abs() < 1e-14, "{duration}");
        let duration = Profile::fastest(9.0, 9.0, 4.0).duration();
        assert!(
            (duration - 4.0 * 0.125_f64.cbrt()).abs() < 1e-14,
            "{duration}"
        );
    }

    #[test]
    fn a_stretched_profile_has_the_same_way_and_lower_rates() {
        let p = Profile::fastest(0.31, 0.7, 2.3);
        let slow = p.stretched(1.7 * p.duration());
        for k in 0..=20 {
            let t = p.duration() * f64::from(k) / 20.0;
            let ([s, v, a], [s1, v1, a1]) = (p.at(t), slow.at(1.7 * t));
            assert!((s - s1).abs() < 1e-14 && (v - 1.7 * v1).abs() < 1e-14);
            assert!((a - 1.7 * 1.7 * a1).abs() < 1e-13, "{a} {a1}");
        }
    }

    #[test]
    fn the_time_to_a_part_of_the_way_is_its_inverse() {
        let p = Profile::fastest(0.31, 0.7, 2.3);
        for s in [1e-4, 0.1, 0.37, 0.5] {
            assert!((p.at(p.time_to(s))[0] - s).abs() < 1e-13, "{s}");
        }
    }
}
