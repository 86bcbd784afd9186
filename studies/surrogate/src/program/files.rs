//! Reads network files, and writes network files and tables, for the commands of this program.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::Args;
use emla::{Surrogate, SurrogateFile};

/// The option `--network`.
#[derive(Args)]
pub(crate) struct NetworkArg {
    /// Network file; without it the shipped network, for `compare` the one trained on the rig.
    #[arg(long)]
    network: Option<PathBuf>,
}

impl NetworkArg {
    /// The network of the file; without a file, the default.
    pub(crate) fn read_or(&self, default: impl Fn() -> Surrogate) -> Result<Surrogate> {
        let Some(path) = &self.network else {
            return Ok(default());
        };
        let name = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        Surrogate::from_json(&text).with_context(|| name.to_string())
    }
}

pub(crate) fn make_folder(path: &Path) -> Result<()> {
    let Some(folder) = path.parent() else {
        return Ok(());
    };
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))
}

/// Writes a network file; makes its folder.
pub(crate) fn write_network(path: &Path, network: &SurrogateFile) -> Result<()> {
    let text = serde_json::to_string_pretty(network).context("cannot write JSON")?;
    write(path, &text)
}

/// Writes a file; makes its folder.
pub(crate) fn write(path: &Path, text: &str) -> Result<()> {
    make_folder(path)?;
    Ok(output_file::write(path, text)?)
}
