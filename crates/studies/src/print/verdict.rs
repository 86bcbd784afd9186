//! The verdict on what a command has found.

use anyhow::Result;
use cosim::Verdict;
use cosim::cli::print;
use serde_json::Value;

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

/// Put a verdict into a JSON object: whether it is good, and what was found.
pub fn put(value: &mut Value, verdict: &Verdict) {
    value["verdict"] = if verdict.is_bad() { "BAD" } else { "good" }.into();
    let findings = verdict.findings().iter().map(|f| f.text.as_str());
    value["findings"] = findings.collect();
}
