//! A run of the machine with all that its verdict takes: tip error, limits and ratings, whether there was a reference.

use anyhow::{Result, bail};
use cosim::master::Master;
use cosim::run::Experiment;
use cosim::signals::{Signals, matching};
use cosim::system::System;
use cosim::verdict::Verdict;
use cosim::wiring::Port;

use crate::experiment::{self, Outcome};
use crate::machine_file::MachineFile;
use crate::verdict::{self, Watch};

/// Signals that are recorded where none are named.
const USEFUL: [&str; 13] = [
    "*.tip_error_norm",
    "*.tip_error[*]",
    "*.desired.position[*]",
    "*.tip.position[*]",
    "hdrm.zeta[*]",
    "hdrm.x[*]",
    "hdrm.x_dot[*]",
    "emla_*.F",
    "emla_*.i_d",
    "emla_*.i_q",
    "controller.v_d[*]",
    "controller.v_q[*]",
    "controller.tau_wrist[*]",
];

/// The signals that are recorded where none are named, as far as the system has them.
pub fn useful(system: &System) -> Result<Vec<Port>> {
    let ports = |pattern: &str| matching(system, &[pattern.into()]).unwrap_or_default();
    Ok(USEFUL.into_iter().flat_map(ports).collect())
}

/// As [`experiment::run`], and what the machine's limits and its reference say of the run. The verdict of the run itself is in the outcome.
///
/// # Errors
/// The run failed; the error tells what was beyond its limits until then.
pub fn run(
    system: &System,
    experiment: &Experiment,
    progress: &dyn Fn(u64, u64),
    mut observe: impl FnMut(&Master) -> Result<()>,
) -> Result<(Outcome, Verdict)> {
    let file = MachineFile::of(system, &experiment.settings)?;
    let mut watch: Option<(Watch, Signals)> = None;
    let mut verdict = Verdict::default();
    let outcome = experiment::run(system, experiment, progress, |master| {
        if watch.is_none() {
            let parameter = |port| master.number(port);
            let new = Watch::new(system, &parameter, &file)?;
            let signals = Signals::new(system, new.ports())?;
            watch = Some((new, signals));
            verdict = verdict::reference(system, &parameter)?;
        }
        if let Some((watch, signals)) = &mut watch {
            watch.add(master.time(), signals.read(master)?);
        }
        observe(master)
    });
    verdict.extend(watch.map(|(w, _)| w.verdict()).unwrap_or_default());
    match outcome {
        Ok(outcome) => Ok((outcome, verdict)),
        Err(error) if verdict.is_bad() => bail!("{error:#}\n{verdict}"),
        Err(error) => Err(error),
    }
}
