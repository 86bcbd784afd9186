//! Tests in `check`: both accessors of a row point to the same field, no two rows share a field.

use super::model_check::ModelCheck;
use super::point::Point;
use crate::Model;
use crate::core::causality::Causality;
use crate::core::sizes;
use crate::core::storage::each;
use std::collections::BTreeMap;

impl<M: Model> ModelCheck<M> {
    /// Writes each input and parameter, and reads back all of them.
    pub(super) fn accessors(&mut self) {
        let elements: Vec<_> = self.layout.iter().collect();
        let read = |point: &Point<M>| -> Vec<_> {
            let elements = elements.iter();
            elements.map(|&element| point.read(element)).collect()
        };
        let before = read(&self.start);
        for (k, element) in self.layout.samples() {
            let mut point = self.start.clone();
            let found = point.values(element.1);
            let len = found.map(|found| each!(Values, found, |values| values.len()));
            let found = point.values_mut(element.1);
            if len != found.map(|found| each!(ValuesMut, found, |values| values.len())) {
                self.has_two_fields(k);
                continue;
            }
            if !point.perturb(element, 0.25) {
                continue;
            }
            let after = read(&point);
            if after[k] == before[k] {
                self.has_two_fields(k);
            }
            for other in (0..elements.len()).filter(|&j| j != k && after[j] != before[j]) {
                self.share_a_field(k, other);
            }
        }
    }

    /// Compares the addresses of the outputs.
    pub(super) fn outputs(&mut self) {
        let y = sizes::output::<M>(&self.start.0);
        let mut addresses = BTreeMap::new();
        for (k, (i, row)) in self.layout.iter().enumerate().collect::<Vec<_>>() {
            if row.causality == Causality::Constant {
                continue; // in no field; the compiler may merge equal constants
            }
            if let Some(values) = row.storage.output_values(&y)
                && let address = each!(Values, values, |values| (&raw const values[i]).addr())
                && let Some(first) = addresses.insert(address, k)
            {
                self.share_a_field(first, k);
            }
        }
    }
}
