//! The canonical ABI of the WebAssembly Component Model, for `component`: how its functions receive
//! and return lists, records and results.

use crate::fmi3::ffi::Status;
use std::alloc::{Layout, alloc, dealloc};
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::{ptr, slice};

/// Address at which the host finds a result.
pub type Answer = *const u8;

/// Size of the longest result: eight bytes that tell success from failure, and a record.
const LONGEST: usize = 24;

thread_local! {
    static ANSWER: Cell<[u64; LONGEST / 8]> = const { Cell::new([0; LONGEST / 8]) };
    /// The list in the last result, kept until the next one.
    static KEPT: RefCell<Option<Box<dyn Any>>> = const { RefCell::new(None) };
    /// Memory that the host has allocated for the arguments of the next call.
    static TAKEN: RefCell<Vec<(*mut u8, Layout)>> = const { RefCell::new(Vec::new()) };
}

/// Allocates memory for an argument; it is freed when the call ends.
#[unsafe(export_name = "cabi_realloc")]
unsafe extern "C" fn take(old: *mut u8, old_size: usize, align: usize, size: usize) -> *mut u8 {
    if size == 0 {
        return ptr::without_provenance_mut(align);
    }
    let layout = Layout::from_size_align(size, align).expect("the host asks for what there can be");
    // SAFETY: of a size that is not zero.
    let new = unsafe { alloc(layout) };
    assert!(!new.is_null(), "no memory for an argument of {size} bytes");
    if old_size != 0 {
        // SAFETY: the old block is as long as the host says; it is freed with the others.
        unsafe { ptr::copy_nonoverlapping(old, new, old_size.min(size)) };
    }
    TAKEN.with_borrow_mut(|taken| taken.push((new, layout)));
    new
}

/// Runs a function of the component and frees its arguments.
pub fn call<R>(function: impl FnOnce() -> R) -> R {
    let result = function();
    TAKEN.with_borrow_mut(|taken| {
        for (bytes, layout) in taken.drain(..) {
            // SAFETY: allocated by `take` for the call that has ended.
            unsafe { dealloc(bytes, layout) };
        }
    });
    result
}

/// A list or a string.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct List {
    at: *const u8,
    len: usize,
}

impl List {
    /// A list without items.
    pub const EMPTY: Self = Self {
        at: ptr::null(),
        len: 0,
    };

    /// A list of `len` items at this address.
    pub fn from_raw<T>(at: *const T, len: usize) -> Self {
        let at = at.cast();
        Self { at, len }
    }

    /// A list of items that live until the next call.
    pub fn from_slice<T>(items: &[T]) -> Self {
        Self::from_raw(items.as_ptr(), items.len())
    }

    /// A list of items that are kept until the next result.
    pub fn from_vec<T: 'static>(items: Vec<T>) -> Self {
        let list = Self::from_slice(&items);
        KEPT.set(Some(Box::new(items)));
        list
    }

    /// Its address and its number of items.
    pub fn parts(self) -> (*const u8, usize) {
        (self.at, self.len)
    }

    /// The items of an argument.
    ///
    /// # Safety
    /// It is an argument of this call, of this type.
    pub unsafe fn items<'a, T>(self) -> &'a [T] {
        match self.len {
            0 => &[],
            // SAFETY: forwarded.
            len => unsafe { slice::from_raw_parts(self.at.cast(), len) },
        }
    }
}

/// A result that cannot be a failure.
pub fn plain<T>(value: T) -> Answer {
    const { assert!(size_of::<T>() <= LONGEST) };
    let place = ANSWER.with(Cell::as_ptr);
    // SAFETY: memory of this thread, long enough and aligned for every type of the interface.
    unsafe { place.cast::<T>().write(value) };
    place.cast()
}

/// A `result<T, status>`: `value` if the status is OK, else the status.
pub fn result<T>(status: Status, value: T) -> Answer {
    #[repr(C)]
    struct Outcome<T> {
        is_error: u8,
        value: T,
    }
    let place = plain(Outcome {
        is_error: u8::from(status != Status::Ok),
        value,
    });
    if status != Status::Ok {
        let at = std::mem::offset_of!(Outcome<T>, value);
        // SAFETY: within the result; the status is in the position of the value.
        unsafe { place.add(at).cast_mut().write(status as u8) };
    }
    place
}
