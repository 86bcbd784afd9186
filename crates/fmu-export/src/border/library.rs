//! What all instances of a library share, and how an instance is made and freed.

use super::body::{Body, Version};
use super::call::U;
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
    /// Where the hash is kept, and what makes it.
    pub(crate) hash: &'a OnceLock<Uuid>,
    pub(crate) resources: Option<PathBuf>,
    pub(crate) own: V,
}

impl<V: Version> Request<'_, V> {
    /// An instance, or why there is none.
    pub(crate) fn make<M: Model>(
        self,
        describe: impl FnOnce(&Layout<M>) -> Result<Uuid, String>,
        prepare: impl FnOnce(&mut Body<M, V>) -> Result<(), String>,
    ) -> Result<*mut c_void, String> {
        let made = panic::catch(|| {
            let layout = Layout::<M>::new();
            let hash = match self.hash.get() {
                Some(hash) => *hash,
                None => {
                    let hash = describe(&layout)?;
                    *self.hash.get_or_init(|| hash)
                }
            };
            check(self.name, self.token, hash)?;
            let identity = Identity {
                version: V::NAME,
                model: hash.into_bytes(),
            };
            let instance = Instance::<M>::new(layout, identity, &V::NAMES, self.resources);
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

/// Refuses arguments that are not meant for this FMU.
fn check(
    name: Option<&str>,
    (argument, given): (&str, Option<&str>),
    hash: Uuid,
) -> Result<(), String> {
    match name {
        None => return Err("instanceName = NULL must be a name".to_owned()),
        Some("") => return Err("instanceName is empty; it must be a name".to_owned()),
        Some(_) => {}
    }
    match given {
        Some(given) if is_same(given, hash) => Ok(()),
        given => Err(format!(
            "{argument} = {} must be {{{hash}}}",
            given.unwrap_or("NULL")
        )),
    }
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
