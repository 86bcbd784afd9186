//! The messages that FMUs have logged in this thread, for error texts and verdicts of the master,
//! and for its page. Messages that differ only in their numbers are counted, not repeated.
//!
//! FMUs log while they are called, so a buffer for each thread separates systems that run in
//! parallel.
//!
//! ```
//! assert!(fmi_import::messages::take().is_empty());
//! ```

use std::cell::RefCell;
use std::ffi::c_int;

use crate::status::{OK, WARNING};

/// Instance name of a message whose instance is not known.
pub const NOBODY: &str = "an FMU";

/// How many different messages are kept per thread; further ones are dropped.
const MAX_KEPT: usize = 64;

thread_local! {
    static MESSAGES: RefCell<Vec<Message>> = const { RefCell::new(Vec::new()) };
}

/// A message, or several that differ only in their numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Name of the instance that logged it.
    pub instance: String,
    /// It is no more than a warning, not the reason of a failure.
    pub is_warning: bool,
    /// It has the status OK: it tells what the FMU does, and nothing that a verdict needs.
    pub is_info: bool,
    /// The text: of several warnings the first, of several failures the last.
    pub text: String,
    /// How often it was logged.
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

fn are_alike(a: &str, b: &str) -> bool {
    let bare = |c: &char| !(c.is_ascii_digit() || "+-.e".contains(*c));
    a.chars().filter(bare).eq(b.chars().filter(bare))
}

pub(crate) fn add(instance: &str, status: c_int, text: &str) {
    let (is_warning, is_info) = (status <= WARNING, status == OK);
    MESSAGES.with_borrow_mut(|messages| {
        let is_same_kind = |m: &Message| m.is_warning == is_warning && m.is_info == is_info;
        let same = |m: &&mut Message| {
            m.instance == instance && is_same_kind(m) && are_alike(&m.text, text)
        };
        if let Some(message) = messages.iter_mut().find(same) {
            message.count += 1;
            if !is_warning {
                message.text = text.to_string();
            }
        } else if messages.len() < MAX_KEPT {
            messages.push(Message {
                instance: instance.to_string(),
                is_warning,
                is_info,
                text: text.to_string(),
                count: 1,
            });
        }
    });
}

/// Adds messages that were logged in another thread.
pub fn extend(others: Vec<Message>) {
    MESSAGES.with_borrow_mut(|messages| messages.extend(others));
}

/// The messages of this thread since [`take`] was called last.
pub fn present() -> Vec<Message> {
    MESSAGES.with_borrow(Clone::clone)
}

/// Removes and returns the messages of this thread.
pub fn take() -> Vec<Message> {
    MESSAGES.take()
}

/// Removes the messages of this thread; returns those of an instance that say why a call failed, or
/// if there are none its warnings, or else what it said of itself.
pub fn reasons(instance: &str) -> Vec<String> {
    let mut messages = take();
    messages.retain(|m| m.instance == instance || m.instance == NOBODY);
    if messages.iter().any(|m| !m.is_warning) {
        messages.retain(|m| !m.is_warning);
    } else if messages.iter().any(|m| !m.is_info) {
        messages.retain(|m| !m.is_info);
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
            add("a", WARNING, &format!("hot at t = {t} s"));
            add("a", 3, &format!("burnt at t = {t} s"));
        }
        add("b", WARNING, "hot at t = 0.1 s");
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
