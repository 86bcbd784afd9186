//! Finds packed FMUs and systems whose folder is not given, for `cosim` and the programs of the
//! studies: by the environment variable `FMU_DIR`, or near the program.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::structure::package::FmuPlace;

/// Environment variable that names the folder of the packed FMUs.
const FMU_DIR: &str = "FMU_DIR";

/// Where the FMUs of a system are: in `folder` if given; else where the system structure says, or
/// in one of the folders that are searched.
pub fn place(folder: Option<&Path>) -> Result<FmuPlace> {
    Ok(match folder {
        Some(folder) => FmuPlace::Folder(folder.to_path_buf()),
        None => FmuPlace::Structure {
            else_in: folders()?,
        },
    })
}

/// Folders that are searched for packed FMUs: the one in the environment variable `FMU_DIR`; else
/// the program's own, `fmu/` in it, and `fmu/` in the folders above it (the build folder).
fn folders() -> Result<Vec<PathBuf>> {
    if let Some(folder) = std::env::var_os(FMU_DIR) {
        return Ok(vec![PathBuf::from(folder)]);
    }
    let program = std::env::current_exe()?;
    let own = program.parent().context("a program lies in a folder")?;
    let above = own.ancestors().take(4).map(|folder| folder.join("fmu"));
    Ok(std::iter::once(own.to_path_buf()).chain(above).collect())
}

/// Name of the folder with the FMUs of FMI 3.0, which lies beside those of 2.0.
const FMI_3: &str = "fmi3";

/// Where the FMUs of FMI 3.0 are: in the folder `fmi3` in `folder` if given; else in that beside
/// the system, or in one of the folders that are searched.
pub fn place_of_fmi_3(folder: Option<&Path>, system: &Path) -> Result<FmuPlace> {
    if let Some(folder) = folder {
        return Ok(FmuPlace::Folder(folder.join(FMI_3)));
    }
    let beside = system.parent().map(Path::to_path_buf);
    let places = beside.into_iter().chain(folders()?);
    let places = places.map(|folder| folder.join(FMI_3)).collect();
    let lacking = format!(
        "there is no folder of FMUs of FMI 3.0: name the one that holds `{FMI_3}` (--fmu-dir DIR)"
    );
    first(places, Path::is_dir, &lacking).map(FmuPlace::Folder)
}

/// The packed system `name` in one of the folders that are searched.
pub fn find(name: &str) -> Result<PathBuf> {
    let files = folders()?.iter().map(|folder| folder.join(name)).collect();
    let lacking = format!(
        "there is no {name}: name a system (--system FILE) or the folder of the FMUs (environment variable {FMU_DIR})"
    );
    first(files, Path::is_file, &lacking)
}

/// The first path that exists; the error says what is `lacking` and lists the paths.
fn first(paths: Vec<PathBuf>, exists: fn(&Path) -> bool, lacking: &str) -> Result<PathBuf> {
    let found = paths.iter().find(|path| exists(path)).cloned();
    found.with_context(|| {
        let paths = paths.iter().map(|path| path.display().to_string());
        format!("{lacking}; looked for {}", Vec::from_iter(paths).join(", "))
    })
}
