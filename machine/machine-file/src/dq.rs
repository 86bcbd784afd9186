//! Voltages, currents and flux linkages as pairs in dq (rotor-flux) coordinates, with rotation and
//! amplitude limit, for both actuator models (`emla` and `rig`).

use serde::{Deserialize, Serialize};
use std::ops::{Add, Mul};

/// A pair in rotor-flux coordinates, peak-valued.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Dq {
    /// Direct axis.
    pub d: f64,
    /// Quadrature axis.
    pub q: f64,
}

impl Dq {
    /// `d·d' + q·q'`.
    #[inline]
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        self.d * other.d + self.q * other.q
    }

    /// The pair rotated by the angle with this sine and cosine.
    #[inline]
    #[must_use]
    pub fn turned(self, (sin, cos): (f64, f64)) -> Self {
        Self {
            d: self.d * cos - self.q * sin,
            q: self.d * sin + self.q * cos,
        }
    }

    /// The pair with its amplitude limited to `largest`, direction kept.
    #[inline]
    #[must_use]
    pub fn limited(self, largest: f64) -> Self {
        let square = self.dot(self);
        if square <= largest * largest {
            return self;
        }
        (largest / square.sqrt()) * self
    }
}

impl Add for Dq {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            d: self.d + other.d,
            q: self.q + other.q,
        }
    }
}

impl Mul<Dq> for f64 {
    type Output = Dq;

    #[inline]
    fn mul(self, pair: Dq) -> Dq {
        Dq {
            d: self * pair.d,
            q: self * pair.q,
        }
    }
}
