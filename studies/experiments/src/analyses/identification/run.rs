//! Runs a machine, with its sensors, along the motion that excites it, and identifies it from what
//! was measured, for the subcommand `tournament`; the results are kept on disk.
//!
//! Angles and forces are fitted by Fourier series over the run; rates and accelerations are the
//! derivatives of the fitted angles. So what oscillates faster than the joints are moved, as the
//! boom on its mounting, is left out of both.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use cosim::run::simulate::{Plan, run_plan};
use cosim::{Experiment, Port, Recording, Setting, System};
use hdrm::DOF;
use motion_check::Motion;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::estimate::{Sample, estimate};
use super::excitation::{DURATION, Excitation};
use super::model::{Condition, Model};
use crate::measures::run::{motion_end, tip_error_port};
use crate::runs::grid::Case;
use crate::runs::run_store::RunStore;
use crate::setup::machine_choice::MachineFile;
use crate::setup::start_values::{Law, path_settings};

/// Law under which machines are excited, with its shipped gains.
const LAW: &str = "modular_integral";
/// Time over which readings are averaged, s.
const BIN: f64 = 0.02;
/// Harmonics of 0.05 Hz of the fitted angles and forces: up to 1.5 Hz, three times the largest
/// frequency of the motion.
const HARMONICS: usize = 30;
/// Largest distance of a joint from its reference, rad, for the machine to count as following.
const FAR: f64 = 0.05;

/// Identifies machines.
pub struct Commissioning {
    model: Model,
    excitation: Excitation,
    folder: PathBuf,
}

/// The identification of a machine as it is kept in the store, or why it failed.
#[derive(Serialize, Deserialize)]
enum Record {
    Found(Found),
    Failed(String),
}

#[derive(Serialize, Deserialize)]
struct Found {
    /// The machine file as text, so that it is the same each time it is written.
    text: String,
    /// Residuals of the forces as in [`super::estimate::Estimate`].
    nominal: [f64; DOF],
    residual: [f64; DOF],
}

/// An identified machine.
pub struct Identification {
    /// The machine file for its controller.
    pub file: PathBuf,
    /// Residuals of the forces in the exciting run, by the nominal machine and by this one; see
    /// [`super::estimate::Estimate`].
    pub forces: [[f64; DOF]; 2],
}

/// Identified machines by the labels of their cases, or why the identification failed.
pub type Identified = BTreeMap<String, Result<Identification, String>>;

impl Commissioning {
    /// For machines whose nominal machine is that of the controller of `system`; files go into
    /// `folder`.
    pub fn new(system: &System, base: &Experiment, folder: &Path) -> Result<Self> {
        let controller = tip_error_port(system)?.component;
        let file = system.port_of(controller, "machine_file")?;
        let machine = MachineFile::from_parameter(system, &base.settings, file)?.machine;
        let model = Model::new(&machine)?;
        let commissioning = Self {
            excitation: Excitation::best(&model)?,
            model,
            folder: std::path::absolute(folder)?,
        };
        let path = commissioning.excitation.path(&machine)?;
        let file = commissioning.path();
        fs::create_dir_all(&commissioning.folder)
            .and_then(|()| write(&file, &path))
            .with_context(|| file.display().to_string())?;
        Ok(commissioning)
    }

    /// How well the excitation distinguishes the parameters.
    pub fn condition(&self) -> Condition {
        self.excitation.condition
    }

    /// The excitation as a path file.
    fn path(&self) -> PathBuf {
        self.folder.join("excitation.json")
    }

    /// Identifies the machine of every case in parallel and keeps each in `store`; `done` is called
    /// after each.
    pub fn identify(
        &self,
        (system, base): (&System, &Experiment),
        cases: &[Case],
        store: &RunStore,
        done: impl Fn() + Sync,
    ) -> Result<Identified> {
        let one = |case: &Case| {
            let found = self.identify_one((system, base), case, store);
            done();
            Ok((case.label.clone(), found?))
        };
        cases.par_iter().map(one).collect()
    }

    fn identify_one(
        &self,
        (system, base): (&System, &Experiment),
        case: &Case,
        store: &RunStore,
    ) -> Result<Result<Identification, String>> {
        let path = path_settings(system, &self.path().display().to_string())?;
        let law = Law::new(LAW, LAW).settings(system)?;
        let mut settings: Vec<Setting> = [law, path].concat();
        // Lowered gains would change what is excited.
        let supervisor = system.port_of(tip_error_port(system)?.component, "supervisor")?;
        settings.push(system.setting(&system.name(supervisor), false)?);
        let experiment = case.apply((system, base), &settings)?;
        let name = format!("identify {}", case.label);
        let record = store.load_or_make(&name, system, &experiment, || {
            Ok(match self.excite(system, &experiment) {
                Ok(found) => Record::Found(found),
                Err(error) => Record::Failed(format!("{error:#}")),
            })
        })?;
        let found = match record {
            Record::Found(found) => found,
            Record::Failed(why) => return Ok(Err(why)),
        };
        let file = format!("machine {}.json", case.label).replace(' ', "_");
        let file = self.folder.join(file);
        write(&file, &found.text).with_context(|| file.display().to_string())?;
        let forces = [found.nominal, found.residual];
        Ok(Ok(Identification { file, forces }))
    }

    /// Makes the exciting run and estimates the machine.
    fn excite(&self, system: &System, experiment: &Experiment) -> Result<Found> {
        let controller = tip_error_port(system)?.component;
        let mut ports = system.ports("zeta_measured")?;
        ports.extend(system.ports("F_measured")?);
        ports.extend(system.elements(controller, "tau_wrist", 3)?);
        let mut recording = Recording::new(system, &ports)?;
        let master = experiment.start(system)?;
        // The path begins once the tip has moved to its first point, as encoders have wrong zeros.
        let end = motion_end(system, &master).context("the excitation has no end")?;
        run_plan(system, master, &Plan::to(end), &|_, _| (), &mut recording)?;
        let samples = self.samples(&recording, &ports, end - DURATION)?;
        let estimate = estimate(&self.model, &samples, BIN)?;
        Ok(Found {
            text: serde_json::to_string_pretty(&estimate.machine)?,
            nominal: estimate.nominal,
            residual: estimate.residual,
        })
    }

    /// Samples of the motion and the forces that are fitted to means over bins.
    fn samples(&self, recording: &Recording, ports: &[Port], start: f64) -> Result<Vec<Sample>> {
        let columns: Vec<&[f64]> = (ports.iter())
            .map(|port| recording.column(*port))
            .collect::<Result<_>>()?;
        let seconds = |k: usize| recording.times[k] - start;
        let points: Vec<usize> = (recording.first_from(start)..recording.times.len()).collect();
        let bin = |k: &usize| (seconds(*k) / BIN) as u32;
        let bins: Vec<&[usize]> = points.chunk_by(|a, b| bin(a) == bin(b)).collect();
        let means = |value: &dyn Fn(usize) -> f64| {
            let mean = |bin: &&[usize]| {
                let sum = bin.iter().fold(0.0, |sum, k| sum + value(*k));
                sum / bin.len() as f64
            };
            DVector::from_iterator(bins.len(), bins.iter().map(mean))
        };
        let times = means(&seconds);
        let wave = DMatrix::from_fn(times.len(), 1 + 2 * HARMONICS, |i, j| {
            fourier_term(times[i], j)[0]
        });
        let normal = wave.transpose() * &wave;
        let normal = normal.cholesky().context("too short a run")?;
        let rest = Sample {
            motion: Motion::rest([0.0; DOF]),
            forces: [0.0; DOF],
        };
        let mut samples = vec![rest; times.len()];
        for k in 0..2 * DOF {
            let fitted = normal.solve(&(wave.transpose() * means(&|i| columns[k][i])));
            for (t, Sample { motion, forces }) in times.iter().zip(&mut samples) {
                let [value, rate, acceleration] = fourier_sum(&fitted, *t);
                if k >= DOF {
                    forces[k - DOF] = value;
                    continue;
                }
                motion.zeta[k] = value;
                motion.zeta_dot[k] = rate;
                motion.zeta_ddot[k] = acceleration;
                let off = value - self.excitation.at(*t).zeta[k];
                ensure!(
                    off.abs() < FAR,
                    "joint {} was {off:.3} rad off at {t:.2} s: it did not follow",
                    k + 1
                );
            }
        }
        Ok(samples)
    }
}

/// Writes a file unless it already has this text.
fn write(file: &Path, text: &str) -> std::io::Result<()> {
    match fs::read_to_string(file) {
        Ok(there) if there == text => Ok(()),
        _ => output_file::write(file, text),
    }
}

/// Value of a Fourier series with its derivatives.
fn fourier_sum(coefficients: &DVector<f64>, t: f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (j, c) in coefficients.iter().enumerate() {
        for (sum, value) in sum.iter_mut().zip(fourier_term(t, j)) {
            *sum += c * value;
        }
    }
    sum
}

/// Term j of the series with its derivatives: 1, then sines and cosines in turn.
fn fourier_term(t: f64, j: usize) -> [f64; 3] {
    let w = TAU / DURATION * j.div_ceil(2) as f64;
    let (sin, cos) = (w * t).sin_cos();
    if j.is_multiple_of(2) {
        [cos, -w * sin, -w * w * cos]
    } else {
        [sin, w * cos, -w * w * sin]
    }
}
