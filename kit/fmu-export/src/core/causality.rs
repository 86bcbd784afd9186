//! Causality of rows, and how tables declare dependencies, for access, descriptions and `check`.

/// In a list of initial dependencies: every parameter of the model.
pub const ALL_PARAMETERS: &str = "*parameters";

/// In a list of dependencies, for Model Exchange: the variable depends on no state. A list that
/// names no state otherwise means all states.
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
    /// Not declared: on everything.
    Unknown,
    /// The same list for each element (`[i]`: same index).
    Same(&'static [&'static str]),
    /// Initially: on the same as at communication points, and on these.
    Also(&'static [&'static str]),
    /// A list for each element.
    Each(&'static [&'static [&'static str]]),
}
