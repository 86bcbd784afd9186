//! How far a model has gone in a step.

/// How far a model has gone in a step, and what happened there.
///
/// Nearly always [`StepEnd::WHOLE`]; else a copy of it with another field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StepEnd {
    /// Time reached, s after the start of the step; None: all of it.
    pub reached: Option<f64>,
    /// Something happened there that the importer may want to react to before it goes on.
    pub event: bool,
    /// The model wants the simulation to end there.
    pub terminate: bool,
}

impl StepEnd {
    /// The whole step, and nothing to tell of.
    pub const WHOLE: Self = Self {
        reached: None,
        event: false,
        terminate: false,
    };
}
