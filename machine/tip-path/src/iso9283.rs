//! Built-in test paths of ISO 9283:1998, "Manipulating industrial robots – Performance criteria and
//! related test methods", for `reading` and the study that evaluates the tests.
//!
//! The cube has edges of 400 mm, one of the standard's sizes, along the world's axes; its centre is
//! where the tip starts. The test plane is the cube's diagonal plane through the upper near and the
//! lower far edge (both along z). P1 is the centre; P2 to P5 lie on the plane's diagonals, 10 % of
//! their length from the corners.
//!
//! - `iso9283-cube` tests poses: P1 → P5 → P4 → P3 → P2, 30 cycles, a second of rest at each.
//! - `iso9283-rectangle` tests straight lines: P2 → P3 → P4 → P5 → P2, 10 cycles.

use crate::error::{PathError, counted};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Edge of the cube, m.
const EDGE: f64 = 0.4;
/// Position of P2 to P5 on the plane's half diagonals.
const PART: f64 = 0.8;

/// What the test measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TestKind {
    /// Poses at rest: accuracy AP and repeatability RP.
    Poses,
    /// Straight lines: accuracy AT and repeatability RT.
    Lines,
}

/// A test path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Iso9283 {
    /// What the test measures.
    pub kind: TestKind,
    /// How often the same points are visited.
    pub cycles: usize,
}

impl Iso9283 {
    /// The test with a name like `iso9283-cube` or `iso9283-cube:3` (3 cycles).
    pub(crate) fn named(name: &str) -> Option<Result<Self, PathError>> {
        let (base, cycles) = match name.split_once(':') {
            Some((base, cycles)) => (base, Some(cycles)),
            None => (name, None),
        };
        let (kind, standard) = match base {
            "iso9283-cube" => (TestKind::Poses, 30),
            "iso9283-rectangle" => (TestKind::Lines, 10),
            _ => return None,
        };
        let read = |text: &str| counted(base, "cycles", text.parse().unwrap_or(f64::NAN), text);
        let cycles = cycles.map_or(Ok(standard), read);
        Some(cycles.map(|cycles| Self { kind, cycles }))
    }

    /// The points of a cycle in their order, relative to the start, m.
    pub fn points(&self) -> Vec<Vector3<f64>> {
        let along = Vector3::new(1.0, -1.0, 0.0) * (0.5 * PART * EDGE);
        let across = Vector3::z() * (0.5 * PART * EDGE);
        let [p2, p3] = [along + across, across - along];
        let [p4, p5] = [-along - across, along - across];
        match self.kind {
            TestKind::Poses => vec![Vector3::zeros(), p5, p4, p3, p2],
            TestKind::Lines => vec![p2, p3, p4, p5],
        }
    }
}
