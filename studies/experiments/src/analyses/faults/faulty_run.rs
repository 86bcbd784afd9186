//! A run from the instant of a fault on, for `faults`: restored from one state for all faults of
//! that instant, watched, and ended as soon as its fate is certain.

use std::fmt::Write as _;

use anyhow::Result;
use cosim::exchange::faults::Faults;
use cosim::master::Saved;
use cosim::run::interrupt;
use cosim::{Master, System};
use serde::{Deserialize, Serialize};

use super::grid::{AT_REST, Fault, Instant};
use super::undisturbed::{Excess, Reading, Readings, STANDS, Undisturbed};
use crate::runs::ended_run::Fate;
use crate::runs::run_store::RunStore;
use crate::setup::start_values::BY_RATES;

/// Error up to which a run is kept, m; on the path of all six joints twice that without a fault.
/// Commanded rates have no path: whoever commands them sees the tip, and [`BEYOND_ORACLE`] is allowed
/// as for a stop.
const KEPT: f64 = 5e-3;
/// Most that a stop may cost beyond the oracle, and in all: distance from the path, m, and force
/// over the rated one.
const BEYOND_ORACLE: Excess = Excess {
    distance: 0.04,
    force: 0.2,
};
const IN_ALL: Excess = Excess {
    distance: 0.1,
    force: 2.0,
};
/// Speed of the tip above which a stopped machine does not stand, m/s; it may creep.
const MOVES: f64 = 0.01;

/// What became of a run with a fault.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FaultyRun {
    pub fate: Fate,
    /// Why it is lost; empty otherwise.
    pub why: String,
    /// Largest distance of the tip from where the reference is, before the brakes, m.
    pub error: f64,
    /// Largest distance from the path, m, and rod force over the rated one; of the oracle too.
    pub distance: f64,
    pub force: f64,
    pub oracle: [f64; 2],
    /// Time from the fault to the brakes, s.
    pub braked: Option<f64>,
    /// Number of the cause that the supervisor names.
    pub cause: i32,
}

/// Runs faults of one instant.
pub(super) struct Runner<'a> {
    system: &'a System,
    undisturbed: &'a Undisturbed,
    oracle: Excess,
    instant: Instant,
    readings: Readings,
    /// The running system, and its state just before the fault.
    started: Option<(Master, Saved)>,
}

impl<'a> Runner<'a> {
    pub(super) fn new(
        system: &'a System,
        undisturbed: &'a Undisturbed,
        instant: &Instant,
    ) -> Result<Self> {
        Ok(Self {
            readings: Readings::new(system, &undisturbed.experiment)?,
            oracle: undisturbed.oracle(instant),
            system,
            undisturbed,
            instant: *instant,
            started: None,
        })
    }

    /// Time of the fault, s.
    pub(super) fn time(&self) -> f64 {
        self.instant.time(self.undisturbed.end)
    }

    /// The run with this fault, or its result from `store`.
    pub(super) fn load_or_run(&mut self, fault: &Fault, store: &RunStore) -> Result<FaultyRun> {
        let system = self.system;
        let mut experiment = self.undisturbed.experiment.clone();
        experiment.faults = fault.on_wire(system, self.time())?;
        let mut name = String::new();
        let Instant { path, payload, .. } = self.instant;
        write!(name, "{path} {payload} kg {fault} {}", self.time())?;
        store.load_or_make(&name, system, &experiment, || {
            let run = self.run(&experiment.faults);
            interrupt::check()?;
            if run.is_err() {
                // The next fault begins with instances of its own.
                self.started = None;
            }
            Ok(run.unwrap_or_else(|error| FaultyRun {
                why: format!("{error:#}"),
                ..FaultyRun::default()
            }))
        })
    }

    fn run(&mut self, faults: &Faults) -> Result<FaultyRun> {
        let (system, time) = (self.system, self.time());
        if self.started.is_none() {
            let mut master = self.undisturbed.experiment.start(system)?;
            let step = master.stepping().step;
            while master.time() < time - 1.5 * step {
                master.step()?;
            }
            let saved = master.save()?;
            self.started = Some((master, saved));
        }
        let (master, saved) = self.started.as_mut().expect("started above");
        master.restore(saved)?;
        master.apply_faults(system, faults)?;
        let mut watch = Watch::new(self.undisturbed, &self.instant, self.oracle, time);
        while watch.ended.is_none() {
            if let Err(error) = master.step() {
                watch.ended = Some((Fate::Lost, format!("{error:#}")));
                self.started = None;
                break;
            }
            watch.add(master.time(), &self.readings.read(master)?);
            interrupt::check()?;
        }
        Ok(watch.result())
    }
}

/// Judges a run while it goes on.
struct Watch<'a> {
    undisturbed: &'a Undisturbed,
    oracle: Excess,
    /// Time of the fault, s.
    time: f64,
    /// Largest error up to which the run is kept, m.
    kept: f64,
    excess: Excess,
    error: f64,
    braked: Option<f64>,
    /// Reading a second before the end of a stop.
    before: Option<Reading>,
    cause: i32,
    ended: Option<(Fate, String)>,
}

impl<'a> Watch<'a> {
    fn new(undisturbed: &'a Undisturbed, instant: &Instant, oracle: Excess, time: f64) -> Self {
        let is_own_path = undisturbed.motion.error > 0.5 * KEPT;
        Self {
            undisturbed,
            oracle,
            time,
            kept: match (instant.path, is_own_path) {
                (BY_RATES | AT_REST, _) => BEYOND_ORACLE.distance,
                (_, true) => 2.0 * undisturbed.motion.error,
                (_, false) => KEPT,
            },
            excess: Excess::default(),
            error: 0.0,
            braked: None,
            before: None,
            cause: 0,
            ended: None,
        }
    }

    fn add(&mut self, t: f64, now: &Reading) {
        if t < self.time {
            return;
        }
        let motion = &self.undisturbed.motion;
        motion.add(now, &mut self.excess);
        self.cause = now.cause;
        if now.is_braked && self.braked.is_none() {
            self.braked = Some(t);
        }
        let Some(braked) = self.braked else {
            self.error = self.error.max(motion.error_at(t, &now.tip));
            if self.excess.distance > IN_ALL.distance || self.excess.force > IN_ALL.force {
                self.ended = Some((Fate::Lost, self.cost()));
            } else if t > self.undisturbed.end {
                self.ended = Some(self.kept());
            }
            return;
        };
        if t > braked + STANDS - 1.0 && self.before.is_none() {
            self.before = Some(*now);
        }
        if t > braked + STANDS || self.is_too_far() {
            self.ended = Some(self.stopped(now));
        }
    }

    fn is_too_far(&self) -> bool {
        let Excess { distance, force } = self.excess;
        distance > (self.oracle.distance + BEYOND_ORACLE.distance).min(IN_ALL.distance)
            || force > (self.oracle.force + BEYOND_ORACLE.force).min(IN_ALL.force)
    }

    /// Distance and force in words.
    fn cost(&self) -> String {
        let Excess { distance, force } = self.excess;
        format!(
            "{:.0} mm from its path, {force:.2} times the rated force; the oracle {:.0} mm, {:.2}",
            1e3 * distance,
            1e3 * self.oracle.distance,
            self.oracle.force
        )
    }

    fn kept(&self) -> (Fate, String) {
        match self.error <= self.kept {
            true => (Fate::Kept, String::new()),
            false => (
                Fate::Lost,
                format!(
                    "drives on with {:.1} mm of error, not stopped",
                    1e3 * self.error
                ),
            ),
        }
    }

    fn stopped(&self, now: &Reading) -> (Fate, String) {
        let moved = self
            .before
            .map_or(0.0, |before| (now.tip - before.tip).norm());
        match (self.is_too_far(), moved > MOVES) {
            (true, _) => (Fate::Lost, self.cost()),
            (_, true) => (
                Fate::Lost,
                format!("moves {:.0} mm in a second after its stop", 1e3 * moved),
            ),
            _ => (Fate::Stopped, String::new()),
        }
    }

    fn result(self) -> FaultyRun {
        let (fate, why) = self.ended.unwrap_or_default();
        FaultyRun {
            fate,
            why,
            error: self.error,
            distance: self.excess.distance,
            force: self.excess.force,
            oracle: [self.oracle.distance, self.oracle.force],
            braked: self.braked.map(|braked| braked - self.time),
            cause: self.cause,
        }
    }
}
