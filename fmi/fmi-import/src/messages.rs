//! What the FMUs of a run say, kept for the error texts and for the verdict of the run: messages
//! that differ in their numbers only are counted.
//!
//! FMUs log while they are being called, so a buffer per thread keeps apart what several systems in
//! several threads say.

use std::cell::RefCell;

/// Name that a message gets whose FMU does not say whose it is.
pub const NOBODY: &str = "an FMU";

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
pub fn extend(others: Vec<Message>) {
    MESSAGES.with_borrow_mut(|messages| messages.extend(others));
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
pub fn reasons(instance: &str) -> Vec<String> {
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
