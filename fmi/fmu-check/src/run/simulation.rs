//! Probes of loading, making, freeing, and the run that every importer makes, for `supervision`.

use std::ffi::c_int;
use std::path::Path;

use anyhow::{Result, bail};
use fmi_description::{Access, Causality};

use super::instances::compare;
use super::probe::probes;
use crate::outcome::Outcome;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, InstanceOptions, references, start_time, step_size};
use fmi_import::raw::RawInstance;
use fmi_import::standard::Mode;
use fmi_import::status::{self, OK, WARNING};

/// Largest number of steps of a plain run.
const STEPS: usize = 100;

/// Number of steps of a plain run, which ends at the stop time of the default experiment at the
/// latest.
fn steps(fmu: &Fmu) -> usize {
    let stop = fmu.description.default_experiment.stop;
    let fitting = stop.map(|stop| ((stop - start_time(fmu)) / step_size(fmu) + 1e-6).floor());
    fitting.map_or(STEPS, |n| (n as usize).clamp(1, STEPS))
}

probes! {
    "loading" {
        opened loads.first_step():
            "the library loads",
            "it needs what this machine, or the program that loads it, does not have [FMI 2.0, 2.3; FMI 3.0, 2.5.1.4.1]";
        opened run.first_step():
            "it initializes and steps; every number that it hands out is finite",
            "this is what it is for [FMI 2.0, 4.2.4; FMI 3.0, 4.2.1]";
        opened versions:
            "it says that it is of the version of FMI that its description names",
            "importers refuse another version [FMI 2.0, 2.1.4; FMI 3.0, 2.2.5]";
        opened plain_run.in_odd_folder():
            "it also runs from a folder whose name has a space and an umlaut, which FMI 2.0 encodes in the URI of its resources",
            "users unpack files to `C:\\Users\\Jürgen Müller` [FMI 2.0, 2.1.5; FMI 3.0, 2.3.2]";
        opened guid:
            "an instance is made for the guid or token of the description, and refused for another one",
            "a library with the description of another version would mix up its variables";
        in_folder reload:
            "the library can be unloaded and loaded again",
            "importers unload between simulations; a crash there takes their user's work with it";
        opened free_nothing:
            "freeing an instance of NULL does nothing",
            "the standard allows it, and importers do it after a failed instantiation [FMI 2.0, 2.1.5; FMI 3.0, 2.3.1]";
    }
    "simulation" {
        opened grid:
            "it takes communication points both as k·h and as a running sum of h",
            "importers compute them either way, and they differ by rounding [FMI 2.0, 4.2.2; FMI 3.0, 4.2.1.1]";
        opened later_start:
            "it starts at another time than 0",
            "coupled systems start where the user says";
        opened stop_time:
            "a step to the stop time is done, one beyond it refused",
            "the standard says so, and models prepare no data for what comes after [FMI 2.0, 2.1.6; FMI 3.0, 2.3.2]";
        opened step_sizes.if_claimed(|c| c.variable_step):
            "steps may differ in length, if canHandleVariableCommunicationStepSize",
            "importers with step size control, and every simulation whose end is no multiple of h, do that [FMI 2.0, 4.3.1; FMI 3.0, 4.4]";
        opened terminate:
            "after termination values can still be read, and a reset makes it ready again",
            "importers read results at the end, and start again without loading [FMI 2.0, 2.1.6; FMI 3.0, 2.3.1, 2.3.8]";
    }
}

/// The library was loaded when the FMU was opened.
fn loads(_: &Fmu, _: &mut Outcome) -> Result<()> {
    Ok(())
}

fn versions(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    for (name, text) in fmu.functions.versions() {
        let expected = match name {
            "fmi2GetTypesPlatform" => "default".to_string(),
            _ => fmu.description.fmi.to_string(),
        };
        let Some(text) = text else {
            outcome.fail(format!("{name} gave NULL"));
            continue;
        };
        // FMI 3.0 has minor versions, and may name one.
        let is_minor = text.starts_with("3.") && expected == "3.0";
        let fault = format!("{name} gave `{text}`, expected `{expected}`");
        match name {
            _ if text == expected || is_minor => {}
            "fmi2GetTypesPlatform" => outcome.remark(fault), // usually, says the standard
            _ => outcome.fail(fault),
        }
    }
    Ok(())
}

fn plain_run(fmu: &Fmu, _: &mut Outcome) -> Result<()> {
    Instance::started(fmu, "spaced")?
        .run_excited(3, 0)
        .map(drop)
}

fn guid(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    Instance::new(fmu, "right")?;
    let token = "{00000000-1111-2222-3333-444444444444}";
    let wrong = InstanceOptions {
        token: Some(token),
        ..InstanceOptions::USUAL
    };
    if Instance::with_options(fmu, "wrong", wrong).is_ok() {
        outcome.remark(format!("fmi2Instantiate took {token}"));
    }
    Ok(())
}

fn reload(folder: &Path) -> Result<()> {
    for _ in 0..3 {
        let fmu = Fmu::from_folder(folder)?;
        Instance::started(&fmu, "reload")?.run_excited(1, 0)?;
    }
    Ok(())
}

fn free_nothing(fmu: &Fmu, _: &mut Outcome) -> Result<()> {
    RawInstance::free_null(&fmu.functions);
    Ok(())
}

fn run(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::started(fmu, "run")?;
    let description = &fmu.description;
    let variables = &description.variables;
    let reals = references(variables, |v| v.access() == Access::Real);
    let texts = references(variables, |v| v.access() == Access::String);
    let h = step_size(fmu);
    let steps = steps(fmu);
    for _ in 0..steps {
        instance.step(h)?;
        let values = instance.must_read(&reals)?;
        let of = variables.iter().filter(|v| v.access() == Access::Real);
        let of = of.flat_map(|v| vec![v; v.size()]);
        for (v, value) in of.zip(values).filter(|(_, value)| !value.is_finite()) {
            let text = format!("t = {} s: `{}` is {value}", instance.time, v.name);
            match v.causality {
                Causality::Output => bail!(text),
                _ if outcome.remarks.is_empty() => outcome.remark(text),
                _ => {}
            }
        }
        instance.observe()?;
        if !texts.is_empty() {
            let (status, _) = instance.texts(&texts);
            instance.must("fmi2GetString of all variables", status)?;
        }
    }
    outcome.note(format!("{steps} steps of {h} s"));
    Ok(())
}

fn grid(fmu: &Fmu, _: &mut Outcome) -> Result<()> {
    let h = step_size(fmu);
    let mut sum = Instance::started(fmu, "sum")?;
    (0..steps(fmu)).try_for_each(|_| sum.step(h))?;
    drop(sum); // the FMU may allow one instance only
    let mut multiple = Instance::started(fmu, "multiple")?;
    let start = multiple.time;
    for k in 0..steps(fmu) {
        multiple.time = start + k as f64 * h;
        multiple.step(h)?;
    }
    Ok(())
}

fn later_start(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::new(fmu, "start")?;
    let h = step_size(fmu);
    let later = start_time(fmu) + 7.0 * h;
    let begun = instance.initialize_between(later, None);
    if let Err(reason) = begun.and_then(|()| instance.step(h)) {
        outcome.remark(reason.to_string());
    }
    Ok(())
}

fn stop_time(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::new(fmu, "stop")?;
    let h = step_size(fmu);
    let start = start_time(fmu);
    instance.initialize_between(start, Some(start + 3.0 * h))?;
    (0..3).try_for_each(|_| instance.step(h))?;
    if let status @ (OK | WARNING) = instance.step_from(instance.time, h) {
        outcome.fail(format!(
            "a step beyond the stop time gave {}, expected fmi2Error",
            status::name(status)
        ));
    }
    Ok(())
}

fn step_sizes(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let h = step_size(fmu);
    let outputs = references(&fmu.description.variables, |v| {
        v.is_computed() && v.access() == Access::Real
    });
    let after = |sizes: &[f64]| {
        let mut instance = Instance::started(fmu, "sizes")?;
        sizes.iter().try_for_each(|h| instance.step(*h))?;
        let (status, values) = instance.reals(&outputs);
        instance.must("fmi2GetReal", status)?;
        anyhow::Ok(values)
    };
    let whole = after(&[h, h, h])?;
    let parts = after(&[0.5 * h, h, 0.25 * h, 1.25 * h])?;
    let pairs = whole.iter().zip(&parts);
    let differences = pairs.map(|(a, b)| (a - b).abs() / a.abs().max(b.abs()).max(1e-9));
    let largest = differences.fold(0.0, f64::max);
    outcome.note(format!(
        "three steps and the same time in four others differ by {largest:.1e} at most, relatively"
    ));
    Ok(())
}

fn terminate(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::started(fmu, "terminate")?;
    let before = instance.run_excited(3, 0)?;
    instance.enter(Mode::Terminated)?;
    instance.observe()?;
    instance.enter(Mode::Instantiated)?;
    instance.initialize()?;
    let after = instance.run_excited(3, 0)?;
    compare(
        &before,
        &after,
        "after fmi2Terminate and fmi2Reset",
        outcome,
    );
    Ok(())
}

/// Whether this is no status that a synchronous co-simulation FMU may return.
pub fn is_odd(status: c_int) -> bool {
    !(0..=3).contains(&status)
}
