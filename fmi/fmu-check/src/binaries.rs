//! Checks the libraries of all platforms, for `fmu_check::check`, without loading them: processor,
//! exported functions, what they need, and whether they reveal where they were built.

use std::collections::BTreeSet;

use fmi_description::platform::{LINUX, LINUX_ARM, MACOS, MACOS_ARM, WINDOWS};
use object::{Architecture, BinaryFormat, Object};

use super::outcome::{Outcome, Promise, Report};
use fmi_description::Entries;
use fmi_import::portability::Needs;

const AREA: &str = "libraries";
const PROCESSOR: Promise = Promise {
    text: "each library is built for the platform of its folder, and named after the model identifier",
    why: "importers pick a library by its folder and name, and fail to load it where it is for another processor [FMI 2.0, 2.3; FMI 3.0, 2.5.1.4]",
};
const FUNCTIONS: Promise = Promise {
    text: "each library exports every function of its interface",
    why: "importers look all of them up when they load it, also those of features that the FMU does not have [FMI 2.0, 2.3; FMI 3.0, 2.5]",
};
const ORIGIN: Promise = Promise {
    text: "libraries tell nothing of the machine that built them",
    why: "paths reveal users and folders of the maker, and make two builds differ",
};

/// A folder in `binaries/`, and the libraries that belong there.
pub struct PlatformFolder {
    pub folder: &'static str,
    suffix: &'static str,
    format: BinaryFormat,
    processors: &'static [Architecture],
}

const fn platform(
    folder: &'static str,
    suffix: &'static str,
    format: BinaryFormat,
    processors: &'static [Architecture],
) -> PlatformFolder {
    PlatformFolder {
        folder,
        suffix,
        format,
        processors,
    }
}

use Architecture::{Aarch64, I386, X86_64};
use BinaryFormat::{Elf, MachO, Pe};

/// Folders of FMI 2.0 (section 2.3) and 3.0 (section 2.5.1.4).
#[rustfmt::skip]
pub const PLATFORMS: [PlatformFolder; 13] = [
    platform("linux64",         ".so",    Elf,   &[X86_64]),
    platform("linux32",         ".so",    Elf,   &[I386]),
    platform("win64",           ".dll",   Pe,    &[X86_64]),
    platform("win32",           ".dll",   Pe,    &[I386]),
    platform("darwin64",        ".dylib", MachO, &[X86_64, Aarch64]),
    platform("x86_64-linux",    ".so",    Elf,   &[X86_64]),
    platform("x86-linux",       ".so",    Elf,   &[I386]),
    platform("aarch64-linux",   ".so",    Elf,   &[Aarch64]),
    platform("x86_64-windows",  ".dll",   Pe,    &[X86_64]),
    platform("x86-windows",     ".dll",   Pe,    &[I386]),
    platform("aarch64-windows", ".dll",   Pe,    &[Aarch64]),
    platform("x86_64-darwin",   ".dylib", MachO, &[X86_64]),
    platform("aarch64-darwin",  ".dylib", MachO, &[Aarch64]),
];

/// How paths in a user's folder begin.
const HOMES: [&[u8]; 4] = [b"/home/", b"/root/", b"/Users/", b":\\Users\\"];

/// Checks the libraries of an FMU with these model identifiers, which must export the functions of
/// their identifier; None if this program does not know them.
pub fn check(
    entries: &Entries,
    identifiers: &[&str],
    functions: impl Fn(&str) -> Option<Vec<String>>,
    report: &mut Report,
) {
    let [mut processor, mut exported, mut origin] = [(); 3].map(|()| Outcome::default());
    for (platform, identifier) in PLATFORMS
        .iter()
        .flat_map(|p| identifiers.iter().map(move |i| (p, i)))
    {
        let folder = format!("binaries/{}/", platform.folder);
        if !entries.keys().any(|name| name.starts_with(&folder)) {
            continue;
        }
        let path = format!("{folder}{identifier}{}", platform.suffix);
        match entries
            .get(&path)
            .map(|bytes| (bytes, object::File::parse(bytes.as_slice())))
        {
            None => processor.fail(format!("there is no {path}")),
            Some((_, Err(reason))) => processor.fail(format!("{path}: {reason}")),
            Some((bytes, Ok(file))) => {
                check_processor(platform, &path, &file, &mut processor);
                match functions(identifier) {
                    Some(functions) => check_exports(&path, &file, &functions, &mut exported),
                    None => {
                        exported =
                            Outcome::not_checked("the functions of this version are not known here")
                    }
                }
                note_glibc(&path, bytes, &mut processor);
                check_paths(&path, bytes, &mut origin);
            }
        }
    }
    report.push(AREA, PROCESSOR, processor);
    report.push(AREA, FUNCTIONS, exported);
    report.push(AREA, ORIGIN, origin);
}

fn check_processor(
    platform: &PlatformFolder,
    path: &str,
    file: &object::File,
    outcome: &mut Outcome,
) {
    let (format, processor) = (file.format(), file.architecture());
    if format != platform.format || !platform.processors.contains(&processor) {
        outcome.fail(format!("{path} is built for {processor:?} ({format:?})"));
    }
}

fn check_exports(path: &str, file: &object::File, functions: &[String], outcome: &mut Outcome) {
    let exported = match file.exports() {
        Ok(exported) => exported,
        Err(reason) => return outcome.fail(format!("{path}: {reason}")),
    };
    let name = |name: &[u8]| {
        let name = String::from_utf8_lossy(name);
        // Mach-O puts an underscore before C names.
        let plain = match file.format() {
            MachO => name.strip_prefix('_'),
            _ => None,
        };
        plain.unwrap_or(&name).to_string()
    };
    let exported: BTreeSet<_> = exported.iter().map(|e| name(e.name())).collect();
    for missing in functions.iter().filter(|f| !exported.contains(*f)) {
        outcome.fail(format!("{path}: {missing}"));
    }
    let others = exported.iter().filter(|name| !functions.contains(name));
    match others.count() {
        0 | 1 => {}
        others => outcome.note(format!(
            "{path} exports {others} other symbols, which may clash with those of other libraries"
        )),
    }
}

fn note_glibc(path: &str, bytes: &[u8], outcome: &mut Outcome) {
    if let Some(version) = Needs::read(bytes).ok().and_then(|needs| needs.glibc()) {
        outcome.note(format!("{path} needs glibc {version} or newer"));
    }
}

fn check_paths(path: &str, bytes: &[u8], outcome: &mut Outcome) {
    let is_path = |b: &u8| b.is_ascii_alphanumeric() || b"/\\._-+:~".contains(b);
    let found: BTreeSet<String> = HOMES
        .iter()
        .flat_map(|home| {
            let places = bytes.windows(home.len()).enumerate();
            let starts = places.filter(move |(_, text)| text == home);
            starts.map(|(start, _)| {
                let rest = &bytes[start..];
                let end = rest.iter().position(|b| !is_path(b)).unwrap_or(rest.len());
                String::from_utf8_lossy(&rest[..end]).into_owned()
            })
        })
        .filter(|text| text.len() > 10)
        .collect();
    if let Some(first) = found.first() {
        let count = found.len();
        let hint = packing_hint(path, bytes).unwrap_or_default();
        outcome.remark(format!("{path} holds {count} paths, such as {first}{hint}"));
    }
}

/// How to pack a library made with fmu-export so that it has no paths; None for others.
fn packing_hint(path: &str, bytes: &[u8]) -> Option<String> {
    let marker = b"fmi2ExportFiles";
    let is_ours = bytes.windows(marker.len()).any(|text| text == marker);
    let folder = path.split('/').nth(1).filter(|_| is_ours)?;
    let platforms = [LINUX, WINDOWS, MACOS, LINUX_ARM, MACOS_ARM];
    let mut platforms = platforms.iter();
    let platform = platforms.find(|p| p.folder == folder || p.folder_3 == folder)?;
    Some(format!(
        "; `cargo fmu pack --target {}` packs it for any machine of its kind, without them",
        platform.folder
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// This test itself is a library for the machine that it runs on, as far as this check goes.
    fn this_program() -> Vec<u8> {
        std::fs::read(std::env::current_exe().unwrap()).unwrap()
    }

    fn checked(path: &str, functions: &[&str]) -> [Outcome; 3] {
        let entries = Entries::from([(path.to_string(), this_program())]);
        let mut report = Report::default();
        let functions: Vec<_> = functions.iter().map(ToString::to_string).collect();
        check(&entries, &["X"], |_| Some(functions.clone()), &mut report);
        let outcomes: Vec<_> = report.rows.into_iter().map(|row| row.outcome).collect();
        outcomes.try_into().unwrap()
    }

    #[cfg(all(target_os = "linux", target_arch = "x86_64"))]
    #[test]
    fn folders_names_and_functions_are_compared() {
        let [sound, exported, _] = checked("binaries/linux64/X.so", &["fmi2DoStep"]);
        assert_eq!(sound.fails, [""; 0]);
        assert!(
            sound.notes[0].starts_with("binaries/linux64/X.so needs glibc 2."),
            "{sound:?}"
        );
        assert_eq!(exported.fails, ["binaries/linux64/X.so: fmi2DoStep"]);
        let [misnamed, ..] = checked("binaries/linux64/Y.so", &[]);
        assert_eq!(misnamed.fails, ["there is no binaries/linux64/X.so"]);
        let [elsewhere, ..] = checked("binaries/aarch64-linux/X.so", &[]);
        assert_eq!(
            elsewhere.fails,
            ["binaries/aarch64-linux/X.so is built for X86_64 (Elf)"]
        );
    }

    #[test]
    fn paths_of_the_maker_are_found() {
        let mut outcome = Outcome::default();
        check_paths("X.so", b"..\0/home/me/model/src.c\0/home/\0", &mut outcome);
        assert_eq!(
            outcome.remarks,
            ["X.so holds 1 paths, such as /home/me/model/src.c"]
        );
        let mut ours = Outcome::default();
        let text = b"fmi2ExportFiles\0/home/me/model/src.c\0";
        check_paths("binaries/x86_64-linux/X.so", text, &mut ours);
        assert_eq!(
            ours.remarks,
            [
                "binaries/x86_64-linux/X.so holds 1 paths, such as /home/me/model/src.c; \
              `cargo fmu pack --target linux64` packs it for any machine of its kind, without them"
            ]
        );
    }
}
