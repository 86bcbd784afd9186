//! `modelDescription/*.xml`, and in `fmi3/` those of FMI 3.0: what the libraries say about
//! themselves, committed so that a change of the interface is seen in a review.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use cargo_fmu::library::{self, Version};
use cargo_fmu::pack::FMI3_FOLDER;
use fmi_description::entries::{self, Entries};

use crate::pack;
use crate::workspace::Workspace;

/// Build the libraries and write their model descriptions, or check that the committed ones are
/// what the libraries say.
pub fn run(workspace: &Workspace, check: bool) -> Result<()> {
    let built = workspace.build_fmus(&workspace.suite())?;
    let mut described = Vec::new();
    for library in &built {
        for version in [Version::Fmi2, Version::Fmi3] {
            described.push((version, library::exported_files(library, version)?));
        }
    }
    compare(workspace, described, check)
}

/// Check that the committed model descriptions are those in packed FMUs of FMI 2.0, and in those of
/// FMI 3.0 beside them.
pub fn check(workspace: &Workspace, fmus: &[PathBuf]) -> Result<()> {
    let both = pack::both_versions(fmus.to_vec())?;
    let versions = both.iter().enumerate().map(|(i, fmu)| {
        let version = match i < fmus.len() {
            true => Version::Fmi2,
            false => Version::Fmi3,
        };
        Ok((version, entries::read(fmu)?))
    });
    compare(workspace, versions.collect::<Result<_>>()?, true)
}

/// Write, or compare with what is committed, the model descriptions among these files.
fn compare(workspace: &Workspace, described: Vec<(Version, Entries)>, check: bool) -> Result<()> {
    let dir = workspace.root.join("modelDescription");
    fs::create_dir_all(dir.join(FMI3_FOLDER)).with_context(|| dir.display().to_string())?;
    let mut stale = Vec::new();
    for (version, files) in described {
        let text = library::description_text(&files)?;
        let identifier = library::description(&files)?.identifier;
        let folder = match version {
            Version::Fmi2 => dir.clone(),
            Version::Fmi3 => dir.join(FMI3_FOLDER),
        };
        let path = folder.join(identifier).with_extension("xml");
        let committed = fs::read_to_string(&path).ok();
        // Git may have given the file the line ends of the platform.
        let same = committed.is_some_and(|c| c.replace("\r\n", "\n") == text);
        if !same && check {
            stale.push(path.display().to_string());
        } else if !same {
            fs::write(&path, text).with_context(|| path.display().to_string())?;
            println!("wrote {}", path.display());
        }
    }
    if !stale.is_empty() {
        bail!(
            "not what the libraries say: {}; run `cargo xtask describe` and commit the result",
            stale.join(", ")
        );
    }
    Ok(())
}
