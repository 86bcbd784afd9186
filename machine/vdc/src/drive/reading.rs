//! The measurements of one drive from the controller's inputs, for voltage law and prediction.

use crate::signals::Input;

/// Measurements of one drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Reading {
    /// Direct-axis current, A.
    pub(crate) i_d: f64,
    /// Quadrature-axis current, A.
    pub(crate) i_q: f64,
    /// Motor speed, rad/s.
    pub(crate) w_m: f64,
    /// Force on the load, N.
    pub(crate) F: f64,
    /// Voltage of the DC link, V; None: that of the nominal machine.
    pub(crate) v_dc: Option<f64>,
    /// Temperature of the winding, K.
    pub(crate) T_winding: f64,
}

impl Reading {
    pub(crate) fn from_input(input: &Input, i: usize) -> Self {
        Self {
            i_d: input.i_d[i],
            i_q: input.i_q[i],
            w_m: input.w_m[i],
            F: input.F[i],
            v_dc: input.v_dc,
            T_winding: input.T_winding[i],
        }
    }
}
