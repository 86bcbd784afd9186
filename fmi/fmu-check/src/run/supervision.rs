//! Runs an FMU's probes for `fmu_check::check`, in processes of their own with time limits for each
//! and for all, and adds their outcomes to the report; `arguments` runs one in such a process.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use fmi_description::Version;

use super::probe::Probe;
use super::{
    calls, derivatives, exchange, fmi3_only, instances, misuse, simulation, states, values,
};
use crate::options::CheckOptions;
use crate::outcome::{Outcome, Promise, Report};
use fmi_import::instance::{ONE_BY_ONE, SAID};
use fmi_import::process::{self, Process, is_told};
use fmi_import::{Fmu, Limits, with_fmi3_names};

/// After this a probe counts as hanging; after less if the plain run was quick.
const LONGEST: Duration = Duration::from_secs(120);
/// A probe may take this long however quick the plain run was, since the machine may be busy.
const SHORTEST: Duration = Duration::from_secs(20);
/// A probe may take this many times as long as the plain run. The longest makes some fifteen such
/// runs.
const PLAIN_RUNS: u32 = 100;

/// How a process says that it has reached its time limit.
const NO_ANSWER: &str = "no answer within";

/// Probes that need neither Co-Simulation nor Model Exchange.
const OF_ANY: [&str; 3] = [LOADS, "versions", "free_nothing"];
/// The probe that loads the library; if it fails, the others cannot be tried.
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

/// All probes of both versions, in the order of the report.
fn probes() -> impl Iterator<Item = &'static Probe> {
    let groups: [&[Probe]; 9] = [
        simulation::PROBES,
        values::PROBES,
        instances::PROBES,
        states::PROBES,
        derivatives::PROBES,
        exchange::PROBES,
        misuse::PROBES,
        fmi3_only::PROBES,
        calls::PROBES,
    ];
    groups.into_iter().flatten()
}

/// The result of a probe's process.
struct ProbeResult {
    outcome: Outcome,
    /// The process did not end in time.
    hangs: bool,
    /// First line that the process printed.
    printed: Option<String>,
}

/// Tests the promises that apply to the version and interfaces of an FMU and are wanted. Its files
/// are in two folders, of which the second has an odd name.
pub fn all(
    options: CheckOptions,
    (version, [simulates, exchanges]): (Version, [bool; 2]),
    [plain, odd]: [&Path; 2],
    scratch: &Path,
    report: &mut Report,
) -> Result<()> {
    let begun = Instant::now();
    let mut printed = Outcome::default();
    let checks_silence = SILENCE.text.contains(options.only);
    let mut longest = LONGEST;
    // Why the first steps failed, if they did, and other probes of what the standard asks for:
    // further ones fail for the same reasons.
    let mut known: Vec<String> = Vec::new();
    let applies = |p: &&Probe| {
        let is_offered = match p.area {
            exchange::AREA => exchanges,
            _ => simulates || OF_ANY.contains(&p.name),
        };
        is_offered && p.version.is_none_or(|v| v == version)
    };
    for probe in probes().filter(applies) {
        let is_wanted = probe.promise.text.contains(options.only);
        if !is_wanted && !checks_silence {
            continue;
        }
        let left = options.limit.saturating_sub(begun.elapsed());
        if left.is_zero() {
            let reason = format!(
                "all probes together may take {} s (--timeout)",
                options.limit.as_secs()
            );
            report.out_of_time = true;
            report.push("simulation", REST, Outcome::not_checked(reason));
            break;
        }
        let folder = if probe.has_odd_folder { odd } else { plain };
        let limit = left.min(longest);
        let clock = Instant::now();
        let ProbeResult {
            mut outcome,
            hangs,
            printed: line,
        } = run_process(options, probe, folder, scratch, limit)?;
        if hangs && limit < longest {
            outcome = Outcome::not_checked(format!(
                "no answer when the time for all probes was up, {} s (--timeout)",
                options.limit.as_secs()
            ));
            report.out_of_time = true;
        }
        if probe.name == RUN {
            longest = (PLAIN_RUNS * clock.elapsed()).clamp(SHORTEST, LONGEST);
        }
        if let Some(line) = line.filter(|_| outcome.fails.is_empty()) {
            let what = probe.promise.text;
            printed.remark(format!("while trying whether {what}: {line}"));
        }
        let is_stuck = probe.is_first_step && (hangs || probe.name == LOADS);
        let ends_here = is_stuck && !outcome.fails.is_empty();
        let reasons: Vec<_> = outcome.fails.iter().map(|r| without_numbers(r)).collect();
        let is_known = !reasons.is_empty() && reasons.iter().all(|r| known.contains(r));
        if is_known && !probe.is_first_step {
            outcome = Outcome::not_checked("it fails as an earlier promise does");
        } else if probe.is_first_step || probe.promise.is_ruled() {
            known.extend(reasons);
        }
        if is_wanted {
            report.push(probe.area, probe.promise, outcome);
        }
        if ends_here {
            let reason = "it does not get that far";
            report.push("simulation", REST, Outcome::not_checked(reason));
            break;
        }
    }
    if checks_silence {
        report.push("log", SILENCE, printed);
    }
    Ok(())
}

/// A reason without its numbers, which differ from process to process.
fn without_numbers(reason: &str) -> String {
    reason.replace(|c: char| c.is_ascii_digit(), "")
}

/// Runs a probe in its own process, and once more if it dies in a call that gets or sets, to find
/// out of which variable.
fn run_process(
    options: CheckOptions,
    probe: &Probe,
    folder: &Path,
    scratch: &Path,
    limit: Duration,
) -> Result<ProbeResult> {
    let run = |further: &[&str]| run_once(options, probe, (folder, scratch), limit, further);
    let result = run(&[])?;
    let is_access = |reason: &String| {
        let name = reason.get(4..7);
        matches!(name, Some("Get" | "Set")) && reason.contains(" crashed ")
    };
    if !result.outcome.fails.iter().any(is_access) {
        return Ok(result);
    }
    let again = run(&["--one-by-one"])?;
    let is_same = !again.hangs && again.outcome.fails.iter().any(is_access);
    Ok(if is_same { again } else { result })
}

fn run_once(
    options: CheckOptions,
    probe: &Probe,
    (folder, scratch): (&Path, &Path),
    limit: Duration,
    further: &[&str],
) -> Result<ProbeResult> {
    let [result, output] = ["result.json", "output.txt"].map(|name| scratch.join(name));
    let _ = fs::remove_file(&result); // left by the probe before; there is none at first
    let sink = File::create(&output).with_context(|| output.display().to_string())?;
    let mut command = Command::new(options.program);
    let arguments = [folder, &result];
    command.args(options.words).args(further);
    command.args(["--try", probe.name]).args(arguments);
    command.arg(limit.as_millis().to_string());
    command.stdin(Stdio::null());
    command.stdout(sink.try_clone()?).stderr(sink);
    let process = Process::start(&mut command);
    let mut process = process.with_context(|| options.program.display().to_string())?;
    let status = process.wait(limit)?;
    let printed = first_line(&output);
    let told = told(&output);
    let outcome = match (status, told) {
        (Some(status), _) if status.success() && result.exists() => {
            serde_json::from_slice(&fs::read(&result)?)?
        }
        (Some(status), told) if told.is_some() && is_told(status) => {
            Outcome::failed(told.unwrap_or_default())
        }
        (Some(status), _) => {
            let line = printed.as_ref();
            let words = line.map_or(String::new(), |line| {
                format!(", after it had printed: {line}")
            });
            Outcome::failed(format!("the process died: {status}{words}"))
        }
        (None, told) => {
            Outcome::failed(told.unwrap_or(format!("{NO_ANSWER} {} s", limit.as_secs())))
        }
    };
    let is_silent = |reason: &String| reason.contains(NO_ANSWER);
    Ok(ProbeResult {
        hangs: status.is_none() || outcome.fails.iter().any(is_silent),
        outcome,
        printed,
    })
}

/// What the importer said of the call in which a process ended: without the name of the instance,
/// which the user did not choose, and with the variable if that was said.
fn told(output: &Path) -> Option<String> {
    let text = fs::read(output).ok()?;
    let text = String::from_utf8_lossy(&text);
    let line = text.lines().find_map(|line| line.strip_prefix("error: "))?;
    let call = match line.split_once(": ") {
        Some((name, call)) if name != "NULL" && !name.contains("meanwhile") => call,
        _ => return Some(line.into()),
    };
    let mut lines = text.lines().rev();
    let variable = lines.find_map(|line| line.strip_prefix(SAID));
    Some(match (variable, call.split_once(' ')) {
        (Some(variable), Some((name, rest))) => format!("{name} of {variable} {rest}"),
        _ => call.into(),
    })
}

/// Runs one probe in this process, and writes its outcome to the file `result`. When the limit is
/// reached, the process says in which call it is, and ends.
pub fn one(
    name: &str,
    folder: &Path,
    result: &Path,
    limit: Duration,
    one_by_one: bool,
) -> Result<()> {
    let time = Some(limit);
    process::watch(Limits { time, memory: None }, None);
    process::begin_call();
    ONE_BY_ONE.store(one_by_one, Relaxed);
    let probe = probes().find(|probe| probe.name == name);
    let probe = probe.with_context(|| format!("there is no probe `{name}`"))?;
    let mut outcome = probe.outcome(folder);
    if Fmu::from_folder(folder).is_ok_and(|fmu| fmu.functions.is_fmi3()) {
        let texts = [&mut outcome.fails, &mut outcome.remarks, &mut outcome.notes];
        let texts = texts.into_iter().flatten();
        texts.for_each(|text| *text = with_fmi3_names(text));
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
    fn a_name_is_that_of_one_probe() {
        let mut names: Vec<_> = probes().map(|probe| probe.name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        assert!(names.contains(&LOADS) && names.contains(&RUN));
    }
}
