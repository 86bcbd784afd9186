//! Memory of a WebAssembly module that its host allocates for arguments and results.

use std::alloc::{Layout, alloc, dealloc};
use std::ptr;

/// Alignment for every type of FMI, bytes.
const ALIGNMENT: usize = 16;

fn layout(size: usize) -> Option<Layout> {
    let layout = Layout::from_size_align(size, ALIGNMENT).ok()?;
    (size != 0).then_some(layout)
}

/// Allocates `size` bytes; returns NULL for 0 bytes or if there is no memory.
#[unsafe(no_mangle)]
extern "C" fn fmu_allocate(size: usize) -> *mut u8 {
    let Some(layout) = layout(size) else {
        return ptr::null_mut();
    };
    // SAFETY: of a size that is not zero.
    unsafe { alloc(layout) }
}

/// Frees what `fmu_allocate(size)` gave; NULL is ignored.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmu_free(bytes: *mut u8, size: usize) {
    if let Some(layout) = layout(size)
        && !bytes.is_null()
    {
        // SAFETY: the host says that it came from `fmu_allocate`, with this size.
        unsafe { dealloc(bytes, layout) }
    }
}
