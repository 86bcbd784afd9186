//! Links and joints of a machine, for `mjcf` and `urdf`: the tree that is left when both loops are
//! cut at their pins. Coordinates of joints are those of `Hdrm`: `zeta_i` in rad, `rod_i` is the
//! stroke `x_i` in m; the four passive joints turn from their parent's x axis.
#![allow(non_snake_case)] // symbols of the machine file

use anyhow::Result;
use hdrm::{BODIES, Body, Configuration, DOF, Hdrm, Options};
use machine_file::Machine;
use nalgebra::{Vector2, Vector3};

/// Poses at which a joint's range and gear are looked at.
const SAMPLES: u32 = 200;

/// A machine as links and joints.
pub struct Robot<'a> {
    pub(super) name: String,
    pub(super) machine: &'a Machine,
    pub(super) plant: Hdrm,
    start: Configuration,
}

/// A body's joint. Its coordinate is `q`.
pub(super) struct Joint {
    pub name: &'static str,
    pub is_slide: bool,
    pub axis: Vector3<f64>,
    /// Of the joint in the parent's axes, m.
    pub origin: Vector3<f64>,
    /// The joint's angle from the parent's axes, or its distance from the origin, at q = 0.
    pub offset: f64,
    pub start: f64,
    /// Least and largest q; of a passive joint those that the others allow.
    pub range: [f64; 2],
    /// N·m·s/rad.
    pub damping: f64,
    /// Force or torque, and rate, that the drive gives at every place of the range; a passive joint
    /// has no force.
    pub effort: f64,
    pub rate: f64,
    pub is_passive: bool,
}

/// A round bar in body axes, m.
pub(super) struct Bar {
    pub from: Vector3<f64>,
    pub to: Vector3<f64>,
    pub radius: f64,
}

/// Pins at which the loops are cut, by body and distance along its x axis, m.
pub(super) struct Cut {
    pub rod: (Body, f64),
    pub other: (Body, f64),
}

impl<'a> Robot<'a> {
    /// An error if the machine's loops do not close.
    pub fn new(name: String, machine: &'a Machine) -> Result<Self> {
        let plant = Hdrm::new(machine, &Options::from_machine(machine))?;
        let start = plant.tree().configuration(&machine.start.zeta);
        Ok(Self {
            name,
            machine,
            plant,
            start,
        })
    }

    /// Bodies whose joint is at a body; `None`: at the ground.
    pub(super) fn children(&self, of: Option<Body>) -> impl Iterator<Item = Body> {
        (BODIES.into_iter()).filter(move |body| body.parent() == of)
    }

    pub(super) fn cuts(&self) -> [Cut; 3] {
        let g = &self.machine.geometry;
        [
            (Body::D2, g.lc_2, Body::A2, g.L1_2),
            (Body::D3, g.lc_3, Body::RK, g.d4),
            (Body::D3, g.lc_3, Body::CP, g.d5),
        ]
        .map(|(rod, lc, other, at)| Cut {
            rod: (rod, lc),
            other: (other, at),
        })
    }

    /// The body's joint; `None`: it is fixed in its parent's frame.
    pub(super) fn joint(&self, body: Body) -> Option<Joint> {
        let (machine, tree) = (self.machine, self.plant.tree());
        let (c, range) = (body.coordinate(), machine.limits.zeta());
        let zeta_name = ["zeta_1", "zeta_2", "zeta_3", "zeta_4", "zeta_5", "zeta_6"];
        let (name, offset, is_passive) = match body {
            Body::A2 => ("zeta_2", -machine.geometry.beta2, false),
            Body::A3 => ("zeta_3", machine.geometry.beta2, false),
            Body::T1 | Body::A4 | Body::C4 | Body::D4 => (zeta_name[c], 0.0, false),
            Body::C2 => ("cylinder_2", 0.0, true),
            Body::C3 => ("cylinder_3", 0.0, true),
            Body::RK => ("rocker", 0.0, true),
            Body::CP => ("coupler", 0.0, true),
            Body::D2 => ("rod_2", tree.lift.x0 - tree.lift.lc, false),
            Body::D3 => ("rod_3", tree.tilt.x0 - tree.tilt.lc, false),
            Body::PL => return None,
        };
        let is_slide = matches!(body, Body::D2 | Body::D3);
        let is_zeta = !is_slide && !is_passive;
        let pose = self.start.link(body).pose;
        let start = match (is_slide, is_zeta) {
            (true, _) => self.start.strokes[c].x,
            (_, true) => machine.start.zeta[c],
            _ => pose.R.m21.atan2(pose.R.m11),
        };
        // Over the range of the coordinate: the passive joint's angle, unwrapped, and its gear.
        let [mut angles, mut gears] = [[start, start], [f64::INFINITY, 0.0_f64]];
        for zeta in self.sweep(c) {
            let at = tree.configuration(&zeta);
            let R = at.link(body).pose.R;
            let turn = R.m21.atan2(R.m11) - start;
            let turn = turn.sin().atan2(turn.cos());
            angles = [angles[0].min(start + turn), angles[1].max(start + turn)];
            let prime = at.strokes.get(c).map_or(1.0, |stroke| stroke.prime);
            gears = [gears[0].min(prime), gears[1].max(prime)];
        }
        let drive = machine.ratings.in_order().get(c).copied();
        let (range, effort, rate) = match (drive, is_slide, is_zeta) {
            (Some(drive), true, _) => (
                machine.limits.strokes()[c],
                drive.force_max,
                drive.rod_speed_max,
            ),
            (Some(drive), _, true) => (
                range[c],
                drive.force_max * gears[0],
                drive.rod_speed_max / gears[1],
            ),
            (Some(drive), ..) => (angles, 0.0, drive.rod_speed_max / gears[0]),
            (None, ..) => (
                range[c],
                machine.limits.tau_wrist_max[c - 3],
                std::f64::consts::PI,
            ),
        };
        Some(Joint {
            name,
            is_slide,
            axis: body.axis().v + body.axis().w,
            origin: if is_slide { Vector3::zeros() } else { pose.r },
            offset,
            start,
            range,
            damping: if is_zeta {
                machine.joint_viscous[c]
            } else {
                0.0
            },
            effort,
            rate,
            is_passive,
        })
    }

    /// Start poses with one coordinate moved over its range.
    fn sweep(&self, coordinate: usize) -> impl Iterator<Item = [f64; DOF]> {
        let [min, max] = self.machine.limits.zeta()[coordinate];
        let mut zeta = self.machine.start.zeta;
        (0..=SAMPLES).map(move |k| {
            zeta[coordinate] = min + (max - min) * f64::from(k) / f64::from(SAMPLES);
            zeta
        })
    }

    /// What of the body is drawn, made up around the mechanism's points; the payload is a box.
    pub(super) fn bars(&self, body: Body) -> Vec<Bar> {
        let tree = self.plant.tree();
        let d = 0.1 * tree.r_A2_B.norm();
        let x = |at: f64| Vector3::new(at, 0.0, 0.0);
        let flat = |p: Vector2<f64>| p.push(0.0);
        let (o, O) = (Vector3::zeros(), tree.r_T1_O);
        let bars = match body {
            Body::T1 => {
                let foot = O + flat(tree.lift.foot);
                let at = |y: f64| Vector3::new(0.0, y, 0.0);
                vec![
                    (o, at(O.y), 0.8 * d),
                    (at(O.y), O, 0.5 * d),
                    (at(foot.y), foot, 0.3 * d),
                ]
            }
            Body::A2 => {
                let e = tree.r_A2_B.normalize();
                let bracket = |p: Vector3<f64>| (e * e.dot(&p), p, 0.2 * d);
                let mut bars = vec![(o, tree.r_A2_B, 0.4 * d)];
                bars.extend([x(tree.lift.L1), tree.r_A2_A, tree.r_A2_E].map(bracket));
                bars
            }
            Body::A3 => {
                let C = flat(tree.tilt.C);
                vec![(o, tree.r_A3_A4, 0.35 * d), (x(C.x), C, 0.2 * d)]
            }
            Body::C2 => vec![(o, x(0.93 * tree.lift.x0), 0.3 * d)],
            Body::D2 => vec![(x(tree.lift.lc - tree.lift.x0), x(tree.lift.lc), 0.17 * d)],
            Body::C3 => vec![(o, x(0.93 * tree.tilt.x0), 0.26 * d)],
            Body::D3 => vec![(x(tree.tilt.lc - tree.tilt.x0), x(tree.tilt.lc), 0.15 * d)],
            Body::RK => vec![(o, x(tree.tilt.d4), 0.15 * d)],
            Body::CP => vec![(o, x(tree.tilt.d5), 0.15 * d)],
            Body::A4 => vec![(o, tree.r_A4_C4, 0.42 * d)],
            Body::C4 => vec![(o, tree.r_C4_D4, 0.38 * d)],
            Body::D4 => vec![(o, tree.r_D4_T4, 0.3 * d)],
            Body::PL => vec![],
        };
        let long = |(from, to, _): &(Vector3<f64>, Vector3<f64>, f64)| (to - from).norm() > 1e-6;
        let bars = bars.into_iter().filter(long);
        (bars.map(|(from, to, radius)| Bar { from, to, radius })).collect()
    }
}

/// Red, green, blue and opacity of a body.
pub(super) fn colour(body: Body) -> [f64; 4] {
    match body {
        Body::A2 => [0.89, 0.64, 0.23, 1.0],
        Body::A3 => [0.85, 0.55, 0.17, 1.0],
        Body::C2 | Body::C3 => [0.18, 0.43, 0.7, 1.0],
        Body::D2 | Body::D3 => [0.79, 0.81, 0.83, 1.0],
        Body::D4 => [0.69, 0.23, 0.18, 1.0],
        Body::PL => [0.45, 0.45, 0.45, 0.5],
        _ => [0.36, 0.4, 0.44, 1.0],
    }
}

/// Edges, m, of the box of uniform density with the body's mass and moments of inertia about its
/// axes: `a_x² = 6 (I_yy + I_zz − I_xx)/m`.
pub fn equivalent_box(body: &machine_file::Body) -> [f64; 3] {
    let i = &body.inertia_com;
    let edge = |own: f64, others: f64| (6.0 * (others - own) / body.mass).sqrt();
    [
        edge(i.xx, i.yy + i.zz),
        edge(i.yy, i.zz + i.xx),
        edge(i.zz, i.xx + i.yy),
    ]
}
