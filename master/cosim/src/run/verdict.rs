//! The verdict on the result of a run, for programs, Python and pages: a list of findings. The
//! result must not be used as it stands if one of them is bad.

use std::fmt;

/// Something that the user of a result must know.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Message.
    pub text: String,
    /// It spoils the result.
    pub is_bad: bool,
}

/// The findings on a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict(Vec<Finding>);

impl Verdict {
    /// Adds a finding that does not spoil the result.
    pub fn note(&mut self, text: String) {
        self.0.push(Finding {
            text,
            is_bad: false,
        });
    }

    /// Adds a finding that spoils the result.
    pub fn object(&mut self, text: String) {
        self.0.push(Finding { text, is_bad: true });
    }

    /// Adds the findings of `other`.
    pub fn extend(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    /// The same findings, each prefixed with the name of what it was found in.
    pub fn prefixed(self, name: &str) -> Self {
        let named = |f: Finding| Finding {
            text: format!("{name}: {}", f.text),
            ..f
        };
        Self(self.0.into_iter().map(named).collect())
    }

    /// The findings, in the order in which they were added.
    pub fn findings(&self) -> &[Finding] {
        &self.0
    }

    /// True if a finding spoils the result.
    pub fn is_bad(&self) -> bool {
        self.0.iter().any(|f| f.is_bad)
    }
}

/// A line for the verdict and one for each finding; nothing if there are none.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return Ok(());
        }
        let whole = if self.is_bad() { "BAD" } else { "good" };
        writeln!(f, "verdict: {whole}")?;
        for finding in &self.0 {
            let mark = if finding.is_bad { '!' } else { '-' };
            writeln!(f, "  {mark} {}", finding.text)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bad_finding_makes_the_verdict_bad() {
        let mut verdict = Verdict::default();
        assert_eq!(verdict.to_string(), "");
        verdict.note("warm".into());
        assert_eq!(verdict.to_string(), "verdict: good\n  - warm\n");
        let mut other = Verdict::default();
        other.object("burnt".into());
        verdict.extend(other.prefixed("motor"));
        assert!(verdict.is_bad());
        assert_eq!(
            verdict.to_string(),
            "verdict: BAD\n  - warm\n  ! motor: burnt\n"
        );
    }
}
