//! Energy balances of a run, for `hdrm-fmu energy`, sizing, the report and Python: for each
//! actuator electrical energy, losses by kind, mechanical work, regeneration and efficiency; for a
//! component that feeds the drives, what it gave and where that went ([`super::supply`]).

use anyhow::{Result, ensure};
use cosim::{Experiment, Port, System, Verdict};
use serde::Serialize;

use super::power_integral::{SHIFT, integral, rise, rise_while_working, rises_and_falls};
use super::run::RecordedRun;
use super::supply::{self, Supply};
use crate::runs::grid::TRAJECTORIES;
use crate::setup::start_values::vary;

/// Outputs of an actuator that are recorded; a component that has them all is an actuator.
const OUTPUTS: [&str; 8] = [
    "energy.in",
    "energy.out",
    "energy.loss",
    "energy.stored",
    "loss.copper",
    "loss.core",
    "loss.inverter",
    "loss.mechanical",
];

/// Energies of one actuator over the motion, J.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Balance {
    /// Component.
    pub actuator: String,
    /// Taken from the DC side.
    pub electrical: f64,
    /// Given back to the DC side.
    pub regenerated: f64,
    /// Work done on the load.
    pub work: f64,
    /// Work that the load did on the actuator.
    pub returned: f64,
    /// Energy that the coupling at the rod creates or loses: work on the load where the exchange
    /// sets the rod to another position than its velocity had taken it to.
    pub shift: f64,
    /// Lost in the windings.
    pub copper: f64,
    /// Lost in the iron.
    pub core: f64,
    /// Lost in the inverter.
    pub inverter: f64,
    /// Lost in friction and to the residual of the network.
    pub mechanical: f64,
    /// All losses, as the actuator integrates them.
    pub lost: f64,
    /// Rise of the stored energy.
    pub stored: f64,
    /// Electrical energy taken minus given back while work is done on the load.
    pub working: f64,
}

impl Balance {
    /// Work on the load divided by the electrical energy taken meanwhile. `None` if no work is
    /// done, or more than was taken: it then came from stored energy, as when a brake is released.
    pub fn efficiency(&self) -> Option<f64> {
        (self.work > 0.0 && self.work <= self.working).then(|| self.work / self.working)
    }

    /// Energy that left the actuator divided by energy that entered it. It is no efficiency: a load
    /// that is raised and lowered again counts twice.
    pub fn throughput(&self) -> f64 {
        match self.electrical + self.returned {
            entered if entered > 0.0 => (self.work + self.regenerated) / entered,
            _ => 0.0,
        }
    }

    /// Error of the balance of the actuator's own integrals: in − out − shift − lost − stored.
    pub fn residual(&self) -> f64 {
        let taken = self.electrical - self.regenerated;
        taken - self.work + self.returned - self.shift - self.lost - self.stored
    }

    /// Balance of all actuators on one DC side.
    fn sum(balances: &[Self]) -> Self {
        let total = |get: fn(&Self) -> f64| balances.iter().map(get).sum();
        Self {
            actuator: "all".into(),
            electrical: total(|b| b.electrical),
            regenerated: total(|b| b.regenerated),
            work: total(|b| b.work),
            returned: total(|b| b.returned),
            shift: total(|b| b.shift),
            copper: total(|b| b.copper),
            core: total(|b| b.core),
            inverter: total(|b| b.inverter),
            mechanical: total(|b| b.mechanical),
            lost: total(|b| b.lost),
            stored: total(|b| b.stored),
            working: total(|b| b.working),
        }
    }
}

/// The energy balances of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Energies {
    /// Balances of the actuators over the motion, and their sum.
    pub balances: Vec<Balance>,
    /// The component that feeds the drives, over the whole run, if there is one.
    pub supply: Option<Supply>,
    /// Verdict on the run.
    #[serde(skip)]
    pub verdict: Verdict,
}

/// Names and experiments of the cases that an analysis runs: both trajectories, or the one that
/// `base` or the system sets.
pub fn trajectory_cases(system: &System, base: &Experiment) -> Result<Vec<(String, Experiment)>> {
    let port = system.port("trajectory")?;
    let component = &system.structure.components[port.component];
    let bound = (component.parameters.iter()).any(|p| p.name == system.variable(port).name);
    if bound || base.settings.iter().any(|s| s.port == port) {
        return Ok(vec![("as set".into(), base.clone())]);
    }
    let one = |trajectory: &str| {
        let experiment = vary(system, base, &[("trajectory", &trajectory)])?;
        Ok((trajectory.to_string(), experiment))
    };
    TRAJECTORIES.into_iter().map(one).collect()
}

/// Indices of the components that are actuators.
pub fn actuators(system: &System) -> Vec<usize> {
    let is_actuator = |k: &usize| OUTPUTS.iter().all(|name| system.port_of(*k, name).is_ok());
    (0..system.fmus.len()).filter(is_actuator).collect()
}

/// Runs the experiment and evaluates its energies.
pub fn run(system: &System, experiment: &Experiment) -> Result<Energies> {
    let recorded = RecordedRun::record(system, experiment, &ports(system)?)?;
    evaluate(system, &recorded)
}

/// The variables that must be recorded at every communication point. Fails without an actuator.
pub fn ports(system: &System) -> Result<Vec<Port>> {
    let mut ports = actuator_ports(system)?;
    let shift = |k| system.port_of(k, SHIFT).ok();
    ports.extend(actuators(system).into_iter().filter_map(shift));
    ports.extend(supply::ports(system)?);
    Ok(ports)
}

/// The [`OUTPUTS`] of all actuators.
fn actuator_ports(system: &System) -> Result<Vec<Port>> {
    let (actuators, name) = (actuators(system), OUTPUTS[0]);
    ensure!(!actuators.is_empty(), "no component has an output `{name}`");
    let outputs = |k| OUTPUTS.map(|name| system.port_of(k, name));
    actuators.into_iter().flat_map(outputs).collect()
}

/// The energies of a run in which [`ports`] were recorded.
pub fn evaluate(system: &System, recorded: &RecordedRun) -> Result<Energies> {
    let ports = actuator_ports(system)?;
    let balances = ports.chunks(OUTPUTS.len());
    let balances = balances.map(|outputs| balance(system, recorded, outputs));
    let mut balances = balances.collect::<Result<Vec<_>>>()?;
    balances.push(Balance::sum(&balances));
    let supply = Supply::from_run(system, recorded, &ports, OUTPUTS.len())?;
    Ok(Energies {
        balances,
        supply,
        verdict: recorded.outcome.verdict(),
    })
}

/// Balance of the actuator with these [`OUTPUTS`].
fn balance(system: &System, recorded: &RecordedRun, outputs: &[Port]) -> Result<Balance> {
    let columns = outputs.iter().map(|port| recorded.motion(*port));
    let columns = columns.collect::<Result<Vec<_>>>()?;
    let times = &recorded.recording.times[recorded.motion_start()..];
    let loss = |k: usize| integral(times, columns[k]);
    let shift = match system.port_of(outputs[0].component, SHIFT) {
        Ok(port) => rise(recorded.motion(port)?),
        Err(_) => 0.0,
    };
    let (electrical, regenerated) = rises_and_falls(columns[0]);
    let (work, returned) = rises_and_falls(columns[1]);
    Ok(Balance {
        actuator: system.component_of(outputs[0]).into(),
        electrical,
        regenerated,
        work,
        returned,
        shift,
        copper: loss(4),
        core: loss(5),
        inverter: loss(6),
        mechanical: loss(7),
        lost: rise(columns[2]),
        stored: rise(columns[3]),
        working: rise_while_working(columns[0], columns[1]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn throughput_counts_both_borders_and_efficiency_work_alone() {
        let b = Balance {
            actuator: "a".into(),
            electrical: 90.0,
            regenerated: 5.0,
            work: 55.0,
            returned: 10.0,
            shift: 1.0,
            copper: 0.0,
            core: 0.0,
            inverter: 0.0,
            mechanical: 0.0,
            lost: 37.0,
            stored: 2.0,
            working: 88.0,
        };
        assert_eq!((b.throughput(), b.efficiency()), (0.6, Some(0.625)));
        let idle = Balance {
            work: 0.0,
            ..b.clone()
        };
        assert_eq!(idle.efficiency(), None);
        assert_eq!(b.residual(), 0.0);
        let two = Balance::sum(&[b.clone(), b]);
        assert_eq!((two.electrical, two.throughput()), (180.0, 0.6));
    }
}
