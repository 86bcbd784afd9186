//! The DC link as the drive finds it. Its voltage is held over a step, as the commanded voltages are.

use crate::Emla;
use crate::input::Input;

/// Voltage below which the link is taken for dead, V.
const LEAST: f64 = 1.0;

/// The DC link over a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    /// Its voltage, V.
    pub v_dc: f64,
    /// Largest phase voltage (peak) that can be made of it, V.
    pub largest: f64,
}

impl Emla {
    /// The DC link that the inputs give, or that of the parameters.
    pub(crate) fn link(&self, u: &Input) -> Link {
        let v_dc = u.v_dc.unwrap_or_else(|| self.p.link_voltage());
        let largest = self.p.largest_voltage(v_dc);
        Link { v_dc, largest }
    }
}

impl Link {
    /// Current that carries the power `P`, W, in A: `P/v_dc`; none from a dead link.
    pub(crate) fn current(self, P: f64) -> f64 {
        if self.v_dc >= LEAST {
            P / self.v_dc
        } else {
            0.0
        }
    }

    /// Derivative of [`Link::current`] when power and voltage change by `dP` and `dv_dc`.
    pub(crate) fn current_tangent(self, P: f64, dP: f64, dv_dc: f64) -> f64 {
        self.current(dP - self.current(P) * dv_dc)
    }
}
