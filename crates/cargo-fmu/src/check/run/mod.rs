//! What an FMU does when it is run. Each promise is tried in a process of its own, so that a crash, a hang or a word on
//! standard output is a row of the table.
#![allow(unsafe_code)] // calls the C functions of an FMU

mod basics;
mod calls;
mod derivatives;
mod instance;
mod instances;
mod misuse;
mod of_3;
mod processes;
mod states;
mod values;

use std::path::Path;

use fmu_description::Version;

use super::outcome::{Outcome, Promise};
use crate::fmi::Fmu;

pub use processes::{all, one};

/// Where a trial finds the files of the FMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In a folder with a plain name.
    Plain,
    /// In a folder whose name has a space and a letter beyond ASCII.
    Spaced,
}

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
    /// Where the files lie.
    pub place: Place,
    /// Where it fails, nothing else is tried.
    pub is_needed: bool,
    /// The version of FMI that has it; None for both.
    pub version: Option<Version>,
    run: Run,
}

const fn trial(
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
        place: Place::Plain,
        is_needed: false,
        version: None,
        run,
    }
}

impl Trial {
    /// Of what only one version of FMI has.
    const fn only_in(self, version: Version) -> Self {
        Self {
            version: Some(version),
            ..self
        }
    }
}

/// All trials of both versions, in the order of the table.
pub fn trials() -> impl Iterator<Item = &'static Trial> {
    let groups: [&[Trial]; 8] = [
        basics::TRIALS,
        values::TRIALS,
        instances::TRIALS,
        states::TRIALS,
        derivatives::TRIALS,
        misuse::TRIALS,
        of_3::TRIALS,
        calls::TRIALS,
    ];
    groups.into_iter().flatten()
}

fn open(folder: &Path) -> Result<Fmu, String> {
    Fmu::unpacked(folder).map_err(|e| format!("{e:#}"))
}
