//! The calls that an instance of either version of FMI understands, which is all that the master
//! knows of it.

use std::any::Any;
use std::ffi::{CStr, CString};

use anyhow::Result;

use crate::batch::Batch;
use crate::value::Value;

/// What an instance is made with.
pub struct Arguments<'a> {
    /// Name.
    pub name: &'a CStr,
    /// `guid` or `instantiationToken`.
    pub token: &'a CStr,
    /// Folder of the unpacked resources, as the version wants it.
    pub resources: &'a CStr,
    /// The master goes through Event Mode where it is needed.
    pub has_events: bool,
    /// Steps may end early.
    pub returns_early: bool,
}

/// A call that may be begun before it is made.
#[cfg_attr(
    not(feature = "native"),
    expect(dead_code, reason = "modules run in the thread of their host")
)]
#[derive(Clone, Copy, Debug)]
pub enum BegunCall<'a> {
    /// From this time, s.
    EnterInitialization(f64),
    ExitInitialization,
    /// From a time by a step, both s.
    Step(f64, f64),
    Get(&'a Batch),
    Set(&'a Batch, &'a [f64]),
    EnterEvents,
    UpdateEvents,
    LeaveEvents,
}

/// The calls of one version of FMI. What the version does not have is done without a call. An error
/// is an [`Answer`](super::answer::Answer), or says more.
pub trait Border {
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
    /// Say when the run starts. Before start values are set: FMUs of 20-sim forget them here.
    fn set_up(&self, start: f64) -> Result<()>;
    /// From Instantiated into Initialization Mode, set up or not.
    fn enter_initialization(&self, start: f64) -> Result<()>;
    /// From Initialization Mode to the first communication point.
    fn exit_initialization(&self) -> Result<()>;
    /// Values as numbers.
    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()>;
    /// Set values from numbers.
    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()>;
    /// First time derivatives of Real outputs; `ones` holds at least as many ones.
    fn get_derivatives(&self, batch: &Batch, ones: &[i32], values: &mut [f64]) -> Result<()>;
    /// First time derivatives of Real inputs.
    fn set_derivatives(&self, batch: &Batch, ones: &[i32], values: &[f64]) -> Result<()>;
    /// How fast Real outputs change with Real inputs that change as fast as `seeds` say.
    fn directional(&self, of: [&Batch; 2], seeds: &[f64], rates: &mut [f64]) -> Result<()>;
    /// A communication step.
    fn step(&self, t: f64, h: f64) -> Result<()>;
    /// The instance's own time, s.
    fn time(&self) -> Result<f64>;
    /// Into Event Mode, where an output may be read after an input was set.
    fn enter_events(&self) -> Result<()> {
        Ok(())
    }
    /// Let discrete states follow; whether they want to once more.
    fn update_events(&self) -> Result<bool> {
        Ok(false)
    }
    /// From Event Mode back to where steps are made.
    fn leave_events(&self) -> Result<()> {
        Ok(())
    }
    /// Event Mode to its end, where the instance is in it.
    fn settle(&self) -> Result<()> {
        Ok(())
    }
    /// When Event Mode must be entered next, s: infinite where that is not known.
    fn next_event(&self) -> f64 {
        f64::INFINITY
    }
    /// Into Event Mode at `t`, s, where an event is due then, up to `tolerance`, s; clocks tick.
    fn tick(&self, _t: f64, _tolerance: f64) -> Result<()> {
        Ok(())
    }
    /// The end of the run.
    fn terminate(&self) -> Result<()>;
    /// The state of the instance, and what its border knows of it; freed when dropped.
    fn save(&self) -> Result<Box<dyn Any>>;
    /// Back to a state that this instance was saved in.
    fn restore(&self, state: &dyn Any) -> Result<()>;
    /// The bytes of a state that this instance was saved in, and of what its border knows of it.
    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>>;
    /// A state of this instance, from the bytes of one of an instance of the same FMU.
    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>>;
    /// Whether a step that the FMU ends early is left there, as [`Stopped`](super::answer::Stopped).
    fn stop_early(&self, _stops: bool) {}
    /// Back to where it was when it was made; false where it cannot be.
    fn reset(&self) -> bool;
}
