//! Draws machines that differ from the nominal one by random errors within bounds, by seed: for the
//! worlds `real` and `strict-rigid`, the surrogate in the loop, `machine perturb` and Python.
//!
//! Errors: each body's mass and inertia by one factor, its centre of mass and its second moments of
//! mass along each axis, joint friction, each length of the geometry, and the direction of gravity.
//! With bounds below 1 every body stays physically possible: its pseudo-inertia stays positive
//! definite, because masses are scaled by positive factors, second moments `Σ` are stretched to
//! `D Σ D`, and moving the centre of mass shifts the body as a whole.
#![allow(non_snake_case)] // the symbols of mechanics

use std::fs;
use std::ops::Range;

use anyhow::{Context, Result, ensure};
use cosim::System;
use machine_file::{Body, InertiaTensor, Machine};
use output_file::TemporaryFolder;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};
use serde_json::Value;

use crate::runs::grid::Case;
use crate::setup::machine_choice::MachineFile;

/// Bounds of the errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Relative error of a mass with its inertia, and of joint friction.
    pub mass: f64,
    /// Error of a centre of mass along each axis, m.
    pub com: f64,
    /// Relative error of a second moment of mass along each axis, in addition to that of the mass.
    pub second_moment: f64,
    /// Error of a length, m.
    pub length: f64,
    /// Angle of gravity from the vertical about each horizontal axis, rad.
    pub plumb: f64,
}

impl Bounds {
    /// Bounds of the real world.
    pub const REAL: Self = Self {
        mass: 0.4,
        com: 0.05,
        second_moment: 0.0,
        length: 1e-3,
        plumb: std::f64::consts::PI / 180.0,
    };

    /// These bounds times a factor.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self {
            mass: factor * self.mass,
            com: factor * self.com,
            second_moment: factor * self.second_moment,
            length: factor * self.length,
            plumb: factor * self.plumb,
        }
    }

    /// Refuses bounds that are negative, not finite or too large for a physically possible machine.
    fn check(&self) -> Result<()> {
        for (name, value, most) in [
            ("mass", self.mass, 1.0),
            ("com", self.com, f64::INFINITY),
            ("second-moment", self.second_moment, 1.0),
            ("length", self.length, f64::INFINITY),
            ("plumb", self.plumb, 0.5),
        ] {
            ensure!(
                value >= 0.0 && value < most,
                "the bound `{name}` = {value} must be at least 0 and below {most}"
            );
        }
        Ok(())
    }
}

/// Draws a machine by errors of `nominal`, and its gravity in the world frame, m/s². Fails for
/// bounds that are too large, or if the drawn geometry cannot be closed.
pub fn draw(nominal: &Machine, seed: u64, bounds: &Bounds) -> Result<(Machine, [f64; 3])> {
    bounds.check()?;
    let even = Uniform::new_inclusive(-1.0, 1.0).expect("finite bounds");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    // Second moments have their own random stream, so that the other errors do not depend on them.
    let mut moments = ChaCha8Rng::seed_from_u64(seed);
    moments.set_stream(1);
    let mut error = |bound: f64| bound * even.sample(&mut random);
    let mut machine = nominal.clone();
    for body in machine.bodies.in_order_mut() {
        let factor = 1.0 + error(bounds.mass);
        body.mass *= factor;
        let I = &mut body.inertia_com;
        for moment in [
            &mut I.xx, &mut I.yy, &mut I.zz, &mut I.xy, &mut I.xz, &mut I.yz,
        ] {
            *moment *= factor;
        }
        for com in &mut body.com {
            *com += error(bounds.com);
        }
        if bounds.second_moment > 0.0 {
            let stretch = [0; 3].map(|_| 1.0 + bounds.second_moment * even.sample(&mut moments));
            body.inertia_com = stretched(body, stretch);
        }
    }
    for d in &mut machine.joint_viscous {
        *d *= 1.0 + error(bounds.mass);
    }
    let mut geometry = serde_json::to_value(&machine.geometry)?;
    for (name, value) in geometry.as_object_mut().context("a table of lengths")? {
        if !name.starts_with("beta") {
            lengthen(value, &mut || error(bounds.length));
        }
    }
    machine.geometry = serde_json::from_value(geometry)?;
    machine
        .check()
        .with_context(|| format!("machine of seed {seed}"))?;
    let [along, across] = [error(bounds.plumb), error(bounds.plumb)];
    let g = nominal.gravity;
    let down = -g * (1.0 - along.sin().powi(2) - across.sin().powi(2)).sqrt();
    Ok((machine, [g * along.sin(), down, g * across.sin()]))
}

/// Inertia of a body after its second moments of mass `Σ = ½ tr(I)·1 − I` are stretched by
/// `factors` along its axes: `D Σ D` with `D = diag(√factors)`, then back to `I = tr(Σ)·1 − Σ`.
fn stretched(body: &Body, factors: [f64; 3]) -> InertiaTensor {
    let I = &body.inertia_com;
    let [x, y, z] = factors.map(f64::sqrt);
    let half = 0.5 * (I.xx + I.yy + I.zz);
    let [a, b, c] = [
        x * x * (half - I.xx),
        y * y * (half - I.yy),
        z * z * (half - I.zz),
    ];
    InertiaTensor {
        xx: b + c,
        yy: a + c,
        zz: a + b,
        xy: x * y * I.xy,
        xz: x * z * I.xz,
        yz: y * z * I.yz,
    }
}

/// Adds an error to every length that is not zero by construction.
fn lengthen(value: &mut Value, error: &mut impl FnMut() -> f64) {
    if let Value::Array(values) = value {
        values.iter_mut().for_each(|v| lengthen(v, error));
    } else if let Some(length) = value.as_f64().filter(|length| *length != 0.0) {
        *value = (length + error()).into();
    }
}

/// Cases, and the temporary machine files that they name, which are deleted with this value.
pub struct Cases {
    /// The cases.
    pub list: Vec<Case>,
    _folder: Option<TemporaryFolder>,
}

impl From<Vec<Case>> for Cases {
    fn from(list: Vec<Case>) -> Self {
        let _folder = None;
        Self { list, _folder }
    }
}

impl Cases {
    /// One case for each seed: a machine drawn within bounds, and the same seed for the sensors,
    /// which draw their own errors. The actuators stay those of the system, `Rig`; the controller
    /// knows nothing of their friction, backlash, compliance, heat and drives.
    pub fn draw_machines(system: &System, seeds: Range<u64>, bounds: &Bounds) -> Result<Self> {
        let nominal = MachineFile::from_manipulator(system, &[])?.machine;
        let folder = TemporaryFolder::new().context("no temporary folder for the machine files")?;
        let mut list = Vec::new();
        for seed in seeds {
            let (machine, gravity) = draw(&nominal, seed, bounds)?;
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
            list.push(Case::from_seed(seed, settings));
        }
        let _folder = Some(folder);
        Ok(Self { list, _folder })
    }

    /// The cases without what they set of the variable `name`.
    pub fn without(mut self, system: &System, name: &str) -> Result<Self> {
        let port = system.port(name)?;
        for case in &mut self.list {
            case.settings.retain(|setting| setting.port != port);
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Matrix4, Vector3};

    #[test]
    fn errors_are_within_their_bounds_and_another_for_each_seed() {
        let (nominal, bounds) = (Machine::reference(), Bounds::REAL);
        let mut largest = [0.0_f64; 4];
        for seed in 1..40 {
            let (machine, gravity) = draw(&nominal, seed, &bounds).expect("a machine");
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
            let (again, _) = draw(&nominal, seed, &bounds).expect("a machine");
            assert_eq!(machine, again);
        }
        let most = [bounds.mass, bounds.com, bounds.length, bounds.plumb];
        for (found, bound) in largest.into_iter().zip(most) {
            assert!(found <= bound && found > 0.9 * bound, "{found} of {bound}");
        }
    }

    /// Pseudo-inertia about the origin of the body's axes, by the book (Wensing, Kim, Slotine
    /// 2018): `[[Σ, h], [hᵀ, m]]` with `Σ = ½ tr(I)·1 − I` about that origin, `h = m c`.
    fn pseudo_inertia(body: &Body) -> Matrix4<f64> {
        let c = Vector3::from(body.com);
        let about_com = Matrix3::from(body.inertia_com.rows());
        let I =
            about_com + (Matrix3::identity() * c.norm_squared() - c * c.transpose()) * body.mass;
        let second = Matrix3::identity() * (0.5 * I.trace()) - I;
        let mut J = Matrix4::zeros();
        J.fixed_view_mut::<3, 3>(0, 0).copy_from(&second);
        J.fixed_view_mut::<3, 1>(0, 3).copy_from(&(c * body.mass));
        J.fixed_view_mut::<1, 3>(3, 0)
            .copy_from(&(c * body.mass).transpose());
        J[(3, 3)] = body.mass;
        J
    }

    /// A body can exist exactly where its pseudo-inertia is positive definite. The bounds go far
    /// beyond those of the real world: heavier by 95 % or 20 times lighter, centres of mass half a
    /// metre off, second moments by ±90 %.
    #[test]
    fn every_drawn_body_has_a_positive_definite_pseudo_inertia() {
        let nominal = Machine::reference();
        let wide = Bounds {
            mass: 0.95,
            com: 0.5,
            second_moment: 0.9,
            ..Bounds::REAL
        };
        for bounds in [Bounds::REAL, wide] {
            for seed in 0..200 {
                let (machine, _) = draw(&nominal, seed, &bounds).expect("a machine");
                for (body, name) in machine
                    .bodies
                    .in_order()
                    .iter()
                    .zip(machine_file::Bodies::NAMES)
                {
                    let J = pseudo_inertia(body);
                    assert!(
                        J.cholesky().is_some(),
                        "seed {seed}, {name}: eigenvalues {:?}",
                        J.symmetric_eigenvalues()
                    );
                }
            }
        }
    }

    /// Oracle: a box whose second moments are `m a²/12` along each edge; stretching by f makes
    /// edges `a √f`.
    #[test]
    fn a_stretched_box_is_a_box() {
        let (m, edges) = (31.0, [0.7, 1.1, 1.9]);
        let inertia = |[a, b, c]: [f64; 3]| {
            let of = |p: f64, q: f64| m / 12.0 * (p * p + q * q);
            InertiaTensor {
                xx: of(b, c),
                yy: of(a, c),
                zz: of(a, b),
                xy: 0.0,
                xz: 0.0,
                yz: 0.0,
            }
        };
        let body = Body {
            mass: m,
            com: [0.0; 3],
            inertia_com: inertia(edges),
        };
        let factors: [f64; 3] = [1.3, 0.8, 0.6];
        let found = stretched(&body, factors);
        let expected = inertia([0, 1, 2].map(|k| edges[k] * factors[k].sqrt()));
        for (a, b) in [
            (found.xx, expected.xx),
            (found.yy, expected.yy),
            (found.zz, expected.zz),
        ] {
            assert!((a - b).abs() < 1e-13 * b, "{a} {b}");
        }
    }

    #[test]
    fn bounds_that_leave_no_machine_are_refused() {
        for bounds in [
            Bounds {
                mass: 1.0,
                ..Bounds::REAL
            },
            Bounds {
                com: f64::NAN,
                ..Bounds::REAL
            },
            Bounds {
                second_moment: -0.1,
                ..Bounds::REAL
            },
        ] {
            let refused = draw(&Machine::reference(), 1, &bounds).expect_err("refused");
            assert!(refused.to_string().contains("must be"), "{refused:#}");
        }
    }
}
