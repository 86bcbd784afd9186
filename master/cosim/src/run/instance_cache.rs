//! A cache of instances, for Python scripts that make thousands of runs: an instance that has ended
//! its run is reset and used again, which is quicker than to make another.
//!
//! The cache is off until a thread turns it on; each thread has its own, with its own instances.

use std::cell::RefCell;
use std::sync::Arc;

use crate::fmu::Fmu;
use crate::instance::Instance;

/// Most instances that a thread keeps; the oldest are freed.
const CAPACITY: usize = 64;

thread_local! {
    static CACHE: RefCell<Option<Vec<Instance>>> = const { RefCell::new(None) };
}

/// From now on this thread keeps the instances of its runs.
pub fn enable_in_this_thread() {
    CACHE.with_borrow_mut(|cache| {
        cache.get_or_insert_default();
    });
}

/// Number of instances in this thread's cache.
pub fn count() -> usize {
    CACHE.with_borrow(|cache| cache.as_ref().map_or(0, Vec::len))
}

/// Keeps terminated instances, except those of other threads and those of FMUs that allow only one
/// instance in a process.
pub(crate) fn keep(mut instances: Vec<Instance>) {
    CACHE.with_borrow_mut(|cache| {
        let Some(cache) = cache else { return };
        let is_only_one = |instance: &Instance| instance.fmu().description.capabilities.only_once;
        instances.retain(|instance| !instance.is_elsewhere() && !is_only_one(instance));
        cache.append(&mut instances);
        let surplus = cache.len().saturating_sub(CAPACITY);
        cache.drain(..surplus);
    });
}

/// Takes an instance of this FMU with this name from the cache, reset; None if there is none or its
/// reset fails.
pub(crate) fn take(fmu: &Arc<Fmu>, name: &str, is_staged: bool) -> Option<Instance> {
    let fits =
        |i: &Instance| Arc::ptr_eq(i.fmu(), fmu) && i.name == name && i.is_staged == is_staged;
    let instance = CACHE.with_borrow_mut(|cache| {
        let cache = cache.as_mut()?;
        let found = cache.iter().position(fits)?;
        Some(cache.swap_remove(found))
    });
    instance.filter(Instance::reset)
}
