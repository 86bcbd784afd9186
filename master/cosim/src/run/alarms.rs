//! Watches the alarms that a system structure declares, for `supervision`: at every communication
//! point the variables are read in batches, and the first time at which an alarm holds is kept.

use std::collections::BTreeMap;
use std::sync::Arc;

use anyhow::Result;

use crate::exchange::{Read, reads};
use crate::instance::At;
use crate::master::Master;
use crate::run::verdict::Verdict;
use crate::structure::alarm::PortAlarm;
use crate::structure::system::System;

/// Time, s, at which an alarm first held, and the value then.
pub(crate) type Raised = Option<(f64, f64)>;

/// The alarms of a run.
#[derive(Clone, Debug)]
pub(crate) struct AlarmWatch {
    reads: Arc<Vec<Read>>,
    values: Vec<f64>,
    /// The alarms with the slots of their values.
    alarms: Arc<Vec<(PortAlarm, usize)>>,
    /// What is known of each alarm.
    pub raised: Vec<Raised>,
}

impl AlarmWatch {
    /// Starts at the present time of `master`.
    pub fn new(system: &System, master: &Master) -> Result<Self> {
        let (alarms, mut slots) = (system.alarms()?, BTreeMap::new());
        let ports = alarms.iter().map(|alarm| alarm.port);
        let reads = reads(&system.wiring()?, ports, &mut slots);
        let with_slot = |alarm: PortAlarm| {
            let slot = slots[&alarm.port];
            (alarm, slot)
        };
        let mut watch = Self {
            reads: Arc::new(reads),
            values: vec![0.0; slots.len()],
            raised: vec![None; alarms.len()],
            alarms: Arc::new(alarms.into_iter().map(with_slot).collect()),
        };
        watch.add(master)?;
        Ok(watch)
    }

    /// Adds the present communication point.
    pub fn add(&mut self, master: &Master) -> Result<()> {
        for read in self.reads.iter() {
            read.run(master.instances(), &mut self.values, At::Time(master.time()))?;
        }
        for ((alarm, slot), raised) in self.alarms.iter().zip(&mut self.raised) {
            let value = self.values[*slot];
            if raised.is_none() && alarm.holds(value) {
                *raised = Some((master.time(), value));
            }
        }
        Ok(())
    }

    /// Adds a bad finding for each alarm that held.
    pub fn judge(&self, system: &System, verdict: &mut Verdict) {
        for ((alarm, _), raised) in self.alarms.iter().zip(&self.raised) {
            if let Some((t, value)) = raised {
                verdict.object(alarm.describe(system, *value, *t));
            }
        }
    }
}
