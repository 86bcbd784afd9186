//! Tracking observer for `controller`: estimates the joint rates from the joint angles.
//!
//! Not in the paper, which measures rates. Differences of encoder angles are coarse, and a filter
//! delays them. The observer uses the required acceleration, so it lags only behind other motion.
//! ```text
//! predicted   ζ⁻ = ζ̂ + h v̂ + h² ζ̈_r/2,   v⁻ = v̂ + h ζ̈_r
//! corrected   ζ̂ = ζ⁻ + (1 − a²)(ζ − ζ⁻),  v̂ = v⁻ + (1 − a)² (ζ − ζ⁻)/h,   a = e^(−ω h)
//! ```
//! Both poles are at −ω (the critically damped g-h filter: Brookner, "Tracking and Kalman Filtering
//! Made Easy", 1998).

use crate::signals::Input;
use hdrm::DOF;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// State of the observer: the joints predicted for the present communication point.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct JointObserver {
    /// ζ⁻, rad.
    angle: [f64; DOF],
    /// v⁻, rad/s.
    rate: [f64; DOF],
    /// The last step, s; 0 before the first, when the measured rates are used.
    h: f64,
}

/// Largest predicted angle, rad, and rate, rad/s, far beyond any machine's. With absurd gains and
/// steps the predictions may diverge; beyond this value the observer is reset.
const LARGEST: f64 = 1e9;

impl JointObserver {
    /// The measurements with the observer's joint rates (bandwidth `omega`, rad/s; 0: none).
    pub(crate) fn with_observed_rates<'a>(&self, input: &'a Input, omega: f64) -> Cow<'a, Input> {
        if omega == 0.0 {
            return Cow::Borrowed(input);
        }
        let rates = self.corrected(&input.zeta, omega);
        Cow::Owned(Input {
            zeta_dot: rates.unwrap_or(input.zeta_dot),
            ..*input
        })
    }

    /// Rates v̂, rad/s, for the measured angles `zeta`; None before the first step.
    fn corrected(&self, zeta: &[f64; DOF], omega: f64) -> Option<[f64; DOF]> {
        let gain = libm::expm1(-self.h * omega).powi(2) / self.h;
        let rate = |j: usize| self.rate[j] + gain * (zeta[j] - self.angle[j]);
        (self.h > 0.0).then(|| std::array::from_fn(rate))
    }

    /// The state after `h` s with the accelerations `zeta_ddot`, from angles and rates v̂.
    pub(crate) fn advanced(
        &self,
        zeta: &[f64; DOF],
        rate: &[f64; DOF],
        zeta_ddot: &[f64; DOF],
        omega: f64,
        h: f64,
    ) -> Self {
        // The share of the angle's error that remains.
        let rest = if self.h > 0.0 {
            libm::exp(-2.0 * self.h * omega)
        } else {
            0.0
        };
        let angle = |j: usize| {
            let now = zeta[j] + rest * (self.angle[j] - zeta[j]);
            now + h * (rate[j] + 0.5 * h * zeta_ddot[j])
        };
        let next = Self {
            angle: std::array::from_fn(angle),
            rate: std::array::from_fn(|j| rate[j] + h * zeta_ddot[j]),
            h,
        };
        if next.is_sound() {
            next
        } else {
            Self::default()
        }
    }

    fn is_sound(&self) -> bool {
        let mut predictions = self.angle.iter().chain(&self.rate);
        predictions.all(|value| value.abs() <= LARGEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest error of the rate in the last of `steps`, with the acceleration told or not.
    fn error(told: bool, quantum: f64, h: f64, omega: f64) -> f64 {
        let mut observer = JointObserver::default();
        let mut worst: f64 = 0.0;
        for k in 0..2000 {
            let t = f64::from(k) * h;
            let (angle, rate, acceleration) = (t.sin(), t.cos(), -t.sin());
            let zeta = [match quantum {
                0.0 => angle,
                q => (angle / q).round() * q,
            }; DOF];
            let found = observer.corrected(&zeta, omega).unwrap_or([rate; DOF]);
            if k > 1000 {
                worst = worst.max((found[2] - rate).abs());
            }
            let known = if told { acceleration } else { 0.0 };
            observer = observer.advanced(&zeta, &found, &[known; DOF], omega, h);
        }
        worst
    }

    /// With the acceleration told it errs by what a step leaves out, h·|jerk|·h/2 each step over
    /// the 2/(ω h) steps it remembers: h/ω. Without, by the critically damped filter's lag of 2/ω
    /// times the acceleration of 1 rad/s².
    #[test]
    fn it_follows_what_it_is_told_and_lags_behind_the_rest() {
        let (h, omega) = (1e-3, 80.0);
        let told = error(true, 0.0, h, omega);
        let untold = error(false, 0.0, h, omega);
        println!("told {told:e}, untold {untold:e}");
        assert!(told < 1.5 * h / omega, "{told:e}");
        assert!(
            (untold - 2.0 / omega).abs() < 0.1 * 2.0 / omega,
            "{untold:e}"
        );
    }

    /// An acceleration that grows with the rate it leads to makes the observer grow; the estimate
    /// stays a number, and of use afterwards.
    #[test]
    fn absurd_accelerations_leave_numbers() {
        let (h, omega) = (1e-3, 80.0);
        let mut observer = JointObserver::default();
        for _ in 0..10_000 {
            let rate = observer.corrected(&[0.0; DOF], omega).unwrap_or([1.0; DOF]);
            assert!(rate.iter().all(|rate| rate.is_finite()));
            let asked = rate.map(|rate| 1e5 * rate);
            observer = observer.advanced(&[0.0; DOF], &rate, &asked, omega, h);
        }
        let mut rate = [0.0; DOF];
        for k in 0..2000 {
            let zeta = [2.0 * f64::from(k) * h; DOF];
            rate = observer.corrected(&zeta, omega).unwrap_or([2.0; DOF]);
            observer = observer.advanced(&zeta, &rate, &[0.0; DOF], omega, h);
        }
        assert!((rate[0] - 2.0).abs() < 1e-9, "{}", rate[0]);
    }

    /// A difference of angles of 19 bits is off by up to a quantum a step: 0.012 rad/s at 1 ms.
    #[test]
    fn it_smooths_a_coarse_encoder() {
        let quantum = std::f64::consts::TAU / f64::from(1 << 19);
        let found = error(true, quantum, 1e-3, 80.0);
        assert!(found < 0.05 * quantum / 1e-3, "{found:e}");
    }
}
