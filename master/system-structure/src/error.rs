//! Why a file cannot be used.

use thiserror::Error;

/// What is wrong, and where.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("`{file}`, line {line}: {text}")]
pub struct StructureError {
    /// Name of the file, as the reader was told it.
    pub file: String,
    /// Line, counted from 1.
    pub line: usize,
    /// What is wrong.
    pub text: String,
}
