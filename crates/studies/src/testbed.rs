//! One-axis experiment (the paper's "Experimental Results"): the lift and the tilt actuator, force-driven, each against a load emulator
//! that replays the force profile of its joint from a run of the whole machine with a first-order lag; the actuator level of the
//! controller tracks the rod's position and velocity of that run. The load's force is previewed to the controller, as the whole machine's
//! decomposition would, or not known to it beforehand, as on a testbed that something else loads.
#![allow(non_snake_case)] // the paper's symbols

use std::fmt::Write as _;

use anyhow::{Context, Result, ensure};
use cosim::master::{Master, Stepping};
use cosim::run::Experiment;
use cosim::signals::{Inputs, Signals};
use cosim::system::{Setting, System};
use cosim::wiring::Port;
use rayon::prelude::*;
use serde::Serialize;

use crate::experiment::{Recorded, vary};
use crate::table::TRAJECTORIES;

/// An axis of the testbed: name, number of its rod, component of the testbed.
pub(crate) const AXES: [(&str, usize, &str); 2] =
    [("lift", 2, "emla_lift"), ("tilt", 3, "emla_tilt")];
/// Component of the testbed that controls both.
pub(crate) const CONTROLLER: &str = "controller";
/// Position RMSE to stay below, m.
pub const POSITION_TARGET: f64 = 0.05e-3;
/// Force RMSE to stay below, as a share of the force's peak.
pub const FORCE_TARGET: f64 = 0.01;

/// A controller on the testbed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// Mode of the controller.
    pub mode: &'static str,
    /// Whether it is told the load's force beforehand.
    pub previewed: bool,
}

/// What checks the code: the controller is told the load.
pub const CHECK: Trial = Trial {
    mode: "adaptive",
    previewed: true,
};

/// The load is not known beforehand.
pub const UNKNOWN_LOAD: [Trial; 5] = {
    const fn trial(mode: &'static str) -> Trial {
        let previewed = false;
        Trial { mode, previewed }
    }
    [
        trial("adaptive"),
        trial("modular"),
        trial("pd"),
        trial("modular_integral"),
        trial("pd_integral"),
    ]
};

/// Course of one rod in the run of the whole machine, at its communication points.
pub(crate) struct Profile {
    /// Position, m.
    pub(crate) x: Vec<f64>,
    /// Velocity, m/s.
    pub(crate) x_dot: Vec<f64>,
    /// Acceleration, m/s², by central differences of the velocity.
    x_ddot: Vec<f64>,
    /// Force of the actuator, N.
    pub(crate) F: Vec<f64>,
}

impl Profile {
    /// Position, velocity, acceleration and force between point `k` and the next.
    pub(crate) fn between(&self, k: usize, share: f64) -> [f64; 4] {
        let next = (k + 1).min(self.x.len() - 1);
        [&self.x, &self.x_dot, &self.x_ddot, &self.F]
            .map(|course| course[k] + share * (course[next] - course[k]))
    }
}

/// Root mean square and maximum of an error, and the peak of what was to be followed.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Tracking {
    /// Root mean square error.
    pub rmse: f64,
    /// Largest error.
    pub max: f64,
    /// Largest magnitude of the reference.
    pub peak: f64,
}

/// Result of one axis on one trajectory.
#[derive(Clone, Debug, Serialize)]
pub struct Axis {
    /// Trajectory.
    pub trajectory: &'static str,
    /// `lift` or `tilt`.
    pub axis: &'static str,
    /// The controller.
    pub trial: Trial,
    /// Position, m.
    pub position: Tracking,
    /// Velocity, m/s.
    pub velocity: Tracking,
    /// Force on the load, N.
    pub force: Tracking,
    /// Course over time.
    #[serde(skip)]
    pub course: Course,
}

/// Reference and measurement of one axis at the communication points.
#[derive(Clone, Debug, Default)]
pub struct Course {
    /// Time, s.
    pub time: Vec<f64>,
    /// Desired and actual position, m.
    pub position: [Vec<f64>; 2],
    /// Desired and actual velocity, m/s.
    pub velocity: [Vec<f64>; 2],
    /// Desired and actual force on the load, N.
    pub force: [Vec<f64>; 2],
}

/// Run both trajectories: record the `machine` under `base`, replay on the `testbed` with each of `trials`. `lag` is the emulator's time constant, s. What is set
/// on the machine's controller and on its lift and tilt actuators counts on the testbed too.
pub fn run(
    machine: &System,
    testbed: &System,
    base: &Experiment,
    lag: f64,
    trials: &[Trial],
) -> Vec<Result<Vec<Axis>>> {
    let settings = match shared(machine, testbed, base) {
        Ok(settings) => settings,
        Err(error) => return vec![Err(error)],
    };
    TRAJECTORIES
        .into_par_iter()
        .map(|(trajectory, _)| {
            let (recorded, profiles) = record(machine, base, trajectory)
                .with_context(|| format!("{trajectory}, run of the machine"))?;
            let mut axes = Vec::new();
            for trial in trials {
                let bed = Bed {
                    system: testbed,
                    settings: &settings,
                    stepping: base.stepping,
                    trial: *trial,
                };
                let replayed = bed.replay(trajectory, &recorded, &profiles, lag);
                axes.extend(replayed.with_context(|| format!("{trajectory}, testbed"))?);
            }
            Ok(axes)
        })
        .collect()
}

/// The one-axis experiment as it is run.
struct Bed<'a> {
    system: &'a System,
    settings: &'a [Setting],
    stepping: Stepping,
    trial: Trial,
}

/// What is set on the machine, on the components of the testbed that stand for the same.
fn shared(machine: &System, testbed: &System, base: &Experiment) -> Result<Vec<Setting>> {
    let mut twins = vec![(machine.port("tip_error_norm")?.component, CONTROLLER)];
    for (_, rod, actuator) in AXES {
        twins.push((rod_ports(machine, rod)?[2].component, actuator));
    }
    let mut settings = Vec::new();
    for Setting { port, value } in &base.settings {
        let variable = &machine.variable(*port).name;
        if let Some((_, twin)) = twins.iter().find(|(k, _)| *k == port.component) {
            settings.push(testbed.setting(&format!("{twin}.{variable}"), value)?);
        }
    }
    Ok(settings)
}

/// Position, velocity and force of a rod of the machine.
fn rod_ports(machine: &System, rod: usize) -> Result<[Port; 3]> {
    let arm = machine.port("f_hold[1]")?.component;
    let of_rod = |array: &str| machine.port_of(arm, &format!("{array}[{rod}]"));
    let wiring = machine.wiring()?;
    let force = wiring.driver(of_rod("f")?);
    let force = force.with_context(|| format!("nothing drives rod {rod}"))?;
    Ok([of_rod("x")?, of_rod("x_dot")?, wiring.links[force].from])
}

pub(crate) fn record(
    machine: &System,
    base: &Experiment,
    trajectory: &str,
) -> Result<(Recorded, [Profile; 2])> {
    let experiment = vary(machine, base, &[("trajectory", &trajectory)])?;
    let rods = [
        rod_ports(machine, AXES[0].1)?,
        rod_ports(machine, AXES[1].1)?,
    ];
    let recorded = Recorded::of(machine, &experiment, rods.as_flattened())?;
    let profile = |[x, x_dot, force]: [Port; 3]| -> Result<Profile> {
        let column = |port| recorded.recording.column(port).map(<[f64]>::to_vec);
        let x_dot = column(x_dot)?;
        Ok(Profile {
            x: column(x)?,
            x_ddot: slope(&x_dot, base.stepping.step),
            x_dot,
            F: column(force)?,
        })
    };
    let profiles = [profile(rods[0])?, profile(rods[1])?];
    Ok((recorded, profiles))
}

/// Derivative by central differences, one-sided at the ends.
fn slope(values: &[f64], step: f64) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let at = |k: usize| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
        (values[after] - values[before]) / (step * (after - before).max(1) as f64)
    };
    (0..values.len()).map(at).collect()
}

/// Start values: the rods where the recording starts, in equilibrium with its forces, of which the controller is told the share `told`.
fn start(testbed: &System, profiles: &[Profile; 2], told: f64) -> Result<Vec<Setting>> {
    let mut settings = Vec::new();
    for ((_, rod, actuator), p) in AXES.into_iter().zip(profiles) {
        for (variable, value) in [
            (format!("{actuator}.x"), p.x[0]),
            (format!("{actuator}.x_dot"), p.x_dot[0]),
            (format!("{actuator}.F_hold"), p.F[0]),
            (format!("{actuator}.F_ext"), p.F[0]),
            (reference("position", rod), p.x[0]),
            (reference("velocity", rod), p.x_dot[0]),
            (reference("force", rod), told * p.F[0]),
        ] {
            settings.push(testbed.setting(&variable, value)?);
        }
    }
    Ok(settings)
}

/// Input of the controller for a rod.
pub(crate) fn reference(quantity: &str, rod: usize) -> String {
    format!("{CONTROLLER}.reference.rod_{quantity}[{rod}]")
}

/// References of both rods: position, velocity, acceleration and force of each.
pub(crate) fn references(testbed: &System) -> Result<Inputs> {
    let quantities = ["position", "velocity", "acceleration", "force"];
    let names = AXES.map(|(_, rod, _)| quantities.map(|q| reference(q, rod)));
    inputs(testbed, names.as_flattened())
}

pub(crate) fn inputs(testbed: &System, names: &[String]) -> Result<Inputs> {
    Inputs::new(testbed, &ports(testbed, names)?)
}

pub(crate) fn ports(system: &System, names: &[String]) -> Result<Vec<Port>> {
    names.iter().map(|name| system.port(name)).collect()
}

/// Load emulator: `lag·F' = F_profile − F`, exact for a profile held at its mean over the step; the mean force of the step.
pub(crate) fn emulate(force: &mut f64, from: f64, to: f64, step: f64, lag: f64) -> f64 {
    let before = *force;
    let reached = if lag > 0.0 {
        -(-step / lag).exp_m1()
    } else {
        1.0
    };
    *force += reached * (0.5 * (from + to) - before);
    0.5 * (before + *force)
}

impl Bed<'_> {
    fn replay(
        &self,
        trajectory: &'static str,
        recorded: &Recorded,
        profiles: &[Profile; 2],
        lag: f64,
    ) -> Result<Vec<Axis>> {
        let points = recorded.recording.times.len();
        ensure!(points > 1, "the recording is empty");
        let Bed {
            system: testbed,
            settings,
            stepping,
            trial,
        } = *self;
        let mut references = references(testbed)?;
        let mut loads = inputs(testbed, &AXES.map(|(_, _, a)| format!("{a}.F_ext")))?;
        let outputs = AXES.map(|(_, _, a)| ["x_rod", "x_rod_dot", "F"].map(|v| format!("{a}.{v}")));
        let mut signals = Signals::new(testbed, &ports(testbed, outputs.as_flattened())?)?;
        let told = if trial.previewed { 1.0 } else { 0.0 };
        let mode = testbed.setting(&format!("{CONTROLLER}.mode"), trial.mode)?;
        let settings = [settings, &start(testbed, profiles, told)?, &[mode]].concat();
        let mut master = Master::new(testbed, &settings, stepping)?;
        let mut load = [profiles[0].F[0], profiles[1].F[0]];
        let mut courses = [Course::default(), Course::default()];
        for k in 0..points {
            let desired = profiles.each_ref();
            let desired = desired.map(|p| [p.x[k], p.x_dot[k], p.x_ddot[k], p.F[k]]);
            let actual = signals.read(&master)?.chunks_exact(3);
            for ((course, [x, x_dot, _, F]), actual) in courses.iter_mut().zip(desired).zip(actual)
            {
                course.add(master.time(), [x, x_dot, F], actual);
            }
            let known = desired.map(|[x, x_dot, x_ddot, F]| [x, x_dot, x_ddot, told * F]);
            references.set(&master, known.as_flattened())?;
            master.pass()?;
            if k + 1 < points {
                let forces = std::array::from_fn::<_, 2, _>(|i| {
                    let F = &profiles[i].F;
                    emulate(&mut load[i], F[k], F[k + 1], stepping.step, lag)
                });
                loads.set(&master, &forces)?;
                master.step()?;
            }
        }
        master.terminate()?;
        let first = recorded.motion_start();
        let axis = |((axis, _, _), course): ((&'static str, usize, &str), Course)| Axis {
            trajectory,
            axis,
            trial,
            position: tracking(&course.position, first),
            velocity: tracking(&course.velocity, first),
            force: tracking(&course.force, first),
            course,
        };
        Ok(AXES.into_iter().zip(courses).map(axis).collect())
    }
}

impl Course {
    pub(crate) fn add(&mut self, time: f64, desired: [f64; 3], actual: &[f64]) {
        self.time.push(time);
        let columns = [&mut self.position, &mut self.velocity, &mut self.force];
        for ((column, desired), actual) in columns.into_iter().zip(desired).zip(actual) {
            column[0].push(desired);
            column[1].push(*actual);
        }
    }
}

/// Errors from sample `first` on.
pub(crate) fn tracking([desired, actual]: &[Vec<f64>; 2], first: usize) -> Tracking {
    let mut sum = 0.0;
    let mut tracking = Tracking::default();
    for (d, a) in desired.iter().zip(actual).skip(first) {
        sum += (d - a) * (d - a);
        tracking.max = tracking.max.max((d - a).abs());
        tracking.peak = tracking.peak.max(d.abs());
    }
    tracking.rmse = (sum / desired.len().saturating_sub(first).max(1) as f64).sqrt();
    tracking
}

/// The controllers that are not told the load, as a table for people.
pub fn unknown_load_text(axes: &[Axis]) -> String {
    let mut text = format!(
        "load not known to the controller beforehand\n{:<12}{:<6}{:<18}{:>22}{:>22}\n",
        "trajectory", "axis", "controller", "position, mm (max)", "velocity, mm/s (max)"
    );
    let cell = |t: &Tracking| format!("{:.4} ({:.4})", 1e3 * t.rmse, 1e3 * t.max);
    for a in axes {
        let [position, velocity] = [&a.position, &a.velocity].map(cell);
        writeln!(
            text,
            "{:<12}{:<6}{:<18}{position:>22}{velocity:>22}",
            a.trajectory, a.axis, a.trial.mode
        )
        .expect("a String takes every text");
    }
    text + "RMSE and maximum over the motion; at the level of the actuators there are no inertias to adapt, so adaptive and modular are one\n"
}

/// The axes as a table for people.
pub fn text(axes: &[Axis]) -> String {
    let mut text = format!(
        "{:<12}{:<6}{:>22}{:>22}{:>22}{:>10}{:>12}\n",
        "trajectory",
        "axis",
        "position, mm (max)",
        "velocity, mm/s (max)",
        "force, N (max)",
        "peak, kN",
        "% of peak"
    );
    let cell = |t: &Tracking, scale: f64, digits: usize| {
        format!("{:.digits$} ({:.digits$})", scale * t.rmse, scale * t.max)
    };
    for a in axes {
        writeln!(
            text,
            "{:<12}{:<6}{:>22}{:>22}{:>22}{:>10.1}{:>12.3}",
            a.trajectory,
            a.axis,
            cell(&a.position, 1e3, 4),
            cell(&a.velocity, 1e3, 3),
            cell(&a.force, 1.0, 1),
            1e-3 * a.force.peak,
            100.0 * a.force.rmse / a.force.peak
        )
        .expect("a String takes every text");
    }
    let met = |yes: bool| if yes { "met" } else { "NOT met" };
    let position = axes.iter().all(|a| a.position.rmse <= POSITION_TARGET);
    let force = axes
        .iter()
        .all(|a| a.force.rmse <= FORCE_TARGET * a.force.peak);
    text + &format!(
        "RMSE and maximum over the motion; targets: position {:.2} mm {}, force {:.0} % of peak {}\n",
        1e3 * POSITION_TARGET,
        met(position),
        100.0 * FORCE_TARGET,
        met(force)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step of the profile: after k steps of h the force is 1 − e^(−k h/lag), closed form.
    #[test]
    fn the_emulator_is_a_first_order_lag() {
        let (mut force, h, lag) = (0.0, 1e-3, 0.02);
        for k in 1..=50 {
            let before = force;
            let mean = emulate(&mut force, 1.0, 1.0, h, lag);
            let exact = -(-f64::from(k) * h / lag).exp_m1();
            assert!((force - exact).abs() < 50.0 * f64::EPSILON, "{k}: {force}");
            assert!((mean - 0.5 * (before + force)).abs() < f64::EPSILON);
        }
        let mut ideal = 3.0;
        emulate(&mut ideal, 4.0, 6.0, h, 0.0);
        assert_eq!(ideal, 5.0);
    }

    #[test]
    fn errors_count_from_the_first_sample_of_the_motion() {
        let courses = [vec![9.0, 1.0, -2.0], vec![0.0, 4.0, 2.0]];
        let t = tracking(&courses, 1);
        assert_eq!((t.rmse, t.max, t.peak), (12.5f64.sqrt(), 4.0, 2.0));
    }

    /// Quadratic: central differences are exact inside, half a step off at the ends.
    #[test]
    fn slopes_of_a_parabola() {
        let values: Vec<f64> = (0..5).map(|k| f64::from(k * k)).collect();
        assert_eq!(slope(&values, 1.0), [1.0, 2.0, 4.0, 6.0, 7.0]);
    }
}
