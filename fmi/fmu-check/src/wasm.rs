//! Checks WebAssembly components by FMI-LS-WASM, for `fmu_check::check`, without running them.

use fmi_description::platform::WASM;

use super::outcome::{Outcome, Promise, Report};
use crate::component::{MANIFEST, imports, path, world_fault};
use fmi_description::Entries;

const AREA: &str = "WebAssembly";
const WORLD: Promise = Promise {
    text: "it is a component of the world `co-simulation-fmu` of FMI-LS-WASM, with a manifest",
    why: "hosts look for these interfaces when they instantiate it [FMI-LS-WASM, draft]",
};
const ALONE: Promise = Promise {
    text: "it imports nothing but types and callbacks",
    why: "a host must offer all that a component imports; many have no files and no clock [FMI-LS-WASM, draft]",
};

/// Checks the components of an FMU for co-simulation with these model identifiers, if it has any.
pub fn check(entries: &Entries, identifiers: &[&str], report: &mut Report) {
    let folder = format!("binaries/{}/", WASM.folder);
    if !entries.keys().any(|name| name.starts_with(&folder)) {
        return;
    }
    let [mut world, mut alone] = [(); 2].map(|()| Outcome::default());
    if !entries.contains_key(MANIFEST.0) {
        world.fail(format!("there is no {}", MANIFEST.0));
    }
    for path in identifiers.iter().map(|identifier| path(identifier)) {
        let Some(component) = entries.get(&path) else {
            world.fail(format!("there is no {path}"));
            continue;
        };
        if let Some(fault) = world_fault(component) {
            world.fail(format!("{path}: {fault}"));
        }
        let known = |name: &String| {
            ["types", "callbacks", "intermediate-update-callbacks"]
                .iter()
                .any(|own| name.starts_with(&format!("fmi:fmi3/{own}@3.0")))
        };
        match imports(component) {
            Ok(names) => {
                for name in names.iter().filter(|name| !known(name)) {
                    alone.remark(format!("{path} imports {name}"));
                }
            }
            Err(reason) => alone.fail(format!("{path}: {reason}")),
        }
    }
    report.push(AREA, WORLD, world);
    report.push(AREA, ALONE, alone);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Row;

    fn checked(files: &[(&str, &[u8])]) -> Vec<Vec<String>> {
        let files = files
            .iter()
            .map(|(name, bytes)| ((*name).to_string(), bytes.to_vec()));
        let mut report = Report::default();
        check(&files.collect(), &["X"], &mut report);
        let found = |row: &Row| [row.outcome.fails.clone(), row.outcome.remarks.clone()].concat();
        report.rows.iter().map(found).collect()
    }

    #[test]
    fn what_is_no_component_of_the_world_is_found() {
        let path = "binaries/wasm32-wasip2/X.wasm";
        assert!(checked(&[("modelDescription.xml", b"")]).is_empty());
        // An empty component, an empty module, and no WebAssembly.
        let manifest = (MANIFEST.0, MANIFEST.1.as_bytes());
        for (bytes, fault) in [
            (&b"\0asm\x0d\0\x01\0"[..], "fmi:fmi3/co"),
            (b"\0asm\x01\0\0\0", "a module"),
            (b"text", "magic"),
        ] {
            let rows = checked(&[(path, bytes), manifest]);
            assert!(rows[0].len() == 1 && rows[0][0].contains(fault), "{rows:?}");
        }
        let rows = checked(&[("binaries/wasm32-wasip2/Y.wasm", b"")]);
        let missing = [
            format!("there is no {}", MANIFEST.0),
            format!("there is no {path}"),
        ];
        assert_eq!(rows[0], missing);
    }
}
