//! Changing the sizes of an instance (its structural parameters), for `parameters` in Configuration
//! Mode and for `instance` when a state with other sizes replaces the present one.

use super::equation_cache::EquationCache;
use super::fault::Fault;
use super::instance::Instance;
use super::layout::Layout;
use super::phase::Phase;
use super::sizes::{resize_vectors, sizes};
use super::state::State;
use crate::Model;

impl<M: Model> Instance<M> {
    /// Sets sizes; vectors whose length changes get their start values.
    pub(super) fn configure(&mut self, mut p: M::Parameters) -> Result<(), Fault> {
        let mut u = self.state.input.value.clone();
        resize_vectors::<M>(
            &mut p,
            &mut u,
            &mut self.output,
            Some(&self.state.parameters),
        );
        let (old, before) = (&self.layout, &self.state);
        let layout = Layout::<M>::new(&p, &u);
        let mut state = State::instantiated(p, u, layout.slots());
        for (number, (_, row)) in layout.numbered() {
            if (row.dimensions(&before.parameters)).eq(row.dimensions(&state.parameters)) {
                state.settings[layout.slot(number)] = before.settings[old.slot(number)];
            }
        }
        state.phase = Phase::Configuration;
        self.replace(state);
        Ok(())
    }

    /// Whether parameters that a text has set have the present sizes.
    pub(super) fn has_sizes(&self, p: &M::Parameters) -> bool {
        self.layout.fits(p, &self.state.input.value)
            && sizes::<M>().all(|(_, size)| size.get(p, 0) == size.get(&self.start, 0))
    }

    /// Adapts the start values and the layout to the sizes in the parameters.
    pub(super) fn follow_sizes(&mut self) {
        let (mut start, mut u) = M::defaults();
        for (_, field) in sizes::<M>() {
            *field.get_mut(&mut start, 0) = field.get(&self.state.parameters, 0);
        }
        resize_vectors::<M>(&mut start, &mut u, &mut self.output, None);
        self.start = start;
        self.equation_cache = EquationCache::default();
        self.workspace.invalidate();
        self.layout = Layout::new(&self.state.parameters, &self.state.input.value);
    }
}
