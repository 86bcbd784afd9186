//! The program `cosim-wasm`: the process in which `cosim` runs an FMU whose binary is a component of
//! FMI-LS-WASM. It is a shared library to the rest of the process: `functions` has the C functions
//! of FMI 3.0, and `component` what they call.

mod component;
mod functions;

use std::process::ExitCode;

use fmi_import::isolated::{Load, serve_with};

fn main() -> ExitCode {
    let load: Load = |path, limits| {
        component::load(path, limits)?;
        Ok(functions::named)
    };
    serve_with(Some(load)).unwrap_or_else(|| {
        eprintln!("cosim-wasm: `cosim` starts it for FMUs of WebAssembly; it does nothing alone");
        ExitCode::FAILURE
    })
}
