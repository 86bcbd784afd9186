//! Speed estimates from position readings, for `sample`: filtered difference or tracking observer.

use crate::{Speed, SpeedKind};
use serde::{Deserialize, Serialize};

/// State of a speed estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// The reading, or the observer's position.
    pub(crate) position: f64,
    pub(crate) speed: f64,
    /// Acceleration of the observer.
    pub(crate) acceleration: f64,
}

/// Shortest time between two samples, s; below it the estimate is unchanged.
const SHORTEST: f64 = 1e-9;

/// Largest speed and acceleration of an estimate, far beyond any machine. Alternating steps of very
/// different lengths make the observer diverge; beyond this value it is reset.
const LARGEST: f64 = 1e18;

impl Track {
    /// At rest at `reading`.
    fn at(reading: f64) -> Self {
        Self {
            position: reading,
            ..Self::default()
        }
    }

    /// Whether the estimate is finite and within [`LARGEST`].
    fn is_sound(&self) -> bool {
        self.position.is_finite()
            && self.speed.abs() <= LARGEST
            && self.acceleration.abs() <= LARGEST
    }
}

impl Speed {
    /// The estimate after a reading, `period` s after the last one (`None`: the first, at rest).
    pub(crate) fn follow(&self, before: &Track, reading: f64, period: Option<f64>) -> Track {
        let Some(T) = period else {
            return Track::at(reading);
        };
        let after = match self.kind {
            _ if T < SHORTEST => *before,
            SpeedKind::Ideal => *before,
            SpeedKind::Difference => self.difference(before, reading, T),
            SpeedKind::Observer => self.observer(before, reading, T),
        };
        if after.is_sound() {
            after
        } else {
            Track::at(reading)
        }
    }

    /// Difference quotient with a first-order lag of τ = `filter_time`, exact for a quotient held
    /// over the sample:
    /// ```text
    /// ω ← ω + (1 − e^(−T/τ))·((θ_k − θ_(k−1))/T − ω)
    /// ```
    fn difference(&self, before: &Track, reading: f64, T: f64) -> Track {
        let quotient = (reading - before.position) / T;
        let share = -libm::expm1(-T / self.filter_time); // 1 where the time is 0
        Track {
            position: reading,
            speed: before.speed + share * (quotient - before.speed),
            acceleration: 0.0,
        }
    }

    /// Tracking observer: a model of constant acceleration corrected by the reading, with a triple
    /// pole at β = e^(−ω_o·T). It follows a constant acceleration without error.
    ///
    /// Source: P. Zarchan, H. Musoff, *Fundamentals of Kalman Filtering*, fading-memory filter of
    /// second order.
    /// ```text
    /// e = θ − (θ̂ + T ω̂ + T²/2 α̂)
    /// θ̂ ← θ̂ + T ω̂ + T²/2 α̂ + (1 − β³) e
    /// ω̂ ← ω̂ + T α̂ + 3/2·(1 − β)²(1 + β)/T·e,   α̂ ← α̂ + (1 − β)³/T²·e
    /// ```
    fn observer(&self, before: &Track, reading: f64, T: f64) -> Track {
        let beta = libm::exp(-self.bandwidth * T);
        let forgotten = 1.0 - beta;
        let ahead = before.position + T * (before.speed + 0.5 * T * before.acceleration);
        let e = reading - ahead;
        Track {
            position: ahead + (1.0 - beta * beta * beta) * e,
            speed: before.speed
                + T * before.acceleration
                + 1.5 * forgotten * forgotten * (1.0 + beta) / T * e,
            acceleration: before.acceleration + forgotten * forgotten * forgotten / (T * T) * e,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: f64 = 1e-3;

    fn estimates(speed: &Speed, position: impl Fn(f64) -> f64, n: u32) -> Vec<f64> {
        let mut track = speed.follow(&Track::default(), position(0.0), None);
        (1..=n)
            .map(|k| {
                track = speed.follow(&track, position(f64::from(k) * T), Some(T));
                track.speed
            })
            .collect()
    }

    /// The observer at the motors has its own bandwidth where one is given: it forgets a wrong
    /// speed by e^(−ω_o·t), so that four times the bandwidth needs a quarter of the time.
    #[test]
    fn motors_have_a_bandwidth_of_their_own() {
        let speed = |bandwidth_motor| Speed {
            kind: SpeedKind::Observer,
            filter_time: 0.0,
            bandwidth: 300.0,
            bandwidth_motor,
        };
        let ramp = |speed: &Speed, n| estimates(speed, |t| 2.0 * t, n);
        assert_eq!(ramp(&speed(0.0).for_motors(), 40), ramp(&speed(1.0), 40));
        assert_eq!(speed(1200.0).for_motors().bandwidth, 1200.0);
        let left = |estimates: Vec<f64>| (estimates[estimates.len() - 1] - 2.0).abs();
        let slow = left(ramp(&speed(1200.0), 12));
        let fast = left(ramp(&speed(1200.0).for_motors(), 12));
        assert!(fast < 1e-2 * slow, "{fast} {slow}");
    }

    /// Oracle: answer of a first-order lag to a step of speed, 1 − e^(−t/τ); exact, so only
    /// rounding of θ/T is left.
    #[test]
    fn difference_answers_a_step_of_speed_as_a_first_order_lag() {
        let speed = Speed {
            kind: SpeedKind::Difference,
            filter_time: 0.005,
            bandwidth: 0.0,
            bandwidth_motor: 0.0,
        };
        for (k, found) in estimates(&speed, |t| 3.7 * t, 60).iter().enumerate() {
            let expected = 3.7 * -(-(k as f64 + 1.0) * T / 0.005).exp_m1();
            assert!((found - expected).abs() < 1e-11, "{k}: {found}, {expected}");
        }
        let plain = Speed {
            filter_time: 0.0,
            ..speed
        };
        assert!((estimates(&plain, |t| 3.7 * t, 1)[0] - 3.7).abs() < 1e-11);
    }

    /// However short a step is, the estimate is finite, and one that is too short to tell changes
    /// nothing.
    #[test]
    fn a_step_of_no_length_changes_no_estimate() {
        for kind in [SpeedKind::Difference, SpeedKind::Observer] {
            let speed = Speed {
                kind,
                filter_time: 0.0,
                bandwidth: 300.0,
                bandwidth_motor: 0.0,
            };
            let before = speed.follow(&Track::default(), 0.4, None);
            assert_eq!(speed.follow(&before, 0.7, Some(5e-324)), before);
            assert!(speed.follow(&before, 1e8, Some(1e-9)).speed.is_finite());
        }
    }

    /// Steps of 1 ms and of days in turn make the observer grow by their quotient; the estimate
    /// stays a number, and of use afterwards.
    #[test]
    fn steps_of_very_different_lengths_leave_numbers() {
        for (kind, days) in [
            (SpeedKind::Observer, 1e6),
            (SpeedKind::Observer, 1e300),
            (SpeedKind::Difference, 1e300),
        ] {
            let speed = Speed {
                kind,
                filter_time: 0.005,
                bandwidth: 300.0,
                bandwidth_motor: 0.0,
            };
            let mut track = speed.follow(&Track::default(), 0.0, None);
            for k in 0..200 {
                let period = if k % 2 == 0 { T } else { days };
                track = speed.follow(&track, f64::from(k % 3), Some(period));
                assert!(track.speed.is_finite() && track.acceleration.is_finite());
            }
            for k in 0..200 {
                track = speed.follow(&track, 2.0 * f64::from(k) * T, Some(T));
            }
            assert!((track.speed - 2.0).abs() < 1e-6, "{}", track.speed);
        }
    }

    /// A constant acceleration leaves a lag of τ − T/2 in the difference and none in the observer,
    /// once its triple pole has decayed: (ωt)² e^(−ωt) at ω = 300 1/s and 0.15 s is 6e-17.
    #[test]
    fn only_the_observer_follows_an_acceleration_without_lag() {
        let position = |t: f64| 0.5 * 11.0 * t * t;
        let of = |kind| Speed {
            kind,
            filter_time: 0.005,
            bandwidth: 300.0,
            bandwidth_motor: 0.0,
        };
        let error = |kind| estimates(&of(kind), position, 150)[149] - 11.0 * 0.15;
        assert!(error(SpeedKind::Observer).abs() < 1e-9);
        // τ/(1 − e^(−T/τ))·… : a held quotient lags by T/(1 − e^(−T/τ)) − T, and the quotient
        // itself by T/2.
        let lag = T / -(-T / 0.005_f64).exp_m1() - T + 0.5 * T;
        assert!((error(SpeedKind::Difference) + 11.0 * lag).abs() < 1e-9);
    }
}
