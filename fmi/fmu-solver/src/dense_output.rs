//! Dense output (the states within an internal step), and location of events for the solver.

use super::algorithm::{Step, vectors};
use super::system::System;

impl Step {
    /// Writes the states at `theta` in place of the errors; returns them.
    pub(crate) fn interpolate(&mut self, theta: f64) -> &[f64] {
        let ([a, b, c], start, end) = (&self.dense, &self.x, &self.end);
        for (i, x) in self.error.iter_mut().enumerate() {
            let inner = a[i] + theta * (b[i] + theta * c[i]);
            *x = start[i] + theta * (end[i] - start[i] + (1.0 - theta) * inner);
        }
        &self.error
    }
}

/// Most looks at the extremum of an indicator within an internal step.
const LOOKS: u32 = 3;
/// How near to zero a parabola must come, relative to the values, to be looked at.
const NEAR: f64 = 0.1;
/// Part of an internal step within which an indicator returns after an event, if it does at once.
const AT_ONCE: f64 = 1e-3;

/// The event indicators.
pub(crate) struct Indicators {
    /// At the start of the internal step and at a later point of it, then at the ends and inside
    /// the interval that contains the event.
    pub(crate) values: [Vec<f64>; 5],
    /// Whether each has changed its sign at the event that the step follows.
    pub(crate) fired: Vec<bool>,
}

/// Whether the sign of an indicator changes from `a` to `b`.
fn changes((a, b): (&f64, &f64)) -> bool {
    (*a > 0.0) != (*b > 0.0)
}

impl Indicators {
    pub(crate) fn new(n: usize) -> Self {
        Self {
            values: vectors(n),
            fired: vec![false; n],
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.fired.is_empty()
    }

    /// The internal step has no event: its end is the start of the next one.
    pub(crate) fn pass(&mut self) {
        self.values.swap(0, 1);
        self.fired.fill(false);
    }

    /// Writes the values at `theta` into the vector with this index.
    fn look<S: System>(
        &mut self,
        system: &mut S,
        step: &mut Step,
        theta: f64,
        to: usize,
    ) -> Result<(), S::Error> {
        let s = step.s + theta * step.dt;
        let states = match theta {
            1.0 => &step.end,
            _ => step.interpolate(theta),
        };
        system.indicators(s, states, &mut self.values[to])
    }

    /// Whether the sign of an indicator changes from the start to the later point.
    fn has_event(&self) -> bool {
        self.values[0].iter().zip(&self.values[1]).any(changes)
    }

    /// A θ up to which the sign of an indicator has changed, if there is one, with the values there;
    /// without one they are those of the end. It looks at the end and the middle, and where a
    /// parabola through both and the start has its extremum.
    pub(crate) fn find<S: System>(
        &mut self,
        system: &mut S,
        step: &mut Step,
    ) -> Result<Option<f64>, S::Error> {
        if self.fired.contains(&true) {
            self.return_at_once(system, step)?;
        }
        self.look(system, step, 0.5, 1)?;
        if self.has_event() {
            return Ok(Some(0.5));
        }
        self.values.swap(1, 4);
        self.look(system, step, 1.0, 1)?;
        if self.has_event() {
            return Ok(Some(1.0));
        }
        for i in 0..self.fired.len() {
            // The nearest points around the extremum, and their values.
            let mut at = [0.0, 0.5, 1.0];
            let mut z = [0, 4, 1].map(|k| self.values[k][i]);
            for _ in 0..LOOKS {
                let Some(theta) = turning_point(at, z) else {
                    break;
                };
                self.look(system, step, theta, 2)?;
                self.values.swap(1, 2);
                if self.has_event() {
                    return Ok(Some(theta));
                }
                self.values.swap(1, 2);
                let found = self.values[2][i];
                (at, z) = match theta < at[1] {
                    true if found.abs() < z[1].abs() => {
                        ([at[0], theta, at[1]], [z[0], found, z[1]])
                    }
                    false if found.abs() < z[1].abs() => {
                        ([at[1], theta, at[2]], [z[1], found, z[2]])
                    }
                    _ => break,
                };
            }
        }
        Ok(None)
    }

    /// Moves indicators that return at once after the event to the side from which they came.
    fn return_at_once<S: System>(
        &mut self,
        system: &mut S,
        step: &mut Step,
    ) -> Result<(), S::Error> {
        // A straight line, since a short flight bends within the step.
        let ([a, ..], start, end) = (&step.dense, &step.x, &step.end);
        for (i, x) in step.error.iter_mut().enumerate() {
            *x = start[i] + AT_ONCE * (end[i] - start[i] + a[i]);
        }
        let s = step.s + AT_ONCE * step.dt;
        system.indicators(s, &step.error, &mut self.values[1])?;
        let [start, later, ..] = &mut self.values;
        for (i, fired) in self.fired.iter_mut().enumerate() {
            if std::mem::take(fired) && changes((&start[i], &later[i])) {
                start[i] = later[i];
            }
        }
        Ok(())
    }

    /// The first θ up to `within`, where the indicators are those of the end, at which the sign of
    /// one has changed, as finely as rounded times can be distinguished; the step then has the states
    /// there. It lies just after the change, so that integration from there does not find the same
    /// event again.
    ///
    /// Regula falsi with the Illinois modification, for the indicator that is predicted to cross
    /// zero first; every fourth iteration bisects, for indicators for which it converges slowly.
    pub(crate) fn locate<S: System>(
        &mut self,
        system: &mut S,
        step: &mut Step,
        within: f64,
    ) -> Result<f64, S::Error> {
        let resolution = 4.0 * f64::EPSILON * (step.t.abs() + step.s + step.dt) / step.dt;
        let [start, end, at_low, at_high, middle] = &mut self.values;
        at_low.copy_from_slice(start);
        at_high.copy_from_slice(end);
        let (mut low, mut high, mut was_low, mut count) = (0.0, within, None, 0);
        while high - low > resolution {
            count += 1;
            let least = 0.5 * resolution / (high - low);
            let share = match count % 4 {
                0 => 0.5,
                _ => first_crossing(at_low, at_high).clamp(least, 1.0 - least),
            };
            let theta = low + share * (high - low);
            let s = step.s + theta * step.dt;
            system.indicators(s, step.interpolate(theta), middle)?;
            let is_low = !start.iter().zip(&*middle).any(changes);
            let (place, near, far) = match is_low {
                true => (&mut low, &mut *at_low, &mut *at_high),
                false => (&mut high, &mut *at_high, &mut *at_low),
            };
            *place = theta;
            near.copy_from_slice(middle);
            if was_low.replace(is_low) == Some(is_low) {
                far.iter_mut().for_each(|z| *z *= 0.5);
            }
        }
        step.interpolate(high);
        for (fired, ends) in self.fired.iter_mut().zip(start.iter().zip(&*at_high)) {
            *fired = changes(ends);
        }
        Ok(high)
    }
}

/// Where the parabola through three points on one side of zero crosses it or comes near, strictly
/// between them; None if it does not turn there.
fn turning_point([a, m, b]: [f64; 3], [za, zm, zb]: [f64; 3]) -> Option<f64> {
    let (left, right) = ((zm - za) / (m - a), (zb - zm) / (b - m));
    let bend = (right - left) / (b - a);
    let theta = 0.5 * (a + m - left / bend);
    let least = za + (theta - a) * (left + (theta - m) * bend);
    let near = NEAR * za.abs().max(zm.abs()).max(zb.abs());
    // Positive indicators have a minimum that matters, others a maximum.
    let is_near = match za > 0.0 {
        true => bend > 0.0 && least < near,
        false => bend < 0.0 && least > -near,
    };
    (is_near && a < theta && theta < b && theta != m).then_some(theta)
}

/// The first zero of the straight lines from `low` to `high`, from 0 to 1.
fn first_crossing(low: &[f64], high: &[f64]) -> f64 {
    let lines = low.iter().zip(high).filter(|ends| changes(*ends));
    lines.map(|(a, b)| a / (a - b)).fold(1.0, f64::min)
}
