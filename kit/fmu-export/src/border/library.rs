//! What all instances of a library share, and how an instance is made and freed.

use super::answer::Answer;
use super::body::{Body, Version};
use super::call::{ME, U};
use super::description::hash;
use super::log::Log;
use crate::Model;
use crate::core::guard::Guarded;
use crate::core::instance::Instance;
use crate::core::layout::Layout;
use crate::core::message::{Kind, Message};
use crate::core::panic;
use crate::core::sizes::{self, Start};
use crate::core::state::Identity;
use std::borrow::Cow;
use std::ffi::{CStr, c_char, c_void};
use std::path::PathBuf;
use std::ptr;
use std::sync::{Arc, OnceLock};
use uuid::Uuid;

/// What all instances of a library share.
pub struct Library {
    /// Hashes of the model descriptions, once they have been computed: of FMI 2.0 and 3.0.
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

/// What an importer says of a new instance.
pub(crate) struct Request<'a, V: Version> {
    /// Name of the function that was called.
    pub(crate) function: &'static str,
    pub(crate) log: Log<V::Logger>,
    pub(crate) name: Option<&'a str>,
    /// Name of the argument by which importer and library agree on the model, and its value.
    pub(crate) token: (&'static str, Option<&'a str>),
    /// Where the hash is kept.
    pub(crate) hash: &'a OnceLock<Uuid>,
    pub(crate) sizes: &'static str,
    /// The folder of resources; one that cannot be understood is reported and done without.
    pub(crate) resources: Option<Result<PathBuf, String>>,
    /// [`CS`] or [`ME`].
    pub(crate) interface: u16,
    pub(crate) own: V,
}

impl<V: Version> Request<'_, V> {
    /// An instance; NULL if there is none, of which the importer's logger hears why. `check` says
    /// what is wrong with the table: then no importer can know the hash.
    pub(crate) fn make<M: Model>(
        self,
        check: impl FnOnce(&Layout<M>, &Start<M>) -> Result<(), String>,
        prepare: impl FnOnce(&mut Body<M, V>) -> Result<(), String>,
    ) -> *mut c_void {
        let (function, log) = (self.function, Arc::new(self.log));
        let mut messages = Vec::new();
        let resources = self.resources.and_then(|folder| {
            let report = |reason: &String| {
                let text = format!("{function}: {reason}; going on without");
                messages.push(Message::new(Kind::Warning, text));
            };
            folder.inspect_err(report).ok()
        });
        let made = panic::catch(|| {
            let start = sizes::start::<M>(self.sizes)?;
            let layout = Layout::new(&start.0, &start.1);
            let known = || hash(&layout, &start, V::NAME);
            let hash = *self.hash.get_or_init(known);
            named(self.name)?;
            agreed(self.token, hash).map_err(|reason| match check(&layout, &start) {
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
            let mut body = Body {
                instance,
                log: Arc::clone(&log),
                strings: Vec::new(),
                bytes: Vec::new(),
                interface: self.interface,
                own: self.own,
            };
            body.instance.wanted = body.log.wanted_of_model();
            prepare(&mut body)?;
            Ok(Box::new(Guarded::new(body)))
        });
        let (instance, answer) = match made.unwrap_or_else(|panic| Err(panic.describe())) {
            Ok(body) => (Box::into_raw(body).cast(), Answer::Ok),
            Err(reason) => {
                messages.push(refusal(function, &reason));
                (ptr::null_mut(), Answer::Error)
            }
        };
        log.send(&messages, answer);
        instance
    }
}

/// A text of C, if there is one.
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
fn named(name: Option<&str>) -> Result<(), String> {
    match name {
        None => Err("instanceName = NULL must be a name".to_owned()),
        Some("") => Err("instanceName is empty; it must be a name".to_owned()),
        Some(_) => Ok(()),
    }
}

/// Refuses a hash that is not this FMU's.
fn agreed((argument, given): (&str, Option<&str>), hash: Uuid) -> Result<(), String> {
    if given.is_some_and(|given| is_same(given, hash)) {
        return Ok(());
    }
    let given = given.unwrap_or("NULL");
    Err(format!("{argument} = {given} must be {{{hash}}}"))
}

/// Hashes are compared as numbers: with or without braces, in either case.
fn is_same(given: &str, hash: Uuid) -> bool {
    Uuid::try_parse(given.trim()).is_ok_and(|given| given == hash)
}

/// Frees an instance; NULL is ignored, and so is an instance in use: a logger that is called while
/// its instance works cannot free it.
///
/// # Safety
/// `c` is NULL or came from the instantiation of this library in this version, and is not used
/// afterwards.
pub(crate) unsafe fn free<M: Model, V: Version>(c: *mut c_void) {
    let component = c.cast::<Guarded<Body<M, V>>>();
    // SAFETY: forwarded.
    let Some(body) = unsafe { component.as_ref() }.and_then(Guarded::enter) else {
        return;
    };
    if V::state(&body) == U {
        return;
    }
    body.log.close();
    drop(body);
    // SAFETY: made by `Request::make` with `Box::into_raw`, and not in use.
    let component = unsafe { Box::from_raw(component) };
    // Only the drop of a model can panic; there is nobody left to tell.
    let _ = panic::catch(|| drop(component));
}
