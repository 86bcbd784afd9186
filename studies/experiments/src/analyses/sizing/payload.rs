//! Sensitivity of power, force, energy and efficiency to the payload at the tip, for the sizing
//! `study`: the metrics of arXiv 2409.16186 and their partial derivatives by its mass, by
//! differences. Here they are taken over the motion (power and force as RMS), there at each time.

use anyhow::{Context, Result, ensure};
use cosim::{Experiment, System};
use serde::Serialize;

use super::recorded::{Columns, Size, columns, ports, start_values};
use crate::measures::energy;
use crate::measures::power_integral::{rise, rise_while_working, rises_and_falls};
use crate::measures::run::RecordedRun;
use crate::setup::start_values::add_settings;

/// The metrics of arXiv 2409.16186 for one actuator, over the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Metrics {
    /// Root mean square of the power delivered to the load, W.
    pub power: f64,
    /// Root mean square of the rod force, N.
    pub force: f64,
    /// Electrical energy, taken less given back, J.
    pub energy: f64,
    /// Work over electrical energy while work is done.
    pub efficiency: f64,
}

/// Sensitivity of the metrics of one actuator to the payload.
#[derive(Clone, Debug, Serialize)]
pub struct Sensitivity {
    /// Component.
    pub actuator: String,
    /// At the payload as it is.
    pub metrics: Metrics,
    /// Change per kilogram, by a central difference.
    pub per_kg: Metrics,
}

impl Metrics {
    fn new(columns: &Columns) -> Self {
        let [_, _, _, _, force, _, _, taken, work] = columns.values;
        let steps = columns.times.windows(2).zip(work.windows(2));
        let power = steps.map(|(t, e)| (e[1] - e[0]) / (t[1] - t[0]));
        let working = rise_while_working(taken, work);
        let (done, _) = rises_and_falls(work);
        Self {
            power: Size::new(power).rms,
            force: Size::new(force.iter().copied()).rms,
            energy: rise(taken),
            efficiency: if working > 0.0 { done / working } else { 0.0 },
        }
    }

    /// Applies `f` to each pair of numbers.
    fn with(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            power: f(self.power, other.power),
            force: f(self.force, other.force),
            energy: f(self.energy, other.energy),
            efficiency: f(self.efficiency, other.efficiency),
        }
    }
}

/// Partial derivatives of each actuator's metrics by the payload's mass, by central differences:
/// one run with `step` kg less and one with `step` kg more. The manipulator carries the other payload; the controller does not know it.
pub(super) fn sensitivity(
    system: &System,
    experiment: &Experiment,
    nominal: &RecordedRun,
    step: f64,
) -> Result<Vec<Sensitivity>> {
    let mass = system.port("payload.mass")?;
    let [payload] = start_values(system, experiment, mass.component, ["payload.mass"])?
        .context("the manipulator must have a payload")?;
    ensure!(
        step > 0.0 && step <= payload,
        "the step of the payload, {step} kg, must be above 0 and at most the payload itself, {payload} kg"
    );
    let ports = ports(system)?;
    let other = |mass: f64| {
        let setting = system.setting("payload.mass", mass)?;
        let experiment = add_settings(system, experiment, vec![setting])?;
        RecordedRun::record(system, &experiment, &ports)
    };
    let (less, more) = (other(payload - step)?, other(payload + step)?);
    let mut found = Vec::new();
    for k in energy::actuators(system) {
        let metrics = |recorded| anyhow::Ok(Metrics::new(&columns(system, recorded, k)?));
        found.push(Sensitivity {
            actuator: system.structure.components[k].name.clone(),
            metrics: metrics(nominal)?,
            per_kg: metrics(&more)?
                .with(metrics(&less)?, |more, less| (more - less) / (2.0 * step)),
        });
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metrics_are_of_power_force_energy_and_efficiency() {
        let (idle, force) = ([0.0; 3], [2.0, -2.0, 2.0]);
        let (taken, work) = ([0.0, 8.0, 6.0], [0.0, 4.0, 3.0]);
        let columns = Columns {
            times: &[0.0, 2.0, 4.0],
            values: [
                &idle, &idle, &idle, &idle, &force, &idle, &idle, &taken, &work,
            ],
            winding: &[],
        };
        let expected = Metrics {
            power: (0.5 * (4.0 + 0.25_f64)).sqrt(),
            force: 2.0,
            energy: 6.0,
            efficiency: 0.5,
        };
        assert_eq!(Metrics::new(&columns), expected);
    }
}
