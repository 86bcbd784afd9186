//! Subcommand `evaluate`.

use std::path::PathBuf;

use crate::elsewhere::{Judge, Judged};
use crate::signal_file::SignalFile;
use anyhow::{Context, Result};
use clap::Args;
use cosim::cli::print;
use cosim::verdict::Verdict;
use serde_json::{Value, json};

use super::MachineArgs;
use super::evaluation::{conditions, write_json};

#[derive(Args)]
pub struct EvaluateArgs {
    /// CSV file of the run: the column `time`, then signals by `component.variable`, a row for each communication point
    #[arg(required_unless_present = "signals")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Largest tip error over the motion with which the verdict is good, m
    #[arg(long, value_name = "METRES")]
    max_error: Option<f64>,
    /// Also write metrics and verdict to this JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Only print the names of the signals that are evaluated, for the importer that is to record them
    #[arg(long)]
    signals: bool,
}

/// Evaluate a run that another importer made.
pub fn evaluate(args: &EvaluateArgs) -> Result<Verdict> {
    let (system, experiment, _) = args.machine.load()?;
    let judge = Judge::new(&system, &experiment)?;
    let Some(csv) = args.csv.as_ref().filter(|_| !args.signals) else {
        print(judge.signals().join("\n") + "\n")?;
        return Ok(Verdict::default());
    };
    let judged = judge
        .judge(&SignalFile::read(csv)?, args.max_error)
        .with_context(|| format!("`{}`", csv.display()))?;
    print(judged.text())?;
    let mut found = conditions(&system, &experiment);
    put(&mut found, &judged);
    write_json(args.json.as_deref(), &found)?;
    Ok(judged.verdict)
}

fn put(found: &mut Value, judged: &Judged) {
    found["metrics"] = json!(judged.metrics());
    found["verdict"] = if judged.verdict.is_bad() {
        "BAD"
    } else {
        "good"
    }
    .into();
    let findings = judged.verdict.findings().iter().map(|f| f.text.as_str());
    found["findings"] = findings.collect();
    for (what, missing) in &judged.left_out {
        found["not_evaluated"][what] = json!(missing);
    }
}
