//! What the FMUs say through their logger callback, kept for the error texts and for the verdict of
//! a run.
//!
//! FMUs log while they are being called, so a buffer per thread keeps apart what several systems in
//! several threads say. An FMU hands back the environment that it was given; it is looked up, not
//! trusted.
#![allow(unsafe_code)]

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Name that a message gets whose FMU does not say whose it is.
pub(crate) const NOBODY: &str = "an FMU";

/// Kinds of messages kept per thread; further ones are dropped.
const KEPT: usize = 64;

thread_local! {
    static MESSAGES: RefCell<Vec<Message>> = const { RefCell::new(Vec::new()) };
}

/// A logger message, or several that differ in their numbers only.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Instance that said it.
    pub instance: String,
    /// A warning, not the reason of a failure.
    pub is_warning: bool,
    /// Its text: the first of several warnings, the last of several reasons.
    pub text: String,
    /// How often it came.
    pub count: u64,
}

impl std::fmt::Display for Message {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.instance, self.text)?;
        if self.count > 1 {
            write!(f, " ({} times)", self.count)?;
        }
        Ok(())
    }
}

/// True for texts that differ in their numbers only.
fn are_alike(a: &str, b: &str) -> bool {
    let bare = |c: &char| !(c.is_ascii_digit() || "+-.e".contains(*c));
    a.chars().filter(bare).eq(b.chars().filter(bare))
}

/// Keep a message.
pub(crate) fn add(instance: &str, is_warning: bool, text: &str) {
    MESSAGES.with_borrow_mut(|messages| {
        let same = |m: &&mut Message| {
            m.instance == instance && m.is_warning == is_warning && are_alike(&m.text, text)
        };
        if let Some(message) = messages.iter_mut().find(same) {
            message.count += 1;
            if !is_warning {
                message.text = text.to_string();
            }
        } else if messages.len() < KEPT {
            messages.push(Message {
                instance: instance.to_string(),
                is_warning,
                text: text.to_string(),
                count: 1,
            });
        }
    });
}

/// Keep what was said in another thread.
#[cfg(feature = "native")]
pub(crate) fn extend(others: Vec<Message>) {
    MESSAGES.with_borrow_mut(|messages| messages.extend(others));
}

/// Names of the living instances, by the number that each has as its environment.
static NAMES: Mutex<BTreeMap<usize, String>> = Mutex::new(BTreeMap::new());

/// An instance as the logger knows it, for as long as it lives.
#[derive(Debug)]
pub(super) struct Speaker(usize);

impl Speaker {
    /// Of the instance `name`.
    pub fn new(name: &CStr) -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(1);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        if let Ok(mut names) = NAMES.lock() {
            names.insert(number, name.to_string_lossy().into_owned());
        }
        Self(number)
    }

    /// What the FMU is given as its environment: a number, nothing that could be read.
    pub fn environment(&self) -> *mut c_void {
        std::ptr::without_provenance_mut(self.0)
    }
}

impl Drop for Speaker {
    fn drop(&mut self) {
        if let Ok(mut names) = NAMES.lock() {
            names.remove(&self.0);
        }
    }
}

/// The logger of FMI 3.0.
pub(super) unsafe extern "C" fn receive_3(
    environment: *mut c_void,
    status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    if !message.is_null() {
        // SAFETY: the message is a C string of the FMU.
        let message = unsafe { CStr::from_ptr(message) };
        receive(environment.addr(), status, &message.to_string_lossy());
    }
}

/// A message of an instance with this environment. What is not a warning is a reason.
pub fn receive(environment: usize, status: c_int, text: &str) {
    let name = NAMES.lock().ok();
    let name = name.and_then(|names| names.get(&environment).cloned());
    let name = name.as_deref().unwrap_or(NOBODY);
    add(name, status <= 1, text.trim_end());
}

/// What was said in this thread since it was last taken.
pub fn present() -> Vec<Message> {
    MESSAGES.with_borrow(Clone::clone)
}

/// Take what was said in this thread since the last call.
pub fn take() -> Vec<Message> {
    MESSAGES.take()
}

/// The reasons that the instance has logged, else its warnings, each once.
pub(super) fn reasons(instance: &str) -> Vec<String> {
    let mut messages = take();
    messages.retain(|m| m.instance == instance || m.instance == NOBODY);
    if messages.iter().any(|m| !m.is_warning) {
        messages.retain(|m| !m.is_warning);
    }
    let mut texts: Vec<_> = messages.into_iter().map(|m| m.text).collect();
    texts.dedup();
    texts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_that_differ_in_numbers_are_counted() {
        for t in ["0.1", "0.2", "1e-3"] {
            add("a", true, &format!("hot at t = {t} s"));
            add("a", false, &format!("burnt at t = {t} s"));
        }
        add("b", true, "hot at t = 0.1 s");
        let texts: Vec<_> = take().iter().map(ToString::to_string).collect();
        let times = "(3 times)";
        assert_eq!(
            texts,
            [
                format!("a: hot at t = 0.1 s {times}"),
                format!("a: burnt at t = 1e-3 s {times}"),
                "b: hot at t = 0.1 s".into()
            ]
        );
        assert!(take().is_empty());
    }
}
