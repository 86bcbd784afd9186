//! What an importer's `fmi2Component` points at, and how every call gets in and out. Nothing here knows what a function does.

use super::calls::Call;
use super::ffi::*;
use super::log::Log;
use crate::Model;
use crate::core::fault::Fault;
use crate::core::guard::{Entered, Guarded};
use crate::core::instance::Instance;
use crate::core::message::{Kind, Message};
use crate::core::panic::{self, Panic};
use crate::core::step::End;
use std::ffi::CString;
use std::sync::Arc;

/// An instance and what FMI 2.0 adds to it.
pub(crate) struct Body<M: Model> {
    pub(crate) instance: Instance<M>,
    pub(crate) log: Arc<Log>,
    /// How the last fmi2DoStep ended.
    pub(crate) last_step: Status,
    /// Whether the model wanted the simulation to end there.
    pub(crate) terminated: bool,
    /// Texts the importer was given by the last fmi2GetString.
    pub(crate) strings: Vec<CString>,
}

/// Runs `f` on the instance: NULL, calls from within calls, call order, panics and messages are dealt with here.
///
/// # Safety
/// `c` is NULL or came from fmi2Instantiate of this library and was not freed.
#[inline]
pub(crate) unsafe fn enter<M: Model>(
    c: Component,
    call: Call,
    f: impl FnOnce(&mut Body<M>) -> Result<(), Fault>,
) -> Status {
    // SAFETY: forwarded.
    let component = unsafe { c.cast::<Guarded<Body<M>>>().as_ref() };
    let Some(mut body) = component.and_then(Guarded::enter) else {
        return Status::Error;
    };
    let result = panic::catch(|| {
        let done = call.check(&body.instance).and_then(|()| f(&mut body));
        match done {
            Ok(()) => Status::Ok,
            Err(fault) => refuse(&mut body.instance, call, fault),
        }
    });
    let status = match result {
        Ok(status) => status,
        Err(panic) => lose(&mut body.instance, call, panic),
    };
    if !body.instance.messages.is_empty() {
        send(body);
    }
    status
}

#[cold]
fn refuse<M: Model>(instance: &mut Instance<M>, call: Call, fault: Fault) -> Status {
    let (kind, status, text) = match fault {
        Fault::Refused(text) => (Kind::Refused, Status::Error, text),
        Fault::Discarded(text) => (Kind::Discarded, Status::Discard, text),
        Fault::Unknown(number) => {
            let last = instance.layout.len().saturating_sub(1);
            let known = if number as usize > last {
                format!("from 0 to {last}")
            } else {
                "one of the model description".to_owned()
            };
            let text = format!("unknown value reference {number}; it must be {known}");
            (Kind::Refused, Status::Error, text)
        }
    };
    instance.tell(kind, format!("{}: {text}", call.name));
    status
}

/// After a panic. FMI 2.0.4 means by fmi2Fatal that all instances are corrupt; one is, and a reset or a restored state mends it.
#[cold]
fn lose<M: Model>(instance: &mut Instance<M>, call: Call, panic: Panic) -> Status {
    instance.lost = true;
    let text = format!(
        "{}: {}; the instance needs fmi2Reset or fmi2SetFMUstate",
        call.name,
        panic.describe()
    );
    instance.tell(Kind::Refused, text);
    Status::Error
}

/// Sends what is queued, after the instance has been let go of: the logger may call back.
#[cold]
fn send<M: Model>(mut body: Entered<'_, Body<M>>) {
    let messages: Vec<Message> = std::mem::take(&mut body.instance.messages);
    let log = Arc::clone(&body.log);
    drop(body);
    log.send(&messages);
}

/// A step that the model did not take to its end.
#[cold]
fn stopped(t: f64, h: f64, end: End) -> Fault {
    let wish = if end.terminate {
        "ends the simulation"
    } else {
        "stops"
    };
    let end = end.time;
    Fault::discarded(format_args!(
        "t = {t} s, h = {h} s: the model {wish} at {end} s"
    ))
}

impl<M: Model> Body<M> {
    /// fmi2DoStep.
    #[inline]
    pub(crate) fn do_step(&mut self, t: f64, h: f64) -> Result<(), Fault> {
        match self.instance.do_step(t, h) {
            Ok(end) if end.is_whole && !end.terminate => {
                self.last_step = Status::Ok;
                Ok(())
            }
            Ok(end) => {
                self.last_step = Status::Discard;
                self.terminated = end.terminate;
                Err(stopped(t, h, end))
            }
            Err(fault) => {
                if matches!(fault, Fault::Discarded(_)) {
                    self.last_step = Status::Discard;
                }
                Err(fault)
            }
        }
    }

    /// fmi2Reset.
    pub(crate) fn reset(&mut self) -> Result<(), Fault> {
        self.instance.reset();
        self.forget_step();
        Ok(())
    }

    /// fmi2SetFMUstate.
    pub(crate) fn restore(&mut self, handle: usize) -> Result<(), Fault> {
        self.instance.restore(handle)?;
        self.forget_step();
        Ok(())
    }

    fn forget_step(&mut self) {
        self.last_step = Status::Ok;
        self.terminated = false;
    }
}
