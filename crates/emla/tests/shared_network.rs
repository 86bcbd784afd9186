//! The shipped network is read once for all who have it at a time, and is gone with the last of them: a library that is unloaded
//! leaves nothing behind. A test alone in its process, because it counts all memory.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use emla::Surrogate;

struct Counting;

static LIVE: AtomicUsize = AtomicUsize::new(0);

// SAFETY: the system's allocator, with a count.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LIVE.fetch_add(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn the_shipped_network_lives_as_long_as_someone_has_it() {
    for _ in 0..3 {
        let before = LIVE.load(Ordering::Relaxed);
        let first = Surrogate::reference();
        let with_one = LIVE.load(Ordering::Relaxed);
        assert!(with_one > before + 50_000, "it was read");
        let second = Surrogate::reference();
        assert_eq!(LIVE.load(Ordering::Relaxed), with_one, "it is shared");
        drop(first);
        let third = Surrogate::reference();
        assert_eq!(LIVE.load(Ordering::Relaxed), with_one, "it is kept");
        drop((second, third));
        assert_eq!(LIVE.load(Ordering::Relaxed), before, "it is gone");
    }
}
