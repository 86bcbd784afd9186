//! Dense output (the states within an internal step), and location of events for the solver.

use super::algorithm::Step;
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

/// Event indicators at the start and the end of the internal step, then at the ends and inside the
/// interval that contains the event.
pub(crate) struct Indicators(pub(crate) [Vec<f64>; 5]);

/// Whether the sign of an indicator changes from `a` to `b`.
fn changes((a, b): (&f64, &f64)) -> bool {
    (*a > 0.0) != (*b > 0.0)
}

impl Indicators {
    pub(crate) fn is_empty(&self) -> bool {
        self.0[0].is_empty()
    }

    /// Whether the sign of an indicator changes within the internal step.
    pub(crate) fn has_event(&self) -> bool {
        self.0[0].iter().zip(&self.0[1]).any(changes)
    }

    /// The first θ up to `within`, where the indicators are those of the end, at which the sign of
    /// one has changed, to within `resolution`; the step then has the states there. It lies just after the change, so that
    /// integration from there does not find the same event again.
    ///
    /// Regula falsi with the Illinois modification, for the indicator that is predicted to cross
    /// zero first; every fourth iteration bisects, for indicators for which it converges slowly.
    pub(crate) fn locate<S: System>(
        &mut self,
        system: &mut S,
        step: &mut Step,
        [within, resolution]: [f64; 2],
    ) -> Result<f64, S::Error> {
        let [start, end, at_low, at_high, middle] = &mut self.0;
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
        Ok(high)
    }
}

/// The first zero of the straight lines from `low` to `high`, from 0 to 1.
fn first_crossing(low: &[f64], high: &[f64]) -> f64 {
    let lines = low.iter().zip(high).filter(|ends| changes(*ends));
    lines.map(|(a, b)| a / (a - b)).fold(1.0, f64::min)
}
