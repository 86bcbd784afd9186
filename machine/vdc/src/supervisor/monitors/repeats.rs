//! Whether a noisy reading repeats, for the monitors. Noise turns back every few readings; what moves
//! smoothly does not, nor does rounding count.

use serde::{Deserialize, Serialize};

/// Changes by which a noisy reading is known, of which one in [`TURNS`] turns back, the repeats that it may
/// have between them by chance, and those that it then may have because readings are lost. White noise
/// through a first-order filter turns back at every second change, what swings at 20 Hz at one in 25.
const NOISY: u32 = 200;
/// Changes of which at least half are remembered.
const REMEMBERED: u32 = 20_000;
const TURNS: u32 = 10;
const FEW: u32 = 10;
const REPEATS: u32 = 50;
/// Part of the largest reading up to which a change is rounding.
const ROUNDING: f64 = 1e-7;

/// Whether a reading that used to change repeats.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Repeats {
    last: f64,
    largest: f64,
    /// The last change.
    change: f64,
    changes: u32,
    /// Changes that turned back the one before.
    turns: u32,
    repeats: u32,
}

impl Repeats {
    /// Adds a reading; true while it changes, and has long changed, as noise does.
    pub(super) fn add(&mut self, reading: f64) -> bool {
        let change = reading - self.last;
        self.largest = self.largest.max(reading.abs());
        if change == 0.0 {
            self.repeats += 1;
        } else {
            if self.repeats > FEW {
                (self.changes, self.turns) = (0, 0);
            }
            let least = change.abs().min(self.change.abs());
            let is_back = change * self.change < 0.0 && least > ROUNDING * self.largest;
            self.turns += u32::from(is_back);
            self.changes += 1;
            if self.changes >= REMEMBERED {
                (self.changes, self.turns) = (self.changes / 2, self.turns / 2);
            }
            (self.change, self.repeats) = (change, 0);
        }
        self.last = reading;
        self.repeats == 0 && self.is_noisy()
    }

    /// Whether it no longer changes.
    pub(super) fn is_stale(&self) -> bool {
        self.is_noisy() && self.repeats >= REPEATS
    }

    fn is_noisy(&self) -> bool {
        self.changes >= NOISY && TURNS * self.turns >= self.changes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a reading is stale that for two seconds was `before(t)`, and stands since.
    fn is_stale(before: impl Fn(f64) -> f64) -> bool {
        let mut repeats = Repeats::default();
        let reading = |k: u32| before(1e-3 * f64::from(k.min(2000)));
        (0..2100).any(|k| {
            repeats.add(reading(k));
            repeats.is_stale()
        })
    }

    /// Noise turns back, also where a filter of 5 ms and a force that rises by 10 kN/s hide it; what
    /// swings at 20 Hz or rounds does not.
    #[test]
    fn noise_that_ends_is_stale() {
        let noise = |t: f64| (7919.0 * t * 1e3).sin();
        assert!(is_stale(noise));
        assert!(is_stale(|t| 10.0 * t + 0.1 * noise(t)));
        assert!(!is_stale(|t| (125.0 * t).sin()));
        assert!(!is_stale(|t| 1e5 + 1e-10 * noise(t)));
    }
}
