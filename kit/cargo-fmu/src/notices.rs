//! Third-party notices for a library or program, for `pack` and `xtask`: names, versions, licences
//! and licence texts of all that others wrote in it, the same bytes on every machine.
//!
//! The crates are those of `cargo tree`. Their texts are the licence files in each crate, else the
//! text of SPDX for its licence. What a package contains besides crates (scripts, data, C code) is
//! named in its Cargo.toml:
//!
//! ```toml
//! [[package.metadata.third-party]]
//! name = "three.js"
//! version = "0.187.0"
//! license = "MIT"
//! file = "assets/three/LICENSE"
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde::Deserialize;

use crate::licences;
use crate::process::output;
use crate::workspace::{Package, Workspace, cargo};
use fmi_description::Entries;

const CRATES: &str = "third-party.txt";
const STANDARD_LIBRARY: &str = "rust-standard-library.html";

/// What `cargo metadata` says of the packages of a workspace and all that they depend on.
#[derive(Deserialize)]
pub struct Notices {
    packages: Vec<Package>,
    workspace_members: BTreeSet<String>,
}

/// A crate or other part that someone else wrote.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, PartialOrd, Ord)]
struct ThirdParty {
    name: String,
    version: String,
    license: String,
    #[serde(default)]
    origin: String,
    #[serde(default)]
    texts: Vec<String>,
}

impl Notices {
    /// Reads what `cargo metadata` says about a workspace.
    pub fn new(workspace: &Workspace) -> Result<Self> {
        let mut command = cargo();
        command.current_dir(&workspace.root);
        command.args(["metadata", "--format-version", "1"]);
        serde_json::from_str(&output(&mut command)?).context("the answer of cargo metadata")
    }

    /// The notices for a package's library or program, as files by name. `triples` are the
    /// compiler's targets that it is built for; none means this machine.
    pub fn files(&self, workspace: &Workspace, package: &str, triples: &[&str]) -> Result<Entries> {
        let mut parts = BTreeSet::new();
        let host = [""];
        for triple in if triples.is_empty() { &host } else { triples } {
            for (name, version) in compiled_in(workspace, package, triple)? {
                let is_it = |p: &&Package| p.name == name && p.version == version;
                let found = (self.packages.iter().find(is_it))
                    .with_context(|| format!("cargo metadata knows no {name} {version}"))?;
                parts.extend(found.declared()?);
                if !self.workspace_members.contains(&found.id) {
                    parts.insert(found.part()?);
                }
            }
        }
        let (version, standard) = standard_library()?;
        parts.insert(ThirdParty {
            name: "Rust standard library".into(),
            version,
            license: "MIT OR Apache-2.0".into(),
            origin: "https://www.rust-lang.org".into(),
            texts: match &standard {
                Some(_) => vec![format!("See {STANDARD_LIBRARY}.\n")],
                None => vec![spdx_texts(
                    "MIT OR Apache-2.0",
                    &["The Rust Project Contributors".into()],
                )?],
            },
        });
        let mut files =
            Entries::from([(CRATES.to_string(), listing(package, &parts).into_bytes())]);
        files.extend(standard.map(|text| (STANDARD_LIBRARY.to_string(), text)));
        Ok(files)
    }
}

/// Names and versions of the crates that are compiled into a package, including itself.
fn compiled_in(
    workspace: &Workspace,
    package: &str,
    triple: &str,
) -> Result<BTreeSet<(String, String)>> {
    let mut tree = cargo();
    tree.current_dir(&workspace.root).args([
        "tree",
        "--package",
        package,
        "--edges",
        "normal,no-proc-macro",
    ]);
    tree.args(["--prefix", "none", "--no-dedupe", "--format", "{p}"]);
    if !triple.is_empty() {
        tree.args(["--target", triple]);
    }
    let text = output(&mut tree)?;
    let part = |line: &str| {
        let mut words = line.split_whitespace();
        let (name, version) = (words.next()?, words.next()?.strip_prefix('v')?);
        Some((name.to_string(), version.to_string()))
    };
    Ok(text.lines().filter_map(part).collect())
}

/// Version of the standard library, and its own notices if the toolchain has them.
fn standard_library() -> Result<(String, Option<Vec<u8>>)> {
    let version = output(Command::new("rustc").arg("--version"))?;
    let version = version.split_whitespace().nth(1).unwrap_or("").to_string();
    let sysroot = output(Command::new("rustc").args(["--print", "sysroot"]))?;
    let file = Path::new(sysroot.trim()).join("share/doc/rust/COPYRIGHT-library.html");
    Ok((version, fs::read(file).ok()))
}

impl Package {
    /// The crate itself.
    fn part(&self) -> Result<ThirdParty> {
        let license = self
            .license
            .as_deref()
            .unwrap_or("see its text")
            .to_string();
        let mut texts = self.texts()?;
        if texts.is_empty() {
            texts.push(spdx_texts(&license, &self.authors).with_context(|| self.name.clone())?);
        }
        Ok(ThirdParty {
            name: self.name.clone(),
            version: self.version.clone(),
            license,
            origin: self.repository.clone().unwrap_or_default(),
            texts,
        })
    }

    /// Its licence files: in its folder, or for a crate of a local repository in the folders above.
    fn texts(&self) -> Result<Vec<String>> {
        if let Some(file) = &self.license_file {
            return Ok(vec![read(&self.folder().join(file))?]);
        }
        for folder in self.folder().ancestors().take(3) {
            let files = licences::in_folder(folder)?;
            if !files.is_empty() {
                return files.iter().map(|file| read(file)).collect();
            }
            if !self.id.starts_with("path+") {
                break;
            }
        }
        Ok(Vec::new())
    }

    /// What its Cargo.toml says that it contains besides crates.
    fn declared(&self) -> Result<Vec<ThirdParty>> {
        #[derive(Deserialize)]
        struct Declared {
            #[serde(flatten)]
            part: ThirdParty,
            file: PathBuf,
        }
        let named = self.metadata.as_ref().and_then(|m| m.get("third-party"));
        let named: Vec<Declared> = match named {
            Some(value) => serde_json::from_value(value.clone())
                .with_context(|| format!("{}: package.metadata.third-party", self.name))?,
            None => Vec::new(),
        };
        let part = |Declared { part, file }| {
            let texts = vec![read(&self.folder().join(file))?];
            Ok(ThirdParty { texts, ..part })
        };
        named.into_iter().map(part).collect()
    }
}

/// A text file, with `\n` as line ends.
fn read(file: &Path) -> Result<String> {
    let bytes = fs::read(file).with_context(|| file.display().to_string())?;
    Ok(String::from_utf8_lossy(&bytes).replace("\r\n", "\n"))
}

/// The texts of SPDX for a licence expression; only that of MIT if MIT can be chosen.
fn spdx_texts(expression: &str, authors: &[String]) -> Result<String> {
    let expression = spdx::Expression::parse_mode(expression, spdx::ParseMode::LAX)
        .with_context(|| format!("`{expression}` is no licence expression of SPDX"))?;
    let mit = spdx::license_id("MIT");
    let is_mit = |id: Option<spdx::LicenseId>| id.is_some() && id == mit;
    let has_choice = expression.evaluate(|requirement| is_mit(requirement.license.id()));
    let requirements = expression.requirements();
    let mut ids: BTreeSet<_> = requirements.filter_map(|r| r.req.license.id()).collect();
    ids.retain(|id| !has_choice || is_mit(Some(*id)));
    let mut text = match authors.is_empty() {
        true => String::new(),
        false => format!("Copyright (c) {}\n\n", authors.join(", ")),
    };
    for id in ids {
        let _ = writeln!(text, "{}", id.text().trim()); // writing to a String cannot fail
    }
    Ok(text)
}

/// Lists the parts, then each text once with the parts that it belongs to.
fn listing(package: &str, parts: &BTreeSet<ThirdParty>) -> String {
    let mut text =
        format!("What others wrote and is part of {package}, with the texts of its licences.\n\n");
    let named = |part: &ThirdParty| format!("{} {}", part.name, part.version);
    let mut owners: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for part in parts {
        let line = format!("{:<32} {:<32} {}", named(part), part.license, part.origin);
        text += &format!("{}\n", line.trim_end());
        for of_part in &part.texts {
            owners.entry(of_part.trim()).or_default().push(named(part));
        }
    }
    let blocks = owners.into_iter().map(|(text, owners)| (owners, text));
    for (owners, licence) in BTreeSet::from_iter(blocks) {
        let line = "=".repeat(100);
        text += &format!("\n{line}\n{}\n{line}\n\n{licence}\n", owners.join(", "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notices_name_what_is_compiled_in_and_nothing_else() {
        let workspace = Workspace::containing(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap();
        let notices = Notices::new(&workspace).unwrap();
        let files = notices.files(&workspace, "fmu-export", &[]).unwrap();
        let text = std::str::from_utf8(&files[CRATES]).unwrap();
        let names: Vec<_> = text.lines().map(|l| l.split(' ').next().unwrap()).collect();
        for name in ["serde", "uuid", "Rust"] {
            assert!(names.contains(&name), "{name}:\n{text}");
        }
        for name in ["fmu-export", "serde_derive", "syn", "clap"] {
            assert!(
                !names.contains(&name),
                "{name} is no part of the library:\n{text}"
            );
        }
        assert!(text.contains("Permission is hereby granted"));
        let root = workspace.root.to_str().unwrap();
        assert!(
            !text.contains(root) && !text.contains(".cargo"),
            "a path of this machine"
        );
        assert_eq!(notices.files(&workspace, "fmu-export", &[]).unwrap(), files);
    }

    /// The programs of the report embed two scripts, whose versions stand at their heads.
    #[test]
    fn scripts_that_a_package_names_are_told() {
        let workspace = Workspace::containing(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap();
        let notices = Notices::new(&workspace).unwrap();
        let files = notices.files(&workspace, "report", &[]).unwrap();
        let text = std::str::from_utf8(&files[CRATES]).unwrap();
        let version = |name: &str| {
            let line = text.lines().find(|line| line.starts_with(name)).unwrap();
            line.split_whitespace().nth(1).unwrap()
        };
        for (name, script) in [
            ("three.js", "three/three.min.js"),
            ("plotly.js", "plotly/plotly.min.js"),
        ] {
            let assets = workspace.root.join("studies/report/assets");
            let script = fs::read_to_string(assets.join(script)).unwrap();
            assert!(script[..200].contains(version(name)), "{name}");
        }
        assert!(text.contains("Copyright 2012-2025, Plotly, Inc."), "{text}");
    }

    /// MIT alone where it is a choice, else every licence that is needed.
    #[test]
    fn a_crate_without_files_has_the_texts_of_its_licences() {
        let choice = spdx_texts("Apache-2.0 OR MIT", &["Ada".into()]).unwrap();
        assert!(choice.starts_with("Copyright (c) Ada\n") && choice.contains("MIT License"));
        assert!(!choice.contains("Apache License"));
        let both = spdx_texts("MIT AND BSD-3-Clause", &[]).unwrap();
        assert!(
            both.contains("MIT License") && both.contains("Neither the name"),
            "{both}"
        );
        assert!(spdx_texts("no licence", &[]).is_err());
    }

    #[test]
    fn a_text_that_several_share_is_there_once() {
        let part = |name: &str| ThirdParty {
            name: name.into(),
            version: "1.0".into(),
            license: "MIT".into(),
            origin: String::new(),
            texts: vec!["words of a licence\n".into()],
        };
        let text = listing("x", &BTreeSet::from([part("b"), part("a")]));
        assert_eq!(text.matches("words of a licence").count(), 1, "{text}");
        assert!(text.contains("\na 1.0, b 1.0\n"), "{text}");
    }
}
