//! Files that commands read and write.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::Args;
use emla::Surrogate;

/// The network that a picture or comparison is of.
#[derive(Args)]
pub(crate) struct NetworkArg {
    /// Network file; without it the shipped network, for `compare` the one trained on the rig.
    #[arg(long)]
    network: Option<PathBuf>,
}

impl NetworkArg {
    /// The file's, else the `other` one.
    pub(crate) fn read_or(&self, other: impl Fn() -> Surrogate) -> Result<Surrogate> {
        let Some(path) = &self.network else {
            return Ok(other());
        };
        let name = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        Surrogate::from_json(&text).with_context(|| name.to_string())
    }
}

/// Makes the folder that a file lies in.
pub(crate) fn make_folder(path: &Path) -> Result<()> {
    let Some(folder) = path.parent() else {
        return Ok(());
    };
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))
}

/// Writes a file, and the folder that it lies in.
pub(crate) fn write(path: &Path, text: &str) -> Result<()> {
    make_folder(path)?;
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}
