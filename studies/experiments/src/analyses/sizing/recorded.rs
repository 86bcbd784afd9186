//! Recorded outputs of the actuators, values of their parameters: for the sizing and the report.

use anyhow::{Result, ensure};
use cosim::{Experiment, Port, System, start_value};
use serde::Serialize;

use crate::measures::energy;
use crate::measures::run::{Distance, RecordedRun};

/// Outputs of an actuator that are recorded: motor torque and speed, currents, rod force, losses,
/// electrical energy taken and work done.
const OUTPUTS: [&str; 9] = [
    "tau_e",
    "w_m",
    "i_d",
    "i_q",
    "F",
    "loss.copper",
    "loss.core",
    "energy.in",
    "energy.out",
];

/// Root mean square and greatest magnitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Size {
    /// Root mean square.
    pub rms: f64,
    /// Greatest magnitude.
    pub peak: f64,
}

impl Size {
    pub(super) fn new(values: impl Iterator<Item = f64>) -> Self {
        let mut size = Distance::default();
        values.for_each(|value| size.add(value.abs()));
        Self {
            rms: size.rms(),
            peak: size.max,
        }
    }
}

/// The recorded outputs of one actuator over the motion.
pub(super) struct Columns<'a> {
    pub times: &'a [f64],
    /// In the order of [`OUTPUTS`].
    pub values: [&'a [f64]; OUTPUTS.len()],
    /// Temperatures of the winding, K; empty where the actuator has none.
    pub winding: &'a [f64],
}

/// What must be recorded at every communication point. Fails if no component is an actuator, or one
/// lacks an output.
pub fn ports(system: &System) -> Result<Vec<Port>> {
    let actuators = energy::actuators(system);
    ensure!(!actuators.is_empty(), "no component is an actuator");
    let mut ports = Vec::new();
    for k in actuators {
        for name in OUTPUTS {
            ports.push(system.port_of(k, name)?);
        }
        ports.extend(system.port_of(k, "T_winding").ok());
    }
    ports.extend(system.port("v_dc_mean")); // of the supply, where there is one
    Ok(ports)
}

pub(super) fn columns<'a>(
    system: &System,
    recorded: &'a RecordedRun,
    k: usize,
) -> Result<Columns<'a>> {
    let motion = |name: &str| recorded.motion(system.port_of(k, name)?);
    let mut values = [&[][..]; OUTPUTS.len()];
    for (column, name) in values.iter_mut().zip(OUTPUTS) {
        *column = motion(name)?;
    }
    Ok(Columns {
        times: &recorded.recording.times[recorded.motion_start()..],
        values,
        winding: motion("T_winding").unwrap_or_default(),
    })
}

/// Values of variables of component `k` under the start values of `experiment`; None where it lacks
/// one of them.
pub(super) fn start_values<const N: usize>(
    system: &System,
    experiment: &Experiment,
    k: usize,
    names: [&str; N],
) -> Result<Option<[f64; N]>> {
    let mut values = [0.0; N];
    for (value, name) in values.iter_mut().zip(names) {
        let Ok(port) = system.port_of(k, name) else {
            return Ok(None);
        };
        *value = start_value(system, &experiment.settings, port)?;
    }
    Ok(Some(values))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_root_mean_square_and_peak() {
        let size = Size::new([3.0, -4.0, 0.0, 5.0].into_iter());
        assert_eq!((size.rms, size.peak), (12.5_f64.sqrt(), 5.0));
        assert_eq!(Size::new(std::iter::empty()), Size::default());
    }
}
