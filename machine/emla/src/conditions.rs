//! What the equations of an instant take as given: parameters at the present temperature, DC-link
//! voltage, gates, brake, and the network's force; `step`, `continuous` and `tangent` pass it on.

use machine_file::{BrakeState, Drive};

/// Parameters and conditions that do not change during a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions<'a> {
    /// Parameters, with resistance and flux at the present temperatures.
    pub p: &'a machine_file::Emla,
    pub drive: Drive,
    /// Voltage of the DC link, V.
    pub v_dc: f64,
    /// Largest phase voltage (peak) at that voltage, V.
    pub largest: f64,
    /// Residual force of the network, `α·dF`, N.
    pub residual: f64,
    /// Whether the inverter's gates are on; while they are off no current flows
    /// ([`Emla::update_gates`]).
    pub gates: bool,
    pub brake: BrakeState,
}

impl Conditions<'_> {
    /// Whether the gates are on and the brake is released.
    #[inline(always)]
    pub(crate) fn is_plain(&self) -> bool {
        self.gates && self.brake == BrakeState::Released
    }
}
