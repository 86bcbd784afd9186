//! Finds by which cause the bound of the stability proof is exceeded, for `stability --world real`:
//! the machine as built is put together step by step, with a run after each step.

use anyhow::{Context, Result};
use cosim::{Experiment, Setting, System, Verdict, start_value};
use machine_file::Emla;

use super::run::{Run, measure};
use super::study::inertia_settings;
use crate::runs::grid::{self, Case, Grid, TRAJECTORIES};
use crate::setup::start_values::Law;

const ACTUATORS: [&str; 3] = ["emla_1", "emla_2", "emla_3"];
/// Effects of the actuators as built, apart from friction.
const EXTRAS: [&str; 9] = [
    "saturation",
    "temperature",
    "ripple",
    "cogging",
    "switching",
    "backlash",
    "compliance",
    "losses",
    "heat",
];
/// Effects of the sensors, and the value that switches each off.
const SENSORS: [(&str, &str); 8] = [
    ("motor_encoder", "false"),
    ("joint_encoder", "false"),
    ("rod_encoder", "false"),
    ("joint_zero", "false"),
    ("current", "false"),
    ("speed", "ideal"),
    ("force", "ideal"),
    ("delay", "0"),
];
/// Part of the communication step at which sampling hardly shows.
const FINE: f64 = 0.25;

/// The steps in which the machine is put together; each adds to those before.
const RUNGS: [&str; 5] = [
    "idealised, a quarter of the step",
    "+ sampling",
    "+ stiction and drag",
    "+ play, compliance, drive, heat",
    "+ sensors and delay",
];

/// A run for each step of putting the machine together, on the cubic trajectory with the gains of
/// `base`, and the verdict on the runs; `system` is the real world, `scale` the plant's inertia over
/// nominal.
pub(crate) fn causes(
    system: &System,
    base: &Experiment,
    scale: f64,
) -> Result<(Vec<(&'static str, Run)>, Verdict)> {
    let case = |(rung, name): (usize, &str)| {
        let mut settings = inertia_settings(system, scale)?;
        settings.extend(switched_off(system, rung)?);
        Ok(Case {
            step: if rung == 0 { FINE } else { 1.0 },
            ..Case::new(name, settings)
        })
    };
    let cases = RUNGS.into_iter().enumerate().map(case);
    let (laws, cases) = ([Law::default()], cases.collect::<Result<Vec<_>>>()?);
    let grid = Grid::new(system, base, &laws, &cases).replacing_bound();
    let grid = grid.with_trajectories(&TRAJECTORIES[..1]);
    let cells = grid.run(|plan| measure(system, plan), || ())?;
    let verdict = grid::verdict(&cells);
    let named = RUNGS.into_iter().zip(cells);
    let rungs = named.map(|(name, cell)| Ok((name, cell.result.context(name)?)));
    Ok((rungs.collect::<Result<_>>()?, verdict))
}

/// Settings that switch off what is added after step `rung`.
fn switched_off(system: &System, rung: usize) -> Result<Vec<Setting>> {
    let mut settings = Vec::new();
    for actuator in ACTUATORS {
        let friction = (rung < 2).then_some("friction");
        let extras = EXTRAS.into_iter().filter(|_| rung < 3);
        for effect in friction.into_iter().chain(extras) {
            settings.push(system.setting(&format!("{actuator}.{effect}"), false)?);
        }
    }
    for (effect, off) in SENSORS.into_iter().filter(|_| rung < 4) {
        settings.push(system.setting(&format!("sensors.{effect}"), off)?);
    }
    Ok(settings)
}

/// Elastic compliance 1/K_b of the lift actuator, m/N, from the stretch with which it holds its
/// load at the start.
pub(crate) fn compliance(system: &System, base: &Experiment, p: &Emla) -> Result<f64> {
    let start = |variable: &str| -> Result<f64> {
        let port = system.port(&format!("emla_2.{variable}"))?;
        start_value(system, &base.settings, port)
    };
    let travel = p.rho / (std::f64::consts::TAU * p.N_gear);
    Ok((travel * start("theta_m")? - start("x")?) / start("F_hold")?)
}
