//! What the FMUs say through their logger callback, kept for the error texts.
//!
//! `fmi-sys` formats a message in C (stable Rust cannot define a variadic function) and hands it to the `log` crate with the instance's
//! name as target; it does so whatever the maximum level is. FMUs log while they are being called, so a buffer per thread keeps apart
//! what several systems in several threads say.

use std::cell::RefCell;
use std::sync::Once;

/// Messages kept per thread; older ones are dropped.
const KEPT: usize = 64;

thread_local! {
    static MESSAGES: RefCell<Vec<Message>> = const { RefCell::new(Vec::new()) };
}

/// One logger message.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Instance that said it.
    pub instance: String,
    /// Its text.
    pub text: String,
}

struct Collector;

impl log::Log for Collector {
    fn enabled(&self, _: &log::Metadata) -> bool {
        true
    }

    fn log(&self, record: &log::Record) {
        // The marker of `fmi-sys`'s callback; other crates' records are not FMU messages.
        if record.module_path() != Some("logger") {
            return;
        }
        MESSAGES.with_borrow_mut(|messages| {
            if messages.len() == KEPT {
                messages.remove(0);
            }
            let text = record.args().to_string();
            messages.push(Message {
                instance: record.target().to_string(),
                text: text.trim_end().to_string(),
            });
        });
    }

    fn flush(&self) {}
}

/// Start collecting; further calls do nothing. An application that has installed a logger of its own keeps it and gets the messages.
pub fn collect() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Fails where the application has a logger already; then that one receives the records.
        let _ = log::set_logger(&Collector);
    });
}

/// Take what was said in this thread since the last call.
pub fn take() -> Vec<Message> {
    MESSAGES.take()
}
