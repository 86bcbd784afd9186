//! A cargo workspace, also for `xtask`: finds packages that make FMUs, and lets cargo build them.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, anyhow};
use serde::Deserialize;

use crate::process::output;

/// A workspace, as `cargo metadata` describes it.
#[derive(Debug, Deserialize)]
pub struct Workspace {
    /// Folder of the root Cargo.toml.
    #[serde(rename = "workspace_root")]
    pub root: PathBuf,
    /// Target directory.
    #[serde(rename = "target_directory")]
    pub target: PathBuf,
    /// The members.
    pub packages: Vec<Package>,
    /// Structural parameters that FMUs are packed with, such as `n=200`.
    #[serde(skip)]
    pub sizes: Vec<String>,
}

/// A package of the workspace, or one that it depends on.
#[derive(Debug, Deserialize)]
pub struct Package {
    /// Name.
    pub name: String,
    /// SPDX licence expression.
    pub license: Option<String>,
    pub(crate) version: String,
    pub(crate) id: String,
    pub(crate) license_file: Option<PathBuf>,
    pub(crate) repository: Option<String>,
    pub(crate) authors: Vec<String>,
    pub(crate) metadata: Option<serde_json::Value>,
    publish: Option<Vec<String>>,
    manifest_path: PathBuf,
    targets: Vec<Target>,
    dependencies: Vec<Dependency>,
}

#[derive(Debug, Deserialize)]
struct Target {
    name: String,
    kind: Vec<String>,
    crate_types: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Dependency {
    name: String,
}

/// A cdylib that becomes an FMU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// The library of a package.
    Package(String),
    /// An example of any package.
    Example(String),
}

/// A file that cargo has built.
#[derive(Debug, Deserialize)]
pub struct Artifact {
    target: Target,
    filenames: Vec<PathBuf>,
    /// A program, test or bench.
    pub executable: Option<PathBuf>,
}

/// The cargo that runs this program, else the one on the path.
pub fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

impl Workspace {
    /// The workspace that a folder is in.
    pub fn containing(folder: &Path) -> Result<Self> {
        let mut command = cargo();
        command.current_dir(folder);
        command.args(["metadata", "--format-version", "1", "--no-deps"]);
        serde_json::from_str(&output(&mut command)?).context("the answer of cargo metadata")
    }

    /// The packages that make FMUs. Inside a package's folder: only that package, or none if it
    /// makes no FMU.
    pub fn fmus(&self, folder: &Path) -> Vec<Source> {
        let around = |p: &&Package| folder.starts_with(p.folder()) && p.folder() != self.root;
        let nearest = self.packages.iter().filter(around);
        let nearest = nearest.max_by_key(|p| p.folder().as_os_str().len());
        let chosen = self.packages.iter().filter(|p| match nearest {
            Some(nearest) => nearest.name == p.name,
            None => true,
        });
        let with_library = chosen.filter(|p| p.is_fmu()).map(|p| p.name.clone());
        with_library.map(Source::Package).collect()
    }

    /// Builds the libraries of FMUs for this machine; returns each with its package.
    pub fn build(
        &self,
        sources: &[Source],
        profile: &[String],
    ) -> Result<Vec<(PathBuf, &Package)>> {
        let mut command = cargo();
        command.current_dir(&self.root).arg("build");
        self.build_with(command, sources, profile)
    }

    /// Builds the libraries with this build command, all at once, so that dependencies are built
    /// once.
    pub fn build_with(
        &self,
        mut command: Command,
        sources: &[Source],
        profile: &[String],
    ) -> Result<Vec<(PathBuf, &Package)>> {
        command.args(profile);
        // `fmu_export::export_fmu!` reads it, so that other sizes cause a new build.
        match &self.sizes[..] {
            [] => command.env_remove("FMU_SIZES"),
            sizes => command.env("FMU_SIZES", sizes.join(" ")),
        };
        for source in sources {
            match source {
                Source::Package(name) => command.args(["--package", name]),
                Source::Example(name) => command.args(["--example", name]),
            };
        }
        if sources.iter().any(|s| matches!(s, Source::Package(_))) {
            command.arg("--lib");
        }
        let built = artifacts(&mut command)?;
        let library = |source: &Source| {
            let package = self.package(source)?;
            let library = source.library(&built).with_context(|| {
                format!("`{}` is no cdylib: its [lib] or [[example]] must have crate-type = [\"cdylib\"]", source.name())
            })?;
            Ok((library, package))
        };
        sources.iter().map(library).collect()
    }

    fn package(&self, source: &Source) -> Result<&Package> {
        let is_it = |p: &&Package| match source {
            Source::Package(name) => p.name == *name,
            Source::Example(name) => p.targets.iter().any(|t| t.is_example() && t.name == *name),
        };
        let found = self.packages.iter().find(is_it);
        found.ok_or_else(|| match source {
            Source::Package(name) => anyhow!("the workspace has no package `{name}`"),
            Source::Example(name) => anyhow!("the workspace has no example `{name}`"),
        })
    }
}

impl Package {
    /// Folder of its Cargo.toml.
    pub fn folder(&self) -> &Path {
        self.manifest_path.parent().unwrap_or(Path::new("/"))
    }

    /// Whether it may be published: `publish = false` is an empty list of registries.
    pub fn is_published(&self) -> bool {
        let registries = self.publish.as_ref();
        registries.is_none_or(|registries| !registries.is_empty())
    }

    /// Whether it is a cdylib that depends on `fmu-export`.
    fn is_fmu(&self) -> bool {
        let is_cdylib = |t: &Target| t.kind.iter().any(|k| k == "cdylib");
        self.targets.iter().any(is_cdylib)
            && self.dependencies.iter().any(|d| d.name == "fmu-export")
    }
}

impl Target {
    fn is_example(&self) -> bool {
        self.kind.iter().any(|k| k == "example")
    }
}

impl Source {
    /// The packages and examples named on a command line.
    pub fn chosen(packages: Vec<String>, examples: Vec<String>) -> Vec<Self> {
        let examples = examples.into_iter().map(Self::Example);
        packages
            .into_iter()
            .map(Self::Package)
            .chain(examples)
            .collect()
    }

    /// Its shared library among what cargo has built.
    pub fn library(&self, built: &[Artifact]) -> Option<PathBuf> {
        let name = self.name().replace('-', "_");
        let fits = |a: &&Artifact| a.name().replace('-', "_") == name && a.is_of(self);
        built.iter().filter(fits).find_map(Artifact::library)
    }

    fn name(&self) -> &str {
        match self {
            Self::Package(name) | Self::Example(name) => name,
        }
    }
}

impl Artifact {
    /// Name of the target.
    pub fn name(&self) -> &str {
        &self.target.name
    }

    fn is_of(&self, source: &Source) -> bool {
        self.target.is_example() == matches!(source, Source::Example(_))
    }

    /// The shared library of a cdylib.
    fn library(&self) -> Option<PathBuf> {
        let is_cdylib = self.target.crate_types.iter().any(|t| t == "cdylib");
        let mut files = self.filenames.iter();
        let is_shared = |f: &&PathBuf| {
            f.extension()
                .is_some_and(|e| ["so", "dll", "dylib", "wasm"].iter().any(|s| e == *s))
        };
        files.find(is_shared).filter(|_| is_cdylib).cloned()
    }
}

/// Runs a cargo command that builds; returns what it has built.
pub fn artifacts(command: &mut Command) -> Result<Vec<Artifact>> {
    #[derive(Deserialize)]
    struct Message {
        reason: String,
    }
    let messages = output(command.args(["--message-format", "json-render-diagnostics"]))?;
    let is_artifact = |line: &&str| {
        serde_json::from_str::<Message>(line).is_ok_and(|m| m.reason == "compiler-artifact")
    };
    let artifacts = messages
        .lines()
        .filter(is_artifact)
        .map(serde_json::from_str);
    let artifacts = artifacts.collect::<Result<_, _>>();
    artifacts.context("the messages of cargo")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_that_make_fmus_are_found_by_folder() {
        let workspace = Workspace::containing(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap();
        let root = workspace.root.clone();
        let package = |name: &str| Source::Package(name.to_string());
        let all = workspace.fmus(&root);
        assert!(all.contains(&package("fmu-emla")) && all.contains(&package("fmu-oscillator")));
        assert!(!all.contains(&package("emla")) && !all.contains(&package("fmu-export")));
        let inside = root.join("kit/fmu-export/example/src");
        assert_eq!(workspace.fmus(&inside), [package("fmu-oscillator")]);
        assert_eq!(workspace.fmus(&root.join("machine/emla")), []);
        let missing = workspace.package(&package("nothing")).unwrap_err();
        assert_eq!(
            missing.to_string(),
            "the workspace has no package `nothing`"
        );
    }

    /// A package and an example of one name are told apart, and of a library's files the one that
    /// can be loaded is taken.
    #[test]
    fn the_library_of_a_source_is_chosen() {
        let artifact = |kind: &str, files: &str| -> Artifact {
            let target =
                format!(r#"{{"name":"my_lag","kind":["{kind}"],"crate_types":["cdylib"]}}"#);
            let text = format!(r#"{{"target":{target},"filenames":[{files}],"executable":null}}"#);
            serde_json::from_str(&text).unwrap()
        };
        let built = [
            artifact("example", r#""/x/examples/libmy_lag.so""#),
            artifact("cdylib", r#""/x/my_lag.dll.lib","/x/my_lag.dll""#),
        ];
        let found = |source: Source| source.library(&built);
        assert_eq!(
            found(Source::Package("my-lag".into())),
            Some("/x/my_lag.dll".into())
        );
        let example = Some("/x/examples/libmy_lag.so".into());
        assert_eq!(found(Source::Example("my_lag".into())), example);
        assert_eq!(found(Source::Package("other".into())), None);
    }
}
