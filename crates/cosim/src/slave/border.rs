//! The calls that an instance of either version of FMI understands, which is all that the master knows of it.

use std::ffi::CString;

use anyhow::Result;
use fmu_description::Variable;

use super::answer::Answer;
use crate::batch::Batch;

/// A start value for one element.
pub enum Value {
    /// A number or a truth value, as [`crate::batch::bits`] has it.
    Bits(u64),
    /// A text.
    Text(CString),
}

/// The calls of one version of FMI. What the version does not have is done without a call.
pub trait Border {
    /// Switch these log categories on and no other.
    fn log_only(&self, categories: &[CString]) -> Answer;
    /// Set a variable, or an element of an array.
    fn set_one(&self, variable: &Variable, value: &Value) -> Answer;
    /// Say when the run starts. Before start values are set: FMUs of 20-sim forget them here.
    fn set_up(&self, start: f64) -> Answer;
    /// From Instantiated into Initialization Mode, set up or not.
    fn enter_initialization(&self, start: f64) -> Answer;
    /// From Initialization Mode to the first communication point.
    fn exit_initialization(&self) -> Answer;
    /// Values as numbers.
    fn get(&self, batch: &Batch, values: &mut [f64]) -> Answer;
    /// Set values from numbers.
    fn set(&self, batch: &Batch, values: &[f64]) -> Answer;
    /// First time derivatives of Real outputs; `ones` holds at least as many ones.
    fn get_derivatives(&self, batch: &Batch, ones: &[i32], values: &mut [f64]) -> Answer;
    /// First time derivatives of Real inputs.
    fn set_derivatives(&self, batch: &Batch, ones: &[i32], values: &[f64]) -> Result<Answer>;
    /// A communication step.
    fn step(&self, t: f64, h: f64) -> Result<Answer>;
    /// The instance's own time, s.
    fn time(&self) -> Result<f64>;
    /// Into Event Mode, where an output may be read after an input was set.
    fn enter_events(&self) -> Answer;
    /// Let discrete states follow; whether they want to once more.
    fn update_events(&self) -> Result<(Answer, bool)>;
    /// From Event Mode back to where steps are made.
    fn leave_events(&self) -> Answer;
    /// The end of the run.
    fn terminate(&self) -> Answer;
    /// Back to where it was when it was made; None where the library cannot.
    fn reset(&self) -> Option<Answer>;
}
