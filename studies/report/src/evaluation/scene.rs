//! The shapes of the machine's bodies in body axes, for the report's animation and for the live
//! page (command `machine scene`). Both compute the bodies' poses from joint angles.
//!
//! The shapes are made up around the mechanism's points, which are exact.

#![allow(non_snake_case)] // points as in the paper

use anyhow::{Result, ensure};
use cosim::{Recording, System};
use experiments::machines::robot::equivalent_box;
use experiments::setup::machine_choice::{Ruled, ruled};
use hdrm::{BODIES, Body, Tree};
use machine_file::{Geometry, Machine};
use machine_sheet::LoadChart;
use motion_check::gain_rule::Actuators;
use nalgebra::Vector3;
use serde::Serialize;
use std::collections::BTreeMap;

/// Payloads of the load chart's curves, kg, for a machine whose median greatest payload is
/// [`MEDIAN`]; for others times a round factor.
const PAYLOADS: [f64; 6] = [300.0, 400.0, 500.0, 700.0, 900.0, 1200.0];
const MEDIAN: f64 = 600.0;
/// Largest distance between the drawn tip and the FMU's if both have the same machine file, m.
const TIP_TOLERANCE: f64 = 1e-6;

/// The ground is that of the base if the tip starts this high over it, else so far below the tip, m.
const TIP_OVER_GROUND: f64 = 0.5;
const LOW_TIP: f64 = 1.0;

#[derive(Serialize)]
pub struct Scene {
    bodies: Vec<BodyShape>,
    tree: Tree,
    /// Height of the ground, m: below the base where the machine starts with its tip low, as a crane
    /// on a vehicle does.
    floor: f64,
}

/// The scene for the live page.
#[derive(Serialize)]
pub struct LiveScene<'a> {
    /// Name of the machine; empty for the reference machine.
    name: &'a str,
    /// The machine file for the FMUs, whole; none for the reference machine, which they have.
    file: Option<&'a Machine>,
    /// What the FMUs are given in each world besides the file, as by `hdrm-fmu run --machine`.
    settings: BTreeMap<&'static str, BTreeMap<String, f64>>,
    bodies: &'a [BodyShape],
    tree: &'a Tree,
    floor: f64,
    /// Rated force of each rod, N.
    rated: [f64; 3],
    /// Least and largest angle of each joint, rad.
    joints: [[f64; 2]; 6],
    /// Least and largest stroke of each rod, m.
    strokes: [[f64; 2]; 3],
    /// Largest distance of the tip from the slew axis in the load chart, m.
    reach: f64,
    /// The load chart: a curve for each of six payloads.
    chart: Vec<LoadCurve>,
}

/// Where a payload is the greatest that the machine holds.
#[derive(Serialize)]
struct LoadCurve {
    /// kg.
    payload: f64,
    /// [reach, height, reach, height], m, to the millimetre.
    pieces: Vec<[f64; 4]>,
}

#[derive(Serialize)]
struct BodyShape {
    name: String,
    /// The body's name in words.
    title: &'static str,
    /// kg.
    mass: f64,
    shapes: Vec<Shape>,
}

/// A shape in body axes, m.
#[derive(Serialize)]
#[serde(rename_all = "lowercase", tag = "kind")]
enum Shape {
    /// Polygon in the body's x-y plane, extruded from `z[0]` to `z[1]`.
    Plate { outline: Vec<[f64; 2]>, z: [f64; 2] },
    Bar {
        from: [f64; 3],
        to: [f64; 3],
        radius: f64,
    },
    /// Box with axes along the body's.
    Box { centre: [f64; 3], size: [f64; 3] },
}

impl Scene {
    pub fn new(machine: &Machine) -> Result<Self> {
        let tree = Tree::new(machine)?;
        let bodies = BODIES.map(|body| BodyShape {
            name: format!("{body:?}"),
            title: title(body),
            mass: machine.bodies.in_order()[body as usize].mass,
            shapes: shapes(body, &tree, machine),
        });
        let start = tip_place(&tree, &machine.start.zeta).y;
        let floor = if start < TIP_OVER_GROUND {
            start - LOW_TIP
        } else {
            0.0
        };
        Ok(Self {
            bodies: bodies.into(),
            tree,
            floor: (1000.0 * floor).round() / 1000.0,
        })
    }

    /// The scene for the live page; `machine`, called `name`, is the one that was given to
    /// [`Scene::new`].
    pub fn to_live<'a>(&'a self, name: &'a str, machine: &'a Machine) -> Result<LiveScene<'a>> {
        let own = (*machine != Machine::reference()).then_some(machine);
        let worlds = [
            (
                "ideal",
                Actuators::Known,
                &["emla_1", "emla_2", "emla_3"][..],
            ),
            // Actuators as built have no network.
            ("real", Actuators::AsBuilt, &[]),
        ];
        let settings = worlds.map(|(world, actuators, blended)| {
            let Ruled { gains, alpha } = own
                .map(|machine| ruled(machine, actuators, &[]))
                .transpose()?
                .unwrap_or_default();
            let gains = gains.into_iter();
            let gains = gains.map(|gain| (format!("controller.{}", gain.name), gain.value));
            let alphas = alpha.into_iter().flat_map(|alpha| {
                let components = ["controller"].iter().chain(blended);
                components.map(move |component| (format!("{component}.alpha"), alpha))
            });
            Ok((world, gains.chain(alphas).collect()))
        });
        let chart = LoadChart::new(machine, 1.0)?;
        let millimetres = |x: f64| (1000.0 * x).round() / 1000.0;
        let curve = |payload| LoadCurve {
            payload,
            pieces: (chart.curve(payload).into_iter())
                .map(|piece| piece.map(millimetres))
                .collect(),
        };
        Ok(LiveScene {
            name: own.map_or("", |_| name),
            file: own,
            settings: settings.into_iter().collect::<Result<_>>()?,
            bodies: &self.bodies,
            tree: &self.tree,
            floor: self.floor,
            rated: machine.ratings.in_order().map(|ratings| ratings.force_max),
            joints: machine.limits.zeta(),
            strokes: machine.limits.strokes(),
            chart: (payloads(&chart).map(curve).into_iter())
                .filter(|curve| !curve.pieces.is_empty())
                .collect(),
            reach: (chart.points().map(|point| point.reach)).fold(0.0, f64::max),
        })
    }

    /// Largest distance of the tip at the FMU's joint angles, which the page draws, from the FMU's
    /// own at every `stride`-th point of a run, m. An error where that is another machine's.
    pub fn drawing_error(
        &self,
        system: &System,
        recording: &Recording,
        stride: usize,
    ) -> Result<f64> {
        let arm = system.port("hdrm.zeta[1]")?.component;
        let columns = |name: &str, n: usize| -> Result<Vec<&[f64]>> {
            let ports = system.elements(arm, name, n)?;
            ports.into_iter().map(|p| recording.column(p)).collect()
        };
        let (zeta, tip) = (columns("zeta", hdrm::DOF)?, columns("tip.position", 3)?);
        let mut error = 0.0_f64;
        for k in (0..recording.times.len()).step_by(stride) {
            let drawn = tip_place(&self.tree, &std::array::from_fn(|i| zeta[i][k]));
            error = error.max((drawn - Vector3::from_fn(|i, _| tip[i][k])).norm());
        }
        ensure!(
            error <= TIP_TOLERANCE,
            "the tip is drawn {error:.1e} m from where the FMU has it: the machine file is not the one the FMU runs with"
        );
        Ok(error)
    }
}

/// [`PAYLOADS`] for the machine of this chart.
fn payloads(chart: &LoadChart) -> [f64; 6] {
    let mut greatest: Vec<f64> = chart.points().filter_map(|point| point.payload).collect();
    greatest.sort_by(f64::total_cmp);
    let median = greatest
        .get(greatest.len() / 2)
        .map_or(MEDIAN, |payload| payload.max(1.0));
    // The factor of the series 1, 2, 5 that is nearest to the machine's, from 0.001 to 5000.
    let rounds = (-3..4).flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10_f64.powi(power)));
    let distance = |factor: &f64| (factor * MEDIAN / median).ln().abs();
    let factor = rounds.min_by(|a, b| distance(a).total_cmp(&distance(b)));
    PAYLOADS.map(|payload| factor.unwrap_or(1.0) * payload)
}

/// Where the tip is at these joint angles, m.
fn tip_place(tree: &Tree, zeta: &[f64; hdrm::DOF]) -> Vector3<f64> {
    let D4 = tree.configuration(zeta).world_poses()[Body::D4 as usize];
    D4.r + D4.R * tree.r_D4_T4
}

fn title(body: Body) -> &'static str {
    match body {
        Body::T1 => "base column",
        Body::A2 => "lift boom",
        Body::C2 => "lift cylinder",
        Body::D2 => "lift rod",
        Body::A3 => "tilt boom",
        Body::C3 => "tilt cylinder",
        Body::D3 => "tilt rod",
        Body::RK => "rocker A–D",
        Body::CP => "coupler C–D",
        Body::A4 => "wrist 1",
        Body::C4 => "wrist 2",
        Body::D4 => "wrist 3 and tip",
        Body::PL => "payload",
    }
}

fn shapes(body: Body, tree: &Tree, machine: &Machine) -> Vec<Shape> {
    let g = &machine.geometry;
    // Thickness of the booms; it scales everything whose size the machine file does not give.
    let d = 0.1 * tree.r_A2_B.norm();
    match body {
        Body::T1 => column(tree, g, d),
        Body::A2 => lift_boom(tree, d),
        Body::C2 => cylinder(tree.lift.x0, d),
        Body::D2 => rod(tree.lift.x0, tree.lift.lc, d),
        Body::A3 => tilt_boom(tree, d),
        Body::C3 => cylinder(tree.tilt.x0, 0.85 * d),
        Body::D3 => rod(tree.tilt.x0, tree.tilt.lc, 0.85 * d),
        Body::RK => pair_of_links(tree.tilt.d4, 0.66 * d, d),
        Body::CP => pair_of_links(tree.tilt.d5, 0.5 * d, d),
        Body::A4 => wrist(tree.r_A4_C4, 0.42 * d),
        Body::C4 => wrist(tree.r_C4_D4, 0.38 * d),
        Body::D4 => wrist(tree.r_D4_T4, 0.3 * d),
        Body::PL => vec![payload(&machine.bodies.PL)],
    }
}

/// Column up to the lift joint with brackets for joint and cylinder foot, and the slew wheel of
/// radius `r_B`.
fn column(tree: &Tree, g: &Geometry, d: f64) -> Vec<Shape> {
    let O = tree.r_T1_O;
    let foot = [O.x + tree.lift.foot.x, O.y + tree.lift.foot.y];
    let upright = |y0: f64, y1: f64, radius| bar([0.0, y0, 0.0], [0.0, y1, 0.0], radius);
    let mut shapes = vec![
        upright(0.0, 0.3 * d, 1.15 * g.r_B),
        upright(0.3 * d, 0.7 * d, g.r_B),
        upright(0.7 * d, O.y - d, 0.85 * d),
    ];
    let reach = 0.35 * d;
    let joint_bracket = [
        [-0.8 * d, O.y - 1.6 * d],
        [0.8 * d, O.y - 1.6 * d],
        [O.x + reach, O.y],
        [O.x, O.y + reach],
        [O.x - reach, O.y],
    ];
    let foot_bracket = [
        [0.0, foot[1] - 1.2 * d],
        [foot[0] + reach, foot[1] - 0.3 * reach],
        [foot[0], foot[1] + reach],
        [0.0, foot[1] + 0.9 * d],
    ];
    shapes.extend(pair_of_plates(&joint_bracket, 0.62 * d, 0.12 * d));
    shapes.extend(pair_of_plates(&foot_bracket, 0.62 * d, 0.12 * d));
    shapes.push(pin([O.x, O.y], 0.85 * d, 0.16 * d));
    shapes.push(pin(foot, 0.8 * d, 0.13 * d));
    shapes
}

/// Box boom O–B that tapers, with the brackets of rod pin, rocker pivot A and cylinder foot E.
fn lift_boom(tree: &Tree, d: f64) -> Vec<Shape> {
    let B = tree.r_A2_B.xy();
    let e = B.normalize();
    let n = nalgebra::Vector2::new(-e.y, e.x);
    let at = |along: f64, across: f64| -> [f64; 2] { (e * along + n * across).into() };
    let length = B.norm();
    let mut shapes = vec![Shape::Plate {
        outline: vec![
            at(-0.5 * d, 0.1 * d),
            at(-0.3 * d, -0.4 * d),
            at(0.3 * length, -0.62 * d),
            at(length, -0.35 * d),
            at(length + 0.35 * d, 0.0),
            at(length, 0.4 * d),
            at(0.3 * length, 0.62 * d),
            at(-0.3 * d, 0.5 * d),
        ],
        z: [-0.42 * d, 0.42 * d],
    }];
    let mounted = [
        nalgebra::Vector2::new(tree.lift.L1, 0.0),
        tree.r_A2_A.xy(),
        tree.r_A2_E.xy(),
    ];
    for p in mounted {
        let (along, across) = (p.dot(&e), p.dot(&n));
        let beyond = across + 0.28 * d * across.signum();
        let bracket = [
            at(along - 0.9 * d, 0.0),
            at(along + 0.9 * d, 0.0),
            at(along + 0.25 * d, beyond),
            at(along - 0.25 * d, beyond),
        ];
        shapes.extend(pair_of_plates(&bracket, 0.48 * d, 0.1 * d));
        shapes.push(pin(p.into(), 0.78 * d, 0.12 * d));
    }
    shapes.push(pin(B.into(), 0.85 * d, 0.16 * d));
    shapes
}

/// Tapered boom from the tilt joint to the wrist, with the coupler's pivot C.
fn tilt_boom(tree: &Tree, d: f64) -> Vec<Shape> {
    let (length, C) = (tree.r_A3_A4.x, tree.tilt.C);
    vec![
        Shape::Plate {
            outline: vec![
                [-0.35 * d, 0.0],
                [0.0, -0.4 * d],
                [C.x, C.y - 0.55 * d],
                [length, -0.3 * d],
                [length, 0.3 * d],
                [C.x, C.y + 0.55 * d],
                [0.0, 0.4 * d],
            ],
            z: [-0.34 * d, 0.34 * d],
        },
        pin(C.into(), 0.78 * d, 0.12 * d),
        bar([length - 0.5 * d, 0.0, 0.0], tree.r_A3_A4.into(), 0.42 * d),
    ]
}

/// Barrel from the foot, with the motor on it.
fn cylinder(x0: f64, d: f64) -> Vec<Shape> {
    let along = |x0: f64, x1: f64, y: f64, radius| bar([x0, y, 0.0], [x1, y, 0.0], radius);
    vec![
        along(0.0, 0.93 * x0, 0.0, 0.3 * d),
        along(0.87 * x0, 0.95 * x0, 0.0, 0.36 * d),
        along(0.12 * x0, 0.5 * x0, -0.62 * d, 0.26 * d),
        Shape::Box {
            centre: [0.1 * x0, -0.3 * d, 0.0],
            size: [0.08 * x0, 1.1 * d, 0.55 * d],
        },
    ]
}

/// The rod up to its pin at `lc`, long enough at its other end to stay inside the barrel.
fn rod(x0: f64, lc: f64, d: f64) -> Vec<Shape> {
    vec![
        bar([lc - x0, 0.0, 0.0], [lc, 0.0, 0.0], 0.17 * d),
        pin([lc, 0.0], 0.4 * d, 0.24 * d),
    ]
}

/// Two bars along x, one on each side of the boom at distance `z` from its plane.
fn pair_of_links(length: f64, z: f64, d: f64) -> Vec<Shape> {
    let half = 0.15 * d;
    let outline = [
        [-half, 0.0],
        [0.0, -half],
        [length, -half],
        [length + half, 0.0],
        [length, half],
        [0.0, half],
    ];
    let [left, right] = pair_of_plates(&outline, z, 0.1 * d);
    vec![left, right, pin([length, 0.0], 0.8 * d, 0.11 * d)]
}

fn wrist(next: Vector3<f64>, radius: f64) -> Vec<Shape> {
    vec![
        pin([0.0, 0.0], 1.15 * radius, 0.8 * radius),
        bar([0.0; 3], next.into(), radius),
    ]
}

/// The box with the body's mass and moments of inertia.
fn payload(body: &machine_file::Body) -> Shape {
    Shape::Box {
        centre: body.com,
        size: equivalent_box(body),
    }
}

/// A round bar across the boom plane.
fn pin([x, y]: [f64; 2], half_width: f64, radius: f64) -> Shape {
    bar([x, y, -half_width], [x, y, half_width], radius)
}

fn bar(from: [f64; 3], to: [f64; 3], radius: f64) -> Shape {
    Shape::Bar { from, to, radius }
}

/// Two equal plates, one on each side of the boom plane at the distance `inner`.
fn pair_of_plates(outline: &[[f64; 2]], inner: f64, thickness: f64) -> [Shape; 2] {
    let outer = inner + thickness;
    [[-outer, -inner], [inner, outer]].map(|z| Shape::Plate {
        outline: outline.to_vec(),
        z,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Oracle: a box of edges a, b, c has I_xx = m (b² + c²)/12.
    #[test]
    fn the_payload_is_drawn_as_the_box_with_its_inertia() {
        let mut body = Machine::reference().bodies.PL;
        let (m, [a, b, c]) = (body.mass, [0.3, 0.5, 0.7]);
        body.inertia_com.xx = m * (b * b + c * c) / 12.0;
        body.inertia_com.yy = m * (c * c + a * a) / 12.0;
        body.inertia_com.zz = m * (a * a + b * b) / 12.0;
        let size = equivalent_box(&body);
        for (drawn, edge) in size.iter().zip([a, b, c]) {
            assert!((drawn - edge).abs() < 1e-12, "{drawn} {edge}");
        }
    }

    /// Over the whole stroke the drawn rod leaves the barrel neither in front nor behind.
    #[test]
    fn rods_stay_in_their_barrels() {
        let machine = Machine::reference();
        let tree = Tree::new(&machine).unwrap();
        for (x0, lc, [min, max]) in [
            (tree.lift.x0, tree.lift.lc, machine.limits.stroke_2),
            (tree.tilt.x0, tree.tilt.lc, machine.limits.stroke_3),
        ] {
            let Shape::Bar { from, .. } = &rod(x0, lc, 0.2)[0] else {
                panic!("a bar");
            };
            let Shape::Bar { to, .. } = &cylinder(x0, 0.2)[0] else {
                panic!("a bar");
            };
            let rear = |x: f64| x0 + x - lc + from[0];
            assert!(rear(min) >= -1e-12 && rear(max) < to[0], "{x0} {lc}");
        }
    }
}
