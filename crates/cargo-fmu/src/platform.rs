//! Platform folders of FMI 2.0 (section 2.3) and 3.0 (section 2.5.1.4): each is claimed only for the processor that it is for.

use anyhow::{Context, Result, bail};
use object::{Architecture, BinaryFormat, Object};

/// Where a library belongs inside an FMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder in `binaries/` of FMI 2.0; where that has none, the one of FMI 3.0.
    pub folder: &'static str,
    /// Folder in `binaries/` of FMI 3.0.
    pub folder_3: &'static str,
    /// Suffix of a library, with its dot.
    pub suffix: &'static str,
}

impl Platform {
    /// Whether FMI 2.0 has a folder for it.
    pub fn is_in_fmi2(&self) -> bool {
        self.folder != self.folder_3
    }

    /// Where the library of an FMU lies in its archive by FMI 2.0.
    pub fn path(&self, identifier: &str) -> Result<String> {
        let Self { folder, suffix, .. } = self;
        if !self.is_in_fmi2() {
            bail!("FMI 2.0 has no folder for {folder}");
        }
        Ok(format!("binaries/{folder}/{identifier}{suffix}"))
    }

    /// The same by FMI 3.0.
    pub fn path_3(&self, identifier: &str) -> String {
        let Self {
            folder_3, suffix, ..
        } = self;
        format!("binaries/{folder_3}/{identifier}{suffix}")
    }
}

/// Linux on x86-64.
pub const LINUX: Platform = Platform {
    folder: "linux64",
    folder_3: "x86_64-linux",
    suffix: ".so",
};
/// Windows on x86-64.
pub const WINDOWS: Platform = Platform {
    folder: "win64",
    folder_3: "x86_64-windows",
    suffix: ".dll",
};
/// macOS on x86-64. FMI 2.0 names no processor here; it was written when Macs had no other.
pub const MACOS: Platform = Platform {
    folder: "darwin64",
    folder_3: "x86_64-darwin",
    suffix: ".dylib",
};
/// Linux on 64-bit ARM.
pub const LINUX_ARM: Platform = Platform {
    folder: "aarch64-linux",
    folder_3: "aarch64-linux",
    suffix: ".so",
};
/// macOS on 64-bit ARM.
pub const MACOS_ARM: Platform = Platform {
    folder: "aarch64-darwin",
    folder_3: "aarch64-darwin",
    suffix: ".dylib",
};

/// The platform that a library was built for, by its own header.
pub fn of(library: &[u8]) -> Result<Platform> {
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
    match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => Ok(LINUX),
        ("linux", "aarch64") => Ok(LINUX_ARM),
        ("windows", "x86_64") => Ok(WINDOWS),
        ("macos", "x86_64") => Ok(MACOS),
        ("macos", "aarch64") => Ok(MACOS_ARM),
        (os, processor) => bail!("FMUs cannot be packed for {os} on {processor}"),
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
        let arm = of(&elf(183)).unwrap();
        assert_eq!(arm, LINUX_ARM);
        assert_eq!(arm.path_3("Lag"), "binaries/aarch64-linux/Lag.so");
        let refused = arm.path("Lag").unwrap_err().to_string();
        assert_eq!(refused, "FMI 2.0 has no folder for aarch64-linux");
        // A library (6) for arm64 in 64-bit Mach-O, little-endian.
        let mut mac = vec![0; 32];
        mac[..8].copy_from_slice(&[0xcf, 0xfa, 0xed, 0xfe, 0x0c, 0, 0, 1]);
        mac[12] = 6;
        assert_eq!(of(&mac).unwrap(), MACOS_ARM);
        mac[4] = 7;
        assert_eq!(of(&mac).unwrap(), MACOS);
        let refused = of(&elf(243)).unwrap_err().to_string();
        assert!(refused.starts_with("built for Riscv64 (Elf)"), "{refused}");
        assert_eq!(of(b"text").unwrap_err().to_string(), "not a library");
    }

    /// This test itself is a program for the machine that it runs on.
    #[test]
    fn the_header_of_this_program_names_this_machine() {
        let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        assert_eq!(of(&program).ok(), host().ok());
    }
}
