//! An instance of an FMU as a strict importer holds it: with its log, the time, and what can be
//! read of it. The FMU is asked nothing of types of which it has no variable.

use std::ffi::{CString, c_int};
use std::ops::Deref;

use anyhow::{Result, anyhow};
use fmi_description::{Access, Variable};

use crate::fmu::Fmu;
use crate::log::{Log, Message};
use crate::raw::{Array, CallbackSet, Experiment, InstanceKind, RawInstance, Request, StepEnd};
use crate::standard::Mode;
use crate::status::{self, OK, WARNING};

/// How an instance is made and what is asked of it.
#[derive(Clone, Copy, Debug)]
pub struct Manner<'a> {
    /// GUID or instantiation token; None for that of the description.
    pub token: Option<&'a str>,
    /// What it is made for.
    pub kind: InstanceKind,
    /// loggingOn.
    pub is_logging: bool,
    /// It is given functions for memory (FMI 2.0).
    pub gives_memory: bool,
    /// A call that must succeed may also answer with a warning.
    pub may_warn: bool,
}

impl Manner<'_> {
    /// As most importers do it.
    pub const USUAL: Self = Self {
        token: None,
        kind: InstanceKind::CoSimulation,
        is_logging: false,
        gives_memory: true,
        may_warn: true,
    };
    /// What FMUs made with fmu-export bear: no functions for memory, and no warnings from calls.
    pub const STRICT: Self = Self {
        gives_memory: false,
        may_warn: false,
        ..Self::USUAL
    };
}

/// A live instance; freed when dropped. Its C functions are those of a [`RawInstance`].
pub struct Instance<'a> {
    /// Its FMU.
    pub fmu: &'a Fmu,
    raw: RawInstance,
    /// instanceName.
    pub name: String,
    /// Time of the last communication point, s.
    pub time: f64,
    /// What it was set up with.
    experiment: Experiment,
    /// It is in Event Mode between steps, where FMI 3.0 allows a get after a set.
    in_events: bool,
    may_warn: bool,
}

impl Deref for Instance<'_> {
    type Target = RawInstance;

    fn deref(&self) -> &RawInstance {
        &self.raw
    }
}

impl<'a> Instance<'a> {
    /// fmi2Instantiate as it should be done.
    pub fn new(fmu: &'a Fmu, name: &str) -> Result<Self> {
        Self::with(fmu, name, Manner::USUAL)
    }

    /// fmi2Instantiate.
    pub fn with(fmu: &'a Fmu, name: &str, manner: Manner) -> Result<Self> {
        let token = manner.token.unwrap_or(&fmu.description.guid);
        let [c_name, token] = [name, token].map(|s| CString::new(s).expect("no NUL in names"));
        let request = Request {
            kind: manner.kind,
            name: Some(&c_name),
            token: Some(&token),
            resources: (!fmu.resources.is_empty()).then_some(&fmu.resources),
            is_logging: manner.is_logging,
            has_events: fmu.functions.has_event_mode(),
            returns_early: false,
            given: match manner.gives_memory {
                true => CallbackSet::LoggerAndMemory,
                false => CallbackSet::Logger,
            },
        };
        let made = RawInstance::new(&fmu.functions, &request, Log::new(name));
        Ok(Self {
            fmu,
            raw: made.map_err(|said| anyhow!("fmi2Instantiate gave NULL{}", told(&said)))?,
            name: name.to_string(),
            time: 0.0,
            experiment: Experiment::default(),
            in_events: false,
            may_warn: manner.may_warn,
        })
    }

    /// At the first communication point, with the start values.
    pub fn started(fmu: &'a Fmu, name: &str) -> Result<Self> {
        let mut instance = Self::new(fmu, name)?;
        instance.initialize()?;
        Ok(instance)
    }

    /// In Initialization Mode, at the default start time.
    pub fn initializing(fmu: &'a Fmu, name: &str) -> Result<Self> {
        let mut instance = Self::new(fmu, name)?;
        instance.setup(start_time(fmu), None)?;
        instance.enter(Mode::Initialization)?;
        Ok(instance)
    }

    /// Where values may be read after others were set: at the first communication point, or where
    /// FMI 3.0 forbids that there, in Initialization Mode.
    pub fn exchanging(fmu: &'a Fmu, name: &str) -> Result<Self> {
        match fmu.functions.reads_after_set() {
            true => Self::started(fmu, name),
            false => Self::initializing(fmu, name),
        }
    }

    /// Messages since the last call of this function.
    pub fn messages(&self) -> Vec<Message> {
        self.raw.log().take()
    }

    /// A call that must be answered by fmi2OK; fmi2Warning is let through.
    pub fn must(&self, call: &str, status: c_int) -> Result<()> {
        match status {
            OK => Ok(()),
            WARNING if self.may_warn => Ok(()),
            _ => Err(anyhow!(
                "{call} gave {}{}",
                status::name(status),
                told(&self.messages())
            )),
        }
    }

    /// A call of a function that must succeed.
    pub fn done(&self, name: &str, call: impl FnOnce(&RawInstance) -> c_int) -> Result<()> {
        self.must(name, call(&self.raw))
    }

    /// From Instantiated to the first communication point, at the default start time.
    pub fn initialize(&mut self) -> Result<()> {
        self.initialize_between(start_time(self.fmu), None)
    }

    /// From Instantiated to the first communication point.
    pub fn initialize_between(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        self.setup(start, stop)?;
        self.enter(Mode::Initialization)?;
        self.enter(Mode::Stepping)
    }

    /// fmi2SetupExperiment.
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

    /// The call that leads into the next mode.
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
        let has_events = self.fmu.functions.has_event_mode();
        self.in_events = has_events && matches!(mode, Mode::Event | Mode::Stepping);
        self.must(name, status)
    }

    /// A step from `t`; its status.
    pub fn step_from(&self, t: f64, h: f64) -> c_int {
        self.stepping(|raw| raw.do_step(t, h, 1, &mut StepEnd::default()))
    }

    /// Out of Event Mode, to stay in Step Mode.
    pub fn enter_step_mode(&mut self) -> Result<()> {
        match std::mem::take(&mut self.in_events) {
            true => self.done("fmi3EnterStepMode", RawInstance::leave_events),
            false => Ok(()),
        }
    }

    /// What is done where steps are made: in FMI 3.0 in Step Mode, between two visits of Event
    /// Mode.
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

    /// fmi2DoStep from the present time, which must succeed.
    pub fn step(&mut self, h: f64) -> Result<()> {
        let status = self.step_from(self.time, h);
        self.must(
            &format!("fmi2DoStep from t = {} s by {h} s", self.time),
            status,
        )?;
        self.time += h;
        Ok(())
    }

    /// Values of Real variables; without any, nothing is called.
    pub fn reals(&self, references: &[u32]) -> (c_int, Vec<f64>) {
        if references.is_empty() {
            return (OK, Vec::new());
        }
        let mut values = vec![0.0; self.fmu.functions.count(references)];
        let status = self
            .raw
            .get_reals(Array::Elements(references), Some(&mut values));
        (status, values)
    }

    /// Values of Real variables, all of which must be to be had; the error names the first that is
    /// not.
    pub fn must_read(&self, vr: &[u32]) -> Result<Vec<f64>> {
        let (status, values) = self.reals(vr);
        if status <= WARNING {
            return Ok(values);
        }
        let said = told(&self.messages());
        let refused = vr.iter().find(|r| self.reals(&[**r]).0 > WARNING);
        let refused = refused.and_then(|r| self.fmu.find(*r));
        let of = refused.map_or("all variables".into(), |v| format!("`{}`", v.name));
        Err(anyhow!(
            "fmi2GetReal of {of} gave {}{said}",
            status::name(status)
        ))
    }

    /// Values of a Real variable, which must be to be had.
    pub fn read(&self, v: &Variable) -> Result<Vec<f64>> {
        let (status, values) = self.reals(&[v.reference]);
        self.must(&format!("fmi2GetReal of `{}`", v.name), status)?;
        Ok(values)
    }

    /// Set Real variables; the status.
    pub fn set_reals(&self, references: &[u32], values: &[f64]) -> c_int {
        assert_eq!(self.fmu.functions.count(references), values.len());
        self.raw
            .set_reals(Array::Elements(references), Array::Elements(values))
    }

    /// Everything that can be read, as bits: numbers of all variables.
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

    /// Step a while with inputs that move a little; everything that can be read after each step.
    pub fn motion(&mut self, steps: usize, phase: usize) -> Result<Vec<u64>> {
        let h = step_size(self.fmu);
        let mut bits = Vec::new();
        for k in 0..steps {
            self.excite(phase + k);
            self.step(h)?;
            bits.extend(self.observe()?);
        }
        Ok(bits)
    }

    /// Set Real inputs a little beside their start values, inside their bounds. A model that
    /// refuses them keeps what it had.
    pub fn excite(&self, k: usize) {
        let is_moving = |v: &&Variable| v.is_input() && v.access() == Access::Real;
        for (n, v) in self
            .fmu
            .description
            .variables
            .iter()
            .filter(is_moving)
            .enumerate()
        {
            let [min, max] = v.bounds();
            let value = |element: usize| {
                let (start, scale) = about(v, element);
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

/// Value references of the variables that fit.
pub fn references(variables: &[Variable], fits: impl Fn(&Variable) -> bool) -> Vec<u32> {
    let fitting = variables.iter().filter(|v| fits(v));
    fitting.map(|v| v.reference).collect()
}

/// Start value of an element of a Real, and about how large its values are.
pub fn about(v: &Variable, element: usize) -> (f64, f64) {
    let start = v.start_number_of(element).unwrap_or(0.0);
    let scale = v.nominal.unwrap_or(start.abs()).abs();
    (start, if scale > 0.0 { scale } else { 1.0 })
}

/// Start time of the default experiment, s.
pub fn start_time(fmu: &Fmu) -> f64 {
    fmu.description.default_experiment.start.unwrap_or(0.0)
}

/// Communication step that the FMU proposes, else a five-hundredth of its experiment, else 10 ms;
/// in s.
pub fn step_size(fmu: &Fmu) -> f64 {
    let experiment = &fmu.description.default_experiment;
    let span = experiment
        .stop
        .map(|stop| (stop - experiment.start.unwrap_or(0.0)) / 500.0);
    let proposed = experiment.step.or(span).unwrap_or(0.01);
    if proposed.is_finite() && proposed > 0.0 {
        proposed
    } else {
        0.01
    }
}

/// The last message, for the end of a sentence.
pub fn told(messages: &[Message]) -> String {
    messages
        .last()
        .map_or(String::new(), |m| format!(": {}", m.format))
}
