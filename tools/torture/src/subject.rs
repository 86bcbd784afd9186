//! An instance under test with the state that the oracle expects, for all commands but `exchange`.

use std::ffi::c_int;
use std::ops::{Deref, DerefMut};

use anyhow::Result;
use fmi_description::Access;
use fmi_import::Fmu;
use fmi_import::instance::{Instance, InstanceOptions, references};
use fmi_import::raw::StateHandle;
use fmi_import::standard::Mode;

/// State of an instance, or of one of its saved states, as the oracle knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownState {
    pub mode: Mode,
    /// Time of the last communication point, s.
    pub time: f64,
    /// A stop time was given.
    pub has_stop: bool,
}

impl KnownState {
    /// Notes that something was set: in Step Mode, FMI 3.0 then forbids to read before the next
    /// step.
    pub fn note_set(&mut self, fmu: &Fmu) {
        if self.mode == Mode::Stepping && fmu.functions.is_fmi3() {
            self.mode = Mode::SteppingAfterSet;
        }
    }
}

/// Categories of messages, each at the place of the status that it belongs to.
pub const CATEGORIES: [&str; 5] = [
    "logEvents",
    "logStatusWarning",
    "logStatusDiscard",
    "logStatusError",
    "logStatusFatal",
];

/// What is known of a new instance, and of one that was reset.
pub const NEW: KnownState = KnownState {
    mode: Mode::Instantiated,
    time: 0.0,
    has_stop: false,
};

/// An instance under test.
pub struct Subject<'a> {
    instance: Instance<'a>,
    pub known: KnownState,
    /// Saved states that have not been freed.
    pub saved: Vec<(StateHandle, KnownState)>,
    /// Log categories that are switched on.
    categories: Vec<String>,
}

impl<'a> Deref for Subject<'a> {
    type Target = Instance<'a>;

    fn deref(&self) -> &Instance<'a> {
        &self.instance
    }
}

impl DerefMut for Subject<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.instance
    }
}

impl<'a> Subject<'a> {
    /// fmi2Instantiate as it should be done, without functions for memory.
    pub fn new(fmu: &'a Fmu, name: &str) -> Result<Self> {
        Ok(Self {
            instance: Instance::with_options(fmu, name, InstanceOptions::STRICT)?,
            known: NEW,
            saved: Vec::new(),
            categories: Vec::new(), // loggingOn = false
        })
    }

    /// fmi2SetDebugLogging: all or only the named categories on, all or the named ones off;
    /// fmi3SetDebugLogging `adds` to those that are on.
    pub fn set_logging(&mut self, on: bool, named: Vec<String>, adds: bool) {
        let is_named = |c: &&str| named.iter().any(|n| n == c || n == "logAll");
        let was_on = |c: &str| self.categories.iter().any(|n| n == c);
        let stays = |c: &&str| match (on, named.is_empty()) {
            (true, true) => true,
            (true, false) => is_named(c) || adds && was_on(c),
            (false, true) => false,
            (false, false) => was_on(c) && !is_named(c),
        };
        let every = CATEGORIES[..4].iter().copied();
        let wanted = every.filter(stays).map(str::to_owned);
        self.categories = wanted.collect();
    }

    /// Whether a failure of this category must be reported. FMI 2.0 never mutes errors (2.0.4,
    /// section 2.1.5); FMI 3.0 may (section 2.3.1).
    pub fn expects(&self, category: &str) -> bool {
        let is_never_muted = category == "logStatusError" && !self.fmu.functions.is_fmi3();
        is_never_muted || self.categories.iter().any(|n| n == category)
    }

    /// From Instantiated to Step Mode at 0 s, with the start values.
    pub fn initialize(&mut self) -> Result<()> {
        self.instance.initialize_between(0.0, None)?;
        self.instance.enter_step_mode()?;
        self.known = KnownState {
            mode: Mode::Stepping,
            ..NEW
        };
        Ok(())
    }

    /// fmi2DoStep at the present time, which must succeed.
    pub fn advance(&mut self, h: f64) -> Result<()> {
        self.instance.time = self.known.time;
        self.instance.step(h)?;
        self.known.time += h;
        Ok(())
    }

    /// fmi2Reset, which must succeed.
    pub fn reset(&mut self) -> Result<()> {
        self.known = NEW;
        self.instance.enter(Mode::Instantiated)
    }

    /// All computed Real variables; the status, and the numbers if it is fmi2OK.
    pub fn outputs(&self) -> (c_int, Vec<f64>) {
        let variables = &self.fmu.description.variables;
        let is_output =
            |v: &fmi_description::Variable| v.is_computed() && v.access() == Access::Real;
        self.reals(&references(variables, is_output))
    }

    /// Makes a step; returns all computed Real variables after it as bits.
    pub fn observed_step(&mut self, h: f64) -> Result<Vec<u64>> {
        self.advance(h)?;
        let (status, values) = self.outputs();
        self.must("fmi2GetReal", status)?;
        Ok(values.iter().map(|v| v.to_bits()).collect())
    }
}

/// Outputs of a new instance in its first steps of 1 ms, as bits.
pub fn first_steps(subject: &mut Subject) -> Result<Vec<u64>> {
    subject.initialize()?;
    let mut bits = Vec::new();
    for _ in 0..5 {
        bits.extend(subject.observed_step(1e-3)?);
    }
    Ok(bits)
}
