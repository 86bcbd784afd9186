//! An experiment: the conditions of a run (step, threads, start values, inputs, faults). Programs,
//! Python and pages start the initialized system from it.

use std::collections::BTreeSet;
use std::sync::Arc;

use anyhow::{Context, Result};

use crate::exchange::faults::Faults;
use crate::io::input_table::{InputTable, Table};
use crate::master::{Master, Stepping};
use crate::structure::system::{Setting, System};
use crate::wiring::Port;
use fmi_import::messages;
use fmi_import::raw::Experiment as FmiExperiment;

/// Conditions of a run.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Start, communication step and schedule.
    pub stepping: Stepping,
    /// Threads that share the components.
    pub threads: usize,
    /// Stop time, s; None for that of the system's default experiment.
    pub stop: Option<f64>,
    /// Relative tolerance that the FMUs are told; None for each one's own.
    pub tolerance: Option<f64>,
    /// Start values, applied in this order after those of the system.
    pub settings: Vec<Setting>,
    /// Faults, noise and events of a scenario, which alter values on their way.
    pub faults: Faults,
    /// Values over time for inputs that no connection drives.
    pub inputs: Option<Arc<Table>>,
    /// Variables that may have values that are not finite.
    pub nonfinite: Vec<Port>,
}

impl Experiment {
    /// Steps on one thread to the stop time of the system, with nothing given.
    pub fn new(stepping: Stepping) -> Self {
        Self {
            stepping,
            threads: 1,
            stop: None,
            tolerance: None,
            settings: Vec::new(),
            faults: Faults::default(),
            inputs: None,
            nonfinite: Vec::new(),
        }
    }

    /// The initialized system at its start time.
    pub fn start(&self, system: &System) -> Result<Master> {
        self.start_until(system, None)
    }

    /// The same for a run that ends at `stop`, s, at the latest, which the FMUs are told.
    pub fn start_until(&self, system: &System, stop: Option<f64>) -> Result<Master> {
        messages::take();
        let (settings, stepping, threads) = (&self.settings, self.stepping, self.threads);
        // One that is no stop time is refused by name when the run begins.
        let stop = stop.filter(|stop| *stop > stepping.start);
        let told = FmiExperiment {
            start: stepping.start,
            has_stop: stop.is_some(),
            stop: stop.map_or(0.0, |stop| told_stop(system, stepping, stop)),
            has_tolerance: self.tolerance.is_some(),
            tolerance: self.tolerance.unwrap_or_default(),
        };
        let nonfinite = &self.nonfinite;
        let mut master =
            Master::for_experiment(system, settings, stepping, threads, told, nonfinite)?;
        if let Some(table) = &self.inputs {
            master.feed(InputTable::new(system, table)?)?;
        }
        if !self.faults.list.is_empty() {
            master.apply_faults(system, &self.faults)?;
        }
        Ok(master)
    }

    /// The variables to which the experiment gives values: by start values, by inputs over time,
    /// and by faults and events of a scenario.
    pub fn given(&self, system: &System) -> Result<BTreeSet<Port>> {
        let mut given: BTreeSet<Port> = self.settings.iter().map(|s| s.port).collect();
        given.extend(self.faults.list.iter().map(|fault| fault.port));
        if let Some(table) = &self.inputs {
            given.extend(InputTable::new(system, table)?.ports());
        }
        Ok(given)
    }

    /// The stop time that is given, else that of the system's default experiment, s.
    pub fn stop(&self, system: &System) -> Result<f64> {
        let stop = self.stop.or(system.structure.stop_time);
        stop.context("no stop time is given, and the system structure has none")
    }
}

/// The stop time that FMUs are told, s: rounding may let the last step end just after that of the
/// run, and an FMU may refuse a step that passes its stop time.
fn told_stop(system: &System, stepping: Stepping, stop: f64) -> f64 {
    let Stepping { start, step, .. } = stepping;
    let last = start + (((stop - start) / step + 1e-6).floor() - 1.0) * step;
    match system.structure.rates.is_empty() {
        true => stop.max(last + step),
        false => stop.max(last + step).next_up().next_up(),
    }
}
