//! Notices of what others wrote and is compiled into a library or program: names, versions,
//! licences and their texts, the same bytes on every machine.
//!
//! Which crates these are, `cargo tree` says; the texts are the files that lie in each crate, else
//! the text of its licence as SPDX has it. What a package carries beside crates (scripts, data, C
//! code) it names in its Cargo.toml:
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

/// Something that is compiled in.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, PartialOrd, Ord)]
struct Part {
    name: String,
    version: String,
    license: String,
    #[serde(default)]
    origin: String,
    #[serde(default)]
    texts: Vec<String>,
}

impl Notices {
    /// For the packages of a workspace.
    pub fn new(workspace: &Workspace) -> Result<Self> {
        let mut command = cargo();
        command
            .current_dir(&workspace.root)
            .args(["metadata", "--format-version", "1"]);
        serde_json::from_str(&output(&mut command)?).context("the answer of cargo metadata")
    }

    /// The notices of a package's library or program for these targets of the compiler (none: this
    /// machine's), as files by name.
    pub fn files(&self, workspace: &Workspace, package: &str, triples: &[&str]) -> Result<Entries> {
        let mut parts = BTreeSet::new();
        let host = [""];
        for triple in if triples.is_empty() { &host } else { triples } {
            for (name, version) in compiled_in(workspace, package, triple)? {
                let found = self
                    .packages
                    .iter()
                    .find(|p| p.name == name && p.version == version);
                let found =
                    found.with_context(|| format!("cargo metadata knows no {name} {version}"))?;
                parts.extend(found.carried()?);
                if !self.workspace_members.contains(&found.id) {
                    parts.insert(found.part()?);
                }
            }
        }
        let (version, standard) = standard_library()?;
        parts.insert(Part {
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

/// Names and versions of the crates that are compiled into a package, itself among them.
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

/// Version of the compiler's standard library, and its own notices where the toolchain has them.
fn standard_library() -> Result<(String, Option<Vec<u8>>)> {
    let version = output(Command::new("rustc").arg("--version"))?;
    let version = version.split_whitespace().nth(1).unwrap_or("").to_string();
    let sysroot = output(Command::new("rustc").args(["--print", "sysroot"]))?;
    let file = Path::new(sysroot.trim()).join("share/doc/rust/COPYRIGHT-library.html");
    Ok((version, fs::read(file).ok()))
}

impl Package {
    /// The crate itself.
    fn part(&self) -> Result<Part> {
        let license = self
            .license
            .clone()
            .unwrap_or_else(|| "see its text".into());
        let mut texts = self.texts()?;
        if texts.is_empty() {
            texts.push(spdx_texts(&license, &self.authors).with_context(|| self.name.clone())?);
        }
        Ok(Part {
            name: self.name.clone(),
            version: self.version.clone(),
            license,
            origin: self.repository.clone().unwrap_or_default(),
            texts,
        })
    }

    /// The licence files in its folder; for a crate that lies in another repository on this
    /// machine, in the folders around it.
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

    /// What it says that it carries beside crates.
    fn carried(&self) -> Result<Vec<Part>> {
        #[derive(Deserialize)]
        struct Carried {
            #[serde(flatten)]
            part: Part,
            file: PathBuf,
        }
        let named = self.metadata.as_ref().and_then(|m| m.get("third-party"));
        let named: Vec<Carried> = match named {
            Some(value) => serde_json::from_value(value.clone())
                .with_context(|| format!("{}: package.metadata.third-party", self.name))?,
            None => Vec::new(),
        };
        let part = |Carried { part, file }| {
            let texts = vec![read(&self.folder().join(file))?];
            Ok(Part { texts, ..part })
        };
        named.into_iter().map(part).collect()
    }
}

/// A text, with the line ends of this format whatever the crate uses.
fn read(file: &Path) -> Result<String> {
    let bytes = fs::read(file).with_context(|| file.display().to_string())?;
    Ok(String::from_utf8_lossy(&bytes).replace("\r\n", "\n"))
}

/// Texts of a licence expression as SPDX has them: of MIT alone where that is a choice.
fn spdx_texts(expression: &str, authors: &[String]) -> Result<String> {
    let expression = spdx::Expression::parse_mode(expression, spdx::ParseMode::LAX)
        .with_context(|| format!("`{expression}` is no licence expression of SPDX"))?;
    let mit = spdx::license_id("MIT");
    let is_mit = |id: Option<spdx::LicenseId>| id.is_some() && id == mit;
    let has_choice = expression.evaluate(|requirement| is_mit(requirement.license.id()));
    let ids: BTreeSet<_> = expression
        .requirements()
        .filter_map(|r| r.req.license.id())
        .collect();
    let mut text = match authors.is_empty() {
        true => String::new(),
        false => format!("Copyright (c) {}\n\n", authors.join(", ")),
    };
    for id in ids
        .into_iter()
        .filter(|id| !has_choice || is_mit(Some(*id)))
    {
        let _ = writeln!(text, "{}", id.text().trim()); // writing to a String cannot fail
    }
    Ok(text)
}

/// The parts, and each text once with the parts that it belongs to.
fn listing(package: &str, parts: &BTreeSet<Part>) -> String {
    let mut text =
        format!("What others wrote and is part of {package}, with the texts of its licences.\n\n");
    let named = |part: &Part| format!("{} {}", part.name, part.version);
    let mut owners: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for part in parts {
        let line = format!("{:<32} {:<32} {}", named(part), part.license, part.origin);
        text += &format!("{}\n", line.trim_end());
        for of_part in &part.texts {
            owners.entry(of_part.trim()).or_default().push(named(part));
        }
    }
    let mut blocks: Vec<_> = owners
        .into_iter()
        .map(|(text, owners)| (owners, text))
        .collect();
    blocks.sort();
    for (owners, licence) in blocks {
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
        let workspace = Workspace::of(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap();
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
        let workspace = Workspace::of(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap();
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
        let part = |name: &str| Part {
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
