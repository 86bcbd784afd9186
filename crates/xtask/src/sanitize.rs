//! Sanitizers, with the standard library built for them: on the tests of the C border, and on the
//! FMUs under their driver and the native master. And Miri on the tests of the C border.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use cargo_fmu::archive::{self, Entries};
use cargo_fmu::library;
use cargo_fmu::pack::FMI3_FOLDER;
use cargo_fmu::platform;
use cargo_fmu::process::execute;
use cargo_fmu::workspace::{Artifact, Source, artifacts};

use crate::nightly;
use crate::workspace::Workspace;

/// A sanitizer of the nightly compiler.
struct Sanitizer {
    /// Folder in the target directory.
    folder: &'static str,
    /// Flags of the compiler. The executables carry the sanitizer's functions, which the libraries
    /// they load look for among their dynamic symbols.
    flags: &'static str,
    /// Environment variable with its options.
    variable: &'static str,
    /// A report of any kind ends the process with a status of its own.
    options: &'static str,
}

/// With LeakSanitizer, and everything that is off by default.
const ADDRESS: Sanitizer = Sanitizer {
    folder: "asan",
    flags: "-Zsanitizer=address -Clink-arg=-rdynamic",
    variable: "ASAN_OPTIONS",
    options: "detect_leaks=1:detect_stack_use_after_return=1:strict_string_checks=1:check_initialization_order=1:\
              detect_invalid_pointer_pairs=2:exitcode=98",
};
const THREAD: Sanitizer = Sanitizer {
    folder: "tsan",
    flags: "-Zsanitizer=thread -Clink-arg=-rdynamic",
    variable: "TSAN_OPTIONS",
    options: "halt_on_error=1:exitcode=98",
};

/// The test that is run under the sanitizers and Miri: the C border of both versions, as importers
/// call it.
const BORDER: [&str; 4] = ["-p", "fmu-export", "--test", "border"];

/// AddressSanitizer and LeakSanitizer; the first report ends it.
pub fn address(workspace: &Workspace, calls: usize, seed: u64) -> Result<()> {
    let built = ADDRESS.build(workspace, &["torture", "cosim"])?;
    let (calls_text, seed) = (calls.to_string(), seed.to_string());
    let random = [
        "calls",
        "--calls",
        &calls_text,
        "--batch",
        "5000",
        "--seed",
        &seed,
    ];
    built.torture(&random)?;
    built.torture(&["life", "--instances", "300", "--loads", "3"])?;
    built.torture(&["threads", "--threads", "4", "--steps", "50"])?;
    // There are no input derivatives in FMI 3.0.
    let runs: [&[&str]; 3] = [
        &["--schedule", "gauss-seidel"],
        &["--schedule", "jacobi", "--input-derivatives"],
        &["--schedule", "gauss-seidel", "--fmi", "3"],
    ];
    for options in runs {
        built.coupled(options)?;
    }
    println!(
        "AddressSanitizer and LeakSanitizer: tests of the border, {calls} random calls, 300 instances of each of {} FMUs over 3 \
         loads and unloads, 4 threads each, {} coupled runs of 5 instances over the whole trajectory: 0 reports",
        built.fmus.len(),
        runs.len()
    );
    Ok(())
}

/// ThreadSanitizer; the first report ends it.
pub fn thread(workspace: &Workspace) -> Result<()> {
    let built = THREAD.build(workspace, &["torture"])?;
    built.torture(&["threads", "--threads", "8", "--steps", "100"])?;
    println!(
        "ThreadSanitizer: tests of the border, 8 threads of each of {} FMUs: 0 reports",
        built.fmus.len()
    );
    Ok(())
}

/// Miri on the tests of the C border, as far as they need no other process and no millions of
/// steps; the first report ends it.
pub fn miri(workspace: &Workspace) -> Result<()> {
    nightly::component(workspace, "miri")?;
    nightly::component(workspace, "rust-src")?;
    let mut cargo = nightly::cargo(workspace);
    cargo.args(["miri", "test"]).args(BORDER);
    cargo.arg("--target-dir").arg(workspace.target.join("miri"));
    // Safe code makes the descriptions; it would take an interpreter long.
    cargo.args(["--", "--skip", "xml"]);
    // The tests write parameter files, and compare runs bit for bit, whose inputs are sines: Miri
    // rounds those at random otherwise.
    let flags = "-Zmiri-disable-isolation -Zmiri-deterministic-floats";
    cargo.env("MIRIFLAGS", flags);
    execute(&mut cargo)?;
    println!("Miri: tests of the border of fmu-export: 0 reports");
    Ok(())
}

/// What was built with a sanitizer.
struct SanitizedPrograms<'a> {
    workspace: &'a Workspace,
    sanitizer: &'a Sanitizer,
    programs: Vec<Artifact>,
    fmu_dir: PathBuf,
    /// Of FMI 2.0, then of 3.0.
    fmus: Vec<PathBuf>,
}

impl Sanitizer {
    /// Run the tests, and build programs and the suite's FMUs, all instrumented.
    fn build<'a>(
        &'a self,
        workspace: &'a Workspace,
        packages: &[&str],
    ) -> Result<SanitizedPrograms<'a>> {
        nightly::component(workspace, "rust-src")?;
        let target = nightly::host(workspace)?;
        let suite = workspace.suite();
        let fmus = suite.iter().filter_map(|source| match source {
            Source::Package(name) => Some(name.as_str()),
            Source::Example(_) => None,
        });
        let all: Vec<&str> = fmus.chain(packages.iter().copied()).collect();
        // The test, FMUs and programs are built of the same packages, so that the features of what
        // they share are the same too.
        let cargo = |command: &str| {
            let mut cargo = nightly::cargo(workspace);
            cargo.args([command, "-Zbuild-std", "--target", &target, "--target-dir"]);
            cargo.arg(workspace.target.join(self.folder));
            cargo
                .env("RUSTFLAGS", self.flags)
                .env(self.variable, self.options);
            cargo.args(all.iter().flat_map(|name| ["-p", name]));
            cargo
        };
        execute(cargo("test").args(BORDER))?;
        let built = artifacts(&mut cargo("build"))?;
        let fmu_dir = workspace.target.join(self.folder).join("fmu");
        let mut fmus = Vec::new();
        for folder in ["", FMI3_FOLDER] {
            for source in &suite {
                let library = source.library(&built);
                let library = library.context("cargo has not built the libraries of all FMUs")?;
                fmus.push(archived(workspace, source, folder, &library, &fmu_dir)?);
            }
        }
        Ok(SanitizedPrograms {
            workspace,
            sanitizer: self,
            programs: built,
            fmu_dir,
            fmus,
        })
    }
}

/// An FMU with an instrumented library. Only instrumented programs can load that to ask for its
/// files, so the description is the committed one, which must be what the library says: otherwise
/// it makes no instance.
fn archived(
    workspace: &Workspace,
    source: &Source,
    folder: &str,
    library: &Path,
    fmu_dir: &Path,
) -> Result<PathBuf> {
    let (Source::Package(name) | Source::Example(name)) = source;
    let model = name.trim_start_matches("fmu-");
    let descriptions = workspace.root.join("modelDescription").join(folder);
    let files = fs::read_dir(&descriptions).with_context(|| descriptions.display().to_string())?;
    let files: Vec<PathBuf> = files
        .map(|file| Ok(file?.path()))
        .collect::<std::io::Result<_>>()?;
    let is_its = |path: &&PathBuf| {
        path.file_stem()
            .is_some_and(|stem| stem.eq_ignore_ascii_case(model))
    };
    let found = files.iter().find(is_its);
    let missing = || format!("{} has none of `{name}`", descriptions.display());
    let text = fs::read(found.with_context(missing)?)?;
    let mut entries = Entries::from([("modelDescription.xml".to_string(), text)]);
    let description = library::description(&entries)?;
    let path = platform::host()?.library(description.fmi, &description.identifier);
    let path = path.context("FMI 2.0 has no folder for this machine")?;
    entries.insert(path, fs::read(library)?);
    let folder = fmu_dir.join(folder);
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let fmu = folder.join(description.identifier).with_extension("fmu");
    archive::write(&fmu, &entries)?;
    Ok(fmu)
}

impl SanitizedPrograms<'_> {
    fn program(&self, name: &str) -> Result<Command> {
        let mut programs = self.programs.iter().filter(|a| a.name() == name);
        let file: Option<&Path> = programs.find_map(|a| a.executable.as_deref());
        let file = file.with_context(|| format!("cargo has built no program `{name}`"))?;
        let mut command = self.workspace.command(file);
        command.env(self.sanitizer.variable, self.sanitizer.options);
        Ok(command)
    }

    fn torture(&self, arguments: &[&str]) -> Result<()> {
        println!("==> torture {}", arguments.join(" "));
        execute(self.program("torture")?.args(arguments).args(&self.fmus))
    }

    /// Five instances over the whole cubic trajectory.
    fn coupled(&self, options: &[&str]) -> Result<()> {
        println!("==> cosim run {}", options.join(" "));
        let mut command = self.program("cosim")?;
        command.args(["run", "--quiet"]).args(options);
        command.arg("--system");
        command.arg(self.workspace.root.join("system/SystemStructure.ssd"));
        execute(command.arg("--fmu-dir").arg(&self.fmu_dir))
    }
}
