//! The machines of the real world: what is drawn by seed, and the files that hold it.
//!
//! Each body's mass and inertia by ±40 % (one factor, so the body stays physical), its centre of mass by ±50 mm along each axis, joint
//! friction by ±40 %, each length of the geometry by ±1 mm, gravity out of plumb by up to 1°; zeros of the joint encoders and errors of the
//! other sensors by the same seed. The actuators are those of the system, `Rig`, of whose friction, play, compliance, heat and drive the
//! controller knows nothing.

use std::fs;
use std::ops::Range;

use anyhow::{Context, Result};
use cosim::system::System;
use machine::Machine;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};
use serde_json::Value;
use tempfile::TempDir;

use super::Case;

/// Packed system of the real world.
pub const SYSTEM: &str = "Real.ssp";
/// Its parameter set: what is changed in the controller, and in where the delay is, for this world.
pub const PARAMETERS: &str = "resources/real.ssv";

/// Error of a mass and of joint friction, as a part.
const MASS: f64 = 0.4;
/// Error of a centre of mass along each axis, m.
const COM: f64 = 0.05;
/// Error of a length, m.
const LENGTH: f64 = 1e-3;
/// Error of plumb, rad.
const PLUMB: f64 = std::f64::consts::PI / 180.0;

/// Machines, and the folder of their files.
pub struct Cases {
    list: Vec<Case>,
    _folder: Option<TempDir>,
}

impl Cases {
    /// Cases without files.
    pub fn plain(list: Vec<Case>) -> Self {
        Self {
            list,
            _folder: None,
        }
    }

    /// One case for each seed: the machine of the manipulator and the seed of the sensors.
    ///
    /// # Errors
    /// A system without `hdrm` or `sensors`, or no place for files.
    pub fn drawn(system: &System, seeds: Range<u64>) -> Result<Self> {
        let folder = TempDir::new().context("no folder for the machine files")?;
        let mut list = Vec::new();
        for seed in seeds {
            let (machine, gravity) = draw(&Machine::reference(), seed)?;
            let path = folder.path().join(format!("machine_{seed}.json"));
            let text = serde_json::to_string_pretty(&machine)?;
            fs::write(&path, text).with_context(|| path.display().to_string())?;
            let mut settings = vec![
                system.setting("hdrm.machine_file", path.display())?,
                system.setting("sensors.seed", seed)?,
            ];
            for (axis, value) in (1..).zip(gravity) {
                settings.push(system.setting(&format!("hdrm.gravity[{axis}]"), value)?);
            }
            list.push(Case {
                label: format!("seed {seed}"),
                settings,
            });
        }
        Ok(Self {
            list,
            _folder: Some(folder),
        })
    }

    /// The cases; their files exist as long as this.
    pub fn list(&self) -> &[Case] {
        &self.list
    }
}

/// A machine of the same kind as `nominal`, and its gravity in the world, m/s².
fn draw(nominal: &Machine, seed: u64) -> Result<(Machine, [f64; 3])> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let even = Uniform::new_inclusive(-1.0, 1.0).expect("finite bounds");
    let mut error = |bound: f64| bound * even.sample(&mut random);
    let mut machine = nominal.clone();
    for body in machine.bodies.in_order_mut() {
        let factor = 1.0 + error(MASS);
        body.mass *= factor;
        let I = &mut body.inertia_com;
        for moment in [
            &mut I.xx, &mut I.yy, &mut I.zz, &mut I.xy, &mut I.xz, &mut I.yz,
        ] {
            *moment *= factor;
        }
        body.com.iter_mut().for_each(|com| *com += error(COM));
    }
    machine
        .joint_viscous
        .iter_mut()
        .for_each(|d| *d *= 1.0 + error(MASS));
    let mut geometry = serde_json::to_value(&machine.geometry)?;
    for (name, value) in geometry.as_object_mut().context("a table of lengths")? {
        if !name.starts_with("beta") {
            stretch(value, &mut || error(LENGTH));
        }
    }
    machine.geometry = serde_json::from_value(geometry)?;
    machine
        .check()
        .with_context(|| format!("machine of seed {seed}"))?;
    let [along, across] = [error(PLUMB), error(PLUMB)];
    let g = nominal.gravity;
    let down = -g * (1.0 - along.sin().powi(2) - across.sin().powi(2)).sqrt();
    Ok((machine, [g * along.sin(), down, g * across.sin()]))
}

/// Add an error to every length that is not zero by construction.
fn stretch(value: &mut Value, error: &mut impl FnMut() -> f64) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(|v| stretch(v, error)),
        Value::Number(length) => match length.as_f64() {
            Some(length) if length != 0.0 => *value = (length + error()).into(),
            _ => {}
        },
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_within_their_bounds_and_another_for_each_seed() {
        let nominal = Machine::reference();
        let mut largest = [0.0_f64; 4];
        for seed in 1..40 {
            let (machine, gravity) = draw(&nominal, seed).expect("a machine");
            for (drawn, body) in machine
                .bodies
                .in_order()
                .iter()
                .zip(nominal.bodies.in_order())
            {
                largest[0] = largest[0].max((drawn.mass / body.mass - 1.0).abs());
                for (a, b) in drawn.com.iter().zip(body.com) {
                    largest[1] = largest[1].max((a - b).abs());
                }
                let ratio = drawn.inertia_com.yy / body.inertia_com.yy;
                assert!((ratio - drawn.mass / body.mass).abs() < 1e-12);
            }
            largest[2] = largest[2].max((machine.geometry.d4 - nominal.geometry.d4).abs());
            let size = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
            assert!((size - nominal.gravity).abs() < 1e-12, "{size}");
            largest[3] = largest[3].max((gravity[0] / nominal.gravity).asin().abs());
            let (again, _) = draw(&nominal, seed).expect("a machine");
            assert_eq!(machine, again);
        }
        for (found, bound) in largest.into_iter().zip([MASS, COM, LENGTH, PLUMB]) {
            assert!(found <= bound && found > 0.9 * bound, "{found} of {bound}");
        }
    }
}
