//! How a component's functions give and take what is more than a number: the canonical ABI of the
//! Component Model, for lists, records and results.

use crate::fmi3::ffi::Status;
use std::alloc::{Layout, alloc, dealloc};
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::{ptr, slice};

/// Where a host finds an answer.
pub type Answer = *const u8;

/// The longest answer: eight bytes that tell success from failure, and a record.
const LONGEST: usize = 24;

thread_local! {
    static ANSWER: Cell<[u64; LONGEST / 8]> = const { Cell::new([0; LONGEST / 8]) };
    /// The list of the last answer, until the next one.
    static KEPT: RefCell<Option<Box<dyn Any>>> = const { RefCell::new(None) };
    /// What the host has taken for the arguments of the coming call.
    static TAKEN: RefCell<Vec<(*mut u8, Layout)>> = const { RefCell::new(Vec::new()) };
}

/// Memory for an argument; it is freed when the call ends.
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
        // SAFETY: what was taken before is as long as the host says; it is freed with the others.
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
            // SAFETY: allocated by `take`, and the call for which it was has ended.
            unsafe { dealloc(bytes, layout) };
        }
    });
    result
}

/// A list, also a text.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct List {
    at: *const u8,
    len: usize,
}

impl List {
    /// Without items.
    pub const EMPTY: Self = Self {
        at: ptr::null(),
        len: 0,
    };

    /// Of so many items there.
    pub fn from_raw<T>(at: *const T, len: usize) -> Self {
        let at = at.cast();
        Self { at, len }
    }

    /// Of what lives on until the next call.
    pub fn from_slice<T>(items: &[T]) -> Self {
        Self::from_raw(items.as_ptr(), items.len())
    }

    /// Of what is kept until the next answer.
    pub fn from_vec<T: 'static>(items: Vec<T>) -> Self {
        let list = Self::from_slice(&items);
        KEPT.set(Some(Box::new(items)));
        list
    }

    /// Where it begins, and how many items it has.
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

/// An answer without failure.
pub fn plain<T>(value: T) -> Answer {
    const { assert!(size_of::<T>() <= LONGEST) };
    let place = ANSWER.with(Cell::as_ptr);
    // SAFETY: of this thread, long enough and aligned for every type of the interface.
    unsafe { place.cast::<T>().write(value) };
    place.cast()
}

/// `result<T, status>`: `value` if the status is OK.
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
        // SAFETY: within the place; the status lies where the value would.
        unsafe { place.add(at).cast_mut().write(status as u8) };
    }
    place
}
