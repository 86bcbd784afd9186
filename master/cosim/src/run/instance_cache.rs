//! Instances that have ended their run and are used again by the next one: for programs that make
//! thousands of runs. Off unless asked for.
//!
//! An instance belongs to a thread, so each thread keeps its own. It is reset before it is used
//! again, and freed where that fails.

use std::cell::RefCell;
use std::sync::Arc;

use crate::fmu::Fmu;
use crate::instance::Instance;

/// Most instances that a thread keeps; the oldest are freed.
const KEPT: usize = 64;

thread_local! {
    static SPARES: RefCell<Option<Vec<Instance>>> = const { RefCell::new(None) };
}

/// From now on this thread keeps the instances of its runs.
pub fn reuse_in_this_thread() {
    SPARES.with_borrow_mut(|spares| {
        spares.get_or_insert_default();
    });
}

/// Number of instances that this thread keeps.
pub fn count() -> usize {
    SPARES.with_borrow(|spares| spares.as_ref().map_or(0, Vec::len))
}

/// Keep instances that have been terminated. One of an FMU that allows no second in the process is
/// not kept, nor is one of another thread.
pub(crate) fn keep(mut instances: Vec<Instance>) {
    SPARES.with_borrow_mut(|spares| {
        let Some(spares) = spares else { return };
        let is_once = |instance: &Instance| instance.fmu().description.capabilities.only_once;
        instances.retain(|instance| !instance.is_elsewhere() && !is_once(instance));
        spares.append(&mut instances);
        let surplus = spares.len().saturating_sub(KEPT);
        spares.drain(..surplus);
    });
}

/// A kept instance of this FMU with this name, as when it was made.
pub(crate) fn take(fmu: &Arc<Fmu>, name: &str, is_staged: bool) -> Option<Instance> {
    let fits =
        |s: &Instance| Arc::ptr_eq(s.fmu(), fmu) && s.name() == name && s.is_staged == is_staged;
    let spare = SPARES.with_borrow_mut(|spares| {
        let spares = spares.as_mut()?;
        let found = spares.iter().position(fits)?;
        Some(spares.swap_remove(found))
    });
    spare.filter(Instance::reset)
}
