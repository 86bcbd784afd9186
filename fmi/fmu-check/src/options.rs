//! [`CheckOptions`]: how an FMU is checked, for `arguments` and for callers of this library.

use std::path::Path;
use std::time::Duration;

/// How an FMU is checked.
#[derive(Clone, Copy, Debug)]
pub struct CheckOptions<'a> {
    /// A program that takes [`Arguments`](crate::Arguments) after `words`. It runs the probes, each
    /// in its own process.
    pub program: &'a Path,
    /// See `program`.
    pub words: &'a [&'a str],
    /// Only promises that contain this text are checked; all contain the empty text.
    pub only: &'a str,
    /// Time limit for all probes of an FMU together.
    pub limit: Duration,
}
