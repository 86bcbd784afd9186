//! The state of an instance (all that a saved state holds), for steps, access and `saved`.

use super::input::{InputPolynomial, MAX_INPUT_DERIVATIVE};
use super::layout::Layout;
use super::model::{Model, zeros};
use super::phase::Phase;
use serde::{Deserialize, Serialize};

/// The state of an instance, which is also what a saved state holds.
#[derive(Clone, Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct State<M: Model> {
    pub(crate) phase: Phase,
    /// Start time, s.
    pub(crate) start: f64,
    /// Stop time, s.
    pub(crate) stop: Option<f64>,
    /// Time of the last communication point, s: the importer's own number plus one step, so that
    /// rounding errors do not add up.
    pub(crate) time: f64,
    /// For Model Exchange the time of the last event, for Co-Simulation that of the next time event,
    /// s: [`SolverWorkspace::next_event`](super::solver_workspace::SolverWorkspace::next_event).
    pub(crate) event: f64,
    /// The internal step that the solver tries first, s; 0 if not known.
    pub(crate) first: f64,
    /// The tolerance that the importer has given.
    pub(crate) tolerance: Option<f64>,
    pub(crate) parameters: M::Parameters,
    /// How the importer has set each parameter, by [`Layout::slot`].
    pub(crate) settings: Vec<Setting>,
    /// Inputs as they were set, and their derivatives for the next step.
    pub(crate) input: InputPolynomial<M::Input>,
    /// The inputs to which derivatives in earlier steps have led; None if each has its set value.
    pub(crate) held_input: Option<HeldInput<M::Input>>,
    /// None until initialization, and in Initialization Mode after something was set.
    pub(crate) model: Option<M>,
}

/// The inputs at the end of a step with derivatives: held there until each is set again.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct HeldInput<I> {
    pub(crate) value: I,
    /// First derivative there; zero for what is held or was set since.
    pub(crate) slope: I,
}

impl<M: Model> State<M> {
    /// The present inputs.
    #[inline]
    pub(crate) fn input(&self) -> &M::Input {
        match &self.held_input {
            Some(held) => &held.value,
            None => &self.input.value,
        }
    }

    /// Becomes a copy of another state, without allocation for vectors of the same length.
    pub(crate) fn copy(&mut self, from: &Self) {
        let Self {
            phase,
            start,
            stop,
            time,
            event,
            first,
            tolerance,
            parameters,
            settings,
            input,
            held_input,
            model,
        } = from;
        (self.phase, self.start, self.stop) = (*phase, *start, *stop);
        (self.time, self.event) = (*time, *event);
        (self.first, self.tolerance) = (*first, *tolerance);
        self.parameters.clone_from(parameters);
        self.settings.clone_from(settings);
        self.input.value.clone_from(&input.value);
        self.input.derivatives.clone_from(&input.derivatives);
        self.input.order = input.order;
        self.held_input.clone_from(held_input);
        self.model.clone_from(model);
    }

    pub(crate) fn instantiated(parameters: M::Parameters, input: M::Input, slots: usize) -> Self {
        Self {
            phase: Phase::Instantiated,
            start: 0.0,
            stop: None,
            time: 0.0,
            event: 0.0,
            first: 0.0,
            tolerance: None,
            parameters,
            settings: vec![Setting::Nothing; slots],
            input: InputPolynomial {
                derivatives: zeros::<M>(&input),
                value: input,
                order: 0,
            },
            held_input: None,
            model: None,
        }
    }

    /// Whether a deserialized state is consistent.
    pub(crate) fn is_sound(&self) -> bool {
        let layout = Layout::<M>::new(&self.parameters, &self.input.value);
        let initialized = self.phase.is_running() || self.phase == Phase::Terminated;
        let held = self.held_input.iter().flat_map(|r| [&r.value, &r.slope]);
        let inputs = self.input.derivatives.iter().chain([&self.input.value]);
        inputs.chain(held).all(|u| layout.fits(&self.parameters, u))
            && self.settings.len() == layout.slots()
            && self.time.is_finite()
            && !self.event.is_nan()
            && self.first.is_finite()
            && self
                .tolerance
                .is_none_or(|tolerance| tolerance > 0.0 && tolerance < 1.0)
            && self.input.order <= MAX_INPUT_DERIVATIVE
            && (self.model.is_some() || !initialized)
    }
}

/// How the importer has set a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Setting {
    Nothing,
    /// Its start value, before the end of initialization.
    Start,
    Explicit,
}

/// Identifies the FMU and the version of FMI that saved states belong to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Identity {
    /// Name of the version of FMI, padded with zeros.
    pub(crate) version: [u8; 4],
    /// Hash of the model.
    pub(crate) model: [u8; 16],
}
