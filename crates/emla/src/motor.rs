//! Permanent-magnet synchronous motor in rotor coordinates.

use serde::{Deserialize, Serialize};

/// A pair in rotor-flux coordinates, peak-valued.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Dq {
    /// Direct axis.
    pub d: f64,
    /// Quadrature axis.
    pub q: f64,
}

impl Dq {
    pub(crate) fn dot(self, other: Self) -> f64 {
        self.d * other.d + self.q * other.q
    }

    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self {
            d: factor * self.d,
            q: factor * self.q,
        }
    }
}

/// Flux linkages, Wb: `λ_d = L_d i_d + λ_m`, `λ_q = L_q i_q`. No saturation.
pub(crate) fn flux(p: &machine::Emla, i: Dq) -> Dq {
    Dq {
        d: p.L_d * i.d + p.lambda_m,
        q: p.L_q * i.q,
    }
}

/// Current derivative, A/s.
///
/// Source: `[paper]` Eq. (eq:dq_voltages), solved for the derivative (p pole pairs, `w_m` mechanical rad/s):
/// ```text
/// L_d di_d/dt = v_d − R_s i_d + p w_m λ_q
/// L_q di_q/dt = v_q − R_s i_q − p w_m λ_d
/// ```
pub(crate) fn di_dt(p: &machine::Emla, v: Dq, i: Dq, lambda: Dq, w_e: f64) -> Dq {
    Dq {
        d: 1.0 / p.L_d * (v.d - p.R_s * i.d + w_e * lambda.q),
        q: 1.0 / p.L_q * (v.q - p.R_s * i.q - w_e * lambda.d),
    }
}

/// The voltage that the inverter can give, V: scaled back onto the circle |v| = v_max.
pub(crate) fn limited(p: &machine::Emla, v: Dq) -> Dq {
    let square = v.dot(v);
    if square <= p.v_max * p.v_max {
        return v;
    }
    v.scaled(p.v_max / square.sqrt())
}

/// Derivative of [`limited`] at `v` along `dv`: outside the circle only the turn remains.
/// ```text
/// d(v·v_max/|v|) = (v_max/|v|)·(dv − v (v·dv)/|v|²)
/// ```
pub(crate) fn limited_tangent(p: &machine::Emla, v: Dq, dv: Dq) -> Dq {
    let square = v.dot(v);
    if square <= p.v_max * p.v_max {
        return dv;
    }
    let radial = v.dot(dv) / square;
    Dq {
        d: dv.d - v.d * radial,
        q: dv.q - v.q * radial,
    }
    .scaled(p.v_max / square.sqrt())
}
