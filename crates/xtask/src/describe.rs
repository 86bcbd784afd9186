//! `modelDescription/*.xml`, and in `fmi3/` those of FMI 3.0: what the libraries say about themselves, committed so that a change of the interface is seen in a review.

use std::fs;

use anyhow::{Context, Result, bail};
use cargo_fmu::library::{self, Version};
use cargo_fmu::pack::FMI3_FOLDER;

use crate::workspace::Workspace;

/// Write the model descriptions, or check that the committed ones are what the libraries say.
pub fn run(workspace: &Workspace, check: bool) -> Result<()> {
    let dir = workspace.root.join("modelDescription");
    let folders = [
        (Version::Fmi2, dir.clone()),
        (Version::Fmi3, dir.join(FMI3_FOLDER)),
    ];
    fs::create_dir_all(dir.join(FMI3_FOLDER)).with_context(|| dir.display().to_string())?;
    let mut stale = Vec::new();
    let built = workspace.build_fmus(&workspace.suite())?;
    let each = built
        .iter()
        .flat_map(|b| folders.iter().map(move |f| (b, f)));
    for (built, (version, folder)) in each {
        let files = library::files_of(built, *version)?;
        let text = library::description_text(&files)?;
        let identifier = library::description(&files)?.identifier;
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
