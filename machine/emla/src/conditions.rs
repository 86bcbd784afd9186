//! What stays as it is over a step: parameters at the present temperature, DC link, gates, brake.

use machine_file::{Drive, Holding};

/// Parameters and conditions that do not change during a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions<'a> {
    /// Parameters, resistance and flux as the temperatures make them.
    pub p: &'a machine_file::Emla,
    /// Who moves the rod.
    pub drive: Drive,
    /// Voltage of the DC link, V.
    pub v_dc: f64,
    /// Largest phase voltage (peak) that can be made of it, V.
    pub largest: f64,
    /// What the network adds to the force, `α·dF`, N.
    pub residual: f64,
    /// Whether the inverter's gates are on. While they are off no current flows: see
    /// [`Emla::update_gates`].
    pub gates: bool,
    /// What the brake does, N·m.
    pub brake: Holding,
}

impl Conditions<'_> {
    /// Whether the inverter works and the shaft is free.
    #[inline(always)]
    pub(crate) fn is_plain(&self) -> bool {
        self.gates && self.brake == Holding::Released
    }
}
