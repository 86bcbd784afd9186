//! One instance of an FMU: its life from fmi2Instantiate to fmi2FreeInstance.

use crate::calls::Mode;
use crate::failure::{Failure, refuse};
use crate::ffi::Status;
use crate::layout::Layout;
use crate::log::{Category, Log};
use crate::{Evaluation, InputPolynomial, Model, ModelError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ffi::CString;
use std::path::PathBuf;

/// All that an importer's `fmi2Component` points at.
pub(crate) struct Instance<M: Model> {
    pub(crate) log: Log,
    pub(crate) layout: Layout<M>,
    pub(crate) guid: uuid::Uuid,
    pub(crate) resources: Option<PathBuf>,
    /// A panic happened: nothing of `state` can be trusted.
    pub(crate) poisoned: bool,
    pub(crate) state: State<M>,
    /// Of `state` and the current inputs, once something has needed it.
    pub(crate) evaluation: Option<M::Evaluation>,
    /// Outputs of `state`, valid while `fresh`.
    pub(crate) output: M::Output,
    pub(crate) fresh: bool,
    /// How the last fmi2DoStep ended.
    pub(crate) last_step: Status,
    /// Saved states by the handle the importer has (the address of the box, never followed).
    pub(crate) saved: BTreeMap<usize, Box<State<M>>>,
    /// Texts the importer was given by the last fmi2GetString.
    pub(crate) strings: Vec<CString>,
}

/// All that fmi2GetFMUstate saves.
#[derive(Clone, Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct State<M: Model> {
    pub(crate) mode: Mode,
    /// Start time, s.
    pub(crate) start: f64,
    /// Time that must not be passed, s.
    pub(crate) stop: Option<f64>,
    /// Time of the last communication point, s: the importer's own number plus one step, so that no rounding adds up.
    pub(crate) time: f64,
    pub(crate) parameters: M::Parameters,
    /// By value reference: whether the importer has set this parameter.
    pub(crate) explicit: Vec<bool>,
    /// Inputs as they were set, and their derivatives for the next step.
    pub(crate) input: InputPolynomial<M::Input>,
    /// Where the derivatives of earlier steps have taken them; None while each input is what was set.
    pub(crate) reached: Option<Reached<M::Input>>,
    /// None until initialized, and in Initialization Mode after something was set.
    pub(crate) model: Option<M>,
}

/// The inputs at the end of a step with derivatives: held there until each is set again.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Reached<I> {
    pub(crate) value: I,
    /// First derivative there; zero for what is held or was set since.
    pub(crate) slope: I,
}

impl<M: Model> State<M> {
    /// The inputs that act now.
    #[inline]
    pub(crate) fn input(&self) -> &M::Input {
        match &self.reached {
            Some(reached) => &reached.value,
            None => &self.input.value,
        }
    }

    fn instantiated(elements: usize) -> Self {
        let (parameters, input) = M::defaults();
        Self {
            mode: Mode::Instantiated,
            start: 0.0,
            stop: None,
            time: 0.0,
            parameters,
            explicit: vec![false; elements],
            input: InputPolynomial::held(input),
            reached: None,
            model: None,
        }
    }

    /// Whether a deserialized state could have come from this layer.
    pub(crate) fn is_sound(&self, elements: usize) -> bool {
        let initialized = matches!(self.mode, Mode::StepComplete | Mode::Terminated);
        self.explicit.len() == elements
            && self.time.is_finite()
            && self.input.order <= crate::MAX_INPUT_DERIVATIVE
            && (self.model.is_some() || !initialized)
    }
}

impl<M: Model> Instance<M> {
    pub(crate) fn new(
        log: Log,
        layout: Layout<M>,
        guid: uuid::Uuid,
        resources: Option<PathBuf>,
    ) -> Self {
        Self {
            log,
            guid,
            resources,
            poisoned: false,
            state: State::instantiated(layout.len()),
            layout,
            evaluation: None,
            output: M::Output::default(),
            fresh: false,
            last_step: Status::Ok,
            saved: BTreeMap::new(),
            strings: Vec::new(),
        }
    }

    pub(crate) fn setup_experiment(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Result<(), Failure> {
        if let Some(tolerance) = tolerance
            && !(tolerance.is_finite() && tolerance > 0.0)
        {
            return refuse!("tolerance = {tolerance}; allowed are finite values > 0");
        }
        if !start.is_finite() {
            return refuse!("startTime = {start}; allowed are finite values");
        }
        if let Some(stop) = stop
            && !(stop.is_finite() && stop >= start)
        {
            return refuse!("stopTime = {stop}; allowed are finite values ≥ startTime = {start}");
        }
        self.state.start = start;
        self.state.time = start;
        self.state.stop = stop;
        Ok(())
    }

    pub(crate) fn enter_initialization(&mut self) -> Result<(), Failure> {
        self.state.mode = Mode::Initialization;
        Ok(())
    }

    pub(crate) fn exit_initialization(&mut self) -> Result<(), Failure> {
        self.model()?;
        self.state.mode = Mode::StepComplete;
        self.log.send(Category::Events, "initialized");
        Ok(())
    }

    pub(crate) fn terminate(&mut self) -> Result<(), Failure> {
        self.state.mode = Mode::Terminated;
        self.log.send(Category::Events, "terminated");
        Ok(())
    }

    pub(crate) fn reset(&mut self) -> Result<(), Failure> {
        self.replace(State::instantiated(self.layout.len()));
        self.log
            .send(Category::Events, "reset to the state after instantiation");
        Ok(())
    }

    /// Puts another state in place of the present one.
    pub(crate) fn replace(&mut self, state: State<M>) {
        self.state = state;
        self.evaluation = None;
        self.fresh = false;
        self.last_step = Status::Ok;
    }

    /// Marks what was computed from parameters and inputs as out of date: the outputs, and the evaluation if it has read them.
    #[inline]
    pub(crate) fn touch(&mut self, is_evaluated: bool) {
        self.fresh = false;
        let is_initial = self.state.mode == Mode::Initialization;
        if is_initial {
            self.state.model = None;
        }
        if is_evaluated || is_initial {
            self.evaluation = None;
        }
    }

    /// Makes the model if there is none: in Initialization Mode when it is first needed.
    pub(crate) fn model(&mut self) -> Result<(), ModelError> {
        let state = &mut self.state;
        if state.model.is_none() {
            let mut new = M::initialize(&state.parameters, &state.input.value, state.start)?;
            warn(&self.log, &mut new);
            state.model = Some(new);
            self.evaluation = None;
        }
        Ok(())
    }

    /// Makes `evaluation` if it is out of date.
    #[inline]
    pub(crate) fn evaluate(&mut self) -> Result<(), ModelError> {
        if self.evaluation.is_none() {
            self.model()?;
            let state = &self.state;
            let model = state.model.as_ref().expect("made above");
            self.evaluation = Some(M::Evaluation::of(model, &state.parameters, state.input())?);
        }
        Ok(())
    }

    /// What [`evaluate`](Self::evaluate) has made.
    #[inline]
    pub(crate) fn evaluated(&self) -> (&M, &M::Evaluation) {
        match (&self.state.model, &self.evaluation) {
            (Some(model), Some(now)) => (model, now),
            _ => unreachable!("`evaluate` comes first"),
        }
    }

    /// Makes `output` agree with the state and the current inputs.
    #[inline]
    pub(crate) fn refresh(&mut self) -> Result<(), Failure> {
        if !self.fresh {
            self.evaluate()?;
            let (model, now) = self.evaluated();
            self.output = model.output(&self.state.parameters, self.state.input(), now)?;
            self.fresh = true;
        }
        Ok(())
    }
}

/// Logs what the model has to warn of.
#[inline]
pub(crate) fn warn<M: Model>(log: &Log, model: &mut M) {
    if let Some(warning) = model.take_warning() {
        log.send(Category::Warning, &warning);
    }
}
