//! FMUs and systems of a machine for tools that know no machine file (`hdrm-fmu machine pack`).
//!
//! The machine is written into the libraries themselves ([`inscribe`]), which then describe
//! themselves anew: start values, modelName and GUID are those of their tables. So every tool gets
//! the machine, with or without the FMU's resources. The systems bind what a run with `--machine`
//! binds.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use cosim::cli::find;
use cosim::structure::DataType;
use fmi_description::xml::Element;
use fmi_description::{Description, Entries, Version, entries};
use fmi_import::{exported_files, platform};
use machine_file::{Machine, Source, inscribe};
use motion_check::gain_rule::{Actuators, IDEAL, gain, take};
use output_file::TemporaryFolder;

use super::machine_choice::{MACHINE_FILE, ORIGIN, bound_to, ruled};
use super::run_setup::MachineArgs;
use crate::machines::strokes::beyond_strokes;
use crate::worlds::World;

/// Folder of the FMUs of FMI 3.0 beside those of FMI 2.0.
const FMI_3: &str = "fmi3";
/// The machine among an FMU's resources, which counts where a user edits it.
const RESOURCE: &str = "resources/reference_machine.json";
/// Results of the reference machine, for smoke tests.
const REFERENCE_RESULTS: &str = "extra/org.fmi-standard.fmi-ls-ref/";
/// The component whose start values have the gains of the ideal world.
const CONTROLLER: &str = "controller";

/// Packs the FMUs and systems of a machine file, or shipped machine, into a folder. Writes nothing
/// before all are made; returns the files.
pub fn pack(machine: &str, out: &Path) -> Result<Vec<PathBuf>> {
    let in_machine = || format!("--machine {machine}");
    let packer = Packer::new(machine).with_context(in_machine)?;
    let first = find(World::Ideal.system())?;
    let folder = first.parent().context("a system lies in a folder")?;
    let mut made = BTreeMap::new();
    for (version, part) in [(Version::Fmi2, ""), (Version::Fmi3, FMI_3)] {
        let fmus = files(&folder.join(part), "fmu")?;
        ensure!(
            !fmus.is_empty(),
            "there are no FMUs in {}",
            folder.join(part).display()
        );
        for file in fmus {
            let name = || file.display().to_string();
            let (name, entries) = packer.fmu(&file, version).with_context(name)?;
            made.insert(Path::new(part).join(name), entries);
        }
    }
    for file in files(folder, "ssp")? {
        let name = || file.display().to_string();
        let entries = packer.system(&file, &made).with_context(name)?;
        made.insert(packer.named(&file).into(), entries);
    }
    fs::create_dir_all(out.join(FMI_3)).with_context(|| out.display().to_string())?;
    let written = made.iter().map(|(name, entries)| {
        let path = out.join(name);
        entries::write(&path, entries)?;
        Ok(path)
    });
    written.collect()
}

/// The files in a folder whose names end so, sorted.
fn files(folder: &Path, ending: &str) -> Result<Vec<PathBuf>> {
    let read = fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let paths = read.map(|entry| Ok(entry?.path()));
    let mut paths = paths.collect::<Result<Vec<_>>>()?;
    paths.retain(|path| path.extension().is_some_and(|end| end == ending));
    paths.sort();
    Ok(paths)
}

/// A machine that is packed.
struct Packer<'a> {
    /// Its file, or the name of a shipped machine.
    file: &'a str,
    /// Its name, as a part of an identifier.
    name: String,
    machine: Machine,
    /// With the gains of the ideal world.
    ruled: Machine,
}

impl<'a> Packer<'a> {
    fn new(file: &'a str) -> Result<Self> {
        output_file::note_read(file.as_ref())?;
        let Source { machine, .. } = Source::named(file)?;
        let unfit = beyond_strokes(&machine)?;
        ensure!(unfit.is_empty(), "{}", unfit.join("; "));
        let mut ruled_machine = machine.clone();
        let gains = ruled(&machine, Actuators::Known, &[])?.gains;
        take(&mut ruled_machine.controller, &gains);
        let stem = Path::new(file).file_stem().unwrap_or_default();
        let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        Ok(Self {
            file,
            name: stem.to_string_lossy().chars().map(letter).collect(),
            machine,
            ruled: ruled_machine,
        })
    }

    /// Name of the file that is made of this one: `Hdrm.fmu` becomes `Hdrm_forester.fmu`.
    fn named(&self, file: &Path) -> String {
        let [stem, end] = [file.file_stem(), file.extension()]
            .map(|part| part.unwrap_or_default().to_string_lossy());
        format!("{stem}_{}.{end}", self.name)
    }

    /// Name and files of an FMU with the machine, or as it is if it depends on none.
    fn fmu(&self, file: &Path, version: Version) -> Result<(String, Entries)> {
        let mut entries = entries::read(file)?;
        let description = description(&entries)?;
        if description.index(MACHINE_FILE).is_none() {
            let name = file.file_name().unwrap_or_default();
            return Ok((name.to_string_lossy().into_owned(), entries));
        }
        let machine = match description.index(IDEAL[0]) {
            Some(_) => &self.ruled,
            None => &self.machine,
        };
        let json = serde_json::to_string(machine)?;
        let binaries = entries.iter_mut();
        for (path, bytes) in binaries.filter(|(path, _)| path.starts_with("binaries/")) {
            inscribe(bytes, &self.name, &json).with_context(|| path.clone())?;
        }
        let host = platform::host()?.library(version, &description.identifier);
        let library = host.and_then(|path| entries.get(&path).map(|bytes| (path, bytes)));
        let (path, bytes) = library.context("it has no library for this machine")?;
        let folder = TemporaryFolder::new()?;
        let library = folder.path().join(path.replace('/', "-"));
        fs::write(&library, bytes)?;
        let exported = exported_files(&library, version)?;
        entries.extend(exported);
        entries.insert(RESOURCE.into(), json.into_bytes());
        entries.retain(|path, _| !path.starts_with(REFERENCE_RESULTS));
        Ok((self.named(file), entries))
    }

    /// Files of a system with the FMUs that are made, and with bindings in all its structures.
    fn system(&self, file: &Path, made: &BTreeMap<PathBuf, Entries>) -> Result<Entries> {
        let old = entries::read(file)?;
        let mut new = Entries::new();
        let mut renamed = Vec::new();
        for (path, bytes) in &old {
            let named = self.named(Path::new(path));
            match made.get(Path::new(&named)) {
                Some(fmu) if path.ends_with(".fmu") => {
                    let place = Path::new(path).with_file_name(&named);
                    let place = place.to_string_lossy().replace('\\', "/");
                    new.insert(place.clone(), entries::stored(fmu)?);
                    renamed.push((path, place));
                }
                _ => drop(new.insert(path.clone(), bytes.clone())),
            }
        }
        let mut sets: Vec<(String, String)> = Vec::new();
        for (name, bytes) in old.iter().filter(|(name, _)| name.ends_with(".ssd")) {
            let mut text = std::str::from_utf8(bytes)
                .with_context(|| name.clone())?
                .to_owned();
            for (path, place) in &renamed {
                text = text.replace(
                    &format!("source=\"{path}\""),
                    &format!("source=\"{place}\""),
                );
            }
            let parameters = self.bound(file, name).with_context(|| name.clone())?;
            let known = sets.iter().find(|(_, known)| *known == parameters);
            let path = match known {
                Some((path, _)) => path.clone(),
                None => {
                    let number = match sets.len() {
                        0 => String::new(),
                        n => format!("_{}", n + 1),
                    };
                    let path = format!("resources/{}{number}.ssv", self.name);
                    sets.push((path.clone(), parameters));
                    path
                }
            };
            let text = self.structure(&text, name, &path)?;
            new.insert(name.clone(), text.into_bytes());
        }
        new.extend(sets.into_iter().map(|(path, set)| (path, set.into_bytes())));
        Ok(new)
    }

    /// The parameter set with what a run of a structure with `--machine` binds, and with the
    /// machine's own gains where it binds none: the start values are those of the ideal world.
    fn bound(&self, system: &Path, structure: &str) -> Result<String> {
        let arguments = MachineArgs::of(self.file).in_structure(system, structure);
        let system = arguments.setup().system()?;
        let mut lines = String::new();
        let mut line = |component: &str, name: &str, kind: &str, value: &str| {
            lines += &format!(
                "    <ssv:Parameter name=\"{component}.{name}\"><ssv:{kind} value=\"{value}\"/></ssv:Parameter>\n"
            );
        };
        for (component, fmu) in system.structure.components.iter().zip(&system.fmus) {
            let own = component.parameters.iter();
            let own = own.filter(|p| p.origin == ORIGIN && p.name != MACHINE_FILE);
            for parameter in own {
                let kind = match parameter.data_type {
                    DataType::Integer => "Integer",
                    _ => "Real",
                };
                line(&component.name, &parameter.name, kind, &parameter.value);
            }
            for name in IDEAL {
                if component.name == CONTROLLER
                    && fmu.description.index(name).is_some()
                    && bound_to(component, name).is_none()
                {
                    let value = gain(&self.machine.controller, name).to_string();
                    line(&component.name, name, "Real", &value);
                }
            }
        }
        Ok(format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- What a run of this system with the machine {0} binds: gains by the rule, actuators, weight of the network. -->\n\
             <ssv:ParameterSet xmlns:ssv=\"http://ssp-standard.org/SSP1/SystemStructureParameterValues\" version=\"1.0\" name=\"{0}\">\n  \
             <ssv:Parameters>\n{lines}  </ssv:Parameters>\n</ssv:ParameterSet>\n",
            self.name
        ))
    }

    /// The text of a structure under a name of its own, with a parameter set bound last.
    fn structure(&self, text: &str, file: &str, set: &str) -> Result<String> {
        let root = Element::parse(text, file, "SystemStructureDescription")?;
        let system = root.child("System").context("it has no System")?;
        let binding = format!("<ssd:ParameterBinding source=\"{set}\"/>");
        let bindings = system.child("ParameterBindings");
        let last = bindings.and_then(|bindings| bindings.children.last());
        let (at, insertion) = match (last, system.child("Elements")) {
            (Some(last), _) => (last.range.end, binding),
            (None, Some(elements)) => (
                elements.range.start,
                format!("<ssd:ParameterBindings>{binding}</ssd:ParameterBindings>\n    "),
            ),
            (None, None) => anyhow::bail!("`{file}` has no Elements"),
        };
        let (before, after) = text.split_at(at);
        let name = format!(" name=\"{}\"", root.required("name")?);
        let start = root.range.start;
        let (head, rest) = before.split_at(start);
        let (left, right) = rest
            .split_once(&name)
            .with_context(|| format!("`{file}` must hold{name}, written so"))?;
        let renamed = format!("{}_{}\"", &name[..name.len() - 1], self.name);
        Ok(format!("{head}{left}{renamed}{right}{insertion}{after}"))
    }
}

/// The model description among the files of an FMU.
fn description(entries: &Entries) -> Result<Description> {
    let bytes = entries.get("modelDescription.xml");
    let bytes = bytes.context("it has no modelDescription.xml")?;
    Ok(Description::parse(std::str::from_utf8(bytes)?)?)
}
