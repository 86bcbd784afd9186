//! What a process that calls FMUs watches of itself, in a thread: how long a call takes, how much
//! memory it needs, and whether the program that started it is still there.

use std::fs::File;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use crate::Limits;
use crate::under_way::{end_for, own_thread_only};

/// Calls that have begun and ended: odd during a call.
static CALLS: AtomicU32 = AtomicU32::new(0);
/// Time between two looks at the memory.
const PERIOD: Duration = Duration::from_millis(10);

/// A call begins, whose time is limited.
#[inline]
pub fn begin_call() {
    CALLS.store(CALLS.load(Relaxed).wrapping_add(1), Relaxed);
}

/// It has ended.
#[inline]
#[cfg(all(feature = "master", target_os = "linux"))]
pub(crate) fn end_call() {
    begin_call();
}

/// The program that started this process, on Linux by a socket whose other end it holds.
#[cfg(target_os = "linux")]
pub type Parent = Option<std::os::fd::OwnedFd>;
/// The program that started this process.
#[cfg(not(target_os = "linux"))]
pub type Parent = Option<std::convert::Infallible>;

/// Ends this process when a limit is passed, after it has said in which call; on Linux also when the
/// program that started it has ended. To be called before an FMU is loaded.
pub fn watch(limits: Limits, parent: Parent) {
    #[cfg(target_os = "linux")]
    // SAFETY: plain numbers.
    unsafe {
        libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL);
    }
    let time = limits.time.map(|time| (time / 20).min(10 * PERIOD));
    let space = limits.memory.map(|_| PERIOD);
    let periods = [time, space, parent.as_ref().map(|_| 100 * PERIOD)];
    let Some(period) = periods.into_iter().flatten().min() else {
        return;
    };
    let period = period.max(PERIOD / 10);
    // Without the thread nothing is watched, and the program that started this process has limits.
    let (begun, has_begun) = mpsc::channel();
    let _ = thread::Builder::new().spawn(move || {
        own_thread_only();
        let statm = File::open("/proc/self/statm").ok();
        let (mut call, mut since) = (0, Instant::now());
        let _ = begun.send(());
        loop {
            wait(period, &parent);
            let present = CALLS.load(Relaxed);
            if present != call || present.is_multiple_of(2) {
                (call, since) = (present, Instant::now());
            } else if let Some(time) = limits.time.filter(|time| since.elapsed() > *time) {
                let seconds = time.as_secs_f64();
                let seconds = if seconds < 10.0 {
                    seconds
                } else {
                    seconds.round()
                };
                end_for(format_args!("gave no answer within {seconds} s"));
            }
            if let (Some(most), Some(used)) = (limits.memory, memory(statm.as_ref()))
                && used > most
            {
                let [used, most] = [used, most].map(|bytes| bytes.div_ceil(1_000_000));
                end_for(format_args!(
                    "uses {used} MB of memory, more than the {most} MB allowed"
                ));
            }
        }
    });
    // The C library begins no thread while it loads an FMU, which may hang then.
    let _ = has_begun.recv();
}

/// Waits, and ends this process if the program that started it has ended.
fn wait(period: Duration, parent: &Parent) {
    #[cfg(target_os = "linux")]
    if let Some(parent) = parent {
        use std::os::fd::AsRawFd;
        let mut socket = libc::pollfd {
            fd: parent.as_raw_fd(),
            events: 0,
            revents: 0,
        };
        // SAFETY: one descriptor, which stays open.
        if unsafe { libc::poll(&mut socket, 1, period.as_millis() as i32) } > 0 {
            exit_now(1);
        }
        return;
    }
    let _ = parent;
    thread::sleep(period);
}

/// Bytes of memory that this process uses, as the system counts them in this file; None if that is
/// not known. Nothing is allocated, since an FMU may hang while it allocates.
fn memory(statm: Option<&File>) -> Option<u64> {
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::fs::FileExt;
        let mut text = [0; 128];
        let length = statm?.read_at(&mut text, 0).ok()?;
        let text = std::str::from_utf8(&text[..length]).ok()?;
        let pages: u64 = text.split(' ').nth(1)?.parse().ok()?;
        // SAFETY: a plain number.
        return Some(pages * unsafe { libc::sysconf(libc::_SC_PAGESIZE) }.unsigned_abs());
    }
    #[allow(unreachable_code)] // known above
    statm.and(None)
}

/// Ends this process at once.
#[cfg(target_os = "linux")]
pub(crate) fn exit_now(code: i32) -> ! {
    // SAFETY: a plain number.
    unsafe { libc::_exit(code) }
}

/// Standard input becomes empty, and standard output standard error.
#[cfg(all(feature = "master", target_os = "linux"))]
pub(crate) fn replace_streams() -> std::io::Result<()> {
    use std::os::fd::AsRawFd;
    let empty = std::fs::File::open("/dev/null")?;
    // SAFETY: plain numbers.
    let done = unsafe { libc::dup2(empty.as_raw_fd(), 0) != -1 && libc::dup2(2, 1) != -1 };
    match done {
        true => Ok(()),
        false => Err(std::io::Error::last_os_error()),
    }
}
