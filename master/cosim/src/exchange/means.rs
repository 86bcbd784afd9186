//! Mean efforts of power bonds over a step: `coupling` reads them after the step of a component,
//! for the residuals. Gauss–Seidel also sets them as inputs of the components that it steps later.

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail, ensure};
use fmi_description::Access;

use crate::exchange::bond::BondSlots;
use crate::exchange::{Exchange, Read, Write, reads, writes};
use crate::wiring::Wiring;

/// How the mean efforts of the bonds are read and set, with their values.
pub(crate) struct Means {
    /// For each component, the read after its step.
    pub reads: Vec<Option<Read>>,
    /// For each component, the write before its step.
    pub writes: Vec<Option<Write>>,
    /// Values last read.
    pub values: Vec<f64>,
}

impl Means {
    /// The means and the bonds of a system.
    pub fn new(
        wiring: &Wiring,
        exchange: &Exchange,
        derivatives: Option<&Exchange>,
    ) -> Result<(Self, Vec<BondSlots>)> {
        let mut slots = BTreeMap::new();
        let links = wiring.links.iter();
        let all_bonds = links.filter_map(|link| Some((link, link.bond?)));
        let means = all_bonds.clone().map(|(_, b)| b.step_mean);
        let reads = reads(wiring, means, &mut slots);
        let mut bonds = Vec::new();
        let mut given = Vec::new();
        for (link, b) in all_bonds {
            let bond = wiring.name(link.from);
            let Some(flow) = wiring.source(b.flow) else {
                bail!(
                    "power bond of {bond}: no connection drives its flow {}",
                    wiring.name(b.flow)
                );
            };
            ensure!(
                wiring.terms(b.flow).count() == 1,
                "power bond of {bond}: its flow {} is a sum; it must have one connection",
                wiring.name(b.flow)
            );
            let mut ports = [link.from, b.step_mean, flow].into_iter();
            if let Some(port) = ports.find(|port| wiring.access(*port) != Access::Real) {
                bail!("power bond of {bond}: {} must be Real", wiring.name(port));
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
        let count = wiring.components.len();
        let mut writes = writes(wiring, given.into_iter());
        writes.iter_mut().for_each(Write::trust_sources);
        let means = Self {
            reads: by_component(reads, |read| read.instance, count),
            writes: by_component(writes, |write| write.instance, count),
            values: vec![0.0; slots.len()],
        };
        Ok((means, bonds))
    }
}

/// At most one item for each of `count` components.
fn by_component<T>(items: Vec<T>, component: fn(&T) -> usize, count: usize) -> Vec<Option<T>> {
    let mut sorted: Vec<Option<T>> = (0..count).map(|_| None).collect();
    for item in items {
        let k = component(&item);
        sorted[k] = Some(item);
    }
    sorted
}
