//! What is said when an FMU ends the process, and the functions that the C library calls at `exit`.
//! For `under_way` and `signals`; there is no allocation, since a signal may come at any moment.

use std::ffi::CStr;
use std::fmt::{self, Write};
use std::mem::transmute;
use std::ptr;
use std::sync::Once;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU32};

use super::{EXIT_CODE, SLOTS, Slot, thread};
use crate::output;

/// The function of [`before_exit`]; NULL if there is none.
static HOOK: AtomicPtr<()> = AtomicPtr::new(ptr::null_mut());
/// This process: not the ones that FMUs fork, which may end as they like.
static PROCESS: AtomicU32 = AtomicU32::new(0);
/// `exit` is no fault of an FMU.
static MAY_EXIT: AtomicBool = AtomicBool::new(false);

/// Has `hook` called if an FMU ends the process by `exit`, before it ends with [`EXIT_CODE`], in the
/// thread that called `exit`; not after a crash.
pub fn before_exit(hook: fn()) {
    HOOK.store(hook as *mut (), Relaxed);
}

/// The program itself ends the process, from any thread and during a call: `exit` then has its own
/// exit code, and nothing is said.
pub fn allow_exit() {
    MAY_EXIT.store(true, Relaxed);
}

/// Installs what notices that the process ends; once in a process.
pub fn watch() {
    PROCESS.store(std::process::id(), Relaxed);
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // SAFETY: functions without arguments, which stay. If there is no room for them, nothing is
        // said at `exit`.
        unsafe {
            libc::atexit(at_exit);
            #[cfg(target_os = "linux")]
            at_quick_exit(at_quick_exit_said);
        }
        #[cfg(unix)]
        super::signals::install();
    });
    #[cfg(unix)]
    super::signals::make_stack();
}

#[cfg(target_os = "linux")]
unsafe extern "C" {
    fn at_quick_exit(function: extern "C" fn()) -> std::ffi::c_int;
}

extern "C" fn at_exit() {
    end("called exit, which ends this process");
}

#[cfg(target_os = "linux")]
extern "C" fn at_quick_exit_said() {
    end("called quick_exit, which ends this process");
}

fn end(did: &str) {
    if MAY_EXIT.load(Relaxed) || !is_in_call(true) {
        return;
    }
    output::drain();
    tell(did);
    let hook = HOOK.load(Relaxed);
    if !hook.is_null() {
        // SAFETY: `before_exit` stored a function of this type.
        unsafe { transmute::<*mut (), fn()>(hook)() };
    }
    // SAFETY: a plain number.
    unsafe { libc::_exit(EXIT_CODE.into()) }
}

/// Whether this thread has a call under way, or is no thread of the program's: then an FMU has
/// made it. `at_exit` the main thread is the program's in any case.
pub fn is_in_call(at_exit: bool) -> bool {
    let is_here = PROCESS.load(Relaxed) == std::process::id();
    is_here && own_slot().map_or_else(
        || !(at_exit && is_main()) && SLOTS.iter().any(Slot::is_busy),
        Slot::is_busy,
    )
}

fn own_slot() -> Option<&'static Slot> {
    let own = thread();
    SLOTS.iter().find(|slot| slot.thread.load(Relaxed) == own)
}

#[cfg(target_os = "linux")]
fn is_main() -> bool {
    // SAFETY: functions without arguments.
    unsafe { libc::gettid() == libc::getpid() }
}

#[cfg(not(target_os = "linux"))]
fn is_main() -> bool {
    true
}

/// Writes to standard error which call was under way when an FMU `did` something.
pub fn tell(did: &str) {
    let mut line = Line {
        bytes: [0; 1024],
        length: 0,
    };
    // A line that is too long is cut.
    let _ = match own_slot() {
        Some(slot) => writeln!(line, "error: {slot} {did}"),
        None => {
            let mut said = write!(line, "error: a thread that an FMU has made {did}; meanwhile");
            for slot in SLOTS.iter().filter(|slot| slot.is_busy()) {
                said = said.and_then(|()| write!(line, " {slot} was under way"));
            }
            said.and_then(|()| writeln!(line))
        }
    };
    line.bytes[line.bytes.len() - 1] = b'\n';
    // SAFETY: as many bytes as there are.
    unsafe { libc::write(2, line.bytes.as_ptr().cast(), line.length as _) };
}

impl Slot {
    fn is_busy(&self) -> bool {
        !self.who.load(Relaxed).is_null()
    }
}

/// Who is called, what, and when: `a: fmi2DoStep at t = 0.31 s`.
impl fmt::Display for Slot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // SAFETY: C strings and functions that live as long as the call is under way.
        let (who, about) = unsafe {
            let who = self.who.load(Relaxed);
            let who = (!who.is_null()).then(|| CStr::from_ptr(who).to_str());
            (who, self.function.load(Relaxed).as_ref())
        };
        let (who, name) = (who.and_then(Result::ok), about.map(|about| about.name));
        let (who, name) = (who.unwrap_or("an FMU"), name.unwrap_or("a call"));
        let [start, length] = [&self.time, &self.length].map(|t| f64::from_bits(t.load(Relaxed)));
        let t = match name.ends_with("DoStep") {
            true => start,
            false => start + length,
        };
        match t.is_nan() {
            true => write!(f, "{who}: {name}"),
            // Ten digits: what a step adds up to has no more that are right.
            false => write!(f, "{who}: {name} at t = {} s", (t * 1e10).round() / 1e10),
        }
    }
}

/// A text in a buffer of its own.
struct Line {
    bytes: [u8; 1024],
    length: usize,
}

impl Write for Line {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let left = &mut self.bytes[self.length..];
        let n = text.len().min(left.len());
        left[..n].copy_from_slice(&text.as_bytes()[..n]);
        self.length += n;
        Ok(())
    }
}
