//! Trials of a machine in closed loop, for `hdrm-fmu machine check`: its triangular path in the
//! ideal and in the real world, each with full and with empty hook, with the gains that a run takes.
//!
//! Limits and ratings count from the start of the motion on. Before, a controller that takes an empty
//! hook for a full one has not weighed it yet: for some milliseconds it asks for forces that the
//! wrist's inertia does not resist. What it exceeds there is a note.

use std::fmt;
use std::path::Path;

use anyhow::Result;
use cosim::Master;
use cosim::run::observer::Function;
use cosim::run::verdict::Verdict;
use machine_file::Machine;
use motion_check::Reach;
use motion_check::gain_rule;

use crate::measures::run::{FailedRun, MachineWatch, motion_start, run};
use crate::setup::machine_choice::MachineFile;
use crate::setup::run_setup::{MachineArgs, RunSetup};
use crate::setup::start_values::{SHIPPED, vary};
use crate::worlds::World;

/// Largest tip error of a machine that is kept, m, at a reach of [`REACH`], and in proportion.
const LARGEST_ERROR: f64 = 2e-3;
/// Reach of the machine for which that holds, m.
const REACH: f64 = 4.5;
/// What a machine needs whose motors or rods are too slow.
const TOO_FAST: &str = "the path of `trajectories.triangular` is too fast for motors, gears and screws: a longer `edge_time`, shorter edges, a \
                        smaller `N_gear` or a larger `rho`";
/// Findings that are told of a trial.
const TOLD: usize = 3;

/// A trial and what was found.
pub struct Trial {
    /// World.
    pub world: World,
    /// Whether the hook is full.
    pub is_full: bool,
    /// Root mean square and maximum of the tip error over the motion, m; None: the run failed.
    pub error: Option<[f64; 2]>,
    /// Reasons for which the machine is not kept.
    pub reasons: Vec<String>,
    /// What was exceeded before the motion, where nothing was in it.
    pub before: Vec<String>,
}

/// Runs the four trials of the machine with this name or file; the systems are those of the folder
/// `systems`, by default as the commands find them.
pub fn trials(name: &str, machine: &Machine, systems: Option<&Path>) -> Result<Vec<Trial>> {
    let arguments = MachineArgs::of(name);
    let setups = [World::Ideal, World::Real].map(|world| {
        let mut setup = arguments.setup().world(world);
        if let Some(folder) = systems {
            setup = setup.packed(&folder.join(world.system()));
        }
        Ok((world, setup.build()?))
    });
    let mut done = Vec::new();
    for (world, setup) in setups.into_iter().collect::<Result<Vec<_>>>()? {
        for is_full in [true, false] {
            done.push(trial(&setup, machine, world, is_full)?);
        }
    }
    Ok(done)
}

fn trial(setup: &RunSetup, machine: &Machine, world: World, is_full: bool) -> Result<Trial> {
    let mode = if world == World::Ideal {
        "adaptive"
    } else {
        SHIPPED
    };
    let mut values: Vec<(&str, &dyn fmt::Display)> =
        vec![("trajectory", &"triangular"), ("mode", &mode)];
    if !is_full {
        values.push(("hdrm.payload.mass", &0));
    }
    let experiment = vary(&setup.system, &setup.base, &values)?;
    let from = motion_start(&setup.system, &experiment)?;
    let file = MachineFile::from_plant(&setup.system, &experiment.settings)?;
    let mut in_motion = None::<MachineWatch>;
    let done = run(
        &setup.system,
        &experiment,
        &|_, _| (),
        &mut Function(|master: &Master| {
            if master.time() < from {
                return Ok(());
            }
            let new = || MachineWatch::new(&setup.system, &experiment, master, file.as_ref());
            match &mut in_motion {
                Some(watch) => watch.add(master),
                none => none.insert(new()?).add(master),
            }
        }),
    );
    let (mut reasons, mut before, error) = match done {
        Ok(outcome) => {
            let mut verdict = outcome.run.verdict.clone();
            let limits = in_motion.map(|watch| watch.verdict(&setup.system, true));
            verdict.extend(limits.unwrap_or_default());
            let motion = &outcome.tip.motion;
            let error = [motion.rms(), motion.max];
            (bad(&verdict), bad(&outcome.limits), Some(error))
        }
        Err(error) => {
            let mut verdict = FailedRun::limits_before(&error);
            verdict.object(format!("{error:#}"));
            (bad(&verdict), Vec::new(), None)
        }
    };
    if !reasons.is_empty() {
        before.clear();
    }
    let strays = error.and_then(|[rms, _]| strays(machine, rms));
    reasons.splice(0..0, strays);
    Ok(Trial {
        world,
        is_full,
        error,
        reasons,
        before,
    })
}

/// A sentence if the root mean square of the tip error, m, is too large for the machine's reach.
pub fn strays(machine: &Machine, rms: f64) -> Option<String> {
    let allowed = LARGEST_ERROR * Reach::new(&machine.geometry).length() / REACH;
    let is_kept = rms <= allowed;
    let (rms, allowed) = (1e3 * rms, 1e3 * allowed);
    (!is_kept).then(|| format!("tip error {rms:.2} mm, more than {allowed:.2} mm for its reach"))
}

/// The first findings that spoil a run.
fn bad(verdict: &Verdict) -> Vec<String> {
    let bad = verdict.findings().iter().filter(|finding| finding.is_bad);
    bad.take(TOLD).map(|finding| finding.text.clone()).collect()
}

/// What makes a machine swing, or asks too much of it, given what the trials found.
pub fn cause(machine: &Machine, found: &[String]) -> Result<String> {
    if found.iter().any(|line| line.contains("speed of ")) {
        return Ok(TOO_FAST.into());
    }
    let ruled = gain_rule::ideal_gains(machine)?;
    let mut as_run = machine.clone();
    gain_rule::take(&mut as_run.controller, &ruled);
    let (mode, motor) = gain_rule::least_damped(&as_run)?;
    let mut text = format!(
        "least damped mode of the loop: {:.1} % at {:.1} Hz; a motor weighs up to {motor:.1} times its boom at the rod",
        100.0 * mode.damping,
        mode.hertz
    );
    // In the real world the rule's gains act, whatever the file says.
    let ideal = World::Ideal.name();
    let is_ideal = found.iter().any(|line| line.starts_with(&ideal));
    for said in gain_rule::said(machine)?.iter().filter(|_| is_ideal) {
        text += &format!(
            "; `controller.{}` = {} is said by the file, the rule gives {}",
            said.name,
            gain_rule::gain(&machine.controller, said.name),
            said.value
        );
    }
    Ok(text)
}

impl Trial {
    /// World and hook: `real world, hook empty`.
    pub fn name(&self) -> String {
        let hook = if self.is_full { "full" } else { "empty" };
        format!("{} world, hook {hook}", self.world.name())
    }

    /// Whether what is found makes the machine unfit. In the ideal world the controller takes the
    /// file's payload for known and does not weigh: with an empty hook that is wrong by design.
    pub fn is_verdict(&self) -> bool {
        self.is_full || self.world != World::Ideal
    }
}

impl fmt::Display for Trial {
    /// A line: `real world, hook empty: tip error RMSE 0.021 mm, max 0.060 mm`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.name())?;
        match self.error {
            Some([rms, max]) => {
                let [rms, max] = [rms, max].map(|metres| 1e3 * metres);
                write!(f, "tip error RMSE {rms:.3} mm, max {max:.3} mm")
            }
            None => write!(f, "the run failed"),
        }
    }
}
