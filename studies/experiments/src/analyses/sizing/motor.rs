//! Peak and continuous torque of a motor over its speed, for `axis` and the report's figures.
#![allow(non_snake_case)] // symbols of the equations

use machine_file::Ratings;
use serde::Serialize;

/// Constants of a motor's torque envelopes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Motor {
    /// Pole pairs.
    pub pole_pairs: f64,
    /// Stator resistance, Ω.
    pub resistance: f64,
    /// Quadrature-axis inductance, H.
    pub inductance: f64,
    /// Flux linkage of the magnets, Wb.
    pub flux: f64,
    /// Largest current, peak, A.
    pub current: f64,
    /// Largest voltage, peak, V: the lesser of `v_max` and what the DC link allows, v_dc/√3.
    pub voltage: f64,
}

impl Motor {
    /// Peak torque at the motor speed `w`, rad/s, N·m, without current in the direct axis: by the
    /// current limit and by the voltage limit `(R i + ω_e λ)² + (ω_e L_q i)² = v²`. It is 0 above the
    /// speed at which the induced voltage reaches that limit.
    pub fn peak(&self, w: f64) -> f64 {
        let w_e = self.pole_pairs * w.abs();
        let (R, X, induced) = (self.resistance, w_e * self.inductance, w_e * self.flux);
        let (square, cross) = (R * R + X * X, R * induced);
        let left = self.voltage * self.voltage - induced * induced;
        let i = ((cross * cross + square * left).max(0.0).sqrt() - cross) / square;
        1.5 * self.pole_pairs * self.flux * i.clamp(0.0, self.current)
    }

    /// Continuous torque at the motor speed `w`, rad/s, N·m: the rated torque up to the rated power,
    /// at most the peak torque.
    pub fn continuous(&self, w: f64, ratings: &Ratings) -> f64 {
        let by_power = ratings.motor_power / w.abs().max(1e-9);
        ratings.motor_torque.min(by_power).min(self.peak(w))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOTOR: Motor = Motor {
        pole_pairs: 4.0,
        resistance: 0.4,
        inductance: 3e-3,
        flux: 0.12,
        current: 70.0,
        voltage: 300.0,
    };

    /// At each speed the peak torque's current meets the current or the voltage limit, by the
    /// voltage equation itself.
    #[test]
    fn the_peak_is_at_a_limit() {
        let mut by_voltage = 0;
        for k in 0..60 {
            let w = 10.0 * f64::from(k);
            let i = MOTOR.peak(w) / (1.5 * MOTOR.pole_pairs * MOTOR.flux);
            let w_e = MOTOR.pole_pairs * w;
            let v = (MOTOR.resistance * i + w_e * MOTOR.flux).hypot(w_e * MOTOR.inductance * i);
            assert!(i <= 70.0 && v <= 300.0 * (1.0 + 1e-12), "{w}: {i} {v}");
            assert!(i == 70.0 || (v / 300.0 - 1.0).abs() < 1e-12, "{w}: {i} {v}");
            by_voltage += u32::from(i < 70.0);
        }
        assert!(0 < by_voltage && by_voltage < 60);
        assert_eq!(MOTOR.peak(700.0), 0.0);
        assert_eq!(MOTOR.peak(-100.0), MOTOR.peak(100.0));
    }
}
