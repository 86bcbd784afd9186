//! Collects the errors that the checks of a machine's sections find, so that users see all at once.

use std::fmt::Display;
use thiserror::Error;

/// Why a machine file was refused.
#[derive(Debug, Error)]
pub enum MachineError {
    /// Not JSON.
    #[error("machine JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A file that cannot be read, or an unknown machine in `extends`.
    #[error("{0}")]
    Source(String),
    /// An error in the machine that the file extends.
    #[error("`extends` = \"{name}\": {error}")]
    Base {
        /// Value of the key `extends`.
        name: String,
        /// The error in that machine.
        error: Box<MachineError>,
    },
    /// Fields that are unknown, missing or of another type, and values outside their ranges.
    #[error("{}", joined(.0))]
    Findings(Vec<Finding>),
}

/// One error in a machine file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{name}` {problem}")]
pub struct Finding {
    /// Path of the field, with dots; elements of arrays are counted from 1.
    pub name: String,
    /// What is wrong with it.
    pub problem: String,
}

fn joined(findings: &[Finding]) -> String {
    let texts: Vec<_> = findings.iter().map(Finding::to_string).collect();
    texts.join("; ")
}

impl MachineError {
    /// All that is wrong, one line each.
    pub fn lines(&self) -> Vec<String> {
        match self {
            Self::Findings(findings) => findings.iter().map(Finding::to_string).collect(),
            Self::Base { name, error } => {
                let lines = error.lines();
                let in_base = |line| format!("`extends` = \"{name}\": {line}");
                lines.into_iter().map(in_base).collect()
            }
            other => vec![other.to_string()],
        }
    }
}

/// Checks fields of a section, each with the method of [`Findings`] that it is listed under.
macro_rules! examine {
    ($found:ident, $section:literal of $of:expr; $($check:ident: $($field:ident)*;)*) => {
        let of = $of;
        $($($found.$check(concat!($section, ".", stringify!($field)), of.$field);)*)*
    };
}
pub(crate) use examine;

/// The errors found so far.
#[derive(Default)]
pub(crate) struct Findings {
    pub(crate) list: Vec<Finding>,
}

impl Findings {
    /// Runs `examine`; the error has all findings.
    pub(crate) fn collect(examine: impl FnOnce(&mut Self)) -> Result<(), MachineError> {
        let mut found = Self::default();
        examine(&mut found);
        found.result()
    }

    /// An error if something was found.
    pub(crate) fn result(self) -> Result<(), MachineError> {
        if self.list.is_empty() {
            return Ok(());
        }
        Err(MachineError::Findings(self.list))
    }

    /// Drops findings that only follow from the first `of_shape` ones, which are about missing and
    /// unusable fields: those about the same fields, which were replaced by the reference machine's
    /// values, and those about the start pose, whose range depends on other fields.
    pub(crate) fn drop_consequences(&mut self, of_shape: usize) {
        let of_values = self.list.split_off(of_shape);
        let is_own = |finding: &Finding| {
            let mut named = self.list.iter().map(|f| f.name.as_str());
            of_shape == 0
                || !(finding.name.starts_with("start.")
                    || named.any(|name| finding.name.starts_with(name)))
        };
        let own: Vec<_> = of_values.into_iter().filter(is_own).collect();
        self.list.extend(own);
    }

    pub(crate) fn add(&mut self, name: impl Display, problem: impl Display) {
        self.list.push(Finding {
            name: name.to_string(),
            problem: problem.to_string(),
        });
    }

    /// Adds "`name` = `value` must be `rule`".
    pub(crate) fn refuse(&mut self, name: impl Display, value: impl Display, rule: impl Display) {
        self.add(name, format_args!("= {value} must be {rule}"));
    }

    pub(crate) fn positive(&mut self, name: impl Display, value: f64) {
        if !(value.is_finite() && value > 0.0) {
            self.refuse(name, value, "finite and > 0");
        }
    }

    pub(crate) fn not_negative(&mut self, name: impl Display, value: f64) {
        if !(value.is_finite() && value >= 0.0) {
            self.refuse(name, value, "finite and ≥ 0");
        }
    }

    pub(crate) fn finite(&mut self, name: impl Display, values: impl AsRef<[f64]>) {
        if let Some(value) = values.as_ref().iter().find(|v| !v.is_finite()) {
            self.refuse(name, value, "finite");
        }
    }

    /// A closed interval, `[min, max]` with min < max.
    pub(crate) fn interval(&mut self, name: impl Display, [min, max]: [f64; 2]) {
        if !(min.is_finite() && max.is_finite() && min < max) {
            let value = format_args!("[{min}, {max}]").to_string();
            self.refuse(name, value, "finite with minimum < maximum");
        }
    }
}
