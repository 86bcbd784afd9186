//! The report's section on a path that the user gave: margins, tip errors and energy.

use std::fmt::Write as _;

use anyhow::{Context, Result};
use cosim::run::observer::{Function, Observers};
use cosim::{Experiment, Master, Recording};
use output_file::TemporaryFolder;
use serde_json::{Value, json};

use super::request::{Request, success};
use crate::margins_figure;
use experiments::analyses::inertia::MODES;
use experiments::machines::path_margins::PathMargins;
use experiments::measures::energy;
use experiments::measures::iso9283::Meter;
use experiments::measures::run::{FailedRun, RecordedRun, run};
use experiments::print;
use experiments::setup::machine_choice::MachineFile;
use experiments::setup::start_values::vary;

/// The controller whose energy is shown.
const ADAPTIVE: &str = MODES[0];

/// The path run with the three controllers: tables as the command line prints them, and the margins
/// along it as SVG; a failure goes to `failures`.
pub fn results(
    request: &Request,
    machine: &MachineFile,
    failures: &mut Vec<String>,
) -> Option<Value> {
    let (name, experiment) = request.path.as_ref()?;
    let result = evaluate(request, machine, name, experiment);
    success(result.with_context(|| format!("path {name}")), failures)
}

fn evaluate(
    request: &Request,
    machine: &MachineFile,
    name: &str,
    experiment: &Experiment,
) -> Result<Value> {
    let margins = PathMargins::new(name, &machine.machine)?;
    let mut text = margins.description() + &margins.table() + "\n";
    let mut balances = String::new();
    for mode in MODES {
        let experiment = vary(request.system, experiment, &[("mode", &mode)])?;
        let mut meter = Meter::from_experiment(request.system, &experiment)?;
        let ports = match mode {
            ADAPTIVE => energy::ports(request.system)?,
            _ => Vec::new(),
        };
        let mut recording = Recording::new(request.system, &ports)?;
        let measure = |master: &Master| meter.iter_mut().try_for_each(|meter| meter.add(master));
        let measure = &mut Function(measure);
        let observers = &mut Observers(vec![&mut recording, measure]);
        let outcome = run(request.system, &experiment, &|_, _| (), observers)
            .map_err(FailedRun::explain)
            .with_context(|| mode.to_owned())?;
        writeln!(text, "{mode}: tip error {}", outcome.tip.motion)?;
        if let Some(measures) = meter.and_then(|meter| meter.measures()) {
            write!(text, "{measures}")?;
        }
        write!(text, "{}", outcome.limits)?;
        if mode == ADAPTIVE {
            let recorded = RecordedRun { recording, outcome };
            let energies = energy::evaluate(request.system, &recorded)?;
            balances = print::energy::text("energy", &energies.balances);
        }
    }
    write!(text, "\n{balances}")?;
    let folder = TemporaryFolder::new()?;
    let [_, svg] = margins_figure::draw(&margins, folder.path())?;
    let figure = std::fs::read_to_string(svg)?;
    Ok(json!({"name": name, "text": text, "figure": figure}))
}
