//! [`Integrals`]: integrals of outputs over a communication step, whose means the power bonds of the
//! master exchange. An FMU for Model Exchange cannot know them, since it knows no communication step.

use fmu_solver::Integrator;

use super::equations::{Equations, answer};
use crate::answer::Answer;
use crate::batch::Batch;

/// Half the distance of the two points of Gauss's rule, relative to the interval: 1/√12.
const GAUSS: f64 = 0.288_675_134_594_812_9;

/// Outputs that are integrated, with their integrals since the start of the step.
#[derive(Default)]
pub(super) struct Integrals {
    outputs: Option<Batch>,
    values: Vec<f64>,
    sums: Vec<f64>,
}

impl Integrals {
    /// Of the outputs whose means the plan names.
    pub fn new(means: Option<&(Batch, Vec<usize>)>) -> Self {
        let zeros = vec![0.0; means.map_or(0, |(outputs, _)| outputs.len())];
        Self {
            outputs: means.map(|(outputs, _)| outputs.clone()),
            values: zeros.clone(),
            sums: zeros,
        }
    }

    pub fn clear(&mut self) {
        self.sums.fill(0.0);
    }

    /// Adds a part of the last internal step, by Gauss's rule of order 4.
    pub fn add(
        &mut self,
        integrator: &mut Integrator,
        equations: &mut Equations,
        [from, to]: [f64; 2],
    ) -> Result<(), Answer> {
        let Some(outputs) = &self.outputs else {
            return Ok(());
        };
        let length = to - from;
        for place in [0.5 - GAUSS, 0.5 + GAUSS] {
            let t = from + place * length;
            let x = integrator.states_at(t - integrator.start());
            equations.set(t, x)?;
            let read = equations.inner.get(outputs, &mut self.values);
            read.map_err(|error| answer(error, "fmi2GetReal"))?;
            for (sum, value) in self.sums.iter_mut().zip(&self.values) {
                *sum += 0.5 * length * value;
            }
        }
        Ok(())
    }

    /// Writes the means over a step of `h`, s.
    pub fn write_means(&self, h: f64, means: &mut [f64]) {
        for (mean, sum) in means.iter_mut().zip(&self.sums) {
            *mean = sum / h;
        }
    }
}
