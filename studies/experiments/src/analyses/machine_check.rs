//! What is wrong with a machine, for `hdrm-fmu machine check` and the Python package: what its file
//! says, its start pose, gains that do not fit, and trials in closed loop.

use std::path::Path;

use anyhow::Result;
use hdrm::HdrmError;
use machine_file::{AXES, Machine, Source};
use motion_check::gain_rule::{self, GainError};
use motion_check::{AllowedRanges, DemandModel, Motion, Payload};

use crate::analyses::trials::{self, Trial};
use crate::machines::continuous_torque::ContinuousTorque;
use crate::machines::strokes::beyond_strokes;
use crate::setup::machine_choice::read;
use crate::setup::run_setup::adaptation_warning;
use crate::worlds::{PARAMETERS, parameter_set_of};

/// What is found in a machine.
#[derive(Default)]
pub struct Checked {
    /// Errors: without any, all FMUs run with the machine.
    pub found: Vec<String>,
    /// What its builder should know.
    pub notes: Vec<String>,
    /// The trials in closed loop; none if they were not asked for, or nothing can be tried.
    pub trials: Vec<Trial>,
}

/// Checks the machine file, or the shipped machine, `name`; the trials take their systems from the
/// folder `systems`, by default as the commands find them.
pub fn check(name: &str, with_trials: bool, systems: Option<&Path>) -> Result<Checked> {
    let mut checked = Checked::default();
    match Source::named(name) {
        Err(error) => checked.found = error.lines(),
        Ok(source) => {
            let machine = &source.machine;
            [checked.found, checked.notes] = at_start(machine);
            if checked.found.is_empty() {
                let warning = gains_warning(machine, source.shipped())?;
                checked.notes.extend(warning);
                if with_trials {
                    try_in_loop(name, machine, systems, &mut checked)?;
                }
            }
        }
    }
    Ok(checked)
}

/// Errors of a machine whose single values are in range: loops that do not close, a start pose that
/// it cannot hold. Second, notes on motors that cannot hold the start pose continuously.
pub fn at_start(machine: &Machine) -> [Vec<String>; 2] {
    let capability = match DemandModel::new(machine, &Payload::from_machine(machine)) {
        Err(HdrmError::Geometry(error)) => return [vec![format!("`geometry`: {error}")], vec![]],
        Err(error) => return [vec![error.to_string()], vec![]],
        Ok(capability) => capability,
    };
    let demand = capability.demand(&Motion::rest(machine.start.zeta));
    let margins = AllowedRanges::from_machine(machine).margins(&demand);
    let unfit = match beyond_strokes(machine) {
        Ok(unfit) => unfit,
        Err(error) => return [vec![format!("`geometry`: {error}")], vec![]],
    };
    if !unfit.is_empty() {
        return [unfit, vec![]];
    }
    let beyond = margins.iter().filter(|margin| !margin.holds());
    let beyond = beyond.map(|margin| format!("at the start pose, `start.zeta`, at rest: {margin}"));
    let motors = AXES.into_iter().zip(demand.tau_e);
    let warm = motors.zip(ContinuousTorque::from_machine(machine));
    let warm = warm.filter(|((_, torque), most)| torque.abs() > most.torque);
    let warm = warm.map(|((axis, torque), ContinuousTorque { torque: most, by })| {
        format!(
            "the start pose cannot be held for ever: motor torque of {axis} = {torque:.1} N·m, of which {most:.1} N·m may last ({by})"
        )
    });
    [beyond.collect(), warm.collect()]
}

/// A warning if the parameter set that ships for the real world does not fit a machine.
fn gains_warning(machine: &Machine, shipped: Option<&str>) -> Result<Option<String>> {
    let set = parameter_set_of(shipped);
    let own = shipped.filter(|_| set != PARAMETERS);
    let made_for = read(own.unwrap_or("reference"))?;
    let wrong = adaptation_warning(machine, gain_rule::gamma(&made_for)?)?;
    Ok(wrong.map(|text| format!("with {set} in the real world: {text}")))
}

/// Runs the trials in closed loop, with systems of the folder `systems`. Their tip errors become notes,
/// and so does what is found in a trial that is no verdict, or before the motion.
fn try_in_loop(
    name: &str,
    machine: &Machine,
    systems: Option<&Path>,
    checked: &mut Checked,
) -> Result<()> {
    checked.trials = match trials::trials(name, machine, systems) {
        Ok(trials) => trials,
        // A machine without gains is not tried.
        Err(error) => {
            let none = error.downcast::<GainError>()?;
            checked.found.push(none.to_string());
            return Ok(());
        }
    };
    let Checked {
        found,
        notes,
        trials,
    } = checked;
    notes.extend(trials.iter().map(Trial::to_string));
    for trial in trials {
        let reasons = trial.reasons.iter();
        let reasons = reasons.map(|reason| format!("{}: {reason}", trial.name()));
        match trial.is_verdict() {
            true => found.extend(reasons),
            false => notes.extend(reasons),
        }
        let before = trial.before.iter();
        notes.extend(before.map(|text| format!("{}, before the motion: {text}", trial.name())));
    }
    if !found.is_empty() {
        found.push(trials::cause(machine, found)?);
    }
    Ok(())
}
