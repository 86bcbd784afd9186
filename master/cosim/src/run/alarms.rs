//! Watches the alarms that a system structure declares, for `supervision`, and keeps the first time
//! at which each holds.

use anyhow::Result;
use fmi_description::Kind;
use fmi_import::digits::short;

use crate::master::Master;
use crate::run::signals::Signals;
use crate::run::verdict::Verdict;
use crate::structure::Alarm;
use crate::structure::system::System;
use crate::wiring::Port;

/// The alarms of a run.
#[derive(Clone, Debug)]
pub(crate) struct AlarmWatch {
    signals: Signals,
    alarms: Vec<(Port, f64, Alarm)>,
    /// For each alarm the time, s, at which it first held, and the value then.
    pub raised: Vec<Option<[f64; 2]>>,
}

impl AlarmWatch {
    /// Starts at the present time of `master`.
    pub fn new(system: &System, master: &Master) -> Result<Self> {
        let alarms = system.alarms.clone();
        let ports: Vec<Port> = alarms.iter().map(|(port, ..)| *port).collect();
        let mut watch = Self {
            signals: Signals::new(system, &ports)?,
            raised: vec![None; alarms.len()],
            alarms,
        };
        watch.add(master)?;
        Ok(watch)
    }

    /// Adds the present communication point.
    pub fn add(&mut self, master: &Master) -> Result<()> {
        let values = self.signals.read(master)?;
        for (((_, bound, alarm), value), raised) in
            self.alarms.iter().zip(values).zip(&mut self.raised)
        {
            if raised.is_none() && alarm.holds(*value, *bound) {
                *raised = Some([master.time(), *value]);
            }
        }
        Ok(())
    }

    /// Adds a bad finding for each alarm that held.
    pub fn judge(&self, system: &System, verdict: &mut Verdict) {
        for ((port, _, alarm), raised) in self.alarms.iter().zip(&self.raised) {
            let Some([t, value]) = raised else { continue };
            let v = system.variable(*port);
            let item = v.items().iter().find(|item| item.value as f64 == *value);
            let shown = match (&v.kind, item) {
                (Kind::Boolean, _) => (*value != 0.0).to_string(),
                (_, Some(item)) => item.name.clone(),
                _ => short(*value),
            };
            let (text, name) = (&alarm.text, system.name(*port));
            let t = short(*t);
            verdict.object(format!("{text}: `{name}` is {shown}, first at t = {t} s"));
        }
    }
}
