//! By which cause the bound is exceeded: the machine as built, put together step by step, each run
//! beside the one before.

use anyhow::{Context, Result};
use cosim::{Experiment, Setting, System, Verdict, start_value};
use machine_file::Emla;

use super::run::{Run, measure};
use super::study::scaled;
use crate::runs::grid::{self, Case, Grid, TRAJECTORIES};
use crate::setup::start_values::Law;

/// Actuators of the system.
const ACTUATORS: [&str; 3] = ["emla_1", "emla_2", "emla_3"];
/// Extras of the actuators as built besides friction.
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
/// Effects of the sensors, and what switches each off.
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
/// Part of the communication step that stands for no sampling.
const FINE: f64 = 0.25;

/// What is there, besides all of the rows before.
const RUNGS: [&str; 5] = [
    "idealised, a quarter of the step",
    "+ sampling",
    "+ stiction and drag",
    "+ play, compliance, drive, heat",
    "+ sensors and delay",
];

/// The machine with all that was put together so far, on the cubic trajectory with the gains of
/// `base`, and what spoils the runs; `system` is the real world, `scale` the plant's inertia over
/// nominal.
pub fn causes(
    system: &System,
    base: &Experiment,
    scale: f64,
) -> Result<(Vec<(&'static str, Run)>, Verdict)> {
    let case = |(rung, name): (usize, &str)| {
        let mut settings = scaled(system, scale)?;
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

/// What is not there yet.
fn switched_off(system: &System, rung: usize) -> Result<Vec<Setting>> {
    let mut settings = Vec::new();
    let mut off = |name: String, value: &str| -> Result<()> {
        settings.push(system.setting(&name, value)?);
        Ok(())
    };
    for actuator in ACTUATORS {
        if rung < 2 {
            off(format!("{actuator}.friction"), "false")?;
        }
        if rung < 3 {
            EXTRAS
                .into_iter()
                .try_for_each(|extra| off(format!("{actuator}.{extra}"), "false"))?;
        }
    }
    if rung < 4 {
        SENSORS
            .into_iter()
            .try_for_each(|(effect, value)| off(format!("sensors.{effect}"), value))?;
    }
    Ok(settings)
}

/// Elastic compliance 1/K_b of the lift actuator, m/N, from the stretch with which it holds its
/// load at the start.
pub fn compliance(system: &System, base: &Experiment, p: &Emla) -> Result<f64> {
    let of = |variable: &str| -> Result<f64> {
        let port = system.port(&format!("emla_2.{variable}"))?;
        start_value(system, &base.settings, port)
    };
    let travel = p.rho / (std::f64::consts::TAU * p.N_gear);
    Ok((travel * of("theta_m")? - of("x")?) / of("F_hold")?)
}
