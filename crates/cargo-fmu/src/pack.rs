//! `cargo fmu pack`: libraries are built, asked for the files that they carry, and packed with them.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::archive::Entries;
use crate::platform::Platform;
use crate::workspace::{Package, Source, Workspace};
use crate::{archive, library, licences, platform};

/// The profile that libraries are built with if none is chosen; see [`profile`].
pub const FMU_PROFILE: &str = "fmu-release";

/// Arguments of cargo for a profile. A library must unwind from a panic, which is caught at the C border, and carries no symbols
/// beside those it exports.
///
/// [`FMU_PROFILE`] needs no entry in the workspace's Cargo.toml: it is `release` with the whole program optimised at once, which
/// takes longest to build and runs fastest.
pub fn profile(name: &str) -> Vec<String> {
    let mut settings = vec!["panic=\"unwind\"", "strip=\"symbols\""];
    if name == FMU_PROFILE {
        settings.extend([
            "inherits=\"release\"",
            "lto=\"fat\"",
            "codegen-units=1",
            "debug-assertions=false",
            "overflow-checks=false",
        ]);
    }
    let settings = settings
        .iter()
        .flat_map(|s| ["--config".to_string(), format!("profile.{name}.{s}")]);
    let name = ["--profile".to_string(), name.to_string()];
    name.into_iter().chain(settings).collect()
}

/// Build and pack FMUs into the folder `out`; the files written.
pub fn fmus(
    workspace: &Workspace,
    sources: &[Source],
    profile: &[String],
    out: &Path,
) -> Result<Vec<PathBuf>> {
    ensure!(
        !sources.is_empty(),
        "no package here makes an FMU: it needs crate-type = [\"cdylib\"] in [lib] and fmu-export among its dependencies"
    );
    let built = workspace.build(sources, profile)?;
    fs::create_dir_all(out).with_context(|| out.display().to_string())?;
    let packed = built
        .iter()
        .map(|(library, package)| fmu(workspace, package, library, out));
    packed.collect()
}

fn fmu(workspace: &Workspace, package: &Package, built: &Path, out: &Path) -> Result<PathBuf> {
    let (identifier, mut entries) = contents(built)?;
    let folders = [package.folder(), &workspace.root];
    for (path, bytes) in licences::files(&folders, package.license.as_deref())? {
        entries.entry(path).or_insert(bytes);
    }
    let path = out.join(identifier).with_extension("fmu");
    let size = archive::write(&path, &entries)?;
    println!("packed {} ({} kB)", path.display(), size / 1000);
    Ok(path)
}

/// Model identifier and files of the FMU that a library makes: those it carries, and itself in the folder of its platform.
pub fn contents(library: &Path) -> Result<(String, Entries)> {
    let name = || library.display().to_string();
    let mut entries = library::files(library)?;
    let identifier = library::description(&entries)
        .with_context(name)?
        .identifier;
    let bytes = fs::read(library).with_context(name)?;
    let Platform { folder, suffix } = platform::of(&bytes).with_context(name)?;
    entries.insert(format!("binaries/{folder}/{identifier}{suffix}"), bytes);
    Ok((identifier, entries))
}

#[cfg(test)]
mod tests {
    use super::profile;

    #[test]
    fn every_profile_unwinds_and_only_ours_is_defined() {
        let release = profile("release").join(" ");
        assert!(release.starts_with("--profile release --config profile.release.panic=\"unwind\""));
        assert!(!release.contains("inherits"));
        assert!(
            profile(super::FMU_PROFILE)
                .join(" ")
                .contains("profile.fmu-release.inherits=\"release\"")
        );
    }
}
