//! Collects licence texts of a package for `pack`, for the folder `documentation/licenses/` of its
//! FMU with `license.txt` (FMI 2.0.4, section 2.3), and finds those of crates for `notices`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use fmi_description::Entries;

/// Folder of licences and notices in an FMU.
pub const FOLDER: &str = "documentation/licenses";
/// How the names of files with licences or notices begin.
const NAMES: [&str; 6] = [
    "LICENSE",
    "LICENCE",
    "COPYING",
    "COPYRIGHT",
    "NOTICE",
    "UNLICENSE",
];

fn is_licence(name: &str) -> bool {
    let name = name.to_uppercase();
    NAMES.iter().any(|n| name.starts_with(n))
}

/// The files in a folder that are licences or notices, sorted by name.
pub fn in_folder(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let entry = entry?;
        if is_licence(&entry.file_name().to_string_lossy()) && entry.file_type()?.is_file() {
            files.push(entry.path());
        }
    }
    files.sort();
    Ok(files)
}

/// The licence files of the first folder that has any, and `license.txt` with the licence
/// expression and their names.
pub fn files(folders: &[&Path], expression: Option<&str>) -> Result<Entries> {
    let mut found = Entries::new();
    for folder in folders {
        for file in in_folder(folder)? {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            found.insert(format!("{FOLDER}/{name}"), fs::read(&file)?);
        }
        if !found.is_empty() {
            break;
        }
    }
    if expression.is_some() || !found.is_empty() {
        let mut text = format!("Licence: {}\n", expression.unwrap_or("see these files"));
        for path in found.keys() {
            text += &format!("{}\n", path.rsplit('/').next().unwrap_or(path));
        }
        found.insert(format!("{FOLDER}/license.txt"), text.into_bytes());
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_folder_with_licences_counts() {
        let root = std::env::temp_dir().join(format!("cargo-fmu-licences-{}", std::process::id()));
        let own = root.join("own");
        fs::create_dir_all(own.join("LICENSES")).unwrap();
        fs::write(root.join("LICENSE-MIT"), "root").unwrap();
        let texts = |expression| {
            let files = files(&[&own, &root], expression).unwrap();
            let text = |(path, bytes)| (path, String::from_utf8(bytes).unwrap());
            files
                .into_iter()
                .map(text)
                .collect::<Vec<(String, String)>>()
        };
        let path = |name: &str| format!("documentation/licenses/{name}");
        let listed = "Licence: MIT\nLICENSE-MIT\n".to_string();
        let expected = [
            (path("LICENSE-MIT"), "root".to_string()),
            (path("license.txt"), listed),
        ];
        assert_eq!(texts(Some("MIT")), expected, "a folder is no licence");
        fs::write(own.join("COPYING"), "own").unwrap();
        let listed = "Licence: see these files\nCOPYING\n".to_string();
        let expected = [
            (path("COPYING"), "own".to_string()),
            (path("license.txt"), listed),
        ];
        assert_eq!(texts(None), expected);
        fs::remove_dir_all(&root).unwrap();
    }
}
