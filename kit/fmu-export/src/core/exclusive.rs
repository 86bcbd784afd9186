//! A cell around each FMI instance, which one call at a time may use: a call within one fails.

use std::cell::UnsafeCell;
use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A value that one call at a time may use.
///
/// The flag `busy` is tested before any reference to the value is made. A call within a call always
/// finds it set. Two threads that call at once, which no version of FMI allows, find it unless they
/// begin within the same few instructions: an atomic exchange would cost each call more than all of
/// its other checks.
#[repr(C)]
pub(crate) struct Exclusive<B> {
    busy: AtomicBool,
    body: UnsafeCell<B>,
}

impl<B> Exclusive<B> {
    pub(crate) fn new(body: B) -> Self {
        Self {
            busy: AtomicBool::new(false),
            body: UnsafeCell::new(body),
        }
    }

    /// Access to the value, unless it is in use.
    #[inline]
    pub(crate) fn enter(&self) -> Option<ExclusiveRef<'_, B>> {
        if self.busy.load(Ordering::Acquire) {
            return None;
        }
        self.busy.store(true, Ordering::Relaxed);
        Some(ExclusiveRef(self))
    }
}

impl<B> Exclusive<B> {
    /// Access to the value when no other thread uses it: in Scheduled Execution, a thread may have
    /// been preempted within a call.
    pub(crate) fn wait(&self) -> ExclusiveRef<'_, B> {
        let (free, taken) = (Ordering::Acquire, Ordering::Relaxed);
        while (self.busy)
            .compare_exchange(false, true, free, taken)
            .is_err()
        {
            std::thread::sleep(Duration::from_micros(20));
        }
        ExclusiveRef(self)
    }
}

/// Exclusive access to the value during a call.
pub(crate) struct ExclusiveRef<'a, B>(&'a Exclusive<B>);

impl<B> Deref for ExclusiveRef<'_, B> {
    type Target = B;

    #[inline]
    fn deref(&self) -> &B {
        // SAFETY: only one `Entered` exists at a time, see `Guarded`.
        unsafe { &*self.0.body.get() }
    }
}

impl<B> DerefMut for ExclusiveRef<'_, B> {
    #[inline]
    fn deref_mut(&mut self) -> &mut B {
        // SAFETY: as above.
        unsafe { &mut *self.0.body.get() }
    }
}

impl<B> Drop for ExclusiveRef<'_, B> {
    #[inline]
    fn drop(&mut self) {
        self.0.busy.store(false, Ordering::Release);
    }
}
