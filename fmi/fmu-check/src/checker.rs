//! How an FMU is checked.

use std::path::Path;
use std::time::Duration;

/// How an FMU is checked.
#[derive(Clone, Copy, Debug)]
pub struct Checker<'a> {
    /// A program that takes [`crate::Arguments`] after these words: it tries what the FMU does, in
    /// processes of their own.
    pub program: &'a Path,
    /// See `program`.
    pub words: &'a [&'a str],
    /// Only the promises whose text holds this are kept; all hold the empty text.
    pub only: &'a str,
    /// What all trials of an FMU together may take.
    pub limit: Duration,
}
