//! [`Remark`]: a harmless fault of an FMU that is read nevertheless; the master prints it.

use thiserror::Error;

/// A fault of an FMU that does not keep it from being run.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Remark {
    /// The identifier, which must be valid in C names, has another character or begins with a
    /// digit.
    #[error("modelIdentifier `{0}` is no C identifier")]
    Identifier(String),
    /// The library is the only one in its folder, and is not named after the identifier.
    #[error("there is no `{expected}`; the only library there is `{found}`")]
    Library {
        /// Where it should be.
        expected: String,
        /// Where it is.
        found: String,
    },
    /// `fmiVersion` is a version of the specification, as "2.0.4".
    #[error("fmiVersion is `{0}`, but must be \"2.0\"")]
    Version(String),
    /// A variable names a type that is not declared.
    #[error("`{variable}`{} names the type `{declared}`, which is not declared", and_more(*.count))]
    UnknownType {
        /// The first of these variables.
        variable: String,
        /// The type.
        declared: String,
        /// Number of variables with such types.
        count: usize,
    },
    /// `ModelStructure` does not list outputs, so that they are taken to depend on all inputs.
    #[error(
        "ModelStructure does not list the output `{variable}`{}: taken to depend on all inputs",
        and_more(*.count)
    )]
    UnlistedOutputs {
        /// The first of them.
        variable: String,
        /// Their number.
        count: usize,
    },
    /// Two variables have one name; the second is found by it.
    #[error("two variables are named `{0}`")]
    SameName(String),
    /// Names in the archive have `\` where `/` belongs.
    #[error("`{0}` in the archive has \\ instead of /")]
    Backslash(String),
}

fn and_more(count: usize) -> String {
    match count {
        0 | 1 => String::new(),
        _ => format!(" (and {} more)", count - 1),
    }
}
