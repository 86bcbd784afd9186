//! The run without a fault, which a run with one is compared with, and what the oracle does: at the
//! instant of the fault it applies all brakes and turns all gates off, as it knows that something
//! errs but not what, so that no drive can be relied on while its brake closes.

use anyhow::{Context, Result};
use cosim::exchange::faults::{Effect, Faults};
use cosim::{Experiment, Master, Port, Signals, System};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::grid::{Instant, on_wire};
use crate::measures::run::motion_start;
use crate::runs::run_store::RunStore;
use crate::setup::machine_choice::MachineFile;

/// Time between two recorded samples, s.
pub(super) const EVERY: f64 = 0.01;
/// Time after which a braked machine is judged, s.
pub(super) const STANDS: f64 = 3.0;

/// Largest distance of the tip from its path, m, and largest rod force over the rated one, from an
/// instant on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Excess {
    pub(super) distance: f64,
    pub(super) force: f64,
}

/// The run without a fault.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Motion {
    /// Where the tip was wanted and where it was, m, each [`EVERY`] from the start on.
    reference: Vec<[f64; 3]>,
    path: Vec<[f64; 3]>,
    /// Largest distance of both while the reference moves, m.
    pub(super) error: f64,
}

/// The run without a fault, and the oracle at each instant.
pub(super) struct Undisturbed {
    pub(super) experiment: Experiment,
    pub(super) motion: Motion,
    pub(super) end: f64,
    oracles: Vec<(Instant, Excess)>,
}

/// What is read of a running machine.
pub(super) struct Readings {
    signals: Signals,
    ratings: [f64; 3],
}

/// One reading.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reading {
    pub(super) tip: Vector3<f64>,
    pub(super) reference: Vector3<f64>,
    /// Largest rod force over its rated one.
    pub(super) force: f64,
    /// Whether the controller has applied a brake, and the cause that it names.
    pub(super) is_braked: bool,
    pub(super) cause: i32,
}

impl Readings {
    pub(super) fn new(system: &System, experiment: &Experiment) -> Result<Self> {
        let file = MachineFile::from_manipulator(system, &experiment.settings)?;
        let controller = system.port("desired.position[1]")?.component;
        let elements = |name: &str| system.elements(controller, name, 3);
        let plant = system.port("tip.position[1]")?.component;
        let mut ports = system.elements(plant, "tip.position", 3)?;
        ports.extend(elements("desired.position")?);
        for k in 1..=3 {
            ports.push(system.port(&format!("emla_{k}.F"))?);
        }
        ports.extend(elements("brake")?);
        ports.extend(system.port_of(controller, "supervisor.cause"));
        Ok(Self {
            signals: Signals::new(system, &ports)?,
            ratings: file.machine.ratings.in_order().map(|r| r.force_max),
        })
    }

    pub(super) fn read(&mut self, master: &Master) -> Result<Reading> {
        let values = self.signals.read(master)?;
        let forces = values[6..9].iter().zip(&self.ratings);
        Ok(Reading {
            tip: Vector3::from_column_slice(&values[..3]),
            reference: Vector3::from_column_slice(&values[3..6]),
            force: forces.map(|(f, rated)| f.abs() / rated).fold(0.0, f64::max),
            is_braked: values[9..12].iter().any(|brake| *brake != 0.0),
            cause: values.get(12).map_or(0, |cause| *cause as i32),
        })
    }
}

impl Undisturbed {
    /// Runs `experiment` without a fault and with the oracle at each of the `instants`, or reads
    /// both from `store`.
    pub(super) fn load_or_run(
        name: &str,
        system: &System,
        experiment: &Experiment,
        instants: &[Instant],
        store: &RunStore,
    ) -> Result<Self> {
        let end = experiment.stop(system)?;
        let run = || Motion::run(system, experiment);
        let motion = store.load_or_make(&format!("{name} no fault"), system, experiment, run)?;
        let oracle = |instant: &Instant| {
            let time = instant.time(end);
            let mut braked = experiment.clone();
            braked.faults = oracle(system, time)?;
            let run = || motion.excess(system, &braked, time);
            let excess = store.load_or_make(&format!("{name} oracle"), system, &braked, run)?;
            Ok((*instant, excess))
        };
        Ok(Self {
            oracles: instants.iter().map(oracle).collect::<Result<_>>()?,
            experiment: experiment.clone(),
            motion,
            end,
        })
    }

    /// What the oracle cannot avoid after this instant.
    pub(super) fn oracle(&self, instant: &Instant) -> Excess {
        let mut oracles = self.oracles.iter();
        oracles
            .find(|(of, _)| of == instant)
            .map_or(Excess::default(), |(_, excess)| *excess)
    }
}

/// Brakes and gates as the oracle commands them from the time `time`, s, on: a wrist without brakes
/// keeps its torques.
fn oracle(system: &System, time: f64) -> Result<Faults> {
    let mut list = Vec::new();
    let mut add = |name: String, effect| {
        list.extend(system.port(&name).map(|port| on_wire(port, effect, time)));
    };
    for k in 1..=3 {
        add(format!("emla_{k}.brake"), Effect::Override(1.0));
        add(format!("emla_{k}.enable"), Effect::Override(0.0));
        add(format!("hdrm.tau_wrist[{k}]"), Effect::Freeze);
        add(format!("hdrm.wrist.brake[{k}]"), Effect::Override(1.0));
        add(format!("hdrm.wrist.enable[{k}]"), Effect::Override(0.0));
    }
    let is_wired = |port: Port| system.wiring().map(|wiring| wiring.driver(port).is_some());
    let mut faults = Faults::default();
    for fault in list {
        if is_wired(fault.port)? {
            faults.list.push(fault);
        }
    }
    Ok(faults)
}

impl Motion {
    fn run(system: &System, experiment: &Experiment) -> Result<Self> {
        let mut master = experiment.start(system)?;
        let mut readings = Readings::new(system, experiment)?;
        let (end, start) = (experiment.stop(system)?, motion_start(system, experiment)?);
        let mut motion = Self {
            reference: Vec::new(),
            path: Vec::new(),
            error: 0.0,
        };
        let half = 0.5 * master.stepping().step;
        while master.time() < end + EVERY {
            if master.time() > EVERY * motion.path.len() as f64 - half {
                let now = readings.read(&master)?;
                anyhow::ensure!(
                    !now.is_braked,
                    "the machine stops without a fault at {} s",
                    master.time()
                );
                motion.reference.push(now.reference.into());
                motion.path.push(now.tip.into());
                if master.time() > start {
                    motion.error = motion.error.max((now.tip - now.reference).norm());
                }
            }
            master.step().context("the run without a fault")?;
        }
        master.terminate()?;
        Ok(motion)
    }

    /// The largest distance and force from `time`, s, until the braked machine is judged.
    fn excess(&self, system: &System, experiment: &Experiment, time: f64) -> Result<Excess> {
        let mut master = experiment.start(system)?;
        let mut readings = Readings::new(system, experiment)?;
        let mut excess = Excess::default();
        while master.time() < time + STANDS {
            master.step().context("the run with the oracle")?;
            if master.time() > time {
                self.add(&readings.read(&master)?, &mut excess);
            }
        }
        master.terminate()?;
        Ok(excess)
    }

    /// Adds a reading to `excess`.
    pub(super) fn add(&self, now: &Reading, excess: &mut Excess) {
        excess.force = excess.force.max(now.force);
        // The search costs as much as a step: only where the tip may be farther than before.
        let is_near = |p: &[f64; 3]| (Vector3::from(*p) - now.tip).norm() <= excess.distance;
        if !self.path.iter().any(is_near) {
            excess.distance = self.distance(&now.tip);
        }
    }

    /// Distance of `tip` from the path of the run without a fault, m.
    fn distance(&self, tip: &Vector3<f64>) -> f64 {
        let legs = self.path.windows(2).map(|ends| {
            let [a, b] = [0, 1].map(|k| Vector3::from(ends[k]));
            let leg = b - a;
            let along = leg.dot(&(tip - a)) / leg.norm_squared().max(f64::MIN_POSITIVE);
            (a + leg * along.clamp(0.0, 1.0) - tip).norm()
        });
        legs.fold(f64::INFINITY, f64::min)
    }

    /// Distance of `tip` from where it was wanted at the time `t`, s, in m.
    pub(super) fn error_at(&self, t: f64, tip: &Vector3<f64>) -> f64 {
        let place = (t / EVERY).max(0.0);
        let k = (place as usize).min(self.reference.len() - 2);
        let [a, b] = [k, k + 1].map(|k| Vector3::from(self.reference[k]));
        (a + (b - a) * (place - k as f64).min(1.0) - tip).norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Motion {
        let path = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0]];
        Motion {
            reference: path.clone(),
            path,
            error: 0.0,
        }
    }

    /// By hand: beside a leg, beyond an end, and inside the corner; the largest is kept.
    #[test]
    fn the_distance_is_that_of_the_nearest_leg() {
        let motion = corner();
        let mut excess = Excess::default();
        for (tip, distance, largest) in [
            ([0.5, -0.25, 0.0], 0.25, 0.25),
            ([0.75, 0.5, 0.0], 0.25, 0.25),
            ([1.0, 2.0, 0.75], 0.75, 0.75),
            ([-0.3, 0.4, 0.0], 0.5, 0.75),
        ] {
            let tip = Vector3::from(tip);
            assert!((motion.distance(&tip) - distance).abs() < 1e-15);
            motion.add(
                &Reading {
                    tip,
                    ..Reading::default()
                },
                &mut excess,
            );
            assert!((excess.distance - largest).abs() < 1e-15, "{excess:?}");
        }
    }

    #[test]
    fn the_error_is_taken_at_its_time() {
        let tip = Vector3::new(1.0, 0.5, 0.0);
        assert!((corner().error_at(1.5 * EVERY, &tip) - 0.5).abs() < 1e-12);
        assert!((corner().error_at(9.0, &tip) - 1.5).abs() < 1e-12);
    }
}
