//! A promise about what an FMU does, and how it is tried.

use std::path::Path;

use fmu_description::Version;

use crate::check::outcome::{Outcome, Promise};
use crate::fmi::Fmu;

/// How a promise is tried; an error is a reason why it does not hold.
#[derive(Clone, Copy)]
pub enum Run {
    /// On the opened FMU.
    Opened(fn(&Fmu, &mut Outcome) -> Result<(), String>),
    /// On the folder with its files.
    InFolder(fn(&Path) -> Result<(), String>),
}

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
    run: Run,
}

/// A trial as most are.
pub const fn trial(
    name: &'static str,
    area: &'static str,
    run: fn(&Fmu, &mut Outcome) -> Result<(), String>,
    text: &'static str,
    why: &'static str,
) -> Trial {
    Trial {
        name,
        area,
        promise: Promise { text, why },
        has_odd_folder: false,
        is_first_step: false,
        version: None,
        run: Run::Opened(run),
    }
}

impl Trial {
    /// Of what only one version of FMI has.
    pub const fn only_in(self, version: Version) -> Self {
        Self {
            version: Some(version),
            ..self
        }
    }

    /// Of what all others try, too.
    pub const fn as_first_step(self) -> Self {
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

    /// Of what needs the files themselves, and opens them.
    pub const fn in_folder(self, run: fn(&Path) -> Result<(), String>) -> Self {
        let run = Run::InFolder(run);
        Self { run, ..self }
    }

    /// Try it on the FMU whose files lie in this folder.
    pub fn outcome(&self, folder: &Path) -> Outcome {
        let mut outcome = Outcome::default();
        let result = match self.run {
            Run::InFolder(run) => run(folder),
            Run::Opened(run) => open(folder).and_then(|fmu| run(&fmu, &mut outcome)),
        };
        if let Err(reason) = result {
            outcome.fail(reason);
        }
        outcome
    }
}

/// What the FMU does not claim is not tried.
pub fn unless(claimed: bool, outcome: &mut Outcome) -> bool {
    if !claimed {
        outcome.not_checked = Some("the FMU does not claim it".into());
    }
    !claimed
}

/// The FMU whose files lie in a folder.
pub fn open(folder: &Path) -> Result<Fmu, String> {
    Fmu::unpacked(folder).map_err(|e| format!("{e:#}"))
}
