//! The conditions of a run, and the running system that they give.

use std::sync::Arc;

use anyhow::{Context, Result};

use crate::exchange::faults::Faults;
use crate::io::input_table::{InputTable, Table};
use crate::master::{Master, Stepping};
use crate::structure::system::{Setting, System};
use fmi_import::messages;

/// Conditions of a run.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Start, communication step and schedule.
    pub stepping: Stepping,
    /// Threads that the components are shared out to.
    pub threads: usize,
    /// Stop time, s, where it is not that of the system's default experiment.
    pub stop: Option<f64>,
    /// Start values, applied in this order after those of the system.
    pub settings: Vec<Setting>,
    /// What is done to values on their way: noise and other faults, events of a scenario.
    pub faults: Faults,
    /// Values over time for inputs that no connection drives.
    pub inputs: Option<Arc<Table>>,
}

impl Experiment {
    /// The initialized system at its start time.
    pub fn start(&self, system: &System) -> Result<Master> {
        messages::take();
        let mut master = Master::side_by_side(system, &self.settings, self.stepping, self.threads)?;
        if let Some(table) = &self.inputs {
            master.feed(InputTable::new(system, table)?)?;
        }
        if !self.faults.list.is_empty() {
            master.alter(system, &self.faults)?;
        }
        Ok(master)
    }

    /// The stop time asked for, else that of the system's default experiment, s.
    pub fn stop(&self, system: &System) -> Result<f64> {
        let stop = self.stop.or(system.structure.stop_time);
        stop.context("neither a stop time is given nor has the system structure one")
    }
}
