//! Reads any structure for `System` and `cosim info`: one of SSP as it is, one of the Open
//! Simulation Platform as the structure of SSP that `system-structure` makes of it. Writes the
//! latter with its FMUs as a packed system (`cosim convert`).

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use fmi_description::{Archive, Entries, entries};
use system_structure::osp::{Converted, Model, convert as to_ssp};

use super::flat::Structure;
use super::flatten::read as read_ssp;
use super::package::{DEFAULT, FmuPlace, Package, read as read_file};

/// What the name of a file with groups of variables ends with.
const GROUPS: &str = "OspModelDescription.xml";

/// Read the structure of a package: of a packed system the one named `variant`, else the default
/// one. `replaced` gives components other FMU files.
pub fn read(
    package: &mut Package,
    variant: Option<&str>,
    place: &FmuPlace,
    replaced: &[(String, PathBuf)],
) -> Result<Structure> {
    let (mut text, mut remarks) = (package.structure(variant)?, Vec::new());
    let mut name = package.structure_name(variant);
    // Pages, which have packed systems only, are built without.
    if cfg!(feature = "native") && package.is_osp() {
        let converted = converted(package, &text, place, replaced, None)?;
        (text, remarks) = (converted.text, converted.remarks);
        name += " (as SSP)";
    }
    let mut structure = read_ssp(&text, &name, &mut |source| package.text(source))?;
    structure.remarks.append(&mut remarks);
    Ok(structure)
}

/// Write a system of the Open Simulation Platform with its FMUs as the packed system `output`.
/// Returns remarks.
pub fn convert(package: &mut Package, place: &FmuPlace, output: &Path) -> Result<Vec<String>> {
    let file = package.path().display().to_string();
    ensure!(
        package.is_osp(),
        "`{file}` is no OspSystemStructure.xml; only systems of the Open Simulation Platform are converted"
    );
    let text = package.structure(None)?;
    let mut files = Entries::new();
    let converted = converted(package, &text, place, &[], Some(&mut files));
    let converted = converted.with_context(|| format!("`{file}`"))?;
    // What is written is read, so that it runs.
    read_ssp(&converted.text, DEFAULT, &mut |source| package.text(source))?;
    files.insert(DEFAULT.into(), converted.text.into_bytes());
    entries::write(output, &files)?;
    Ok(converted.remarks)
}

/// The structure of SSP; its FMUs are put into `files`.
fn converted(
    package: &mut Package,
    text: &str,
    place: &FmuPlace,
    replaced: &[(String, PathBuf)],
    mut files: Option<&mut Entries>,
) -> Result<Converted> {
    let name = package.structure_name(None);
    let mut models: HashMap<String, Arc<Model>> = HashMap::new();
    let mut model = |simulator: &str, source: &str| {
        let own = replaced.iter().find(|(name, _)| name == simulator);
        let path = match own {
            Some((_, file)) => file.display().to_string(),
            None => local(source)?.to_string(),
        };
        if let Some(model) = models.get(&path) {
            return Ok(model.clone());
        }
        let bytes = match own {
            Some((_, file)) => read_file(file),
            None => place.read(&path, package),
        };
        let context = || format!("FMU `{path}`");
        let mut archive = Archive::open(bytes?).with_context(context)?;
        let description = archive.description().with_context(context)?.by_element();
        let groups = groups(package, &path, &description.model, &mut archive);
        let mut written = match own {
            Some(_) => source.to_string(),
            None => path.clone(),
        };
        if let Some(files) = &mut files {
            let stem = Path::new(&path).file_stem().unwrap_or_default();
            let stem = stem.to_string_lossy();
            let names = (1..).map(|k| match k {
                1 => format!("resources/{stem}.fmu"),
                _ => format!("resources/{stem}_{k}.fmu"),
            });
            let free = names.into_iter().find(|name| !files.contains_key(name));
            written = free.unwrap_or_default();
            files.insert(written.clone(), archive.into_bytes());
        }
        let model = Arc::new(Model {
            description,
            groups,
            source: written,
        });
        models.insert(path, model.clone());
        Ok(model)
    };
    let mut model = |simulator: &str, source: &str| {
        let model: Result<_> = model(simulator, source);
        model.map_err(|error| format!("{error:#}"))
    };
    Ok(to_ssp(text, &name, &mut model)?)
}

/// The path in the source of a simulator.
fn local(source: &str) -> Result<&str> {
    let scheme = source.split_once(':').map(|(scheme, _)| scheme);
    // A single letter is a drive.
    match scheme.filter(|scheme| scheme.len() > 1 && !scheme.contains('/')) {
        None => Ok(source),
        Some("file") => {
            let path = &source["file:".len()..];
            let path = path.strip_prefix("//localhost").unwrap_or(path);
            Ok(path.strip_prefix("//").unwrap_or(path))
        }
        Some("proxyfmu") => bail!(
            "the source `{source}` is an FMU in another process (`proxyfmu:`), which is not supported: name the FMU itself (--fmu SIMULATOR=FILE), \
             or run the system in a program of libcosim, which calls the server `proxyfmu` of OSP's proxy-fmu on that machine"
        ),
        Some(scheme @ ("http" | "https")) => bail!(
            "the source `{source}` is on a server (`{scheme}:`), which is not supported: download the FMU and name the file (--fmu SIMULATOR=FILE)"
        ),
        Some(scheme) => bail!(
            "the source `{source}` has the scheme `{scheme}:`; it must be a path relative to the structure or a `file:` URI"
        ),
    }
}

/// Name and text of the groups of an FMU: next to it, next to the structure, or in it.
fn groups(
    package: &mut Package,
    path: &str,
    model: &str,
    archive: &mut Archive,
) -> Option<(String, String)> {
    let name = format!("{model}_{GROUPS}");
    let folder = &path[..path.rfind('/').map_or(0, |slash| slash + 1)];
    for file in [format!("{folder}{name}"), name] {
        if let Ok(text) = package.text(&file) {
            return Some((file, text));
        }
    }
    let inner = archive.names().find(|name| name.ends_with(GROUPS))?;
    let inner = inner.to_string();
    let bytes = archive.file(&inner).ok()??;
    let text = fmi_description::text(&bytes).ok()?;
    Some((format!("{path}/{inner}"), text))
}
