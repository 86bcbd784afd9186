//! Where the energy of each actuator goes over a run: electrical energy, losses by kind, mechanical work, regeneration, efficiency.

use std::fmt::Write as _;

use anyhow::{Result, ensure};
use cosim::run::Experiment;
use cosim::system::System;
use cosim::wiring::Port;
use serde::Serialize;

use crate::experiment::Recorded;

/// Outputs of an actuator that are recorded; a component that has the first is one.
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
#[derive(Clone, Debug, Serialize)]
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
    /// Lost in the windings.
    pub copper: f64,
    /// Lost in the iron.
    pub core: f64,
    /// Lost in the inverter.
    pub inverter: f64,
    /// Lost in friction, and to the residual of the network.
    pub mechanical: f64,
    /// All losses, as the actuator integrates them.
    pub lost: f64,
    /// Rise of the stored energy.
    pub stored: f64,
}

impl Balance {
    /// Energy that left through a border over energy that came in through one.
    pub fn efficiency(&self) -> f64 {
        let came = self.electrical + self.returned;
        if came > 0.0 {
            (self.work + self.regenerated) / came
        } else {
            0.0
        }
    }

    /// What the actuator's own integrals leave open: in − out − lost − stored.
    pub fn residual(&self) -> f64 {
        self.electrical - self.regenerated - self.work + self.returned - self.lost - self.stored
    }

    /// Balance of several actuators on one DC side: what one gives back another can use, so far as it is stored meanwhile.
    fn sum(balances: &[Self]) -> Self {
        let total = |get: fn(&Self) -> f64| balances.iter().map(get).sum();
        Self {
            actuator: "all".into(),
            electrical: total(|b| b.electrical),
            regenerated: total(|b| b.regenerated),
            work: total(|b| b.work),
            returned: total(|b| b.returned),
            copper: total(|b| b.copper),
            core: total(|b| b.core),
            inverter: total(|b| b.inverter),
            mechanical: total(|b| b.mechanical),
            lost: total(|b| b.lost),
            stored: total(|b| b.stored),
        }
    }
}

/// Run the experiment; the balances of all actuators over the motion, and their sum.
pub fn run(system: &System, experiment: &Experiment) -> Result<Vec<Balance>> {
    let is_actuator = |k: &usize| system.port_of(*k, OUTPUTS[0]).is_ok();
    let actuators: Vec<usize> = (0..system.fmus.len()).filter(is_actuator).collect();
    ensure!(
        !actuators.is_empty(),
        "no component has an output `{}`",
        OUTPUTS[0]
    );
    let mut ports = Vec::new();
    for k in &actuators {
        for output in OUTPUTS {
            ports.push(system.port_of(*k, output)?);
        }
    }
    let recorded = Recorded::of(system, experiment, &ports)?;
    let mut balances = Vec::new();
    for (outputs, k) in ports.chunks(OUTPUTS.len()).zip(actuators) {
        let name = &system.structure.components[k].name;
        balances.push(balance(&recorded, name, outputs)?);
    }
    balances.push(Balance::sum(&balances));
    Ok(balances)
}

/// Balance of one actuator, of its [`OUTPUTS`].
fn balance(recorded: &Recorded, actuator: &str, outputs: &[Port]) -> Result<Balance> {
    let columns: Vec<&[f64]> = outputs
        .iter()
        .map(|port| recorded.motion(*port))
        .collect::<Result<_>>()?;
    let times = &recorded.recording.times[recorded.motion_start()..];
    let loss = |k: usize| integral(times, columns[k]);
    let (electrical, regenerated) = both_ways(columns[0]);
    let (work, returned) = both_ways(columns[1]);
    let rise = |c: &[f64]| c[c.len() - 1] - c[0];
    Ok(Balance {
        actuator: actuator.into(),
        electrical,
        regenerated,
        work,
        returned,
        copper: loss(4),
        core: loss(5),
        inverter: loss(6),
        mechanical: loss(7),
        lost: rise(columns[2]),
        stored: rise(columns[3]),
    })
}

/// Sums of the rises and of the falls of an integrated power.
fn both_ways(energy: &[f64]) -> (f64, f64) {
    let mut ways = (0.0, 0.0);
    for pair in energy.windows(2) {
        let rise = pair[1] - pair[0];
        if rise > 0.0 {
            ways.0 += rise;
        } else {
            ways.1 -= rise;
        }
    }
    ways
}

/// Trapezoidal rule.
fn integral(times: &[f64], power: &[f64]) -> f64 {
    let steps = times.windows(2).zip(power.windows(2));
    steps
        .map(|(t, p)| 0.5 * (t[1] - t[0]) * (p[0] + p[1]))
        .sum()
}

/// The balances as a table for people.
pub fn text(title: &str, balances: &[Balance]) -> String {
    let mut text = format!("{title}\n{:<34}", "energy over the motion, J");
    for b in balances {
        write!(text, "{:>12}", b.actuator).expect("a String takes every text");
    }
    text += "\n";
    type Row = (&'static str, fn(&Balance) -> f64);
    let rows: [Row; 11] = [
        ("electrical, taken", |b| b.electrical),
        ("electrical, given back", |b| b.regenerated),
        ("work on the load", |b| b.work),
        ("work by the load", |b| b.returned),
        ("loss, copper", |b| b.copper),
        ("loss, iron", |b| b.core),
        ("loss, inverter", |b| b.inverter),
        ("loss, mechanical", |b| b.mechanical),
        ("rise of stored energy", |b| b.stored),
        ("balance left open", Balance::residual),
        ("efficiency (out / in), %", |b| 100.0 * b.efficiency()),
    ];
    for (name, get) in rows {
        write!(text, "{name:<34}").expect("a String takes every text");
        for b in balances {
            write!(text, "{:>12.2}", get(b)).expect("a String takes every text");
        }
        text += "\n";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rises_and_falls_are_kept_apart() {
        assert_eq!(both_ways(&[1.0, 4.0, 2.0, 2.0, 7.0]), (8.0, 2.0));
        assert_eq!(integral(&[0.0, 1.0, 3.0], &[2.0, 4.0, 6.0]), 13.0);
    }

    #[test]
    fn efficiency_counts_both_borders() {
        let b = Balance {
            actuator: "a".into(),
            electrical: 90.0,
            regenerated: 5.0,
            work: 55.0,
            returned: 10.0,
            copper: 0.0,
            core: 0.0,
            inverter: 0.0,
            mechanical: 0.0,
            lost: 38.0,
            stored: 2.0,
        };
        assert_eq!(b.efficiency(), 0.6);
        assert_eq!(b.residual(), 0.0);
        let two = Balance::sum(&[b.clone(), b]);
        assert_eq!((two.electrical, two.efficiency()), (180.0, 0.6));
    }
}
