//! Energy balance of the component that feeds the drives, at the far end of power bonds with
//! `power="drawn"`: our `DcLink` or another battery. For `hdrm-fmu energy` and the report.
//!
//! The energy that it gives comes from the bonds, so it needs no outputs for that. If it has
//! outputs `energy.battery`, `energy.brake`, `energy.loss` and `energy.stored` with the meaning of
//! those of `DcLink`, the balance goes back to its source.

use anyhow::Result;
use cosim::structure::Power;
use cosim::{Port, System, Verdict};
use fmi_description::{Causality, Kind};
use serde::Serialize;

use super::power_integral::{SHIFT, rise};
use super::run::RecordedRun;

/// Outputs of the feeding component with which the balance goes back to the source.
const ENERGIES: [&str; 4] = [
    "energy.battery",
    "energy.brake",
    "energy.loss",
    "energy.stored",
];
/// Signals of the feeding component that are shown if it has them.
pub const SHOWN: [&str; 5] = ["v_dc", "i_battery", "soc", "T_battery", "P_brake"];
/// Boolean outputs of any component that report a fault.
const FAULTS: [&str; 2] = ["tripped", "undervoltage"];
/// Share of the throughput that may be unaccounted for, and that the bonds may create or lose.
const OPEN: f64 = 1e-5;
const RESIDUAL: f64 = 1e-3;

/// The feeding component over a whole run, energies in J.
#[derive(Clone, Debug, Serialize)]
pub struct Supply {
    /// Component.
    pub component: String,
    /// Energy that went through the bonds in either direction.
    pub throughput: f64,
    /// Energy given to the drives minus what they gave back, at its side of the bonds.
    pub given: f64,
    /// Energy that the bonds lost (> 0) or created (< 0).
    pub residual: f64,
    /// Work of the drives on the load.
    pub work: f64,
    /// Energy that the coupling at the rods creates or loses, as in `Balance`.
    pub shift: f64,
    /// Lost in the drives.
    pub lost: f64,
    /// Rise of the energy stored in the drives.
    pub stored: f64,
    /// The energies back to its source, if it has such outputs.
    pub source: Option<Source>,
    /// The shown signals.
    pub ranges: Vec<Range>,
    /// Faults: signal and time at which it is first true, s.
    #[serde(rename = "trouble")]
    pub faults: Vec<(String, f64)>,
}

/// Energies between the source and the drives, J.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Source {
    /// From the source itself.
    pub battery: f64,
    /// Burnt in the brake resistor.
    pub brake: f64,
    /// Lost between source and drives.
    pub lost: f64,
    /// Rise of the energy stored between source and drives.
    pub stored: f64,
}

/// A signal's values over the run.
#[derive(Clone, Debug, Serialize)]
pub struct Range {
    /// Name of the output.
    pub name: &'static str,
    /// Unit in the model description.
    pub unit: String,
    /// Least value.
    pub least: f64,
    /// Greatest value.
    pub greatest: f64,
    /// Value at the end.
    pub last: f64,
}

/// Index of the component that feeds the drives, if there is one.
pub fn component(system: &System) -> Result<Option<usize>> {
    Ok(feeding(system)?.map(|(k, _)| k))
}

/// The component at the end of the drawing bonds, and the names of their efforts.
fn feeding(system: &System) -> Result<Option<(usize, Vec<String>)>> {
    let wiring = system.wiring()?;
    let mut found: Option<(usize, Vec<String>)> = None;
    for link in &wiring.links {
        if link.bond.is_some_and(|b| b.power == Power::Drawn) {
            let (component, names) = found.get_or_insert((link.to.component, Vec::new()));
            if *component == link.to.component {
                names.push(wiring.name(link.from));
            }
        }
    }
    Ok(found)
}

/// The variables that [`Supply::from_run`] needs besides the actuators' energies.
pub fn ports(system: &System) -> Result<Vec<Port>> {
    let mut ports = fault_ports(system);
    if let Some((k, _)) = feeding(system)? {
        let names = ENERGIES.iter().chain(&SHOWN);
        ports.extend(names.filter_map(|name| system.port_of(k, name).ok()));
    }
    Ok(ports)
}

fn fault_ports(system: &System) -> Vec<Port> {
    let components = 0..system.fmus.len();
    let named = components.flat_map(|k| FAULTS.map(|name| system.port_of(k, name)));
    let is_output = |port: &Port| {
        let variable = system.variable(*port); // a parameter may have this name too
        variable.kind == Kind::Boolean && variable.causality == Causality::Output
    };
    named.flatten().filter(is_output).collect()
}

impl Supply {
    /// The balance of a run; `actuators` are the recorded outputs of all actuators, `count` each,
    /// of which the first are the energies in, out, lost and stored.
    pub fn from_run(
        system: &System,
        recorded: &RecordedRun,
        actuators: &[Port],
        count: usize,
    ) -> Result<Option<Self>> {
        let Some((k, bonds)) = feeding(system)? else {
            return Ok(None);
        };
        let rise = |port: Port| Ok::<_, anyhow::Error>(rise(recorded.recording.column(port)?));
        let (mut totals, mut shift) = ([0.0; 3], 0.0);
        for outputs in actuators.chunks(count) {
            for (total, port) in totals.iter_mut().zip(&outputs[1..]) {
                *total += rise(*port)?;
            }
            if let Ok(port) = system.port_of(outputs[0].component, SHIFT) {
                shift += rise(port)?;
            }
        }
        let of_bonds = recorded.outcome.run.residuals.iter();
        let of_bonds: Vec<_> = of_bonds.filter(|r| bonds.contains(&r.bond)).collect();
        let own: Option<Vec<f64>> = (ENERGIES.iter())
            .map(|name| rise(system.port_of(k, name).ok()?).ok())
            .collect();
        let mut ranges = Vec::new();
        for name in SHOWN {
            if let Ok(port) = system.port_of(k, name) {
                let column = recorded.recording.column(port)?;
                ranges.push(Range {
                    name,
                    unit: system.variable(port).unit.clone().unwrap_or_default(),
                    least: column.iter().copied().fold(f64::INFINITY, f64::min),
                    greatest: column.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                    last: column.last().copied().unwrap_or(f64::NAN),
                });
            }
        }
        let mut faults = Vec::new();
        for port in fault_ports(system) {
            let column = recorded.recording.column(port)?;
            if let Some(first) = column.iter().position(|value| *value > 0.5) {
                faults.push((system.name(port), recorded.recording.times[first]));
            }
        }
        let [work, lost, stored] = totals;
        Ok(Some(Self {
            component: system.structure.components[k].name.clone(),
            throughput: of_bonds.iter().map(|r| r.turnover).sum(),
            given: of_bonds.iter().map(|r| r.passed).sum(),
            residual: of_bonds.iter().map(|r| r.energy).sum(),
            work,
            shift,
            lost,
            stored,
            source: own.map(|e| Source {
                battery: e[0],
                brake: e[1],
                lost: e[2],
                stored: e[3],
            }),
            ranges,
            faults,
        }))
    }

    /// Energy that is unaccounted for, J: from the source (else given by the component) minus
    /// losses, work, rise of stored energy, and what the bonds and the coupling at the rods lost.
    pub fn open(&self) -> f64 {
        let from = self
            .source
            .map_or(self.given, |s| s.battery - s.brake - s.lost - s.stored);
        from - self.work - self.shift - self.lost - self.stored - self.residual
    }

    /// Bad if energy is unaccounted for, created or lost by the coupling, or after a fault.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        let share = |energy: f64| energy.abs() / self.throughput.max(f64::MIN_POSITIVE);
        let (component, open) = (&self.component, self.open());
        if share(open) > OPEN {
            verdict.object(format!(
                "{component}: {open:.3e} J of the energy are unaccounted for, {:.1e} of what went through its bonds; it must be at most {OPEN:e}",
                share(open)
            ));
        }
        for (energy, place) in [(self.residual, "at its bonds"), (self.shift, "at the rods")] {
            if share(energy) > RESIDUAL {
                verdict.object(format!(
                    "{component}: the coupling made or lost {energy:.3e} J {place}, {:.1e} of what went through its bonds; it must be at most {RESIDUAL:e}",
                    share(energy)
                ));
            }
        }
        for (signal, since) in &self.faults {
            verdict.object(format!("`{signal}` is true from t = {since} s on"));
        }
        verdict
    }
}
