//! Signals of a run kept in memory.

use anyhow::{Context, Result};

use crate::master::Master;
use crate::signals::Signals;
use crate::system::System;
use crate::wiring::Port;

/// Signals at the communication points that were recorded.
pub struct Recording {
    /// Communication points, s.
    pub times: Vec<f64>,
    signals: Signals,
    columns: Vec<Vec<f64>>,
}

impl Recording {
    /// An empty recording of the variables `ports`.
    pub fn new(system: &System, ports: &[Port]) -> Result<Self> {
        Ok(Self {
            times: Vec::new(),
            signals: Signals::new(system, ports)?,
            columns: vec![Vec::new(); ports.len()],
        })
    }

    /// Add the present communication point.
    pub fn add(&mut self, master: &Master) -> Result<()> {
        self.times.push(master.time());
        let values = self.signals.read(master)?;
        for (column, value) in self.columns.iter_mut().zip(values) {
            column.push(*value);
        }
        Ok(())
    }

    /// Values of a recorded variable.
    pub fn column(&self, port: Port) -> Result<&[f64]> {
        let k = self.signals.ports().iter().position(|p| *p == port);
        Ok(&self.columns[k.context("a variable that was not recorded is asked for")?])
    }
}
