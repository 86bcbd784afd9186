//! The errors that the strict worlds draw in addition to those of the machine, for `world`:
//! actuators axis by axis, mounting and damping, dry friction of the joints, drives of the wrist,
//! load cells, a push on the tip, and jitter of the communication points.
//!
//! Bounds: resistance ±10, flux ±5 and inductance ±10 %, as data sheets of servo motors bound them;
//! friction ±40 %, for wear and temperature of the grease; lead ±0.05 %, between grades 7 and 10 of
//! ISO 3408-3; start between 20 and 90 °C; commutation ±2° electrical; load cells with a gain of
//! ±1 % and a loop of 0.3 % of 70 kN; mounting 30 to 120 N/µm, damped so that the boom's mode has a
//! damping ratio of 0.3 to 1.5 %.

use std::f64::consts::PI;

use anyhow::Result;
use cosim::System;
use cosim::master::Jitter;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};

use crate::runs::grid::Case;
use crate::setup::machine_choice::MachineFile;

/// System of the bending structure with actuators as built.
pub const SYSTEM: &str = "StrictBending.ssd";
/// Stream of the random generator; the machine's errors use the first two.
const STREAM: u64 = 2;
/// Width of a load cell's hysteresis loop, N: 0.3 % of 70 kN.
const HYSTERESIS: f64 = 210.0;
/// Friction parameters of an actuator as built, with their nominal values; the motor's friction
/// comes from the machine file.
const FRICTION: [(&str, f64); 6] = [
    ("friction.screw_drag", 0.5),
    ("friction.screw_loss", 0.026),
    ("friction.seal", 260.0),
    ("friction.gear_drag", 0.14),
    ("friction.gear_loss", 0.05),
    ("friction.gear_viscous", 0.0012),
];

/// Adds to each case the strict errors of its seed. A plant that `bends` has its own joints with
/// friction, ideal drives of the wrist, and steps that must keep their length.
pub(super) fn add_strict_errors(system: &System, cases: &mut [Case], bends: bool) -> Result<()> {
    let file = system.port("emla_1.machine_file")?;
    let machine = MachineFile::from_parameter(system, &[], file)?.machine;
    let even = Uniform::new_inclusive(-1.0, 1.0).expect("finite bounds");
    for case in cases {
        let seed = case.seed.unwrap_or(0);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(STREAM);
        let mut within = |least: f64, most: f64| {
            0.5 * (least + most) + 0.5 * (most - least) * even.sample(&mut random)
        };
        let mut values: Vec<(String, f64)> = Vec::new();
        for (k, p) in (1..).zip(machine.emla.in_order()) {
            let mut set = |name: &str, value| values.push((format!("emla_{k}.{name}"), value));
            let inductance = within(0.9, 1.1);
            let friction = within(0.6, 1.4);
            let temperature = within(293.15, 363.15);
            set("R_s", p.R_s * within(0.9, 1.1));
            set("lambda_m", p.lambda_m * within(0.95, 1.05));
            set("L_d", p.L_d * inductance);
            set("L_q", p.L_q * inductance);
            set("J_m", p.J_m * within(0.9, 1.1));
            set("rho", p.rho * within(0.9995, 1.0005));
            set("tau_C", p.tau_C * friction);
            set("C_m", p.C_m * friction);
            for (name, size) in FRICTION {
                set(name, size * friction);
            }
            set("T_winding_start", temperature);
            set("T_housing_start", temperature);
            set("switching.offset", within(-2.0, 2.0) * PI / 180.0);
            set("compliance.mount", within(3e7, 1.2e8));
            set("damping.mount", within(0.0, 4e4));
        }
        let mut set = |name: &str, value| values.push((name.into(), value));
        set("sensors.force.gain", 0.01);
        set("sensors.force.hysteresis", HYSTERESIS);
        if bends {
            set("hdrm.friction", within(0.6, 1.4));
        } else {
            for k in 1..=3 {
                set(&format!("hdrm.joint_dry.torque[{k}]"), within(100.0, 400.0));
            }
            set("hdrm.joint_dry.breakaway", 1.5);
            let (up, around) = (within(-1.0, 1.0), within(-PI, PI));
            let flat = (1.0 - up * up).sqrt();
            for (k, part) in (1..).zip([flat * around.cos(), up, flat * around.sin()]) {
                set(&format!("hdrm.push.force[{k}]"), 300.0 * part);
            }
            set("hdrm.push.start", within(6.0, 12.0));
            set("hdrm.push.duration", 0.2);
            case.settings.push(system.setting("hdrm.wrist", true)?);
            case.jitter = Some(Jitter {
                seed,
                part: 0.1,
                lost: 1e-3,
            });
        }
        for k in 1..=3 {
            let damping = system.setting(&format!("emla_{k}.damping"), true)?;
            case.settings.push(damping);
        }
        if bends {
            case.settings.push(system.setting("sensors.seed", seed)?);
            // The same delay as in the other worlds, in steps of half the length.
            case.settings.push(system.setting("sensors.delay", 2)?);
        }
        for (name, value) in values {
            case.settings.push(system.setting(&name, value)?);
        }
    }
    Ok(())
}
