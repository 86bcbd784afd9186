//! Instantiation in `fmi2` and `fmi3`: what all instances of a library share, the arguments of an
//! instantiation, and how an instance is made and freed.

use super::call_order::{INTERMEDIATE_UPDATE, ME};
use super::description::hash;
use super::fmi_instance::{FmiInstance, Version};
use super::log::Log;
use super::status::Status;
use crate::Model;
use crate::core::exclusive::Exclusive;
use crate::core::instance::Instance;
use crate::core::layout::Layout;
use crate::core::message::{Kind, Message};
use crate::core::panic;
use crate::core::sizes::{self, StartValues};
use crate::core::state::Identity;
use std::borrow::Cow;
use std::ffi::{CStr, c_char, c_void};
use std::path::PathBuf;
use std::ptr;
use std::sync::{Arc, OnceLock};
use uuid::Uuid;

/// What all instances of a library share.
pub struct Library {
    /// Hashes of the model descriptions of FMI 2.0 and 3.0, once they have been computed.
    pub(crate) hashes: [OnceLock<Uuid>; 2],
    /// The sizes that the FMU was packed with, such as `n=200 m=3`.
    pub(crate) sizes: &'static str,
    /// It is part of a program (a test), where others than the model may panic.
    is_program: bool,
    /// Is told of each panic, where a panic ends the library (a module of WebAssembly).
    tell_panic: Option<fn(&str)>,
}

impl Library {
    /// For one model.
    pub const fn new(is_program: bool, sizes: Option<&'static str>) -> Self {
        Self {
            sizes: match sizes {
                Some(sizes) => sizes,
                None => "",
            },
            hashes: [OnceLock::new(), OnceLock::new()],
            is_program,
            tell_panic: None,
        }
    }

    /// With a function that is told of each panic.
    #[cfg(target_arch = "wasm32")]
    pub(crate) const fn telling_panics(mut self, tell: fn(&str)) -> Self {
        self.tell_panic = Some(tell);
        self
    }

    /// Keeps panics from printing; to be called before a model is.
    pub(crate) fn silence_panics(&self) {
        panic::silence(self.is_program, self.tell_panic);
    }
}

/// The arguments of an instantiation.
pub(crate) struct Request<'a, V: Version> {
    /// Name of the FMI function that was called.
    pub(crate) function: &'static str,
    pub(crate) log: Log<V::Logger>,
    pub(crate) name: Option<&'a str>,
    /// Name and value of the argument that identifies the model (`fmuGUID`, `instantiationToken`).
    pub(crate) token: (&'static str, Option<&'a str>),
    /// Where the library stores the hash.
    pub(crate) hash: &'a OnceLock<Uuid>,
    pub(crate) sizes: &'static str,
    /// The resources folder; one that cannot be parsed is reported, and the FMU runs without it.
    pub(crate) resources: Option<Result<PathBuf, String>>,
    /// [`CS`] or [`ME`].
    pub(crate) interface: u16,
    pub(crate) version: V,
}

impl<V: Version> Request<'_, V> {
    /// Makes an instance; on failure returns NULL and logs the reason. If the token is wrong,
    /// `check` looks for a mistake in the table, for which there is no model description and so no
    /// token that an importer could know.
    pub(crate) fn instantiate<M: Model>(
        self,
        check: impl FnOnce(&Layout<M>, &StartValues<M>) -> Result<(), String>,
        prepare: impl FnOnce(&mut FmiInstance<M, V>) -> Result<(), String>,
    ) -> *mut c_void {
        let (function, log) = (self.function, Arc::new(self.log));
        let mut messages = Vec::new();
        let resources = self.resources.and_then(|folder| {
            let report = |reason: &String| {
                let text = format!("{function}: {reason}; the FMU runs without resources");
                messages.push(Message::new(Kind::Warning, text));
            };
            folder.inspect_err(report).ok()
        });
        let made = panic::catch(|| {
            let start = sizes::start::<M>(self.sizes)?;
            let layout = Layout::new(&start.0, &start.1);
            let known = || hash(&layout, &start, V::NAME);
            let hash = *self.hash.get_or_init(known);
            check_name(self.name)?;
            check_token(self.token, hash).map_err(|reason| match check(&layout, &start) {
                Ok(()) => reason,
                Err(wrong) => wrong,
            })?;
            let identity = Identity {
                version: match self.interface {
                    ME => [V::NAME[0], V::NAME[1], V::NAME[2], b'X'],
                    _ => V::NAME,
                },
                model: hash.into_bytes(),
            };
            let instance = Instance::new(layout, start, identity, &V::NAMES, resources, self.sizes);
            let mut fmi = FmiInstance {
                instance,
                log: Arc::clone(&log),
                strings: Vec::new(),
                bytes: Vec::new(),
                interface: self.interface,
                version: self.version,
            };
            fmi.instance.log_filter = fmi.log.model_filter();
            prepare(&mut fmi)?;
            fmi.instance.take_packed_files()?;
            messages.append(&mut fmi.instance.messages);
            Ok(Box::new(Exclusive::new(fmi)))
        });
        let (instance, status) = match made.unwrap_or_else(|panic| Err(panic.describe())) {
            Ok(fmi) => (Box::into_raw(fmi).cast(), Status::Ok),
            Err(reason) => {
                messages.push(refusal(function, &reason));
                (ptr::null_mut(), Status::Error)
            }
        };
        log.send(&messages, status);
        instance
    }
}

/// A C string as text; None for NULL.
///
/// # Safety
/// `s` is NULL or a C string that lives as long as the result is used.
pub(crate) unsafe fn text<'a>(s: *const c_char) -> Option<Cow<'a, str>> {
    // SAFETY: not NULL; the rest is forwarded.
    (!s.is_null()).then(|| unsafe { CStr::from_ptr(s) }.to_string_lossy())
}

/// A message that says why there is no instance.
pub(crate) fn refusal(function: &str, reason: &str) -> Message {
    Message::new(Kind::Refused, format!("{function}: {reason}"))
}

/// Refuses an instance without a name.
fn check_name(name: Option<&str>) -> Result<(), String> {
    match name {
        None => Err("instanceName = NULL must be a name".to_owned()),
        Some("") => Err("instanceName is empty; it must be a name".to_owned()),
        Some(_) => Ok(()),
    }
}

/// Refuses a hash that is not this FMU's.
fn check_token((argument, given): (&str, Option<&str>), hash: Uuid) -> Result<(), String> {
    // With or without braces, in upper or lower case.
    let read = given.and_then(|given| Uuid::try_parse(given.trim()).ok());
    if read == Some(hash) {
        return Ok(());
    }
    let given = given.unwrap_or("NULL");
    Err(format!("{argument} = {given} must be {{{hash}}}"))
}

/// Frees an instance. NULL is ignored, and so is an instance in use: a callback that is called
/// during a call cannot free its instance.
///
/// # Safety
/// `c` is NULL or came from the instantiation of this library in this version, and is not used
/// afterwards.
pub(crate) unsafe fn free<M: Model, V: Version>(c: *mut c_void) {
    let guard = c.cast::<Exclusive<FmiInstance<M, V>>>();
    // SAFETY: forwarded.
    let Some(fmi) = unsafe { guard.as_ref() }.and_then(Exclusive::enter) else {
        return;
    };
    if V::state(&fmi) == INTERMEDIATE_UPDATE {
        return;
    }
    fmi.log.close();
    drop(fmi);
    // SAFETY: made by `Request::instantiate` with `Box::into_raw`, and not in use.
    let guard = unsafe { Box::from_raw(guard) };
    // Only dropping the model can panic, and then there is no instance left to report it.
    let _ = panic::catch(|| drop(guard));
}
