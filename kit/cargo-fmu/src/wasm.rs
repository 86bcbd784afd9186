//! Adds WebAssembly to FMUs of FMI 3.0 by the draft FMI-LS-WASM, for `cargo fmu pack` and `xtask`:
//! a module of the model is made a component with the interface `fmi3.wit`.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use fmu_check::component::{MANIFEST, interface, path};
use wit_component::{ComponentEncoder, StringEncoding, embed_component_metadata};

use crate::library;
use crate::target::{self, Tools};
use crate::workspace::{Source, Workspace};
use fmi_description::entries;
use fmi_import::portability;

/// Builds modules of these sources, and adds each as a component to the FMU of FMI 3.0 at its
/// place.
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
        let named = portability::folders_in(&bytes, &folders);
        ensure!(
            named.is_empty(),
            "{name} is not for every machine: it names {}",
            named.join(", ")
        );
        let component = component(&bytes).with_context(|| name.to_string())?;
        let fmu = fmu.as_ref();
        let mut entries = entries::read(fmu)?;
        let identifier = library::description(&entries)?.identifier;
        let (manifest, text) = MANIFEST;
        entries.insert(manifest.to_string(), text.into());
        entries.insert(path(&identifier), component);
        let size = entries::write(fmu, &entries)?;
        println!(
            "packed {} with WebAssembly ({} kB)",
            fmu.display(),
            size / 1000
        );
    }
    Ok(())
}

/// The component of a module that was made with `fmu_export::export_fmu!`.
pub fn component(module: &[u8]) -> Result<Vec<u8>> {
    let (resolve, world) = interface("fmu")?;
    let mut module = module.to_vec();
    embed_component_metadata(&mut module, &resolve, world, StringEncoding::UTF8, false)?;
    ComponentEncoder::default().module(&module)?.encode()
}
