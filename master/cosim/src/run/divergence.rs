//! Detects divergence, for `supervision`. It is the sign of a communication step that is too long:
//! a value that jumps up and down from one communication point to the next, further each time. A
//! loop of components does that long before a component refuses a value. A physical oscillation
//! does not, because many communication steps resolve it; noise jumps, but does not keep growing.

use serde::{Deserialize, Serialize};

/// Communication steps of a window, over which changes are counted.
const WINDOW: u32 = 8;
/// Reversals of direction from which on a window is unresolved: three or more in eight steps are a
/// period of five steps or less.
const TURNS: f64 = 3.0;
/// Growth of the largest change from one window to the next.
const GROWTH: f64 = 2.0;
/// Growth over all windows in a row, far more than noise grows by chance.
const TOTAL: f64 = 1e4;
/// Changes below this, in SI units, count as rounding errors of larger values.
const ROUNDING: f64 = 1e-9;

/// Windows in a row in which the changes of a value grew.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
struct Growth {
    windows: u32,
    /// Start of the first of them, s.
    since: f64,
    /// Largest change in the window before the first.
    first: f64,
    /// Largest change in the last window.
    last: f64,
    /// Largest change in all windows before the first.
    ever: f64,
}

/// Watches the exchanged values. Each quantity that is updated at every step has an array of its
/// own, so that the compiler vectorizes the loop.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Watch {
    values: Vec<f64>,
    changes: Vec<f64>,
    /// Reversals of direction in this window.
    turns: Vec<f64>,
    /// Largest change of this window.
    largest: Vec<f64>,
    growth: Vec<Growth>,
    steps: u32,
    /// Start of this window, s.
    start: f64,
    /// Index of the first value that diverged, and since when, s.
    pub diverged: Option<(usize, f64)>,
}

impl Watch {
    /// Starts with the values at time `t`, s.
    pub fn new(t: f64, values: &[f64]) -> Self {
        let zeros = vec![0.0; values.len()];
        Self {
            values: values.to_vec(),
            changes: zeros.clone(),
            turns: zeros.clone(),
            largest: zeros,
            growth: vec![Growth::default(); values.len()],
            steps: 0,
            start: t,
            diverged: None,
        }
    }

    /// Adds the values at time `t`, s, one communication step later.
    pub fn add(&mut self, t: f64, values: &[f64]) {
        let before = self.values.iter_mut().zip(&mut self.changes);
        let window = self.turns.iter_mut().zip(&mut self.largest);
        for ((now, (value, last)), (turns, largest)) in values.iter().zip(before).zip(window) {
            let change = now - *value;
            *turns += if change * *last < 0.0 { 1.0 } else { 0.0 };
            // One instruction; `max` would check for NaN first.
            *largest = if change.abs() > *largest {
                change.abs()
            } else {
                *largest
            };
            (*value, *last) = (*now, change);
        }
        self.steps += 1;
        if self.steps == WINDOW {
            let window = self.turns.iter_mut().zip(&mut self.largest);
            for (k, (growth, (turns, largest))) in self.growth.iter_mut().zip(window).enumerate() {
                let since = growth.close(self.start, *turns >= TURNS, *largest);
                self.diverged = self.diverged.or(since.map(|since| (k, since)));
                (*turns, *largest) = (0.0, 0.0);
            }
            (self.steps, self.start) = (0, t);
        }
    }
}

impl Growth {
    /// Closes a window that began at `start`, s; returns since when the value has diverged, s.
    fn close(&mut self, start: f64, is_unresolved: bool, largest: f64) -> Option<f64> {
        if is_unresolved && self.last > 0.0 && largest > GROWTH * self.last {
            if self.windows == 0 {
                (self.since, self.first) = (start, self.last);
            }
            self.windows += 1;
        } else {
            self.windows = 0;
            self.ever = self.ever.max(self.last).max(largest);
        }
        self.last = largest;
        let is_far = largest > ROUNDING.max(TOTAL * self.first).max(self.ever);
        (self.windows >= 2 && is_far).then_some(self.since)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn diverged(of: impl Fn(f64) -> f64) -> Option<(usize, f64)> {
        let mut watch = Watch::new(0.0, &[1.0, of(0.0)]);
        for k in 1..400 {
            let t = f64::from(k);
            watch.add(t, &[1.0, of(t)]);
        }
        watch.diverged
    }

    /// Any period that the steps do not resolve; the time is that of the first window which has one
    /// to grow over.
    #[test]
    fn an_unresolved_growth_is_seen_where_it_begins() {
        assert_eq!(diverged(|t| (-2.0f64).powf(t)), Some((1, 8.0)));
        assert_eq!(
            diverged(|t| 1.5f64.powf(t) * (2.1 * t).cos()),
            Some((1, 8.0))
        );
        let late = |t: f64| 3.0 + 1e-9 * (-2.0f64).powf(t.max(48.0) - 48.0);
        let (k, since) = diverged(late).unwrap();
        assert!(k == 1 && (48.0..=64.0).contains(&since), "{since}");
    }

    #[test]
    fn decay_noise_and_resolved_growth_are_none() {
        assert_eq!(diverged(|t| (-0.9f64).powf(t)), None);
        assert_eq!(diverged(|t| 1.5f64.powf(t)), None);
        assert_eq!(diverged(|t| (0.3 * t).sin() * 1.5f64.powf(t)), None);
        assert_eq!(diverged(|t| (7919.0 * t * t).sin()), None);
        assert_eq!(diverged(|t| 1e6 + (-1.0f64).powf(t)), None);
        // The noise of a reading that rested meanwhile, as an encoder's does.
        let rests = |t: f64| match t as u32 {
            80..160 => 1e-7 * (-0.9f64).powf(t),
            160..168 => 1e-4 * (-1.0f64).powf(t),
            _ => (-1.0f64).powf(t),
        };
        assert_eq!(diverged(rests), None);
        // A value at rest, of which first nothing, then the last digit of a larger one is left.
        let digits = |t: f64| 2e-11 + 1e-27 * (-2.0f64).powf(t.min(36.0));
        assert_eq!(diverged(digits), None);
    }
}
