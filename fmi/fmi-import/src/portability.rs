//! What a library or program needs from the machine that loads it, and what it reveals of the
//! machine that built it, read from its headers for `fmu-check`, `cargo fmu` and `xtask`.
//!
//! ```
//! use fmi_import::portability::Needs;
//!
//! let program = std::fs::read(std::env::current_exe()?)?;
//! assert!(!Needs::read(&program)?.libraries.is_empty());
//! # anyhow::Ok(())
//! ```

use std::collections::BTreeSet;
use std::fmt;

use anyhow::{Context, Result};
use object::read::elf::FileHeader;
use object::{Object, elf};

/// Newest version of the GNU C library that a Linux binary may need: that of Red Hat Enterprise
/// Linux 7 (2014).
const GLIBC: Version = Version(2, 17, 0);

/// The libraries of the GNU C library, the only ones that may be needed on Linux.
const LINUX: [&str; 7] = [
    "ld-linux-aarch64.so.1",
    "ld-linux-x86-64.so.2",
    "libc.so.6",
    "libdl.so.2",
    "libm.so.6",
    "libpthread.so.0",
    "librt.so.1",
];
/// Libraries that every Windows 10 has, in lower case, besides those named `api-ms-win-…`.
const WINDOWS: [&str; 10] = [
    "advapi32.dll",
    "bcrypt.dll",
    "bcryptprimitives.dll",
    "kernel32.dll",
    "msvcrt.dll",
    "ntdll.dll",
    "shell32.dll",
    "ucrtbase.dll",
    "userenv.dll",
    "ws2_32.dll",
];
/// Folders of the libraries that every macOS has.
const MACOS: [&str; 2] = ["/usr/lib/", "/System/Library/"];

/// Mathematical functions of C whose last digits differ between platforms and between versions of
/// one; Windows puts `_` before some.
const MATHEMATICS: [&str; 27] = [
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "erf",
    "exp", "exp2", "expm1", "hypot", "lgamma", "log", "log10", "log1p", "log2", "pow", "sin",
    "sincos", "sinh", "tan", "tanh", "tgamma",
];

/// A version of the GNU C library.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version(pub u32, pub u32, pub u32);

impl Version {
    /// From the name of a symbol version: `GLIBC_2.3.4`.
    fn parse(name: &str) -> Option<Self> {
        let mut parts = name.strip_prefix("GLIBC_")?.split('.').map(str::parse);
        let mut next = || parts.next().unwrap_or(Ok(0)).ok();
        Some(Self(next()?, next()?, next()?))
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self(major, minor, patch) = self;
        write!(f, "{major}.{minor}")?;
        match patch {
            0 => Ok(()),
            _ => write!(f, ".{patch}"),
        }
    }
}

/// What a library or program needs, by its own headers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Needs {
    /// Names of the symbol versions that it needs (Linux).
    versions: BTreeSet<String>,
    /// Shared libraries that it loads.
    pub libraries: BTreeSet<String>,
    /// Functions and variables that it imports from them.
    imports: BTreeSet<String>,
    /// It has symbols that are not exported, or debug information.
    has_symbols: bool,
}

impl Needs {
    /// Reads the headers of a library or program for Linux, Windows or macOS.
    pub fn read(binary: &[u8]) -> Result<Self> {
        let file = object::File::parse(binary).context("neither library nor program")?;
        let imports = file.imports()?;
        let (versions, libraries) = match &file {
            object::File::Elf64(_) => elf_needs(binary)?,
            _ => {
                let libraries = imports.iter().map(|i| text(i.library()));
                (BTreeSet::new(), libraries.collect())
            }
        };
        let is_macho = file.format() == object::BinaryFormat::MachO;
        Ok(Self {
            versions,
            libraries,
            imports: imports.iter().map(|i| text(i.name())).collect(),
            // The symbols of Mach-O are also its imports and exports.
            has_symbols: file.has_debug_symbols() || !is_macho && file.symbols().next().is_some(),
        })
    }

    /// The newest version of the GNU C library that it needs.
    pub fn glibc(&self) -> Option<Version> {
        self.versions.iter().filter_map(|v| Version::parse(v)).max()
    }

    /// Mathematical functions that it imports, so that its numbers may differ between platforms.
    pub fn mathematics(&self) -> Vec<&str> {
        let names = self.imports.iter().map(|name| name.trim_start_matches('_'));
        names.filter(|name| MATHEMATICS.contains(name)).collect()
    }

    /// Why it would not run on every machine of its platform folder, or is larger than necessary.
    pub fn faults(&self, folder: &str) -> Vec<String> {
        let mut faults = Vec::new();
        for version in &self.versions {
            // A version that cannot be parsed is GLIBC_PRIVATE, or one of another library.
            if Version::parse(version).is_none_or(|v| v > GLIBC) {
                faults.push(format!(
                    "needs symbols of {version}, but must do with GLIBC_{GLIBC}"
                ));
            }
        }
        let is_there = |name: &&String| match folder {
            "linux64" | "aarch64-linux" => LINUX.contains(&name.as_str()),
            "win64" => {
                let name = name.to_ascii_lowercase();
                name.starts_with("api-ms-win-") || WINDOWS.contains(&name.as_str())
            }
            "darwin64" | "aarch64-darwin" => MACOS.iter().any(|path| name.starts_with(path)),
            _ => false,
        };
        let foreign = self.libraries.iter().filter(|name| !is_there(name));
        faults.extend(
            foreign.map(|name| format!("loads {name}, which not every machine for {folder} has")),
        );
        if self.has_symbols {
            faults.push("holds symbols or debug information; it must be stripped".to_string());
        }
        faults
    }
}

/// Symbol versions and libraries that an ELF file needs.
fn elf_needs(binary: &[u8]) -> Result<(BTreeSet<String>, BTreeSet<String>)> {
    let header = elf::FileHeader64::<object::Endianness>::parse(binary)?;
    let endian = header.endian()?;
    let sections = header.sections(endian, binary)?;
    let mut versions = BTreeSet::new();
    if let Some((mut needs, link)) = sections.gnu_verneed(endian, binary)? {
        let strings = sections.strings(endian, binary, link)?;
        while let Some((_, mut symbols)) = needs.next()? {
            while let Some(symbol) = symbols.next()? {
                versions.insert(text(symbol.name(endian, strings)?));
            }
        }
    }
    let table = sections.dynamic_table(endian, binary)?;
    let needed = table.iter().filter(|d| d.tag == elf::DT_NEEDED);
    let libraries = needed.map(|d| table.string(d).map(text));
    Ok((versions, libraries.collect::<Result<_, _>>()?))
}

fn text(name: &[u8]) -> String {
    String::from_utf8_lossy(name).into_owned()
}

/// The folders whose paths occur in a binary. `src/roots.rs` is no occurrence of `/root`.
pub fn folders_in<'a>(binary: &[u8], folders: &'a [String]) -> Vec<&'a str> {
    let continues = |next: &u8| next.is_ascii_alphanumeric() || b"_-".contains(next);
    let is_named = |folder: &&String| {
        let length = folder.len();
        length > 0
            && binary.windows(length).enumerate().any(|(at, window)| {
                window == folder.as_bytes() && !binary.get(at + length).is_some_and(continues)
            })
    };
    folders
        .iter()
        .filter(is_named)
        .map(String::as_str)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn needs(versions: &[&str], libraries: &[&str]) -> Needs {
        let set = |names: &[&str]| names.iter().map(ToString::to_string).collect();
        Needs {
            versions: set(versions),
            libraries: set(libraries),
            imports: set(&["_hypot", "sin", "memcpy", "sinh_of_ours"]),
            has_symbols: false,
        }
    }

    #[test]
    fn versions_are_compared_as_numbers() {
        let old = needs(&["GLIBC_2.2.5", "GLIBC_2.14", "GLIBC_2.9"], &["libc.so.6"]);
        assert_eq!(old.glibc().unwrap().to_string(), "2.14");
        assert_eq!(old.faults("linux64"), <[&str; 0]>::default());
        for wrong in ["GLIBC_2.17.1", "GLIBC_2.34", "GLIBC_PRIVATE", "GCC_3.0"] {
            let faults = needs(&[wrong], &[]).faults("linux64");
            assert_eq!(
                faults,
                [format!(
                    "needs symbols of {wrong}, but must do with GLIBC_2.17"
                )]
            );
        }
    }

    #[test]
    fn libraries_beside_the_system_are_refused() {
        let windows = needs(
            &[],
            &[
                "KERNEL32.dll",
                "api-ms-win-core-synch-l1-2-0.dll",
                "libgcc_s_seh-1.dll",
            ],
        );
        assert_eq!(
            windows.faults("win64"),
            ["loads libgcc_s_seh-1.dll, which not every machine for win64 has"]
        );
        let linux = needs(&[], &["libc.so.6", "libgcc_s.so.1"]);
        assert_eq!(
            linux.faults("linux64"),
            ["loads libgcc_s.so.1, which not every machine for linux64 has"]
        );
        let mac = needs(&[], &["/usr/lib/libSystem.B.dylib", "/opt/lib/libz.dylib"]);
        assert_eq!(mac.faults("darwin64").len(), 1);
    }

    #[test]
    fn mathematics_of_the_platform_is_named() {
        assert_eq!(needs(&[], &[]).mathematics(), ["hypot", "sin"]);
    }

    /// This test itself: a program of this machine with symbols, which names the folder of its
    /// source.
    #[test]
    fn this_program_is_read() {
        let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        let needs = Needs::read(&program).unwrap();
        assert!(!needs.libraries.is_empty());
        if cfg!(target_os = "linux") {
            assert!(needs.glibc().is_some() && needs.libraries.contains("libc.so.6"));
            let faults = needs.faults("linux64");
            assert!(faults.iter().any(|f| f.contains("stripped")), "{faults:?}");
        }
        // Made here, since this program holds every literal.
        let absent = format!("/absent/{}", std::process::id());
        let folder = Path::new(file!()).parent().unwrap().to_str().unwrap();
        let folders = [absent, folder.to_string()];
        assert_eq!(folders_in(&program, &folders), [folder]);
    }

    #[test]
    fn a_folder_is_not_the_start_of_another_name() {
        let folders = ["/root".to_string()];
        let is_named = |text: &[u8]| !folders_in(text, &folders).is_empty();
        assert!(!is_named(b"/registry/num-integer/src/roots.rs"));
        assert!(!is_named(b"/root-of-all/x"));
        assert!(is_named(b"x/roots /root/.cargo/registry") && is_named(b"in /root"));
    }
}
