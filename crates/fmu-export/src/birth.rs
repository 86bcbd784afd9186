//! fmi2Instantiate and fmi2FreeInstance.

use crate::description::describe;
use crate::failure::{Failure, refuse};
use crate::ffi::*;
use crate::instance::Instance;
use crate::layout::Layout;
use crate::log::{Category, Log};
use crate::{Model, panic, uri};
use libc::c_int;
use std::ffi::CStr;
use std::path::PathBuf;
use std::ptr;
use std::sync::OnceLock;
use uuid::Uuid;

/// Where the GUID of the model is kept once it has been computed.
pub type Guid = OnceLock<Uuid>;

/// fmi2Instantiate.
///
/// # Safety
/// As for every function of [`entry`](crate::entry); `functions` points at callbacks that may be called until fmi2FreeInstance.
pub unsafe fn instantiate<M: Model>(
    guid: &Guid,
    name: Str,
    kind: c_int,
    given_guid: Str,
    resources: Str,
    functions: *const CallbackFunctions,
    logging_on: Boolean,
) -> Component {
    if functions.is_null() || !functions.is_aligned() {
        return ptr::null_mut();
    }
    panic::silence();
    // SAFETY: not NULL, aligned; the rest is forwarded.
    let callbacks = unsafe { *functions };
    // SAFETY: forwarded.
    let text = |s: Str| (!s.is_null()).then(|| unsafe { CStr::from_ptr(s) }.to_string_lossy());
    let (name, given_guid, resources) = (text(name), text(given_guid), text(resources));
    let log = Log::new(
        &callbacks,
        name.as_deref().unwrap_or_default(),
        logging_on != 0,
    );
    let made = panic::catch(|| {
        let layout = Layout::<M>::new();
        let guid = identify(guid, &layout)?;
        match name.as_deref() {
            None => return refuse!("instanceName = NULL; allowed are non-empty names"),
            Some("") => return refuse!("instanceName is empty; allowed are non-empty names"),
            Some(_) => {}
        }
        if kind != CO_SIMULATION {
            return refuse!("fmuType = {kind}; allowed is {CO_SIMULATION} (fmi2CoSimulation)");
        }
        match given_guid.as_deref() {
            Some(given) if is_same(given, guid) => {}
            given => {
                return refuse!(
                    "fmuGUID = {}; allowed is {{{guid}}}",
                    given.unwrap_or("NULL")
                );
            }
        }
        Ok((layout, guid))
    });
    match made {
        Ok(Ok((layout, guid))) => {
            let folder = resources.and_then(|uri| folder(&log, &uri));
            Box::into_raw(Box::new(Instance::<M>::new(log, layout, guid, folder))).cast()
        }
        Ok(Err(Failure::Error(text) | Failure::Discard(text))) => {
            log.send(Category::Error, &format!("fmi2Instantiate: {text}"));
            ptr::null_mut()
        }
        Err(message) => {
            log.send(Category::Fatal, &format!("fmi2Instantiate: {message}"));
            ptr::null_mut()
        }
    }
}

fn identify<M: Model>(guid: &Guid, layout: &Layout<M>) -> Result<Uuid, Failure> {
    if let Some(guid) = guid.get() {
        return Ok(*guid);
    }
    let description = describe(layout).map_err(Failure::Error)?;
    Ok(*guid.get_or_init(|| description.guid))
}

/// GUIDs are compared as numbers: with or without braces, in either case.
fn is_same(given: &str, guid: Uuid) -> bool {
    Uuid::try_parse(given.trim()).is_ok_and(|given| given == guid)
}

/// The resources folder; one that cannot be understood is reported and done without.
fn folder(log: &Log, uri: &str) -> Option<PathBuf> {
    match uri::folder(uri) {
        Ok(folder) => Some(folder),
        Err(reason) => {
            log.send(
                Category::Warning,
                &format!("fmi2Instantiate: {reason}; going on without"),
            );
            None
        }
    }
}

/// fmi2FreeInstance; NULL is ignored.
///
/// # Safety
/// As for every function of [`entry`](crate::entry); `c` is not used afterwards.
pub unsafe fn free_instance<M: Model>(c: Component) {
    if !c.is_null() {
        // SAFETY: made by `instantiate` with `Box::into_raw`.
        let instance = unsafe { Box::from_raw(c.cast::<Instance<M>>()) };
        // Only the drop of a model can panic; there is nobody left to tell.
        let _ = panic::catch(|| drop(instance));
    }
}
