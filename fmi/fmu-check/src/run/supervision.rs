//! Trials in processes of their own, with a limit for each and for all of them.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use fmi_description::Version;

use super::trial::Trial;
use super::{
    calls, derivatives, exchange, fmi3_only, instances, misuse, simulation, states, values,
};
use crate::checker::Checker;
use crate::outcome::{Outcome, Promise, Report};
use fmi_import::process::wait;
use fmi_import::{Fmu, names};

/// After this a trial counts as hanging; after less where the plain run was quick.
const LONGEST: Duration = Duration::from_secs(120);
/// However quick the plain run was, a trial may take this long: the machine may be busy.
const SHORTEST: Duration = Duration::from_secs(20);
/// How many times as long as the plain run a trial may take. The longest makes some fifteen such
/// runs.
const PLAIN_RUNS: u32 = 100;

/// The trial without which nothing can be tried.
const LOADS: &str = "loads";
/// The plain run.
const RUN: &str = "run";

const REST: Promise = Promise {
    text: "everything else that it does when it is run",
    why: "",
};
const SILENCE: Promise = Promise {
    text: "nothing is printed: messages go to the importer's logger",
    why: "programs whose standard output is read by others break, and services fill their logs",
};

/// All trials of both versions, in the order of the table.
fn trials() -> impl Iterator<Item = &'static Trial> {
    let groups: [&[Trial]; 9] = [
        simulation::TRIALS,
        values::TRIALS,
        instances::TRIALS,
        states::TRIALS,
        derivatives::TRIALS,
        exchange::TRIALS,
        misuse::TRIALS,
        fmi3_only::TRIALS,
        calls::TRIALS,
    ];
    groups.into_iter().flatten()
}

/// What a trial came to.
struct Answer {
    outcome: Outcome,
    /// The process had to be ended.
    hangs: bool,
    /// First line that was printed.
    printed: Option<String>,
}

/// Try the promises of its version and interfaces on the FMU whose files lie in these folders: all of them, or
/// those that are wanted.
pub fn all(
    checker: Checker,
    (version, has_exchange): (Version, bool),
    [plain, odd]: [&Path; 2],
    scratch: &Path,
    report: &mut Report,
) -> Result<()> {
    let begun = Instant::now();
    let mut printed = Outcome::default();
    let listens = SILENCE.text.contains(checker.only);
    let mut longest = LONGEST;
    // What the first steps failed of: the rest fails of it, too.
    let mut known: Vec<String> = Vec::new();
    let is_of_it = |t: &&Trial| {
        t.version.is_none_or(|v| v == version) && (has_exchange || t.area != exchange::AREA)
    };
    for trial in trials().filter(is_of_it) {
        let is_wanted = trial.promise.text.contains(checker.only);
        if !is_wanted && !listens {
            continue;
        }
        let left = checker.limit.saturating_sub(begun.elapsed());
        if left.is_zero() {
            let reason = format!(
                "all trials together may take {} s (--timeout)",
                checker.limit.as_secs()
            );
            report.push("simulation", REST, Outcome::not_checked(reason));
            break;
        }
        let folder = if trial.has_odd_folder { odd } else { plain };
        let limit = left.min(longest);
        let clock = Instant::now();
        let answer = attempt(checker, trial, folder, scratch, limit)?;
        let Answer {
            mut outcome,
            hangs,
            printed: line,
        } = answer;
        if hangs && limit < longest {
            outcome = Outcome::failed(format!(
                "no answer when the time for all trials was up, {} s (--timeout)",
                checker.limit.as_secs()
            ));
        }
        if trial.name == RUN {
            longest = (PLAIN_RUNS * clock.elapsed()).clamp(SHORTEST, LONGEST);
        }
        if let Some(line) = line.filter(|_| outcome.fails.is_empty()) {
            let what = trial.promise.text;
            printed.remark(format!("while trying whether {what}: {line}"));
        }
        let is_stuck = trial.is_first_step && (hangs || trial.name == LOADS);
        let ends_here = is_stuck && !outcome.fails.is_empty();
        if trial.is_first_step {
            known.extend(outcome.fails.iter().map(|reason| without_names(reason)));
        } else if !outcome.fails.is_empty()
            && outcome
                .fails
                .iter()
                .all(|reason| known.contains(&without_names(reason)))
        {
            outcome = Outcome::not_checked("it fails as the plain run does");
        }
        if is_wanted {
            report.push(trial.area, trial.promise, outcome);
        }
        if ends_here {
            let reason = "it does not get that far";
            report.push("simulation", REST, Outcome::not_checked(reason));
            break;
        }
    }
    if listens {
        report.push("log", SILENCE, printed);
    }
    Ok(())
}

/// A reason without the numbers that differ from process to process.
fn without_names(reason: &str) -> String {
    reason.replace(|c: char| c.is_ascii_digit(), "")
}

/// One trial in a process of its own.
fn attempt(
    checker: Checker,
    trial: &Trial,
    folder: &Path,
    scratch: &Path,
    limit: Duration,
) -> Result<Answer> {
    let [result, output] = ["result.json", "output.txt"].map(|name| scratch.join(name));
    let _ = fs::remove_file(&result); // of the trial before; there is none at first
    let sink = File::create(&output).with_context(|| output.display().to_string())?;
    let mut command = Command::new(checker.program);
    let arguments = [folder, &result];
    command.args(checker.words);
    command.args(["--try", trial.name]).args(arguments);
    command.stdin(Stdio::null());
    command.stdout(sink.try_clone()?).stderr(sink);
    let child = command.spawn();
    let status = wait(
        child.with_context(|| checker.program.display().to_string())?,
        limit,
    )?;
    let printed = first_line(&output);
    let outcome = match status {
        None => Outcome::failed(format!("no answer within {} s", limit.as_secs())),
        Some(status) => match fs::read(&result) {
            Ok(bytes) if status.success() => serde_json::from_slice(&bytes)?,
            _ => {
                let last_words = printed.as_ref().map_or(String::new(), |line| {
                    format!(", after it had printed: {line}")
                });
                Outcome::failed(format!("the process died: {status}{last_words}"))
            }
        },
    };
    Ok(Answer {
        outcome,
        hangs: status.is_none(),
        printed,
    })
}

/// One trial, in this process; its outcome goes into the file `result`.
pub fn one(name: &str, folder: &Path, result: &Path) -> Result<()> {
    let trial = trials().find(|trial| trial.name == name);
    let trial = trial.with_context(|| format!("there is no trial `{name}`"))?;
    let mut outcome = trial.outcome(folder);
    if Fmu::unpacked(folder).is_ok_and(|fmu| fmu.functions.is_3()) {
        let texts = [&mut outcome.fails, &mut outcome.remarks, &mut outcome.notes];
        let texts = texts.into_iter().flatten();
        texts.for_each(|text| *text = names::text_in_3(text));
    }
    fs::write(result, serde_json::to_vec(&outcome)?)?;
    Ok(())
}

fn first_line(output: &Path) -> Option<String> {
    let text = fs::read(output).ok()?;
    let text = String::from_utf8_lossy(&text);
    let line = text.lines().find(|line| !line.trim().is_empty())?;
    Some(line.chars().take(200).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_that_of_one_trial() {
        let mut names: Vec<_> = trials().map(|trial| trial.name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        assert!(names.contains(&LOADS) && names.contains(&RUN));
    }
}
