//! Records chosen variables at communication points in memory, for Python and the studies.

use anyhow::{Context, Result, ensure};

use crate::master::Master;
use crate::run::signals::Signals;
use crate::structure::system::System;
use crate::wiring::Port;

/// Recorded signals.
#[derive(Clone)]
pub struct Recording {
    /// Communication points, s.
    pub times: Vec<f64>,
    signals: Signals,
    columns: Vec<Vec<f64>>,
}

impl Recording {
    /// An empty recording of the variables `ports`.
    pub fn new(system: &System, ports: &[Port]) -> Result<Self> {
        let columns = vec![Vec::new(); ports.len()];
        Self::from_columns(system, ports, Vec::new(), columns)
    }

    /// A recording of another program: a column of values at `times`, s, for each of the variables
    /// `ports`.
    ///
    /// # Errors
    /// Too few columns, or one whose length is not that of `times`.
    pub fn from_columns(
        system: &System,
        ports: &[Port],
        times: Vec<f64>,
        columns: Vec<Vec<f64>>,
    ) -> Result<Self> {
        let is_whole = columns.iter().all(|column| column.len() == times.len());
        ensure!(
            is_whole && columns.len() == ports.len(),
            "every variable needs one value at each of {} times",
            times.len()
        );
        Ok(Self {
            times,
            signals: Signals::new(system, ports)?,
            columns,
        })
    }

    /// Adds the present communication point.
    pub fn add(&mut self, master: &Master) -> Result<()> {
        self.times.push(master.time());
        let values = self.signals.read(master)?;
        for (column, value) in self.columns.iter_mut().zip(values) {
            column.push(*value);
        }
        Ok(())
    }

    /// Index of the first communication point at or after a time, s.
    pub fn first_from(&self, time: f64) -> usize {
        self.times.partition_point(|t| *t < time)
    }

    /// Values of a recorded variable.
    pub fn column(&self, port: Port) -> Result<&[f64]> {
        let k = self.signals.ports().iter().position(|p| *p == port);
        Ok(&self.columns[k.context("the variable was not recorded")?])
    }
}
