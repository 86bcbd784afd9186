//! Error texts for failed calls of an `Instance`: which instance and FMU, at which time, which
//! variables, and the reasons that the FMU logged.

use anyhow::{Error, Result, anyhow};
use fmi_description::Version;

use fmi_import::answer::{Answer, LateAnswer};
use fmi_import::batch::Batch;
use fmi_import::{messages, status};

use super::{At, Instance};

impl Instance {
    #[inline]
    pub(super) fn check<T>(&self, done: Result<T>, batch: Option<&Batch>, at: At) -> Result<T> {
        done.map_err(|error| self.error(error, batch, at))
    }

    #[cold]
    pub(crate) fn error(&self, error: Error, batch: Option<&Batch>, at: At) -> Error {
        if let Some(LateAnswer { answer, batch }) = error.downcast_ref() {
            return self.error((*answer).into(), Some(batch), at);
        }
        let answer = match error.downcast::<Answer>() {
            Ok(answer) => answer,
            Err(error) => return error.context(self.location(at)),
        };
        let variables = &self.fmu.description.variables;
        let names = batch.into_iter().flat_map(|batch| &batch.variables);
        let names: Vec<_> = names.map(|k| variables[*k].name.as_str()).collect();
        let call = match names.as_slice() {
            [] => answer.call.to_string(),
            [first, second, third, rest @ ..] if rest.len() > 1 => {
                let (call, more) = (answer.call, rest.len());
                format!("{call} of {first}, {second}, {third} and {more} more")
            }
            names => format!("{} of {}", answer.call, names.join(", ")),
        };
        self.refused(answer, &call, at)
    }

    pub(super) fn refused(&self, answer: Answer, call: &str, at: At) -> Error {
        let (name, file) = (&self.name, &self.fmu.file);
        let version = match self.fmu.description.fmi {
            Version::Fmi2 => "fmi2",
            Version::Fmi3 => "fmi3",
        };
        let result = match answer.status {
            status::ABSENT => {
                let function = answer.call;
                return anyhow!(
                    "{name} (FMU `{file}`): its library does not export {function}, which is needed {at}"
                );
            }
            status::UNFIT => {
                return anyhow!(
                    "{name} (FMU `{file}`): {call} {at}: a value is outside of the range of its type"
                );
            }
            status::NO_TEXT | status::NO_BYTES => {
                let what = status::name(answer.status);
                return anyhow!("{name} (FMU `{file}`): {call} {at} gave {what}");
            }
            status::DISCARD => format!("{version}Discard"),
            3 => format!("{version}Error"),
            4 => format!("{version}Fatal"),
            other => format!("the unknown status {other}"),
        };
        let reasons = messages::reasons(name);
        match reasons.is_empty() {
            true => anyhow!("{name} (FMU `{file}`): {call} {at} returned {result}"),
            false => anyhow!(
                "{name}: {}\n  (FMU `{file}`: {call} {at} returned {result})",
                reasons.join("\n  ")
            ),
        }
    }

    pub(super) fn location(&self, at: At) -> String {
        format!("{} (FMU `{}`) {at}", self.name, self.fmu.file)
    }
}
