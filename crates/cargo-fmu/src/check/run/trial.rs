//! A promise about what an FMU does, and how it is tried.

use std::path::Path;

use fmu_description::Version;

use crate::check::outcome::{Outcome, Promise};
use crate::fmi::Fmu;

/// What a trial does: an error is a reason why the promise does not hold.
type Run = fn(&Path, &mut Outcome) -> Result<(), String>;

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
    /// Tries it on the FMU whose files lie in this folder.
    pub run: Run,
}

/// A trial as most are.
pub const fn trial(
    name: &'static str,
    area: &'static str,
    run: Run,
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
        run,
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
}

/// The FMU whose files lie in a folder.
pub fn open(folder: &Path) -> Result<Fmu, String> {
    Fmu::unpacked(folder).map_err(|e| format!("{e:#}"))
}
