//! One-axis experiment with actuators as built: the lift and the tilt rig under the actuator level of the controller, each loaded by an
//! emulator with a lag or by a second rig, nose to nose, under force control. Both replay the force of the joint in a run of the whole
//! machine; neither is previewed to the controller.
#![allow(non_snake_case)] // the paper's symbols

use std::fmt::Write as _;

use anyhow::{Context, Result};
use cosim::master::{Master, Stepping};
use cosim::run::Experiment;
use cosim::signals::{Inputs, Signals};
use cosim::system::{Setting, System};
use emla::maps;
use machine::{Emla, Machine};
use rayon::prelude::*;
use serde::Serialize;

use crate::table::TRAJECTORIES;
use crate::testbed::{
    AXES, Axis, CONTROLLER, Course, Profile, Trial, emulate, inputs, ports, record, reference,
    references, tracking,
};

/// Packed system.
pub const SYSTEM: &str = "RigTestbed.ssp";
/// Components of the loading rigs, in the order of [`AXES`].
const LOADS: [&str; 2] = ["load_lift", "load_tilt"];
/// Communication step of two rigs against each other, s: the rod between them weighs 24 kg and hangs between two stiff springs.
const STEP: f64 = 1e-4;
/// Shortest time constant with which a loading rig's force follows, s: its speed control is little faster.
const FASTEST: f64 = 0.01;
/// Bandwidths of the loading rig's speed and current control, rad/s, and of the speed's integral.
const W_SPEED: f64 = 150.0;
/// See [`W_SPEED`].
const W_INTEGRAL: f64 = 40.0;
/// See [`W_SPEED`].
const W_CURRENT: f64 = 1500.0;

/// What loads an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Load {
    /// A force with a first-order lag.
    Emulator,
    /// A second rig under force control.
    Rig,
}

/// An axis under a load.
#[derive(Clone, Debug, Serialize)]
pub struct Loaded {
    /// What loaded it.
    pub load: Load,
    /// The axis.
    #[serde(flatten)]
    pub axis: Axis,
}

/// Run every trial under both loads on both trajectories; `lag` is the loads' time constant, s. The controller's settings on the `machine`
/// count here too.
pub fn run(
    machine: &System,
    bed: &System,
    base: &Experiment,
    lag: f64,
    trials: &[Trial],
) -> Result<Vec<Loaded>> {
    let controller = machine.port("tip_error_norm")?.component;
    let mut settings = Vec::new();
    for Setting { port, value } in &base.settings {
        if port.component == controller {
            let variable = &machine.variable(*port).name;
            settings.push(bed.setting(&format!("{CONTROLLER}.{variable}"), value)?);
        }
    }
    let recorded: Result<Vec<_>> = TRAJECTORIES
        .into_par_iter()
        .map(|(trajectory, _)| {
            let run = record(machine, base, trajectory);
            run.with_context(|| format!("{trajectory}, run of the machine"))
        })
        .collect();
    let recorded = recorded?;
    let mut runs = Vec::new();
    for (k, (trajectory, _)) in TRAJECTORIES.into_iter().enumerate() {
        for load in [Load::Emulator, Load::Rig] {
            runs.extend(trials.iter().map(|trial| (k, trajectory, load, *trial)));
        }
    }
    let one = |(k, trajectory, load, trial): (usize, &'static str, Load, Trial)| {
        let (recorded, profiles) = &recorded[k];
        let bench = Bench {
            system: bed,
            settings: &settings,
            base: base.stepping,
            p: Machine::reference().emla.lift,
            lag,
            load,
            trial,
        };
        let courses = bench.replay(profiles);
        let courses =
            courses.with_context(|| format!("{trajectory}, {load:?} as load, {}", trial.mode))?;
        let first = recorded.motion_start();
        let axis = |((axis, _, _), course): ((&'static str, usize, &str), Course)| Loaded {
            load,
            axis: Axis {
                trajectory,
                axis,
                trial,
                position: tracking(&course.position, first),
                velocity: tracking(&course.velocity, first),
                force: tracking(&course.force, first),
                course,
            },
        };
        Ok(AXES.into_iter().zip(courses).map(axis).collect::<Vec<_>>())
    };
    let loaded: Result<Vec<_>> = runs.into_par_iter().map(one).collect();
    Ok(loaded?.into_iter().flatten().collect())
}

/// The experiment as it is run.
struct Bench<'a> {
    system: &'a System,
    settings: &'a [Setting],
    base: Stepping,
    /// The loading rigs as their control knows them.
    p: Emla,
    lag: f64,
    load: Load,
    trial: Trial,
}

impl Bench<'_> {
    /// Communication steps from one recorded point to the next.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small positive number"
    )]
    fn parts(&self) -> usize {
        match self.load {
            Load::Emulator => 1,
            Load::Rig => (self.base.step / STEP).ceil() as usize,
        }
    }

    /// Stroke of a loading rig whose actuator is at `x`: nose to nose both screws together are one screw long.
    fn mirrored(&self, x: f64) -> f64 {
        self.p.L_s - x
    }

    fn start(&self, profiles: &[Profile; 2]) -> Result<Vec<Setting>> {
        let mut settings = self.settings.to_vec();
        for (((_, rod, actuator), load), p) in AXES.into_iter().zip(LOADS).zip(profiles) {
            for (variable, value) in [
                (format!("{actuator}.x"), p.x[0]),
                (format!("{actuator}.x_dot"), p.x_dot[0]),
                (format!("{actuator}.F_hold"), p.F[0]),
                (format!("{actuator}.F_ext"), p.F[0]),
                (format!("{load}.x"), self.mirrored(p.x[0])),
                (format!("{load}.x_dot"), -p.x_dot[0]),
                (format!("{load}.F_hold"), p.F[0]),
                (reference("position", rod), p.x[0]),
                (reference("velocity", rod), p.x_dot[0]),
            ] {
                settings.push(self.system.setting(&variable, value)?);
            }
        }
        let mode = format!("{CONTROLLER}.mode");
        settings.push(self.system.setting(&mode, self.trial.mode)?);
        Ok(settings)
    }

    /// Courses of both axes at the recorded points.
    fn replay(&self, profiles: &[Profile; 2]) -> Result<[Course; 2]> {
        let points = profiles[0].x.len();
        let parts = self.parts();
        let h = self.base.step / parts as f64;
        let stepping = Stepping {
            step: h,
            ..self.base
        };
        let system = self.system;
        let mut references = references(system)?;
        let mut forces = inputs(system, &AXES.map(|(_, _, a)| format!("{a}.F_ext")))?;
        let outputs = AXES.map(|(_, _, a)| ["x_rod", "x_rod_dot", "F"].map(|v| format!("{a}.{v}")));
        let mut rods = Signals::new(system, &ports(system, outputs.as_flattened())?)?;
        let mut loads = Loads::new(system)?;
        let mut master = Master::new(system, &self.start(profiles)?, stepping)?;
        let mut emulated = [profiles[0].F[0], profiles[1].F[0]];
        let mut courses = [Course::default(), Course::default()];
        for k in 0..points {
            for part in 0..parts {
                let wanted = profiles
                    .each_ref()
                    .map(|p| p.between(k, part as f64 / parts as f64));
                let mut rod = [[0.0; 3]; 2];
                rod.as_flattened_mut().copy_from_slice(rods.read(&master)?);
                if part == 0 {
                    for ((course, [x, x_dot, _, F]), actual) in
                        courses.iter_mut().zip(wanted).zip(rod)
                    {
                        course.add(master.time(), [x, x_dot, F], &actual);
                    }
                }
                let untold = wanted.map(|[x, x_dot, x_ddot, _]| [x, x_dot, x_ddot, 0.0]);
                references.set(&master, untold.as_flattened())?;
                let force = match self.load {
                    Load::Rig => loads.press(self, &master, rod, wanted, h)?,
                    Load::Emulator => [0, 1].map(|i| {
                        let F = &profiles[i].F;
                        emulate(
                            &mut emulated[i],
                            F[k],
                            F[(k + 1).min(points - 1)],
                            h,
                            self.lag,
                        )
                    }),
                };
                forces.set(&master, &force)?;
                master.pass()?;
                if k + 1 == points {
                    break;
                }
                master.step()?;
            }
        }
        master.terminate()?;
        Ok(courses)
    }
}

/// Both loading rigs.
struct Loads {
    rods: Inputs,
    voltages: Inputs,
    readings: Signals,
    drives: [Option<LoadDrive>; 2],
}

impl Loads {
    fn new(system: &System) -> Result<Self> {
        let names = |variables: &[&str]| -> Vec<String> {
            let of = |load| variables.iter().map(move |v| format!("{load}.{v}"));
            LOADS.into_iter().flat_map(of).collect()
        };
        Ok(Self {
            rods: inputs(system, &names(&["x", "x_dot"]))?,
            voltages: inputs(system, &names(&["v_d", "v_q"]))?,
            readings: Signals::new(system, &ports(system, &names(&["F", "i_d", "i_q", "w_m"]))?)?,
            drives: [None, None],
        })
    }

    /// Move them with the rods, let their control act for the next `h` s; their forces on the rods.
    fn press(
        &mut self,
        bench: &Bench,
        master: &Master,
        rod: [[f64; 3]; 2],
        wanted: [[f64; 4]; 2],
        h: f64,
    ) -> Result<[f64; 2]> {
        let mirrored = rod.map(|[x, x_dot, _]| [bench.mirrored(x), -x_dot]);
        self.rods.set(master, mirrored.as_flattened())?;
        let mut read = [[0.0; 4]; 2];
        read.as_flattened_mut()
            .copy_from_slice(self.readings.read(master)?);
        let mut v = [[0.0; 2]; 2];
        for axis in 0..2 {
            let [F, i_d, i_q, w_m] = read[axis];
            let seen = Seen {
                F,
                i: [i_d, i_q],
                w_m,
                x: mirrored[axis][0],
                x_dot: mirrored[axis][1],
            };
            let [_, _, x_ddot, F] = wanted[axis];
            let (p, drive) = (&bench.p, &mut self.drives[axis]);
            let drive = drive.get_or_insert_with(|| LoadDrive::holding(p, &seen));
            v[axis] = drive.command(p, [F, -x_ddot], &seen, bench.lag.max(FASTEST), h);
        }
        self.voltages.set(master, v.as_flattened())?;
        Ok(read.map(|[F, ..]| F))
    }
}

/// What the control of a loading rig reads.
struct Seen {
    /// Force, N.
    F: f64,
    /// Currents, A.
    i: [f64; 2],
    /// Motor speed, rad/s.
    w_m: f64,
    /// Stroke, m, and its rate, m/s.
    x: f64,
    /// See `x`.
    x_dot: f64,
}

/// Force control of a loading rig: integrals of the speed, N·m, and of the currents, V.
struct LoadDrive {
    speed: f64,
    current: [f64; 2],
}

impl LoadDrive {
    /// A drive that holds what it reads.
    fn holding(p: &Emla, seen: &Seen) -> Self {
        Self {
            speed: torque_per_ampere(p) * seen.i[1] - maps::travel_per_radian(p) * seen.F,
            current: seen.i.map(|i| p.R_s * i),
        }
    }

    /// Voltages for the force `F` while the nut accelerates by `x_ddot`. The spring between nut and rod turns speed into force, so the
    /// speed is commanded with which the force follows with the time constant `lag`:
    /// ```text
    /// K (ẋ_n − ẋ) = (F_r − F)/lag,   w = ẋ_n/ρ
    /// τ = ρ F_r + J (ẇ_r + K_w (w − w_m)) + ∫,   v = K_c (i_r − i) + ∫ + back-EMF
    /// ```
    fn command(
        &mut self,
        p: &Emla,
        [F, x_ddot]: [f64; 2],
        seen: &Seen,
        lag: f64,
        h: f64,
    ) -> [f64; 2] {
        let travel = maps::travel_per_radian(p);
        let mount = rig::Extras::AS_BUILT.compliance.mount;
        let K = 1.0 / (1.0 / maps::stiffness(p, seen.x) + 1.0 / mount);
        let x_dot = seen.x_dot + (F - seen.F) / (K * lag);
        let (J, error) = (maps::inertia(p, 1.0), x_dot / travel - seen.w_m);
        self.speed += h * J * W_SPEED * W_INTEGRAL * error;
        let tau = travel * F + J * (x_ddot / travel + W_SPEED * error) + self.speed;
        let i_q = (tau / torque_per_ampere(p)).clamp(-p.i_max, p.i_max);
        let w_e = f64::from(p.p) * seen.w_m;
        let emf = [
            -w_e * p.L_q * seen.i[1],
            w_e * (p.L_d * seen.i[0] + p.lambda_m),
        ];
        let required = [0.0, i_q];
        std::array::from_fn(|k| {
            let off = required[k] - seen.i[k];
            self.current[k] += h * W_CURRENT * p.R_s * off;
            W_CURRENT * p.L_d * off + self.current[k] + emf[k]
        })
    }
}

/// N·m/A.
fn torque_per_ampere(p: &Emla) -> f64 {
    1.5 * f64::from(p.p) * p.lambda_m
}

/// The axes as a table for people.
pub fn text(axes: &[Loaded]) -> String {
    let mut text = format!(
        "actuators as built, load not known to the controller beforehand\n{:<12}{:<6}{:<10}{:<18}{:>20}{:>22}{:>24}{:>11}\n",
        "trajectory",
        "axis",
        "load",
        "controller",
        "position, mm (max)",
        "velocity, mm/s (max)",
        "load's force, N (max)",
        "% of peak"
    );
    for Loaded { load, axis: a } in axes {
        let cell = |t: &crate::testbed::Tracking, scale: f64, digits: usize| {
            format!("{:.digits$} ({:.digits$})", scale * t.rmse, scale * t.max)
        };
        let load = match load {
            Load::Emulator => "emulator",
            Load::Rig => "rig",
        };
        writeln!(
            text,
            "{:<12}{:<6}{load:<10}{:<18}{:>20}{:>22}{:>24}{:>11.2}",
            a.trajectory,
            a.axis,
            a.trial.mode,
            cell(&a.position, 1e3, 3),
            cell(&a.velocity, 1e3, 2),
            cell(&a.force, 1.0, 0),
            100.0 * a.force.rmse / a.force.peak
        )
        .expect("a String takes every text");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use rig::{Drive, Extras, Input, Rig};

    /// The force of a loading rig on a rod that stands follows a step as the law that its speed is commanded by: two thirds after the time
    /// constant, all of it in the end. It falls short by what its speed control, eight times as fast, and dry friction take: a tenth of the
    /// step at first, 2 % in the end.
    #[test]
    fn a_loading_rig_follows_its_force_with_the_lag() {
        let p = Machine::reference().emla.lift;
        let rig = Rig::new(p, Extras::AS_BUILT, Drive::Motion).expect("the reference machine");
        let (low, high, lag, h) = (20e3, 30e3, 0.05, STEP);
        let T = rig.extras().temperature.reference;
        let mut u = Input {
            v_dc: 650.0,
            T_ambient: T,
            x: 0.4,
            F_hold: low,
            ..Input::default()
        };
        let mut s = rig.start(&u, [T; 2]).expect("a start");
        let mut drive = None;
        let mut force = |time: f64, wanted: f64| {
            let mut F = 0.0;
            for k in 0..(time / h).round() as u32 {
                let y = rig.output(&s, &u);
                F = y.F;
                let seen = Seen {
                    F,
                    i: [y.i_d, y.i_q],
                    w_m: y.w_m,
                    x: u.x,
                    x_dot: 0.0,
                };
                let drive = drive.get_or_insert_with(|| LoadDrive::holding(&p, &seen));
                [u.v_d, u.v_q] = drive.command(&p, [wanted, 0.0], &seen, lag, h);
                s = rig.step(&s, &u, f64::from(k) * h, h).expect("a step");
            }
            F
        };
        let part = |F: f64| (F - low) / (high - low);
        assert!(part(force(0.1, low)).abs() < 0.02);
        let first = part(force(lag, high));
        assert!((first - 0.632).abs() < 0.1, "{first}");
        let last = part(force(10.0 * lag, high));
        assert!((last - 1.0).abs() < 0.02, "{last}");
    }
}
