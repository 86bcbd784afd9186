//! The call of an FMU that is under way in each thread, noted by `raw` and `library`. If an FMU ends
//! the process by a crash or `exit`, a line on standard error says in which call, and the exit code
//! is [`EXIT_CODE`]. What an FMU changed of the thread and the process is put back after calls.
//!
//! A call costs a few stores into a slot that its thread owns. Signal handlers read the slots of all
//! threads, so there is no allocation and no lock.

#[cfg(feature = "native")]
mod ending;
mod floating_point;
#[cfg(all(unix, feature = "native"))]
mod signals;
mod slots;
#[cfg(all(unix, feature = "native"))]
mod surroundings;

use std::cell::Cell;
use std::ffi::CStr;
use std::ops::Deref;
use std::ptr;
use std::sync::atomic::Ordering::Relaxed;

use crate::messages;
use crate::status::WARNING;

#[cfg(feature = "native")]
pub use ending::{EXIT_CODE, keep_last_words, last_words, own_program};
#[cfg(feature = "native")]
pub(crate) use ending::{end_for, own_thread_only};
pub(crate) use slots::{About, Slot};
use slots::{SLOTS, SPARE, thread};
pub use surroundings::remember;
pub(crate) use surroundings::remember_late;

/// Every so many steps of a thread the process is looked at, as after initialization.
const STEPS: u32 = 1024;
/// Parts of the names of functions that are called so rarely that the process is looked at then.
const RARE: [&str; 5] = [
    "Instantiate",
    "InitializationMode",
    "Terminate",
    "Reset",
    "FreeInstance",
];

thread_local! {
    static OWN: Cell<*const Slot> = const { Cell::new(&raw const SPARE) };
    static RELEASE: Release = Release {
        #[cfg(all(unix, feature = "native"))]
        _stack: signals::HandlerStack::new(),
    };
}

/// What there is to remember elsewhere: nothing.
#[cfg(not(all(unix, feature = "native")))]
mod surroundings {
    /// Does nothing here.
    pub fn remember() {}

    pub fn remember_late() {}

    pub fn put_back() -> Vec<&'static str> {
        Vec::new()
    }
}

impl Slot {
    /// The slot of this thread, for calls that begin something new: what belongs to the thread and
    /// the process now is what is put back.
    pub fn fresh() -> &'static Self {
        if OWN.get() == &raw const SPARE && RELEASE.try_with(|_| ()).is_ok() {
            let own = thread();
            let claim = |slot: &&Slot| {
                let claimed = slot.thread.compare_exchange(0, own, Relaxed, Relaxed);
                claimed.is_ok()
            };
            OWN.set(SLOTS.iter().find(claim).unwrap_or(&SPARE));
        }
        // SAFETY: it points to one of the statics.
        let slot: &'static Self = unsafe { &*OWN.get() };
        for (to, control) in slot.control.iter().zip(floating_point::present()) {
            to.store(control, Relaxed);
        }
        slot.at(f64::NAN, 0.0);
        slot.function.store(ptr::null_mut(), Relaxed);
        #[cfg(feature = "native")]
        ending::watch();
        #[cfg(all(unix, feature = "native"))]
        signals::watch();
        surroundings::remember();
        slot
    }

    /// Notes that `who` is called, a C string that outlives the call, until what is returned is
    /// dropped.
    #[inline]
    pub fn call(&'static self, who: &CStr) -> Call {
        self.who.store(who.as_ptr().cast_mut(), Relaxed);
        Call(self)
    }

    /// The same for what is no function of FMI.
    #[cfg(feature = "native")]
    pub fn call_of(&'static self, who: &CStr, about: &About) -> Call {
        let call = self.call(who);
        note(about);
        call
    }

    /// Notes from which time a step begins and how long it is, both s.
    #[inline]
    pub fn at(&self, time: f64, length: f64) {
        self.time.store(time.to_bits(), Relaxed);
        self.length.store(length.to_bits(), Relaxed);
        let steps = self.steps.load(Relaxed).wrapping_add(1);
        self.steps.store(steps, Relaxed);
        if steps.is_multiple_of(STEPS) {
            self.is_due.store(true, Relaxed);
        }
    }

    /// Puts back what a call has changed, and logs it in the name of who was called.
    #[cold]
    fn look(&self) {
        let who = self.who.load(Relaxed);
        self.is_due.store(false, Relaxed);
        if who.is_null() {
            return; // A call in this call was looked at.
        }
        // SAFETY: a C string, and what was noted in this call, as long as it is under way.
        let (who, about) = unsafe { (CStr::from_ptr(who), self.function.load(Relaxed).as_ref()) };
        let who = who.to_string_lossy();
        let say = |text: String| messages::add(&who, WARNING, &(text + "; it was put back"));
        let name = about.map_or("a call", |about| about.name);
        let own = self.control.each_ref().map(|control| control.load(Relaxed));
        floating_point::put_back(own).for_each(|what| say(format!("{name} changed {what}")));
        let others = surroundings::put_back().into_iter();
        others.for_each(|what| say(format!("it changed {what}, found after {name}")));
    }
}

/// Notes what is about to be called.
#[inline]
fn note(about: &About) {
    // SAFETY: it points to one of the statics.
    let slot = unsafe { &*OWN.get() };
    slot.function
        .store(ptr::from_ref(about).cast_mut(), Relaxed);
    if about.is_rare {
        slot.is_due.store(true, Relaxed);
    }
}

/// A call that is under way.
pub(crate) struct Call(&'static Slot);

impl Drop for Call {
    #[inline]
    fn drop(&mut self) {
        let slot = self.0;
        let control = slot.control[0].load(Relaxed);
        if slot.is_due.load(Relaxed) | floating_point::differs(control) {
            slot.look();
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
        let is_rare = RARE.iter().any(|part| name.contains(part));
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
struct Release {
    #[cfg(all(unix, feature = "native"))]
    _stack: signals::HandlerStack,
}

impl Drop for Release {
    fn drop(&mut self) {
        // SAFETY: it points to one of the statics.
        let slot = unsafe { &*OWN.get() };
        // `exit` ends threads too: a call is then under way, and is yet to be told.
        if slot.who.load(Relaxed).is_null() {
            OWN.set(&raw const SPARE);
            slot.thread.store(0, Relaxed);
        }
    }
}
