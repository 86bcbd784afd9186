//! Dependencies of a variable by element, for fmi3GetVariableDependencies (FMI 3.0.2, 2.2.10).

use super::ffi::{DEPENDENT, ValueReference};
use super::instance::Fmi3Instance;
use crate::Model;
use crate::core::dependencies::Knowns;
use crate::core::fault::{Fault, refuse};
use crate::core::phase::Phase;
use std::ffi::c_int;

/// One dependency: an element of the dependent variable, the variable that it depends on, and the
/// element of that one. Elements are counted from 1.
pub(super) struct Dependency {
    pub(super) element: usize,
    pub(super) independent: ValueReference,
    pub(super) independent_element: usize,
    pub(super) kind: c_int,
}

impl<M: Model> Fmi3Instance<M> {
    /// All dependencies of a computed variable: those of its `InitialUnknown` until the end of
    /// Initialization Mode, afterwards those of its `Output`.
    pub(super) fn dependencies(&self, dependent: ValueReference) -> Result<Vec<Dependency>, Fault> {
        let layout = &self.instance.layout;
        let (span, first, n) = layout.block(dependent)?;
        let row = span.row;
        let phase = self.instance.state.phase;
        let initially = matches!(phase, Phase::Instantiated | Phase::Initialization);
        if !row.is_unknown(initially) {
            let name = self.instance.name(row, first);
            let kind = row.kind(self.instance.names);
            return refuse!(
                "`{name}` is {kind}; it must be a variable of ModelStructure in this mode"
            );
        }
        let knowns = Knowns::new(layout);
        let mut found = Vec::new();
        for element in 0..n {
            let positions = (knowns.resolve(row, first + element, initially))
                .map_err(Fault::Refused)?
                .unwrap_or_else(|| knowns.all(initially)); // a row without a list
            for position in positions {
                let (independent, index) = layout.block_at(position);
                found.push(Dependency {
                    element: element + 1,
                    independent,
                    independent_element: index + 1,
                    kind: DEPENDENT,
                });
            }
        }
        Ok(found)
    }
}
