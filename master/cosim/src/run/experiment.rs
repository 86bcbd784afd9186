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

/// Conditions of a run.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Start, communication step and schedule.
    pub stepping: Stepping,
    /// Threads that share the components.
    pub threads: usize,
    /// Stop time, s; None for that of the system's default experiment.
    pub stop: Option<f64>,
    /// Start values, applied in this order after those of the system.
    pub settings: Vec<Setting>,
    /// Faults, noise and events of a scenario, which alter values on their way.
    pub faults: Faults,
    /// Values over time for inputs that no connection drives.
    pub inputs: Option<Arc<Table>>,
}

impl Experiment {
    /// The initialized system at its start time.
    pub fn start(&self, system: &System) -> Result<Master> {
        messages::take();
        let mut master = Master::with_threads(system, &self.settings, self.stepping, self.threads)?;
        if let Some(table) = &self.inputs {
            master.feed(InputTable::new(system, table)?)?;
        }
        if !self.faults.list.is_empty() {
            master.apply_faults(system, &self.faults)?;
        }
        Ok(master)
    }

    /// The variables to which the experiment gives values: by start values, by inputs over time, and
    /// by faults and events of a scenario.
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
