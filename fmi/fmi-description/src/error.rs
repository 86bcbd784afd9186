//! Why a model description cannot be used.

use thiserror::Error;

use crate::xml::XmlError;

/// Why a model description cannot be used, or what was not found in it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DescriptionError {
    /// Letters of an encoding that is not known, or not those of the one that is named.
    #[error("the model description cannot be read: {0}")]
    Encoding(String),
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
    /// An FMU for other interfaces only.
    #[error("model `{model}` offers {offered}, no co-simulation")]
    NoCoSimulation {
        /// Model.
        model: String,
        /// What it offers instead.
        offered: &'static str,
    },
    /// The identifier becomes the name of a file.
    #[error("model `{model}`: modelIdentifier `{identifier}` cannot be the name of a file")]
    Identifier {
        /// Model.
        model: String,
        /// What it names.
        identifier: String,
    },
    /// A variable without `Real`, `Integer`, `Boolean`, `String` or `Enumeration`.
    #[error("model `{model}`: variable `{name}` has no type")]
    NoType {
        /// Model.
        model: String,
        /// Variable.
        name: String,
    },
    /// A dimension of an array that is no number, or names a variable that is no number.
    #[error(
        "model `{model}`: a dimension of `{name}` must be a number of at least 1 or name a structural parameter that starts at one; an array has at most 16777216 elements"
    )]
    Dimension {
        /// Model.
        model: String,
        /// Array.
        name: String,
    },
    /// `ModelStructure` of FMI 3.0 names variables by value reference.
    #[error(
        "model `{model}`: ModelStructure names value reference {reference}, which no variable has"
    )]
    Reference {
        /// Model.
        model: String,
        /// What it names.
        reference: String,
    },
    /// `ModelStructure` of FMI 2.0 counts variables from 1 in the order of the file.
    #[error(
        "model `{model}`: ModelStructure names variable number {index}, but must name one of 1 to {count}"
    )]
    Index {
        /// Model.
        model: String,
        /// What it names.
        index: String,
        /// Number of variables.
        count: usize,
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
