//! What is wrong by the standard in an FMU but does no harm: it is read, and told to the user.

use std::fmt;

/// A fault of an FMU that does not keep it from being run.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Remark {
    /// The identifier, which is to be a part of C names, has a letter that they cannot have, or
    /// begins with a digit.
    Identifier(String),
    /// The library is the only one in its folder, and is not named after the identifier.
    Library {
        /// Where it should be.
        expected: String,
        /// Where it is.
        found: String,
    },
    /// `fmiVersion` is a version of the specification, as "2.0.4".
    Version(String),
    /// A variable names a type that is not declared.
    UnknownType {
        /// The first of these variables.
        variable: String,
        /// The type.
        declared: String,
        /// Number of variables with such types.
        count: usize,
    },
    /// Outputs that `ModelStructure` does not list, so that they are taken to depend on all inputs.
    UnlistedOutputs {
        /// The first of them.
        variable: String,
        /// Their number.
        count: usize,
    },
    /// Two variables have one name; the second is found by it.
    SameName(String),
    /// Names in the archive have `\` where `/` belongs.
    Backslash(String),
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Identifier(identifier) => {
                write!(f, "modelIdentifier `{identifier}` is no C identifier")
            }
            Self::Library { expected, found } => {
                write!(
                    f,
                    "there is no `{expected}`; the only library there is `{found}`"
                )
            }
            Self::Version(version) => {
                write!(f, "fmiVersion is `{version}`, but must be \"2.0\"")
            }
            Self::UnknownType {
                variable,
                declared,
                count,
            } => {
                let more = and_more(*count);
                write!(
                    f,
                    "`{variable}`{more} names the type `{declared}`, which is not declared"
                )
            }
            Self::UnlistedOutputs { variable, count } => {
                let more = and_more(*count);
                write!(
                    f,
                    "ModelStructure does not list the output `{variable}`{more}: taken to depend on all inputs"
                )
            }
            Self::SameName(name) => write!(f, "two variables are named `{name}`"),
            Self::Backslash(name) => write!(f, "`{name}` in the archive has \\ instead of /"),
        }
    }
}

fn and_more(count: usize) -> String {
    match count {
        0 | 1 => String::new(),
        _ => format!(" (and {} more)", count - 1),
    }
}
