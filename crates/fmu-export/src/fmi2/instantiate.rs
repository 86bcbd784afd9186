//! fmi2Instantiate and fmi2FreeInstance.

use super::component::Body;
use super::description::describe;
use super::ffi::*;
use super::log::Log;
use super::uri;
use crate::Model;
use crate::core::guard::Guarded;
use crate::core::instance::Instance;
use crate::core::layout::Layout;
use crate::core::message::{Kind, Message};
use crate::core::panic;
use libc::c_int;
use std::ffi::CStr;
use std::path::PathBuf;
use std::ptr;
use std::sync::{Arc, OnceLock};
use uuid::Uuid;

/// What all instances of a library share.
pub struct Library {
    /// Of the model, once it has been computed.
    guid: OnceLock<Uuid>,
    /// It is part of a program (a test), where others than the model may panic.
    pub(super) is_program: bool,
}

impl Library {
    /// For one model.
    pub const fn new(is_program: bool) -> Self {
        Self {
            guid: OnceLock::new(),
            is_program,
        }
    }
}

/// fmi2Instantiate.
///
/// # Safety
/// As for every function of [`entry`](crate::entry); `functions` points at callbacks that may be called until fmi2FreeInstance.
pub unsafe fn instantiate<M: Model>(
    library: &Library,
    name: Str,
    kind: c_int,
    given_guid: Str,
    resources: Str,
    functions: *const CallbackFunctions,
    logging_on: Boolean,
) -> Component {
    // SAFETY: not NULL; the rest is forwarded. Unaligned on 32-bit platforms.
    let Some(callbacks) = (!functions.is_null()).then(|| unsafe { functions.read_unaligned() })
    else {
        return ptr::null_mut();
    };
    panic::silence(library.is_program);
    // SAFETY: forwarded.
    let text = |s: Str| (!s.is_null()).then(|| unsafe { CStr::from_ptr(s) }.to_string_lossy());
    let name = text(name);
    let log = Arc::new(Log::new(
        &callbacks,
        name.as_deref().unwrap_or_default(),
        logging_on != 0,
        M::INFO.log_categories,
    ));
    let mut messages = Vec::new();
    let made = panic::catch(|| {
        let layout = Layout::<M>::new();
        let guid = identify(&library.guid, &layout)?;
        check(name.as_deref(), kind, text(given_guid).as_deref(), guid)?;
        let folder = text(resources).and_then(|uri| folder(&mut messages, &uri));
        let mut instance = Instance::<M>::new(layout, guid.into_bytes(), folder);
        instance.wanted = log.wanted();
        Ok(Box::new(Guarded::new(Body {
            instance,
            log: Arc::clone(&log),
            last_step: Status::Ok,
            terminated: false,
            strings: Vec::new(),
        })))
    });
    let made = made.unwrap_or_else(|panic| Err(panic.describe()));
    let component = match made {
        Ok(component) => Box::into_raw(component).cast(),
        Err(text) => {
            messages.push(Message::new(
                Kind::Refused,
                format!("fmi2Instantiate: {text}"),
            ));
            ptr::null_mut()
        }
    };
    log.send(&messages);
    component
}

/// Refuses arguments that are not meant for this FMU.
fn check(
    name: Option<&str>,
    kind: c_int,
    given_guid: Option<&str>,
    guid: Uuid,
) -> Result<(), String> {
    match name {
        None => return Err("instanceName = NULL must be a name".to_owned()),
        Some("") => return Err("instanceName is empty; it must be a name".to_owned()),
        Some(_) => {}
    }
    if kind != CO_SIMULATION {
        return Err(format!(
            "fmuType = {kind} must be {CO_SIMULATION} (fmi2CoSimulation)"
        ));
    }
    match given_guid {
        Some(given) if is_same(given, guid) => Ok(()),
        given => Err(format!(
            "fmuGUID = {} must be {{{guid}}}",
            given.unwrap_or("NULL")
        )),
    }
}

fn identify<M: Model>(guid: &OnceLock<Uuid>, layout: &Layout<M>) -> Result<Uuid, String> {
    if let Some(guid) = guid.get() {
        return Ok(*guid);
    }
    let description = describe(layout)?;
    Ok(*guid.get_or_init(|| description.guid))
}

/// GUIDs are compared as numbers: with or without braces, in either case.
fn is_same(given: &str, guid: Uuid) -> bool {
    Uuid::try_parse(given.trim()).is_ok_and(|given| given == guid)
}

/// The resources folder; one that cannot be understood is reported and done without.
fn folder(messages: &mut Vec<Message>, uri: &str) -> Option<PathBuf> {
    match uri::folder(uri) {
        Ok(folder) => Some(folder),
        Err(reason) => {
            let text = format!("fmi2Instantiate: {reason}; going on without");
            messages.push(Message::new(Kind::Warning, text));
            None
        }
    }
}

/// fmi2FreeInstance; NULL is ignored, and so is an instance in use: a logger that is called while its instance works cannot free it.
///
/// # Safety
/// As for every function of [`entry`](crate::entry); `c` is not used afterwards.
pub unsafe fn free_instance<M: Model>(c: Component) {
    let component = c.cast::<Guarded<Body<M>>>();
    // SAFETY: forwarded.
    let Some(body) = unsafe { component.as_ref() }.and_then(Guarded::enter) else {
        return;
    };
    body.log.close();
    drop(body);
    // SAFETY: made by `instantiate` with `Box::into_raw`, and not in use.
    let component = unsafe { Box::from_raw(component) };
    // Only the drop of a model can panic; there is nobody left to tell.
    let _ = panic::catch(|| drop(component));
}
