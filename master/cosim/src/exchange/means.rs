//! Mean efforts of power bonds over a step: planned once, read and given by the schedules.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail};
use fmi_description::Access;

use crate::exchange::bond::BondSlots;
use crate::exchange::{Exchange, Read, Write, reads, writes};
use crate::wiring::{Port, Wiring};

/// Step means of the bonds' efforts: read after a component was stepped, given to those stepped
/// later (Gauss–Seidel).
#[derive(Default)]
pub struct Means {
    /// After the step of each component.
    pub reads: Vec<Option<Read>>,
    /// Before the step of each component.
    pub writes: Vec<Option<Write>>,
    /// Last read.
    pub values: Vec<f64>,
    /// Room for what a write passes.
    pub buffer: Vec<f64>,
}

impl Means {
    /// The means and the bonds of a system.
    pub fn new(
        wiring: &Wiring,
        exchange: &Exchange,
        derivatives: Option<&Exchange>,
    ) -> Result<(Self, Vec<BondSlots>)> {
        let mut slots = BTreeMap::new();
        let ports = wiring
            .links
            .iter()
            .filter_map(|link| link.bond.map(|b| b.step_mean));
        let count = wiring.component_count();
        let mut means = Self {
            reads: by_component(count),
            writes: by_component(count),
            ..Self::default()
        };
        for read in reads(wiring, ports, &mut slots) {
            let k = read.component();
            means.reads[k] = Some(read);
        }
        let mut bonds = Vec::new();
        let mut given = Vec::new();
        for link in &wiring.links {
            let Some(b) = link.bond else { continue };
            let Some(flow) = wiring.source(b.flow) else {
                bail!(
                    "power bond of {}: no connection drives its flow {}",
                    wiring.name(link.from),
                    wiring.name(b.flow)
                );
            };
            let is_no_real = |port: &Port| wiring.access(*port) != Access::Real;
            if let Some(port) = [link.from, b.step_mean, flow]
                .iter()
                .find(|p| is_no_real(p))
            {
                let (bond, name) = (wiring.name(link.from), wiring.name(*port));
                bail!("power bond of {bond}: {name} must be Real");
            }
            let slot = |port| exchange.slot(port).context("every connection has a slot");
            let (mean_slot, mean_given) =
                (slots[&b.step_mean], link.from.component < link.to.component);
            if mean_given {
                given.push((link.to, mean_slot, link.transformation.clone()));
            }
            let derivative = |port| derivatives.and_then(|d| d.slot(port));
            bonds.push(BondSlots {
                effort: link.from,
                effort_slot: slot(link.from)?,
                flow_slot: slot(flow)?,
                mean_slot,
                mean_given,
                derivative_slots: (derivative(link.from), derivative(flow)),
                transformation: link.transformation.linear(),
                power: b.power,
            });
        }
        for write in writes(wiring, given.iter().cloned()) {
            let k = write.component();
            means.writes[k] = Some(write);
        }
        means.values = vec![0.0; slots.len()];
        means.buffer = vec![0.0; given.len()];
        Ok((means, bonds))
    }
}

fn by_component<T>(count: usize) -> Vec<Option<T>> {
    std::iter::repeat_with(|| None).take(count).collect()
}
