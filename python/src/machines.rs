//! Machine files for `hdrm_fmu.Machine`: reads, checks and changes them, and what is told of a machine
//! by the subcommands `machine`, `sizing` and `path check` of `hdrm-fmu`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Parser;
use experiments::analyses::machine_check::{self, Checked};
use experiments::analyses::sizing;
use experiments::machines::path_margins::PathMargins;
use experiments::machines::scaling::booms;
use experiments::print::output::put_verdict;
use experiments::setup::run_setup::MachineArgs;
use experiments::worlds::perturbation::draw;
use experiments::worlds::{Bounds, MACHINE, parameter_set_of};
use machine_file::{Machine, Source, extension_of, preset};
use machine_sheet::{LoadChart, Sheet};
use motion_check::gain_rule::{self, Actuators};
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::errors::to_exception;

/// Name, value, unit and reason of a gain.
type Gain = (&'static str, f64, &'static str, String);

/// The arguments of a run, as a user of the program gives them.
#[derive(Parser)]
struct Arguments {
    #[command(flatten)]
    machine: MachineArgs,
}

/// Result of an analysis that may take long, without the interpreter's lock.
fn detached<T: Send>(py: Python<'_>, of: impl FnOnce() -> Result<T> + Send) -> PyResult<T> {
    py.detach(of).map_err(to_exception)
}

fn machine(text: &str) -> PyResult<Machine> {
    Machine::from_json(text).map_err(to_exception)
}

/// Of the text of a machine file: the text with all that it extends; the text that has only what
/// differs from a shipped machine, if it extends one; the machine's parameter set for the real world.
/// Relative paths in the text start at the folder of `file`.
#[pyfunction]
#[pyo3(signature = (text, file=None))]
pub fn whole_machine(
    text: &str,
    file: Option<PathBuf>,
) -> PyResult<(String, String, &'static str)> {
    let source = Source::read(text, file.as_deref()).map_err(to_exception)?;
    let whole = serde_json::to_string(&source.machine).map_err(to_exception)?;
    let shipped = source.shipped();
    let short = short(&source.machine, shipped)?;
    Ok((whole, short, parameter_set_of(shipped)))
}

/// The text of a machine file with only what differs from a shipped machine, if one is named.
fn short(machine: &Machine, shipped: Option<&str>) -> PyResult<String> {
    match shipped.and_then(|name| Some((name, Machine::preset(name)?))) {
        Some((name, base)) => Ok(extension_of(name, &base, machine).to_string()),
        None => serde_json::to_string(machine).map_err(to_exception),
    }
}

/// The text of a shipped machine file.
#[pyfunction]
pub fn shipped_machine(name: &str) -> Option<&'static str> {
    preset(name)
}

/// The gains by the rule of `hdrm-fmu machine gains`.
#[pyfunction]
pub fn ruled_gains(text: &str, is_ideal: bool) -> PyResult<Vec<Gain>> {
    let actuators = match is_ideal {
        true => Actuators::Known,
        false => Actuators::AsBuilt,
    };
    let gains = gain_rule::gains_for(&machine(text)?, actuators, &[]).map_err(to_exception)?;
    let row = |gain: gain_rule::RuledGain| (gain.name, gain.value, gain.unit, gain.why);
    Ok(gains.into_iter().map(row).collect())
}

/// What `hdrm-fmu machine check` finds in a machine file, as JSON; systems come from a folder.
#[pyfunction]
pub fn check_machine(
    py: Python<'_>,
    file: String,
    systems: PathBuf,
    with_trials: bool,
) -> PyResult<String> {
    let check = || machine_check::check(&file, with_trials, Some(&systems));
    let Checked {
        found,
        notes,
        trials,
    } = detached(py, check)?;
    let trials = trials.iter().map(|trial| {
        json!({
            "world": trial.world.name(),
            "hook": if trial.is_full { "full" } else { "empty" },
            "tip_rmse": trial.error.map(|[rms, _]| rms),
            "tip_max": trial.error.map(|[_, max]| max),
            "is_verdict": trial.is_verdict(),
        })
    });
    let trials = Value::from_iter(trials);
    Ok(json!({"found": found, "notes": notes, "trials": trials}).to_string())
}

/// The machine file with booms `s` times as large; it extends a shipped machine if `text` does.
#[pyfunction]
pub fn scaled_machine(text: &str, s: f64) -> PyResult<String> {
    let source = Source::read(text, None).map_err(to_exception)?;
    let scaled = booms(&source.machine, s);
    let checked = scaled.check().context("the machine of that size");
    checked.map_err(to_exception)?;
    short(&scaled, source.shipped())
}

/// The machine that `hdrm-fmu machine perturb` draws, and its gravity, m/s². Bounds by name, of those
/// that are not the real world's.
#[pyfunction]
pub fn perturbed_machine(
    text: &str,
    seed: u64,
    bounds: BTreeMap<String, f64>,
) -> PyResult<(String, [f64; 3])> {
    let of = |name: &str, real: f64| bounds.get(name).copied().unwrap_or(real);
    let real = Bounds::REAL;
    let bounds = Bounds {
        mass: of("mass", real.mass),
        com: of("com", real.com),
        second_moment: of("second_moment", real.second_moment),
        length: of("length", real.length),
        plumb: of("plumb", real.plumb),
    };
    let (drawn, gravity) = draw(&machine(text)?, seed, &bounds).map_err(to_exception)?;
    Ok((
        serde_json::to_string(&drawn).map_err(to_exception)?,
        gravity,
    ))
}

/// The load chart as CSV, as `hdrm-fmu machine draw --csv` writes it.
#[pyfunction]
pub fn load_chart(py: Python<'_>, text: &str, factor: f64) -> PyResult<String> {
    let machine = machine(text)?;
    let csv = || {
        let mut csv = Vec::new();
        LoadChart::new(&machine, factor)?.write_csv(&mut csv)?;
        Ok(String::from_utf8(csv)?)
    };
    detached(py, csv)
}

/// Draws the sheet of a machine, with `name` as its title, as SVG or PNG.
#[pyfunction]
pub fn draw_machine(
    py: Python<'_>,
    text: &str,
    name: &str,
    factor: f64,
    file: PathBuf,
) -> PyResult<()> {
    let machine = machine(text)?;
    let drawn = || {
        let chart = LoadChart::new(&machine, factor)?;
        Sheet::new(name, machine, chart)?.write(&file)
    };
    detached(py, drawn)
}

/// What `hdrm-fmu sizing` finds with a machine file, as JSON; systems come from a folder.
#[pyfunction]
pub fn sizing_of(
    py: Python<'_>,
    file: String,
    systems: PathBuf,
    settings: Vec<String>,
    waypoints: Option<String>,
    payload_step: f64,
) -> PyResult<String> {
    let sized = || {
        let system = systems.join(MACHINE).display().to_string();
        let mut words = vec![String::new(), "--machine".into(), file];
        words.extend(["--system".into(), system]);
        let more = settings
            .into_iter()
            .map(|setting| format!("--set={setting}"));
        words.extend(more);
        words.extend(waypoints.map(|path| format!("--waypoints={path}")));
        let arguments = Arguments::try_parse_from(words)?;
        let setup = arguments.machine.setup().build()?;
        let (done, verdict) = sizing::cases(setup, payload_step, |_, _| Ok(()))?;
        let mut found = json!({});
        for (case, sizing) in &done {
            found["sizing"][case] = serde_json::to_value(sizing)?;
        }
        put_verdict(&mut found, &verdict);
        let severities = verdict.findings().iter().map(|finding| finding.is_bad);
        found["is_bad"] = severities.collect();
        Ok(found.to_string())
    };
    detached(py, sized)
}

/// What `hdrm-fmu path check` finds, as JSON.
#[pyfunction]
pub fn path_check(py: Python<'_>, text: &str, path: &str) -> PyResult<String> {
    let machine = machine(text)?;
    let check = || {
        let margins = PathMargins::new(path, &machine)?;
        let mut found = margins.json();
        found["refusal"] = margins.checked.refusal().into();
        Ok(found.to_string())
    };
    detached(py, check)
}
