//! [`Ramp`]: inputs that change at constant rates within a communication step, since the master gave
//! their derivatives, or since another input is their derivative, as the rod velocity of an actuator
//! is that of the rod position. The latter move on until they are set again.

use super::plan::FollowedInputs;
use crate::batch::Batch;

/// Inputs of one instance on lines.
#[derive(Debug)]
pub(super) struct Ramp {
    pub batch: Batch,
    /// Inputs whose values are the rates, by index; none if the master gives the rates.
    pub sources: Vec<usize>,
    /// Time of the values, s.
    pub start: f64,
    /// Values at the start, and their derivatives, per s.
    pub values: Vec<f64>,
    pub rates: Vec<f64>,
    /// Workspace.
    pub now: Vec<f64>,
}

impl Ramp {
    pub fn new(batch: &Batch, sources: &[usize], [values, rates]: [Vec<f64>; 2]) -> Self {
        Self {
            batch: batch.clone(),
            sources: sources.to_vec(),
            start: 0.0,
            now: values.clone(),
            values,
            rates,
        }
    }

    /// The inputs that follow others.
    pub fn of_plan(plan: &FollowedInputs) -> Self {
        Self::new(&plan.batch, &plan.sources, plan.start.clone())
    }

    /// Computes the values at `t`, s.
    pub fn at(&mut self, t: f64) {
        let lines = self.values.iter().zip(&self.rates);
        for (now, (value, rate)) in self.now.iter_mut().zip(lines) {
            *now = value + rate * (t - self.start);
        }
    }

    /// Inputs that follow others go on from `t`, s, at any rates.
    pub fn move_to(&mut self, t: f64) {
        if !self.sources.is_empty() && t != self.start {
            self.at(t);
            self.values.copy_from_slice(&self.now);
            self.start = t;
        }
    }

    /// Takes a new value of a variable; returns whether that changes an input that was moving.
    pub fn take(&mut self, variable: usize, new: f64) -> bool {
        if let Some(place) = self.sources.iter().position(|v| *v == variable) {
            self.rates[place] = new;
        }
        let mut places = self.batch.variables.iter();
        let Some(place) = places.position(|v| *v == variable) else {
            return false;
        };
        let was_moving = self.rates[place] != 0.0;
        self.values[place] = new;
        if self.sources.is_empty() {
            self.rates[place] = 0.0;
        }
        was_moving
    }
}
