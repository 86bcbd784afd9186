//! The WebAssembly module of an FMU, in the place of a shared library: the host of WebAssembly keeps
//! it, and forwards the functions of FMI 3.0 to instances of it.
#![allow(unsafe_code)]

use std::ffi::{c_int, c_void};

use anyhow::{Result, anyhow, ensure};
use fmu_description::{
    Archive, Description, Remark, Version, fmi3_functions,
    functions::{Pointer, Text},
};

use super::functions::Logger;
use crate::slave::messages;

/// Folder of the modules in an archive.
const FOLDER: &str = "binaries/wasm32-unknown-unknown";

/// A module that the host has compiled.
pub struct Library(u32);

#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// Compiles a module; its number, or -1 after a message that says why not.
    safe fn load(bytes: *const u8, size: usize) -> c_int;
    /// Forgets a module.
    safe fn unload(module: u32);
    /// Whether a module exports the function of this name.
    safe fn exports(module: u32, name: *const u8, size: usize) -> bool;
}

macro_rules! imports {
    ($($function:ident $interface:ident [$($states:tt)*] ($($argument:ty),*) $(-> $result:ty)?;)*) => {
        // The host forwards each to the module of the instance, whose memory is another one: it
        // copies what is pointed to.
        #[link(wasm_import_module = "fmi3")]
        unsafe extern "C" {
            $(fn $function($(_: $argument),*) $(-> $result)?;)*
        }

        fn imported(name: &str) -> Option<*const c_void> {
            match name {
                $(stringify!($function) => Some($function as *const c_void),)*
                _ => None,
            }
        }
    };
}

fmi3_functions!(imports!);

impl Library {
    /// Have the host compile the module of the FMU `file`. In the place of its resources, which a
    /// module cannot read, is the path by which the host knows the module.
    ///
    /// # Errors
    /// The FMU has no module, or what the host says of it.
    pub fn load(
        file: &str,
        archive: &mut Archive,
        description: &Description,
    ) -> Result<(Self, String, Option<Remark>)> {
        ensure!(
            description.fmi == Version::Fmi3,
            "it is of FMI 2.0; a page runs FMUs of FMI 3.0 with WebAssembly"
        );
        let path = format!("{FOLDER}/{}.wasm", description.identifier);
        let bytes = archive.file(&path)?.ok_or_else(|| {
            anyhow!("it has no WebAssembly for a page: there is no `{path}` in it (cargo fmu pack --target wasm adds it)")
        })?;
        let Ok(module) = u32::try_from(load(bytes.as_ptr(), bytes.len())) else {
            let reasons = messages::take().into_iter().map(|m| m.text);
            return Err(
                anyhow!("{path}: {}", reasons.collect::<Vec<_>>().join("; "))
                    .context(file.to_string()),
            );
        };
        Ok((Self(module), format!("/{module}/"), None))
    }

    /// The exported function `name`.
    ///
    /// # Safety
    /// `F` is the type of a pointer to that function.
    pub unsafe fn function<F: Copy>(&self, name: &str) -> Option<F> {
        let function = imported(name).filter(|_| exports(self.0, name.as_ptr(), name.len()))?;
        // SAFETY: a pointer to the imported function of this name, as the caller promises.
        Some(unsafe { std::mem::transmute_copy(&function) })
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        unload(self.0);
    }
}
