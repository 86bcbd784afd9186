//! Everything that is wrong with a machine, reported at once.

use std::fmt::Display;
use thiserror::Error;

/// Why a machine was refused.
#[derive(Debug, Error)]
pub enum MachineError {
    /// Not JSON.
    #[error("machine JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A file that cannot be read, or a key `extends` that names nothing.
    #[error("{0}")]
    Source(String),
    /// What is wrong with the machine that a file extends.
    #[error("`extends` = \"{name}\": {error}")]
    Base {
        /// What the key says.
        name: String,
        /// What is wrong there.
        error: Box<MachineError>,
    },
    /// Fields that are unknown, missing or of another type, and values outside their ranges.
    #[error("{}", joined(.0))]
    Findings(Vec<Finding>),
}

/// One thing that is wrong.
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

/// Examines fields of a section, each by the check that it is listed under, with its own name.
macro_rules! examine {
    ($found:ident, $section:literal of $of:expr; $($check:ident: $($field:ident)*;)*) => {
        let of = $of;
        $($($found.$check(concat!($section, ".", stringify!($field)), of.$field);)*)*
    };
}
pub(crate) use examine;

/// What has been found so far.
#[derive(Default)]
pub(crate) struct Findings {
    pub(crate) list: Vec<Finding>,
}

impl Findings {
    /// What `examine` finds.
    pub(crate) fn collect(examine: impl FnOnce(&mut Self)) -> Result<(), MachineError> {
        let mut found = Self::default();
        examine(&mut found);
        found.result()
    }

    /// An error where something was found.
    pub(crate) fn result(self) -> Result<(), MachineError> {
        if self.list.is_empty() {
            return Ok(());
        }
        Err(MachineError::Findings(self.list))
    }

    /// Keeps the first `of_shape` findings, which are about missing and unusable fields, and drops
    /// later ones that only follow from them: those about the same fields, in whose place the
    /// reference machine's values stand, and those about the start, whose range depends on other
    /// fields.
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

    /// The value of `name` breaks the rule "must be `rule`".
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
