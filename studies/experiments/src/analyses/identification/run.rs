//! The run that excites a machine, with its sensors, and what is kept of it.
//!
//! Angles and forces are fitted by Fourier series over the run; the derivatives of those of the
//! angles are the rates and accelerations. So what swings faster than the joints are moved, as the
//! boom on its mounting, is left out on both sides.

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

use super::estimate::{Estimate, Sample, estimate};
use super::excitation::{DURATION, Excitation};
use super::model::{Condition, Model};
use crate::measures::run::{motion_end, tip_error_port};
use crate::runs::grid::Case;
use crate::runs::run_store::RunStore;
use crate::setup::machine_choice::MachineFile;
use crate::setup::start_values::{Law, on_path};

/// Law under which machines are excited, as shipped.
const LAW: &str = "modular_integral";
/// Time over which readings are averaged, s.
const BIN: f64 = 0.02;
/// Harmonics of 0.05 Hz of the fitted angles and forces: up to 1.5 Hz, three times what the joints are moved
/// with.
const HARMONICS: usize = 30;
/// Largest distance of a joint from where it is to be, rad, of a machine that follows.
const FAR: f64 = 0.05;

/// Identifies machines.
pub struct Commissioning {
    model: Model,
    excitation: Excitation,
    folder: PathBuf,
}

/// What was found of a machine, as it is kept: the estimate, or why there is none.
#[derive(Serialize, Deserialize)]
enum Record {
    Found {
        /// The machine file as text, so that it is the same whenever it is written.
        text: String,
        nominal: [f64; DOF],
        residual: [f64; DOF],
    },
    Failed(String),
}

/// What was found of a machine.
pub struct Identification {
    /// The machine file for its controller.
    pub file: PathBuf,
    /// What the nominal machine left of the forces of the excitation, and what this one leaves.
    pub forces: [[f64; DOF]; 2],
}

/// The machines by the names of their cases; where there is none, why.
pub type Identified = BTreeMap<String, Result<Identification, String>>;

impl Commissioning {
    /// Of machines whose nominal one the controller of `system` has; files go into `folder`.
    ///
    /// # Errors
    /// A nominal machine that cannot be excited, or no folder to write to.
    pub fn new(system: &System, base: &Experiment, folder: &Path) -> Result<Self> {
        let controller = tip_error_port(system)?.component;
        let file = system.port_of(controller, "machine_file")?;
        let machine = MachineFile::at(system, &base.settings, file)?.machine;
        let model = Model::new(&machine)?;
        let excitation = Excitation::of(&model)?;
        let folder = std::path::absolute(folder)?;
        let commissioning = Self {
            model,
            excitation,
            folder,
        };
        let path = commissioning.excitation.path(&machine)?;
        let file = commissioning.path();
        fs::create_dir_all(&commissioning.folder)
            .and_then(|()| write(&file, &path))
            .with_context(|| file.display().to_string())?;
        Ok(commissioning)
    }

    /// How well the excitation tells the parameters.
    pub fn condition(&self) -> Condition {
        self.excitation.condition
    }

    /// The excitation as a path file.
    fn path(&self) -> PathBuf {
        self.folder.join("excitation.json")
    }

    /// The machine of every case, on all cores, each kept in `store`; `done` is called after each.
    ///
    /// # Errors
    /// A system without the signals that tell, or a store that cannot be written.
    pub fn identify(
        &self,
        (system, base): (&System, &Experiment),
        cases: &[Case],
        store: &RunStore,
        done: impl Fn() + Sync,
    ) -> Result<Identified> {
        let one = |case: &Case| {
            let found = self.one((system, base), case, store);
            done();
            Ok((case.label.clone(), found?))
        };
        cases.par_iter().map(one).collect()
    }

    fn one(
        &self,
        (system, base): (&System, &Experiment),
        case: &Case,
        store: &RunStore,
    ) -> Result<Result<Identification, String>> {
        let path = on_path(system, &self.path().display().to_string())?;
        let law = Law::new(LAW, LAW).settings(system)?;
        let mut settings: Vec<Setting> = [law, path].concat();
        // Lowered gains would change what is excited.
        let supervisor = system.port_of(tip_error_port(system)?.component, "supervisor")?;
        settings.push(system.setting(&system.name(supervisor), false)?);
        let experiment = case.over((system, base), &settings)?;
        let name = format!("identify {}", case.label);
        let record = store.kept(&name, system, &experiment, || {
            Ok(match self.of_run(system, &experiment) {
                Ok(Estimate {
                    machine,
                    nominal,
                    residual,
                }) => Record::Found {
                    text: serde_json::to_string_pretty(&machine)?,
                    nominal,
                    residual,
                },
                Err(error) => Record::Failed(format!("{error:#}")),
            })
        })?;
        Ok(match record {
            Record::Failed(why) => Err(why),
            Record::Found {
                text,
                nominal,
                residual,
            } => {
                let file = format!("machine {}.json", case.label).replace(' ', "_");
                let file = self.folder.join(file);
                write(&file, &text).with_context(|| file.display().to_string())?;
                Ok(Identification {
                    file,
                    forces: [nominal, residual],
                })
            }
        })
    }

    fn of_run(&self, system: &System, experiment: &Experiment) -> Result<Estimate> {
        let controller = tip_error_port(system)?.component;
        let mut ports = Vec::new();
        for (array, count) in [("zeta_measured", DOF), ("F_measured", 3)] {
            for k in 1..=count {
                ports.push(system.port(&format!("{array}[{k}]"))?);
            }
        }
        ports.extend(system.elements(controller, "tau_wrist", 3)?);
        let mut recording = Recording::new(system, &ports)?;
        let master = experiment.start(system)?;
        // The path begins once the tip has gone to its first point: encoders have wrong zeros.
        let end = motion_end(system, &master).context("the excitation has no end")?;
        run_plan(system, master, &Plan::to(end), &|_, _| (), &mut recording)?;
        let samples = self.samples(&recording, &ports, end - DURATION)?;
        estimate(&self.model, &samples, BIN)
    }

    /// Means over bins, with the motion that was fitted to the angles.
    fn samples(&self, recording: &Recording, ports: &[Port], start: f64) -> Result<Vec<Sample>> {
        let columns: Vec<&[f64]> = (ports.iter())
            .map(|port| recording.column(*port))
            .collect::<Result<_>>()?;
        let mut bins: BTreeMap<u32, (f64, Vec<f64>)> = BTreeMap::new();
        for k in recording.first_from(start)..recording.times.len() {
            let t = recording.times[k] - start;
            let (count, sums) = (bins.entry((t / BIN) as u32))
                .or_insert_with(|| (0.0, vec![0.0; 1 + columns.len()]));
            *count += 1.0;
            sums[0] += t;
            for (sum, column) in sums[1..].iter_mut().zip(&columns) {
                *sum += column[k];
            }
        }
        let mut means = Vec::new();
        for (count, mut sums) in bins.into_values() {
            sums.iter_mut().for_each(|sum| *sum /= count);
            means.push(sums);
        }
        let times: Vec<f64> = means.iter().map(|mean| mean[0]).collect();
        let wave = DMatrix::from_fn(times.len(), 1 + 2 * HARMONICS, |i, j| wave(times[i], j)[0]);
        let normal = wave.transpose() * &wave;
        let normal = normal.cholesky().context("too short a run")?;
        let rest = Sample {
            motion: Motion::rest([0.0; DOF]),
            forces: [0.0; DOF],
        };
        let mut samples = vec![rest; means.len()];
        for k in 0..2 * DOF {
            let column = DVector::from_iterator(means.len(), means.iter().map(|mean| mean[1 + k]));
            let fitted = normal.solve(&(wave.transpose() * column));
            for (t, Sample { motion, forces }) in times.iter().zip(&mut samples) {
                let [value, rate, acceleration] = sum(&fitted, *t);
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

/// Writes a file that is not there, or says something else.
fn write(file: &Path, text: &str) -> std::io::Result<()> {
    match fs::read_to_string(file) {
        Ok(there) if there == text => Ok(()),
        _ => fs::write(file, text),
    }
}

/// A series with its derivatives.
fn sum(coefficients: &DVector<f64>, t: f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (j, c) in coefficients.iter().enumerate() {
        for (sum, value) in sum.iter_mut().zip(wave(t, j)) {
            *sum += c * value;
        }
    }
    sum
}

/// Function j of the series, with its derivatives: 1, then cosines and sines in turn.
fn wave(t: f64, j: usize) -> [f64; 3] {
    let w = TAU / DURATION * j.div_ceil(2) as f64;
    let (sin, cos) = (w * t).sin_cos();
    if j.is_multiple_of(2) {
        [cos, -w * sin, -w * w * cos]
    } else {
        [sin, w * cos, -w * w * sin]
    }
}
