//! `modelDescription/*.xml`: what the libraries say about themselves, committed so that a change of the interface is seen in a review.

use std::fs;

use anyhow::{Context, Result, bail};
use cargo_fmu::library;

use crate::workspace::Workspace;

/// Write the model descriptions, or check that the committed ones are what the libraries say.
pub fn run(workspace: &Workspace, check: bool) -> Result<()> {
    let dir = workspace.root.join("modelDescription");
    let mut stale = Vec::new();
    for built in workspace.build_fmus(&workspace.suite())? {
        let files = library::files(&built)?;
        let text = library::description_text(&files)?;
        let identifier = library::description(&files)?.identifier;
        let path = dir.join(identifier).with_extension("xml");
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
