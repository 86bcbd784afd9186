//! [`Segment`]: memory that a program shares with the process of an isolated instance, and how one
//! of them sleeps until the other wakes it, for `channel`.

use std::cell::Cell;
use std::hint::spin_loop;
use std::io;
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd, RawFd};
use std::ptr;
use std::slice;
use std::sync::atomic::Ordering::{Relaxed, SeqCst};
use std::sync::atomic::{AtomicU32, AtomicU64};
use std::time::Duration;

/// Shared memory of 64-bit words, which either process may change at any time: they are read and
/// written as atomics only.
pub struct Segment(&'static [AtomicU64]);

impl Segment {
    /// A new segment of so many words, all 0, and the file by which the other process opens it. Its
    /// length is sealed: a process that cut it would end the other one, too.
    pub fn new(words: usize) -> io::Result<(Self, OwnedFd)> {
        let flags = libc::MFD_CLOEXEC | libc::MFD_ALLOW_SEALING;
        // glibc 2.17 has no function for it.
        // SAFETY: a C string.
        let file = unsafe { libc::syscall(libc::SYS_memfd_create, c"fmu".as_ptr(), flags) };
        if file == -1 {
            return Err(io::Error::last_os_error());
        }
        // SAFETY: a new descriptor, which nobody else closes.
        let file = unsafe { OwnedFd::from_raw_fd(file as RawFd) };
        let seals = libc::F_SEAL_SHRINK | libc::F_SEAL_GROW | libc::F_SEAL_SEAL;
        // SAFETY: plain numbers.
        let done = unsafe {
            libc::ftruncate(file.as_raw_fd(), (8 * words) as libc::off_t) == 0
                && libc::fcntl(file.as_raw_fd(), libc::F_ADD_SEALS, seals) == 0
        };
        match done {
            true => Ok((Self::open(&file, words)?, file)),
            false => Err(io::Error::last_os_error()),
        }
    }

    /// Opens a segment of so many words that another process has made.
    pub fn open(file: &OwnedFd, words: usize) -> io::Result<Self> {
        let access = libc::PROT_READ | libc::PROT_WRITE;
        let flags = libc::MAP_SHARED | libc::MAP_NORESERVE;
        let (length, file) = (8 * words, file.as_raw_fd());
        // SAFETY: new pages, wherever the system finds room.
        let start = unsafe { libc::mmap(ptr::null_mut(), length, access, flags, file, 0) };
        if start == libc::MAP_FAILED {
            return Err(io::Error::last_os_error());
        }
        // SAFETY: pages of this length, which stay until this is dropped; zeros are values.
        Ok(Self(unsafe { slice::from_raw_parts(start.cast(), words) }))
    }

    /// Its words.
    pub fn words(&self) -> &[AtomicU64] {
        self.0
    }

    /// The same words, for as long as the process lives, in which the segment stays.
    pub fn forever(self) -> &'static [AtomicU64] {
        let words = self.0;
        std::mem::forget(self);
        words
    }
}

impl Drop for Segment {
    fn drop(&mut self) {
        // SAFETY: the pages of this segment, to which no reference is left.
        unsafe { libc::munmap(self.0.as_ptr().cast_mut().cast(), 8 * self.0.len()) };
    }
}

/// A count in a word that one process raises and the other awaits.
pub struct Count<'a> {
    number: &'a AtomicU32,
    /// The core on which it was raised last.
    core: &'a AtomicU64,
    /// The number that the other process awaits asleep, after [`ASLEEP`]; 0 while it is awake.
    awaited: &'a AtomicU64,
}

const ASLEEP: u64 = 1 << 32;
/// Most times that a number is looked for before the thread sleeps, some 50 µs, and fewest.
pub const SPINS: u64 = 2000;
const LEAST: u64 = 20;
/// One in so many waits looks for long, whatever the ones before brought.
const TRIAL: u64 = 64;

/// How long a thread looks for a number before it sleeps: shorter while looking is in vain, as on a
/// busy machine; never, if it is 0.
#[derive(Default)]
pub struct Patience {
    pub spins: Cell<u64>,
    waits: Cell<u64>,
}

/// The core on which this thread runs.
fn core() -> u64 {
    // SAFETY: a call without arguments.
    unsafe { libc::sched_getcpu() as u64 }
}

impl<'a> Count<'a> {
    /// The count in these words.
    pub fn new([number, core]: [&'a AtomicU64; 2], awaited: &'a AtomicU64) -> Self {
        // SAFETY: a part of the word, aligned as the word is.
        let number = unsafe { &*ptr::from_ref(number).cast::<AtomicU32>() };
        Self {
            number,
            core,
            awaited,
        }
    }

    /// Whether this many have been counted; the count starts again at 0 after 2³².
    #[inline]
    pub fn has_reached(&self, number: u32) -> bool {
        let count = self.number.load(SeqCst);
        count.wrapping_sub(number).cast_signed() >= 0
    }

    /// Looks for a number for a while; returns whether it came. On the core of the other process,
    /// which cannot run meanwhile, it looks once.
    #[inline]
    pub fn spin(&self, number: u32, patience: &Patience) -> bool {
        if self.core.load(Relaxed) == core() {
            return self.has_reached(number);
        }
        let (spins, waits) = (patience.spins.get(), patience.waits.get());
        patience.waits.set(waits.wrapping_add(1));
        let is_trial = spins > 0 && waits.is_multiple_of(TRIAL);
        let spins = if is_trial { SPINS } else { spins };
        for _ in 0..spins {
            if self.has_reached(number) {
                patience.spins.set((spins + spins / 4 + 1).min(SPINS));
                return true;
            }
            spin_loop();
        }
        patience.spins.set((spins / 2).max(LEAST.min(spins)));
        self.has_reached(number)
    }

    /// Sets the count. If the other process sleeps, it is woken by [`Self::wake`] only.
    #[inline]
    pub fn set(&self, number: u32) {
        self.core.store(core(), Relaxed);
        self.number.store(number, SeqCst);
    }

    /// Wakes the other process if the count has reached what it awaits.
    #[inline]
    pub fn wake(&self) {
        let awaited = self.awaited.load(SeqCst);
        if awaited != 0 && self.has_reached(awaited as u32) {
            // SAFETY: a word that stays.
            unsafe { libc::syscall(libc::SYS_futex, self.number, libc::FUTEX_WAKE, 1) };
        }
    }

    /// Sleeps until the count has reached a number, but not longer than the limit, if there is one.
    pub fn sleep(&self, number: u32, limit: Option<Duration>) {
        self.awaited.store(ASLEEP | u64::from(number), SeqCst);
        let seen = self.number.load(SeqCst);
        if seen.wrapping_sub(number).cast_signed() < 0 {
            let limit = limit.map(|limit| libc::timespec {
                tv_sec: limit.as_secs() as libc::time_t,
                tv_nsec: limit.subsec_nanos().into(),
            });
            let limit = limit.as_ref().map_or(ptr::null(), ptr::from_ref);
            // SAFETY: a word and a time that stay as long as the call.
            unsafe { libc::syscall(libc::SYS_futex, self.number, libc::FUTEX_WAIT, seen, limit) };
        }
        self.awaited.store(0, SeqCst);
    }
}
