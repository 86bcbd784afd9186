//! Corrects the inputs of power bonds for `coupling`, so that energy is nearly conserved
//! (`--between balanced`): the error of effort and flow over a step is added to them over the next
//! one (NEPCE: Benedikt et al. 2013; Sadjina and Pedersen 2019, arXiv 1606.05168). Outputs are read
//! with the uncorrected inputs: the correction holds for the step alone.
//!
//! Over a step of `h` the receiver of an effort was given `F` where its mean was `F̄`. Over the
//! next one, of `h'` from `F'` and `v'`,
//! ```text
//! u_F = F' + (F̄ − F) r     u_v = v' + (v̄ − v) r     r = min(1, h/h')
//! ```
//! `F̄` is the mean that the bond names, `v̄` the mean of the flows at both ends of the step.
//! Effort and flow then are those of the middle of the step, to second order, and errors do not
//! accumulate. A longer step gets back the missing impulse, a shorter one at most the mean error.

use anyhow::{Result, ensure};

use crate::exchange::bond::{BondSlots, BondStep};
use crate::exchange::{Exchange, Write, writes};
use crate::instance::{At, Instance};
use crate::schedule::{Between, Schedule, Stepping};
use crate::wiring::Wiring;

/// How the corrected inputs are set, with their values.
pub(crate) struct Balance {
    pub writes: Vec<Write>,
    /// Effort and flow of each bond in turn, as given over the step.
    values: Vec<f64>,
}

impl Balance {
    /// Corrections for all bonds, except for efforts whose receiver gets the mean itself. None if
    /// the run does not correct inputs.
    pub fn new(wiring: &Wiring, stepping: Stepping, has_rates: bool) -> Result<Option<Self>> {
        if stepping.between != Between::Balanced {
            return Ok(None);
        }
        ensure!(
            !has_rates && stepping.schedule != Schedule::JacobiDerivatives,
            "inputs can be balanced only where all components make each communication step, without input derivatives"
        );
        let is_sequential = stepping.schedule == Schedule::GaussSeidel;
        let (mut inputs, mut count) = (Vec::new(), 0);
        for link in &wiring.links {
            let Some(bond) = link.bond else { continue };
            if !(is_sequential && link.from.component < link.to.component) {
                inputs.push((link.to, count, link.transformation.clone()));
            }
            let flow = wiring.driver(bond.flow).map(|k| &wiring.links[k]);
            let flow = flow.map(|flow| (flow.to, count + 1, flow.transformation.clone()));
            inputs.extend(flow);
            count += 2;
        }
        ensure!(
            count > 0,
            "the system has no power bond whose inputs could be balanced"
        );
        Ok(Some(Self {
            writes: writes(wiring, inputs.into_iter()),
            values: vec![0.0; count],
        }))
    }

    /// Corrected effort and flow of a bond over the step.
    pub fn given(&self, bond: usize) -> [f64; 2] {
        [self.values[2 * bond], self.values[2 * bond + 1]]
    }

    /// Set the corrected inputs for a step from `t` by `h`, both s.
    pub fn set<'a>(
        &mut self,
        bonds: impl Iterator<Item = (&'a BondSlots, &'a BondStep)>,
        instances: &[Instance],
        exchange: &mut Exchange,
        [t, h]: [f64; 2],
    ) -> Result<()> {
        for (k, (bond, last)) in bonds.enumerate() {
            let [effort, flow] =
                [bond.effort_slot, bond.flow_slot].map(|slot| exchange.values[slot]);
            let share = (last.length / h).min(1.0);
            self.values[2 * k] = effort + share * last.effort_lacked;
            self.values[2 * k + 1] = flow + share * last.flow_lacked;
        }
        for write in &mut self.writes {
            let faults = exchange.faults.as_mut();
            write.run(instances, &self.values, faults, At::Time(t))?;
        }
        Ok(())
    }
}
