//! By which cause the bound is exceeded: the machine as built, put together step by step, each run beside the one before.

use std::fmt::Write as _;

use anyhow::{Context, Result};
use cosim::master::start_value;
use cosim::run::Experiment;
use cosim::system::{Setting, System};
use machine::Emla;
use rayon::prelude::*;

use super::{Run, measure};
use crate::experiment::vary;

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

/// The rungs on the cubic trajectory with the gains of `base`; `system` is the real world, `scale` the plant's inertia over nominal.
pub fn causes(system: &System, base: &Experiment, scale: f64) -> Result<Vec<(&'static str, Run)>> {
    let one = |(rung, name): (usize, &'static str)| {
        let mut experiment = vary(
            system,
            base,
            &[
                ("trajectory", &"cubic"),
                ("lyapunov.inertia_scale", &scale),
                ("inertia_scale", &scale),
            ],
        )?;
        experiment.settings.extend(switched_off(system, rung)?);
        if rung == 0 {
            experiment.stepping.step *= FINE;
        }
        let run = measure(system, &experiment).with_context(|| name.to_string())?;
        Ok((name, run))
    };
    let rungs: Vec<_> = RUNGS.into_iter().enumerate().collect();
    rungs.into_par_iter().map(one).collect()
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

/// The rungs as a table for people.
pub fn causes_text(rungs: &[(&'static str, Run)]) -> String {
    let mut text = format!(
        "\nbound nu' <= -B on the cubic trajectory as the machine is put together; W: mean, rms, largest\n{:<36}{:>9}{:>24}{:>24}{:>24}{:>24}{:>24}\n",
        "", "time", "B", "excess nu' + B", "of it: bodies", "actuators", "cuts at the rods"
    );
    for (name, r) in rungs {
        write!(text, "{name:<36}{:>7.1} %", 100.0 * r.exceeded).expect("a String takes every text");
        for p in [&r.dissipation, &r.excess, &r.bodies, &r.actuators, &r.cuts] {
            let cell = format!("{:.2} {:.2} {:.2}", p.mean, p.rms, p.max);
            write!(text, "{cell:>24}").expect("a String takes every text");
        }
        text += "\n";
    }
    text + "time: share of it in which the bound is exceeded\n"
}

/// Elastic compliance 1/K_b of the lift actuator, m/N, from the stretch with which it holds its load at the start.
pub fn compliance(system: &System, base: &Experiment, p: &Emla) -> Result<f64> {
    let of = |variable: &str| -> Result<f64> {
        let port = system.port(&format!("emla_2.{variable}"))?;
        start_value(system, &base.settings, port)
    };
    let travel = p.rho / (std::f64::consts::TAU * p.N_gear);
    Ok((travel * of("theta_m")? - of("x")?) / of("F_hold")?)
}
