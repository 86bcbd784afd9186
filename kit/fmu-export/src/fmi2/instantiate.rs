//! fmi2Instantiate and fmi2FreeInstance, which `entry` re-exports for `export_fmu!`.

use super::ffi::*;
use super::instance::Fmi2;
use super::{log, uri};
use crate::Model;
use crate::c_api::call_order::{CS, ME};
use crate::c_api::description::table_check;
use crate::c_api::export::Exported;
use crate::c_api::library::{self, Library, Request, text};
use crate::core::panic;
use std::ptr;

/// fmi2Instantiate.
///
/// # Safety
/// As for every function of [`entry`](crate::entry); `functions` points at callbacks that may be
/// called until fmi2FreeInstance.
pub unsafe fn instantiate<X: Exported>(
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
    library.silence_panics();
    // SAFETY: forwarded.
    let (name, guid, resources) = unsafe { (text(name), text(given_guid), text(resources)) };
    let resources = resources.map(|uri| {
        let folder = panic::catch(|| uri::folder(&uri));
        folder.unwrap_or_else(|panic| Err(panic.describe()))
    });
    let request = Request {
        function: "fmi2Instantiate",
        log: log::new::<X::Model>(&callbacks, name.as_deref().unwrap_or_default(), logging_on),
        name: name.as_deref(),
        token: ("fmuGUID", guid.as_deref()),
        sizes: library.sizes,
        hash: &library.hashes[0],
        resources,
        interface: if kind == MODEL_EXCHANGE { ME } else { CS },
        version: Fmi2::NEW,
    };
    request.instantiate::<X::Model>(table_check::check, |fmi| {
        fmi.instance.ticks_itself = true;
        check_kind::<X::Model>(kind)
    })
}

fn check_kind<X: Model>(kind: c_int) -> Result<(), String> {
    let is_known = kind == CO_SIMULATION || kind == MODEL_EXCHANGE && X::MODEL_EXCHANGE.is_some();
    if is_known {
        return Ok(());
    }
    let exchange = match X::MODEL_EXCHANGE {
        Some(_) => format!(" or {MODEL_EXCHANGE} (fmi2ModelExchange)"),
        None => String::new(),
    };
    Err(format!(
        "fmuType = {kind} must be {CO_SIMULATION} (fmi2CoSimulation){exchange}"
    ))
}

/// fmi2FreeInstance; NULL and an instance in use are ignored.
///
/// # Safety
/// As for every function of [`entry`](crate::entry); `c` is not used afterwards.
pub unsafe fn free_instance<X: Exported>(c: Component) {
    // SAFETY: forwarded.
    unsafe { library::free::<X::Model, Fmi2>(c) }
}
