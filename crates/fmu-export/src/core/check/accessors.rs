//! Each row has a field of its own, which both of its accessors are of.

use super::point::{Point, known};
use super::trial::Trial;
use crate::Model;
use crate::core::causality::Causality;
use crate::core::place::output;
use crate::core::sizes;
use std::collections::BTreeMap;

impl<M: Model> Trial<M> {
    /// Writes each input and parameter, and reads all.
    pub(super) fn accessors(&mut self) {
        let elements: Vec<_> = self.layout.iter().collect();
        let read = |point: &mut Point<M>| -> Vec<_> {
            elements
                .iter()
                .map(|&element| point.read(element))
                .collect()
        };
        let before = read(&mut self.start.clone());
        for (k, element) in self.layout.samples() {
            let mut point = self.start.clone();
            let lengths = known!(element.1, point, |place, owner| {
                (place.slice(owner).len(), place.slice_mut(owner).len())
            });
            if lengths.is_some_and(|(read, write)| read != write) {
                self.has_two_fields(k);
                continue;
            }
            if !point.perturb(element, 0.25) {
                continue;
            }
            let after = read(&mut point);
            if after[k] == before[k] {
                self.has_two_fields(k);
            }
            for other in (0..elements.len()).filter(|&j| j != k && after[j] != before[j]) {
                self.share_a_field(k, other);
            }
        }
    }

    /// Looks where the outputs are.
    pub(super) fn outputs(&mut self) {
        let y = sizes::output::<M>(&self.start.0);
        let mut places = BTreeMap::new();
        for (k, (i, row)) in self.layout.iter().enumerate().collect::<Vec<_>>() {
            if row.causality == Causality::Constant {
                continue; // in no field; the compiler may put equal ones in one place
            }
            let address = output!(&row.place, |place| (&raw const place.slice(&y)[i]).addr());
            if let Some(address) = address
                && let Some(first) = places.insert(address, k)
            {
                self.share_a_field(first, k);
            }
        }
    }
}
