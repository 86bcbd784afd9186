//! Why a model description cannot be used.

use thiserror::Error;

/// Why a model description cannot be used, or what was not found in it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DescriptionError {
    /// Not well-formed, or an element or attribute is missing or has the wrong form.
    #[error("the model description cannot be read: {0}")]
    Xml(#[from] quick_xml::DeError),
    /// Another version of FMI.
    #[error("model `{model}`: FMI version {version} is not supported, only 2.0 and 3.0")]
    Version {
        /// Model.
        model: String,
        /// What it names.
        version: String,
    },
    /// An FMU for model exchange only.
    #[error("model `{model}` offers no co-simulation")]
    NoCoSimulation {
        /// Model.
        model: String,
    },
    /// The identifier becomes a file name and the prefix of C names.
    #[error("model `{model}`: modelIdentifier `{identifier}` must be a C identifier")]
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
        "model `{model}`: a dimension of `{name}` must be a number of at least 1 or name a structural parameter that starts at one"
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
