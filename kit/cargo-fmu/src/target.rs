//! Builds libraries for a platform of FMI so that old systems can load them, without paths of the
//! building machine, with the same bytes from any folder, for `pack`, `wasm`, `web` and `xtask`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use anyhow::{Context, Result, anyhow, bail};

use crate::process::output;
use crate::workspace::{Workspace, cargo};
use fmi_import::platform::{self, Platform};
use fmi_import::portability::{self, Needs};

/// The PyPI packages of the linker for Linux and macOS: zig, and cargo-zigbuild, by which cargo
/// calls it.
pub const ZIG: &str = "ziglang==0.17.1\ncargo-zigbuild==0.24.0\n";

const ZIGBUILD: &str = "cargo-zigbuild";
const INSTALL_NAME: &str = "link-arg=-Wl,-install_name,@rpath/model.dylib";
const MINGW: &str = "x86_64-w64-mingw32-gcc";
/// A script that calls the linker for Windows.
#[cfg(unix)]
const MINGW_LINK: &str = include_str!("mingw_link.sh");

/// A platform that can be built for.
#[derive(Debug, PartialEq, Eq)]
pub struct Target {
    /// Its folder in an FMU, and the suffix of its libraries.
    pub platform: Platform,
    /// The compiler's name for it.
    pub triple: &'static str,
    linker: Linker,
}

#[derive(Debug, PartialEq, Eq)]
enum Linker {
    /// zig, for this version of the system's C library.
    Zig { libc: &'static str },
    /// The GNU linker for Windows.
    Mingw,
    /// The compiler's own.
    Own,
}

/// For components of FMI-LS-WASM: a module without an operating system, which imports only
/// callbacks.
pub const WASM: Target = Target::new(platform::WASM, "wasm32-unknown-unknown", Linker::Own);

/// The GNU C library of an old Linux.
const OLD_LINUX: Linker = Linker::Zig { libc: ".2.17" };
/// The C library that macOS itself has.
const OWN_MACOS: Linker = Linker::Zig { libc: "" };

/// All platforms of shared libraries.
pub const TARGETS: [Target; 5] = [
    Target::new(platform::LINUX, "x86_64-unknown-linux-gnu", OLD_LINUX),
    Target::new(platform::WINDOWS, "x86_64-pc-windows-gnu", Linker::Mingw),
    Target::new(platform::MACOS, "x86_64-apple-darwin", OWN_MACOS),
    Target::new(platform::LINUX_ARM, "aarch64-unknown-linux-gnu", OLD_LINUX),
    Target::new(platform::MACOS_ARM, "aarch64-apple-darwin", OWN_MACOS),
];

/// Folders in which tools are looked for before the search path.
#[derive(Clone, Debug, Default)]
pub struct Tools(pub Vec<PathBuf>);

impl Target {
    const fn new(platform: Platform, triple: &'static str, linker: Linker) -> Self {
        Self {
            platform,
            triple,
            linker,
        }
    }

    /// The target with this platform folder or compiler's name.
    pub fn named(name: &str) -> Result<&'static Self> {
        let is_it = |t: &&Self| [t.platform.folder, t.triple].contains(&name);
        TARGETS.iter().find(is_it).ok_or_else(|| {
            let names: Vec<_> = TARGETS.iter().map(|t| t.platform.folder).collect();
            anyhow!(
                "`{name}` is no platform that can be built for; there are {}",
                names.join(", ")
            )
        })
    }

    /// What this machine lacks to build for it, each with the command that installs it.
    pub fn missing(&self, tools: &Tools) -> Vec<String> {
        let mut missing = Vec::new();
        if !self.has_standard_library() {
            missing.push(format!(
                "the standard library for {0}: `rustup target add {0}`",
                self.triple
            ));
        }
        let mut needs = |program: &str, command: &str| {
            if tools.find(program).is_none() {
                missing.push(format!("{program}: `{command}`"));
            }
        };
        match self.linker {
            Linker::Zig { .. } => {
                let command = format!("pip install {}", ZIG.trim().replace('\n', " "));
                needs(ZIGBUILD, &command);
            }
            Linker::Mingw => needs(MINGW, "apt-get install gcc-mingw-w64-x86-64"),
            Linker::Own => {}
        }
        missing
    }

    /// What is missing, in a sentence.
    pub fn fault(&self, tools: &Tools) -> Option<String> {
        let missing = self.missing(tools);
        let folder = self.platform.folder;
        let text = || {
            format!(
                "{folder} cannot be built here; missing: {}",
                missing.join("; ")
            )
        };
        (!missing.is_empty()).then(text)
    }

    /// Why a library or program that was built for it would not run on every machine of the
    /// platform, or what it reveals of the machine that built it.
    pub fn faults(&self, binary: &[u8], workspace: &Workspace) -> Result<Vec<String>> {
        let mut faults = Needs::read(binary)?.faults(self.platform.folder);
        let platform = platform::detect(binary)?;
        if platform != self.platform {
            faults.push(format!("is built for {}", platform.folder));
        }
        let folders = private_folders(workspace)?;
        let named = portability::folders_in(binary, &folders);
        faults.extend(named.iter().map(|path| format!("names {path}")));
        Ok(faults)
    }

    /// Whether it is for macOS. Such libraries can be built without a Mac, but not run.
    pub fn is_macos(&self) -> bool {
        [platform::MACOS, platform::MACOS_ARM].contains(&self.platform)
    }

    /// Whether zig links for it.
    pub fn needs_zig(&self) -> bool {
        matches!(self.linker, Linker::Zig { .. })
    }

    fn has_standard_library(&self) -> bool {
        let mut rustc = Command::new("rustc");
        rustc.args(["--print", "target-libdir", "--target", self.triple]);
        let printed = rustc.output();
        printed.is_ok_and(|o| Path::new(String::from_utf8_lossy(&o.stdout).trim()).is_dir())
    }

    /// `cargo build` for this platform.
    pub fn build(&self, workspace: &Workspace, tools: &Tools) -> Result<Command> {
        if let Some(fault) = self.fault(tools) {
            bail!(fault);
        }
        let mut flags = flags()?;
        for (from, to) in private_paths(workspace)?.into_iter().rev() {
            flags.push(format!("--remap-path-prefix={from}={to}"));
        }
        let mut command = match self.linker {
            Linker::Zig { libc } => {
                if self.is_macos() {
                    // A library's own name, which is else the path where it was linked.
                    flags.extend(["-C", INSTALL_NAME].map(String::from));
                    // No paths of object files, on which the library's UUID would depend.
                    flags.extend(["-C", "link-arg=-s"].map(String::from));
                }
                let mut zigbuild = Command::new(tools.find(ZIGBUILD).context(ZIGBUILD)?);
                zigbuild.args(["zigbuild", "--target"]);
                zigbuild.arg(format!("{}{libc}", self.triple));
                zigbuild.env("PATH", tools.search_path()?);
                zigbuild
            }
            Linker::Mingw => {
                // No time in the header, so that the bytes do not change.
                flags.extend(["-C", "link-arg=-Wl,--no-insert-timestamp"].map(String::from));
                let mut build = cargo();
                build.args(["build", "--target", self.triple]);
                build.env(
                    "CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER",
                    mingw_linker(&workspace.target)?,
                );
                build
            }
            Linker::Own => {
                // Every browser has it since 2021; it does not change results.
                flags.extend(["-C", "target-feature=+simd128"].map(String::from));
                let mut build = cargo();
                build.args(["build", "--target", self.triple]);
                build
            }
        };
        command.current_dir(&workspace.root);
        command.env("CARGO_TARGET_DIR", &workspace.target);
        // Incremental builds give other bytes.
        command.env("CARGO_INCREMENTAL", "0");
        command.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"));
        Ok(command)
    }
}

impl Tools {
    /// A program in these folders or on the search path.
    pub fn find(&self, program: &str) -> Option<PathBuf> {
        let search_path = self.search_path().ok()?;
        let file = format!("{program}{}", env::consts::EXE_SUFFIX);
        let mut candidates = env::split_paths(&search_path).map(|folder| folder.join(&file));
        candidates.find(|path| path.is_file())
    }

    /// These folders, then the search path.
    pub fn search_path(&self) -> Result<OsString> {
        let path = env::var_os("PATH").unwrap_or_default();
        let folders = self.0.iter().cloned().chain(env::split_paths(&path));
        env::join_paths(folders).context("the search path")
    }
}

/// The linker for Windows that cargo calls: a script in the target directory, which makes the bytes
/// independent of folders.
#[cfg(unix)]
fn mingw_linker(target: &Path) -> Result<PathBuf> {
    use std::os::unix::fs::PermissionsExt;

    let script = target.join("mingw_link.sh");
    if fs::read_to_string(&script).is_ok_and(|text| text == MINGW_LINK) {
        return Ok(script);
    }
    // Renamed when complete, since another build may be about to call it.
    fs::create_dir_all(target)?;
    let new = tempfile::NamedTempFile::new_in(target)?;
    fs::write(&new, MINGW_LINK)?;
    fs::set_permissions(&new, fs::Permissions::from_mode(0o755))?;
    new.into_temp_path()
        .persist(&script)
        .with_context(|| script.display().to_string())?;
    Ok(script)
}

/// The linker for Windows that cargo calls.
#[cfg(not(unix))]
fn mingw_linker(_target: &Path) -> Result<PathBuf> {
    Ok(PathBuf::from(MINGW))
}

/// The flags of the compiler in the environment.
fn flags() -> Result<Vec<String>> {
    let text = |name: &str| match env::var(name) {
        Ok(text) => Ok(text),
        Err(env::VarError::NotPresent) => Ok(String::new()),
        Err(error) => Err(error).context(name.to_string()),
    };
    let (encoded, plain) = (text("CARGO_ENCODED_RUSTFLAGS")?, text("RUSTFLAGS")?);
    let flags = match encoded.is_empty() {
        false => encoded.split('\x1f').map(String::from).collect(),
        true => plain.split_whitespace().map(String::from).collect(),
    };
    Ok(flags)
}

/// Folders of this machine that the compiler would write into its output, innermost first, each
/// with the name that replaces it on every machine.
fn private_paths(workspace: &Workspace) -> Result<Vec<(String, String)>> {
    let text = |path: &Path| {
        let text = path.to_str().map(String::from);
        text.context("a path that is no UTF-8")
    };
    let home = env::home_dir().context("this user has no home folder")?;
    let cargo_home = env::var_os("CARGO_HOME").map_or_else(|| home.join(".cargo"), PathBuf::from);
    let mut paths = Vec::new();
    // One folder for each registry, which may be a mirror.
    let registries = fs::read_dir(cargo_home.join("registry/src"));
    for registry in registries.into_iter().flatten() {
        paths.push((text(&registry?.path())?, "/registry".to_string()));
    }
    paths.push((text(&cargo_home)?, "/cargo".to_string()));
    // Build scripts write source there.
    paths.push((text(&workspace.target)?, "/source/target".to_string()));
    paths.push((text(&workspace.root)?, "/source".to_string()));
    let version = output(Command::new("rustc").arg("-vV"))?;
    let mut lines = version.lines();
    let commit = lines.find_map(|l| l.strip_prefix("commit-hash: "));
    let sysroot = output(Command::new("rustc").args(["--print", "sysroot"]))?;
    let library = Path::new(sysroot.trim()).join("lib/rustlib/src/rust");
    // The name that the standard library itself was built with.
    let built = format!("/rustc/{}", commit.unwrap_or("unknown"));
    paths.push((text(&library)?, built));
    paths.push((sysroot.trim().to_string(), "/rust".to_string()));
    paths.push((text(&home)?, "/home".to_string()));
    Ok(paths)
}

/// Folders of source, tools and user on this machine, which nothing that is published may name.
pub fn private_folders(workspace: &Workspace) -> Result<Vec<String>> {
    let paths = private_paths(workspace)?.into_iter();
    Ok(paths.map(|(folder, _)| folder).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_have_two_names_and_other_processors_none() {
        for target in &TARGETS {
            assert_eq!(Target::named(target.platform.folder).unwrap(), target);
            assert_eq!(Target::named(target.triple).unwrap(), target);
        }
        let refused = Target::named("riscv64-linux").unwrap_err().to_string();
        assert!(
            refused.starts_with("`riscv64-linux` is no platform")
                && refused
                    .ends_with("there are linux64, win64, darwin64, aarch64-linux, aarch64-darwin"),
            "{refused}"
        );
    }

    #[test]
    fn what_is_missing_is_named_with_its_command() {
        let nowhere = Target {
            platform: platform::WINDOWS,
            triple: "mips64-unknown-none-such",
            linker: Linker::Mingw,
        };
        let missing = nowhere.missing(&Tools::default());
        assert!(
            missing[0].contains("`rustup target add mips64-unknown-none-such`"),
            "{missing:?}"
        );
        let workspace = Workspace::containing(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap();
        let error = nowhere.build(&workspace, &Tools::default()).unwrap_err();
        assert!(
            error
                .to_string()
                .starts_with("win64 cannot be built here; missing: "),
            "{error}"
        );
    }

    #[test]
    fn tools_are_found_before_the_search_path() {
        let folder = env::temp_dir().join(format!("cargo-fmu-tools-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let cargo = folder.join(format!("cargo{}", env::consts::EXE_SUFFIX));
        fs::write(&cargo, "").unwrap();
        let own = Tools(vec![folder.clone()]);
        assert_eq!(own.find("cargo"), Some(cargo.clone()));
        assert_ne!(Tools::default().find("cargo"), Some(cargo));
        assert_eq!(own.find("no-such-program"), None);
        fs::remove_dir_all(&folder).unwrap();
    }

    /// The linker gets archives by names of their order alone, which lead to the files; all else as
    /// it is, and its exit code is the answer.
    #[cfg(unix)]
    #[test]
    fn names_of_archives_do_not_depend_on_folders() {
        use std::os::unix::fs::PermissionsExt;

        let folder = tempfile::tempdir().unwrap();
        let script = mingw_linker(folder.path()).unwrap();
        assert_eq!(mingw_linker(folder.path()).unwrap(), script);
        let gcc = folder.path().join(MINGW);
        let stub = "#!/bin/sh\necho \"$@\"\ncat 10001.rlib 10002.a 10003.lib\nexit 7\n";
        fs::write(&gcc, stub).unwrap();
        fs::set_permissions(&gcc, fs::Permissions::from_mode(0o755)).unwrap();
        let mut arguments = vec![folder.path().join("main.o")];
        for name in ["one.rlib", "two.a", "three.lib"] {
            let path = folder.path().join(name);
            fs::write(&path, name).unwrap();
            arguments.push(path);
        }
        let tools = Tools(vec![folder.path().to_path_buf()]);
        let linked = Command::new(&script)
            .args(&arguments)
            .args(["-Wl,--start-group", "-lkernel32", "-o", "a file.exe"])
            .env("PATH", tools.search_path().unwrap())
            .output()
            .unwrap();
        let expected = format!(
            "{} 10001.rlib 10002.a 10003.lib -Wl,--start-group -lkernel32 -o a file.exe\none.rlibtwo.athree.lib",
            arguments[0].display()
        );
        assert_eq!(String::from_utf8_lossy(&linked.stdout), expected);
        assert_eq!(linked.status.code(), Some(7));
    }
}
