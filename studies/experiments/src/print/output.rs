//! What a command leaves: CSV and JSON files, in them what the numbers were made under, and the
//! verdict on what was found.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::{Context, Result};
use cosim::cli::{bar, print};
use cosim::{Experiment, Setting, System, Verdict};
use serde::Serialize;
use serde_json::{Value, json};

/// What `run` returns, with a progress bar over `count` of what it makes (`what`); it calls the
/// function that it is given after each.
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

/// Write a file where one is asked for.
pub fn write(
    path: Option<&Path>,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let file = File::create(path);
    let file = file.with_context(|| format!("`{}` cannot be written", path.display()))?;
    let mut file = BufWriter::new(file);
    content(&mut file)
        .and_then(|()| file.flush())
        .with_context(|| path.display().to_string())
}

/// Write a JSON file where one is asked for.
pub fn write_json(path: Option<&Path>, value: &impl Serialize) -> Result<()> {
    write(path, |file| {
        serde_json::to_writer_pretty(&mut *file, value)?;
        writeln!(file)
    })
}

/// What the numbers were made under.
pub fn conditions(system: &System, base: &Experiment) -> Value {
    let setting = |s: &Setting| format!("{}={}", system.name(s.port), s.value);
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "step_s": base.stepping.step,
        "schedule": format!("{:?}", base.stepping.schedule),
        "settings": base.settings.iter().map(setting).collect::<Vec<_>>(),
    })
}

/// For people; also says so where nothing was found.
pub fn verdict_text(verdict: &Verdict) -> String {
    if verdict.findings().is_empty() {
        return "verdict: good\n".into();
    }
    verdict.to_string()
}

/// The verdict on many runs: printed where it is asked for by `--check`; else a hint beside the
/// results where it is bad.
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

/// End a command: the verdict goes into the numbers that it has found, these into a JSON file where
/// one is asked for, and the verdict is printed as by [`print_counted`].
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

/// Put a verdict into a JSON object: whether it is good, and what was found.
pub fn put_verdict(value: &mut Value, verdict: &Verdict) {
    value["verdict"] = if verdict.is_bad() { "BAD" } else { "good" }.into();
    let findings = verdict.findings().iter().map(|f| f.text.as_str());
    value["findings"] = findings.collect();
}
