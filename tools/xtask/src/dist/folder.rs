//! The folder that `cargo xtask dist` makes, and the files in it; its listing and checks read them.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::Result;
use cargo_fmu::pack::FMI3_FOLDER;
use cargo_fmu::target::Target;

use crate::workspace::archives;

/// Name of the list of checksums, in the form of `sha256sum`.
pub const CHECKSUMS: &str = "SHA256SUMS";

pub struct Dist {
    pub folder: PathBuf,
    pub targets: Vec<&'static Target>,
    /// File names of the FMUs, in the order of `Workspace::suite`.
    pub suite: Vec<String>,
    /// Programs by platform folder and name; also those that only the checks need.
    pub programs: BTreeMap<(&'static str, String), PathBuf>,
}

impl Dist {
    /// The FMUs of FMI 2.0.
    pub fn fmus(&self) -> Result<Vec<PathBuf>> {
        archives(&self.folder, "fmu")
    }

    /// The FMUs of FMI 3.0.
    pub fn fmus_3(&self) -> Result<Vec<PathBuf>> {
        archives(&self.folder.join(FMI3_FOLDER), "fmu")
    }

    pub fn systems(&self) -> Result<Vec<PathBuf>> {
        archives(&self.folder, "ssp")
    }
}
