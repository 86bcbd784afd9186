//! Tip tracking error of a run: root mean square and maximum of the controller's output
//! `tip_error_norm`.

/// Root mean square and maximum of a distance, both m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distance {
    sum_of_squares: f64,
    count: u32,
    /// Largest distance, m.
    pub max: f64,
}

impl Distance {
    /// Add a sample, m.
    pub fn add(&mut self, distance: f64) {
        self.sum_of_squares += distance * distance;
        self.count += 1;
        self.max = self.max.max(distance);
    }

    /// Root mean square over the samples, m; 0 without any.
    pub fn rms(&self) -> f64 {
        if self.count == 0 {
            0.0
        } else {
            (self.sum_of_squares / f64::from(self.count)).sqrt()
        }
    }
}

impl std::fmt::Display for Distance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "RMSE {:.4} mm, max {:.4} mm",
            1e3 * self.rms(),
            1e3 * self.max
        )
    }
}

/// Tip error over the whole run and over the motion alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipError {
    /// From here on the reference moves, s.
    pub motion_start: f64,
    /// Samples from `motion_start` on: what the paper calls tracking.
    pub motion: Distance,
    /// All samples, with the time in which the machine settles.
    pub whole: Distance,
}

impl TipError {
    /// No samples yet.
    pub fn new(motion_start: f64) -> Self {
        Self {
            motion_start,
            motion: Distance::default(),
            whole: Distance::default(),
        }
    }

    /// As text for people, of two lines.
    pub fn text(&self) -> String {
        format!(
            "tip error, motion from {} s on: {}\ntip error, whole run:           {}\n",
            self.motion_start, self.motion, self.whole
        )
    }

    /// Add the error at time `t`.
    pub fn add(&mut self, t: f64, distance: f64) {
        self.whole.add(distance);
        if t >= self.motion_start {
            self.motion.add(distance);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_before_the_motion_counts_only_for_the_whole() {
        let mut e = TipError::new(2.0);
        for (t, d) in [(1.0, 5.0), (2.0, 3.0), (3.0, 4.0)] {
            e.add(t, d);
        }
        assert_eq!((e.motion.max, e.whole.max), (4.0, 5.0));
        assert!(
            (e.motion.rms() - 12.5f64.sqrt()).abs() < 1e-15,
            "(9 + 16)/2"
        );
        assert!((e.whole.rms() - (50.0f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(TipError::new(0.0).whole.rms(), 0.0);
    }
}
