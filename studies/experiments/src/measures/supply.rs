//! What feeds the drives: the component at the far end of power bonds that draw (`power="drawn"`),
//! our `DcLink` or anybody's battery.
//!
//! What it gave comes from the bonds themselves, so that a component counts which tells nothing of
//! itself; where it has outputs `energy.battery`, `energy.brake`, `energy.loss` and `energy.stored`
//! with the meaning of `DcLink`'s, the balance is drawn up back to its source.

use anyhow::Result;
use cosim::structure::Power;
use cosim::{Port, System, Verdict};
use fmi_description::{Causality, Kind};
use serde::Serialize;

use super::power_integral::{SHIFT, rise};
use super::run::RecordedRun;

/// Outputs of the source that make a whole balance.
const ENERGIES: [&str; 4] = [
    "energy.battery",
    "energy.brake",
    "energy.loss",
    "energy.stored",
];
/// Signals of the feeding component that are shown where it has them.
pub const SHOWN: [&str; 5] = ["v_dc", "i_battery", "soc", "T_battery", "P_brake"];
/// Booleans of any component that say that something is wrong.
const TROUBLE: [&str; 2] = ["tripped", "undervoltage"];
/// Share of the throughput that may be left open, and share that the bonds may make or lose.
const OPEN: f64 = 1e-5;
const RESIDUAL: f64 = 1e-3;

/// The feeding component over a whole run, energies in J.
#[derive(Clone, Debug, Serialize)]
pub struct Supply {
    /// Component.
    pub component: String,
    /// Energy that went through the bonds in either direction.
    pub throughput: f64,
    /// Energy that it gave to the drives, less what they gave back, as it counts it.
    pub given: f64,
    /// Energy that the bonds lost (> 0) or created (< 0).
    pub residual: f64,
    /// What became of the energy in the drives: work on the load, losses, rise of what is stored.
    pub work: f64,
    /// Work on the load where the exchange set a rod elsewhere than its velocity had taken it: what
    /// the coupling at the rods makes or loses.
    pub shift: f64,
    /// Lost in the drives.
    pub lost: f64,
    /// Rise of what the drives store.
    pub stored: f64,
    /// Its own account, where it has one.
    pub source: Option<Source>,
    /// Least and greatest value and last one of the shown signals that it has.
    pub ranges: Vec<Range>,
    /// What went wrong, by signal, and when first, s.
    pub trouble: Vec<(String, f64)>,
}

/// Account of a source, J.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Source {
    /// From the source itself.
    pub battery: f64,
    /// Burnt in the brake resistor.
    pub brake: f64,
    /// Lost on the way.
    pub lost: f64,
    /// Rise of what is stored on the way.
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

/// Index of the component that feeds the drives, where there is one.
pub fn component(system: &System) -> Result<Option<usize>> {
    Ok(feeding(system)?.map(|(k, _)| k))
}

/// The component that the drawing bonds end at, and the names of their efforts.
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

/// What must be recorded for [`Supply::from_run`] besides the actuators' energies.
pub fn ports(system: &System) -> Result<Vec<Port>> {
    let mut ports = trouble(system);
    if let Some((k, _)) = feeding(system)? {
        let names = ENERGIES.iter().chain(&SHOWN);
        ports.extend(names.filter_map(|name| system.port_of(k, name).ok()));
    }
    Ok(ports)
}

fn trouble(system: &System) -> Vec<Port> {
    let components = 0..system.fmus.len();
    let of = |k| {
        TROUBLE
            .iter()
            .filter_map(move |name| system.port_of(k, name).ok())
    };
    let is_told = |port: &Port| {
        let variable = system.variable(*port); // a parameter may be named so too
        variable.kind == Kind::Boolean && variable.causality == Causality::Output
    };
    components.flat_map(of).filter(is_told).collect()
}

impl Supply {
    /// Of a run; `actuators` are the recorded outputs of all actuators, `count` of each: energies
    /// in, out, lost and stored first.
    pub fn of(
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
            .map(|name| {
                system
                    .port_of(k, name)
                    .ok()
                    .and_then(|port| rise(port).ok())
            })
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
        let mut wrong = Vec::new();
        for port in trouble(system) {
            let column = recorded.recording.column(port)?;
            if let Some(first) = column.iter().position(|value| *value > 0.5) {
                wrong.push((system.name(port), recorded.recording.times[first]));
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
            trouble: wrong,
        }))
    }

    /// What is left open of: energy from the source, or given by the component where it tells of no
    /// source, less losses, work, rise of what is stored, and what the bonds and the exchange at
    /// the rods lost, J.
    pub fn open(&self) -> f64 {
        let from = self
            .source
            .map_or(self.given, |s| s.battery - s.brake - s.lost - s.stored);
        from - self.work - self.shift - self.lost - self.stored - self.residual
    }

    /// What is to be said of it.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        let share = |energy: f64| energy.abs() / self.throughput.max(f64::MIN_POSITIVE);
        if share(self.open()) > OPEN {
            verdict.object(format!(
                "{}: {:.3e} J of the energy are unaccounted for, {:.1e} of what went through its bonds; it must be at most {OPEN:e}",
                self.component,
                self.open(),
                share(self.open())
            ));
        }
        for (energy, place) in [(self.residual, "at its bonds"), (self.shift, "at the rods")] {
            if share(energy) > RESIDUAL {
                verdict.object(format!(
                    "{}: the coupling made or lost {energy:.3e} J {place}, {:.1e} of what went through its bonds; it must be at most {RESIDUAL:e}",
                    self.component,
                    share(energy)
                ));
            }
        }
        for (signal, since) in &self.trouble {
            verdict.object(format!("`{signal}` is true from t = {since} s on"));
        }
        verdict
    }
}
