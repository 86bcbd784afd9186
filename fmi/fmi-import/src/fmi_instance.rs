//! The calls that an instance of either version of FMI understands, which is all that the master
//! knows of it.

use std::any::Any;
use std::ffi::CString;

use anyhow::Result;

use crate::batch::Batch;
use crate::value::Value;

/// What an instance is made with.
#[derive(Clone, Debug)]
pub struct Arguments {
    /// Name.
    pub name: CString,
    /// `guid` or `instantiationToken`.
    pub token: CString,
    /// Folder of the unpacked resources, as the version wants it.
    pub resources: CString,
    /// The master goes through Event Mode where it is needed.
    pub has_events: bool,
    /// Steps may end early.
    pub returns_early: bool,
}

/// A call that passes no values of variables. It answers a number, 0 where there is nothing to say.
#[derive(Clone, Copy, Debug)]
pub enum Call {
    /// Say when the run starts, s. Before start values are set: FMUs of 20-sim forget them here.
    SetUp(f64),
    /// From Instantiated into Initialization Mode at this time, s, set up or not.
    EnterInitialization(f64),
    /// From Initialization Mode to the first communication point.
    ExitInitialization,
    /// A communication step from a time by a length, both s.
    Step(f64, f64),
    /// The instance's own time, s.
    Time,
    /// Whether a step that the FMU ends early is left there, as [`Stopped`](crate::answer::Stopped).
    StopEarly(bool),
    /// Into Event Mode, where an output may be read after an input was set.
    EnterEvents,
    /// Let discrete states follow; 1 where they want to once more.
    UpdateEvents,
    /// From Event Mode back to where steps are made.
    LeaveEvents,
    /// Event Mode to its end, where the instance is in it.
    Settle,
    /// When Event Mode must be entered next, s: infinite where that is not known.
    NextEvent,
    /// Into Event Mode at a time, where an event is due then, up to a tolerance, both s; clocks
    /// tick.
    Tick(f64, f64),
    /// The end of the run.
    Terminate,
}

/// A call that may be begun before it is made.
#[derive(Clone, Copy, Debug)]
pub enum BegunCall<'a> {
    /// One without values.
    Plain(Call),
    /// Values are read.
    Get(&'a Batch),
    /// Values are set.
    Set(&'a Batch, &'a [f64]),
}

/// The calls of one version of FMI. An error is an [`Answer`](crate::answer::Answer), or says more.
pub trait FmiInstance {
    /// Begin a call where the instance is in another thread. The same call, made later, is its end; calls
    /// end in the order in which they were begun.
    fn begin(&self, _ahead: BegunCall) {}
    /// Await and forget what is begun.
    fn drain(&self) {}
    /// Switch these log categories on and no other.
    fn log_only(&self, categories: &[CString]) -> Result<()>;
    /// Whole values of a type that does not pass as numbers.
    fn get_whole(&self, batch: &Batch, values: &mut [Value]) -> Result<()>;
    /// Set whole values, of any type.
    fn set_whole(&self, batch: &Batch, values: &[Value]) -> Result<()>;
    /// A call without values. What the version does not have is left out.
    fn call(&self, call: Call) -> Result<f64>;
    /// Values as numbers.
    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()>;
    /// Set values from numbers.
    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()>;
    /// First time derivatives of Real outputs.
    fn get_derivatives(&self, batch: &Batch, values: &mut [f64]) -> Result<()>;
    /// First time derivatives of Real inputs.
    fn set_derivatives(&self, batch: &Batch, values: &[f64]) -> Result<()>;
    /// How fast Real outputs change with Real inputs that change as fast as `seeds` say.
    fn directional(&self, of: [&Batch; 2], seeds: &[f64], rates: &mut [f64]) -> Result<()>;
    /// The state of the instance, and what is known of it besides; freed when dropped.
    fn save(&self) -> Result<Box<dyn Any>>;
    /// Back to a state that this instance was saved in.
    fn restore(&self, state: &dyn Any) -> Result<()>;
    /// The bytes of a state that this instance was saved in, and of what is known of it besides.
    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>>;
    /// A state of this instance, from the bytes of one of an instance of the same FMU.
    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>>;
    /// Back to where it was when it was made; false where it cannot be.
    fn reset(&self) -> bool;
}
