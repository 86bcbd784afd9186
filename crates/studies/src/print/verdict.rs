//! The verdict on what a command has found.

use std::path::Path;

use anyhow::Result;
use cosim::Verdict;
use cosim::cli::print;
use serde_json::Value;

use super::files::write_json;

/// For people; also says so where nothing was found.
pub fn text(verdict: &Verdict) -> String {
    if verdict.findings().is_empty() {
        return "verdict: good\n".into();
    }
    verdict.to_string()
}

/// The verdict on many runs: printed where it is asked for by `--check`; else a hint beside the
/// results where it is bad.
///
/// # Errors
/// Standard output is closed.
pub fn print_counted(verdict: &Verdict, check: bool) -> Result<()> {
    if check {
        return print(text(verdict));
    }
    if verdict.is_bad() {
        eprintln!("the verdict is BAD: --check says why, and ends with exit code 2");
    }
    Ok(())
}

/// End a command: the verdict goes into the numbers that it has found, these into a JSON file where
/// one is asked for, and the verdict is printed as by [`print_counted`].
///
/// # Errors
/// The file cannot be written.
pub fn finish(
    mut found: Value,
    verdict: Verdict,
    json: Option<&Path>,
    check: bool,
) -> Result<Verdict> {
    put(&mut found, &verdict);
    write_json(json, &found)?;
    print_counted(&verdict, check)?;
    Ok(verdict)
}

/// Put a verdict into a JSON object: whether it is good, and what was found.
pub fn put(value: &mut Value, verdict: &Verdict) {
    value["verdict"] = if verdict.is_bad() { "BAD" } else { "good" }.into();
    let findings = verdict.findings().iter().map(|f| f.text.as_str());
    value["findings"] = findings.collect();
}
