//! The slots in which threads note the calls of FMUs, for `under_way`, `ending` and `signals`.

use std::ffi::c_char;
use std::ptr;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU32, AtomicU64, AtomicUsize};

/// How many threads may call FMUs at a time; the calls of further ones have no name.
const THREADS: usize = 256;

pub static SLOTS: [Slot; THREADS] = [const { Slot::new() }; THREADS];
/// Where threads write that have no slot of their own.
pub static SPARE: Slot = Slot::new();

/// A C function of FMI, or something else that is called in a library.
pub struct About {
    pub name: &'static str,
    /// The process is looked at afterwards.
    pub is_rare: bool,
}

impl About {
    /// Something that is called so rarely that the process is looked at afterwards.
    #[cfg(feature = "native")]
    pub const fn rare(name: &'static str) -> Self {
        let is_rare = true;
        Self { name, is_rare }
    }
}

/// Calls of a thread.
#[repr(align(128))]
pub struct Slot {
    /// The thread; 0 if the slot is free.
    pub thread: AtomicUsize,
    /// Who is called, a C string; NULL between calls.
    pub who: AtomicPtr<c_char>,
    /// What is called, or was called last.
    pub function: AtomicPtr<About>,
    /// Start and length of the last step, s, as bits; NaN before the run.
    pub time: AtomicU64,
    pub length: AtomicU64,
    pub steps: AtomicU32,
    /// The process is looked at after this call.
    pub is_due: AtomicBool,
    /// Floating-point control of the thread.
    pub control: [AtomicU32; 2],
}

impl Slot {
    const fn new() -> Self {
        Self {
            thread: AtomicUsize::new(0),
            who: AtomicPtr::new(ptr::null_mut()),
            function: AtomicPtr::new(ptr::null_mut()),
            time: AtomicU64::new(0),
            length: AtomicU64::new(0),
            steps: AtomicU32::new(0),
            is_due: AtomicBool::new(false),
            control: [const { AtomicU32::new(0) }; 2],
        }
    }
}

/// A number for the present thread that is not 0.
pub fn thread() -> usize {
    #[cfg(all(unix, feature = "native"))]
    // SAFETY: a function without arguments.
    let number = unsafe { libc::pthread_self() } as usize;
    #[cfg(not(all(unix, feature = "native")))]
    thread_local!(static OWN_ADDRESS: u8 = const { 0 });
    #[cfg(not(all(unix, feature = "native")))]
    let number = OWN_ADDRESS.with(|own| ptr::from_ref(own).addr());
    number
}
