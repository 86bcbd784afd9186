//! The calls of an instance in a step of the schedule `standard`, which its thread makes one after
//! the other: `whole_steps` plans them.

use anyhow::Error;

use fmi_import::batch::Batch;
use fmi_import::fmi_instance::{Call, FmiInstance};
use fmi_import::messages::{self, Message};

/// What an instance is set to before a step, and what is read after it.
#[derive(Clone, Debug, Default)]
pub(crate) struct StepCalls {
    pub sets: Vec<Batch>,
    pub gets: Vec<Batch>,
}

/// A call that failed.
pub(crate) struct FailedCall {
    /// Its place among sets, step and gets.
    pub place: usize,
    error: Error,
    /// What FMUs have said in its thread.
    messages: Vec<Message>,
}

/// The values of a step that a thread has made, with the calls that failed, by place in its plan.
pub(crate) struct StepsDone {
    pub values: Vec<f64>,
    pub failed: Vec<(usize, FailedCall)>,
}

impl FailedCall {
    pub fn new(place: usize, error: Error) -> Self {
        let messages = messages::take();
        Self {
            place,
            error,
            messages,
        }
    }

    /// The error; what was said is now said in this thread.
    pub fn into_error(self) -> Error {
        messages::extend(self.messages);
        self.error
    }
}

impl StepCalls {
    /// Number of values that are set and read.
    pub fn len(&self) -> usize {
        self.sets.iter().chain(&self.gets).map(Batch::len).sum()
    }

    /// Make a step from `t` by `h`, both s; `values` are those to set, then those read.
    pub fn make(
        &self,
        instance: &dyn FmiInstance,
        mut values: &mut [f64],
        [t, h]: [f64; 2],
    ) -> Result<(), FailedCall> {
        let mut next = |batch: &Batch| values.split_off_mut(..batch.len()).unwrap_or_default();
        let step = self.sets.len();
        for (place, batch) in self.sets.iter().enumerate() {
            let done = instance.set(batch, next(batch));
            done.map_err(|error| FailedCall::new(place, error))?;
        }
        let done = instance.call(Call::Step(t, h));
        done.map_err(|error| FailedCall::new(step, error))?;
        for (place, batch) in self.gets.iter().enumerate() {
            let done = instance.get(batch, next(batch));
            done.map_err(|error| FailedCall::new(step + 1 + place, error))?;
        }
        Ok(())
    }
}
