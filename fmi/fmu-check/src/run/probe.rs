//! A [`Probe`]: a promise about what an FMU does when it is run, and the function that tests it.
//! Other files of this folder list probes with the macro `probes!`, and `supervision` runs them.

use std::path::Path;

use anyhow::Result;
use fmi_description::{Capabilities, Version};

use crate::outcome::Outcome;
pub use crate::outcome::Promise;
use fmi_import::Fmu;

/// The function that tests a promise; its error is a reason why the promise does not hold.
#[derive(Clone, Copy)]
pub enum Run {
    /// It is called with the opened FMU.
    Opened(fn(&Fmu, &mut Outcome) -> Result<()>),
    /// It is called with the folder of the FMU's files.
    InFolder(fn(&Path) -> Result<()>),
}

/// Why a promise cannot be tested on an FMU, if it cannot.
type Hindrance = fn(&Fmu) -> Option<&'static str>;
/// Whether an FMU declares the capability that a promise is about.
type Claim = fn(&Capabilities) -> bool;

/// A promise about what an FMU does, and how it is tested.
pub struct Probe {
    /// Name by which the process of the probe is told what to do.
    pub name: &'static str,
    /// Heading in the report.
    pub area: &'static str,
    pub promise: Promise,
    /// The FMU is run from a folder whose name has a space and a non-ASCII letter.
    pub has_odd_folder: bool,
    /// All other probes do what this one does, so those that fail as it does are not listed.
    pub is_first_step: bool,
    /// The only version of FMI that it applies to; None for both.
    pub version: Option<Version>,
    claim: Claim,
    hindrance: Hindrance,
    run: Run,
}

/// The table `PROBES` of a file. Under each heading, for each probe: how it is tested, the promise,
/// why it matters, with the sections of the standard that ask for it, if any do.
macro_rules! probes {
    ($($area:literal { $($kind:ident $run:ident $(.$how:ident($($argument:expr)?))*: $text:literal, $why:literal;)* })*) => {
        pub const PROBES: &[super::probe::Probe] = &[$($(
            super::probe::Probe::$kind(
                stringify!($run), $area, $run, super::probe::Promise { text: $text, why: $why },
            )$(.$how($($argument)?))*,
        )*)*];
    };
}

pub(super) use probes;

impl Probe {
    /// A probe of the opened FMU.
    pub const fn opened(
        name: &'static str,
        area: &'static str,
        run: fn(&Fmu, &mut Outcome) -> Result<()>,
        promise: Promise,
    ) -> Self {
        Self {
            name,
            area,
            promise,
            has_odd_folder: false,
            is_first_step: false,
            version: None,
            claim: |_| true,
            hindrance: |_| None,
            run: Run::Opened(run),
        }
    }

    /// A probe that opens the files itself.
    pub const fn in_folder(
        name: &'static str,
        area: &'static str,
        run: fn(&Path) -> Result<()>,
        promise: Promise,
    ) -> Self {
        Self {
            run: Run::InFolder(run),
            ..Self::opened(name, area, |_, _| Ok(()), promise)
        }
    }

    /// Only for one version of FMI.
    pub const fn only_in(self, version: Version) -> Self {
        Self {
            version: Some(version),
            ..self
        }
    }

    /// Only for FMUs that declare a capability.
    pub const fn if_claimed(self, claim: Claim) -> Self {
        Self { claim, ..self }
    }

    /// Not for FMUs for which `hindrance` returns a reason.
    pub const fn unless(self, hindrance: Hindrance) -> Self {
        Self { hindrance, ..self }
    }

    /// All other probes do the same first.
    pub const fn first_step(self) -> Self {
        Self {
            is_first_step: true,
            ..self
        }
    }

    /// Runs from a folder whose name has a space and a non-ASCII letter.
    pub const fn in_odd_folder(self) -> Self {
        Self {
            has_odd_folder: true,
            ..self
        }
    }

    /// Tests the FMU whose files are in this folder.
    pub fn outcome(&self, folder: &Path) -> Outcome {
        let mut outcome = Outcome::default();
        let result = match self.run {
            Run::InFolder(run) => run(folder),
            Run::Opened(run) => Fmu::from_folder(folder).and_then(|fmu| {
                let hindrance = match (self.claim)(&fmu.description.capabilities) {
                    true => (self.hindrance)(&fmu),
                    false => Some("the FMU does not claim it"),
                };
                outcome.not_checked = hindrance.map(String::from);
                match outcome.not_checked {
                    None => run(&fmu, &mut outcome),
                    Some(_) => Ok(()),
                }
            }),
        };
        if let Err(reason) = result {
            outcome.fail(format!("{reason:#}"));
        }
        outcome
    }
}
