//! Platform folders of FMI 2.0 (section 2.3): each is claimed only for the processor that it is for.

use anyhow::{Context, Result, bail};
use object::{Architecture, BinaryFormat, Object};

/// Where a library belongs inside an FMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder in `binaries/`.
    pub folder: &'static str,
    /// Suffix of a library, with its dot.
    pub suffix: &'static str,
}

impl Platform {
    /// Where the library of an FMU lies in its archive.
    pub fn path(&self, identifier: &str) -> String {
        format!("binaries/{}/{identifier}{}", self.folder, self.suffix)
    }
}

/// Linux on x86-64.
pub const LINUX: Platform = Platform {
    folder: "linux64",
    suffix: ".so",
};
/// Windows on x86-64.
pub const WINDOWS: Platform = Platform {
    folder: "win64",
    suffix: ".dll",
};
/// macOS on x86-64. The standard names no processor here; it was written when Macs had no other.
pub const MACOS: Platform = Platform {
    folder: "darwin64",
    suffix: ".dylib",
};

/// The platform that a library was built for, by its own header.
pub fn of(library: &[u8]) -> Result<Platform> {
    let file = object::File::parse(library).context("not a library")?;
    match (file.format(), file.architecture()) {
        (BinaryFormat::Elf, Architecture::X86_64) => Ok(LINUX),
        (BinaryFormat::Pe, Architecture::X86_64) => Ok(WINDOWS),
        (BinaryFormat::MachO, Architecture::X86_64) => Ok(MACOS),
        (format, processor) => bail!(
            "built for {processor:?} ({format:?}); FMI 2.0 has folders for Linux (linux64), Windows (win64) and macOS (darwin64) on x86-64 \
             only"
        ),
    }
}

/// The platform of this machine.
pub fn host() -> Result<Platform> {
    match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => Ok(LINUX),
        ("windows", "x86_64") => Ok(WINDOWS),
        ("macos", "x86_64") => Ok(MACOS),
        (os, processor) => bail!("FMI 2.0 has no folder for {os} on {processor}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The header of an ELF file for a processor (`e_machine` of the System V ABI), without sections.
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
        assert_eq!(of(&elf(62)).unwrap(), LINUX);
        let refused = of(&elf(183)).unwrap_err().to_string();
        assert!(
            refused.starts_with("built for Aarch64 (Elf); FMI 2.0 has folders for Linux (linux64)"),
            "{refused}"
        );
        assert!(of(&elf(243)).is_err(), "RISC-V");
        assert_eq!(of(b"text").unwrap_err().to_string(), "not a library");
    }

    /// This test itself is a program for the machine that it runs on.
    #[test]
    fn the_header_of_this_program_names_this_machine() {
        let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        assert_eq!(of(&program).ok(), host().ok());
    }
}
