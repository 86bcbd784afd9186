//! One instance of a model, which `fmi2` and `fmi3` wrap for the importer: its state, the outputs
//! computed from it, and their invalidation when something is set.

use super::equation_cache::EquationCache;
use super::fault::{Fault, refuse};
use super::layout::Layout;
use super::log::LogFilter;
use super::message::{Kind, Message};
use super::phase::Phase;
use super::sizes;
use super::solver_workspace::SolverWorkspace;
use super::state::{Identity, State};
use super::storage::TypeNames;
use crate::{Evaluation, Model, ModelError};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// An instance, without what the C interface adds.
pub(crate) struct Instance<M: Model> {
    pub(crate) layout: Layout<M>,
    /// Identifies the FMU and version that a saved state belongs to.
    pub(crate) identity: Identity,
    /// The names of the types in the version of FMI.
    pub(crate) names: &'static TypeNames,
    pub(crate) resources: Option<PathBuf>,
    /// A panic happened: `state` cannot be trusted until it is replaced.
    pub(crate) lost: bool,
    pub(crate) state: State<M>,
    /// Start values of the parameters.
    pub(crate) start: M::Parameters,
    /// Files in the resources folder that count before what is compiled in, by the names of their
    /// String parameters, and the start values with them.
    pub(crate) packed_texts: BTreeMap<&'static str, String>,
    pub(crate) packed_start: Option<M::Parameters>,
    /// The sizes that the FMU was packed with.
    pub(crate) sizes: &'static str,
    /// The evaluation of `state` and the current inputs, if it is up to date.
    pub(crate) evaluation: Option<M::Evaluation>,
    /// Outputs of `state` and the current inputs, if `output_is_valid`.
    pub(crate) output: M::Output,
    pub(crate) output_is_valid: bool,
    /// Workspace of the model's solver.
    pub(crate) workspace: SolverWorkspace<M, M::Input>,
    /// Derivatives and event indicators, for Model Exchange.
    pub(crate) equation_cache: EquationCache<M>,
    /// Saved states by handle.
    pub(crate) saved: BTreeMap<usize, Box<State<M>>>,
    /// Messages that were not sent yet.
    pub(crate) messages: Vec<Message>,
    /// Which of the model's messages the importer has enabled.
    pub(crate) log_filter: LogFilter,
    /// The importer was warned that input derivatives of a high order are ignored.
    pub(crate) has_warned_of_order: bool,
}

impl<M: Model> Instance<M> {
    /// With the model's default values.
    pub(crate) fn new(
        layout: Layout<M>,
        (start, input): (M::Parameters, M::Input),
        identity: Identity,
        names: &'static TypeNames,
        resources: Option<PathBuf>,
        sizes: &'static str,
    ) -> Self {
        Self {
            identity,
            names,
            resources,
            lost: false,
            state: State::instantiated(start.clone(), input, layout.slots()),
            output: sizes::output::<M>(&start),
            start,
            packed_texts: BTreeMap::new(),
            packed_start: None,
            layout,
            sizes,
            evaluation: None,
            output_is_valid: false,
            workspace: SolverWorkspace::default(),
            equation_cache: EquationCache::default(),
            saved: BTreeMap::new(),
            messages: Vec::new(),
            log_filter: LogFilter::default(),
            has_warned_of_order: false,
        }
    }

    /// Queues a message.
    pub(crate) fn report(&mut self, kind: Kind, text: impl Into<String>) {
        self.messages.push(Message::new(kind, text));
    }

    /// Sets start and stop time, s, and the tolerance. A stop time of +infinity means none. The
    /// tolerance is ignored for models whose solver has none.
    pub(crate) fn set_experiment(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Result<(), Fault> {
        let tolerance = tolerance.filter(|_| M::INFO.tolerance.is_some());
        if let Some(tolerance) = tolerance.filter(|&t| !(t > 0.0 && t < 1.0)) {
            return refuse!("tolerance = {tolerance} must be above 0 and below 1");
        }
        if !start.is_finite() {
            return refuse!("start time = {start} s must be finite");
        }
        let stop = stop.filter(|&stop| stop != f64::INFINITY);
        if let Some(stop) = stop
            && !(stop.is_finite() && stop >= start)
        {
            return refuse!("stop time = {stop} s must be at least the start time = {start} s");
        }
        self.state.start = start;
        self.state.time = start;
        self.state.event = start;
        self.state.stop = stop;
        self.state.tolerance = tolerance;
        Ok(())
    }

    /// Changes the phase, which the call order allows.
    pub(crate) fn enter(&mut self, phase: Phase) -> Result<(), Fault> {
        self.state.phase = phase;
        Ok(())
    }

    /// Ends Initialization Mode; `has_event_mode`: the importer handles the first event.
    pub(crate) fn exit_initialization(&mut self, has_event_mode: bool) -> Result<(), Fault> {
        self.model()?;
        if M::EVENTS.is_some() && !has_event_mode {
            self.first_event()?;
        }
        self.state.phase = Phase::Stepping;
        self.report(Kind::Event, "initialized");
        Ok(())
    }

    pub(crate) fn terminate(&mut self) {
        self.state.phase = Phase::Terminated;
        self.report(Kind::Event, "terminated");
    }

    pub(crate) fn reset(&mut self) {
        let (mut start, input) = sizes::start::<M>(self.sizes).expect("as when it was made");
        if let Some(packed) = &self.packed_start {
            start.clone_from(packed);
        }
        let slots = Layout::<M>::new(&start, &input).slots();
        self.replace(State::instantiated(start, input, slots));
        self.report(Kind::Event, "reset to the state after instantiation");
    }

    /// A copy of the state, to be restored if the second of two changes fails.
    #[cold]
    pub(crate) fn snapshot(&self) -> State<M> {
        let mut state = self.state.clone();
        state.first = self.workspace.first;
        state
    }

    /// Replaces the state.
    pub(crate) fn replace(&mut self, state: State<M>) {
        self.state = state;
        self.adopt_state();
    }

    /// Adapts the rest of the instance after the state was replaced.
    pub(crate) fn adopt_state(&mut self) {
        self.workspace.first = self.state.first;
        if self.layout.has_vectors() && !self.has_sizes(&self.state.parameters) {
            self.follow_sizes();
        }
        self.invalidate();
        self.lost = false;
    }

    /// Marks everything computed from the state as out of date.
    #[inline(always)]
    pub(crate) fn invalidate(&mut self) {
        self.evaluation = None;
        self.output_is_valid = false;
        self.equation_cache.invalidate();
    }

    /// Marks everything computed from parameters and inputs as out of date: the outputs, and the
    /// evaluation if it depends on them (`is_evaluated`).
    #[inline]
    pub(crate) fn invalidate_inputs(&mut self, is_evaluated: bool) {
        self.output_is_valid = false;
        self.equation_cache.invalidate();
        let is_initializing = self.state.phase == Phase::Initialization;
        if M::EVENTS.is_some() && matches!(self.state.phase, Phase::Stepping | Phase::Exchange) {
            self.state.event = f64::NEG_INFINITY;
        }
        if is_evaluated || is_initializing {
            self.evaluation = None;
        }
        if is_initializing {
            self.state.model = None;
        }
    }

    /// Initializes the model if that is not done yet: in Initialization Mode, when first needed.
    pub(crate) fn model(&mut self) -> Result<(), ModelError> {
        let state = &mut self.state;
        if state.model.is_none() {
            let mut new = M::initialize(&state.parameters, &state.input.value, state.start)?;
            collect_messages(&mut self.messages, &mut new);
            state.model = Some(new);
            self.evaluation = None;
        }
        Ok(())
    }

    /// Computes `evaluation` if it is out of date.
    #[inline]
    pub(crate) fn evaluate(&mut self) -> Result<(), ModelError> {
        if self.evaluation.is_none() {
            self.model()?;
            let state = &self.state;
            let model = state.model.as_ref().expect("made above");
            self.evaluation = Some(M::Evaluation::new(model, &state.parameters, state.input())?);
        }
        Ok(())
    }

    /// The model and the evaluation, after [`evaluate`](Self::evaluate).
    #[inline]
    pub(crate) fn evaluated(&self) -> (&M, &M::Evaluation) {
        match (&self.state.model, &self.evaluation) {
            (Some(model), Some(now)) => (model, now),
            _ => unreachable!("`evaluate` comes first"),
        }
    }

    /// Recomputes `output` from the state and the current inputs, if it is out of date.
    #[inline]
    pub(crate) fn update_output(&mut self) -> Result<(), ModelError> {
        if !self.output_is_valid {
            self.evaluate()?;
            let (Some(model), Some(now)) = (&self.state.model, &self.evaluation) else {
                unreachable!("`evaluate` comes first");
            };
            let (p, u) = (&self.state.parameters, self.state.input());
            model.output_into(p, u, now, &mut self.output)?;
            self.output_is_valid = true;
        }
        Ok(())
    }
}

/// Before a call of the model: passes the importer's enabled categories to the model's log.
#[inline]
pub(crate) fn set_log_filter<M: Model>(filter: LogFilter, model: &mut M) {
    if let Some(log) = model.log() {
        log.prepare(filter, M::INFO.log_categories);
    }
}

/// Queues the messages in the model's log.
#[inline]
pub(crate) fn collect_log<M: Model>(messages: &mut Vec<Message>, model: &mut M) {
    if let Some(log) = model.log() {
        log.empty_into(messages);
    }
}

/// Queues the model's warning, if there is one, and the messages in its log.
#[inline]
pub(crate) fn collect_messages<M: Model>(messages: &mut Vec<Message>, model: &mut M) {
    if let Some(warning) = model.take_warning() {
        messages.push(Message::new(Kind::Warning, warning));
    }
    collect_log(messages, model);
}
