//! Trials in processes of their own.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use fmu_description::Version;

use super::super::Checker;
use super::super::outcome::{Outcome, Promise, Report};
use super::{Place, open, trials};
use crate::fmi::names;

/// After this a trial counts as hanging.
const LONGEST: Duration = Duration::from_secs(120);

const REST: Promise = Promise {
    text: "everything else that it does when it is run",
    why: "",
};
const SILENCE: Promise = Promise {
    text: "nothing is printed: messages go to the importer's logger",
    why: "programs whose standard output is read by others break, and services fill their logs",
};

/// Try the promises of its version on the FMU whose files lie in these folders: all of them, or those that are wanted.
pub fn all(
    Checker { program, only }: Checker,
    version: Version,
    plain: &Path,
    spaced: &Path,
    scratch: &Path,
    report: &mut Report,
) -> Result<()> {
    let mut printed = Outcome::default();
    let listens = SILENCE.text.contains(only);
    for trial in trials().filter(|t| t.version.is_none_or(|v| v == version)) {
        let is_wanted = trial.promise.text.contains(only);
        if !is_wanted && !listens {
            continue;
        }
        let folder = match trial.place {
            Place::Plain => plain,
            Place::Spaced => spaced,
        };
        let [result, output] = ["result.json", "output.txt"].map(|name| scratch.join(name));
        let _ = fs::remove_file(&result); // of the trial before; there is none at first
        let sink = File::create(&output).with_context(|| output.display().to_string())?;
        let mut command = Command::new(program);
        command
            .args(["fmu", "try", trial.name])
            .arg(folder)
            .arg(&result);
        command
            .stdin(std::process::Stdio::null())
            .stdout(sink.try_clone()?)
            .stderr(sink);
        let child = command
            .spawn()
            .with_context(|| program.display().to_string())?;
        let outcome = match wait(child)? {
            None => Outcome::failed(format!("no answer within {} s", LONGEST.as_secs())),
            Some(status) => match fs::read(&result) {
                Ok(bytes) if status.success() => serde_json::from_slice(&bytes)?,
                _ => Outcome::failed(format!("the process died: {status}{}", last_words(&output))),
            },
        };
        if let Some(line) = first_line(&output).filter(|_| outcome.fails.is_empty()) {
            printed.remark(format!(
                "while trying whether {}: {line}",
                trial.promise.text
            ));
        }
        let ends_here = trial.is_needed && !outcome.fails.is_empty();
        if is_wanted {
            report.push(trial.area, trial.promise, outcome);
        }
        if ends_here {
            let reason = "it does not get that far";
            report.push("simulation", REST, Outcome::not_checked(reason));
            return Ok(());
        }
    }
    if listens {
        report.push("log", SILENCE, printed);
    }
    Ok(())
}

/// One trial, in this process; its outcome goes into the file `result`.
pub fn one(name: &str, folder: &Path, result: &Path) -> Result<()> {
    let trial = trials().find(|trial| trial.name == name);
    let trial = trial.with_context(|| format!("there is no trial `{name}`"))?;
    let mut outcome = Outcome::default();
    if let Err(reason) = (trial.run)(folder, &mut outcome) {
        outcome.fail(reason);
    }
    let is_3 = open(folder).is_ok_and(|fmu| fmu.functions.fmi3().is_some());
    if is_3 {
        let texts = [&mut outcome.fails, &mut outcome.remarks, &mut outcome.notes];
        let texts = texts.into_iter().flatten();
        texts.for_each(|text| *text = names::text_in_3(text));
    }
    fs::write(result, serde_json::to_vec(&outcome)?)?;
    Ok(())
}

fn wait(mut child: Child) -> Result<Option<ExitStatus>> {
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if begun.elapsed() > LONGEST {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn first_line(output: &Path) -> Option<String> {
    let text = fs::read(output).ok()?;
    let text = String::from_utf8_lossy(&text);
    let line = text.lines().find(|line| !line.trim().is_empty())?;
    Some(line.chars().take(200).collect())
}

fn last_words(output: &Path) -> String {
    first_line(output).map_or(String::new(), |line| {
        format!(", after it had printed: {line}")
    })
}
