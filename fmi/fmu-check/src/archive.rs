//! Checks the archive, for `fmu_check::check`: whether it opens everywhere, unpacks safely, and has
//! its files where the standard puts them.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Read};

use zip::{CompressionMethod, ZipArchive};

use fmi_description::platform::WASM;

use super::binaries::PLATFORMS;
use super::outcome::{Outcome, Promise, Report};
use fmi_description::Entries;

const AREA: &str = "archive";
const OPENS: Promise = Promise {
    text: "it is a ZIP archive, stored or deflated, not encrypted",
    why: "importers open nothing else",
};
const SAFE: Promise = Promise {
    text: "names of files stay inside the archive and fit every file system",
    why: "`../x` or `C:\\x` writes outside the folder it is unpacked to; names that differ by case only are one file on Windows and macOS",
};
const PLACES: Promise = Promise {
    text: "files lie where the standard puts them",
    why: "importers look for them there, and nowhere else",
};

/// Folders and files at the top of an archive.
const TOP: [&str; 8] = [
    "modelDescription.xml",
    "model.png",
    "documentation",
    "sources",
    "binaries",
    "resources",
    "terminalsAndIcons",
    "extra",
];

/// Largest size of all unpacked files, bytes.
const MAX_SIZE: u64 = 4 << 30;

/// Checks the archive; returns its files if it can be unpacked safely.
pub fn check(bytes: &[u8], report: &mut Report) -> Option<Entries> {
    let entries = match open(bytes) {
        Ok(entries) => entries,
        Err(reason) => {
            report.push(AREA, OPENS, Outcome::failed(reason));
            return None;
        }
    };
    report.push(AREA, OPENS, Outcome::default());
    let safe = names(entries.keys().map(String::as_str));
    let is_safe = safe.fails.is_empty();
    report.push(AREA, SAFE, safe);
    report.push(AREA, PLACES, places(&entries));
    is_safe.then_some(entries)
}

fn open(bytes: &[u8]) -> Result<Entries, String> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let mut entries = Entries::new();
    let mut left = MAX_SIZE;
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(|e| e.to_string())?;
        let name = entry.name().map_err(|e| e.to_string())?.into_owned();
        if entry.encrypted() {
            return Err(format!("`{name}` is encrypted"));
        }
        let method = entry.compression();
        if !matches!(
            method,
            CompressionMethod::Stored | CompressionMethod::Deflated
        ) {
            return Err(format!("`{name}` is compressed by {method}"));
        }
        if !entry.is_file() {
            continue;
        }
        let mut content = Vec::new();
        let read = entry.by_ref().take(left).read_to_end(&mut content);
        left -= read.map_err(|e| format!("`{name}`: {e}"))? as u64;
        if left == 0 {
            return Err(format!("it unpacks to more than {MAX_SIZE} bytes"));
        }
        entries.insert(name, content);
    }
    Ok(entries)
}

fn names<'a>(names: impl Iterator<Item = &'a str>) -> Outcome {
    let mut outcome = Outcome::default();
    let mut folded = BTreeMap::new();
    for name in names {
        let is_inside = !name.starts_with('/')
            && !name.contains(['\\', '\0', ':'])
            && name.split('/').all(|part| !part.is_empty() && part != "..");
        if !is_inside {
            outcome.fail(format!("`{name}`"));
        }
        if !name.is_ascii() {
            outcome.remark(format!("`{name}` has letters beyond ASCII"));
        }
        if let Some(other) = folded.insert(name.to_lowercase(), name) {
            outcome.remark(format!("`{other}` and `{name}` differ by case only"));
        }
    }
    outcome
}

fn places(entries: &Entries) -> Outcome {
    let mut outcome = Outcome::default();
    if !entries.contains_key("modelDescription.xml") {
        let elsewhere = entries
            .keys()
            .find(|n| n.ends_with("/modelDescription.xml"));
        outcome.fail(match elsewhere {
            Some(name) => format!("modelDescription.xml is at `{name}`, not at the top"),
            None => "there is no modelDescription.xml".to_string(),
        });
    }
    let top: BTreeSet<_> = entries.keys().filter_map(|n| n.split('/').next()).collect();
    for name in top.iter().filter(|name| !TOP.contains(*name)) {
        outcome.remark(format!("the standard knows no `{name}` at the top"));
    }
    let platforms = entries.keys().filter_map(|n| n.strip_prefix("binaries/"));
    let platforms: BTreeSet<_> = platforms
        .filter_map(|n| Some(n.split_once('/')?.0))
        .collect();
    for folder in &platforms {
        let is_known = |known: &str| known == *folder;
        if !PLATFORMS.iter().any(|p| is_known(p.folder)) && !is_known(WASM.folder) {
            outcome.remark(format!(
                "the standard knows no platform `binaries/{folder}`"
            ));
        }
    }
    if platforms.is_empty() && !top.contains("sources") {
        outcome.fail("there are neither binaries nor sources");
    }
    outcome
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(files: &[&str]) -> Entries {
        let files = files.iter().map(|name| ((*name).to_string(), Vec::new()));
        files.collect()
    }

    #[test]
    fn names_that_leave_the_folder_are_found() {
        let found = |name: &str| names([name].into_iter()).fails.len();
        assert_eq!(found("resources/a b.txt"), 0);
        for name in ["../x", "a/../x", "/x", "a//x", "C:/x", "a\\x"] {
            assert_eq!(found(name), 1, "{name}");
        }
        let twins = names(["a/X", "a/x"].into_iter());
        assert_eq!(twins.remarks, ["`a/X` and `a/x` differ by case only"]);
    }

    #[test]
    fn misplaced_files_are_found() {
        let sound = entries(&["modelDescription.xml", "binaries/linux64/X.so"]);
        assert_eq!(places(&sound), Outcome::default());
        let nested = places(&entries(&[
            "X/modelDescription.xml",
            "X/binaries/linux64/X.so",
        ]));
        assert_eq!(nested.fails.len(), 2, "{nested:?}");
        assert_eq!(nested.remarks, ["the standard knows no `X` at the top"]);
        let odd = places(&entries(&["modelDescription.xml", "binaries/amiga/X.so"]));
        assert_eq!(
            odd.remarks,
            ["the standard knows no platform `binaries/amiga`"]
        );
    }

    #[test]
    fn what_is_no_archive_is_said() {
        let mut report = Report::default();
        assert!(check(b"text", &mut report).is_none());
        assert_eq!(report.rows[0].outcome.fails.len(), 1);
    }
}
