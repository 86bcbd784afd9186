//! The report of a check, filled in by all checks and probes: rows of promise, outcome and verdict.

use std::fmt::{self, Write};

use serde::{Deserialize, Serialize};

/// What was found about a promise.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outcome {
    /// What breaks the standard.
    pub fails: Vec<String>,
    /// What no standard forbids, but importers have trouble with: the FMU is not robust.
    pub remarks: Vec<String>,
    /// Why it could not be checked.
    pub not_checked: Option<String>,
    /// Further information, such as numbers of calls.
    pub notes: Vec<String>,
}

/// An outcome in one word, by the worst that was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The promise holds.
    Pass,
    /// It does not hold, and no standard says that it must.
    NotRobust,
    /// It does not hold, which breaks the standard.
    Fails,
    /// It could not be checked.
    NotChecked,
}

/// What must hold for an FMU, and why that matters to those who load it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Promise {
    /// What must hold.
    pub text: &'static str,
    /// What goes wrong if it does not, and in brackets the sections of the standard that ask for it;
    /// without any, an FMU that does not keep it is not robust, whatever it does.
    pub why: &'static str,
}

impl Promise {
    /// Whether a standard asks for it.
    pub(crate) fn is_ruled(self) -> bool {
        self.why.ends_with(']')
    }
}

/// A row of the report.
#[derive(Clone, Debug)]
pub struct Row {
    /// Heading that it is under.
    pub area: &'static str,
    /// The promise.
    pub promise: Promise,
    /// What was found about it.
    pub outcome: Outcome,
}

/// The report of an FMU.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// What was checked: file, version of FMI, model.
    pub title: String,
    /// Its rows, in order.
    pub rows: Vec<Row>,
    /// The time was up before everything was tried.
    pub out_of_time: bool,
}

/// How many details of one kind are printed for a row; the rest is counted.
const MAX_SHOWN: usize = 5;

impl Outcome {
    pub(crate) fn not_checked(reason: impl Into<String>) -> Self {
        Self {
            not_checked: Some(reason.into()),
            ..Self::default()
        }
    }

    pub(crate) fn failed(reason: impl Into<String>) -> Self {
        Self {
            fails: vec![reason.into()],
            ..Self::default()
        }
    }

    pub(crate) fn fail(&mut self, reason: impl Into<String>) {
        self.fails.push(reason.into());
    }

    pub(crate) fn remark(&mut self, remark: impl Into<String>) {
        self.remarks.push(remark.into());
    }

    pub(crate) fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// The outcome in one word.
    pub fn verdict(&self) -> Verdict {
        match self {
            Self { fails, .. } if !fails.is_empty() => Verdict::Fails,
            Self { remarks, .. } if !remarks.is_empty() => Verdict::NotRobust,
            Self {
                not_checked: Some(_),
                ..
            } => Verdict::NotChecked,
            _ => Verdict::Pass,
        }
    }
}

impl Report {
    /// Number of rows with this verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        let verdicts = self.rows.iter().map(|row| row.outcome.verdict());
        verdicts.filter(|v| *v == verdict).count()
    }

    pub(crate) fn push(&mut self, area: &'static str, promise: Promise, mut outcome: Outcome) {
        if !promise.is_ruled() {
            outcome.remarks.splice(..0, outcome.fails.drain(..));
        }
        self.rows.push(Row {
            area,
            promise,
            outcome,
        });
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Pass => "pass",
            Self::NotRobust => "not robust",
            Self::Fails => "FAILS",
            Self::NotChecked => "not checked",
        })
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        let mut area = "";
        for row in &self.rows {
            if row.area != area {
                area = row.area;
                writeln!(f, "\n{area}")?;
            }
            row.fmt(f)?;
        }
        let counts = [
            (Verdict::Pass, "passed"),
            (Verdict::Fails, "failed (the standard is broken)"),
            (Verdict::NotRobust, "not robust (no standard asks for it)"),
            (Verdict::NotChecked, "not checked"),
        ];
        let counts = counts.map(|(verdict, word)| format!("{} {word}", self.count(verdict)));
        writeln!(f, "\n{}", counts.join(", "))
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = self.outcome.verdict();
        writeln!(f, "  {verdict:<12} {}", self.promise.text)?;
        let outcome = &self.outcome;
        write_details(f, "!", &outcome.fails)?;
        write_details(f, "~", &outcome.remarks)?;
        write_details(f, "?", outcome.not_checked.as_slice())?;
        write_details(f, "·", &outcome.notes)?;
        if matches!(verdict, Verdict::Fails | Verdict::NotRobust) {
            write_details(f, "→", &[self.promise.why.to_string()])?;
        }
        Ok(())
    }
}

/// Writes the details of a row, a line for each, after a mark.
fn write_details(f: &mut fmt::Formatter<'_>, mark: &str, texts: &[String]) -> fmt::Result {
    for text in texts.iter().take(MAX_SHOWN) {
        writeln!(f, "{:15}{mark} {}", "", in_one_line(text))?;
    }
    match texts.len().saturating_sub(MAX_SHOWN) {
        0 => Ok(()),
        more => writeln!(f, "{:15}{mark} and {more} more like it", ""),
    }
}

/// Replaces control characters, which messages of an FMU may contain, by escapes.
fn in_one_line(text: &str) -> String {
    text.chars().fold(String::new(), |mut line, c| {
        if c.is_control() {
            let _ = write!(line, "{}", c.escape_default()); // writing to a String cannot fail
        } else {
            line.push(c);
        }
        line
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROMISE: Promise = Promise {
        text: "it works",
        why: "else it does not [FMI 2.0, 2.1]",
    };

    #[test]
    fn the_worst_counts() {
        let mut outcome = Outcome::not_checked("no library");
        assert_eq!(outcome.verdict(), Verdict::NotChecked);
        outcome.remark("odd");
        assert_eq!(outcome.verdict(), Verdict::NotRobust);
        outcome.fail("wrong");
        assert_eq!(outcome.verdict(), Verdict::Fails);
        assert_eq!(Outcome::default().verdict(), Verdict::Pass);
    }

    #[test]
    fn a_table_says_what_fails_and_why_it_matters() {
        let mut report = Report {
            title: "X.fmu".into(),
            ..Report::default()
        };
        report.push("files", PROMISE, Outcome::default());
        let fails = (1..8).map(|k| format!("wrong\t{k}")).collect();
        let outcome = Outcome {
            fails,
            ..Outcome::default()
        };
        report.push("calls", PROMISE, outcome);
        // What no standard asks for cannot break it.
        let why = "else it does not";
        let crashed = Outcome::failed("it crashed");
        report.push("misuse", Promise { why, ..PROMISE }, crashed);
        let text = report.to_string();
        assert!(
            text.starts_with(
                "X.fmu\n\nfiles\n  pass         it works\n\ncalls\n  FAILS        it works\n"
            ),
            "{text}"
        );
        assert!(text.contains("! wrong\\t5\n"), "{text}");
        assert!(text.contains("! and 2 more like it\n"), "{text}");
        assert!(
            text.contains("→ else it does not [FMI 2.0, 2.1]\n"),
            "{text}"
        );
        let robust = "  not robust   it works\n               ~ it crashed\n               → else it does not\n";
        assert!(text.contains(robust), "{text}");
        let counts = "1 passed, 1 failed (the standard is broken), 1 not robust (no standard asks for it), 0 not checked";
        assert!(text.ends_with(&format!("\n{counts}\n")), "{text}");
    }
}
