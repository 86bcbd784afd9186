//! Subcommand `evaluate`: metrics and verdict of a run that another importer recorded as CSV.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use cosim::Verdict;
use cosim::cli::{output, print};
use serde_json::json;
use surrogate::measurement::signal_file::SignalFile;

use crate::analyses::imported_run::Evaluator;
use crate::print::output::{conditions, put_verdict, write_json};
use crate::setup::run_setup::{MachineArgs, RunSetup};

#[derive(Args)]
pub struct EvaluateArgs {
    /// CSV file of the run: the column `time`, then signals by `component.variable`, a row for each
    /// communication point
    #[arg(required_unless_present = "signals", conflicts_with = "signals")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Largest tip error over the motion for a good verdict, m
    #[arg(long, value_name = "METRES", conflicts_with = "signals")]
    max_error: Option<f64>,
    /// Also write metrics and verdict to this JSON file
    #[arg(long, value_name = "FILE", conflicts_with = "signals", value_parser = output())]
    json: Option<PathBuf>,
    /// Only print the names of the signals that the importer must record
    #[arg(long)]
    signals: bool,
}

/// Evaluates a run of another importer.
pub fn evaluate(args: &EvaluateArgs) -> Result<Verdict> {
    args.machine.refuse_stepping()?;
    let RunSetup { system, base, .. } = args.machine.setup().build()?;
    let evaluator = Evaluator::new(&system, &base)?;
    let Some(csv) = &args.csv else {
        print(evaluator.signals().join("\n") + "\n")?;
        return Ok(Verdict::default());
    };
    let run = evaluator
        .evaluate(&SignalFile::read(csv)?, args.max_error)
        .with_context(|| format!("`{}`", csv.display()))?;
    print(run.text())?;
    let mut found = conditions(&system, &base);
    found["metrics"] = json!(run.metrics());
    put_verdict(&mut found, &run.verdict);
    for (what, missing) in &run.left_out {
        found["not_evaluated"][what] = json!(missing);
    }
    write_json(args.json.as_deref(), &found)?;
    Ok(run.verdict)
}
