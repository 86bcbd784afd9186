//! The 13 bodies, their tree and joint axes, for this model, the controller and the studies.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use spatial::Twist;

/// A body of the machine, parents before children. `as usize` is its index everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Body {
    /// Base column.
    T1,
    /// Lift boom.
    A2,
    /// Lift cylinder.
    C2,
    /// Lift rod.
    D2,
    /// Tilt boom.
    A3,
    /// Tilt cylinder.
    C3,
    /// Tilt rod.
    D3,
    /// Rocker A–D of the four-bar.
    RK,
    /// Coupler C–D of the four-bar.
    CP,
    /// First wrist body.
    A4,
    /// Second wrist body.
    C4,
    /// Third wrist body, carries the tip.
    D4,
    /// Payload, rigid in D4.
    PL,
}

/// All bodies in index order.
pub const BODIES: [Body; 13] = [
    Body::T1,
    Body::A2,
    Body::C2,
    Body::D2,
    Body::A3,
    Body::C3,
    Body::D3,
    Body::RK,
    Body::CP,
    Body::A4,
    Body::C4,
    Body::D4,
    Body::PL,
];

impl Body {
    /// Number of bodies.
    pub const COUNT: usize = BODIES.len();

    /// The body this one is jointed to; `None`: to the ground.
    #[must_use]
    pub const fn parent(self) -> Option<Body> {
        match self {
            Body::T1 => None,
            Body::A2 | Body::C2 => Some(Body::T1),
            Body::D2 => Some(Body::C2),
            Body::A3 | Body::C3 | Body::RK => Some(Body::A2),
            Body::D3 => Some(Body::C3),
            Body::CP | Body::A4 => Some(Body::A3),
            Body::C4 => Some(Body::A4),
            Body::D4 => Some(Body::C4),
            Body::PL => Some(Body::D4),
        }
    }

    /// Index c(k) of the `zeta` that drives the body's joint (0 = slew … 5 = last wrist joint).
    /// The payload has no joint: its gear is zero.
    #[must_use]
    pub const fn coordinate(self) -> usize {
        match self {
            Body::T1 => 0,
            Body::A2 | Body::C2 | Body::D2 => 1,
            Body::A3 | Body::C3 | Body::D3 | Body::RK | Body::CP => 2,
            Body::A4 => 3,
            Body::C4 => 4,
            Body::D4 | Body::PL => 5,
        }
    }

    /// Unit twist s_k of the body's joint, the same in parent's and body's axes: `y_tau` for the
    /// slew, `x_f` for the rods, `x_tau` or `z_tau` for the rest (`[paper] Eq. (Eq:Zeta)`).
    #[must_use]
    pub fn axis(self) -> Twist {
        let o = Vector3::zeros();
        match self {
            Body::T1 => Twist::new(o, Vector3::y()),
            Body::D2 | Body::D3 => Twist::new(Vector3::x(), o),
            Body::A4 | Body::D4 | Body::PL => Twist::new(o, Vector3::x()),
            _ => Twist::new(o, Vector3::z()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parents_come_before_children_and_names_match_the_machine_file() {
        for (k, body) in BODIES.into_iter().enumerate() {
            assert_eq!(body as usize, k);
            assert!(body.parent().is_none_or(|p| (p as usize) < k));
            assert_eq!(format!("{body:?}"), machine_file::Bodies::NAMES[k]);
        }
    }
}
