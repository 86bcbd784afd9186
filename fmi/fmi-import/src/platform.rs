//! Finds for which platform a library was built, by its own header, and which platform this machine
//! is, for the importer, the check, `cargo fmu` and `xtask`.
//!
//! ```
//! let program = std::fs::read(std::env::current_exe()?)?;
//! assert_eq!(fmi_import::platform::detect(&program)?, fmi_import::platform::host()?);
//! # anyhow::Ok(())
//! ```

use anyhow::{Context, Result, bail};
pub use fmi_description::platform::{LINUX, LINUX_ARM, MACOS, MACOS_ARM, Platform, WASM, WINDOWS};
use object::{Architecture, BinaryFormat, Object};

/// The platform that a library or program was built for.
pub fn detect(library: &[u8]) -> Result<Platform> {
    let file = object::File::parse(library).context("not a library")?;
    match (file.format(), file.architecture()) {
        (BinaryFormat::Elf, Architecture::X86_64) => Ok(LINUX),
        (BinaryFormat::Elf, Architecture::Aarch64) => Ok(LINUX_ARM),
        (BinaryFormat::Pe, Architecture::X86_64) => Ok(WINDOWS),
        (BinaryFormat::MachO, Architecture::X86_64) => Ok(MACOS),
        (BinaryFormat::MachO, Architecture::Aarch64) => Ok(MACOS_ARM),
        (format, processor) => bail!(
            "built for {processor:?} ({format:?}), but must be for Linux, Windows or macOS on x86-64, or for Linux or macOS on 64-bit ARM"
        ),
    }
}

/// The platform of this machine.
pub fn host() -> Result<Platform> {
    let (os, processor) = (std::env::consts::OS, std::env::consts::ARCH);
    fmi_description::platform::host()
        .with_context(|| format!("FMUs cannot be packed for {os} on {processor}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmi_description::Version;

    /// The header of an ELF file for a processor (`e_machine` of the System V ABI), without
    /// sections.
    fn elf(machine: u16) -> Vec<u8> {
        let mut header = vec![0; 64];
        header[..7].copy_from_slice(b"\x7fELF\x02\x01\x01");
        header[16] = 3; // shared object
        header[18..20].copy_from_slice(&machine.to_le_bytes());
        header[20] = 1;
        header[52] = 64; // size of this header
        header
    }

    #[test]
    fn a_folder_is_claimed_for_its_own_processor_only() {
        assert_eq!(detect(&elf(62)).unwrap(), LINUX);
        let arm = detect(&elf(183)).unwrap();
        assert_eq!(arm, LINUX_ARM);
        let library = arm.library(Version::Fmi3, "Lag");
        assert_eq!(library.as_deref(), Some("binaries/aarch64-linux/Lag.so"));
        assert_eq!(arm.library(Version::Fmi2, "Lag"), None);
        // A library (6) for arm64 in 64-bit Mach-O, little-endian.
        let mut mac = vec![0; 32];
        mac[..8].copy_from_slice(&[0xcf, 0xfa, 0xed, 0xfe, 0x0c, 0, 0, 1]);
        mac[12] = 6;
        assert_eq!(detect(&mac).unwrap(), MACOS_ARM);
        mac[4] = 7;
        assert_eq!(detect(&mac).unwrap(), MACOS);
        let refused = detect(&elf(243)).unwrap_err().to_string();
        assert!(refused.starts_with("built for Riscv64 (Elf)"), "{refused}");
        assert_eq!(detect(b"text").unwrap_err().to_string(), "not a library");
    }

    /// This test itself is a program for the machine that it runs on.
    #[test]
    fn the_header_of_this_program_names_this_machine() {
        let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        assert_eq!(detect(&program).ok(), host().ok());
    }
}
