//! The section `emla` with all optional fields, for parameters of FMUs and the check in `shape`.

use crate::{Brake, CoreLosses, Emla, Heat, InverterLosses, Temperature};
use serde::{Deserialize, Serialize};
use std::num::TryFromIntError;

/// The section `emla` in the form of FMU parameters: losses that the file leaves out are zero,
/// brake and heat are typical ones, and the pole pairs are signed like FMI integers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EmlaFields {
    /// The section; the other fields override its parts.
    pub emla: Emla,
    /// Pole pairs.
    pub pole_pairs: i32,
    /// Zero where the machine has none.
    pub core: CoreLosses,
    /// Zero where the machine has none.
    pub inverter: InverterLosses,
    /// Typical where the machine says nothing.
    pub brake: Brake,
    /// Typical where the machine says nothing.
    pub heat: Heat,
    /// Typical where the machine says nothing.
    pub temperature: Temperature,
}

const NO_CORE: CoreLosses = CoreLosses { k_h: 0.0, k_e: 0.0 };
const NO_INVERTER: InverterLosses = InverterLosses {
    v_dc: 0.0,
    f_sw: 0.0,
    k_sw: 0.0,
    v_0: 0.0,
    r_0: 0.0,
};

impl EmlaFields {
    /// From a section of a machine file.
    pub fn new(emla: Emla) -> Self {
        Self {
            pole_pairs: i32::try_from(emla.p).unwrap_or(i32::MAX),
            core: emla.core.unwrap_or(NO_CORE),
            inverter: emla.inverter.unwrap_or(NO_INVERTER),
            brake: emla.brake.unwrap_or(Brake::TYPICAL),
            heat: emla.heat.unwrap_or(Heat::TYPICAL),
            temperature: emla.temperature.unwrap_or(Temperature::TYPICAL),
            emla,
        }
    }

    /// Back to a section; an error if the pole pairs are negative.
    pub fn section(&self) -> Result<Emla, TryFromIntError> {
        Ok(Emla {
            p: u32::try_from(self.pole_pairs)?,
            core: Some(self.core),
            inverter: Some(self.inverter),
            brake: Some(self.brake),
            heat: Some(self.heat),
            temperature: Some(self.temperature),
            ..self.emla
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Machine;

    #[test]
    fn a_section_survives_its_fields() {
        let emla = Machine::reference().emla.lift;
        let section = EmlaFields::new(emla).section().expect("positive");
        let complete = Emla {
            core: Some(emla.core.unwrap_or(NO_CORE)),
            inverter: Some(emla.inverter.unwrap_or(NO_INVERTER)),
            brake: Some(emla.brake.unwrap_or(Brake::TYPICAL)),
            heat: Some(emla.heat.unwrap_or(Heat::TYPICAL)),
            temperature: Some(emla.temperature.unwrap_or(Temperature::TYPICAL)),
            ..emla
        };
        assert_eq!(section, complete);
        let mut fields = EmlaFields::new(emla);
        fields.pole_pairs = 7;
        fields.core.k_h = 0.5;
        let section = fields.section().expect("positive");
        assert_eq!((section.p, section.core.map(|c| c.k_h)), (7, Some(0.5)));
        fields.pole_pairs = -1;
        assert!(fields.section().is_err());
    }
}
