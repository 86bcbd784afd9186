//! [`DescriptionError`]: why a model description cannot be used; importer and master report it.

use thiserror::Error;

use crate::encoding::EncodingError;
use crate::xml::XmlError;

/// Why a model description cannot be used, or what was not found in it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DescriptionError {
    /// The encoding is unknown, or is not the one that is named.
    #[error("the model description cannot be read: {0}")]
    Encoding(#[from] EncodingError),
    /// Not well-formed, or an element or attribute is missing or has the wrong form.
    #[error("the model description cannot be read: line {}: {}", .0.line, .0.text)]
    Xml(#[from] XmlError),
    /// Another version of FMI.
    #[error("model `{model}` is of FMI {version}; only FMI 2.0 and 3.0 are supported")]
    Version {
        /// Model.
        model: String,
        /// What it names.
        version: String,
    },
    /// The FMU does not offer the interface that is wanted.
    #[error("model `{model}` offers {offered}, no {wanted}")]
    NoInterface {
        /// Model.
        model: String,
        /// What it offers instead.
        offered: String,
        /// What is wanted.
        wanted: String,
    },
    /// The identifier cannot be the name of a file, as it must.
    #[error("model `{model}`: modelIdentifier `{identifier}` cannot be the name of a file")]
    Identifier {
        /// Model.
        model: String,
        /// What it names.
        identifier: String,
    },
    /// No variable of this name.
    #[error("model `{model}` has no variable `{name}`{hint}")]
    UnknownVariable {
        /// Model.
        model: String,
        /// What was looked for.
        name: String,
        /// Similar names, or nothing.
        hint: String,
    },
}
