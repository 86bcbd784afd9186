//! Instances that live in a process of their own (Linux): what crashes, hangs or needs too much
//! memory there ends that process, and is an error here. `cosim` makes them for `--isolate`.
//!
//! [`IsolatedInstance`] is the end of the master, `host` that of the process; the numbers of a step
//! pass through memory that both share. The process runs the same program as the master, which
//! calls [`serve_if_asked`] first of all, or another that does.

mod channel;
mod host;
mod instance;
mod program;
mod protocol;
mod segment;

pub use host::serve_if_asked;
pub use instance::IsolatedInstance;

/// The first argument of a process that hosts an instance; the name of the instance follows.
pub const ARGUMENT: &str = "--host-fmu";
