//! The motor's equations in dq coordinates, for `maps`, `instant`, `dynamics` and `tangent`.

use machine_file::Dq;

/// Flux linkages, Wb: `λ_d = L_d i_d + λ_m`, `λ_q = L_q i_q`. No saturation.
pub(crate) fn flux(p: &machine_file::Emla, i: Dq) -> Dq {
    Dq {
        d: p.L_d * i.d + p.lambda_m,
        q: p.L_q * i.q,
    }
}

/// Current derivative, A/s.
///
/// Source: `[paper]` Eq. (eq:dq_voltages), solved for the derivative (p pole pairs, `w_m`
/// mechanical rad/s):
/// ```text
/// L_d di_d/dt = v_d − R_s i_d + p w_m λ_q
/// L_q di_q/dt = v_q − R_s i_q − p w_m λ_d
/// ```
pub(crate) fn di_dt(p: &machine_file::Emla, v: Dq, i: Dq, lambda: Dq, w_e: f64) -> Dq {
    Dq {
        d: 1.0 / p.L_d * (v.d - p.R_s * i.d + w_e * lambda.q),
        q: 1.0 / p.L_q * (v.q - p.R_s * i.q - w_e * lambda.d),
    }
}

/// Derivative of [`Dq::limited`] at `v` along `dv` and `d_largest`. Outside the circle only the
/// rotation of `v` and the change of the radius r count:
/// ```text
/// d(v·r/|v|) = (r/|v|)·(dv − v (v·dv)/|v|²) + (v/|v|)·dr
/// ```
pub(crate) fn limited_tangent(largest: f64, d_largest: f64, v: Dq, dv: Dq) -> Dq {
    let square = v.dot(v);
    if square <= largest * largest {
        return dv;
    }
    let (radial, size) = (v.dot(dv) / square, square.sqrt());
    let along = d_largest / size - largest / size * radial;
    Dq {
        d: largest / size * dv.d + along * v.d,
        q: largest / size * dv.q + along * v.q,
    }
}
