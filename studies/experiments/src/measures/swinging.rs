//! Whether a rod swings: the one criterion of runs, `sizing`, `margins` and ended runs. The live page
//! has it in `monitor.js`.
//!
//! What counts is a rod's force less its moving mean, as a root mean square over each second. A rod
//! swings if this is above 1 % of the rated force for two seconds in a row while the reference
//! rests, and has rested for two seconds: a path's own accelerations would count, too.

use std::f64::consts::SQRT_2;

use anyhow::Result;
use cosim::{Port, System, Verdict};

/// Share of the rated force above which a rod at rest swings; the shipped machines have 0.2 %.
pub const SWINGS: f64 = 0.01;
/// Time constant of the moving mean, s: oscillations above 0.6 Hz remain.
const MEAN: f64 = 0.25;
/// Length of a window, s.
const WINDOW: f64 = 1.0;
/// Time for which the reference must have rested before a window counts, s.
const SETTLES: f64 = 2.0;
/// A reference that moves by less rests, in m and in components of a quaternion.
const RESTS: f64 = 1e-4;

/// The force of a rod divided by its rated force.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rod {
    /// Rated force, N.
    rated: f64,
    /// Present force.
    pub part: f64,
    /// Its moving mean.
    pub mean: f64,
    /// Sum of squares of the rest times time in this window, s, and changes of its sign.
    squares: f64,
    turns: u32,
    /// Root mean square of the rest in the last whole window.
    pub rms: f64,
    /// Windows in a row in which it swung.
    windows: u32,
    /// Since when it swings, s; its largest root mean square, and the frequency then, Hz.
    found: Option<[f64; 3]>,
}

/// Watches the rods while the machine runs.
#[derive(Clone, Debug, Default)]
pub struct SwingWatch {
    /// The rods.
    pub rods: Vec<Rod>,
    reference: Vec<f64>,
    /// Times of the last sample, of the start of the window, and since when the reference rests, s.
    times: Option<[f64; 3]>,
    /// The last whole window was at rest.
    is_settled: bool,
}

/// The variables that are the tip's reference; none if the system does not have them.
pub fn reference_ports(system: &System) -> Vec<Port> {
    let all = || -> Result<Vec<Port>> {
        let controller = system.port("desired.position[1]")?.component;
        let position = system.elements(controller, "desired.position", 3)?;
        let orientation = system.elements(controller, "desired.orientation", 4)?;
        Ok([position, orientation].concat())
    };
    all().unwrap_or_default()
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
        let [last, start, rests] = self.times.get_or_insert([t; 3]);
        let dt = t - std::mem::replace(last, t);
        let moves = |(a, b): (&f64, &f64)| (a - b).abs() > RESTS;
        if self.reference.is_empty() || reference.iter().zip(&self.reference).any(moves) {
            self.reference.clear();
            self.reference.extend_from_slice(reference);
            *rests = t;
        }
        for (rod, force) in self.rods.iter_mut().zip(forces) {
            rod.add(force / rod.rated, dt);
        }
        // Half a sample less: times are sums of steps.
        if dt > 0.0 && t - *start > WINDOW - 0.5 * dt {
            self.is_settled = *start - *rests > SETTLES - 0.5 * dt;
            let rods = self.rods.iter_mut();
            rods.for_each(|rod| rod.close([*start, t], self.is_settled));
            *start = t;
        }
    }

    /// The first rod that swung in the last whole second, counted from 1.
    pub fn swings_now(&self) -> Option<usize> {
        let swings = |rod: &Rod| self.is_settled && rod.rms > SWINGS;
        self.rods.iter().position(swings).map(|k| k + 1)
    }

    /// A bad finding for each rod that swung; the rods have these names.
    pub fn judge<'a>(&self, names: impl Iterator<Item = &'a String>, verdict: &mut Verdict) {
        for (rod, name) in self.rods.iter().zip(names) {
            let Some([since, share, hertz]) = rod.found else {
                continue;
            };
            let (size, share) = (1e-3 * SQRT_2 * share * rod.rated, 100.0 * share);
            verdict.object(format!(
                "{name} swings: ±{size:.1} kN at {hertz:.1} Hz while the reference rests, root mean square {share:.1} % of the rated force, \
                 more than {} %, first at t = {since:.3} s",
                100.0 * SWINGS
            ));
        }
    }
}

impl Rod {
    /// Adds the force over the rated force, `dt` s after the last one.
    fn add(&mut self, part: f64, dt: f64) {
        if dt == 0.0 {
            (self.part, self.mean) = (part, part);
        }
        let before = self.part - self.mean;
        self.part = part;
        self.mean += (dt / MEAN).min(1.0) * (part - self.mean);
        let rest = part - self.mean;
        self.turns += u32::from(rest * before < 0.0);
        self.squares += rest * rest * dt;
    }

    /// Closes a window from `start` to `end`, s.
    fn close(&mut self, [start, end]: [f64; 2], is_settled: bool) {
        self.rms = (self.squares / (end - start)).sqrt();
        let hertz = 0.5 * f64::from(self.turns) / (end - start);
        (self.squares, self.turns) = (0.0, 0);
        let swings = is_settled && self.rms > SWINGS;
        self.windows = if swings { self.windows + 1 } else { 0 };
        let [since, worst, _] = self.found.unwrap_or([start - WINDOW, 0.0, 0.0]);
        if self.windows > 1 && self.rms > worst {
            self.found = Some([since, self.rms, hertz]);
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
        watch.judge(["rod 1".into()].iter(), &mut verdict);
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
