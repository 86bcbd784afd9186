//! Where the rod is between two sets of the input `x`.
//!
//! The rod moves on with its velocity, in a step and from one step to the next, as long as `x` keeps its value: holding it while
//! x_dot ≠ 0 would cost K_b·x_dot·h of force, some 20 kN at 1 ms. So after a step the outputs belong to the new time, before the
//! importer has set anything.

use super::{EmlaFmu, table};
use emla::Input;
use fmu_export::{InputPolynomial, ModelError};
use serde::{Deserialize, Serialize};
use std::cell::Cell;

/// Rod position.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Rod {
    /// The input `x` as it was last used, m.
    set: f64,
    /// Where the rod is while the input stays so, m.
    x: f64,
}

impl Rod {
    /// A rod where the input says, m.
    pub(crate) fn at(x: f64) -> Self {
        Self { set: x, x }
    }

    /// The inputs with the rod where it is.
    pub(crate) fn input(&self, u: &Input) -> Input {
        let x = if u.x == self.set { self.x } else { u.x };
        Input { x, ..*u }
    }

    /// The inputs over a step that begins here.
    pub(crate) fn course<'a>(&self, u: &'a InputPolynomial<Input>) -> Course<'a> {
        let derivatives = [1, 2, 3].map(|k| u.derivative(k));
        Course {
            u,
            start: self.input(u.value()).x,
            x_dot: [0, 1, 2, 3].map(|k| u.derivative(k).x_dot),
            is_given: derivatives.iter().any(|d| d.x != 0.0),
            farthest: Cell::new(0.0),
        }
    }
}

/// Inputs over a step.
pub(crate) struct Course<'a> {
    u: &'a InputPolynomial<Input>,
    /// Rod position at the start of the step, m.
    start: f64,
    /// Rod velocity at the start of the step and its derivatives.
    x_dot: [f64; 4],
    /// Whether the importer has given derivatives of `x` itself.
    is_given: bool,
    /// Largest magnitude of the rod position so far, m.
    farthest: Cell<f64>,
}

impl Course<'_> {
    /// The inputs `s` seconds into the step.
    pub(crate) fn at(&self, s: f64) -> Input {
        let u = self.u.at::<EmlaFmu>(s);
        let x = self.position(&u, s);
        self.farthest.set(self.farthest.get().max(x.abs()));
        Input { x, ..u }
    }

    /// x(s) from its own derivatives if the importer has given some, else ∫ x_dot.
    fn position(&self, u: &Input, s: f64) -> f64 {
        if self.is_given {
            return self.start + (u.x - self.u.value().x);
        }
        let [v, a, jerk, snap] = self.x_dot;
        self.start + s * (v + s / 2.0 * (a + s / 3.0 * (jerk + s / 4.0 * snap)))
    }

    /// The rod after a step of `h` s, if it has stayed within the bounds of `x`.
    pub(crate) fn end(&self, h: f64) -> Result<Rod, ModelError> {
        let x = self.at(h).x;
        let farthest = self.farthest.get();
        if farthest > table::X_LARGEST {
            let limit = table::X_LARGEST;
            return Err(ModelError::new(format!(
                "`x_dot` moves the rod to |x| = {farthest} m within the step; it must stay within {limit} m"
            )));
        }
        let set = self.u.at::<EmlaFmu>(h).x;
        Ok(Rod { set, x })
    }
}
