//! Ends a run whose events follow each other without end at one time: chattering, where they are as
//! close as rounding allows, and Zeno, where each comes sooner after the last.

use anyhow::{Result, bail};
use serde::{Deserialize, Serialize};

use crate::digits::short;

/// Events closer than this, relative to the time or 1 s, are crowded.
const CLOSE: f64 = 1e-9;
/// Crowded events in a row that count as chattering.
const MOST: u32 = 100;
/// Crowded events in a row, each after a shorter time than the one before, that count as Zeno.
const MOST_SHRINKING: u32 = 6;

/// The last events of an instance.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Crowding {
    /// Time of the last event, and time before it without one, s.
    last: f64,
    gap: f64,
    crowded: u32,
    shrinking: u32,
}

impl Default for Crowding {
    fn default() -> Self {
        Self {
            last: f64::NEG_INFINITY,
            gap: f64::INFINITY,
            crowded: 0,
            shrinking: 0,
        }
    }
}

impl Crowding {
    /// Adds an event at `t`, s.
    pub fn add(&mut self, t: f64) -> Result<()> {
        let gap = t - self.last;
        let is_crowded = gap < CLOSE * t.abs().max(1.0);
        let is_shrinking = is_crowded && gap > 0.0 && gap < 0.98 * self.gap;
        self.crowded = if is_crowded { self.crowded + 1 } else { 0 };
        self.shrinking = if is_shrinking { self.shrinking + 1 } else { 0 };
        (self.last, self.gap) = (t, gap);
        if self.shrinking >= MOST_SHRINKING {
            bail!(
                "Zeno behaviour at t = {} s: each event comes sooner after the one before, the last {MOST_SHRINKING} within {CLOSE} s: the \
                 model must stop them, for example below a least speed",
                short(t)
            );
        }
        if self.crowded >= MOST {
            bail!(
                "chattering at t = {} s: {MOST} events in a row, each less than {CLOSE} s after the one before: the model switches back and \
                 forth without end; it needs a hysteresis",
                short(t)
            );
        }
        Ok(())
    }
}
