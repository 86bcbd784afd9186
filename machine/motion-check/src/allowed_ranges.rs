//! Ranges that the machine file allows and a demand's margins to them, for `tip-path` and studies.

use crate::demand::Demand;
use crate::quantity::Quantity;
use machine_file::Machine;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Allowed range of every quantity, from these sections of the machine file: rod forces, rod speeds
/// and motor speeds from `ratings`; joints, strokes and wrist torques from `limits`; currents from
/// `emla.i_max`; voltages as the inverter can give from its DC link, at most `emla.v_max`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AllowedRanges {
    /// Least and largest value, in the order of [`Quantity::all`], SI units.
    ranges: [[f64; 2]; Quantity::COUNT],
}

/// A quantity's value together with its allowed range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// The quantity.
    pub quantity: Quantity,
    /// Its value, SI unit.
    pub value: f64,
    /// Smallest and largest allowed value, SI unit.
    pub range: [f64; 2],
}

impl AllowedRanges {
    /// The allowed ranges of a machine.
    pub fn from_machine(machine: &Machine) -> Self {
        let (zeta, strokes) = (machine.limits.zeta(), machine.limits.strokes());
        let (ratings, emla) = (machine.ratings.in_order(), machine.emla.in_order());
        let both = |largest: f64| [-largest, largest];
        let range = |quantity| match quantity {
            Quantity::Joint(k) => zeta[k],
            Quantity::Stroke(k) => strokes[k],
            Quantity::RodSpeed(k) => both(ratings[k].rod_speed_max),
            Quantity::Force(k) => both(ratings[k].force_max),
            Quantity::WristTorque(k) => both(machine.limits.tau_wrist_max[k]),
            Quantity::MotorSpeed(k) => {
                both(ratings[k].motor_speed_rpm * std::f64::consts::PI / 30.0)
            }
            Quantity::Current(k) => both(emla[k].i_max),
            Quantity::Voltage(k) => both(emla[k].largest_voltage(emla[k].link_voltage())),
        };
        Self {
            ranges: Quantity::all().map(range),
        }
    }

    /// Margins of all quantities, in the order of [`Quantity::all`].
    pub fn margins(&self, demand: &Demand) -> [Margin; Quantity::COUNT] {
        let all = Quantity::all();
        std::array::from_fn(|k| Margin {
            quantity: all[k],
            value: demand.value(all[k]),
            range: self.ranges[k],
        })
    }
}

impl Margin {
    /// Distance to the nearer end of the range over half the range: 1 in the middle (zero force), 0
    /// at the limit, negative beyond it. NaN if the value is NaN.
    pub fn part(&self) -> f64 {
        let [min, max] = self.range;
        let nearer = (self.value - min).min(max - self.value);
        // `min` drops a NaN.
        nearer / (0.5 * (max - min)) + 0.0 * self.value
    }

    /// Whether the value is within its range; NaN is not.
    pub fn holds(&self) -> bool {
        let [min, max] = self.range;
        min <= self.value && self.value <= max
    }
}

/// Writes value, limit, and by how much the limit is exceeded.
impl fmt::Display for Margin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, per_si) = self.quantity.unit();
        let [min, max] = self.range.map(|end| rounded(end * per_si));
        let value = self.value * per_si;
        write!(f, "{} = {value:.2} {unit} must be ", self.quantity)?;
        if min == -max {
            write!(f, "at most {max} {unit} in magnitude")?;
        } else {
            write!(f, "{min} to {max} {unit}")?;
        }
        if self.holds() {
            return write!(f, ": {:.1} % of the range left", 100.0 * self.part());
        }
        let beyond = (min - value).max(value - max);
        write!(f, ": {beyond:.2} {unit} beyond")?;
        if min == -max {
            write!(f, " ({:.1} %)", 100.0 * beyond / max)?;
        }
        Ok(())
    }
}

/// Removes the rounding errors of a unit conversion.
fn rounded(value: f64) -> f64 {
    (1e6 * value).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    fn margin(quantity: Quantity, value: f64, range: [f64; 2]) -> Margin {
        Margin {
            quantity,
            value,
            range,
        }
    }

    #[test]
    fn a_margin_is_one_in_the_middle_and_negative_beyond() {
        let of = |value| margin(Quantity::Stroke(1), value, [0.2, 0.6]);
        for (value, part) in [(0.4, 1.0), (0.5, 0.5), (0.6, 0.0), (0.7, -0.5), (0.1, -0.5)] {
            assert!((of(value).part() - part).abs() < 1e-12, "{value}");
        }
        assert!(of(0.6).holds() && !of(0.6001).holds());
        assert!(of(f64::NAN).part().is_nan() && !of(f64::NAN).holds());
    }

    #[test]
    fn a_margin_says_value_limit_and_by_how_much() {
        let force = margin(Quantity::Force(2), -73_500.0, [-70e3, 70e3]);
        assert_eq!(
            force.to_string(),
            "force of tilt = -73.50 kN must be at most 70 kN in magnitude: 3.50 kN beyond (5.0 %)"
        );
        let joint = margin(Quantity::Joint(2), (-15.0_f64).to_radians(), [-2.0, -0.3]);
        assert_eq!(
            joint.to_string(),
            "joint 3 (tilt) = -15.00 deg must be -114.591559 to -17.188734 deg: 2.19 deg beyond"
        );
        let held = margin(Quantity::Stroke(0), 0.25, [0.0, 0.5]);
        assert_eq!(
            held.to_string(),
            "stroke of slew = 250.00 mm must be 0 to 500 mm: 100.0 % of the range left"
        );
    }
}
