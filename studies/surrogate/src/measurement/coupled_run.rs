//! A coupled run of the machine on rigs, of `experiments` or, for `surrogate loop`, of a CSV file
//! of `hdrm-fmu run`: tip errors, currents, and true values of its actuators in windows of 20 ms.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use emla::maps;
use machine_file::Emla;

use crate::measurement::signal_file::SignalFile;
use crate::measurement::windows::{ACTUATOR_SIGNALS, SAMPLES, SLOWEST, Truth};

const TIP_ERROR: &str = "controller.tip_error_norm";
const REQUIRED_CURRENT: &str = "controller.i_q_required";

/// Columns of one actuator.
#[derive(Clone, Debug)]
struct Axis {
    i_q_required: Vec<f64>,
    /// In the order of [`ACTUATOR_SIGNALS`].
    own: Vec<Vec<f64>>,
}

/// The signals of a coupled run.
#[derive(Clone, Debug)]
pub struct CoupledRun {
    /// Communication step, s.
    h: f64,
    time: Vec<f64>,
    tip_error: Vec<f64>,
    axes: Vec<Axis>,
}

impl CoupledRun {
    /// Reads the file, which must hold all of [`CoupledRun::signals`] as numbers.
    pub fn read(path: &Path) -> Result<Self> {
        let file = SignalFile::read(path)?;
        let column = |signal: &str| {
            let column = file.column(signal).map(<[f64]>::to_vec);
            column.with_context(|| {
                format!("signal `{signal}` is missing; record a run on rigs with --signals \"*\"")
            })
        };
        Self::new(file.times().to_vec(), column).with_context(|| path.display().to_string())
    }

    /// Takes the times, s, and the column of each of [`CoupledRun::signals`] from `column`. Fails if
    /// a signal is missing, or there are too few rows.
    pub fn new(time: Vec<f64>, column: impl Fn(&str) -> Result<Vec<f64>>) -> Result<Self> {
        if time.len() < 2 * SAMPLES {
            bail!("{} rows, at least {} are needed", time.len(), 2 * SAMPLES);
        }
        let axis = |k: u32| -> Result<Axis> {
            let own = ACTUATOR_SIGNALS.map(|signal| column(&format!("emla_{k}.{signal}")));
            Ok(Axis {
                own: own.into_iter().collect::<Result<_>>()?,
                i_q_required: column(&format!("{REQUIRED_CURRENT}[{k}]"))?,
            })
        };
        Ok(Self {
            h: time[1] - time[0],
            tip_error: column(TIP_ERROR)?,
            axes: [1, 2, 3].map(axis).into_iter().collect::<Result<_>>()?,
            time,
        })
    }

    /// Names of the signals that are needed.
    pub fn signals() -> Vec<String> {
        let of_axis = |k: u32| {
            let own = ACTUATOR_SIGNALS.map(|signal| format!("emla_{k}.{signal}"));
            own.into_iter().chain([format!("{REQUIRED_CURRENT}[{k}]")])
        };
        let mut names: Vec<String> = [1, 2, 3].into_iter().flat_map(of_axis).collect();
        names.push(TIP_ERROR.into());
        names
    }

    /// Times, s, from `start` on, with the required and the true current of an axis, A.
    pub fn currents(&self, axis: usize, start: f64) -> [&[f64]; 3] {
        let (first, a) = (self.first_row(start), &self.axes[axis]);
        [&self.time, &a.i_q_required, a.i_q()].map(|course| &course[first..])
    }

    fn first_row(&self, start: f64) -> usize {
        self.time.partition_point(|&t| t < start)
    }

    /// Tip errors from `start`, s, on, m.
    pub fn tip_errors(&self, start: f64) -> impl Iterator<Item = f64> + '_ {
        self.tip_error[self.first_row(start)..].iter().copied()
    }

    /// Required less true currents of all axes from `start`, s, on, A.
    pub fn current_errors(&self, start: f64) -> impl Iterator<Item = f64> + '_ {
        let first = self.first_row(start);
        self.axes
            .iter()
            .flat_map(move |a| (first..a.i_q().len()).map(move |k| a.i_q_required[k] - a.i_q()[k]))
    }

    /// The true values of all axes in windows from `start`, s, on in which the rod moves one way.
    pub fn windows(&self, p: &Emla, start: f64) -> Vec<Truth> {
        let windows = (0..self.axes.len()).flat_map(|axis| self.axis_windows(axis, p, start));
        windows.map(|(_, truth)| truth).collect()
    }

    /// The same of one axis, each with the time of its middle, s.
    pub fn axis_windows(&self, axis: usize, p: &Emla, start: f64) -> Vec<(f64, Truth)> {
        let (first, axis) = (self.first_row(start), &self.axes[axis]);
        let count = (self.time.len() - first).saturating_sub(1) / SAMPLES;
        let window = |k: usize| {
            let begin = first + k * SAMPLES;
            let middle = self.time[begin] + 0.5 * SAMPLES as f64 * self.h;
            Some((middle, axis.window(p, begin, self.h)?))
        };
        (0..count).filter_map(window).collect()
    }
}

impl Axis {
    fn i_q(&self) -> &[f64] {
        &self.own[0]
    }

    fn w_m(&self) -> &[f64] {
        &self.own[4]
    }

    /// The window that begins at row `first`, if the rod moves one way in it.
    fn window(&self, p: &Emla, first: usize, h: f64) -> Option<Truth> {
        let travel = maps::travel_per_radian(p);
        let moves = |sign: f64| {
            let mut speeds = self.w_m()[first..=first + SAMPLES].iter();
            speeds.all(|w| sign * travel * w > SLOWEST)
        };
        let truth = || Truth::new(p, first, SAMPLES as f64 * h, |s, k| self.own[s][k]);
        (moves(1.0) || moves(-1.0)).then(truth)
    }
}
