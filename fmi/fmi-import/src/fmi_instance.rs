//! [`FmiInstance`]: the interface by which a co-simulation master (`cosim`) calls an instance,
//! whatever version of FMI it has and wherever it is: in this thread, in another one, or in a page.
//!
//! ```
//! use fmi_import::fmi_instance::{Call, FmiInstance};
//! fn step(instance: &dyn FmiInstance, t: f64, h: f64) -> anyhow::Result<f64> {
//!     instance.call(Call::Step(t, h))
//! }
//! ```

use std::any::Any;
use std::ffi::CString;

use anyhow::Result;
use serde::{Deserialize, Serialize};

use crate::batch::Batch;
use crate::raw::Experiment;
use crate::value::Value;

/// The arguments with which an instance is made.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Arguments {
    /// instanceName.
    pub name: CString,
    /// `guid` or `instantiationToken`.
    pub token: CString,
    /// Folder of the unpacked resources: a URI in FMI 2.0, a path in FMI 3.0.
    pub resources: CString,
    /// The master enters Event Mode if it is needed (eventModeUsed).
    pub has_events: bool,
    /// loggingOn.
    pub is_logging: bool,
    /// Steps may end early (earlyReturnAllowed).
    pub returns_early: bool,
}

/// A call that passes no values of variables. It returns a number, 0 unless said otherwise.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub enum Call {
    /// What the FMU is told of the run: fmi2SetupExperiment, in FMI 3.0 the arguments of the next
    /// [`Self::EnterInitialization`]. It comes before start values are set, since FMUs of 20-sim
    /// lose them here.
    SetUp(Experiment),
    /// From Instantiated to Configuration Mode, in which structural parameters are set.
    EnterConfiguration,
    /// Back to Instantiated.
    ExitConfiguration,
    /// From Instantiated to Initialization Mode at this time, s, with or without [`Self::SetUp`].
    EnterInitialization(f64),
    /// From Initialization Mode to the first communication point.
    ExitInitialization,
    /// A communication step from a time by a length, both s.
    Step(f64, f64),
    /// Returns the time that the instance has reached, s.
    Time,
    /// Whether a step that the FMU ends early fails with [`Stopped`](crate::answer::Stopped)
    /// instead of being continued.
    StopEarly(bool),
    /// To Event Mode, where an output may be read after an input was set.
    EnterEvents,
    /// Updates discrete states; returns 1 if they must be updated once more.
    UpdateEvents,
    /// From Event Mode to Step Mode.
    LeaveEvents,
    /// Completes Event Mode, if the instance is in it.
    Settle,
    /// Returns 1 if the instance is in Event Mode, 2 if it has something to update there, else 0.
    InEvents,
    /// Returns when Event Mode must be entered next, s; infinite if that is not known.
    NextEvent,
    /// Sets the time at which an event is handled, s. Model Exchange only.
    SetTime(f64),
    /// Returns the time of the next event that the FMU has announced, s. Model Exchange only.
    NextTimeEvent,
    /// To Event Mode at a time, with a tolerance, both s; clocks that are due tick.
    Tick(f64, f64),
    /// Ends the run.
    Terminate,
}

/// A call that is begun ahead of the call itself, for an instance in another thread.
#[derive(Clone, Copy, Debug)]
pub enum BegunCall<'a> {
    /// A call without values.
    Plain(Call),
    /// [`FmiInstance::get`].
    Get(&'a Batch),
    /// [`FmiInstance::set`].
    Set(&'a Batch, &'a [f64]),
}

/// How many updates of discrete states there may be at one time.
pub(crate) const MAX_PASSES: usize = 100;

/// What the integration of an instance for Model Exchange took so far.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Integration {
    /// Internal steps.
    pub steps: u64,
    /// Internal steps that were repeated because their error was too large.
    pub rejected: u64,
    /// Evaluations of the derivatives, without those by the FMU for directional derivatives.
    pub evaluations: u64,
    /// Jacobians.
    pub jacobians: u64,
    /// Events: of states, times, inputs and clocks.
    pub events: u64,
    /// Time from which the stiff method integrates, s.
    pub stiff_since: Option<f64>,
}

/// An instance that a co-simulation master steps. Errors are an [`Answer`](crate::answer::Answer),
/// [`Ended`](crate::answer::Ended), [`Stopped`](crate::answer::Stopped), or a text.
pub trait FmiInstance {
    /// Begins a call, if the instance is in another thread. The same call, made later, waits for
    /// its result; calls end in the order in which they were begun.
    fn begin(&self, _ahead: BegunCall) {}
    /// Waits for all calls that were begun, and drops their results.
    fn drain(&self) {}
    /// Switches these log categories on, and all others off.
    fn log_only(&self, categories: &[CString]) -> Result<()>;
    /// Gets values of a type that an `f64` cannot represent.
    fn get_values(&self, batch: &Batch, values: &mut [Value]) -> Result<()>;
    /// Sets values of any type.
    fn set_values(&self, batch: &Batch, values: &[Value]) -> Result<()>;
    /// Makes a call without values. What the version of FMI does not have is skipped.
    fn call(&self, call: Call) -> Result<f64>;
    /// Gets values as numbers; of output clocks whether they tick at present, 1 or 0. From then on
    /// these clocks are asked in Event Mode, and no tick of theirs is passed over.
    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()>;
    /// Sets values from numbers; input clocks tick that are set to 1.
    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()>;
    /// Gets first time derivatives of Real outputs.
    fn get_derivatives(&self, batch: &Batch, values: &mut [f64]) -> Result<()>;
    /// Sets first time derivatives of Real inputs.
    fn set_derivatives(&self, batch: &Batch, values: &[f64]) -> Result<()>;
    /// Gets the rates of the Real outputs `of[0]` when the Real inputs `of[1]` change at the rates
    /// `seeds`.
    fn directional(&self, of: [&Batch; 2], seeds: &[f64], rates: &mut [f64]) -> Result<()>;
    /// What its integration took; None for an instance that steps itself.
    fn integration(&self) -> Result<Option<Integration>> {
        Ok(None)
    }
    /// Saves the state of the instance, and what is tracked of it. The state is freed when dropped.
    fn save(&self) -> Result<Box<dyn Any>>;
    /// Restores a state that this instance has saved.
    fn restore(&self, state: &dyn Any) -> Result<()>;
    /// The bytes of a state that this instance has saved, and of what is tracked of it.
    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>>;
    /// A state of this instance, from the bytes of a state of any instance of the same FMU.
    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>>;
    /// Resets the instance to Instantiated; returns false if that is not possible.
    fn reset(&self) -> bool;
}
