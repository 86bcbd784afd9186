//! The oracle of `torture calls`: which statuses a call may return, by the standard and the model
//! description, and the check of its status and messages.

use crate::subject::{CATEGORIES, Subject};
use anyhow::{Context, Result, anyhow, ensure};
use fmi_import::log::Message;
use fmi_import::status::{DISCARD, ERROR, OK, WARNING};
use std::ffi::c_int;

/// Statuses that a call may return.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expect {
    /// fmi2OK only.
    Done,
    /// fmi2Error only.
    Refused,
    /// fmi2Discard only.
    Discarded,
    /// A step, which may be discarded.
    Step,
    /// A step that may pass the stop time, or starts nearly at the present time.
    StepOrRefused,
    /// fmi2OK, or fmi2Error where the model finds the values together impossible.
    ModelDecides,
    /// As before, or fmi2Discard where a file holds a value out of its bounds.
    FileDecides,
    /// fmi3Error or fmi3Discard: several arguments are wrong.
    RefusedOrDiscarded,
}

impl Expect {
    /// `Done` if `sound`, else `Refused`.
    pub fn done_if(sound: bool) -> Self {
        if sound { Self::Done } else { Self::Refused }
    }

    fn allows(self, status: c_int) -> bool {
        match self {
            Self::Done => status == OK,
            Self::Refused => status == ERROR,
            Self::Discarded => status == DISCARD,
            Self::Step => matches!(status, OK | DISCARD),
            Self::StepOrRefused => matches!(status, OK | DISCARD | ERROR),
            Self::ModelDecides => matches!(status, OK | ERROR),
            Self::FileDecides => matches!(status, OK | ERROR | DISCARD),
            Self::RefusedOrDiscarded => matches!(status, ERROR | DISCARD),
        }
    }
}

/// A call that was made.
pub struct Call {
    /// Name of the C function.
    pub name: &'static str,
    pub status: c_int,
    pub expect: Expect,
    /// Names of the variables in its arguments: a refusal must name one of them. Empty where the
    /// arguments are wrong as such.
    pub variables: Vec<String>,
    /// Called with `c` = NULL.
    pub without_instance: bool,
}

/// Checks status and messages of a call.
pub fn judge(instance: &Subject, call: &Call) -> Result<()> {
    let messages = instance.messages();
    let Call { name, status, .. } = call;
    let judged = judge_by(&messages, instance, call);
    judged.map_err(|what| anyhow!("{name} gave {status}: {what}; log: {messages:?}"))
}

fn judge_by(messages: &[Message], instance: &Subject, call: &Call) -> Result<()> {
    let Call { name, status, .. } = *call;
    ensure!(call.expect.allows(status), "must be {:?}", call.expect);
    for message in messages {
        check(instance, message, status)?;
    }
    let Some(category) = category(status).filter(|_| status != OK && !call.without_instance) else {
        return Ok(());
    };
    if !instance.expects(category) {
        let is_sent = messages.iter().any(|m| m.category == category);
        ensure!(!is_sent, "a message that was not asked for");
        return Ok(());
    }
    let message = messages.iter().find(|m| m.status == status);
    let text = message.context("no message tells why")?.text();
    let is_named = text.starts_with(&format!("{name}: "));
    ensure!(is_named, "the message does not name the function");
    let is_number = !READS.contains(&name) || !text.contains(" became ");
    ensure!(is_number, "an output is no number");
    // The message may name an element of an array.
    let named = |v: &String| {
        let stem = v.strip_suffix(')').unwrap_or(v); // `der(x[1])` is an element of `der(x)`
        text.contains(&format!("`{v}`")) || text.contains(&format!("`{stem}["))
    };
    ensure!(
        call.variables.is_empty() || call.variables.iter().any(named),
        "the message names none of the variables {:?}",
        call.variables
    );
    Ok(())
}

/// Functions that read values. (A step, or a derivative for a huge seed, may overflow.)
const READS: [&str; 7] = [
    "fmi2GetReal",
    "fmi2GetInteger",
    "fmi2GetBoolean",
    "fmi3GetFloat64",
    "fmi3GetInt32",
    "fmi3GetInt64",
    "fmi3GetBoolean",
];

/// Checks category, status, name and text of a message.
fn check(instance: &Subject, message: &Message, status: c_int) -> Result<()> {
    let (declared, category) = (&instance.fmu.description.log_categories, &message.category);
    let is_declared = declared.contains(category);
    ensure!(is_declared, "category `{category}` is not declared");
    // In FMI 3.0 the status of a message must be no worse than that of the call, so a warning in a
    // call that is done has the status OK.
    let is_mild = message.is_plain && message.status == OK && category == "logStatusWarning";
    ensure!(
        is_mild || self::category(message.status) == Some(category),
        "status and category of a message do not fit"
    );
    ensure!(
        message.status == status || message.status <= WARNING,
        "status of a message is not that of the call"
    );
    let sound =
        message.instance == instance.name && (message.is_plain || is_plain(&message.format));
    let is_whole = sound && !message.format.is_empty();
    ensure!(is_whole, "name, format or text of a message");
    Ok(())
}

/// Whether a format asks for no arguments and names no value reference: `%` and `#` only in pairs.
fn is_plain(format: &str) -> bool {
    let rest = format.replace("%%", "").replace("##", "");
    !rest.contains(['%', '#'])
}

/// The category that belongs to a status.
fn category(status: c_int) -> Option<&'static str> {
    CATEGORIES.get(usize::try_from(status).ok()?).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Never fmi2Warning, fmi2Fatal or fmi2Pending, and of the rest what each expectation says.
    #[test]
    fn answers_are_allowed_by_kind() {
        let allowed = |e: Expect| (0..6).filter(|s| e.allows(*s)).collect::<Vec<_>>();
        assert_eq!(allowed(Expect::Done), [OK]);
        assert_eq!(allowed(Expect::Refused), [ERROR]);
        assert_eq!(allowed(Expect::Discarded), [DISCARD]);
        assert_eq!(allowed(Expect::Step), [OK, DISCARD]);
        assert_eq!(allowed(Expect::StepOrRefused), [OK, DISCARD, ERROR]);
        assert_eq!(allowed(Expect::ModelDecides), [OK, ERROR]);
        assert_eq!(allowed(Expect::FileDecides), [OK, DISCARD, ERROR]);
        assert_eq!(Expect::done_if(true), Expect::Done);
        assert_eq!(Expect::done_if(false), Expect::Refused);
    }

    #[test]
    fn statuses_have_their_categories() {
        assert_eq!(category(DISCARD), Some("logStatusDiscard"));
        assert_eq!(category(ERROR), Some("logStatusError"));
        assert_eq!(category(4), Some("logStatusFatal"));
        assert_eq!((category(5), category(-1)), (None, None));
    }
}
