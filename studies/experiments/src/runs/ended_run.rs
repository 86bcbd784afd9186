//! A run on a machine that the controller may fail to hold, for `draws`, `margins` and
//! `tournament`: whether the tip stayed on its reference, the controller stopped the machine, or
//! control was lost; with the tip error and the rods' forces. The run ends as soon as control is
//! lost, or after the stopped machine has had time to come to rest.

use std::ops::Range;

use anyhow::Result;
use cosim::run::interrupt::Interrupted;
use cosim::run::observer::{Observer, Observers};
use cosim::run::simulate::{Plan, run_plan};
use cosim::{Experiment, Master, Recording, Signals, System, start_value};
use serde::{Deserialize, Serialize};

use crate::measures::run::{end_time, motion_start, tip_error_port};
use crate::measures::swinging::{SWINGS, SwingWatch, reference_ports};
use crate::measures::tracking::Evaluation;
use crate::setup::machine_choice::MachineFile;

/// Tip error from which on a run is lost, m.
const FAR: f64 = 0.05;
/// Rod force from which on a run is lost, as a multiple of the rated force.
const HUGE: f64 = 4.0;
/// Swing in motion from which on a run is lost, as a share of the rated force; the paths' own
/// accelerations stay below a third of it.
const WILD: f64 = 0.15;
/// Time after braking at which the machine must be at rest, s.
const STANDS: f64 = 3.0;

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
    /// The same of each lap, m, on a path of equal laps.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub laps: Vec<f64>,
    /// Largest rod force divided by the rated force, or by a larger limit of the controller.
    pub force: f64,
    /// Largest moving mean of a rod's force until braking, divided by the rated force.
    pub load: f64,
    /// Root mean square of the swinging force in the last whole second, divided by the rated force.
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
            let stop = watch.end + if watch.brakes.is_empty() { 0.0 } else { STANDS };
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
        let (rmse, laps) = match fate {
            Fate::Kept => {
                let start = motion_start(system, experiment)?;
                let tracking = evaluation.evaluate(&recording, start)?;
                (Some(tracking.known.rmse), tracking.laps)
            }
            Fate::Stopped | Fate::Lost => (None, Vec::new()),
        };
        let rods = watch.swings.rods.iter();
        let swing = rods.map(|rod| rod.rms).fold(0.0, f64::max);
        Ok(Self {
            fate,
            why,
            rmse,
            laps,
            force: watch.force,
            load: watch.load,
            swing,
            time,
        })
    }
}

/// Watches the run and ends it when its fate is known.
struct Watch {
    signals: Signals,
    swings: SwingWatch,
    /// The controller's limit divided by the rated force, at least 1.
    limit: f64,
    time: f64,
    force: f64,
    load: f64,
    /// When the controller braked, s, and why.
    braked: Option<f64>,
    cause: String,
    /// Names of the supervisor's causes, of which the signal before the brakes has the number.
    causes: Vec<String>,
    /// Places of the brakes among the signals; the reference follows.
    brakes: Range<usize>,
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
        let rated = file.machine.ratings.in_order().map(|r| r.force_max);
        let limit = match system.port_of(tip.component, "force_limit") {
            Ok(port) => start_value(system, &experiment.settings, port)?.max(1.0),
            Err(_) => 1.0,
        };
        let cause = system.port_of(tip.component, "supervisor.cause").ok();
        let variables = &system.fmus[tip.component].description.variables;
        let items = cause.map_or(&[][..], |port| variables[port.variable].items());
        ports.extend(cause);
        let first_brake = ports.len();
        let brake = |k| system.port_of(tip.component, &format!("brake[{k}]"));
        ports.extend((1..=3).flat_map(brake));
        let brakes = first_brake..ports.len();
        ports.extend(reference_ports(system));
        Ok(Self {
            signals: Signals::new(system, &ports)?,
            brakes,
            swings: SwingWatch::new(rated),
            limit,
            time: experiment.stepping.start,
            force: 0.0,
            load: 0.0,
            braked: None,
            cause: String::new(),
            causes: items.iter().map(|item| item.name.clone()).collect(),
            end: f64::INFINITY,
            ended: None,
        })
    }

    /// The fate of a run after braking.
    fn stopped(&self) -> (Fate, String) {
        let mut rods = self.swings.rods.iter();
        match rods.position(|rod| rod.rms > SWINGS) {
            None => (
                Fate::Stopped,
                format!("the controller braked{}", self.cause),
            ),
            Some(k) => (
                Fate::Lost,
                format!("rod {} swings under its brake{}", k + 1, self.cause),
            ),
        }
    }
}

impl Observer for Watch {
    fn observe(&mut self, master: &Master) -> Result<()> {
        let dt = master.time() - self.time;
        self.time = master.time();
        let values = self.signals.read(master)?;
        let (error, forces) = (values[0], values[1..4].iter().copied());
        let is_braked = values[self.brakes.clone()].iter().any(|b| *b != 0.0);
        let reference = &values[self.brakes.end..];
        self.swings.add(self.time, forces, reference);
        for (k, rod) in (1..).zip(&self.swings.rods) {
            self.force = self.force.max(rod.part.abs() / self.limit);
            if self.braked.is_none() {
                self.load = self.load.max(rod.mean.abs());
                if rod.rms > WILD {
                    self.ended = Some((Fate::Lost, format!("rod {k} swings")));
                }
            }
        }
        if self.force > HUGE {
            self.ended = Some((Fate::Lost, "a rod's force".into()));
        }
        if is_braked && self.braked.is_none() {
            self.braked = Some(self.time);
            let number = values[self.brakes.start - 1] as usize;
            let name = self.causes.get(number.wrapping_sub(1));
            self.cause = name.map_or(String::new(), |name| format!(": {name}"));
        }
        match self.braked {
            None if error > FAR => {
                self.ended = Some((Fate::Lost, "the tip is far off".into()));
            }
            None if self.time > self.end - 0.5 * dt => {
                self.ended = Some(match self.swings.swings_now() {
                    None => (Fate::Kept, String::new()),
                    Some(k) => (Fate::Lost, format!("rod {k} swings at rest")),
                });
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
