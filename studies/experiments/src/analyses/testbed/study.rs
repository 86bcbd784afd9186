//! The replays of the one-axis experiment, for the subcommand `testbed` and the report: the lift
//! and the tilt actuator, each against a load emulator that replays, with a first-order lag, the
//! force on its rod in a run of the machine. The controller's actuator level tracks the rod's
//! motion of that run. It gets the load's force beforehand, as the whole machine's decomposition
//! gives it, or not, as for an unknown load. Actuators as built are also loaded by a second rig
//! under force control.

use anyhow::{Context, Result};
use cosim::{Experiment, Setting, System, Verdict};
use rayon::prelude::*;

use super::axis::{
    AXES, Axis, AxisError, CONTROLLER, FORCE_TARGET, Load, LoadedAxis, POSITION_TARGET, TestedLaw,
};
use super::profile::{MachineRun, rods};
use super::replay::Bed;

/// Packed system.
pub(crate) const SYSTEM: &str = "Testbed.ssp";
/// Packed system of actuators as built.
pub(crate) const RIG_SYSTEM: &str = "RigTestbed.ssp";

/// What the testbed stands for: the machine, and under which conditions it ran.
#[derive(Clone, Copy)]
pub struct Replay<'a> {
    /// The machine.
    pub machine: &'a System,
    /// Its conditions; settings of its controller, and of its lift and tilt actuators, apply to the
    /// testbed too.
    pub base: &'a Experiment,
    /// Its runs.
    pub runs: &'a [MachineRun],
    /// Time constant of the loads, s.
    pub lag: f64,
}

impl Replay<'_> {
    /// Replays all runs on the `testbed` with each of `laws`, loaded by emulators; fails also if
    /// the testbed lacks a variable that is set on the machine.
    pub fn on(&self, testbed: &System, laws: &[TestedLaw]) -> Result<Vec<Axis>> {
        let axes = self.replay(testbed, laws, &[Load::Emulator], false)?;
        Ok(axes.into_iter().map(|loaded| loaded.axis).collect())
    }

    /// Replays all runs on the testbed of actuators as built with each of `laws`, under both loads;
    /// of the machine's settings only those of its controller apply.
    pub(crate) fn on_rigs(&self, testbed: &System, laws: &[TestedLaw]) -> Result<Vec<LoadedAxis>> {
        self.replay(testbed, laws, &[Load::Emulator, Load::Rig], true)
    }

    fn replay(
        &self,
        system: &System,
        laws: &[TestedLaw],
        loads: &[Load],
        is_as_built: bool,
    ) -> Result<Vec<LoadedAxis>> {
        let settings = self.shared_settings(system, is_as_built)?;
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
            let error = |pair: &_| AxisError::new(pair, run.motion_start);
            let axes = AXES.into_iter().zip(courses).map(|((axis, ..), course)| {
                let axis = Axis {
                    trajectory: run.trajectory,
                    axis,
                    law,
                    position: error(&course.position),
                    velocity: error(&course.velocity),
                    force: error(&course.force),
                    course,
                };
                LoadedAxis { load, axis }
            });
            Ok(axes.collect::<Vec<_>>())
        };
        let axes: Result<Vec<_>> = replays.into_par_iter().map(one).collect();
        Ok(axes?.into_iter().flatten().collect())
    }

    /// The machine's settings that apply to the testbed: those of its controller, and unless the
    /// testbed's actuators are as built, of its actuators.
    fn shared_settings(&self, testbed: &System, is_as_built: bool) -> Result<Vec<Setting>> {
        let machine = self.machine;
        let mut twins = vec![(machine.port("tip_error_norm")?.component, CONTROLLER)];
        if !is_as_built {
            let actuators = AXES.into_iter().zip(rods(machine)?);
            twins.extend(actuators.map(|((.., twin), [.., force])| (force.component, twin)));
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

/// Makes the verdict bad for each target that is missed; they are for the law with preview.
pub(crate) fn judge(axes: &[Axis], verdict: &mut Verdict) {
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
