//! Evaluates a run that another importer made and wrote as CSV, for the subcommand `evaluate`: tip
//! error, tracking and verdict are computed as for a run made by this program.

use std::cmp::Ordering;
use std::fmt::Write as _;

use anyhow::{Context, Result, bail, ensure};
use cosim::{Experiment, Port, Recording, System, Verdict, start_value};
use surrogate::measurement::signal_file::SignalFile;

use crate::measures::limits::{self, LimitWatch};
use crate::measures::metrics::{Metrics, add_tracking, tip_metrics};
use crate::measures::run::{TipError, motion_start, tip_error_port};
use crate::measures::tracking::{Evaluation, Tracking};
use crate::setup::machine_choice::MachineFile;

/// Evaluates runs of an experiment that other importers made.
pub struct Evaluator<'a> {
    system: &'a System,
    motion_start: f64,
    tip_error: Port,
    tracking: Evaluation,
    limits: LimitWatch,
    reference: Verdict,
}

/// Such a run, evaluated.
pub struct ImportedRun {
    tip: TipError,
    /// None where its signals were not recorded.
    tracking: Option<Tracking>,
    /// Contains limits and ratings only where their signals were recorded.
    pub verdict: Verdict,
    /// What was not evaluated, and the signals that the file lacks for it.
    pub left_out: Vec<(&'static str, Vec<String>)>,
}

impl<'a> Evaluator<'a> {
    /// For runs of `experiment` on `system`, which must be the machine with its controller.
    pub fn new(system: &'a System, experiment: &Experiment) -> Result<Self> {
        let settings = &experiment.settings;
        let parameter = |port| start_value(system, settings, port);
        let file = MachineFile::from_manipulator(system, settings)?;
        Ok(Self {
            system,
            motion_start: motion_start(system, experiment)?,
            tip_error: tip_error_port(system)?,
            tracking: Evaluation::new(system, experiment)?,
            limits: LimitWatch::new(system, &parameter, Some(&file))?,
            reference: limits::check_reference(system, experiment, &parameter)?,
        })
    }

    /// Names of all signals that it can evaluate, each once.
    pub fn signals(&self) -> Vec<String> {
        let mut ports = vec![self.tip_error];
        for port in self.tracking.ports().iter().chain(self.limits.ports()) {
            if !ports.contains(port) {
                ports.push(*port);
            }
        }
        ports.into_iter().map(|p| self.system.name(p)).collect()
    }

    /// Evaluates a run; the verdict is bad where the tip error exceeds `max_error`, m. The file must
    /// have the tip error.
    pub fn evaluate(mut self, file: &SignalFile, max_error: Option<f64>) -> Result<ImportedRun> {
        let times = file.times();
        ensure!(!times.is_empty(), "there are no rows");
        let rises = |pair: &[f64]| pair[0].partial_cmp(&pair[1]) == Some(Ordering::Less);
        if let Some(k) = times.windows(2).position(|pair| !rises(pair)) {
            let (before, after) = (times[k], times[k + 1]);
            bail!("times must rise, but {after} s comes after {before} s");
        }
        let name = self.system.name(self.tip_error);
        let errors = file.column(&name);
        let errors = errors.with_context(|| format!("it has no signal `{name}`"))?;
        let mut tip = TipError::new(self.motion_start);
        times.iter().zip(errors).for_each(|(t, e)| tip.add(*t, *e));
        let mut left_out = Vec::new();
        let mut verdict = self.reference;
        let ports = self.tracking.ports();
        let tracking = match columns(self.system, file, &ports) {
            Ok(columns) => {
                let columns = columns.into_iter().map(<[f64]>::to_vec).collect();
                let (system, times) = (self.system, times.to_vec());
                let recording = Recording::from_columns(system, &ports, times, columns)?;
                Some(self.tracking.evaluate(&recording, self.motion_start)?)
            }
            Err(missing) => {
                left_out.push(("tracking and orientation", missing));
                None
            }
        };
        match columns(self.system, file, self.limits.ports()) {
            Ok(columns) => {
                for (k, t) in times.iter().enumerate() {
                    let row: Vec<f64> = columns.iter().map(|column| column[k]).collect();
                    self.limits.add(*t, &row);
                }
                verdict.extend(self.limits.verdict(|_| false));
            }
            Err(missing) => left_out.push(("limits and ratings", missing)),
        }
        verdict.extend(tip.verdict(max_error));
        Ok(ImportedRun {
            tip,
            tracking,
            verdict,
            left_out,
        })
    }
}

impl ImportedRun {
    /// Its metrics by name.
    pub fn metrics(&self) -> Metrics {
        let mut metrics = tip_metrics(&self.tip);
        if let Some(tracking) = &self.tracking {
            add_tracking(&mut metrics, tracking);
        }
        metrics
    }

    /// As text for people.
    pub fn text(&self) -> String {
        let mut text = self.tip.text();
        if let Some(t) = &self.tracking {
            let [rms, max] = t.orientation.map(f64::to_degrees);
            let _ = writeln!(
                text,
                "error of the plant's tip: RMSE {:.4} mm, max {:.4} mm; of its orientation: RMS {rms:.4}°, max {max:.4}°",
                1e3 * t.plant.rmse,
                1e3 * t.plant.max
            );
        }
        for (what, missing) in &self.left_out {
            let _ = writeln!(
                text,
                "not evaluated: {what}, because the file does not have {}",
                missing.join(", ")
            );
        }
        text + &self.verdict.to_string()
    }
}

/// Columns of the file for these variables, else the names of the columns that it lacks.
fn columns<'a>(
    system: &System,
    file: &'a SignalFile,
    ports: &[Port],
) -> Result<Vec<&'a [f64]>, Vec<String>> {
    let (mut columns, mut missing) = (Vec::new(), Vec::new());
    for name in ports.iter().map(|port| system.name(*port)) {
        match file.column(&name) {
            Some(column) => columns.push(column),
            None => missing.push(name),
        }
    }
    missing.dedup();
    if missing.is_empty() {
        Ok(columns)
    } else {
        Err(missing)
    }
}
