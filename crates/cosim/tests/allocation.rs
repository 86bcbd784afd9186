//! A communication step of the master allocates nothing.
//!
//! Counted are the allocations of this program; the FMUs have an allocator of their own, which their crates' tests watch.

use std::alloc::{GlobalAlloc, Layout, System as Heap};
use std::cell::Cell;

use cosim::master::{Master, Schedule};

mod support;
use support::{oscillator, stepping, system};

struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: forwards to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        // SAFETY: forwarded.
        unsafe { Heap.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: forwarded.
        unsafe { Heap.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_step_allocates_nothing() {
    let system = system("allocation", &oscillator()).unwrap();
    for schedule in [
        Schedule::Standard,
        Schedule::GaussSeidel,
        Schedule::Jacobi,
        Schedule::JacobiDerivatives,
    ] {
        let before = COUNT.get();
        let mut master = Master::new(&system, &[], stepping(1e-3, schedule)).unwrap();
        let after_start = COUNT.get();
        assert!(after_start > before, "the counter counts");
        for _ in 0..100 {
            master.step().unwrap();
        }
        assert_eq!(COUNT.get() - after_start, 0, "{schedule:?}");
    }
}
