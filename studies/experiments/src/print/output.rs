//! The output that the commands share: progress bar, CSV and JSON files, the conditions of the runs
//! in the JSON file, and the verdict. The report writes its files with it too.

use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result};
use cosim::cli::{bar, print};
use cosim::run::interrupt;
use cosim::{Experiment, Setting, System, Verdict};
use output_file::OutputFile;
use serde::Serialize;
use serde_json::{Value, json};

/// Calls `run` with a progress bar over `count` items; `run` calls its argument after each.
pub fn with_progress<T>(
    count: u64,
    what: &'static str,
    run: impl FnOnce(&(dyn Fn() + Sync)) -> T,
) -> T {
    let bar = bar(count, what, false);
    let result = run(&|| bar.inc(1));
    bar.finish_and_clear();
    result
}

/// Writes a file if a path is given.
pub fn write(
    path: Option<&Path>,
    content: impl FnOnce(&mut OutputFile) -> io::Result<()>,
) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    interrupt::check()?;
    let mut file = OutputFile::create(path)?;
    content(&mut file).with_context(|| path.display().to_string())?;
    Ok(file.commit()?)
}

/// Writes a JSON file if a path is given.
pub fn write_json(path: Option<&Path>, value: &impl Serialize) -> Result<()> {
    write(path, |file| {
        serde_json::to_writer_pretty(&mut *file, value)?;
        writeln!(file)
    })
}

/// Version, step, schedule and start values as a JSON object, to which results are added.
pub fn conditions(system: &System, base: &Experiment) -> Value {
    let setting = |s: &Setting| format!("{}={}", system.name(s.port), s.value);
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "step_s": base.stepping.step,
        "schedule": format!("{:?}", base.stepping.schedule),
        "settings": base.settings.iter().map(setting).collect::<Vec<_>>(),
    })
}

/// The verdict as text; "verdict: good" if there are no findings.
pub fn verdict_text(verdict: &Verdict) -> String {
    if verdict.findings().is_empty() {
        return "verdict: good\n".into();
    }
    verdict.to_string()
}

/// Prints the verdict with `--check`; without it, a hint on stderr if the verdict is bad.
pub fn print_counted(verdict: &Verdict, check: bool) -> Result<()> {
    if check {
        return print(verdict_text(verdict));
    }
    if verdict.is_bad() {
        eprintln!(
            "some runs break a limit of the machine; --check names them and ends with exit code 2"
        );
    }
    Ok(())
}

/// Ends a command: adds the verdict to its results `found`, writes them as JSON if a path is given,
/// and prints the verdict as [`print_counted`] does.
pub fn finish(
    mut found: Value,
    verdict: Verdict,
    json: Option<&Path>,
    check: bool,
) -> Result<Verdict> {
    put_verdict(&mut found, &verdict);
    write_json(json, &found)?;
    print_counted(&verdict, check)?;
    Ok(verdict)
}

/// Adds a verdict to a JSON object: whether it is good, and the findings.
pub fn put_verdict(value: &mut Value, verdict: &Verdict) {
    value["verdict"] = if verdict.is_bad() { "BAD" } else { "good" }.into();
    let findings = verdict.findings().iter().map(|f| f.text.as_str());
    value["findings"] = findings.collect();
}
