//! A run on a machine that the controller may fail to hold, for `draws`, `margins` and
//! `tournament`: whether the tip stayed on its reference, the controller stopped the machine, or
//! control was lost; with the tip error and the rods' forces. The run ends as soon as control is
//! lost, or after the stopped machine has had time to come to rest.

use anyhow::Result;
use cosim::run::interrupt::Interrupted;
use cosim::run::observer::{Observer, Observers};
use cosim::run::simulate::{Plan, run_plan};
use cosim::{Experiment, Master, Recording, Signals, System, start_value};
use machine_file::Ratings;
use serde::{Deserialize, Serialize};

use crate::measures::run::{end_time, motion_start, tip_error_port};
use crate::measures::tracking::Evaluation;
use crate::setup::machine_choice::MachineFile;

/// Tip error from which on a run is lost, m.
const FAR: f64 = 0.05;
/// Rod force from which on a run is lost, as a multiple of the rated force.
const HUGE: f64 = 4.0;
/// A rod oscillates if its force without the moving mean has this root mean square, as a share of
/// the rated force; the paths' own accelerations stay below a third of it.
const SWINGS: f64 = 0.15;
/// Time constants of mean and mean square, s: lasting oscillations above 0.6 Hz remain.
const MEAN: f64 = 0.25;
const LASTING: f64 = 1.0;
/// Time after braking at which the machine must be at rest, s.
const STANDS: f64 = 3.0;
/// Root mean square below which a rod is at rest, as a share of the rated force.
const STILL: f64 = 0.05;

/// What became of a run.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fate {
    /// The tip followed to the end.
    Kept,
    /// The controller stopped the machine by its brakes, and it came to rest.
    Stopped,
    /// The machine oscillated, the tip was far off, or the run failed.
    #[default]
    Lost,
}

/// A run and what became of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EndedRun {
    /// What became of it.
    pub fate: Fate,
    /// Why it did not come to its end; empty if it did.
    pub why: String,
    /// Root mean square of the known tip error over the motion, m, if the run was kept.
    pub rmse: Option<f64>,
    /// Largest rod force divided by the rated force, or by a larger limit of the controller.
    pub force: f64,
    /// Largest moving mean of a rod's force until braking, divided by the rated force.
    pub load: f64,
    /// Root mean square of the oscillating force at the end, divided by the rated force.
    pub swing: f64,
    /// Simulated time, s.
    pub time: f64,
}

impl EndedRun {
    /// RMSE, m; infinite if the run was not kept.
    #[must_use]
    pub fn cost(&self) -> f64 {
        self.rmse.unwrap_or(f64::INFINITY)
    }

    /// The result of a run that was not executed because it could only be lost.
    #[must_use]
    pub fn lost(why: String) -> Self {
        Self {
            why,
            ..Self::default()
        }
    }

    /// Runs `experiment`. A run that fails is lost, not an error.
    pub fn run(system: &System, experiment: &Experiment) -> Result<Self> {
        let evaluation = Evaluation::new(system, experiment)?;
        let mut watch = Watch::new(system, experiment)?;
        let ports = evaluation.ports();
        let mut recording = Recording::new(system, &ports)?;
        let mut run = || -> Result<f64> {
            let master = experiment.start(system)?;
            watch.end = end_time(system, experiment, &master)?;
            // Time for a machine that brakes at the end to come to rest.
            let stop = watch.end + if watch.has_brakes { STANDS } else { 0.0 };
            let observers = &mut Observers(vec![&mut recording, &mut watch]);
            let outcome = run_plan(system, master, &Plan::to(stop), &|_, _| (), observers)?;
            Ok(outcome.simulated)
        };
        let run = match run() {
            Err(error) if error.is::<Interrupted>() => return Err(error),
            run => run,
        };
        let time = *run.as_ref().unwrap_or(&watch.time);
        let ended = run.err().map(|error| (Fate::Lost, format!("{error:#}")));
        let (fate, why) = (watch.ended.take().or(ended)).unwrap_or((Fate::Kept, String::new()));
        let rmse = match fate {
            Fate::Kept => {
                let start = motion_start(system, experiment)?;
                let tracking = evaluation.evaluate(&recording, start)?;
                Some(tracking.known.rmse)
            }
            Fate::Stopped | Fate::Lost => None,
        };
        let swing = watch.rods.iter().map(|rod| rod.square).fold(0.0, f64::max);
        Ok(Self {
            fate,
            why,
            rmse,
            force: watch.force,
            load: watch.load,
            swing: swing.sqrt(),
            time,
        })
    }
}

/// Force of a rod divided by the rated force: its moving mean, and the mean square of the rest.
#[derive(Clone, Copy, Default)]
struct Rod {
    rated: f64,
    /// The controller's limit divided by the rated force, at least 1.
    limit: f64,
    mean: f64,
    square: f64,
}

impl Rod {
    /// Adds the force, N, `dt` s after the last one; returns its share of the limit.
    fn add(&mut self, force: f64, dt: f64) -> f64 {
        let part = force / self.rated;
        if dt == 0.0 {
            self.mean = part;
        }
        self.mean += (dt / MEAN).min(1.0) * (part - self.mean);
        let rest = part - self.mean;
        self.square += (dt / LASTING).min(1.0) * (rest * rest - self.square);
        part.abs() / self.limit
    }
}

/// Watches the run and ends it when its fate is known.
struct Watch {
    signals: Signals,
    rods: Vec<Rod>,
    time: f64,
    force: f64,
    load: f64,
    /// When the controller braked, s.
    braked: Option<f64>,
    has_brakes: bool,
    /// When the run ends unless the controller brakes, s.
    end: f64,
    ended: Option<(Fate, String)>,
}

impl Watch {
    fn new(system: &System, experiment: &Experiment) -> Result<Self> {
        let file = MachineFile::from_manipulator(system, &experiment.settings)?;
        let tip = tip_error_port(system)?;
        let force = |k| system.port(&format!("emla_{k}.F"));
        let mut ports = vec![tip, force(1)?, force(2)?, force(3)?];
        let rated = file.machine.ratings.in_order();
        let limit = match system.port_of(tip.component, "force_limit") {
            Ok(port) => start_value(system, &experiment.settings, port)?.max(1.0),
            Err(_) => 1.0,
        };
        let brake = |k| system.port_of(tip.component, &format!("brake[{k}]"));
        ports.extend((1..=3).flat_map(brake));
        let rod = |ratings: &&Ratings| Rod {
            rated: ratings.force_max,
            limit,
            ..Rod::default()
        };
        Ok(Self {
            signals: Signals::new(system, &ports)?,
            rods: rated.iter().map(rod).collect(),
            time: experiment.stepping.start,
            force: 0.0,
            load: 0.0,
            braked: None,
            has_brakes: ports.len() > 4,
            end: f64::INFINITY,
            ended: None,
        })
    }
}

impl Observer for Watch {
    fn observe(&mut self, master: &Master) -> Result<()> {
        let dt = master.time() - self.time;
        self.time = master.time();
        let [error, rest @ ..] = self.signals.read(master)? else {
            unreachable!("the tip error is read first");
        };
        let (forces, brakes) = rest.split_at(self.rods.len());
        for (k, (rod, force)) in (1..).zip(self.rods.iter_mut().zip(forces)) {
            self.force = self.force.max(rod.add(*force, dt));
            if self.braked.is_none() {
                self.load = self.load.max(rod.mean.abs());
                if rod.square > SWINGS * SWINGS {
                    self.ended = Some((Fate::Lost, format!("rod {k} swings")));
                }
            }
        }
        if self.force > HUGE {
            self.ended = Some((Fate::Lost, "a rod's force".into()));
        }
        if brakes.iter().any(|brake| *brake != 0.0) {
            self.braked.get_or_insert(self.time);
        }
        match self.braked {
            None if *error > FAR => {
                self.ended = Some((Fate::Lost, "the tip is far off".into()));
            }
            None if self.time > self.end - 0.5 * dt => {
                self.ended = Some((Fate::Kept, String::new()));
            }
            Some(braked) if self.time - braked > 0.99 * STANDS => self.ended = Some(self.stopped()),
            _ => {}
        }
        Ok(())
    }

    fn is_done(&self) -> bool {
        self.ended.is_some()
    }
}

impl Watch {
    /// The fate of a run after braking.
    fn stopped(&self) -> (Fate, String) {
        let standing = |rod: &Rod| rod.square < STILL * STILL;
        match self.rods.iter().position(|rod| !standing(rod)) {
            None => (Fate::Stopped, "the controller braked".into()),
            Some(k) => (Fate::Lost, format!("rod {} swings under its brake", k + 1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A force that swings around a load has its amplitude over √2 as its root mean square, less
    /// what the mean takes: at 5.6 Hz and 0.25 s 0.6 %. A load that changes slowly does not swing.
    #[test]
    fn swinging_is_told_from_load() {
        let rated = 70e3;
        let after = |force: &dyn Fn(f64) -> f64| {
            let mut rod = Rod {
                rated,
                limit: 1.0,
                ..Rod::default()
            };
            rod.add(force(0.0), 0.0);
            for k in 1..8000 {
                rod.add(force(1e-3 * f64::from(k)), 1e-3);
            }
            rod.square.sqrt()
        };
        let w = std::f64::consts::TAU * 5.6;
        let swings = after(&|t| 40e3 + 16e3 * (w * t).sin());
        let expected = 16e3 / rated / 2.0_f64.sqrt();
        assert!(
            (swings / expected - 1.0).abs() < 0.03,
            "{swings}, {expected}"
        );
        let slow = after(&|t| 40e3 + 16e3 * (0.5 * t).sin());
        assert!(slow < 0.2 * SWINGS, "{slow}");
    }
}
