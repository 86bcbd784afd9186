//! Options of `cosim run` for variable or repeated communication steps, and for snapshots: when
//! they are saved, and from which one a run is resumed.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;

use crate::run::simulate::{Experiment, Plan};
use crate::stepping::{StepControl, StepLimits};
use crate::structure::system::System;
use fmi_import::digits::short;

/// How long communication steps are, and where a run is saved or resumed.
#[derive(Args, Clone)]
pub struct StepArgs {
    /// Choose the communication step, beginning with the shortest, by the energy that the coupling
    /// creates or loses at the power bonds over a step: at most about this part of the energy that
    /// is transferred
    #[arg(long, value_name = "TOLERANCE", conflicts_with_all = ["doubling_tolerance", "interval"])]
    pub energy_tolerance: Option<f64>,
    /// Energy added to that of a step before --energy-tolerance is applied, J: it keeps the
    /// tolerance from vanishing with the energy
    #[arg(
        long,
        value_name = "JOULE",
        default_value_t = 1.0,
        requires = "energy_tolerance",
        conflicts_with_all = ["doubling_tolerance", "interval"]
    )]
    pub energy_scale: f64,
    /// Choose the communication step, beginning with --step, by comparison with two steps of half
    /// the length: connected outputs may differ by this part of the sum of nominal value and
    /// output; steps are repeated as with --repeat-steps
    #[arg(long, value_name = "TOLERANCE", conflicts_with_all = ["interval", "repeat_steps"])]
    pub doubling_tolerance: Option<f64>,
    /// Repeat a step within which a component stops, with all components to where it stopped; with
    /// --energy-tolerance also one that creates or loses more than twice the allowed energy
    #[arg(long, conflicts_with = "interval")]
    pub repeat_steps: bool,
    /// Shortest and longest step, s
    #[arg(long, value_name = "SHORTEST,LONGEST", value_parser = numbers::<2>)]
    pub step_limits: Option<[f64; 2]>,
    /// Smallest and largest factor from one step to the next
    #[arg(long, value_name = "LEAST,LARGEST", value_parser = numbers::<2>)]
    pub step_change: Option<[f64; 2]>,
    /// Safety, and with --energy-tolerance proportional and integral gain of the controller that
    /// chooses steps
    #[arg(long, value_name = "SAFETY,P,I", value_parser = numbers::<3>)]
    pub step_controller: Option<[f64; 3]>,
    /// Save the run to this file at the first communication point at or after a time, s; repeatable
    #[arg(long = "snapshot", value_name = "TIME=FILE")]
    pub snapshots: Vec<String>,
    /// Resume from a file of --snapshot, of the same system with the same options; only the stop
    /// time may be another
    #[arg(long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
}

impl StepArgs {
    /// The plan of a run of `experiment` on `system` with these arguments.
    pub fn plan(&self, system: &System, experiment: &Experiment) -> Result<Plan> {
        let stop = experiment.stop(system)?;
        let mut snapshots = Vec::new();
        for text in &self.snapshots {
            let parts = text.split_once('=');
            let time = parts.and_then(|(time, _)| time.trim().parse().ok());
            let (time, (_, file)): (f64, _) = (time.zip(parts))
                .with_context(|| format!("--snapshot {text}: it must be TIME=FILE"))?;
            ensure!(
                time <= stop,
                "--snapshot {text}: the run ends before, at {} s",
                short(stop)
            );
            output_file::claim(Path::new(file))?;
            snapshots.push((time, PathBuf::from(file)));
        }
        if let Some(file) = &self.resume {
            output_file::note_read(file)?;
        }
        let mut plan = Plan {
            stop,
            control: self.control()?,
            snapshots,
            resume: self.resume.clone(),
            ..Plan::default()
        };
        if plan.resume.is_some() || !plan.snapshots.is_empty() {
            plan.key = Some(plan.key(system, experiment));
        }
        Ok(plan)
    }

    fn control(&self) -> Result<StepControl> {
        let mut limits = StepLimits::default();
        limits.length = self.step_limits.unwrap_or(limits.length);
        limits.change = self.step_change.unwrap_or(limits.change);
        if let Some([safety, proportional, integral]) = self.step_controller {
            (limits.safety, limits.proportional) = (safety, proportional);
            limits.integral = integral;
        }
        let given = [
            (self.step_limits.is_some(), "--step-limits"),
            (self.step_change.is_some(), "--step-change"),
            (self.step_controller.is_some(), "--step-controller"),
        ];
        let given = given.iter().find(|(is_given, _)| *is_given);
        Ok(
            match (self.energy_tolerance, self.doubling_tolerance, given) {
                (Some(tolerance), ..) => StepControl::Energy {
                    tolerance,
                    scale: self.energy_scale,
                    repeats: self.repeat_steps,
                    limits,
                },
                (_, Some(tolerance), _) => StepControl::Doubling { tolerance, limits },
                (.., Some((_, option))) => bail!(
                    "{option} needs --energy-tolerance or --doubling-tolerance, which choose steps"
                ),
                _ if self.repeat_steps => StepControl::Repeated,
                _ => StepControl::Fixed,
            },
        )
    }
}

/// Parses numbers with commas between them.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers = text.split(',').map(|number| number.trim().parse().ok());
    let numbers: Option<Vec<f64>> = numbers.collect();
    let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| format!("it must be {N} numbers with commas between them"))
}
