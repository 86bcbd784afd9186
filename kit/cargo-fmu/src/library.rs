//! The files that a library made with `fmu_export::export_fmu!` carries.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result};
pub use fmi_description::Version;
use fmi_description::{Description, Entries};
pub use fmi_import::exported::{Lacking, files as files_of};

/// All files of the FMU of FMI 2.0 beside the binaries: model description, documentation, icon,
/// resources. The library must be one that this machine can load.
pub fn files(library: &Path) -> Result<Entries> {
    files_of(library, Version::Fmi2)
}

/// Text of the model description among the files.
pub fn description_text(files: &BTreeMap<String, Vec<u8>>) -> Result<&str> {
    let bytes = files.get("modelDescription.xml");
    let bytes = bytes.context("the library carries no modelDescription.xml")?;
    std::str::from_utf8(bytes).context("modelDescription.xml must be UTF-8")
}

/// The model description among the files.
pub fn description(files: &Entries) -> Result<Description> {
    Ok(Description::parse(description_text(files)?)?)
}
