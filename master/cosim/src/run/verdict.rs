//! What a run says of itself at its end: findings, and whether one of them forbids to use its
//! result.

use std::fmt;

/// Something worth knowing about a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// For people.
    pub text: String,
    /// The result is not to be used as it stands.
    pub is_bad: bool,
}

/// All that was found in a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict(Vec<Finding>);

impl Verdict {
    /// Add something that does not spoil the result.
    pub fn note(&mut self, text: String) {
        self.0.push(Finding {
            text,
            is_bad: false,
        });
    }

    /// Add something that spoils the result.
    pub fn object(&mut self, text: String) {
        self.0.push(Finding { text, is_bad: true });
    }

    /// Add the findings of `other`.
    pub fn extend(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    /// The same findings, each with the name of what it was found in.
    pub fn of(self, name: &str) -> Self {
        let named = |f: Finding| Finding {
            text: format!("{name}: {}", f.text),
            ..f
        };
        Self(self.0.into_iter().map(named).collect())
    }

    /// What was found.
    pub fn findings(&self) -> &[Finding] {
        &self.0
    }

    /// True where a finding spoils the result.
    pub fn is_bad(&self) -> bool {
        self.0.iter().any(|f| f.is_bad)
    }
}

/// Nothing where nothing was found, else a line for the whole and one for each finding.
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
        verdict.extend(other.of("motor"));
        assert!(verdict.is_bad());
        assert_eq!(
            verdict.to_string(),
            "verdict: BAD\n  - warm\n  ! motor: burnt\n"
        );
    }
}
