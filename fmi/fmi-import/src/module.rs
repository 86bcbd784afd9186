//! The WebAssembly module of an FMU, which `fmu` uses instead of a shared library when this crate
//! runs in a page: the host of WebAssembly compiles it, and forwards functions of FMI 3.0 to it.

use std::ffi::{c_int, c_void};

use anyhow::{Context, Result, bail, ensure};
use fmi_description::{Archive, Description, Version};

use crate::calls::{Exports, Logger, Offered};
use crate::messages;
use crate::standard::{Pointer, Text, fmi3_functions};

/// Folders of an archive for a plain module, and for a module in a component.
const FOLDERS: [&str; 2] = ["binaries/wasm32-unknown-unknown", "binaries/wasm32-wasip2"];

/// A module that the host has compiled.
pub struct Library(u32);

#[link(wasm_import_module = "host")]
unsafe extern "C" {
    /// Compiles a module; returns its number, or -1 after a message that says why not.
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
    /// Lets the host compile the module of an FMU. The path that is returned as that of the
    /// resources, which a module cannot read, identifies the module to the host.
    ///
    /// # Errors
    /// The FMU has no module, or the host cannot compile it.
    pub fn load(
        file: &str,
        archive: &mut Archive,
        description: &Description,
    ) -> Result<(Self, String)> {
        ensure!(
            description.fmi == Version::Fmi3,
            "it is of FMI 2.0; a page runs FMUs of FMI 3.0 with WebAssembly"
        );
        let [path, inside] =
            FOLDERS.map(|folder| format!("{folder}/{}.wasm", description.identifier));
        let bytes = match (archive.file(&path)?, archive.file(&inside)?) {
            (Some(module), _) => module,
            (None, Some(component)) => {
                let module = first_module(&component).map(<[u8]>::to_vec);
                module.with_context(|| format!("`{inside}` is no component that holds a module"))?
            }
            (None, None) => bail!(
                "it has no WebAssembly for a page: there is neither `{path}` nor `{inside}` in it (cargo fmu pack --target wasm adds it)"
            ),
        };
        let Ok(module) = u32::try_from(load(bytes.as_ptr(), bytes.len())) else {
            let reasons = messages::take().into_iter().map(|m| m.text);
            bail!("{file}: {path}: {}", reasons.collect::<Vec<_>>().join("; "));
        };
        Ok((Self(module), format!("/{module}/")))
    }
}

impl Exports for Library {
    unsafe fn function<F: Copy>(&self, name: &str) -> Option<F> {
        let is_there = exports(self.0, name.as_ptr(), name.len());
        // SAFETY: forwarded.
        is_there.then(|| unsafe { Offered(imported).function(name) })?
    }
}

/// The first module in a component of the Component Model. Each section is a kind, a size (LEB128)
/// and that many bytes; kind 1 is a module.
fn first_module(component: &[u8]) -> Option<&[u8]> {
    const MODULE: u8 = 1;
    let mut rest = component.get(8..)?;
    loop {
        let (kind, mut after) = rest.split_first()?;
        let (mut size, mut shift) = (0usize, 0);
        loop {
            let (byte, next) = after.split_first()?;
            size |= usize::from(byte & 0x7F).checked_shl(shift)?;
            (after, shift) = (next, shift + 7);
            if byte & 0x80 == 0 {
                break;
            }
        }
        let (section, next) = after.split_at_checked(size)?;
        if *kind == MODULE {
            return Some(section);
        }
        rest = next;
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        unload(self.0);
    }
}
