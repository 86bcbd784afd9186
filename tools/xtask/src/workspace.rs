//! This repository's workspace, for all commands: its folders, their files, its FMUs, and how cargo
//! builds it.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use cargo_fmu::workspace::{Source, artifacts, cargo};

/// Profile of the libraries that are packed, and of the benches.
pub const FMU_PROFILE: &str = cargo_fmu::pack::FMU_PROFILE;

/// The workspace as `cargo metadata` describes it.
pub struct Workspace {
    /// Directory of the root Cargo.toml.
    pub root: PathBuf,
    /// Cargo's target directory.
    pub target: PathBuf,
    /// The packages.
    pub cargo: cargo_fmu::workspace::Workspace,
}

impl Workspace {
    /// The workspace this program belongs to.
    pub fn find() -> Result<Self> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .ancestors()
            .nth(2)
            .context("xtask lies in tools/")?;
        let cargo = cargo_fmu::workspace::Workspace::containing(root)?;
        Ok(Self {
            root: cargo.root.clone(),
            target: cargo.target.clone(),
            cargo,
        })
    }

    /// Where packed FMUs go.
    pub fn fmu_dir(&self) -> PathBuf {
        self.target.join("fmu")
    }

    /// The suite: packages in `fmu-*` folders of the root.
    pub fn suite(&self) -> Vec<Source> {
        let packages = self.cargo.packages.iter().filter(|p| {
            let folder = p.folder();
            let is_fmu = |name: &OsStr| name.to_string_lossy().starts_with("fmu-");
            folder.parent() == Some(&self.root) && folder.file_name().is_some_and(is_fmu)
        });
        packages.map(|p| Source::Package(p.name.clone())).collect()
    }

    /// A command in the root folder, with the target directory of this workspace.
    pub fn command(&self, program: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new(program);
        command
            .current_dir(&self.root)
            .env("CARGO_TARGET_DIR", &self.target);
        command
    }

    /// A cargo command in the root folder.
    pub fn cargo<'a>(&self, arguments: impl IntoIterator<Item = &'a str>) -> Command {
        let mut command = self.command(cargo().get_program());
        command.args(arguments);
        command
    }

    /// Build programs or benches with a profile; their files, by target name.
    pub fn build(&self, profile: &str, targets: &[&str]) -> Result<BTreeMap<String, PathBuf>> {
        let mut command = self.cargo(["build", "--profile", profile]);
        command.args(targets);
        let built = artifacts(&mut command)?.into_iter();
        let programs = built.filter_map(|a| Some((a.name().to_string(), a.executable?)));
        Ok(programs.collect())
    }

    /// Build the shared libraries of FMUs, in one go so that their dependencies are built once.
    pub fn build_fmus(&self, sources: &[Source]) -> Result<Vec<PathBuf>> {
        let built = self.cargo.build(sources, &profile(FMU_PROFILE))?;
        Ok(built.into_iter().map(|(library, _)| library).collect())
    }

    /// Build programs, from the crates that the tests of the whole workspace are built from: with
    /// the same features. The file of the first.
    pub fn build_programs(&self, names: &[&str]) -> Result<PathBuf> {
        let programs = names.iter().flat_map(|name| ["--bin", name]);
        let targets: Vec<_> = ["--workspace"].into_iter().chain(programs).collect();
        self.build_program("release", &targets, names.first().context("a program")?)
    }

    /// As [`Self::build`]; the file of the program `name`.
    pub fn build_program(&self, profile: &str, targets: &[&str], name: &str) -> Result<PathBuf> {
        let program = self.build(profile, targets)?.remove(name);
        program.with_context(|| format!("there is no program `{name}`"))
    }
}

/// The files with this suffix in a folder itself, sorted by name.
pub fn archives(folder: &Path, suffix: &str) -> Result<Vec<PathBuf>> {
    let mut all = files(folder)?;
    let is_one = |path: &PathBuf| {
        path.parent() == Some(folder) && path.extension().is_some_and(|e| e == suffix)
    };
    all.retain(is_one);
    Ok(all)
}

/// All files below a folder, sorted by name.
pub fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        match path.is_dir() {
            true => found.extend(files(&path)?),
            false => found.push(path),
        }
    }
    found.sort();
    Ok(found)
}

/// Name of a file.
pub fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// Whether this is continuous integration (environment variable CI).
pub fn is_ci() -> bool {
    std::env::var("CI").is_ok_and(|ci| !matches!(ci.as_str(), "" | "0" | "false"))
}

/// Arguments of cargo for a profile of this workspace's Cargo.toml.
pub fn profile(name: &str) -> [String; 2] {
    ["--profile".to_string(), name.to_string()]
}
