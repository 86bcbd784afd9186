//! What an importer's handle points to, and [`enter`], through which all functions of `fmi2` and
//! `fmi3` reach an instance: it checks handle and call order, catches panics, sends messages.

use super::call_order::{CLOCK_ACTIVATION, COMMON_STATES, CS, Call, LOST, ME, ME_STATES, SE};
use super::log::{Log, Logger};
use super::status::Status;
use crate::core::exclusive::{Exclusive, ExclusiveRef};
use crate::core::fault::{self, Fault};
use crate::core::instance::Instance;
use crate::core::message::{Kind, Message};
use crate::core::panic::{self, Panic};
use crate::core::storage::TypeNames;
use crate::{Binary, Model};
use std::ffi::{CString, c_void};
use std::sync::Arc;

/// A version of FMI: what it adds to an instance, and its names for types and states.
pub(crate) trait Version: Sized + 'static {
    /// Its logger.
    type Logger: Logger;
    /// Its name, padded with zeros.
    const NAME: [u8; 4];
    /// Its names for the types of variables.
    const NAMES: TypeNames;
    /// The bits of the states and their names.
    const STATES: &'static [(u16, &'static str)];
    /// The functions that make an instance usable again after a panic.
    const RECOVERY: &'static str;
    /// The value reference of time, if time is a variable.
    const TIME: Option<u32> = None;

    /// The bit of the state that an instance is in.
    fn state<M: Model>(fmi: &FmiInstance<M, Self>) -> u16;
}

/// An instance, together with what its version of FMI adds to it.
pub(crate) struct FmiInstance<M: Model, V: Version> {
    pub(crate) instance: Instance<M>,
    pub(crate) log: Arc<Log<V::Logger>>,
    /// The strings that the last get has returned to the importer.
    pub(crate) strings: Vec<CString>,
    /// The binary values that the last get has returned to the importer.
    pub(crate) bytes: Vec<Binary>,
    /// The interface it was instantiated for, [`CS`], [`ME`] or [`SE`].
    pub(crate) interface: u16,
    pub(crate) version: V,
}

/// Runs `f` on the instance: refuses NULL, a call within a call and a call out of order, catches a
/// panic, and sends the queued messages afterwards.
///
/// # Safety
/// `c` is NULL or came from the instantiation of this library in this version and was not freed.
#[inline]
pub(crate) unsafe fn enter<M: Model, V: Version>(
    c: *mut c_void,
    call: Call,
    f: impl FnOnce(&mut FmiInstance<M, V>) -> Result<(), Fault>,
) -> Status {
    // SAFETY: forwarded.
    let guard = unsafe { c.cast::<Exclusive<FmiInstance<M, V>>>().as_ref() };
    let entered = match M::SCHEDULED_EXECUTION {
        true => guard.map(Exclusive::wait),
        false => guard.and_then(Exclusive::enter),
    };
    let Some(mut fmi) = entered else {
        return Status::Error;
    };
    let result = panic::catch(|| {
        let done = check_order(&fmi, call).and_then(|()| f(&mut fmi));
        match done {
            Ok(()) => Status::Ok,
            Err(fault) => report_fault(&mut fmi, call, fault),
        }
    });
    let status = match result {
        Ok(status) => status,
        Err(panic) => report_panic(&mut fmi, call, panic),
    };
    if !fmi.instance.messages.is_empty() {
        send(fmi, status);
    }
    status
}

/// Refuses a call that is not allowed in the instance's state or for its interface.
#[inline]
fn check_order<M: Model, V: Version>(fmi: &FmiInstance<M, V>, call: Call) -> Result<(), Fault> {
    let state = V::state(fmi);
    // For a model with Co-Simulation alone, the code for others is not even compiled.
    let interface = match M::MODEL_EXCHANGE.is_some() || M::SCHEDULED_EXECUTION {
        true => fmi.interface,
        false => CS,
    };
    if call.allowed & interface == 0 {
        return other_interface::<M>(call, interface);
    }
    match call.allowed & state {
        0 => out_of_order::<V>(call, state, interface),
        _ => Ok(()),
    }
}

#[cold]
fn other_interface<M: Model>(call: Call, interface: u16) -> Result<(), Fault> {
    let name = |interfaces: u16| match interfaces {
        _ if interfaces & ME != 0 => "Model Exchange",
        _ if interfaces & SE != 0 => "Scheduled Execution",
        _ => "Co-Simulation",
    };
    let (of, is) = (name(call.allowed), name(interface));
    if M::MODEL_EXCHANGE.is_none() && !M::SCHEDULED_EXECUTION {
        return fault::refuse!("this function is for {of}, and this FMU offers {is} only");
    }
    fault::refuse!("this function is for {of}, and the instance was made for {is}")
}

#[cold]
fn out_of_order<V: Version>(call: Call, state: u16, interface: u16) -> Result<(), Fault> {
    let names = |mask: u16| -> Vec<&str> {
        let named = V::STATES.iter().filter(|(bit, _)| mask & bit != 0);
        named.map(|(_, name)| *name).collect()
    };
    let own = match interface {
        ME => ME_STATES | COMMON_STATES,
        SE => CLOCK_ACTIVATION | COMMON_STATES,
        _ => !(ME_STATES | CLOCK_ACTIVATION),
    };
    let now = names(state).join("");
    let allowed = names(call.allowed & !LOST & own).join(", ");
    fault::refuse!("not allowed in state {now}; allowed in {allowed}")
}

#[cold]
fn report_fault<M: Model, V: Version>(
    fmi: &mut FmiInstance<M, V>,
    call: Call,
    fault: Fault,
) -> Status {
    let instance = &mut fmi.instance;
    let (kind, status, text) = match fault {
        Fault::Refused(text) => (Kind::Refused, Status::Error, text),
        Fault::Discarded(text) => (Kind::Discarded, Status::Discard, text),
        Fault::Unknown(number) if V::TIME == Some(number) => {
            let real = V::NAMES.real;
            let text = format!(
                "value reference {number} is `time`, the independent variable; it can only be read, as {real}"
            );
            (Kind::Refused, Status::Error, text)
        }
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
    instance.report(kind, format!("{}: {text}", call.name));
    status
}

/// After a panic: this instance is unusable until a reset or a restored state; others go on.
#[cold]
fn report_panic<M: Model, V: Version>(
    fmi: &mut FmiInstance<M, V>,
    call: Call,
    panic: Panic,
) -> Status {
    fmi.instance.lost = true;
    let text = format!(
        "{}: {}; the instance needs {}",
        call.name,
        panic.describe(),
        V::RECOVERY
    );
    fmi.instance.report(Kind::Refused, text);
    Status::Error
}

/// Sends the queued messages once the instance is no longer in use: the logger may call back.
#[cold]
pub(crate) fn send<M: Model, V: Version>(
    mut fmi: ExclusiveRef<'_, FmiInstance<M, V>>,
    status: Status,
) {
    let messages: Vec<Message> = std::mem::take(&mut fmi.instance.messages);
    let log = Arc::clone(&fmi.log);
    drop(fmi);
    log.send(&messages, status);
}
