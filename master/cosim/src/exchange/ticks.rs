//! Passes the ticks of output clocks to the input clocks that are connected to them, for
//! `coupling`: at most once an instant of Event Mode, which ends when discrete states are updated.

use anyhow::Result;

use crate::instance::{At, Instance};
use crate::wiring::{Port, Wiring};
use fmi_import::batch::Batch;
use fmi_import::value::Value;

/// The connections between clocks.
#[derive(Default)]
pub(crate) struct Ticks {
    links: Vec<TickLink>,
    /// Components that are in Event Mode.
    pub in_events: Vec<usize>,
    /// Values before they were read once more in the same instant.
    pub before: (Vec<f64>, Vec<Value>),
}

struct TickLink {
    name: String,
    /// Component and clock.
    from: (usize, Batch),
    to: (usize, Batch),
    /// The tick was passed in the present instant, or in the last one that had ticks.
    has_passed: bool,
    is_last: bool,
}

impl Ticks {
    pub fn new(wiring: &Wiring) -> Self {
        let end = |p: Port| {
            (
                p.component,
                wiring.batch(p.component, [p.variable].into_iter()),
            )
        };
        let link = |[from, to]: &[Port; 2]| TickLink {
            name: format!("{} -> {}", wiring.name(*from), wiring.name(*to)),
            from: end(*from),
            to: end(*to),
            has_passed: false,
            is_last: false,
        };
        Self {
            links: wiring.clocks.iter().map(link).collect(),
            ..Self::default()
        }
    }

    /// Whether no clocks are connected.
    pub fn is_empty(&self) -> bool {
        self.links.is_empty()
    }

    /// Begins an instant, in which every clock may tick.
    pub fn begin_instant(&mut self) {
        for link in &mut self.links {
            link.is_last = std::mem::take(&mut link.has_passed);
        }
    }

    /// Passes ticks that were not passed in this instant; returns whether there were any.
    pub fn pass(&mut self, instances: &[Instance], at: At) -> Result<bool> {
        let mut is_any = false;
        for link in self.links.iter_mut().filter(|link| !link.has_passed) {
            let ((from, output), (to, input)) = (&link.from, &link.to);
            let mut ticks = [0.0];
            instances[*from].get(output, &mut ticks, at)?;
            if ticks != [0.0] {
                instances[*to].set(input, &ticks, at)?;
                (link.has_passed, is_any) = (true, true);
            }
        }
        Ok(is_any)
    }

    /// Whether a tick was passed in this instant.
    pub fn has_passed(&self) -> bool {
        self.links.iter().any(|link| link.has_passed)
    }

    /// The connections that passed a tick in the last instant.
    pub fn ticking(&self) -> Vec<&str> {
        let ticking = self.links.iter().filter(|link| link.is_last);
        ticking.map(|link| link.name.as_str()).collect()
    }
}
