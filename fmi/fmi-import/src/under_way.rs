//! The call of an FMU that is under way in each thread, noted by `raw` and `library`. If an FMU ends
//! the process by a crash or by `exit`, a line on standard error says in which call, and the exit
//! code is [`EXIT_CODE`]. What an FMU changed of the thread and the process is put back after calls.
//!
//! To note a call costs a few stores into a slot that the thread owns. Signal handlers read the
//! slots of all threads, so there is no allocation and no lock.
//!
//! ```
//! /// Keeps the rows of a run also if an FMU calls `exit`.
//! fn write_rows() {}
//! fmi_import::under_way::before_exit(write_rows);
//! ```

#[cfg(feature = "native")]
mod ending;
mod floating_point;
#[cfg(all(unix, feature = "native"))]
mod signals;
#[cfg(feature = "native")]
mod surroundings;

use std::cell::Cell;
use std::ffi::{CStr, c_char};
use std::ops::Deref;
use std::ptr;
use std::sync::atomic::Ordering::{AcqRel, Relaxed};
use std::sync::atomic::{AtomicPtr, AtomicU32, AtomicU64, AtomicUsize};

use crate::messages;

#[cfg(feature = "native")]
pub use ending::{allow_exit, before_exit};
#[cfg(feature = "native")]
pub use surroundings::remember;

/// Exit code of a process that an FMU ended.
pub const EXIT_CODE: u8 = 3;
/// How many threads may call FMUs at a time; the calls of further ones have no name.
const THREADS: usize = 256;
/// Every so many steps of a thread the process is looked at, as after initialization.
const STEPS: u32 = 1024;

static SLOTS: [Slot; THREADS] = [const { Slot::new() }; THREADS];
/// Where threads write that have no slot of their own.
static SPARE: Slot = Slot::new();

thread_local! {
    static OWN: Cell<*const Slot> = const { Cell::new(&raw const SPARE) };
    static RELEASE: Release = const { Release };
}

/// A C function of FMI, or something else that is called in a library.
#[repr(C)]
pub(crate) struct About {
    pub name: &'static str,
    /// It is called so rarely that the process is looked at after it.
    is_rare: bool,
}

impl About {
    pub const fn rare(name: &'static str) -> Self {
        Self { name, is_rare: true }
    }
}

/// Calls of a thread.
#[repr(align(128))]
pub(crate) struct Slot {
    /// The thread; 0 if the slot is free.
    thread: AtomicUsize,
    /// Who is called, a C string; NULL between calls.
    who: AtomicPtr<c_char>,
    /// What is called; NULL until that is known.
    function: AtomicPtr<About>,
    /// Start and length of the last step, s, as bits; NaN before the run.
    time: AtomicU64,
    length: AtomicU64,
    steps: AtomicU32,
    /// Floating-point control of the thread.
    control: [AtomicU32; 2],
}

impl Slot {
    const fn new() -> Self {
        Self {
            thread: AtomicUsize::new(0),
            who: AtomicPtr::new(ptr::null_mut()),
            function: AtomicPtr::new(ptr::null_mut()),
            time: AtomicU64::new(f64::NAN.to_bits()),
            length: AtomicU64::new(0),
            steps: AtomicU32::new(1),
            control: [const { AtomicU32::new(0) }; 2],
        }
    }

    /// The slot of this thread, for calls that begin something new: what belongs to the thread and
    /// the process now is what is put back.
    pub fn fresh() -> &'static Self {
        let slot = Self::own();
        for (to, control) in slot.control.iter().zip(floating_point::present()) {
            to.store(control, Relaxed);
        }
        slot.at(f64::NAN, 0.0);
        #[cfg(feature = "native")]
        {
            ending::watch();
            surroundings::remember();
        }
        slot
    }

    /// The slot of this thread.
    pub fn own() -> &'static Self {
        // SAFETY: it points to one of the statics.
        let slot: &'static Self = unsafe { &*OWN.get() };
        match ptr::eq(slot, &SPARE) {
            true => Self::claim(),
            false => slot,
        }
    }

    /// The same before an instance is freed. That may be long after its last call, so in programs
    /// that are not ours the process is what it is now.
    pub fn renew() {
        #[cfg(feature = "native")]
        if !crate::output::is_separate() {
            surroundings::remember();
        }
    }

    #[cold]
    fn claim() -> &'static Self {
        let own = thread();
        let is_free = |slot: &&Slot| slot.thread.compare_exchange(0, own, AcqRel, Relaxed).is_ok();
        let slot = SLOTS.iter().find(is_free).unwrap_or(&SPARE);
        OWN.set(slot);
        RELEASE.with(|_| ());
        slot
    }

    /// Notes that `who` is called, a C string that outlives the call, until what is returned is
    /// dropped.
    #[inline]
    pub fn call(&'static self, who: &CStr) -> Call {
        self.function.store(ptr::null_mut(), Relaxed);
        self.who.store(who.as_ptr().cast_mut(), Relaxed);
        Call(self)
    }

    /// The same for what is no function of FMI.
    pub fn call_of<'a>(&'static self, who: &'a CStr, about: &'a About) -> Call {
        let call = self.call(who);
        note(about);
        call
    }

    /// Notes from which time a step begins and how long it is, both s.
    #[inline]
    pub fn at(&self, time: f64, length: f64) {
        self.time.store(time.to_bits(), Relaxed);
        self.length.store(length.to_bits(), Relaxed);
        self.steps.store(self.steps.load(Relaxed).wrapping_add(1), Relaxed);
    }

    /// Puts back what a call has changed, and logs it in the name of who was called.
    #[cold]
    fn look(&self, about: Option<&About>) {
        let who = self.who.load(Relaxed);
        if who.is_null() {
            return; // A call in this call was looked at.
        }
        // SAFETY: a C string as long as the call is under way.
        let who = unsafe { CStr::from_ptr(who) }.to_string_lossy();
        let name = about.map_or("a call", |about| about.name);
        let own = self.control.each_ref().map(|control| control.load(Relaxed));
        for what in floating_point::put_back(own) {
            messages::add(&who, true, &format!("{name} changed {what}; it was put back"));
        }
        #[cfg(feature = "native")]
        for what in surroundings::put_back() {
            let text = format!("it changed {what}, found after {name}; it was put back");
            messages::add(&who, true, &text);
        }
    }
}

/// Notes what is called, before `Noted` is called.
#[inline]
pub(crate) fn note(about: &About) {
    // SAFETY: it points to one of the statics.
    let slot = unsafe { &*OWN.get() };
    slot.function.store(ptr::from_ref(about).cast_mut(), Relaxed);
}

/// A call that is under way.
pub(crate) struct Call(&'static Slot);

impl Drop for Call {
    #[inline]
    fn drop(&mut self) {
        let slot = self.0;
        // SAFETY: NULL, or what was noted in this call, which lives as long as the library.
        let about = unsafe { slot.function.load(Relaxed).as_ref() };
        let is_due = about.is_some_and(|about| about.is_rare)
            | slot.steps.load(Relaxed).is_multiple_of(STEPS)
            | floating_point::differs(slot.control[0].load(Relaxed));
        if is_due {
            slot.look(about);
        }
        slot.who.store(ptr::null_mut(), Relaxed);
    }
}

/// A pointer to a function of a library, whose calls are noted.
pub(crate) struct Noted<F> {
    about: About,
    function: F,
}

impl<F> Noted<F> {
    pub fn new(function: F, name: &'static str) -> Self {
        let rare = ["Instantiate", "InitializationMode", "Terminate", "Reset", "FreeInstance"];
        let is_rare = rare.iter().any(|part| name.contains(part));
        let about = About { name, is_rare };
        Self { about, function }
    }
}

impl<F> Deref for Noted<F> {
    type Target = F;

    #[inline]
    fn deref(&self) -> &F {
        note(&self.about);
        &self.function
    }
}

/// Gives the slot back when the thread ends.
struct Release;

impl Drop for Release {
    fn drop(&mut self) {
        #[cfg(all(unix, feature = "native"))]
        signals::drop_stack();
        let slot = OWN.replace(&raw const SPARE);
        // SAFETY: it points to one of the statics.
        let slot = unsafe { &*slot };
        if !ptr::eq(slot, &SPARE) {
            slot.thread.store(0, Relaxed);
        }
    }
}

/// A number for the present thread that is not 0.
fn thread() -> usize {
    #[cfg(all(unix, feature = "native"))]
    // SAFETY: a function without arguments.
    return unsafe { libc::pthread_self() } as usize;
    #[cfg(not(all(unix, feature = "native")))]
    OWN.with(|own| ptr::from_ref(own).addr())
}
