//! Whether a noisy reading repeats, for the monitors.

use serde::{Deserialize, Serialize};

/// Changes by which a noisy reading is known, the repeats that it may have between them by chance, and
/// those that it then may have because readings are lost.
const NOISY: u32 = 200;
const FEW: u32 = 10;
const REPEATS: u32 = 50;

/// Whether a reading that used to change repeats.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Repeats {
    last: f64,
    changes: u32,
    repeats: u32,
}

impl Repeats {
    /// Adds a reading; true while it changes, and has long changed, as noise does.
    pub(super) fn add(&mut self, reading: f64) -> bool {
        if reading == self.last {
            self.repeats += 1;
        } else {
            self.changes = if self.repeats > FEW {
                0
            } else {
                self.changes.saturating_add(1)
            };
            self.repeats = 0;
        }
        self.last = reading;
        self.repeats == 0 && self.changes >= NOISY
    }

    /// Whether it no longer changes.
    pub(super) fn is_stale(&self) -> bool {
        self.changes >= NOISY && self.repeats >= REPEATS
    }
}
