//! A promise about what an FMU does, and how it is tried.

use std::path::Path;

use anyhow::Result;
use fmi_description::{Capabilities, Version};

use crate::outcome::Outcome;
pub use crate::outcome::Promise;
use fmi_import::Fmu;

/// How a promise is tried; an error is a reason why it does not hold.
#[derive(Clone, Copy)]
pub enum Run {
    /// On the opened FMU.
    Opened(fn(&Fmu, &mut Outcome) -> Result<()>),
    /// On the folder with its files.
    InFolder(fn(&Path) -> Result<()>),
}

/// Why it is not tried on an FMU; None where it is.
type Hindrance = fn(&Fmu) -> Option<&'static str>;
/// Whether an FMU claims to be able to do it.
type Claim = fn(&Capabilities) -> bool;

/// A promise and how it is tried.
pub struct Trial {
    /// Name by which the process of its own is told what to do.
    pub name: &'static str,
    /// Heading.
    pub area: &'static str,
    /// What must hold.
    pub promise: Promise,
    /// The files lie in a folder whose name has a space and a letter beyond ASCII.
    pub has_odd_folder: bool,
    /// What it tries, all others do, too: where it fails, those that fail alike are not listed.
    pub is_first_step: bool,
    /// The version of FMI that has it; None for both.
    pub version: Option<Version>,
    claim: Claim,
    hindrance: Hindrance,
    run: Run,
}

/// Trials as a table. Under each heading: how it is tried, the promise, and why it matters.
macro_rules! trials {
    ($($area:literal { $($kind:ident $run:ident $(.$how:ident($($argument:expr)?))*: $text:literal, $why:literal;)* })*) => {
        pub const TRIALS: &[super::trial::Trial] = &[$($(
            super::trial::Trial::$kind(
                stringify!($run), $area, $run, super::trial::Promise { text: $text, why: $why },
            )$(.$how($($argument)?))*,
        )*)*];
    };
}

pub(super) use trials;

impl Trial {
    /// On the opened FMU.
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

    /// With the files themselves, which it opens.
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

    /// Of what only one version of FMI has.
    pub const fn only_in(self, version: Version) -> Self {
        Self {
            version: Some(version),
            ..self
        }
    }

    /// Of FMUs that claim to be able to do it.
    pub const fn if_claimed(self, claim: Claim) -> Self {
        Self { claim, ..self }
    }

    /// Not of FMUs that something hinders.
    pub const fn unless(self, hindrance: Hindrance) -> Self {
        Self { hindrance, ..self }
    }

    /// Of what all others try, too.
    pub const fn first_step(self) -> Self {
        Self {
            is_first_step: true,
            ..self
        }
    }

    /// With the files in a folder whose name is odd.
    pub const fn in_odd_folder(self) -> Self {
        Self {
            has_odd_folder: true,
            ..self
        }
    }

    /// Try it on the FMU whose files lie in this folder.
    pub fn outcome(&self, folder: &Path) -> Outcome {
        let mut outcome = Outcome::default();
        let result = match self.run {
            Run::InFolder(run) => run(folder),
            Run::Opened(run) => Fmu::unpacked(folder).and_then(|fmu| {
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
