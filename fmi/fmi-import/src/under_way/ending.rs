//! What is said when an FMU ends the process, and the functions that the C library calls at `exit`.
//! For `under_way` and `signals`; nothing is allocated, since a signal may come at any moment.

use std::ffi::CStr;
use std::fmt;
use std::io::{Cursor, Write};
use std::mem::transmute;
use std::ptr;
use std::sync::Once;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU32};

use super::slots::{SLOTS, Slot, thread};

/// Exit code of a process that an FMU ended.
pub const EXIT_CODE: u8 = 3;

/// How many threads may call `exit` at a time: each meets a handler of its own, and waits in it.
const EXITS: usize = 16;

/// The function of [`own_program`]; NULL if there is none.
static DRAIN: AtomicPtr<()> = AtomicPtr::new(ptr::null_mut());
/// This process: those that FMUs fork may end as they like.
static PROCESS: AtomicU32 = AtomicU32::new(0);
/// `exit` is no fault of an FMU.
static MAY_EXIT: AtomicBool = AtomicBool::new(false);

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

/// The program itself ends the process, from any thread and during a call: `exit` then has its own
/// exit code, and nothing is said.
pub fn allow_exit() {
    MAY_EXIT.store(true, Relaxed);
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
    if MAY_EXIT.load(Relaxed) || !is_in_call() || (is_main && own_slot().is_none()) {
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
    let is_busy = |slot: &Slot| !slot.who.load(Relaxed).is_null();
    let is_here = PROCESS.load(Relaxed) == std::process::id();
    is_here && own_slot().map_or_else(|| SLOTS.iter().any(is_busy), is_busy)
}

/// The calls that are under way in all threads, in words.
pub fn calls() -> Vec<String> {
    let is_busy = |slot: &&Slot| !slot.who.load(Relaxed).is_null();
    let busy = SLOTS.iter().filter(is_busy);
    busy.map(Slot::to_string).collect()
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
            let is_busy = |slot: &&Slot| !slot.who.load(Relaxed).is_null();
            let mut slots = SLOTS.iter().filter(is_busy);
            let said = write!(
                line,
                "error: a thread that an FMU has made {did}; meanwhile"
            );
            let said = said.and_then(|()| slots.try_for_each(|slot| write!(line, " {slot}")));
            said.and_then(|()| writeln!(line))
        }
    };
    let length = line.position() as usize;
    // SAFETY: as many bytes as there are.
    unsafe { libc::write(2, bytes.as_ptr().cast(), length as _) };
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
