//! Instruction counts against recorded ones. Counts repeat from run to run where times do not, so
//! they show a loss of a few per cent; they are not times. They are those of one compiler and one C
//! library, so a record holds its environment, and elsewhere more growth is accepted.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use cargo_fmu::process::output;
use serde::{Deserialize, Serialize};

use super::borders;
use super::callgrind::{per_call, valgrind};
use super::inputs::{BORDER_IN_C, BORDER_IN_RUST, PROGRAMS, build, instantiation, overhead};
use crate::workspace::Workspace;

/// Growth over the recorded count that is still accepted.
const ALLOWED_GROWTH: f64 = 0.03;
/// The same with another compiler, C library or valgrind than the counts were recorded with.
const ALLOWED_GROWTH_ELSEWHERE: f64 = 0.15;

/// Recorded counts, relative to the root.
const RECORD: &str = "benches/instructions.json";

/// Bench program and call.
const CALLS: [(&str, &str); 5] = [
    ("dynamics", "forward dynamics"),
    ("dynamics", "manipulator outputs"),
    ("step", "actuator step of 1 ms (motion-driven)"),
    ("step", "surrogate evaluation"),
    ("controller", "controller output + step (adaptive)"),
];

/// The file.
#[derive(Serialize, Deserialize)]
struct Record {
    /// What the counts depend on beside our code.
    environment: Vec<String>,
    /// Instructions of each call.
    counts: BTreeMap<String, u64>,
}

/// Whether there is a valgrind to count with.
pub fn is_possible() -> bool {
    output(Command::new("valgrind").arg("--version")).is_ok()
}

/// Count on packed FMUs, and record.
pub fn record(workspace: &Workspace, fmus: Vec<PathBuf>) -> Result<()> {
    let record = Record {
        environment: environment()?,
        counts: count(workspace, fmus)?,
    };
    let text = serde_json::to_string_pretty(&record)? + "\n";
    fs::write(workspace.root.join(RECORD), &text)?;
    println!("{text}");
    Ok(())
}

/// Count on packed FMUs, print, compare; fails where a count has grown too much.
pub fn check(workspace: &Workspace, fmus: Vec<PathBuf>) -> Result<()> {
    let file = workspace.root.join(RECORD);
    let text = fs::read_to_string(&file)
        .with_context(|| format!("{}: run with --record first", file.display()))?;
    let recorded: Record =
        serde_json::from_str(&text).with_context(|| file.display().to_string())?;
    let environment = environment()?;
    let mut limit = ALLOWED_GROWTH;
    if environment != recorded.environment {
        limit = ALLOWED_GROWTH_ELSEWHERE;
        println!(
            "recorded with {}; here with {}: growth may reach {limit}",
            recorded.environment.join(", "),
            environment.join(", "),
        );
    }
    let is_hdrm = |fmu: &&PathBuf| fmu.file_stem().is_some_and(|name| name == "Hdrm");
    let hdrm = fmus.iter().find(is_hdrm).cloned();
    compare(&count(workspace, fmus)?, &recorded.counts, limit)?;
    borders::check(
        workspace,
        &hdrm.context("Hdrm is not among the packed FMUs")?,
    )
}

/// Processor family, compiler, C library and valgrind.
fn environment() -> Result<Vec<String>> {
    let first_line = |program: &str| -> Result<String> {
        let text = output(Command::new(program).arg("--version"))?;
        Ok(text.lines().next().unwrap_or_default().to_string())
    };
    let (os, arch) = (std::env::consts::OS, std::env::consts::ARCH);
    Ok(vec![
        format!("{os} {arch}"),
        first_line("rustc")?,
        first_line("ldd")?,
        first_line("valgrind")?,
    ])
}

fn count(workspace: &Workspace, fmus: Vec<PathBuf>) -> Result<BTreeMap<String, u64>> {
    let built = build(workspace, fmus, &PROGRAMS)?;
    let mut counts = BTreeMap::new();
    for (program, call) in CALLS {
        let program = built.program(program)?;
        let count = per_call([100, 200], |n| {
            let mut command = valgrind(workspace);
            command.arg(program).args(["--count", call, &n.to_string()]);
            command
        })?;
        counts.insert(call.to_string(), count);
    }
    // In motion, which starts after 4 s of settling.
    let coupled = per_call([4600, 4800], |n| {
        let mut command = valgrind(workspace);
        let cosim = built.coupled(workspace);
        command.arg(cosim.get_program()).args(cosim.get_args());
        let stop = format!("{}", 1e-3 * f64::from(n));
        command.args(["--repeat", "1", "--stop-time", &stop]);
        command
    })?;
    counts.insert("coupled step of 1 ms".to_string(), coupled);
    let driven = |command: &Command, [instances, steps]: [u32; 2]| {
        let mut counted = valgrind(workspace);
        counted.arg(command.get_program()).args(command.get_args());
        counted.args([instances.to_string(), steps.to_string()]);
        counted
    };
    for (name, command) in instantiation(workspace, &built.fmus)? {
        let count = per_call([0, 1], |n| driven(&command, [n, 0]))?;
        counts.insert(format!("first instance of {name}"), count);
    }
    let [in_rust, in_c] = overhead(workspace)?;
    for (name, command) in [(BORDER_IN_RUST, in_rust), (BORDER_IN_C, in_c)] {
        let count = per_call([1000, 2000], |n| driven(&command, [1, n]))?;
        counts.insert(name.to_string(), count);
    }
    Ok(counts)
}

fn compare(
    counts: &BTreeMap<String, u64>,
    recorded: &BTreeMap<String, u64>,
    limit: f64,
) -> Result<()> {
    println!(
        "{:<44} {:>12} {:>12} {:>8}",
        "instructions per call", "now", "recorded", "growth"
    );
    let mut grown = Vec::new();
    for (call, &now) in counts {
        let &before = recorded
            .get(call)
            .with_context(|| format!("`{call}` is not recorded"))?;
        let growth = now as f64 / before as f64 - 1.0;
        println!("{call:<44} {now:>12} {before:>12} {:>7.1}%", 100.0 * growth);
        if growth > limit {
            grown.push(call.as_str());
        }
    }
    ensure!(
        grown.is_empty(),
        "more than {:.0} % above the record: {}",
        100.0 * limit,
        grown.join(", ")
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_growth_beyond_the_limit_fails() {
        let counts = |n| BTreeMap::from([("call".to_string(), n)]);
        let recorded = counts(1000);
        assert!(compare(&counts(1029), &recorded, 0.03).is_ok());
        assert!(compare(&counts(500), &recorded, 0.03).is_ok());
        assert!(compare(&counts(1031), &recorded, 0.03).is_err());
        assert!(compare(&counts(1031), &recorded, 0.15).is_ok());
        assert!(compare(&counts(1000), &BTreeMap::new(), 0.03).is_err());
    }
}
