//! Checks the archive, for `fmu_check::check`: whether it opens everywhere, unpacks safely, and has
//! its files where the standard puts them.

use std::collections::{BTreeMap, BTreeSet};

use fmi_description::platform::WASM;
use fmi_description::{Archive, ArchiveError, Entries, unportable};

use super::binaries::PLATFORMS;
use super::outcome::{Outcome, Promise, Report};

const AREA: &str = "archive";
const OPENS: Promise = Promise {
    text: "it is a ZIP archive, stored or deflated, not encrypted, with nothing before it",
    why: "importers open nothing else [FMI 2.0, 2.3; FMI 3.0, 2.5]",
};
const SAFE: Promise = Promise {
    text: "names of files stay inside the archive, each is there once, and they fit every file system; there are no links",
    why: "`../x` or `C:\\x` writes outside the folder it is unpacked to; names that differ by case only are one file on Windows and macOS [FMI 2.0, 2.3; FMI 3.0, 2.5; APPNOTE 4.4.17]",
};
const PLACES: Promise = Promise {
    text: "files lie where the standard puts them",
    why: "importers look for them there, and nowhere else [FMI 2.0, 2.3; FMI 3.0, 2.5.1]",
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

/// Checks the archive; returns its files if importers open it, as [`Archive::open`] says for all of
/// this project.
pub fn check(bytes: Vec<u8>, report: &mut Report) -> Option<Entries> {
    let opened = Archive::open(bytes).and_then(|mut archive| {
        let files = archive.read_all()?;
        Ok((files, names(&archive)))
    });
    let (entries, safe) = match opened {
        Ok(opened) => opened,
        Err(reason @ (ArchiveError::Unsafe { .. } | ArchiveError::Repeated)) => {
            report.push(AREA, OPENS, Outcome::default());
            report.push(AREA, SAFE, Outcome::failed(reason.to_string()));
            return None;
        }
        Err(reason) => {
            report.push(AREA, OPENS, Outcome::failed(reason.to_string()));
            return None;
        }
    };
    report.push(AREA, OPENS, Outcome::default());
    report.push(AREA, SAFE, safe);
    report.push(AREA, PLACES, places(&entries));
    Some(entries)
}

fn names(archive: &Archive) -> Outcome {
    let mut outcome = Outcome::default();
    let mut folded = BTreeMap::new();
    for remark in archive.remarks() {
        outcome.fail(remark.to_string());
    }
    for name in archive.names() {
        if let Some(reason) = unportable(name) {
            outcome.fail(format!("`{name}` {reason}"));
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
    fn names_that_not_all_can_have_are_found() {
        let names = |files: &[&str]| {
            let bytes = fmi_description::entries::stored(&entries(files)).unwrap();
            names(&Archive::open(bytes).unwrap())
        };
        assert_eq!(names(&["resources/a b.txt"]), Outcome::default());
        for name in ["a\\x", "a/NUL.txt", "a/x.", "a/x?"] {
            assert_eq!(names(&[name]).fails.len(), 1, "{name}");
        }
        let twins = names(&["a/X", "a/x"]);
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
        assert!(check(b"text".to_vec(), &mut report).is_none());
        assert_eq!(report.rows[0].outcome.fails.len(), 1);
    }
}
