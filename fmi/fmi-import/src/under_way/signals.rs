//! Handlers of the signals by which a crash ends a process, for `under_way`: they say which call of
//! an FMU was under way. Crashes elsewhere are as without them, and handlers that were there before
//! (Python's faulthandler) run too.

use std::ffi::{c_int, c_void};
use std::mem::{transmute, zeroed};
use std::ptr;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

use libc::{sigaction, siginfo_t, stack_t};

use super::ending::{EXIT_CODE, is_in_call, is_own_program, tell};

const OVERFLOW: &str = "overflowed its stack (SIGSEGV)";
const SIGNALS: [(c_int, &str); 7] = [
    (libc::SIGSEGV, "crashed with a segmentation fault (SIGSEGV)"),
    (libc::SIGBUS, "crashed with a bus error (SIGBUS)"),
    (libc::SIGFPE, "crashed with an arithmetic fault (SIGFPE)"),
    (libc::SIGILL, "crashed with an illegal instruction (SIGILL)"),
    (libc::SIGTRAP, "stopped at a trap (SIGTRAP)"),
    (libc::SIGSYS, "made a forbidden system call (SIGSYS)"),
    (libc::SIGABRT, "called abort (SIGABRT)"),
];
/// Size of the stack on which handlers run, since that of the thread may be full.
const STACK: usize = 1 << 16;

/// The handlers before ours.
static BEFORE: OnceLock<[sigaction; SIGNALS.len()]> = OnceLock::new();
static IS_TOLD: AtomicBool = AtomicBool::new(false);

/// The present handler of a signal.
pub fn handler(signal: c_int) -> sigaction {
    // SAFETY: all zeros is a value of the type, and the system fills it in.
    unsafe {
        let mut present: sigaction = zeroed();
        libc::sigaction(signal, ptr::null(), &mut present);
        present
    }
}

/// Installs the handlers, once in a process.
pub fn watch() {
    if BEFORE.get().is_none() {
        install();
    }
}

/// Installs the handlers, or installs them again where an FMU has switched them off. Those that it
/// has put in their place stay, since the runtimes of Java and Go need theirs.
pub fn install() {
    let is_first = BEFORE.get().is_none();
    BEFORE.get_or_init(|| SIGNALS.map(|(signal, _)| handler(signal)));
    for (signal, _) in SIGNALS {
        if !is_first && ![libc::SIG_DFL, libc::SIG_IGN].contains(&handler(signal).sa_sigaction) {
            continue;
        }
        // SAFETY: a handler that is safe in signals, and an empty mask.
        unsafe {
            let mut own: sigaction = zeroed();
            own.sa_sigaction = on_signal as *const () as usize;
            own.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            libc::sigaction(signal, &own, ptr::null_mut());
        }
    }
}

extern "C" fn on_signal(signal: c_int, info: *mut siginfo_t, context: *mut c_void) {
    // SAFETY: a plain number.
    let end = || unsafe { libc::_exit(EXIT_CODE.into()) };
    let (is_ours, place) = (is_in_call(), SIGNALS.iter().position(|(s, _)| *s == signal));
    let place = place.unwrap_or(0);
    if IS_TOLD.swap(is_ours, Relaxed) {
        end(); // A handler from before ours has aborted.
    }
    if is_ours {
        // SAFETY: as the system passes them.
        let is_overflow = signal == libc::SIGSEGV && unsafe { is_near_stack(info, context) };
        tell(if is_overflow {
            OVERFLOW
        } else {
            SIGNALS[place].1
        });
    }
    if is_ours && is_own_program() {
        end(); // What was there before is Rust's, which says less.
    }
    let before = BEFORE.get().map(|all| &all[place]);
    // SAFETY: the handling before ours, called as it was installed. What the system does by default
    // follows once this function has returned.
    unsafe {
        match before {
            Some(before) if before.sa_sigaction == libc::SIG_DFL && !is_ours => {
                libc::sigaction(signal, before, ptr::null_mut());
                libc::raise(signal);
            }
            Some(before) if ![libc::SIG_DFL, libc::SIG_IGN].contains(&before.sa_sigaction) => {
                // What takes one argument ignores the others.
                type Handler = extern "C" fn(c_int, *mut siginfo_t, *mut c_void);
                transmute::<usize, Handler>(before.sa_sigaction)(signal, info, context);
            }
            _ => {}
        }
    }
    if is_ours {
        end();
    }
}

/// Whether the address that cannot be reached is where the thread's stack ends; false where that is
/// not known.
///
/// # Safety
/// What the system passed to a handler.
unsafe fn is_near_stack(info: *mut siginfo_t, context: *mut c_void) -> bool {
    let (_address, _context) = (info, context);
    #[cfg(all(
        target_os = "linux",
        any(target_arch = "x86_64", target_arch = "aarch64")
    ))]
    {
        // SAFETY: as the caller promises.
        let (address, context) =
            unsafe { ((*info).si_addr(), &*context.cast::<libc::ucontext_t>()) };
        #[cfg(target_arch = "x86_64")]
        let stack = context.uc_mcontext.gregs[libc::REG_RSP as usize] as usize;
        #[cfg(target_arch = "aarch64")]
        let stack = context.uc_mcontext.sp as usize;
        return address.addr().abs_diff(stack) < STACK;
    }
    #[allow(unreachable_code)] // known above
    false
}

/// The stack for handlers that was made for a thread.
pub struct HandlerStack(*mut c_void);

impl HandlerStack {
    /// Gives this thread a stack for handlers, unless it has one that is large enough. Without, an
    /// overflow of its own is not told.
    pub fn new() -> Self {
        // SAFETY: the system fills in the present stack, and is given pages that stay.
        unsafe {
            let mut stack: stack_t = zeroed();
            libc::sigaltstack(ptr::null(), &mut stack);
            let is_there = stack.ss_flags & libc::SS_DISABLE == 0 && stack.ss_size >= STACK;
            let access = libc::PROT_READ | libc::PROT_WRITE;
            let kind = libc::MAP_PRIVATE | libc::MAP_ANON;
            let map = || libc::mmap(ptr::null_mut(), STACK, access, kind, -1, 0);
            let pages = if is_there { libc::MAP_FAILED } else { map() };
            if pages != libc::MAP_FAILED {
                (stack.ss_sp, stack.ss_size, stack.ss_flags) = (pages, STACK, 0);
                libc::sigaltstack(&stack, ptr::null_mut());
            }
            Self(pages)
        }
    }
}

impl Drop for HandlerStack {
    fn drop(&mut self) {
        // SAFETY: the pages are this thread's, and are unmapped once no handler runs on them.
        unsafe {
            let mut stack: stack_t = zeroed();
            libc::sigaltstack(ptr::null(), &mut stack);
            if stack.ss_sp == self.0 {
                stack.ss_flags = libc::SS_DISABLE;
                libc::sigaltstack(&stack, ptr::null_mut());
            }
            if self.0 != libc::MAP_FAILED {
                libc::munmap(self.0, STACK);
            }
        }
    }
}
