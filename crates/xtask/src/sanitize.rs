//! Sanitizers, with the standard library built for them: on the tests of the C border, and on the FMUs under their driver and the
//! native master. And Miri on the tests of the C border.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use cargo_fmu::pack::Platforms;
use cargo_fmu::process::execute;
use cargo_fmu::workspace::{Artifact, Source, artifacts};

use crate::workspace::Workspace;
use crate::{libclang, nightly, pack};

/// A sanitizer of the nightly compiler.
struct Sanitizer {
    /// Folder in the target directory.
    folder: &'static str,
    /// Flags of the compiler. The executables carry the sanitizer's functions, which the libraries they load look for among their
    /// dynamic symbols.
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

/// The test that is run under the sanitizers and Miri: the C border of both versions, as importers call it.
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

/// Miri on the tests of the C border, as far as they need no other process and no millions of steps; the first report ends it.
pub fn miri(workspace: &Workspace) -> Result<()> {
    nightly::component(workspace, "miri")?;
    nightly::component(workspace, "rust-src")?;
    let mut cargo = nightly::cargo(workspace);
    cargo.args(["miri", "test"]).args(BORDER);
    cargo.arg("--target-dir").arg(workspace.target.join("miri"));
    // The tests write parameter files.
    cargo.env("MIRIFLAGS", "-Zmiri-disable-isolation");
    execute(&mut cargo)?;
    println!("Miri: tests of the border of fmu-export: 0 reports");
    Ok(())
}

/// What was built with a sanitizer.
struct Built<'a> {
    workspace: &'a Workspace,
    sanitizer: &'a Sanitizer,
    programs: Vec<Artifact>,
    fmu_dir: PathBuf,
    /// Of FMI 2.0, then of 3.0.
    fmus: Vec<PathBuf>,
}

impl Sanitizer {
    /// Run the tests, and build programs and the suite's FMUs, all instrumented.
    fn build<'a>(&'a self, workspace: &'a Workspace, packages: &[&str]) -> Result<Built<'a>> {
        nightly::component(workspace, "rust-src")?;
        let environment = libclang::provide(workspace)?;
        let target = nightly::host(workspace)?;
        let suite = workspace.suite();
        let fmus = suite.iter().filter_map(|source| match source {
            Source::Package(name) => Some(name.as_str()),
            Source::Example(_) => None,
        });
        let all: Vec<&str> = fmus.chain(packages.iter().copied()).collect();
        // The test, FMUs and programs are built of the same packages, so that the features of what they share are the same too.
        let cargo = |command: &str| {
            let mut cargo = nightly::cargo(workspace);
            cargo.args([command, "-Zbuild-std", "--target", &target, "--target-dir"]);
            cargo.arg(workspace.target.join(self.folder));
            cargo
                .env("RUSTFLAGS", self.flags)
                .env(self.variable, self.options);
            cargo.envs(environment.iter().cloned());
            cargo.args(all.iter().flat_map(|name| ["-p", name]));
            cargo
        };
        execute(cargo("test").args(BORDER))?;
        let built = artifacts(&mut cargo("build"))?;
        let libraries: Vec<_> = suite.iter().filter_map(|s| s.library(&built)).collect();
        ensure!(
            libraries.len() == suite.len(),
            "cargo has not built the libraries of all FMUs"
        );
        let fmu_dir = workspace.target.join(self.folder).join("fmu");
        // A packer cannot load an instrumented library, so it packs the plain one first.
        let packed = pack::suite_with(workspace, "release", &Platforms::default(), &fmu_dir)?;
        let fmus = pack::both_versions(packed)?;
        for (fmu, library) in fmus.iter().zip(libraries.iter().cycle()) {
            pack::replace_library(fmu, library)?;
        }
        Ok(Built {
            workspace,
            sanitizer: self,
            programs: built,
            fmu_dir,
            fmus,
        })
    }
}

impl Built<'_> {
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
