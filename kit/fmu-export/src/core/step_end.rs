//! The result of a step, which a model's `step` returns and the instance checks.

/// The result of a model's step: how far it went, and why it ended there.
///
/// Usually [`StepEnd::WHOLE`]; else a copy of it with another field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StepEnd {
    /// Time reached, s from the start of the step; None: the whole step.
    pub reached: Option<f64>,
    /// An event occurred that the importer may want to handle before the next step.
    pub event: bool,
    /// The model asks to end the simulation there.
    pub terminate: bool,
}

impl StepEnd {
    /// The whole step, without an event.
    pub const WHOLE: Self = Self {
        reached: None,
        event: false,
        terminate: false,
    };
}
