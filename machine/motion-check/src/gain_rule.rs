//! Computes controller gains for a machine: with actuators as built, which are compliant, sampled
//! and delayed ([`gains`]), and with those that the controller knows ([`ideal_gains`]). Used by
//! `hdrm-fmu machine gains`, the setup of experiments and the Python package.
//!
//! Each gain is a fixed ratio of the quantity that bounds it. The ratios are those with which the
//! reference machine is stable in every plant of the tests; `docs/machine/machines.md` has the
//! reasoning.

mod as_built;
mod bounds;
mod error;
mod feedback;
mod ideal;
mod ruled_gain;

pub use as_built::{gains, gamma};
pub use bounds::{Bounds, bounds};
pub use error::GainError;
pub use feedback::least_damped;
pub use ideal::{ideal_gains, said};
pub use ruled_gain::{IDEAL, RuledGain, gain, take};

use as_built::gains_beside;
use ideal::ideal_gains_beside;
use machine_file::Machine;

/// The actuators that a controller's gains are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Actuators {
    /// Those that it knows: the ideal world.
    Known,
    /// As built, with current loops of their own: the real world.
    AsBuilt,
    /// As built, on the controller's voltages.
    AsBuiltOnVoltages,
}

/// The gains of a machine with these actuators, for a user who gives `own` values to some: they fit
/// those. On voltages those of the voltage law are the ideal world's.
pub fn gains_for(
    machine: &Machine,
    actuators: Actuators,
    own: &[(&'static str, f64)],
) -> Result<Vec<RuledGain>, GainError> {
    let ideal = || ideal_gains_beside(machine, own);
    let as_built = || gains_beside(machine, own);
    match actuators {
        Actuators::Known => ideal(),
        Actuators::AsBuilt => as_built(),
        Actuators::AsBuiltOnVoltages => {
            let slow = ["Lambda_position", "omega_tip", "gamma"];
            let voltage = ideal()?.into_iter();
            let voltage = voltage.filter(|gain| gain.name.starts_with("K_"));
            let slow = as_built()?
                .into_iter()
                .filter(|gain| slow.contains(&gain.name));
            Ok(voltage.chain(slow).collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use machine_file::{Emla, Machine};

    pub(super) fn value(gains: &[RuledGain], name: &str) -> f64 {
        let found = gains.iter().find(|gain| gain.name == name);
        found.expect("a gain").value
    }

    /// The reference machine with other gears and screws.
    pub(super) fn geared(N: f64, rho: f64) -> Machine {
        let mut machine = Machine::reference();
        let emla = Emla {
            N_gear: N,
            rho,
            ..machine.emla.lift
        };
        machine.emla = machine_file::PerAxis::all(emla);
        machine
    }

    /// A motor a hundred times as heavy leaves no feedback, and none of 0 is given.
    #[test]
    fn a_machine_without_feedback_is_refused_with_the_mode() {
        let machine = geared(80.0, 0.008);
        for refused in [ideal_gains(&machine), gains(&machine)] {
            let text = refused.expect_err("no gains").to_string();
            assert!(
                text.contains("no `controller.Lambda_position`") && text.contains(" Hz"),
                "{text}"
            );
        }
        // Where the user's own gain may be why, gears are not blamed.
        let refused = ideal_gains_beside(&machine, &[("K_v", 1e-3)]).expect_err("no gains");
        let text = refused.to_string();
        assert!(
            text.contains("your own `K_v`") && !text.contains("gears"),
            "{text}"
        );
        // The user's gain counts, in the file or given otherwise, although it is the reference
        // machine's, and others fit it.
        let own = [("Lambda_position", 20.0)];
        let ideal = ideal_gains_beside(&machine, &own).expect("gains");
        assert_eq!(value(&ideal, "omega_tip"), 5.0);
        let real = gains_beside(&machine, &own).expect("gains");
        assert_eq!(value(&real, "omega_tip"), 10.0);
        let mut filed = machine;
        filed.controller.Lambda_position = 3.0;
        assert!(ideal_gains(&filed).is_ok() && gains(&filed).is_ok());
    }
}
