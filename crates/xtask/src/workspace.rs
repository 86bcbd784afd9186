//! The cargo workspace: where it is, what is in it, and running its tools.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, anyhow, bail, ensure};
use serde_json::Value;

/// What `cargo metadata` says.
pub struct Workspace {
    /// Directory of the root Cargo.toml.
    pub root: PathBuf,
    /// Target directory, wherever the user has put it.
    pub target: PathBuf,
    metadata: Value,
}

/// Profile of the libraries that are packed, and of the benches.
pub const FMU_PROFILE: &str = "fmu-release";

/// A cdylib that becomes an FMU.
#[derive(Clone, Debug, PartialEq)]
pub enum Fmu {
    /// The library of a package.
    Package(String),
    /// An example of any package.
    Example(String),
}

impl Fmu {
    /// The packages and examples named on the command line.
    pub fn chosen(packages: &[String], examples: &[String]) -> Vec<Self> {
        let packages = packages.iter().cloned().map(Self::Package);
        packages
            .chain(examples.iter().cloned().map(Self::Example))
            .collect()
    }
}

impl Workspace {
    /// The workspace this program belongs to.
    pub fn find() -> Result<Self> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .ancestors()
            .nth(2)
            .context("xtask lies in crates/")?;
        let mut command = Command::new(cargo());
        command
            .current_dir(root)
            .args(["metadata", "--format-version", "1", "--no-deps"]);
        let metadata: Value =
            serde_json::from_str(&output(&mut command)?).context("cargo metadata")?;
        let text = |key: &str| {
            metadata[key]
                .as_str()
                .map(PathBuf::from)
                .with_context(|| format!("cargo metadata has no {key}"))
        };
        Ok(Self {
            root: text("workspace_root")?,
            target: text("target_directory")?,
            metadata,
        })
    }

    /// Where packed FMUs go.
    pub fn fmu_dir(&self) -> PathBuf {
        self.target.join("fmu")
    }

    /// The suite: packages in `fmu-*` folders of the root.
    pub fn suite(&self) -> Vec<Fmu> {
        let packages = self.metadata["packages"].as_array().into_iter().flatten();
        let at_root = |p: &&Value| {
            let folder = p["manifest_path"]
                .as_str()
                .map(Path::new)
                .and_then(Path::parent);
            folder.is_some_and(|f| {
                f.parent() == Some(&self.root)
                    && f.file_name()
                        .is_some_and(|n| n.to_string_lossy().starts_with("fmu-"))
            })
        };
        let names = packages.filter(at_root).filter_map(|p| p["name"].as_str());
        names.map(|name| Fmu::Package(name.to_string())).collect()
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
        let mut command = self.command(cargo());
        command.args(arguments);
        command
    }

    /// Build with a profile; the artifacts of kind `kind` (`cdylib` or `bin`) that cargo reports, by target name.
    pub fn build(
        &self,
        profile: &str,
        targets: &[&str],
        kind: &str,
        environment: &[(String, String)],
    ) -> Result<BTreeMap<String, PathBuf>> {
        let mut command = self.cargo([
            "build",
            "--profile",
            profile,
            "--message-format",
            "json-render-diagnostics",
        ]);
        command.args(targets).envs(environment.iter().cloned());
        let messages = output(&mut command)?;
        let artifacts = messages
            .lines()
            .filter_map(|line| serde_json::from_str::<Value>(line).ok());
        let of_kind = |m: &Value| {
            m["target"]["crate_types"]
                .as_array()
                .is_some_and(|kinds| kinds.iter().any(|k| k == kind))
        };
        let built = |m: Value| {
            let path = match kind {
                "bin" => m["executable"].as_str(),
                _ => m["filenames"]
                    .as_array()?
                    .iter()
                    .filter_map(Value::as_str)
                    .find(|f| is_shared_library(f)),
            };
            Some((
                m["target"]["name"].as_str()?.to_string(),
                PathBuf::from(path?),
            ))
        };
        Ok(artifacts
            .filter(|m| m["reason"] == "compiler-artifact" && of_kind(m))
            .filter_map(built)
            .collect())
    }

    /// Build the shared libraries of FMUs, in one go so that their dependencies are built once.
    pub fn build_fmus(&self, fmus: &[Fmu]) -> Result<Vec<PathBuf>> {
        let mut targets = Vec::new();
        for fmu in fmus {
            match fmu {
                Fmu::Package(name) => targets.extend(["--package", name]),
                Fmu::Example(name) => targets.extend(["--example", name]),
            }
        }
        if fmus.iter().any(|f| matches!(f, Fmu::Package(_))) {
            targets.push("--lib");
        }
        let built = self.build(FMU_PROFILE, &targets, "cdylib", &[])?;
        let library = |fmu: &Fmu| {
            let name = match fmu {
                Fmu::Package(name) | Fmu::Example(name) => name,
            };
            let found = built
                .get(name)
                .or_else(|| built.get(&name.replace('-', "_")));
            found
                .cloned()
                .ok_or_else(|| anyhow!("`{name}` has no cdylib"))
        };
        fmus.iter().map(library).collect()
    }

    /// Build a program.
    pub fn build_program(
        &self,
        package: &str,
        name: &str,
        environment: &[(String, String)],
    ) -> Result<PathBuf> {
        let target = ["--package", package, "--bin", name];
        let built = self.build("release", &target, "bin", environment)?;
        built
            .get(name)
            .cloned()
            .ok_or_else(|| anyhow!("`{package}` has no program `{name}`"))
    }
}

fn is_shared_library(file: &str) -> bool {
    let extension = Path::new(file).extension().and_then(OsStr::to_str);
    extension.is_some_and(|e| e == std::env::consts::DLL_EXTENSION)
}

/// The cargo that runs this program.
fn cargo() -> PathBuf {
    std::env::var_os("CARGO").map_or_else(|| PathBuf::from("cargo"), PathBuf::from)
}

/// Run a command; an error names it.
pub fn execute(command: &mut Command) -> Result<()> {
    let text = shown(command);
    let status = command
        .status()
        .with_context(|| format!("`{text}` cannot be started"))?;
    ensure!(status.success(), "`{text}` failed ({status})");
    Ok(())
}

/// Run a command; what it wrote to standard output.
pub fn output(command: &mut Command) -> Result<String> {
    let text = shown(command);
    let result = command
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("`{text}` cannot be started"))?;
    if !result.status.success() {
        bail!("`{text}` failed ({})", result.status);
    }
    String::from_utf8(result.stdout).with_context(|| format!("`{text}` wrote no UTF-8"))
}

fn shown(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words
        .map(|w| w.to_string_lossy().into_owned())
        .collect::<Vec<_>>()
        .join(" ")
}
