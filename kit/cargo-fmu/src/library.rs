//! The files of an FMU that a library made with `fmu_export::export_fmu!` carries, and the model
//! description among them, for `pack`, `wasm`, `web`, `xtask` and tests of `cosim`.
//!
//! ```no_run
//! use cargo_fmu::library::{Version, description, exported_files};
//! let files = exported_files("target/release/libmy.so".as_ref(), Version::Fmi3)?;
//! println!("{}", description(&files)?.identifier);
//! # anyhow::Ok(())
//! ```

use anyhow::{Context, Result};
pub use fmi_description::Version;
use fmi_description::{Description, Entries};
pub use fmi_import::{UnsupportedType, exported_files};

/// Text of the model description among the files of an FMU.
pub fn description_text(files: &Entries) -> Result<&str> {
    let bytes = files.get("modelDescription.xml");
    let bytes = bytes.context("the library carries no modelDescription.xml")?;
    std::str::from_utf8(bytes).context("modelDescription.xml must be UTF-8")
}

/// The model description among the files of an FMU.
pub fn description(files: &Entries) -> Result<Description> {
    Ok(Description::parse(description_text(files)?)?)
}
