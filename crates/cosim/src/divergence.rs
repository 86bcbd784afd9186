//! The signature of a communication step that is too long: a value that jumps up and down from one communication point to the next, ever
//! further. A loop of components does that long before one of them refuses a value. A physical oscillation does not, because many
//! communication steps resolve it; noise does, but it does not grow.

/// Communication steps over which changes are looked at together.
const WINDOW: u32 = 8;
/// Changes against the one before from which on a window is not resolved: three or more in eight steps are a period of five or less.
const TURNS: u32 = 3;
/// Growth of the largest change from one window to the next.
const GROWTH: f64 = 2.0;
/// Growth over all windows in a row, far beyond what noise does by chance.
const TOTAL: f64 = 1e4;

/// One value over the run.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    value: f64,
    change: f64,
    /// Of this window.
    turns: u32,
    largest: f64,
    /// Largest change of the window before.
    before: f64,
    /// Windows in a row that grew, when the first began, s, and the largest change before it.
    windows: u32,
    since: f64,
    first: f64,
}

/// Watches values that are exchanged.
#[derive(Clone, Debug)]
pub struct Watch {
    courses: Vec<Course>,
    steps: u32,
    /// Start of this window, s.
    start: f64,
    /// Index of the first value that diverged, and when that began, s.
    pub diverged: Option<(usize, f64)>,
}

impl Watch {
    /// Of the values at the start, time `t`, s.
    pub fn new(t: f64, values: &[f64]) -> Self {
        let course = |value: &f64| Course {
            value: *value,
            ..Course::default()
        };
        Self {
            courses: values.iter().map(course).collect(),
            steps: 0,
            start: t,
            diverged: None,
        }
    }

    /// Add the values at time `t`, s, one communication step later.
    pub fn add(&mut self, t: f64, values: &[f64]) {
        for (course, value) in self.courses.iter_mut().zip(values) {
            let change = value - course.value;
            course.turns += u32::from(change * course.change < 0.0);
            course.largest = course.largest.max(change.abs());
            (course.value, course.change) = (*value, change);
        }
        self.steps += 1;
        if self.steps == WINDOW {
            let start = self.start;
            let grown = self.courses.iter_mut().map(|c| c.close(start));
            let grown = grown.enumerate().filter_map(|(k, s)| Some((k, s?)));
            self.diverged = grown.fold(self.diverged, |first, now| first.or(Some(now)));
            (self.steps, self.start) = (0, t);
        }
    }
}

impl Course {
    /// Close a window that began at `start`, s; since when the value has been diverging, s.
    fn close(&mut self, start: f64) -> Option<f64> {
        if self.turns >= TURNS && self.largest > GROWTH * self.before && self.before > 0.0 {
            if self.windows == 0 {
                (self.since, self.first) = (start, self.before);
            }
            self.windows += 1;
        } else {
            self.windows = 0;
        }
        let has_grown = self.windows >= 2 && self.largest > TOTAL * self.first;
        (self.turns, self.before, self.largest) = (0, self.largest, 0.0);
        has_grown.then_some(self.since)
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

    /// Any period that the steps do not resolve; the time is that of the first window which has one to grow over.
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
    }
}
