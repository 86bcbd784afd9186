//! How long the reference has stood still, for `controller`: after a while the machine is where it
//! may stay for long, has the gains with which it rests at any pose, and learns nothing from noise.

use crate::reference::DesiredMotion;
use hdrm::DOF;
use serde::{Deserialize, Serialize};

/// Time for which the gains of a path stay, s: longer than the rest before a path.
const STAYS: f64 = 4.5;
/// Time in which they fall, and in which they return once the reference moves, s.
const FALLS: f64 = 0.5;
const RETURNS: f64 = 0.1;
/// Rates that the joints of a machine at rest lack, as a mean over a time, rad/s and s, below which nothing
/// excites its estimates: what is left then is noise, whose square would move them for ever. Those of lift
/// and tilt are an error of the tip of some tenths of a millimetre; the slew bears no weight and stands
/// where its play and friction let it; in the wrist two axes that are almost parallel oppose each other.
const LACKS: [f64; DOF] = [1e-3, 2e-4, 2e-4, 5e-3, 5e-3, 5e-3];
const MEAN: f64 = 1.0;

/// The reference of the step before, and for how long it has stood still, s, at most until the gains
/// have fallen.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Standstill {
    last: Option<DesiredMotion>,
    time: f64,
    /// Mean of the required joint rates minus the measured ones, rad/s.
    lacking: [f64; DOF],
}

impl Standstill {
    /// Share of the gains' fall, 0 to 1.
    pub(crate) fn share(&self) -> f64 {
        ((self.time - STAYS) / FALLS).max(0.0)
    }

    /// Whether it stands where nothing excites the estimates of the bodies.
    pub(crate) fn teaches_nothing(&self) -> bool {
        self.share() >= 1.0
            && self
                .lacking
                .iter()
                .zip(LACKS)
                .all(|(rate, most)| rate.abs() < most)
    }

    /// Advances by `h` s with the reference `desired` held, and joints that are `lacking` such rates.
    pub(crate) fn advance(&mut self, desired: &DesiredMotion, lacking: &[f64; DOF], h: f64) {
        let reached = -libm::expm1(-h / MEAN);
        for (mean, rate) in self.lacking.iter_mut().zip(lacking) {
            *mean += reached * (rate - *mean);
        }
        let stands = !desired.is_moving() && self.last.as_ref() == Some(desired);
        self.last = Some(*desired);
        self.time = match self.share() {
            _ if stands => (self.time + h).min(STAYS + FALLS),
            0.0 => 0.0,
            _ => self.time - h * FALLS / RETURNS,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{UnitQuaternion, Vector3};

    const H: f64 = 1e-3;

    /// What stands in place `x`, m.
    fn at(x: f64) -> DesiredMotion {
        DesiredMotion::rest(Vector3::new(x, 0.0, 0.0), UnitQuaternion::identity())
    }

    fn after(standstill: &mut Standstill, seconds: f64, x: impl Fn(f64) -> f64) -> f64 {
        for k in 0..(seconds / H).round() as u32 {
            standstill.advance(&at(x(H * f64::from(k))), &[0.0; DOF], H);
        }
        standstill.share()
    }

    /// None of it in the rest before a path, the whole after 5 s, and none 0.1 s after a start; a
    /// position that moves without a velocity, as from an importer that gives none, is no rest.
    #[test]
    fn gains_fall_after_a_while_at_rest() {
        let mut standstill = Standstill::default();
        assert_eq!(after(&mut standstill, 4.0, |_| 0.3), 0.0);
        let half = after(&mut standstill, 0.75, |_| 0.3);
        assert!((half - 0.5).abs() < 3.0 * H / FALLS, "{half}");
        assert!((after(&mut standstill, 5.0, |_| 0.3) - 1.0).abs() < 1e-12);
        assert_eq!(after(&mut standstill, 0.103, |t| 0.3 + t), 0.0);
        assert_eq!(after(&mut standstill, 20.0, |t| 1e-3 * t), 0.0);
    }

    /// Noise of the rates teaches a machine at rest nothing, however long; one that lacks 0.5 mrad/s at the
    /// lift, as with another load, learns, and so does one whose reference moves.
    #[test]
    fn noise_teaches_nothing_at_rest() {
        let mut standstill = Standstill::default();
        let mut taught = |seconds: f64, lift: f64, speed: f64| {
            for k in 0..(seconds / H).round() as u32 {
                let t = H * f64::from(k);
                let noise = 0.01 * if k % 2 == 0 { 1.0 } else { -1.0 };
                standstill.advance(
                    &at(speed * t),
                    &[noise, lift + noise, noise, 0.0, 0.0, 0.0],
                    H,
                );
            }
            !standstill.teaches_nothing()
        };
        assert!(taught(4.9, 0.0, 0.0), "before it has stood for 5 s");
        assert!(!taught(1.0, 0.0, 0.0));
        assert!(taught(1.0, 5e-4, 0.0));
        assert!(!taught(5.0, 0.0, 0.0));
        assert!(taught(0.1, 0.0, 0.1));
    }
}
