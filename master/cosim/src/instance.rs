//! An FMU instance that the master and the studies call, in this thread or another. Errors of its
//! calls name the instance, the time, the variables and the reasons that the FMU logged.

mod configuration;
mod errors;
pub(crate) mod finite;
#[cfg(feature = "native")]
mod queue;
#[cfg(feature = "native")]
mod remote;
pub(crate) mod step_calls;
#[cfg_attr(not(feature = "native"), path = "instance/workers_of_module.rs")]
pub(crate) mod workers;

use std::any::Any;
use std::ffi::{CStr, CString};
use std::sync::Arc;

use anyhow::{Context, Error, Result, anyhow, bail, ensure};
use fmi_description::{Causality, Description};
use fmi_import::answer::Answer;
pub use fmi_import::answer::{At, Ended, Stopped};
use fmi_import::batch::Batch;
use fmi_import::fmi_instance::{Arguments, FmiInstance, Integration};
pub(crate) use fmi_import::fmi_instance::{BegunCall, Call};
pub use fmi_import::log::receive;
pub use fmi_import::messages;
use fmi_import::status;
pub use fmi_import::under_way;
use fmi_import::value::{Value, fits};

use crate::fmu::Fmu;
use step_calls::{FailedCall, StepCalls};
use workers::Worker;

/// An FMU instance. The owner terminates it; it is freed when dropped.
pub struct Instance {
    fmi: Box<dyn FmiInstance>,
    fmu: Arc<Fmu>,
    pub(crate) name: String,
    /// It enters Event Mode.
    pub(crate) has_events: bool,
    /// Made for schedules that read outputs again after inputs were set.
    pub(crate) is_staged: bool,
    is_elsewhere: bool,
    /// The worker in whose thread it runs, and its number there.
    host: Option<(Worker, usize)>,
    /// Variables that may have values that are not finite, in order.
    nonfinite: Vec<usize>,
}

/// The first error, in the order of components, of calls made in several threads: all calls that
/// were begun are ended even if one fails.
#[derive(Default)]
pub(crate) struct Failure(Option<(usize, anyhow::Error)>);

impl Failure {
    /// Adds the result of a component's call.
    pub fn add(&mut self, component: usize, done: Result<()>) {
        if let Err(error) = done
            && self.0.as_ref().is_none_or(|(first, _)| component < *first)
        {
            self.0 = Some((component, error));
        }
    }
}

impl From<Failure> for Result<()> {
    fn from(failure: Failure) -> Self {
        failure.0.map_or(Ok(()), |(_, error)| Err(error))
    }
}

/// Makes a call of all these instances, in parallel if they are in several threads; returns the
/// largest answer.
pub(crate) fn all<'a>(
    mut instances: impl Iterator<Item = &'a Instance> + Clone,
    call: Call,
    at: At,
) -> Result<f64> {
    let mut largest = 0.0_f64;
    let mut make = |instance: &Instance| {
        largest = largest.max(instance.call(call, at)?);
        Ok(())
    };
    if instances.clone().any(Instance::is_elsewhere) {
        let mut failure = Failure::default();
        (instances.clone()).for_each(|instance| instance.begin(BegunCall::Plain(call)));
        for (k, instance) in instances.enumerate() {
            failure.add(k, make(instance));
        }
        Result::from(failure)?;
    } else {
        instances.try_for_each(make)?;
    }
    Ok(largest)
}

/// A saved state of an instance.
pub struct State(Box<dyn Any>);

impl Instance {
    /// Creates the instance `name` of `fmu`. Errors that it logs later become part of error texts.
    ///
    /// With `is_staged` an output may be read after an input was set at the same communication
    /// point. FMI 2.0 leaves that to the FMU; FMI 3.0 allows it only in Event Mode, which the
    /// instance then enters if its FMU has one. Otherwise it enters Event Mode only for clocks and
    /// discrete inputs.
    pub fn new(fmu: &Arc<Fmu>, name: &str, is_staged: bool) -> Result<Self> {
        Self::in_thread(None, fmu, name, is_staged, true)
    }

    /// The same in a worker's thread, if one is given, unless its FMU is isolated; it `may_return`
    /// early from a step.
    pub(crate) fn in_thread(
        worker: Option<&Worker>,
        fmu: &Arc<Fmu>,
        name: &str,
        is_staged: bool,
        may_return: bool,
    ) -> Result<Self> {
        let c_string = |text: &str| {
            CString::new(text).map_err(|_| anyhow!("{name}: `{text}` has a NUL character"))
        };
        let description = &fmu.description;
        let has_events =
            description.capabilities.event_mode && (is_staged || description.needs_events());
        let mut arguments = Arguments {
            name: c_string(name)?,
            token: c_string(&description.guid)?,
            resources: fmu.loaded.resources.clone(),
            has_events,
            // Of an FMU without the categories of the standard all would be logged: that costs time.
            is_logging: !warnings_of(description).is_empty(),
            returns_early: may_return && has_events && description.capabilities.variable_step,
        };
        if let Some(clock) = fmu.plan.clocks.first().filter(|_| !has_events) {
            bail!(
                "{name}: FMU `{}` has the clock `{}` but no Event Mode, in which alone it could tick",
                fmu.file,
                clock.name
            );
        }
        fmu.register(name)?;
        let make = |arguments: &Arguments| match worker {
            _ if let Some(limits) = fmu.isolation => fmu.make_isolated(arguments, limits),
            None => fmu.make(&fmu.loaded.functions, arguments),
            #[cfg(feature = "native")]
            Some(worker) => remote::make(worker, fmu, arguments),
            #[cfg(not(feature = "native"))]
            Some(worker) => match *worker {},
        };
        let mut made = make(&arguments);
        if matches!(made, Ok(None)) && !arguments.is_logging {
            // Once more, so that it may say why.
            arguments.is_logging = true;
            made = make(&arguments);
        }
        let fmi = match made {
            Ok(Some(fmi)) => fmi,
            Ok(None) | Err(_) => {
                fmu.unregister();
                made.with_context(|| format!("{name}: FMU `{}`", fmu.file))?;
                let tool = match description.capabilities.needs_execution_tool {
                    true => "; it says that it needs its tool (needsExecutionTool)",
                    false => "",
                };
                let reasons = messages::reasons(name).into_iter();
                let reasons: String = reasons.map(|reason| format!("\n  {reason}")).collect();
                bail!(
                    "{name}: FMU `{}` could not be instantiated{tool}{reasons}",
                    fmu.file
                );
            }
        };
        let instance = Self {
            fmi,
            fmu: fmu.clone(),
            name: name.to_string(),
            has_events,
            is_staged,
            is_elsewhere: worker.is_some() || fmu.isolation.is_some(),
            host: worker
                .filter(|_| fmu.isolation.is_none())
                .map(|worker| (worker.clone(), worker.last())),
            nonfinite: Vec::new(),
        };
        instance.log_only_warnings()?;
        instance.configure()?;
        Ok(instance)
    }

    /// The FMU it is an instance of.
    pub fn fmu(&self) -> &Arc<Fmu> {
        &self.fmu
    }

    /// Whether it runs in another thread or process.
    pub(crate) fn is_elsewhere(&self) -> bool {
        self.is_elsewhere
    }

    /// The worker in whose thread it runs, and its number there.
    pub(crate) fn host(&self) -> Option<&(Worker, usize)> {
        self.host.as_ref()
    }

    /// Makes the calls of a step, in the thread of the caller.
    pub(crate) fn make_step(
        &self,
        calls: &StepCalls,
        values: &mut [f64],
        time: [f64; 2],
    ) -> Result<(), FailedCall> {
        calls.make(&*self.fmi, values, time)
    }

    /// Begins a call, if it runs in another thread or process.
    pub(crate) fn begin(&self, ahead: BegunCall) {
        self.fmi.begin(ahead);
    }

    /// Awaits all calls that are begun and drops their answers.
    pub(crate) fn drain(&self) {
        self.fmi.drain();
    }

    /// Turns on warnings and errors only, if the FMU has the standard categories: other messages
    /// cost time.
    fn log_only_warnings(&self) -> Result<()> {
        let chosen = warnings_of(&self.fmu.description);
        if chosen.is_empty() {
            return Ok(());
        }
        match self.fmi.log_only(&chosen) {
            Err(error) if Answer::status(&error) == Some(status::ABSENT) => Ok(()),
            done => self.check(done, None, At::Initialization),
        }
    }

    /// Set a variable of any type from text: a number, `true`/`false`, an enumeration item's name
    /// or number, a string, or bytes as hexadecimal digits.
    pub fn set_from_text(&self, variable: &str, text: &str) -> Result<()> {
        let description = &self.fmu.description;
        let v = description.variable(variable);
        let v = v.map_err(|e| anyhow!("{}: {e}", self.name))?;
        let value = Value::parse_for(v, text)
            .map_err(|unfit| anyhow!("{}.{variable}: `{text}` is not {unfit}", self.name))?;
        let index = description.index(variable).unwrap_or_default();
        if v.causality == Causality::StructuralParameter {
            return self.check_configuration(v, &value, text);
        }
        self.check_value(index, &value, text)?;
        let batch = self.fmu.any_batch(vec![index]);
        let set = self.fmi.set_values(&batch, &[value]);
        set.map_err(|error| match error.downcast::<Answer>() {
            Ok(answer) => {
                let names = format!("{} to `{text}` of {variable}", answer.call);
                self.refused(answer, &names, At::Initialization)
            }
            Err(error) => error.context(self.location(At::Initialization)),
        })
    }

    /// Value of a variable whose type is no number, by its index in the description.
    pub fn value(&self, variable: usize, at: At) -> Result<Value> {
        let batch = self.fmu.any_batch(vec![variable]);
        let mut value = Value::empty(batch.access);
        self.get_whole(&batch, std::slice::from_mut(&mut value), at)?;
        Ok(value)
    }

    /// Value of a numeric variable, by its index in the description; an integer, enumeration or
    /// boolean as a number.
    pub fn number(&self, variable: usize, at: At) -> Result<f64> {
        let mut value = [0.0];
        self.get(&self.fmu.batch(vec![variable])?, &mut value, at)?;
        Ok(value[0])
    }

    /// A call without values.
    pub(crate) fn call(&self, call: Call, at: At) -> Result<f64> {
        self.check(self.fmi.call(call), None, at)
    }

    /// Enters Initialization Mode, with the start time `start`, s.
    pub fn enter_initialization(&self, start: f64) -> Result<()> {
        (self.call(Call::EnterInitialization(start), At::Initialization)).map(drop)
    }

    /// Exits Initialization Mode.
    pub fn exit_initialization(&self) -> Result<()> {
        (self.call(Call::ExitInitialization, At::Initialization)).map(drop)
    }

    /// Read values, as numbers.
    pub fn get(&self, batch: &Batch, values: &mut [f64], at: At) -> Result<()> {
        self.check(self.fmi.get(batch, values), Some(batch), at)
    }

    /// Set values.
    pub fn set(&self, batch: &Batch, values: &[f64], at: At) -> Result<()> {
        self.check(self.fmi.set(batch, values), Some(batch), at)
    }

    /// Reads values of a type that is no number.
    pub fn get_whole(&self, batch: &Batch, values: &mut [Value], at: At) -> Result<()> {
        self.check(self.fmi.get_values(batch, values), Some(batch), at)
    }

    /// Set whole values.
    pub fn set_whole(&self, batch: &Batch, values: &[Value], at: At) -> Result<()> {
        let is_unfit = |value: &&Value| matches!(value, Value::Whole(k) if !fits(batch.access, *k));
        let done = match values.iter().find(is_unfit) {
            Some(_) => Answer::refuse(status::UNFIT, "set"),
            None => self.fmi.set_values(batch, values),
        };
        self.check(done, Some(batch), at)
    }

    /// First time derivatives of outputs, which must be finite.
    pub fn get_derivatives(&self, batch: &Batch, values: &mut [f64], at: At) -> Result<()> {
        self.check(self.fmi.get_derivatives(batch, values), Some(batch), at)?;
        self.check_derivatives(batch, values, at)
    }

    /// First time derivatives of inputs for the next step, which must be finite.
    pub fn set_derivatives(&self, batch: &Batch, values: &[f64], at: At) -> Result<()> {
        self.check_derivatives(batch, values, at)?;
        self.check(self.fmi.set_derivatives(batch, values), Some(batch), at)
    }

    /// Directional derivatives of Real outputs along `seeds` of Real inputs.
    pub(crate) fn directional(
        &self,
        of: [&Batch; 2],
        seeds: &[f64],
        rates: &mut [f64],
        at: At,
    ) -> Result<()> {
        self.check(self.fmi.directional(of, seeds, rates), Some(of[0]), at)
    }

    /// A communication step from `t` by `h`, both s.
    pub fn step(&self, t: f64, h: f64) -> Result<()> {
        match self.fmi.call(Call::Step(t, h)) {
            Ok(_) => Ok(()),
            Err(error) => Err(self.step_error(error, t)),
        }
    }

    /// The error of a step; as [`Stopped`], with the time if the FMU reports it, if the FMU ended
    /// the step early.
    #[cold]
    pub(crate) fn step_error(&self, error: Error, t: f64) -> Error {
        let is_discarded = Answer::status(&error) == Some(status::DISCARD);
        let is_stopped = is_discarded || error.is::<Stopped>();
        let error = self.error(error, None, At::Time(t));
        match is_stopped {
            true => error.context(Stopped {
                name: self.name.clone(),
                time: self.fmi.call(Call::Time).ok(),
            }),
            false => error,
        }
    }

    /// From now on a step that the FMU ends early returns [`Stopped`]; until then it is continued.
    pub(crate) fn stop_early(&self) {
        // If its thread has ended, the next call says so.
        let _ = self.fmi.call(Call::StopEarly(true));
    }

    /// The instance's own time, s: the end of its last successful step.
    pub fn time(&self) -> Result<f64> {
        (self.fmi.call(Call::Time)).with_context(|| self.name.clone())
    }

    /// When Event Mode must be entered next, s; infinite if unknown.
    pub fn next_event(&self) -> f64 {
        // If its thread has ended, the next call says so.
        (self.fmi.call(Call::NextEvent)).unwrap_or(f64::INFINITY)
    }

    /// What its integration took; None if it steps itself.
    pub(crate) fn integration(&self) -> Option<Integration> {
        // If its thread has ended, the run has told it.
        self.fmi.integration().ok().flatten()
    }

    /// Saves its state.
    pub fn save(&self, at: At) -> Result<State> {
        let can_save = self.fmu.description.capabilities.saves_state;
        self.require(can_save, "save its state", at)?;
        self.check(self.fmi.save(), None, at).map(State)
    }

    /// Restores a state of this instance.
    pub fn restore(&self, state: &State, at: At) -> Result<()> {
        self.check(self.fmi.restore(&*state.0), None, at)
    }

    /// The bytes of a saved state.
    pub fn state_to_bytes(&self, state: &State, at: At) -> Result<Vec<u8>> {
        let can_serialize = self.fmu.description.capabilities.serializes_state;
        self.require(can_serialize, "write its state as bytes", at)?;
        self.check(self.fmi.state_to_bytes(&*state.0), None, at)
    }

    fn require(&self, can: bool, what: &str, at: At) -> Result<()> {
        let (name, file) = (&self.name, &self.fmu.file);
        ensure!(can, "{name} (FMU `{file}`) cannot {what} ({at})");
        Ok(())
    }

    /// A state to be restored, from the bytes of an instance of the same FMU.
    pub fn state_from_bytes(&self, bytes: &[u8], at: At) -> Result<State> {
        (self.check(self.fmi.state_from_bytes(bytes), None, at)).map(State)
    }

    /// Resets it to where it was when it was made; false if that fails, so that another is needed.
    pub(crate) fn reset(&self) -> bool {
        self.fmi.reset() && self.log_only_warnings().is_ok()
    }
}

/// The standard log categories of warnings and errors that an FMU declares.
fn warnings_of(description: &Description) -> Vec<CString> {
    const CATEGORIES: [&CStr; 4] = [
        c"logStatusWarning",
        c"logStatusDiscard",
        c"logStatusError",
        c"logStatusFatal",
    ];
    let names = || description.log_categories.iter().map(String::as_bytes);
    let declared = CATEGORIES.into_iter();
    let declared = declared.filter(|c| names().any(|name| name == c.to_bytes()));
    declared.map(CStr::to_owned).collect()
}

impl Drop for Instance {
    fn drop(&mut self) {
        self.fmu.unregister();
    }
}
