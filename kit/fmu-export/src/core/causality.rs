//! What a row is to an importer, and what it depends on.

/// In a list of initial dependencies: every parameter of the model.
pub const ALL_PARAMETERS: &str = "*parameters";

/// In a list of dependencies of a model for Model Exchange: no state, where none is named.
pub const NO_STATES: &str = "*no states";

/// Causality of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Causality {
    Input,
    Output,
    Local,
    Parameter,
    /// A function of parameters.
    CalculatedParameter,
    /// Always the same.
    Constant,
}

/// What the elements of a row depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Dependencies {
    /// Not said: on everything.
    Unknown,
    /// The same lists, one after the other, for each element (`[i]`: same index).
    Same([&'static [&'static str]; 2]),
    /// A list for each element.
    Each(&'static [&'static [&'static str]]),
}
