//! Handlers of the signals by which a crash ends a process, for `under_way`: they say which call of
//! an FMU was under way. Crashes elsewhere, and handlers that were there before (Python's
//! faulthandler, a debugger's), are as without.

use std::cell::Cell;
use std::ffi::{c_int, c_void};
use std::mem::{transmute, zeroed};
use std::ptr;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

use libc::{sigaction, siginfo_t};

use super::EXIT_CODE;
use super::ending::{is_in_call, tell};

const OVERFLOW: &str = "overflowed its stack (SIGSEGV)";
const SIGNALS: [(c_int, &str); 7] = [
    (libc::SIGSEGV, "crashed with a segmentation fault (SIGSEGV)"),
    (libc::SIGBUS, "crashed with a bus error (SIGBUS)"),
    (libc::SIGFPE, "crashed with an arithmetic fault (SIGFPE)"),
    (libc::SIGILL, "crashed with an illegal instruction (SIGILL)"),
    (libc::SIGTRAP, "stopped at a trap (SIGTRAP)"),
    (libc::SIGSYS, "made a system call that is forbidden (SIGSYS)"),
    (libc::SIGABRT, "called abort (SIGABRT)"),
];
/// Size of the stack on which handlers run, since that of the thread may be full.
const STACK: usize = 1 << 16;

/// The handlers before ours.
static BEFORE: OnceLock<[sigaction; SIGNALS.len()]> = OnceLock::new();
static IS_TOLD: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// The stack that was made for this thread; NULL if it has another.
    static OWN_STACK: Cell<*mut c_void> = const { Cell::new(ptr::null_mut()) };
}

/// The present handler of a signal.
pub fn handler(signal: c_int) -> sigaction {
    // SAFETY: all zeros is a value of the type, and the system fills it in.
    unsafe {
        let mut present: sigaction = zeroed();
        libc::sigaction(signal, ptr::null(), &mut present);
        present
    }
}

/// Installs the handlers.
pub fn install() {
    BEFORE.get_or_init(|| SIGNALS.map(|(signal, _)| handler(signal)));
    for (signal, _) in SIGNALS {
        set(signal);
    }
}

fn set(signal: c_int) {
    // SAFETY: a handler that is safe in signals, and an empty mask.
    unsafe {
        let mut own: sigaction = zeroed();
        own.sa_sigaction = on_signal as *const () as usize;
        own.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
        libc::sigemptyset(&mut own.sa_mask);
        libc::sigaction(signal, &own, ptr::null_mut());
    }
}

/// Installs handlers again where an FMU has switched them off. Those that it has put in their place
/// stay, since the runtimes of Java and Go need theirs.
pub fn install_again() {
    for (signal, _) in SIGNALS {
        if [libc::SIG_DFL, libc::SIG_IGN].contains(&handler(signal).sa_sigaction) {
            set(signal);
        }
    }
}

extern "C" fn on_signal(signal: c_int, info: *mut siginfo_t, context: *mut c_void) {
    let is_ours = is_in_call(false);
    let place = SIGNALS.iter().position(|(s, _)| *s == signal).unwrap_or(0);
    if IS_TOLD.load(Relaxed) {
        // A handler from before ours has aborted.
        end();
    }
    if is_ours {
        IS_TOLD.store(true, Relaxed);
        // SAFETY: as the system passes them.
        let is_overflow = signal == libc::SIGSEGV && unsafe { is_near_stack(info, context) };
        tell(if is_overflow { OVERFLOW } else { SIGNALS[place].1 });
    }
    let Some(before) = BEFORE.get().map(|before| &before[place]) else {
        return;
    };
    match before.sa_sigaction {
        libc::SIG_IGN => {}
        libc::SIG_DFL if is_ours => {}
        libc::SIG_DFL => {
            // SAFETY: the handling before, which the signal meets once this function has returned.
            unsafe {
                libc::sigaction(signal, before, ptr::null_mut());
                libc::raise(signal);
            }
        }
        // SAFETY: a handler that was installed with these flags.
        function => unsafe {
            if before.sa_flags & libc::SA_SIGINFO != 0 {
                type Handler = extern "C" fn(c_int, *mut siginfo_t, *mut c_void);
                transmute::<usize, Handler>(function)(signal, info, context);
            } else {
                transmute::<usize, extern "C" fn(c_int)>(function)(signal);
            }
        },
    }
    if is_ours {
        end();
    }
}

fn end() {
    // SAFETY: a plain number.
    unsafe { libc::_exit(EXIT_CODE.into()) }
}

/// Whether the address that cannot be reached is where the thread's stack ends.
///
/// # Safety
/// What the system passed to a handler.
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
unsafe fn is_near_stack(info: *mut siginfo_t, context: *mut c_void) -> bool {
    // SAFETY: as the caller promises.
    let (address, machine) = unsafe {
        let context = &*context.cast::<libc::ucontext_t>();
        ((*info).si_addr().addr(), &context.uc_mcontext)
    };
    #[cfg(target_arch = "x86_64")]
    let stack = machine.gregs[libc::REG_RSP as usize] as usize;
    #[cfg(target_arch = "aarch64")]
    let stack = machine.sp as usize;
    address.abs_diff(stack) < STACK
}

/// Not known here.
///
/// # Safety
/// None is needed.
#[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
unsafe fn is_near_stack(_: *mut siginfo_t, _: *mut c_void) -> bool {
    false
}

/// Gives this thread a stack for handlers, unless it has one that is large enough.
pub fn make_stack() {
    // SAFETY: the system fills in the present stack, and is given pages that stay.
    unsafe {
        let mut present: libc::stack_t = zeroed();
        libc::sigaltstack(ptr::null(), &mut present);
        let is_there = present.ss_flags & libc::SS_DISABLE == 0;
        if is_there && present.ss_size >= STACK {
            return;
        }
        let access = libc::PROT_READ | libc::PROT_WRITE;
        let kind = libc::MAP_PRIVATE | libc::MAP_ANON;
        let pages = libc::mmap(ptr::null_mut(), STACK, access, kind, -1, 0);
        if pages == libc::MAP_FAILED {
            return; // A full stack is then not told.
        }
        present.ss_sp = pages;
        present.ss_size = STACK;
        present.ss_flags = 0;
        libc::sigaltstack(&present, ptr::null_mut());
        OWN_STACK.set(pages);
    }
}

/// Takes the stack for handlers away again, when the thread ends.
pub fn drop_stack() {
    let own = OWN_STACK.replace(ptr::null_mut());
    if own.is_null() {
        return;
    }
    // SAFETY: the pages are this thread's, and are unmapped once no handler runs on them.
    unsafe {
        let mut present: libc::stack_t = zeroed();
        libc::sigaltstack(ptr::null(), &mut present);
        if present.ss_sp == own {
            present.ss_flags = libc::SS_DISABLE;
            libc::sigaltstack(&present, ptr::null_mut());
        }
        libc::munmap(own, STACK);
    }
}
