//! What an FMU says to its importer's logger.

use super::functions::{Callbacks, Pointer, Text};
use std::cell::RefCell;
use std::ffi::{CStr, c_int};
use std::ptr;

/// A message as the logger got it.
#[derive(Clone, Debug)]
pub struct Message {
    /// Instance that it is said to come from.
    pub instance: String,
    /// Status.
    pub status: c_int,
    /// Category.
    pub category: String,
    /// As it came: in FMI 2.0 a printf format whose arguments are not looked at.
    pub format: String,
    /// A text, in which nothing is doubled (FMI 3.0).
    pub is_plain: bool,
}

impl Message {
    /// What it prints: `%` and `#` stand doubled in the format.
    #[must_use]
    pub fn text(&self) -> String {
        match self.is_plain {
            true => self.format.clone(),
            false => self.format.replace("%%", "%").replace("##", "#"),
        }
    }
}

/// The messages of an instance.
#[derive(Debug, Default)]
pub struct Log {
    messages: RefCell<Vec<Message>>,
    /// Of the instance, which a logger of FMI 3.0 is not told.
    name: String,
}

impl Log {
    /// Of the instance with this name.
    pub fn new(name: &str) -> Self {
        Self {
            messages: RefCell::default(),
            name: name.to_string(),
        }
    }

    /// Callbacks whose logger writes here, without memory functions. The log must outlive the instance and stay where it is.
    pub fn callbacks(&self) -> Callbacks {
        Callbacks {
            logger: Some(logger),
            allocate_memory: None,
            free_memory: None,
            step_finished: ptr::null_mut(),
            environment: ptr::from_ref(self).cast_mut().cast(),
        }
    }

    /// Messages since the last call of this function.
    pub fn take(&self) -> Vec<Message> {
        self.messages.take()
    }
}

/// The logger of FMI 3.0, which does not say which instance speaks; a message is a text, which has nothing doubled.
pub(super) unsafe extern "C" fn callback_3(
    environment: Pointer,
    status: c_int,
    category: Text,
    message: Text,
) {
    if environment.is_null() {
        return;
    }
    // SAFETY: the environment is the log of the instance, which outlives it; C strings of the FMU.
    unsafe {
        let log = &*environment.cast::<Log>();
        let message = Message {
            instance: log.name.clone(),
            status,
            category: string(category),
            format: string(message),
            is_plain: true,
        };
        log.messages.borrow_mut().push(message);
    }
}

unsafe fn string(s: Text) -> String {
    match s.is_null() {
        true => String::new(),
        // SAFETY: a C string.
        false => unsafe { CStr::from_ptr(s) }.to_string_lossy().into_owned(),
    }
}

unsafe extern "C" fn logger(
    environment: Pointer,
    name: Text,
    status: c_int,
    category: Text,
    format: Text,
) {
    // SAFETY: C strings of the FMU, and the log of the instance, which outlives it.
    unsafe {
        let message = Message {
            instance: string(name),
            status,
            category: string(category),
            format: string(format),
            is_plain: false,
        };
        let log = &*environment.cast::<Log>();
        log.messages.borrow_mut().push(message);
    }
}
