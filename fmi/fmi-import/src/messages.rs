//! The messages that FMUs have logged in this thread, for error texts and verdicts of the master,
//! and for its page. Messages that differ only in their numbers are counted, not repeated.
//!
//! FMUs log while they are called, so a list for each thread that calls instances separates systems
//! that run in parallel. FMUs may log in threads that they have made, too.
//!
//! ```
//! assert!(fmi_import::messages::take().is_empty());
//! ```

use std::ffi::c_int;
use std::sync::{Mutex, PoisonError};
use std::thread::{self, ThreadId};

use crate::status::{OK, WARNING};

/// Instance name of a message whose instance is not known.
pub const NOBODY: &str = "an FMU";

/// How many different warnings and failures are kept per thread; further ones are counted.
const MAX_KEPT: usize = 64;
/// The most bytes of a text that are kept.
pub(crate) const MAX_TEXT: usize = 4096;
const NOT_KEPT: &str = "further messages, which are not kept";

/// Messages with the thread that calls the instance.
static MESSAGES: Mutex<Vec<(ThreadId, Vec<Message>)>> = Mutex::new(Vec::new());

/// A message, or several that differ only in their numbers.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "master", derive(serde::Deserialize, serde::Serialize))]
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

/// Lets `change` see the messages of a thread; without messages it is forgotten afterwards.
fn with_messages<T>(owner: ThreadId, change: impl FnOnce(&mut Vec<Message>) -> T) -> T {
    let mut all = MESSAGES.lock().unwrap_or_else(PoisonError::into_inner);
    let place = all.iter().position(|(thread, _)| *thread == owner);
    let mut messages = place.map_or_else(Vec::new, |place| all.swap_remove(place).1);
    let result = change(&mut messages);
    if !messages.is_empty() {
        all.push((owner, messages));
    }
    result
}

/// Adds a text to the messages of this thread.
pub(crate) fn add(instance: &str, status: c_int, text: &str) {
    add_for(thread::current().id(), instance, status, text);
}

/// Adds a text to the messages of the thread `owner`, which may be another one.
pub(crate) fn add_for(owner: ThreadId, instance: &str, status: c_int, text: &str) {
    with_messages(owner, |messages| add_to(messages, instance, status, text));
}

fn add_to(messages: &mut Vec<Message>, instance: &str, status: c_int, text: &str) {
    let (is_warning, is_info) = (status <= WARNING, status == OK);
    let mut text = text[..text.floor_char_boundary(MAX_TEXT)].to_string();
    if text.len() > MAX_TEXT - 8 {
        text += " … (the rest is not kept)";
    }
    let mut instance = instance;
    let is_same = |m: &Message, instance: &str, text: &str| {
        let is_same_kind = m.is_warning == is_warning && m.is_info == is_info;
        m.instance == instance && is_same_kind && are_alike(&m.text, text)
    };
    if !messages.iter().any(|m| is_same(m, instance, &text)) {
        let kept = messages.iter().filter(|m| m.is_warning == is_warning);
        if kept.count() >= MAX_KEPT {
            (instance, text) = (NOBODY, NOT_KEPT.to_string());
        }
    }
    if let Some(message) = messages.iter_mut().find(|m| is_same(m, instance, &text)) {
        message.count += 1;
        if !is_warning {
            message.text = text;
        }
        return;
    }
    messages.push(Message {
        instance: instance.to_string(),
        is_warning,
        is_info,
        text,
        count: 1,
    });
}

/// Adds messages that were logged in another thread.
pub fn extend(others: Vec<Message>) {
    with_messages(thread::current().id(), |messages| messages.extend(others));
}

/// The messages of this thread since [`take`] was called last.
pub fn present() -> Vec<Message> {
    with_messages(thread::current().id(), |messages| messages.clone())
}

/// Removes and returns the messages of this thread.
pub fn take() -> Vec<Message> {
    with_messages(thread::current().id(), std::mem::take)
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

    /// There are at most so many warnings and failures, of at most so many bytes; a flood of
    /// warnings hides no failure.
    #[test]
    fn a_flood_is_counted() {
        // Without `e`, which may belong to a number.
        let word = |k: u32| String::from_utf8(vec![b'f' + (k % 20) as u8; 1 + k as usize / 20]);
        (0..1000).for_each(|k| add("a", WARNING, &word(k).unwrap()));
        add("a", 3, &"ä".repeat(MAX_TEXT));
        let all = take();
        assert_eq!(all.len(), MAX_KEPT + 2);
        assert_eq!(
            all[MAX_KEPT].to_string(),
            format!("an FMU: {NOT_KEPT} (936 times)")
        );
        assert!(all[MAX_KEPT + 1].text.len() < MAX_TEXT + 50);
    }

    /// A thread that an FMU has made logs for the thread that calls the instance.
    #[test]
    fn messages_of_other_threads_arrive() {
        let own = thread::current().id();
        thread::spawn(move || add_for(own, "a", 3, "from a thread"))
            .join()
            .unwrap();
        assert_eq!(reasons("a"), ["from a thread"]);
        assert!(take().is_empty());
    }
}
