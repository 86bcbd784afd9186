//! A run kept in memory: the chosen signals at every communication point, by name.

use anyhow::{Context, Result};

use crate::run::{Experiment, Outcome};
use crate::signals::Signals;
use crate::system::System;

/// Signals over a run.
pub struct Recording {
    /// Communication points, s.
    pub times: Vec<f64>,
    /// What else came out.
    pub outcome: Outcome,
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl Recording {
    /// Run the experiment and keep the signals that `patterns` choose.
    pub fn of(
        system: &System,
        experiment: &Experiment,
        patterns: &[String],
        progress: impl Fn(u64, u64),
    ) -> Result<Self> {
        let mut signals = Signals::choose(system, patterns)?;
        let without_unit = |title: &String| title.split(" [").next().unwrap_or(title).to_string();
        let names: Vec<String> = signals.titles.iter().map(without_unit).collect();
        let mut columns = vec![Vec::new(); names.len()];
        let mut times = Vec::new();
        let outcome = experiment.watch(system, progress, Some(&mut signals), |t, row| {
            times.push(t);
            for (column, value) in columns.iter_mut().zip(row) {
                column.push(*value);
            }
            Ok(())
        })?;
        Ok(Self {
            times,
            outcome,
            names,
            columns,
        })
    }

    /// Values of `component.variable`.
    pub fn column(&self, name: &str) -> Result<&[f64]> {
        let k = self.names.iter().position(|n| n == name);
        let k = k.with_context(|| format!("`{name}` was not recorded"))?;
        Ok(&self.columns[k])
    }

    /// Index of the first communication point of the motion, 0 where the system tells of none.
    pub fn motion_start(&self) -> usize {
        let start = self
            .outcome
            .tip
            .map_or(f64::NEG_INFINITY, |tip| tip.motion_start);
        self.times.partition_point(|t| *t < start)
    }
}
