//! Energy balances as the page takes them.

use anyhow::Result;
use cosim::system::System;
use serde::Serialize;

use studies::measures::energy;
use studies::measures::run::RecordedRun;

/// Energy balances of one trajectory.
#[derive(Serialize)]
pub struct Energy {
    trajectory: &'static str,
    balances: Vec<Balance>,
}

#[derive(Serialize)]
struct Balance {
    #[serde(flatten)]
    energies: energy::Balance,
    efficiency: Option<f64>,
    throughput: f64,
}

impl Energy {
    /// Of a run of which [`energy::ports`] were recorded.
    pub fn of(system: &System, trajectory: &'static str, recorded: &RecordedRun) -> Result<Self> {
        let balance = |energies: energy::Balance| Balance {
            efficiency: energies.efficiency(),
            throughput: energies.throughput(),
            energies,
        };
        let balances = energy::evaluate(system, recorded)?.balances;
        Ok(Self {
            trajectory,
            balances: balances.into_iter().map(balance).collect(),
        })
    }
}
