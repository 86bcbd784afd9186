//! Whether a rod swings: the one criterion of runs, margins, sizing and ended runs. The live page
//! has it in `monitor.js`.
//!
//! What counts is a rod's force less its moving mean, as a root mean square over each second. A rod
//! swings where this is above 1 % of the rated force for two seconds in a row while the reference
//! rests: a path's own accelerations count in it, too, and end two seconds after the path.

use std::f64::consts::SQRT_2;

use anyhow::Result;
use cosim::{Port, System, Verdict};

/// Share of the rated force above which a rod at rest swings: 1 kN of amplitude on the reference
/// machine. The shipped machines have 0.2 % at rest.
pub const SWINGS: f64 = 0.01;
/// Time constant of the moving mean, s: oscillations above 0.6 Hz remain.
const MEAN: f64 = 0.25;
/// Length of the windows of the mean square, s, and how many in a row must exceed the limit.
const WINDOW: f64 = 1.0;
const WINDOWS: u32 = 2;
/// Time for which the reference must have rested before a window counts, s.
const SETTLES: f64 = 2.0;
/// A reference that moves by less rests, in m and in components of a quaternion.
const RESTS: f64 = 1e-4;
/// Arrays of the controller that are the reference of the tip.
const REFERENCE: [(&str, usize); 2] = [("desired.position", 3), ("desired.orientation", 4)];

/// The force of a rod divided by its rated force.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rod {
    /// Rated force, N.
    rated: f64,
    /// Moving mean.
    pub mean: f64,
    /// The rest of the last sample, and how often its sign changed in this window.
    rest: f64,
    turns: u32,
    /// Sum of squares times time in this window, s.
    squares: f64,
    /// Root mean square of the rest in the last whole window.
    pub rms: f64,
    /// Windows in a row in which the rod at rest swung.
    windows: u32,
    /// When it began to swing, s.
    since: Option<f64>,
    /// Where it swung most: the root mean square, and the frequency, Hz.
    worst: (f64, f64),
}

/// Watches the rods while the machine runs.
#[derive(Clone, Debug, Default)]
pub struct SwingWatch {
    /// The rods.
    pub rods: Vec<Rod>,
    reference: Vec<f64>,
    /// Time of the last sample, start of the window, and since when the reference rests, s.
    t: f64,
    start: f64,
    rests: f64,
    /// The last whole window was at rest.
    is_settled: bool,
}

/// The variables whose values are the reference of the tip, as far as the system has them.
pub fn reference_ports(system: &System) -> Vec<Port> {
    let controller = system.port("desired.position[1]").map(|p| p.component);
    let arrays = controller
        .into_iter()
        .flat_map(|k| REFERENCE.map(|array| (k, array)));
    let arrays = arrays.map(|(k, (name, count))| system.elements(k, name, count));
    arrays.flatten().flatten().collect()
}

impl SwingWatch {
    /// For rods with these rated forces, N.
    pub fn new(rated: impl IntoIterator<Item = f64>) -> Self {
        let rod = |rated| Rod {
            rated,
            ..Rod::default()
        };
        Self {
            rods: rated.into_iter().map(rod).collect(),
            ..Self::default()
        }
    }

    /// Adds the rods' forces, N, and the reference at the time `t`, s.
    pub fn add(&mut self, t: f64, forces: impl Iterator<Item = f64>, reference: &[f64]) {
        let is_first = self.reference.len() != reference.len() || self.t > t;
        let dt = if is_first { 0.0 } else { t - self.t };
        if is_first {
            (self.start, self.rests) = (t, t);
            self.reference = reference.to_vec();
        }
        self.t = t;
        let moves = |(a, b): (&f64, &f64)| (a - b).abs() > RESTS;
        if reference.iter().zip(&self.reference).any(moves) {
            self.reference.copy_from_slice(reference);
            self.rests = t;
        }
        for (rod, force) in self.rods.iter_mut().zip(forces) {
            rod.add(force / rod.rated, dt);
        }
        // Half a sample less: times are sums of steps.
        let window = t - self.start;
        if window > WINDOW - 0.5 * dt && dt > 0.0 {
            self.is_settled = self.start - self.rests > SETTLES - 0.5 * dt;
            for rod in &mut self.rods {
                rod.close(self.start, window, self.is_settled);
            }
            self.start = t;
        }
    }

    /// The first rod that swung at rest in the last whole second, counted from 1.
    pub fn swings_now(&self) -> Option<usize> {
        let swings = |rod: &Rod| self.is_settled && rod.rms > SWINGS;
        self.rods.iter().position(swings).map(|k| k + 1)
    }

    /// A bad finding for each rod that swung; `name` says which one it is.
    pub fn judge(&self, name: impl Fn(usize) -> String, verdict: &mut Verdict) {
        for (k, rod) in self.rods.iter().enumerate() {
            let (Some(since), (share, hertz)) = (rod.since, rod.worst) else {
                continue;
            };
            verdict.object(format!(
                "{} swings: ±{:.1} kN at {hertz:.1} Hz while the reference rests, root mean square {:.1} % of the rated force, more than {} %, \
                 first at t = {since:.3} s",
                name(k),
                1e-3 * SQRT_2 * share * rod.rated,
                100.0 * share,
                100.0 * SWINGS
            ));
        }
    }
}

impl Rod {
    /// Adds the force over the rated force, `dt` s after the last one.
    fn add(&mut self, part: f64, dt: f64) {
        if dt == 0.0 {
            self.mean = part;
        }
        self.mean += (dt / MEAN).min(1.0) * (part - self.mean);
        let rest = part - self.mean;
        self.turns += u32::from(rest * self.rest < 0.0);
        self.rest = rest;
        self.squares += rest * rest * dt;
    }

    /// Closes a window that began at `start` and lasted `window`, both s.
    fn close(&mut self, start: f64, window: f64, is_settled: bool) {
        self.rms = (self.squares / window).sqrt();
        let hertz = 0.5 * f64::from(self.turns) / window;
        (self.squares, self.turns) = (0.0, 0);
        self.windows = match is_settled && self.rms > SWINGS {
            true => self.windows + 1,
            false => 0,
        };
        if self.windows >= WINDOWS {
            self.since = self.since.or(Some(start - WINDOW * f64::from(WINDOWS - 1)));
            if self.rms > self.worst.0 {
                self.worst = (self.rms, hertz);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a rod of 70 kN is found to do at rest from 0 s on, while the reference moves until
    /// `moves`, s.
    fn judged(moves: f64, force: impl Fn(f64) -> f64) -> (SwingWatch, String) {
        let mut watch = SwingWatch::new([70e3]);
        for t in (0..10_000).map(|k| 1e-3 * f64::from(k)) {
            watch.add(t, [force(t)].into_iter(), &[0.1 * t.min(moves)]);
        }
        let mut verdict = Verdict::default();
        watch.judge(|k| format!("rod {}", k + 1), &mut verdict);
        (watch, verdict.to_string())
    }

    /// A force that swings around a load has its amplitude over √2 as its root mean square, less
    /// what the mean takes: of 5.6 Hz and 0.25 s 0.6 %; an allowance of 1 % covers the part of a
    /// period in each window.
    #[test]
    fn a_swing_is_told_from_a_load_by_its_size_and_frequency() {
        let w = std::f64::consts::TAU * 5.6;
        let swing = |size: f64| move |t: f64| 40e3 + size * (w * t).sin();
        let (watch, text) = judged(0.0, swing(1.05e3));
        let expected = 1.05e3 / 70e3 / SQRT_2;
        assert!(
            (watch.rods[0].rms / expected - 1.0).abs() < 0.02,
            "{watch:?}"
        );
        assert!(
            text.contains("rod 1 swings: ±1.0 kN at 5.5 Hz while the reference rests"),
            "{text}"
        );
        assert!(text.contains("first at t = 2.0") && watch.swings_now() == Some(1));
        assert_eq!(judged(0.0, swing(0.95e3)).1, "");
        assert_eq!(judged(0.0, |t| 40e3 + 16e3 * (0.1 * t).sin()).1, "");
    }

    /// Neither a path's accelerations count, nor what they leave for two seconds, nor a push.
    #[test]
    fn only_what_lasts_at_rest_counts() {
        let w = std::f64::consts::TAU * 5.6;
        let while_moving = |t: f64| if t < 7.0 { 4e3 * (w * t).sin() } else { 0.0 };
        assert_eq!(judged(5.0, while_moving).1, "");
        assert!(judged(2.0, while_moving).1.contains("first at t = 4."));
        let pushed = |t: f64| 9e3 * (-3.0 * (t - 6.0).max(0.0)).exp() * (w * t).sin();
        let (watch, text) = judged(0.0, |t| if t < 6.0 { 0.0 } else { pushed(t) });
        assert_eq!((watch.swings_now(), text.as_str()), (None, ""));
    }
}
