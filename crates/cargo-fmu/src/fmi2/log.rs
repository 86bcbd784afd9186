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
    /// As it came: a printf format whose arguments are not looked at.
    pub format: String,
}

impl Message {
    /// What it prints: `%` and `#` stand doubled in the format.
    #[must_use]
    pub fn text(&self) -> String {
        self.format.replace("%%", "%").replace("##", "#")
    }
}

/// The messages of an instance.
#[derive(Debug, Default)]
pub struct Log(RefCell<Vec<Message>>);

impl Log {
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
        self.0.take()
    }
}

unsafe extern "C" fn logger(
    environment: Pointer,
    name: Text,
    status: c_int,
    category: Text,
    format: Text,
) {
    let string = |s: Text| match s.is_null() {
        true => String::new(),
        // SAFETY: a C string of the FMU.
        false => unsafe { CStr::from_ptr(s) }.to_string_lossy().into_owned(),
    };
    let message = Message {
        instance: string(name),
        status,
        category: string(category),
        format: string(format),
    };
    // SAFETY: the environment is the log of the instance, which outlives it.
    unsafe { &*environment.cast::<Log>() }
        .0
        .borrow_mut()
        .push(message);
}
