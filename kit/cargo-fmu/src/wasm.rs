//! WebAssembly in FMUs of FMI 3.0, as the draft FMI-LS-WASM has it: a module of the model becomes a
//! component, whose interface is `fmi3.wit`.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use wasmparser::{Parser, Payload, Validator, WasmFeatures};
use wit_component::{ComponentEncoder, StringEncoding, embed_component_metadata};
use wit_parser::{Resolve, WorldId};

use crate::archive;
use crate::library;
use crate::portability;
use crate::target::{self, Tools};
use crate::workspace::{Source, Workspace};

const INTERFACE: &str = include_str!("fmi3.wit");
/// The world of an FMU for co-simulation.
const WORLD: &str = "co-simulation-fmu";
/// Where the draft wants its manifest, and what it is to say.
pub const MANIFEST: (&str, &str) = (
    "extra/org.modelica.fmi-ls-wasm/manifest.xml",
    r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiLayeredStandardManifest xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
  fmi-ls:fmi-ls-name="org.modelica.fmi-ls-wasm"
  fmi-ls:fmi-ls-version="0.1.0"
  fmi-ls:fmi-ls-description="FMI Layered Standard for WebAssembly"/>
"#,
);

/// Where the component of an FMU lies in its archive.
pub fn path(identifier: &str) -> String {
    format!("binaries/wasm32-wasip2/{identifier}.wasm")
}

/// Builds modules of these sources and adds them as components to the archives of FMI 3.0, one for
/// each source.
pub fn add(
    workspace: &Workspace,
    sources: &[Source],
    profile: &[String],
    fmus: &[impl AsRef<Path>],
) -> Result<()> {
    ensure!(
        fmus.len() == sources.len(),
        "there must be as many FMUs as packages"
    );
    let build = target::WASM.build(workspace, &Tools::default())?;
    let built = workspace.build_with(build, sources, profile)?;
    let folders = target::private_folders(workspace)?;
    for ((module, _), fmu) in built.iter().zip(fmus) {
        let name = module.display();
        let bytes = fs::read(module).with_context(|| name.to_string())?;
        let named = portability::named(&bytes, &folders);
        ensure!(
            named.is_empty(),
            "{name} is not for every machine: it names {}",
            named.join(", ")
        );
        let component = component(&bytes).with_context(|| name.to_string())?;
        let fmu = fmu.as_ref();
        let mut entries = archive::read(fmu)?;
        let identifier = library::description(&entries)?.identifier;
        let (manifest, text) = MANIFEST;
        entries.insert(manifest.to_string(), text.into());
        entries.insert(path(&identifier), component);
        let size = archive::write(fmu, &entries)?;
        println!(
            "packed {} with WebAssembly ({} kB)",
            fmu.display(),
            size / 1000
        );
    }
    Ok(())
}

/// The interface, and the world that a component is for.
fn interface() -> Result<(Resolve, WorldId)> {
    let mut resolve = Resolve::default();
    let package = resolve.push_str("fmi3.wit", INTERFACE)?;
    let world = resolve.select_world(&[package], Some(WORLD))?;
    Ok((resolve, world))
}

/// The component of a module that was made with `fmu_export::export_fmu!`.
pub fn component(module: &[u8]) -> Result<Vec<u8>> {
    let (resolve, world) = interface()?;
    let mut module = module.to_vec();
    embed_component_metadata(&mut module, &resolve, world, StringEncoding::UTF8, false)?;
    ComponentEncoder::default().module(&module)?.encode()
}

/// Why a file is no component for this world, if it is none.
pub fn world_fault(component: &[u8]) -> Option<String> {
    if Parser::is_core_wasm(component) {
        return Some("it is a module, not a component".to_string());
    }
    let fault = || {
        Validator::new_with_features(WasmFeatures::all()).validate_all(component)?;
        let (resolve, world) = interface()?;
        wit_component::targets(&resolve, world, component, false)
    };
    fault().err().map(|error| format!("{error:#}"))
}

/// Names of what a component imports.
pub fn imports(component: &[u8]) -> Result<Vec<String>> {
    let (mut names, mut depth) = (Vec::new(), 0);
    for payload in Parser::new(0).parse_all(component) {
        match payload? {
            Payload::ModuleSection { .. } | Payload::ComponentSection { .. } => depth += 1,
            Payload::End(_) => depth -= 1,
            Payload::ComponentImportSection(imports) if depth == 0 => {
                for import in imports {
                    names.push(import?.name.name.to_string());
                }
            }
            _ => {}
        }
    }
    Ok(names)
}

/// The module that a component was made of: the first one in it. None in a module.
pub fn module(component: &[u8]) -> Result<Option<&[u8]>> {
    for payload in Parser::new(0).parse_all(component) {
        if let Payload::ModuleSection {
            unchecked_range, ..
        } = payload?
        {
            let range = unchecked_range.start as usize..unchecked_range.end as usize;
            return Ok(component.get(range));
        }
    }
    Ok(None)
}

/// Names of what a module exports.
pub fn exports(module: &[u8]) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for payload in Parser::new(0).parse_all(module) {
        if let Payload::ExportSection(exports) = payload? {
            for export in exports {
                names.push(export?.name.to_string());
            }
        }
    }
    Ok(names)
}
