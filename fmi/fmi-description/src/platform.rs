//! Platforms that FMUs have folders for, by FMI 2.0 (section 2.3) and 3.0 (section 2.5.1.4), for
//! the importer, the check and `cargo fmu`.
//!
//! ```
//! use fmi_description::{Version, platform::WINDOWS};
//! let library = WINDOWS.library(Version::Fmi3, "My");
//! assert_eq!(library.as_deref(), Some("binaries/x86_64-windows/My.dll"));
//! ```

use crate::description::Version;

/// A platform, with the folder and suffix of its libraries in an FMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder in `binaries/` of FMI 2.0, or of FMI 3.0 if FMI 2.0 has none.
    pub folder: &'static str,
    /// Folder in `binaries/` of FMI 3.0.
    pub folder_3: &'static str,
    /// Suffix of a library, with its dot.
    pub suffix: &'static str,
}

impl Platform {
    const fn new(folder: &'static str, folder_3: &'static str, suffix: &'static str) -> Self {
        Self {
            folder,
            folder_3,
            suffix,
        }
    }

    /// Whether FMI 2.0 has a folder for it.
    pub fn is_in_fmi2(&self) -> bool {
        self.folder != self.folder_3
    }

    /// Path of the library of an FMU in its archive; None if the version has no folder for it.
    pub fn library(&self, version: Version, identifier: &str) -> Option<String> {
        let folder = match version {
            Version::Fmi2 => self.is_in_fmi2().then_some(self.folder)?,
            Version::Fmi3 => self.folder_3,
        };
        Some(format!("binaries/{folder}/{identifier}{}", self.suffix))
    }
}

/// Linux on x86-64.
pub const LINUX: Platform = Platform::new("linux64", "x86_64-linux", ".so");
/// Windows on x86-64.
pub const WINDOWS: Platform = Platform::new("win64", "x86_64-windows", ".dll");
/// macOS on x86-64. FMI 2.0 names no processor here; it was written when Macs had no other.
pub const MACOS: Platform = Platform::new("darwin64", "x86_64-darwin", ".dylib");
/// Linux on 64-bit ARM.
pub const LINUX_ARM: Platform = Platform::new("aarch64-linux", "aarch64-linux", ".so");
/// macOS on 64-bit ARM.
pub const MACOS_ARM: Platform = Platform::new("aarch64-darwin", "aarch64-darwin", ".dylib");

/// WebAssembly for every machine, by the draft FMI-LS-WASM.
pub const WASM: Platform = Platform::new("wasm32-wasip2", "wasm32-wasip2", ".wasm");

/// The platform of this machine, if FMUs have a folder for it.
pub fn host() -> Option<Platform> {
    match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => Some(LINUX),
        ("linux", "aarch64") => Some(LINUX_ARM),
        ("windows", "x86_64") => Some(WINDOWS),
        ("macos", "x86_64") => Some(MACOS),
        ("macos", "aarch64") => Some(MACOS_ARM),
        _ => None,
    }
}
