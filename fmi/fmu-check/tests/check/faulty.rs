//! Checks of FMUs with one mistake each.

use std::path::Path;
use std::time::Duration;

use fmi_description::entries::{self, Entries};
use fmu_check::{self, CheckOptions, Report, Verdict};
use tempfile::TempDir;

/// The rows of the check whose promises hold the text `only`, for an FMU of these files.
pub fn checked(entries: &Entries, only: &str) -> Report {
    checked_within(entries, only, Duration::from_secs(300))
}

/// The same, with this limit for all probes.
pub fn checked_within(entries: &Entries, only: &str, limit: Duration) -> Report {
    let folder = TempDir::new().unwrap();
    let fmu = folder.path().join("lag.fmu");
    entries::write(&fmu, entries).unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_fmu-check"));
    fmu_check::check(
        &fmu,
        CheckOptions {
            program,
            words: &[],
            only,
            limit,
        },
    )
    .unwrap()
}

/// Changes of a text, one at a time: what is changed, what stands there instead, the promise whose
/// row alone must fail.
pub fn must_be_found(
    text: &str,
    changes: &[(&str, &str, &str)],
    report: impl Fn(&str, &str) -> Report,
) {
    for (was, is, promise) in changes {
        let changed = text.replacen(was, is, 1);
        assert_ne!(changed, text, "{was}");
        let report = report(&changed, promise);
        let verdicts = report.rows.iter().map(|row| row.outcome.verdict());
        let verdicts: Vec<_> = verdicts.collect();
        assert_eq!(verdicts, [Verdict::Fails], "`{is}`: `{promise}`:\n{report}");
    }
}
