//! [`Instance`]: an instance that is called in the order of the standard, with its time and its
//! log, for programs that test FMUs (`fmu-check`, `torture`). It calls no functions for types of
//! which the FMU has no variable.
//!
//! ```
//! fn first_step(fmu: &fmi_import::Fmu) -> anyhow::Result<()> {
//!     fmi_import::Instance::started(fmu, "my instance")?.step(0.01)
//! }
//! ```

use std::ffi::{CString, c_int};
use std::ops::Deref;
use std::slice;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

use anyhow::{Result, anyhow};
use fmi_description::{Access, Variable};

use crate::fmu::Fmu;
use crate::log::{Log, Message};
use crate::names::with_fmi3_names;
use crate::raw::{Array, CallbackSet, Experiment, InstanceKind, RawInstance, Request, StepEnd};
use crate::standard::Mode;
use crate::status::{self, OK, WARNING};

/// Each [`Instance`] reads every variable by a call of its own, and before each says on standard
/// error which variable is read or set, after [`SAID`]: so a crash can be traced.
pub static ONE_BY_ONE: AtomicBool = AtomicBool::new(false);
/// See [`ONE_BY_ONE`].
pub const SAID: &str = "variable: ";

/// How an instance is made, and how strictly its statuses are judged.
#[derive(Clone, Copy, Debug)]
pub struct InstanceOptions<'a> {
    /// GUID or instantiation token; None passes that of the description.
    pub token: Option<&'a str>,
    /// Interface that is instantiated.
    pub kind: InstanceKind,
    /// loggingOn.
    pub is_logging: bool,
    /// It is passed functions for memory (FMI 2.0).
    pub gives_memory: bool,
    /// A call that must succeed may return Warning.
    pub may_warn: bool,
    /// Event Mode of FMI 3.0 is used, where the FMU has it.
    pub event_mode: bool,
}

impl InstanceOptions<'_> {
    /// As most importers make instances.
    pub const USUAL: Self = Self {
        token: None,
        kind: InstanceKind::CoSimulation,
        is_logging: false,
        gives_memory: true,
        may_warn: true,
        event_mode: true,
    };
    /// As FMUs made with fmu-export allow: no functions for memory, and no warnings from calls.
    pub const STRICT: Self = Self {
        gives_memory: false,
        may_warn: false,
        ..Self::USUAL
    };
}

/// A live instance; freed when dropped. It dereferences to a [`RawInstance`] for single C
/// functions.
pub struct Instance<'a> {
    /// Its FMU.
    pub fmu: &'a Fmu,
    raw: RawInstance,
    /// instanceName.
    pub name: String,
    /// Time of the last communication point, s.
    pub time: f64,
    /// What fmi2SetupExperiment was passed.
    experiment: Experiment,
    /// It stays in Event Mode between steps, where FMI 3.0 allows a get after a set.
    in_events: bool,
    has_events: bool,
    may_warn: bool,
}

impl Deref for Instance<'_> {
    type Target = RawInstance;

    fn deref(&self) -> &RawInstance {
        &self.raw
    }
}

impl<'a> Instance<'a> {
    /// Makes an instance as most importers do (fmi2Instantiate).
    pub fn new(fmu: &'a Fmu, name: &str) -> Result<Self> {
        Self::with_options(fmu, name, InstanceOptions::USUAL)
    }

    /// Makes an instance (fmi2Instantiate).
    pub fn with_options(fmu: &'a Fmu, name: &str, options: InstanceOptions) -> Result<Self> {
        let token = options.token.unwrap_or(&fmu.description.guid);
        let [c_name, token] = [name, token].map(|s| CString::new(s).expect("no NUL in names"));
        let request = Request {
            kind: options.kind,
            name: Some(&c_name),
            token: Some(&token),
            resources: (!fmu.resources.is_empty()).then_some(&fmu.resources),
            is_logging: options.is_logging,
            has_events: options.event_mode && fmu.functions.has_event_mode(),
            returns_early: false,
            given: match options.gives_memory {
                true => CallbackSet::LoggerAndMemory,
                false => CallbackSet::Logger,
            },
        };
        let made = RawInstance::new(&fmu.functions, &request, Log::new(name));
        Ok(Self {
            fmu,
            raw: made.map_err(|messages| {
                let call = fmu.functions.name("fmi2Instantiate");
                anyhow!("{call} gave NULL{}", last_message(&messages))
            })?,
            name: name.to_string(),
            time: 0.0,
            experiment: Experiment::default(),
            in_events: false,
            has_events: options.event_mode && fmu.functions.has_event_mode(),
            may_warn: options.may_warn,
        })
    }

    /// Makes an instance and initializes it, with the start values.
    pub fn started(fmu: &'a Fmu, name: &str) -> Result<Self> {
        let mut instance = Self::new(fmu, name)?;
        instance.initialize()?;
        Ok(instance)
    }

    /// Makes an instance and enters Initialization Mode, at the default start time.
    pub fn initializing(fmu: &'a Fmu, name: &str) -> Result<Self> {
        let mut instance = Self::new(fmu, name)?;
        instance.setup(start_time(fmu), None)?;
        instance.enter(Mode::Initialization)?;
        Ok(instance)
    }

    /// Makes an instance in a state in which values may be read after others were set: at the first
    /// communication point, or in Initialization Mode if FMI 3.0 forbids it there.
    pub fn readable_after_set(fmu: &'a Fmu, name: &str) -> Result<Self> {
        match fmu.functions.reads_after_set() {
            true => Self::started(fmu, name),
            false => Self::initializing(fmu, name),
        }
    }

    /// Messages since the last call of this function.
    pub fn messages(&self) -> Vec<Message> {
        self.raw.log().take()
    }

    /// Fails unless the status is OK, or Warning where that is allowed. `call` is named in the
    /// error, by its name in the FMU's version of FMI.
    pub fn must(&self, call: &str, status: c_int) -> Result<()> {
        match status {
            OK => Ok(()),
            WARNING if self.may_warn => Ok(()),
            _ => {
                let mut failed = format!("{call} gave {}", status::name(status));
                if self.fmu.functions.is_fmi3() {
                    failed = with_fmi3_names(&failed);
                }
                Err(anyhow!("{failed}{}", last_message(&self.messages())))
            }
        }
    }

    /// Calls a function that must succeed.
    pub fn done(&self, name: &str, call: impl FnOnce(&RawInstance) -> c_int) -> Result<()> {
        self.must(name, call(&self.raw))
    }

    /// Initializes: from Instantiated to the first communication point, at the default start time.
    pub fn initialize(&mut self) -> Result<()> {
        self.initialize_between(start_time(self.fmu), None)
    }

    /// Initializes for a run from `start` to `stop`, s.
    pub fn initialize_between(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        self.setup(start, stop)?;
        self.enter(Mode::Initialization)?;
        self.enter(Mode::Stepping)
    }

    /// Sets up a run from `start` to `stop`, s (fmi2SetupExperiment).
    pub fn setup(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        self.experiment = Experiment {
            start,
            has_stop: stop.is_some(),
            stop: stop.unwrap_or(0.0),
            ..Experiment::default()
        };
        let status = self.raw.setup_experiment(self.experiment);
        self.time = start;
        self.must("fmi2SetupExperiment", status)
    }

    /// Makes the call that leads from the present mode to the next one.
    pub fn enter(&mut self, mode: Mode) -> Result<()> {
        let raw = &self.raw;
        let (name, status) = match mode {
            Mode::Instantiated => ("fmi2Reset", raw.reset()),
            Mode::Initialization => {
                let status = raw.enter_initialization_mode(self.experiment);
                ("fmi2EnterInitializationMode", status)
            }
            Mode::Event | Mode::Stepping | Mode::SteppingAfterSet => {
                ("fmi2ExitInitializationMode", raw.exit_initialization_mode())
            }
            Mode::Terminated => ("fmi2Terminate", raw.terminate()),
        };
        self.in_events = self.has_events && matches!(mode, Mode::Event | Mode::Stepping);
        self.must(name, status)
    }

    /// Makes a step from `t` by `h`, s; returns the status.
    pub fn step_from(&self, t: f64, h: f64) -> c_int {
        self.stepping(|raw| raw.do_step(t, h, 1, &mut StepEnd::default()))
    }

    /// Leaves Event Mode, and stays in Step Mode between steps from now on.
    pub fn enter_step_mode(&mut self) -> Result<()> {
        match std::mem::take(&mut self.in_events) {
            true => self.done("fmi3EnterStepMode", RawInstance::leave_events),
            false => Ok(()),
        }
    }

    /// Does something that needs Step Mode, and goes back to Event Mode afterwards.
    pub fn stepping(&self, act: impl FnOnce(&RawInstance) -> c_int) -> c_int {
        if !self.in_events {
            return act(&self.raw);
        }
        let left = self.raw.leave_events();
        if left > WARNING {
            return left;
        }
        let status = act(&self.raw);
        status.max(self.raw.enter_events())
    }

    /// Makes a step by `h`, s, from the present time, which must succeed (fmi2DoStep).
    pub fn step(&mut self, h: f64) -> Result<()> {
        self.step_with_end(h).map(drop)
    }

    /// The same; returns how the step ended, which only FMI 3.0 tells.
    pub fn step_with_end(&mut self, h: f64) -> Result<StepEnd> {
        let (t, mut end) = (self.time, StepEnd::default());
        let status = self.stepping(|raw| raw.do_step(t, h, 1, &mut end));
        self.must(&format!("fmi2DoStep from t = {t} s by {h} s"), status)?;
        self.time += h;
        Ok(end)
    }

    /// What [`ONE_BY_ONE`] asks for before a call: the variable is said, or there are calls for one
    /// each, whose results these are.
    pub(crate) fn one_by_one<T>(
        &self,
        vr: &[u32],
        get: impl Fn(&[u32]) -> (c_int, Vec<T>),
    ) -> Option<(c_int, Vec<T>)> {
        match vr {
            _ if !ONE_BY_ONE.load(Relaxed) => None,
            [reference] => {
                let found = self.fmu.find(*reference).map(|v| format!("`{}`", v.name));
                let unknown = || format!("the value reference {reference}, which no variable has,");
                eprintln!("{SAID}{}", found.unwrap_or_else(unknown));
                None
            }
            _ => {
                let results = vr.iter().map(|reference| get(slice::from_ref(reference)));
                let (statuses, values): (Vec<_>, Vec<_>) = results.unzip();
                Some((
                    statuses.into_iter().max()?,
                    values.into_iter().flatten().collect(),
                ))
            }
        }
    }

    /// The status, and the values of Real variables; nothing is called for none.
    pub fn reals(&self, references: &[u32]) -> (c_int, Vec<f64>) {
        if references.is_empty() {
            return (OK, Vec::new());
        }
        if let Some(all) = self.one_by_one(references, |one| self.reals(one)) {
            return all;
        }
        let mut values = vec![0.0; self.fmu.functions.count(references)];
        let vr = Array::Elements(references);
        (self.raw.get_reals(vr, Some(&mut values)), values)
    }

    /// The values of Real variables, which must be readable; the error names the first that is not.
    pub fn must_read(&self, vr: &[u32]) -> Result<Vec<f64>> {
        let (status, values) = self.reals(vr);
        if status <= WARNING {
            return Ok(values);
        }
        let message = last_message(&self.messages());
        let refused = vr.iter().find(|r| self.reals(&[**r]).0 > WARNING);
        let refused = refused.and_then(|r| self.fmu.find(*r));
        let of = refused.map_or("all variables".into(), |v| format!("`{}`", v.name));
        Err(anyhow!(
            "fmi2GetReal of {of} gave {}{message}",
            status::name(status)
        ))
    }

    /// The values of a Real variable, which must be readable.
    pub fn read(&self, v: &Variable) -> Result<Vec<f64>> {
        let (status, values) = self.reals(&[v.reference]);
        self.must(&format!("fmi2GetReal of `{}`", v.name), status)?;
        Ok(values)
    }

    /// Sets Real variables; returns the status.
    pub fn set_reals(&self, references: &[u32], values: &[f64]) -> c_int {
        assert_eq!(self.fmu.functions.count(references), values.len());
        self.one_by_one(&references[..references.len().min(1)], |_| (OK, vec![()]));
        self.raw
            .set_reals(Array::Elements(references), Array::Elements(values))
    }

    /// The numbers of all variables, as the bits of `f64`s: what two runs are compared by.
    pub fn observe(&self) -> Result<Vec<u64>> {
        let description = &self.fmu.description;
        let of = |access| references(&description.variables, |v| v.access() == access);
        let reals = self.must_read(&of(Access::Real))?;
        let mut bits: Vec<_> = reals.iter().map(|value| value.to_bits()).collect();
        let is_other = |access: &Access| access.is_number() && *access != Access::Real;
        for access in self.fmu.accesses().into_iter().filter(is_other) {
            let (status, values) = self.values_of(access, &of(access), false);
            let [get, _] = self.fmu.functions.names_of(access);
            self.must(&format!("{get} of all variables"), status)?;
            let number = |text: &String| text.parse::<f64>().unwrap_or(f64::from(text == "true"));
            bits.extend(values.iter().map(|text| number(text).to_bits()));
        }
        Ok(bits)
    }

    /// Makes steps with inputs that [change a little](Self::excite); returns what can be
    /// [observed](Self::observe) after each.
    pub fn run_excited(&mut self, steps: usize, phase: usize) -> Result<Vec<u64>> {
        let h = step_size(self.fmu);
        let mut bits = Vec::new();
        for k in 0..steps {
            self.excite(phase + k);
            self.step(h)?;
            bits.extend(self.observe()?);
        }
        Ok(bits)
    }

    /// Sets Real inputs to values near their start values that depend on `k`, within their bounds.
    /// A refusal is ignored.
    pub fn excite(&self, k: usize) {
        let is_moving = |v: &&Variable| v.is_input() && v.access() == Access::Real;
        let variables = self.fmu.description.variables.iter();
        for (n, v) in variables.filter(is_moving).enumerate() {
            let [min, max] = v.bounds();
            let value = |element: usize| {
                let (start, scale) = start_and_scale(v, element);
                let phase = 0.7 * k as f64 + n as f64 + element as f64;
                (start + 0.01 * scale * phase.sin()).clamp(min, max)
            };
            if min <= max {
                let values: Vec<f64> = (0..v.size()).map(value).collect();
                self.set_reals(&[v.reference], &values);
            }
        }
        self.messages();
    }
}

/// Value references of the variables that a condition selects, without those that can only be set
/// and read at the ticks of a clock.
pub fn references(variables: &[Variable], fits: impl Fn(&Variable) -> bool) -> Vec<u32> {
    let fitting = variables.iter().filter(|v| v.clocks.is_empty() && fits(v));
    fitting.map(|v| v.reference).collect()
}

/// Start value of an element of a Real, and the order of magnitude of its values.
pub fn start_and_scale(v: &Variable, element: usize) -> (f64, f64) {
    let start = v.start_number_of(element).unwrap_or(0.0);
    let scale = v.nominal.unwrap_or(start.abs()).abs();
    (start, if scale > 0.0 { scale } else { 1.0 })
}

/// Start time of the default experiment, s.
pub fn start_time(fmu: &Fmu) -> f64 {
    fmu.description.default_experiment.start.unwrap_or(0.0)
}

/// Communication step that the FMU proposes, else a five-hundredth of its default experiment, else
/// 10 ms; in s.
pub fn step_size(fmu: &Fmu) -> f64 {
    let experiment = &fmu.description.default_experiment;
    let start = experiment.start.unwrap_or(0.0);
    let span = experiment.stop.map(|stop| (stop - start) / 500.0);
    let proposed = experiment.step.or(span);
    proposed
        .filter(|h| h.is_finite() && *h > 0.0)
        .unwrap_or(0.01)
}

/// The last message after a colon, to end a sentence with; empty without messages.
pub fn last_message(messages: &[Message]) -> String {
    let last = messages.last();
    last.map_or(String::new(), |m| format!(": {}", m.format))
}
