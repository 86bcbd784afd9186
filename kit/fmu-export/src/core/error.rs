//! The error of a model's methods, which authors of models return and the FMI functions report.

use std::fmt;

/// The error of a model's methods; its text goes to the importer's log.
///
/// Any error type converts into it with `?`.
pub struct ModelError(String);

impl ModelError {
    /// An error with this text, which should name the variable, its value and what is allowed.
    pub fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }
}

impl<E: std::error::Error> From<E> for ModelError {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Debug for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
