//! Learns on a path of equal laps, for `controller`: iterative learning control. What the tip's error
//! repeats from lap to lap is met in the next one by a shift z of the position that the law follows.
//!
//! Over a lap z is a closed cubic spline with N knots, a time Δ apart:
//! ```text
//! z(t) = Σ_j c_j B(t/Δ − j)      e_j = ∫ B(t/Δ − j) e(t + δ) dt/Δ      c_j ← c_j + (((Q − 1) c)_j + γ e_j)/k
//! ```
//! k is 1 for the first two laps, then 2 and 3, and 4 for all others: what does not repeat is averaged.
//! B has no phase, as the smoothing `Q = [1 4 1]/6` has none: both act on errors before and after a
//! knot. A knot is renewed when the lap is past it, so that z stays smooth. The memory has the same
//! size from the start to the end. Convergence: `docs/machine/laps.md`.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use tip_path::Laps;

/// Largest time between knots that are not [`MOST`], s: what is faster than 2 Hz is not learnt.
const SPACING: f64 = 0.16;
/// Most and fewest knots of a lap.
const MOST: usize = 2000;
const FEWEST: usize = 8;
/// δ, by which the machine answers later, s.
const LEAD: f64 = 0.06;
/// Largest k.
const AVERAGED: usize = 4;
/// Largest shift along each axis, m.
const LARGEST: f64 = 0.02;
/// Root mean square of a lap's error over that of the first one from which on nothing is learnt any more:
/// the error does not repeat, or load or machine have changed. Laps that nothing changes were up to 1.14
/// times as bad as the first, but for one machine (`docs/machine/laps.md`).
const WORSE: f64 = 1.25;
/// Time in which what was learnt fades then, s.
const FADES: f64 = 1.0;

/// A knot j of the spline.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Knot {
    /// c_j, m.
    shift: Vector3<f64>,
    /// The integral e_j so far, m, and that of its weight.
    error: Vector3<f64>,
    weight: f64,
}

/// What was learnt, and what the present lap adds.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct LapMemory {
    laps: Laps,
    knots: Vec<Knot>,
    /// Knots renewed since the first lap began.
    renewed: usize,
    /// Shift of the knot renewed last before it was renewed, m.
    before: Vector3<f64>,
    /// Laps begun, with the square of the present one's error, m²·s, and the time that counts, s.
    begun: usize,
    square: f64,
    time: f64,
    /// Mean square of the first lap's error, m²; None before its end.
    first: Option<f64>,
    /// Time for which what was learnt has faded, s, up to [`FADES`].
    fades: Option<f64>,
}

/// Values of the four splines that act in the part `f` of an interval, with their first and second
/// derivatives by it: those of the knots before it, at its ends, and behind it.
fn splines(f: f64) -> [[f64; 4]; 3] {
    let g = 1.0 - f;
    [
        [
            g * g * g / 6.0,
            (3.0 * f * f * f - 6.0 * f * f + 4.0) / 6.0,
            (3.0 * g * g * g - 6.0 * g * g + 4.0) / 6.0,
            f * f * f / 6.0,
        ],
        [
            -0.5 * g * g,
            1.5 * f * f - 2.0 * f,
            2.0 * g - 1.5 * g * g,
            0.5 * f * f,
        ],
        [g, 3.0 * f - 2.0, 3.0 * g - 2.0, f],
    ]
}

impl LapMemory {
    /// For these laps; None if they are too short to learn from.
    pub(crate) fn new(laps: Laps) -> Option<Self> {
        let count = libm::ceil(laps.period / SPACING).min(MOST as f64) as usize;
        (count >= FEWEST).then(|| Self {
            laps,
            knots: vec![Knot::default(); count],
            renewed: 0,
            before: Vector3::zeros(),
            begun: 0,
            square: 0.0,
            time: 0.0,
            first: None,
            fades: None,
        })
    }

    /// Time Δ between knots, s.
    fn spacing(&self) -> f64 {
        self.laps.period / self.knots.len() as f64
    }

    /// Interval of the spline in which the path is `t` s after its start, counted from the first
    /// lap's begin, and the part of it that is past.
    fn interval(&self, t: f64) -> Option<(usize, f64)> {
        let past = (t - self.laps.begins) / self.spacing();
        (past >= 0.0).then(|| (past as usize, past - libm::floor(past)))
    }

    /// Places of the four knots that act in an interval.
    fn places(&self, interval: usize) -> [usize; 4] {
        let count = self.knots.len();
        [count - 1, 0, 1, 2].map(|more| (interval + more) % count)
    }

    /// z, m, with its first and second derivatives, `t` s after the path's start.
    pub(crate) fn shift(&self, t: f64) -> [Vector3<f64>; 3] {
        let end = self.laps.end();
        let Some((interval, part)) = self.interval(t.min(end)) else {
            return Default::default();
        };
        let (places, h) = (self.places(interval), self.spacing());
        let sum = |weights: [f64; 4]| -> Vector3<f64> {
            let terms = places.iter().zip(weights);
            terms.map(|(j, weight)| self.knots[*j].shift * weight).sum()
        };
        let [z, first, second] = splines(part).map(sum);
        let [z, first, second] = match t < end {
            true => [z, first / h, second / (h * h)],
            false => [z, Vector3::zeros(), Vector3::zeros()],
        };
        let p = self.fades.unwrap_or(0.0) / FADES;
        let share = 1.0 - p * p * (3.0 - 2.0 * p);
        let rate = -6.0 * p * (1.0 - p) / FADES;
        let twice = match self.fades {
            Some(time) if time < FADES => (12.0 * p - 6.0) / (FADES * FADES),
            _ => 0.0,
        };
        [
            z * share,
            first * share + z * rate,
            second * share + first * (2.0 * rate) + z * twice,
        ]
    }

    /// Adds the tip's error `error`, m, `t` s after the path's start, for `h` s, at the gain γ. What
    /// `counts` not, as at a limit of a drive, is not learnt.
    pub(crate) fn add(&mut self, gain: f64, counts: bool, error: &Vector3<f64>, t: f64, h: f64) {
        if let Some(time) = &mut self.fades {
            *time = (*time + h).min(FADES);
        }
        let lap = self.laps.number(t);
        if lap != self.begun {
            self.end_lap();
            self.begun = lap;
        }
        let Some((interval, part)) = self.interval(t - LEAD).filter(|_| lap > 0) else {
            return;
        };
        if counts && self.fades.is_none() {
            let places = self.places(interval);
            for (j, weight) in places.into_iter().zip(splines(part)[0]) {
                let weight = weight * h / self.spacing();
                self.knots[j].error += error * weight;
                self.knots[j].weight += weight;
            }
            self.square += h * error.norm_squared();
            self.time += h;
        }
        while self.renewed + 2 <= interval {
            let count = self.knots.len();
            let k = (self.renewed / count).clamp(1, AVERAGED);
            self.renew(self.renewed % count, gain, 1.0 / k as f64);
            self.renewed += 1;
        }
    }

    /// Renews a `share` of knot `j`, if most of its error is known.
    fn renew(&mut self, j: usize, gain: f64, share: f64) {
        let next = self.knots[(j + 1) % self.knots.len()].shift;
        let knot = &mut self.knots[j];
        let old = knot.shift;
        if knot.weight > 0.5 && self.fades.is_none() {
            let smoother = (self.before - old * 2.0 + next) / 6.0;
            let shift = old + (smoother + knot.error * (gain / knot.weight)) * share;
            knot.shift = shift.map(|part| part.clamp(-LARGEST, LARGEST));
        }
        (knot.error, knot.weight) = (Vector3::zeros(), 0.0);
        self.before = old;
    }

    /// Compares the lap that ends with the first one, if most of it counts.
    fn end_lap(&mut self) {
        if self.begun > 0 && self.time > 0.5 * self.laps.period {
            let mean = self.square / self.time;
            let first = *self.first.get_or_insert(mean);
            if mean > WORSE * WORSE * first {
                self.fades = self.fades.or(Some(0.0));
            }
        }
        (self.square, self.time) = (0.0, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const H: f64 = 1e-3;
    const PERIOD: f64 = 4.0;

    fn memory() -> LapMemory {
        LapMemory::new(Laps {
            begins: 1.0,
            period: PERIOD,
            count: 20,
        })
        .expect("long enough")
    }

    /// Root mean square of the error in each of `count` laps, m: of a machine that follows the shift with a
    /// lag of 60 ms, while `push` moves it by so much, m, at the time after the first lap's begin.
    fn errors(memory: &mut LapMemory, count: usize, push: impl Fn(f64) -> f64) -> Vec<f64> {
        let (mut lag, mut squares) = (0.0, vec![0.0; count]);
        let steps = (PERIOD / H) as usize;
        for k in 0..1000 + count * steps {
            let t = H * k as f64;
            let error = push(t - 1.0) - lag;
            memory.add(0.8, true, &Vector3::new(error, 0.0, 0.0), t, H);
            lag += (memory.shift(t)[0].x - lag) * H / 0.06;
            if k >= 1000 {
                squares[(k - 1000) / steps] += error * error / steps as f64;
            }
        }
        squares.into_iter().map(f64::sqrt).collect()
    }

    /// Closed form: the splines of all knots add up to 1, and the derivatives are those of differences,
    /// exact for a cubic but for h² of its third derivative.
    #[test]
    fn the_shift_has_its_derivatives() {
        for part in [0.0, 0.3, 0.99] {
            let [values, first, second] = splines(part).map(|of| of.iter().sum::<f64>());
            assert!((values - 1.0).abs() < 1e-15 && first.abs() < 1e-15 && second.abs() < 1e-15);
        }
        let mut learnt = memory();
        errors(&mut learnt, 3, |t| 1e-3 * (TAU * t / PERIOD).sin());
        for fades in [None, Some(0.4)] {
            learnt.fades = fades;
            let t = 2.345;
            let at = |t: f64| {
                let mut now = learnt.clone();
                now.fades = fades.map(|time| time + t - 2.345);
                now.shift(t)
            };
            let [before, now, after] = [t - H, t, t + H].map(at);
            let [first, second] = [1, 2].map(|k| (after[k - 1] - before[k - 1]) / (2.0 * H));
            assert!(
                (first - now[1]).norm() < 1e-5 * now[1].norm().max(1e-3),
                "{first} {}",
                now[1]
            );
            assert!(
                (second - now[2]).norm() < 1e-2 * now[2].norm(),
                "{second} {}",
                now[2]
            );
        }
    }

    /// Closed form: of 0.25 and 0.75 Hz (1 − Q)/(1 − Q + γ S) are left, 1.3 and 12 %, together 8.5 %; the sixth lap
    /// is there but for a quarter. A push of 8 Hz, which the machine hardly follows, is left as it is.
    #[test]
    fn what_repeats_is_learnt() {
        let repeats = |t: f64| 1e-3 * ((TAU * t / PERIOD).sin() + (3.0 * TAU * t / PERIOD).cos());
        let laps = errors(&mut memory(), 6, repeats);
        assert!((0.08..0.115).contains(&(laps[5] / laps[0])), "{laps:?}");
        let rings = errors(&mut memory(), 6, |t| 1e-3 * (32.0 * TAU * t / PERIOD).sin());
        assert!((rings[5] / rings[0] - 1.0).abs() < 0.05, "{rings:?}");
    }

    /// A push that is turned round from lap to lap is the worst that does not repeat: the second lap has
    /// 1 + γ = 1.8 times its error, less what the lag smooths, and nothing is learnt any more.
    #[test]
    fn what_does_not_repeat_ends_it() {
        let laps = errors(&mut memory(), 9, |t| 1e-3 * (1.5 * TAU * t / PERIOD).sin());
        let over = |k: usize| laps[k] / laps[0];
        assert!((1.7..1.8).contains(&over(1)) && over(2) < 1.2, "{laps:?}");
        assert!((3..9).all(|k| (over(k) - 1.0).abs() < 0.01), "{laps:?}");
    }

    /// A second lap that a wave of 8 Hz, of which nothing is learnt, makes 1.15 times as bad as the first does not end it; made 1.4
    /// times as bad, it does.
    #[test]
    fn a_lap_that_is_worse_by_chance_does_not_end_it() {
        for (chance, goes_on) in [(1.15, true), (1.4, false)] {
            let wave = |waves: f64, t: f64| 1e-3 * (waves * TAU * t / PERIOD).sin();
            let push = |t: f64| match (PERIOD..2.0 * PERIOD).contains(&t) {
                true => wave(1.0, t) + chance * wave(32.0, t),
                false => wave(1.0, t),
            };
            let laps = errors(&mut memory(), 6, push);
            let over = |k: usize| laps[k] / laps[0];
            assert!((over(1) - chance).abs() < 0.05, "{laps:?}");
            assert_eq!(over(5) < 0.1, goes_on, "{laps:?}");
        }
    }

    /// After six laps the push turns round: the lap is nearly twice as bad as the first, what was learnt fades
    /// without a jump of more than its own rate, and is gone.
    #[test]
    fn a_change_ends_what_was_learnt() {
        let mut memory = memory();
        let turns = |t: f64| {
            let wave = 1e-3 * (TAU * t / PERIOD).sin();
            if t < 6.0 * PERIOD { wave } else { -wave }
        };
        let laps = errors(&mut memory, 9, turns);
        assert!(
            laps[5] < 0.1 * laps[0] && laps[6] > 1.5 * laps[0],
            "{laps:?}"
        );
        assert!((laps[8] / laps[0] - 1.0).abs() < 0.01, "{laps:?}");
        assert_eq!(memory.shift(36.5), [Vector3::zeros(); 3]);
    }

    /// Shifts are bounded, at a limit nothing is learnt, and the memory does not grow.
    #[test]
    fn what_is_learnt_has_bounds() {
        let mut memory = memory();
        let size = memory.knots.capacity();
        errors(&mut memory, 12, |t| 0.1 * (TAU * t / PERIOD).sin());
        let largest = memory
            .knots
            .iter()
            .map(|knot| knot.shift.amax())
            .fold(0.0, f64::max);
        assert_eq!((largest, memory.knots.capacity()), (LARGEST, size));
        let mut limited = self::memory();
        for k in 0..12_000 {
            limited.add(
                0.8,
                false,
                &Vector3::new(1e-3, 0.0, 0.0),
                H * f64::from(k),
                H,
            );
        }
        assert_eq!(limited.shift(11.0), [Vector3::zeros(); 3]);
        let short = Laps {
            begins: 0.0,
            period: 0.5,
            count: 9,
        };
        assert!(LapMemory::new(short).is_none());
    }
}
