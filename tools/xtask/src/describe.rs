//! `cargo xtask describe`: writes the model descriptions of the built libraries into
//! `modelDescription/`, and those of FMI 3.0 into its folder `fmi3/`. They are committed, so that a
//! review shows each change of an interface; `test` compares them with the packed FMUs.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use cargo_fmu::library::{self, Version};
use cargo_fmu::pack::{FMI3_FOLDER, fmi3_files};
use fmi_description::entries::{self, Entries};

use crate::workspace::Workspace;

/// Builds the libraries and writes their model descriptions, or checks that the committed ones are
/// the same.
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

/// Checks that the committed model descriptions are those in these packed FMUs of FMI 2.0, and in
/// the FMUs of FMI 3.0 that were packed with them.
pub fn check(workspace: &Workspace, fmus: &[PathBuf]) -> Result<()> {
    let fmi3 = fmi3_files(fmus)?;
    let fmus = fmus.iter().map(|fmu| (Version::Fmi2, fmu));
    let all = fmus.chain(fmi3.iter().map(|fmu| (Version::Fmi3, fmu)));
    let described = all.map(|(version, fmu)| Ok((version, entries::read(fmu)?)));
    compare(workspace, described.collect::<Result<_>>()?, true)
}

/// Writes the model descriptions among these files, or compares them with the committed ones.
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
            output_file::write(&path, text)?;
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
