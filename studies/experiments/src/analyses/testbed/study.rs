//! One-axis experiment (the paper's "Experimental Results"): the lift and the tilt actuator,
//! force-driven, each against a load emulator that replays the force profile of its joint from a
//! run of the whole machine with a first-order lag; the actuator level of the controller tracks the
//! rod's position and velocity of that run. The load's force is previewed to the controller, as the
//! whole machine's decomposition would, or not known to it beforehand, as on a testbed that
//! something else loads. With actuators as built, a second rig under force control, nose to nose,
//! loads them too.

use anyhow::{Context, Result};
use cosim::{Experiment, Setting, System, Verdict};
use rayon::prelude::*;

use super::axis::{
    AXES, Axis, CONTROLLER, FORCE_TARGET, Load, LoadedAxis, POSITION_TARGET, TestedLaw,
};
use super::profile::{MachineRun, rod_ports};
use super::replay::Bed;

/// Packed system.
pub const SYSTEM: &str = "Testbed.ssp";
/// Packed system of actuators as built.
pub const RIG_SYSTEM: &str = "RigTestbed.ssp";
/// What the testbed stands for: the machine, and under which conditions it ran.
#[derive(Clone, Copy)]
pub struct Replay<'a> {
    /// The machine.
    pub machine: &'a System,
    /// Its conditions; what is set on its controller, and on its lift and tilt actuators, counts on
    /// the testbed too.
    pub base: &'a Experiment,
    /// Its runs.
    pub runs: &'a [MachineRun],
    /// Time constant of the loads, s.
    pub lag: f64,
}

impl Replay<'_> {
    /// Replay both trajectories on the `testbed` with each of `laws`.
    ///
    /// # Errors
    /// A run fails, or the testbed does not have what is set on the machine.
    pub fn on(&self, testbed: &System, laws: &[TestedLaw]) -> Result<Vec<Axis>> {
        let axes = self.replay(testbed, laws, &[Load::Emulator], false)?;
        Ok(axes.into_iter().map(|loaded| loaded.axis).collect())
    }

    /// Replay both trajectories on the testbed of actuators as built with each of `laws`, under
    /// both loads; of what is set on the machine what is set on its controller counts.
    pub fn on_rigs(&self, testbed: &System, laws: &[TestedLaw]) -> Result<Vec<LoadedAxis>> {
        self.replay(testbed, laws, &[Load::Emulator, Load::Rig], true)
    }

    fn replay(
        &self,
        system: &System,
        laws: &[TestedLaw],
        loads: &[Load],
        is_as_built: bool,
    ) -> Result<Vec<LoadedAxis>> {
        let settings = self.shared(system, is_as_built)?;
        let mut replays = Vec::new();
        for run in self.runs {
            for load in loads {
                replays.extend(laws.iter().map(|law| (run, *load, *law)));
            }
        }
        let one = |(run, load, law): (&MachineRun, Load, TestedLaw)| {
            let bed = Bed {
                system,
                settings: &settings,
                stepping: self.base.stepping,
                is_as_built,
                load,
                lag: self.lag,
                law,
            };
            let courses = bed.replay(&run.profiles).with_context(|| {
                let (trajectory, mode) = (run.trajectory, law.mode);
                format!("{trajectory}, testbed, {load:?} as load, {mode}")
            })?;
            let axis = |((name, ..), course): ((&'static str, usize, &str), _)| LoadedAxis {
                load,
                axis: Axis::of(run.trajectory, name, law, course, run.motion_start),
            };
            Ok(AXES.into_iter().zip(courses).map(axis).collect::<Vec<_>>())
        };
        let axes: Result<Vec<_>> = replays.into_par_iter().map(one).collect();
        Ok(axes?.into_iter().flatten().collect())
    }

    /// What is set on the machine, on the components of the testbed that stand for the same.
    fn shared(&self, testbed: &System, is_as_built: bool) -> Result<Vec<Setting>> {
        let machine = self.machine;
        let mut twins = vec![(machine.port("tip_error_norm")?.component, CONTROLLER)];
        for (_, rod, actuator) in AXES.into_iter().filter(|_| !is_as_built) {
            twins.push((rod_ports(machine, rod)?[2].component, actuator));
        }
        let mut settings = Vec::new();
        for Setting { port, value } in &self.base.settings {
            let variable = &machine.variable(*port).name;
            if let Some((_, twin)) = twins.iter().find(|(k, _)| *k == port.component) {
                settings.push(testbed.setting(&format!("{twin}.{variable}"), value)?);
            }
        }
        Ok(settings)
    }
}

/// Objects to what is not met of the targets: those of the controller that is told the load.
pub fn judge(axes: &[Axis], verdict: &mut Verdict) {
    for a in axes {
        let name = format!("{} of the testbed, {}", a.axis, a.trajectory);
        if !a.meets_position_target() {
            let [rmse, target] = [a.position.rmse, POSITION_TARGET].map(|v| 1e3 * v);
            verdict.object(format!(
                "{name}: position RMSE {rmse:.4} mm, more than the target of {target:.2} mm"
            ));
        }
        if !a.meets_force_target() {
            let [share, target] = [a.force.rmse / a.force.peak, FORCE_TARGET].map(|v| 100.0 * v);
            verdict.object(format!(
                "{name}: force RMSE {share:.3} % of its peak, more than the target of {target:.0} %"
            ));
        }
    }
}
