//! What all instances of a library share, and how an instance is made and freed.

use super::body::{Body, Version};
use super::call::U;
use super::description::hash;
use super::log::Log;
use crate::Model;
use crate::core::guard::Guarded;
use crate::core::instance::Instance;
use crate::core::layout::Layout;
use crate::core::message::{Kind, Message};
use crate::core::panic;
use crate::core::saved::Identity;
use libc::c_void;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use uuid::Uuid;

/// What all instances of a library share.
pub struct Library {
    /// Hashes of the model descriptions, once they have been computed: of FMI 2.0 and 3.0.
    pub(crate) hashes: [OnceLock<Uuid>; 2],
    /// It is part of a program (a test), where others than the model may panic.
    pub(crate) is_program: bool,
}

impl Library {
    /// For one model.
    pub const fn new(is_program: bool) -> Self {
        Self {
            hashes: [OnceLock::new(), OnceLock::new()],
            is_program,
        }
    }
}

/// What an importer says of a new instance.
pub(crate) struct Request<'a, V: Version> {
    pub(crate) log: Arc<Log<V::Logger>>,
    pub(crate) name: Option<&'a str>,
    /// Name of the argument by which importer and library agree on the model, and its value.
    pub(crate) token: (&'static str, Option<&'a str>),
    /// Where the hash is kept.
    pub(crate) hash: &'a OnceLock<Uuid>,
    pub(crate) resources: Option<PathBuf>,
    pub(crate) own: V,
}

impl<V: Version> Request<'_, V> {
    /// An instance, or why there is none. `check` says what is wrong with the table: then no importer can know the hash.
    pub(crate) fn make<M: Model>(
        self,
        check: impl FnOnce(&Layout<M>) -> Result<(), String>,
        prepare: impl FnOnce(&mut Body<M, V>) -> Result<(), String>,
    ) -> Result<*mut c_void, String> {
        let made = panic::catch(|| {
            let (parameters, input) = M::defaults();
            let layout = Layout::new(&parameters, &input);
            let known = || hash(&layout, (&parameters, &input), V::NAME);
            let hash = *self.hash.get_or_init(known);
            named(self.name)?;
            agreed(self.token, hash).map_err(|reason| match check(&layout) {
                Ok(()) => reason,
                Err(wrong) => wrong,
            })?;
            let identity = Identity {
                version: V::NAME,
                model: hash.into_bytes(),
            };
            let instance = Instance::new(
                layout,
                (parameters, input),
                identity,
                &V::NAMES,
                self.resources,
            );
            let mut body = Body {
                instance,
                log: self.log,
                strings: Vec::new(),
                own: self.own,
            };
            prepare(&mut body)?;
            Ok(Box::new(Guarded::new(body)))
        });
        let made = made.unwrap_or_else(|panic| Err(panic.describe()))?;
        Ok(Box::into_raw(made).cast())
    }
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

/// Frees an instance; NULL is ignored, and so is an instance in use: a logger that is called while its instance works cannot free it.
///
/// # Safety
/// `c` is NULL or came from the instantiation of this library in this version, and is not used afterwards.
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
