//! What is said when an FMU ends the process, and the functions that the C library calls at `exit`.
//! For `under_way` and `signals`; nothing is allocated, since a signal may come at any moment.

use std::ffi::CStr;
use std::fmt;
use std::io::{Cursor, Write};
use std::mem::transmute;
use std::ptr;
use std::sync::atomic::Ordering::{Relaxed, Release};
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU32, AtomicU64};
use std::sync::{Once, OnceLock};

use super::slots::{SLOTS, Slot, thread};

/// Exit code of a process that an FMU ended.
pub const EXIT_CODE: u8 = 3;

/// How many threads may call `exit` at a time: each meets a handler of its own, and waits in it.
const EXITS: usize = 16;

/// The function of [`own_program`]; NULL if there is none.
static DRAIN: AtomicPtr<()> = AtomicPtr::new(ptr::null_mut());
/// This process: those that FMUs fork may end as they like.
static PROCESS: AtomicU32 = AtomicU32::new(0);
/// See [`keep_last_words`].
static LAST_WORDS: OnceLock<&'static [AtomicU64]> = OnceLock::new();

/// The process is a program of ours, in which FMUs alone change what belongs to the process from now
/// on. `drain` writes what was printed, before something is said at `exit`.
pub fn own_program(drain: fn()) {
    DRAIN.store(drain as *mut (), Relaxed);
}

/// Whether the process is a program of ours.
#[cfg(unix)]
pub fn is_own_program() -> bool {
    !DRAIN.load(Relaxed).is_null()
}

/// Has what is said when an FMU ends this process kept here instead of being written to standard
/// error: the number of its bytes in the first word, then the bytes, 8 in a word.
pub fn keep_last_words(place: &'static [AtomicU64]) {
    let _ = LAST_WORDS.set(place);
}

/// Reads what was kept, from memory that the process that kept it shares.
pub fn last_words(place: &[AtomicU64]) -> Option<String> {
    let (length, words) = place.split_first()?;
    let length = length.load(Relaxed) as usize;
    let words = words.iter().map(|word| word.load(Relaxed).to_le_bytes());
    let bytes: Vec<u8> = words.flatten().take(length).collect();
    (length > 0).then(|| String::from_utf8_lossy(&bytes).trim_end().to_string())
}

fn say(line: &[u8]) {
    let Some((length, words)) = LAST_WORDS.get().and_then(|place| place.split_first()) else {
        // SAFETY: as many bytes as there are.
        unsafe { libc::write(2, line.as_ptr().cast(), line.len() as _) };
        return;
    };
    let line = line.strip_prefix(b"error: ").unwrap_or(line);
    let line = &line[..line.len().min(8 * words.len())];
    for (to, bytes) in words.iter().zip(line.chunks(8)) {
        let mut word = [0; 8];
        word[..bytes.len()].copy_from_slice(bytes);
        to.store(u64::from_le_bytes(word), Relaxed);
    }
    length.store(line.len() as u64, Release);
}

/// Says which calls are under way in all threads and that they `did` something, and ends the
/// process. For the thread that watches it.
pub fn end_for(did: fmt::Arguments) -> ! {
    let mut bytes = [0; 1024];
    let mut line = Cursor::new(&mut bytes[..]);
    let _ = write!(line, "error:");
    for slot in SLOTS.iter().filter(|slot| is_busy(slot)) {
        let _ = write!(line, " {slot}");
    }
    let _ = writeln!(line, " {did}"); // A line that is too long is cut.
    let length = line.position() as usize;
    say(&bytes[..length]);
    // SAFETY: a plain number.
    unsafe { libc::_exit(EXIT_CODE.into()) }
}

/// Signals that end the process come to other threads than this one, whose calls are told.
pub fn own_thread_only() {
    #[cfg(unix)]
    // SAFETY: a mask that is filled before it is set.
    unsafe {
        let mut all = std::mem::zeroed();
        libc::sigfillset(&mut all);
        libc::pthread_sigmask(libc::SIG_SETMASK, &all, ptr::null_mut());
    }
}

/// Installs what notices that the process ends; once in a process.
pub fn watch() {
    static ONCE: Once = Once::new();
    PROCESS.store(std::process::id(), Relaxed);
    ONCE.call_once(|| {
        // SAFETY: functions without arguments, which stay. If there is no room for them, nothing is
        // said at `exit`.
        unsafe {
            for _ in 0..EXITS {
                libc::atexit(at_exit);
                #[cfg(target_os = "linux")]
                at_quick_exit(at_exit);
            }
        }
    });
}

#[cfg(target_os = "linux")]
unsafe extern "C" {
    fn at_quick_exit(function: extern "C" fn()) -> std::ffi::c_int;
}

extern "C" fn at_exit() {
    // The main thread is the program's; other threads without a slot are an FMU's.
    #[cfg(target_os = "linux")]
    // SAFETY: a function without arguments.
    let is_main = unsafe { libc::syscall(libc::SYS_gettid) } == std::process::id().into();
    #[cfg(not(target_os = "linux"))]
    let is_main = true;
    if !is_in_call() || (is_main && own_slot().is_none()) {
        return;
    }
    static IS_ENDING: AtomicBool = AtomicBool::new(false);
    while IS_ENDING.swap(true, Relaxed) {
        std::thread::sleep(std::time::Duration::from_secs(1)); // Another thread ends the process.
    }
    let drain = DRAIN.load(Relaxed);
    if !drain.is_null() {
        // SAFETY: a function of this type was stored.
        unsafe { transmute::<*mut (), fn()>(drain)() };
    }
    tell("called exit, which ends this process");
    // SAFETY: a plain number.
    unsafe { libc::_exit(EXIT_CODE.into()) }
}

/// Whether this thread has a call under way. A thread without a slot has one if any has: an FMU has
/// made it.
pub fn is_in_call() -> bool {
    let is_here = PROCESS.load(Relaxed) == std::process::id();
    is_here && own_slot().map_or_else(|| SLOTS.iter().any(is_busy), is_busy)
}

/// Whether a call of this slot is under way.
fn is_busy(slot: &Slot) -> bool {
    !slot.who.load(Relaxed).is_null()
}

fn own_slot() -> Option<&'static Slot> {
    let own = thread();
    SLOTS.iter().find(|slot| slot.thread.load(Relaxed) == own)
}

/// Writes to standard error which call was under way when an FMU `did` something.
pub fn tell(did: &str) {
    let mut bytes = [0; 1024];
    let mut line = Cursor::new(&mut bytes[..]);
    // A line that is too long is cut.
    let _ = match own_slot() {
        Some(slot) => writeln!(line, "error: {slot} {did}"),
        None => {
            let mut slots = SLOTS.iter().filter(|slot| is_busy(slot));
            let said = write!(
                line,
                "error: a thread that an FMU has made {did}; meanwhile"
            );
            let said = said.and_then(|()| slots.try_for_each(|slot| write!(line, " {slot}")));
            said.and_then(|()| writeln!(line))
        }
    };
    let length = line.position() as usize;
    say(&bytes[..length]);
}

/// Who is called, what, and when: `a: fmi2DoStep at t = 0.31 s`.
impl fmt::Display for Slot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let who = self.who.load(Relaxed);
        // SAFETY: a C string and a function that live as long as the call is under way.
        let (who, about) = unsafe {
            let who = (!who.is_null()).then(|| CStr::from_ptr(who).to_str());
            (who, self.function.load(Relaxed).as_ref())
        };
        let who = who.and_then(Result::ok).unwrap_or("an FMU");
        let name = about.map_or("a call", |about| about.name);
        let [start, length] = [&self.time, &self.length].map(|t| f64::from_bits(t.load(Relaxed)));
        let is_step = name.ends_with("DoStep");
        let t = if is_step { start } else { start + length };
        match t.is_nan() {
            true => write!(f, "{who}: {name}"),
            // Ten digits: what steps add up to has no more that are right.
            false => write!(f, "{who}: {name} at t = {} s", (t * 1e10).round() / 1e10),
        }
    }
}
