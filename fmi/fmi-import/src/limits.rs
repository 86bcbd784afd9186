//! [`Limits`] of a process that calls FMUs, for `process` and `isolated`, and for masters that pass
//! them on.

use std::time::Duration;

/// What a process may need.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "master", derive(serde::Deserialize, serde::Serialize))]
pub struct Limits {
    /// Time of a call.
    pub time: Option<Duration>,
    /// Memory, bytes.
    pub memory: Option<u64>,
}
