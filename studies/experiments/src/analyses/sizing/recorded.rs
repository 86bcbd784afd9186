//! What is recorded of the actuators, and what their parameters are.

use anyhow::{Result, ensure};
use cosim::instance::At;
use cosim::{Experiment, Port, System, instantiate};
use serde::Serialize;

use crate::measures::energy;
use crate::measures::run::{Distance, RecordedRun};

/// Outputs of an actuator that are recorded.
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
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Self {
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
    pub values: Vec<&'a [f64]>,
    pub winding: &'a [f64],
}

/// What must be recorded at every communication point.
///
/// # Errors
/// No component is an actuator, or one lacks an output.
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
    ports.extend(system.port("v_dc_mean")); // of what feeds them, if anything does
    Ok(ports)
}

pub(super) fn columns<'a>(
    system: &System,
    recorded: &'a RecordedRun,
    k: usize,
) -> Result<Columns<'a>> {
    let of = |name: &str| recorded.motion(system.port_of(k, name)?);
    Ok(Columns {
        times: &recorded.recording.times[recorded.motion_start()..],
        values: OUTPUTS.iter().map(|name| of(name)).collect::<Result<_>>()?,
        winding: of("T_winding").unwrap_or_default(),
    })
}

/// Values of parameters or inputs of a component under the start values of `experiment`; None where
/// it has not all of them.
pub(super) fn parameters_of<const N: usize>(
    system: &System,
    experiment: &Experiment,
    k: usize,
    names: [&str; N],
) -> Result<Option<[f64; N]>> {
    let ports: Vec<Port> = names
        .iter()
        .filter_map(|n| system.port_of(k, n).ok())
        .collect();
    if ports.len() < N {
        return Ok(None);
    }
    let instance = instantiate(system, k, &experiment.settings)?;
    instance.enter_initialization(experiment.stepping.start)?;
    let mut found = [0.0; N];
    for (value, port) in found.iter_mut().zip(ports) {
        *value = instance.number(port.variable, At::Initialization)?;
    }
    Ok(Some(found))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_root_mean_square_and_peak() {
        let size = Size::of([3.0, -4.0, 0.0, 5.0].into_iter());
        assert_eq!((size.rms, size.peak), (12.5_f64.sqrt(), 5.0));
        assert_eq!(Size::of(std::iter::empty()), Size::default());
    }
}
