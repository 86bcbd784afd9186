//! Reads WebAssembly components of FMUs of FMI 3.0, which follow the draft FMI-LS-WASM and its
//! interface `fmi3.wit`, for the check of them (`wasm`) and for `cargo fmu`, which makes them.
//!
//! ```
//! let module = b"\0asm\x01\0\0\0";
//! let fault = fmu_check::component::world_fault(module).unwrap();
//! assert_eq!(fault, "it is a module, not a component");
//! ```

use anyhow::Result;
use wasmparser::{Parser, Payload, Validator, WasmFeatures};
use wit_parser::{Resolve, WorldId};

const INTERFACE: &str = include_str!("fmi3.wit");
/// Path and content of the manifest that the draft demands.
pub const MANIFEST: (&str, &str) = (
    "extra/org.modelica.fmi-ls-wasm/manifest.xml",
    r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiLayeredStandardManifest xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
  fmi-ls:fmi-ls-name="org.modelica.fmi-ls-wasm"
  fmi-ls:fmi-ls-version="0.1.0"
  fmi-ls:fmi-ls-description="FMI Layered Standard for WebAssembly"/>
"#,
);

/// Path of the component of an FMU in its archive.
pub fn path(identifier: &str) -> String {
    format!("binaries/wasm32-wasip2/{identifier}.wasm")
}

/// The interface, and in it a world that a component implements: `co-simulation-fmu`,
/// `model-exchange-fmu`, or `fmu` for both.
pub fn interface(world: &str) -> Result<(Resolve, WorldId)> {
    let mut resolve = Resolve::default();
    let package = resolve.push_str("fmi3.wit", INTERFACE)?;
    let world = resolve.select_world(&[package], Some(world))?;
    Ok((resolve, world))
}

/// Why a file is no component of an FMU for Co-Simulation, if it is none.
pub fn world_fault(component: &[u8]) -> Option<String> {
    if Parser::is_core_wasm(component) {
        return Some("it is a module, not a component".to_string());
    }
    let fault = || {
        Validator::new_with_features(WasmFeatures::all()).validate_all(component)?;
        let (resolve, world) = interface("co-simulation-fmu")?;
        wit_component::targets(&resolve, world, component, false)
    };
    fault().err().map(|error| format!("{error:#}"))
}

/// Names of the imports of a component.
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

/// The first module in a component, of which it was made; None in a module.
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

/// Names of the exports of a module.
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
