//! A machine seen from the side: the places of its named points in a pose, for its sheet.
#![allow(non_snake_case)] // names of points

use hdrm::{Body, DOF, Tree};
use nalgebra::Vector3;

/// A point of the boom plane.
pub struct NamedPoint {
    /// As in the machine file and the equations.
    pub name: &'static str,
    pub meaning: &'static str,
    /// Distance ahead of the slew axis and height, m.
    pub place: [f64; 2],
}

pub struct SideView {
    pub points: Vec<NamedPoint>,
    /// Where the rods leave their cylinders: of the lift and of the tilt actuator.
    pub rods: [[f64; 2]; 2],
}

impl SideView {
    /// The points of the pose `zeta`, rad, with the slew angle set to 0.
    pub fn new(tree: &Tree, zeta: &[f64; DOF]) -> Self {
        let zeta = [0.0, zeta[1], zeta[2], zeta[3], zeta[4], zeta[5]];
        let poses = tree.configuration(&zeta).world_poses();
        let at = |body: Body, r: Vector3<f64>| {
            let pose = poses[body as usize];
            let place = pose.r + pose.R * r;
            [place.x, place.y]
        };
        let along = |x: f64| Vector3::new(x, 0.0, 0.0);
        let origin = Vector3::zeros();
        let named = |name, meaning, place| NamedPoint {
            name,
            meaning,
            place,
        };
        Self {
            points: vec![
                named("T1", "base, origin of the world", [0.0, 0.0]),
                named("O", "lift joint", at(Body::A2, origin)),
                named("F", "foot of the lift actuator", at(Body::C2, origin)),
                named("P", "its rod's pin", at(Body::A2, along(tree.lift.L1))),
                named("B", "tilt joint", at(Body::A3, origin)),
                named("A", "pivot of the rocker AD", at(Body::RK, origin)),
                named("C", "pivot of the coupler CD", at(Body::CP, origin)),
                named(
                    "D",
                    "pin of the tilt actuator's rod",
                    at(Body::RK, along(tree.tilt.d4)),
                ),
                named("E", "foot of the tilt actuator", at(Body::C3, origin)),
                named("A4", "first wrist joint", at(Body::A4, origin)),
                named("C4", "second wrist joint", at(Body::C4, origin)),
                named("D4", "third wrist joint", at(Body::D4, origin)),
                named("T4", "tip", at(Body::D4, tree.r_D4_T4)),
            ],
            rods: [at(Body::D2, origin), at(Body::D3, origin)],
        }
    }

    /// Place of the point of this name, which must exist.
    pub fn at(&self, name: &str) -> [f64; 2] {
        let point = self.points.iter().find(|point| point.name == name);
        point.expect("a named point").place
    }
}
