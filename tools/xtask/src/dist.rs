//! `cargo xtask dist`: makes the folder that is handed out, also for `test`. Its FMUs hold a
//! library for each platform, its programs and libraries run on any machine of a platform, and a
//! commit gives the same bytes wherever it is built.

mod check;
mod folder;
mod listing;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use cargo_fmu::notices::Notices;
use cargo_fmu::pack::{FMI3_FOLDER, Platforms, fmi3_files};
use cargo_fmu::process::output;
use cargo_fmu::target::{TARGETS, Target};
use cargo_fmu::workspace::artifacts;
use clap::Args;
use sha2::{Digest, Sha256};

use crate::python::Python;
use crate::workspace::{FMU_PROFILE, Workspace, file_name, files, is_ci, profile};
use crate::{cosim_wasm, pack, web, wheel};
pub use check::{prepare, try_wheel};
use folder::{CHECKSUMS, Dist};
use listing::Listing;

#[derive(Args)]
pub struct Options {
    /// Platform to build for, repeatable: linux64, win64, aarch64-linux, darwin64, aarch64-darwin
    /// [default: all, those of macOS where they can be built]
    #[arg(long = "platform", value_name = "PLATFORM")]
    platforms: Vec<String>,
    /// Folder for the result, which is replaced [default: dist/ in the cargo target directory]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Leave out `hdrm-fmu` and the programs beside it, and WebAssembly with the live machine,
    /// which take longest to build
    #[arg(long)]
    without_experiments: bool,
    /// Run what was built: here, in an old Debian and under Wine, with equal numbers; random calls;
    /// states carried between platforms
    #[arg(long)]
    check: bool,
    /// Build a second time from a copy of the source in another folder, and compare every byte
    #[arg(long)]
    again: bool,
}

/// The platforms that CI builds for: always the first, at night all.
const CI_PLATFORMS: [&str; 2] = ["linux64", "win64"];
/// Programs that are handed out, with their packages.
const PROGRAMS: [(&str, &str); 5] = [
    ("cosim", "cosim"),
    (cosim_wasm::PROGRAM, cosim_wasm::PROGRAM),
    ("experiments", "hdrm-fmu"),
    ("report", "hdrm-fmu-report"),
    ("surrogate", "hdrm-fmu-surrogate"),
];
/// Packages to build: those of `PROGRAMS`, and `torture`, which the checks run; experiments last.
const PACKAGES: [&str; 5] = ["cosim", "torture", "experiments", "report", "surrogate"];
/// The profile of the programs: as for this machine, but without debug assertions, overflow checks
/// and symbols.
const PROGRAM_PROFILE: [&str; 3] = [
    "profile.release.debug-assertions=false",
    "profile.release.overflow-checks=false",
    "profile.release.strip=\"symbols\"",
];
const README: &str = include_str!("dist/README.md");

/// The folder that was built, and its listing.
pub struct Handout {
    dist: Dist,
    listing: Listing,
    options: Options,
}

/// Builds the folder, and tries it as the options say.
pub fn run(workspace: &Workspace, caller: &Path, options: Options) -> Result<()> {
    make(workspace, caller, options)?.try_out(workspace)
}

fn ci_platforms(nightly: bool) -> Vec<String> {
    let count = if nightly { CI_PLATFORMS.len() } else { 1 };
    let platforms = CI_PLATFORMS.iter().take(count);
    platforms.map(ToString::to_string).collect()
}

/// Builds the folder for CI: libraries and co-simulation program for [`CI_PLATFORMS`]. The other
/// programs and platforms take the same steps.
pub fn for_ci(workspace: &Workspace, nightly: bool) -> Result<Handout> {
    let options = Options {
        platforms: ci_platforms(nightly),
        out: None,
        without_experiments: true,
        check: true,
        again: false,
    };
    make(workspace, &workspace.root, options)
}

fn make(workspace: &Workspace, caller: &Path, options: Options) -> Result<Handout> {
    let folder = options.out.clone();
    let folder = caller.join(folder.unwrap_or_else(|| workspace.target.join("dist")));
    ensure!(
        !options.again || !commit(workspace)?.ends_with("-dirty"),
        "--again builds what is committed, but there are changes that are not"
    );
    let mut listing = Listing::default();
    let platforms = platforms(workspace, &options.platforms, &mut listing)?;
    let dist = build(workspace, &platforms, folder, options.without_experiments)?;
    if options.without_experiments {
        let left_out = "`hdrm-fmu`, WebAssembly, machine.html: --without-experiments";
        listing.add("all", "not built", left_out);
    }
    listing.built(&dist)?;
    Ok(Handout {
        dist,
        listing,
        options,
    })
}

impl Handout {
    /// Runs its content and builds it again, as the options say, and prints the listing.
    pub fn try_out(mut self, workspace: &Workspace) -> Result<()> {
        let (dist, options) = (&self.dist, &self.options);
        let checked = if options.check {
            check::run(workspace, dist, &mut self.listing)
        } else {
            let why = "`cargo xtask dist --check` was not asked for";
            for target in &dist.targets {
                self.listing.add(target.platform.folder, "not run", why);
            }
            Ok(())
        };
        let repeated = match options.again {
            true => check::build_again(workspace, dist, options.without_experiments),
            false => Ok(()),
        };
        print!("\n{}", self.listing);
        println!("in {}", dist.folder.display());
        checked.and(repeated)?;
        let lacking = self.listing.lacking();
        ensure!(
            lacking.is_empty() || !is_ci(),
            "in CI nothing may be skipped, but these runs could not be made: {lacking}"
        );
        Ok(())
    }

    /// Copies the FMUs and systems to another folder; returns the FMUs of FMI 2.0, in the order of
    /// [`Workspace::suite`].
    pub fn copy(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        let dist = &self.dist;
        fs::create_dir_all(folder.join(FMI3_FOLDER))
            .with_context(|| folder.display().to_string())?;
        for from in [dist.fmus()?, dist.fmus_3()?, dist.systems()?].concat() {
            let to = folder.join(from.strip_prefix(&dist.folder)?);
            fs::copy(&from, &to).with_context(|| to.display().to_string())?;
        }
        Ok(dist.suite.iter().map(|name| folder.join(name)).collect())
    }
}

/// What this machine lacks to build what CI builds; empty where nothing is missing.
pub fn lacking(workspace: &Workspace, nightly: bool) -> Result<String> {
    let mut platforms = Platforms::named(&ci_platforms(nightly))?;
    platforms.tools = Python::provide(workspace)?.zig(workspace)?;
    Ok(missing(&platforms).join("\n"))
}

/// The platforms, with the tools to build for them. Lists each platform that is not built: by
/// default macOS where tools are missing, else what was not named.
fn platforms(workspace: &Workspace, names: &[String], listing: &mut Listing) -> Result<Platforms> {
    let mut platforms = Platforms::named(names)?;
    let is_default = platforms.targets.is_empty();
    if is_default || platforms.targets.iter().any(|t| t.needs_zig()) {
        platforms.tools = Python::provide(workspace)?.zig(workspace)?;
    }
    if is_default {
        platforms.targets = TARGETS.iter().collect();
        platforms.targets.retain(|target| {
            let missing = target.missing(&platforms.tools);
            let is_optional = target.is_macos() && !missing.is_empty();
            if is_optional {
                listing.add(target.platform.folder, "not built", &missing.join("; "));
            }
            !is_optional
        });
    }
    let missing = missing(&platforms);
    if !missing.is_empty() {
        bail!(
            "{}\n`cargo xtask dist --platform NAME` builds for one platform alone",
            missing.join("\n")
        );
    }
    for target in &TARGETS {
        if !platforms.targets.contains(&target) && !is_default {
            listing.add(target.platform.folder, "not built", "it was not asked for");
        }
    }
    Ok(platforms)
}

/// What this machine lacks to build for the platforms: a line each.
fn missing(platforms: &Platforms) -> Vec<String> {
    let lines = platforms.targets.iter().filter_map(|target| {
        let (folder, missing) = (target.platform.folder, target.missing(&platforms.tools));
        (!missing.is_empty()).then(|| format!("{folder} needs {}", missing.join("; ")))
    });
    lines.collect()
}

fn build(
    workspace: &Workspace,
    platforms: &Platforms,
    folder: PathBuf,
    without_experiments: bool,
) -> Result<Dist> {
    let packages = match without_experiments {
        true => &PACKAGES[..2],
        false => &PACKAGES[..],
    };
    // Built under another name, so that the folder is never seen incomplete.
    let new = folder.with_extension("new");
    if new.exists() {
        fs::remove_dir_all(&new)?;
    }
    fs::create_dir_all(&new).with_context(|| new.display().to_string())?;
    let fmus = pack::suite_with(workspace, &profile(FMU_PROFILE), platforms, &new)?;
    if !without_experiments {
        let page = new.join("machine.html");
        web::make(workspace, &fmi3_files(&fmus)?, FMU_PROFILE, &page)?;
        let engine = web::engine(workspace, FMU_PROFILE);
        fs::copy(&engine, new.join(web::ENGINE)).with_context(|| engine.display().to_string())?;
    }
    let mut dist = Dist {
        folder,
        targets: platforms.targets.clone(),
        suite: fmus.iter().map(|fmu| file_name(fmu)).collect(),
        programs: BTreeMap::new(),
    };
    for target in &platforms.targets {
        let packages = match target.platform.folder {
            // The master needs headers of a C library, which macOS has only in its SDK.
            _ if target.is_macos() => &[],
            // The other programs need FMUs of FMI 2.0.
            "aarch64-linux" => &packages[..1],
            _ => packages,
        };
        if !packages.is_empty() {
            let mut command = target.build(&workspace.cargo, &platforms.tools)?;
            command.args(packages.iter().flat_map(|name| ["--package", name]));
            dist.build_programs(workspace, target, command, &new)?;
        }
    }
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
        let to = new.join(licence);
        fs::copy(workspace.root.join(licence), to).with_context(|| licence.to_string())?;
    }
    notices(
        &workspace.cargo,
        &dist.targets,
        packages,
        &new.join("THIRD-PARTY"),
    )?;
    for target in &platforms.targets {
        if !without_experiments && target.platform.folder == wheel::HANDED_OUT_FOR {
            let own = cosim_wasm::workspace(workspace)?;
            let mut command = target.build(&own, &platforms.tools)?;
            command.arg("--locked");
            dist.build_programs(workspace, target, command, &new)?;
            let (folder, package) = (&new.join("THIRD-PARTY"), [cosim_wasm::PROGRAM]);
            notices(&own, &[target], &package, folder)?;
            wheel::build(workspace, &new, Some(target), &new.join("python"))?;
        }
    }
    let readme = README.replace("{commit}", &commit(workspace)?);
    let readme = readme.replace("{version}", env!("CARGO_PKG_VERSION"));
    fs::write(new.join("README.md"), readme)?;
    fs::write(new.join(CHECKSUMS), checksums(&new)?)?;
    clear(&dist.folder)?;
    fs::rename(&new, &dist.folder)?;
    Ok(dist)
}

/// Writes the notices of the programs' third-party crates; FMUs hold their own in
/// `documentation/licenses/`.
fn notices(
    workspace: &cargo_fmu::workspace::Workspace,
    targets: &[&Target],
    packages: &[&str],
    folder: &Path,
) -> Result<()> {
    fs::create_dir_all(folder)?;
    let notices = Notices::new(workspace)?;
    let triples: Vec<_> = targets.iter().map(|target| target.triple).collect();
    for (package, program) in PROGRAMS {
        if packages.contains(&package) {
            for (name, bytes) in notices.files(workspace, package, &triples)? {
                let name = name.replace("third-party", program);
                fs::write(folder.join(name), bytes)?;
            }
        }
    }
    Ok(())
}

/// Removes a folder that is empty or holds an older result, and refuses any other.
fn clear(folder: &Path) -> Result<()> {
    if folder.exists() && fs::read_dir(folder)?.next().is_some() {
        ensure!(
            folder.join(CHECKSUMS).is_file(),
            "{} holds other files; it must be empty, new, or hold an older result",
            folder.display()
        );
    }
    match folder.exists() {
        true => fs::remove_dir_all(folder).with_context(|| folder.display().to_string()),
        false => Ok(()),
    }
}

impl Dist {
    fn build_programs(
        &mut self,
        workspace: &Workspace,
        target: &Target,
        mut command: Command,
        new: &Path,
    ) -> Result<()> {
        command.args(["--bins", "--profile", "release"]);
        command.args(PROGRAM_PROFILE.iter().flat_map(|c| ["--config", c]));
        let folder = target.platform.folder;
        for built in artifacts(&mut command)? {
            let name = built.name().to_string();
            let Some(mut path) = built.executable else {
                continue;
            };
            if PROGRAMS.iter().any(|(_, program)| *program == name) {
                let bytes = fs::read(&path).with_context(|| path.display().to_string())?;
                let faults = target.faults(&bytes, &workspace.cargo)?;
                let shown = path.display();
                ensure!(faults.is_empty(), "{shown}: it {}", faults.join("; it "));
                let inside = Path::new(folder).join(path.file_name().unwrap_or_default());
                fs::create_dir_all(new.join(folder))?;
                fs::copy(&path, new.join(&inside))?;
                path = self.folder.join(inside);
            }
            self.programs.insert((folder, name), path);
        }
        Ok(())
    }
}

/// Lines of `sha256sum`, in the order of the names.
fn checksums(folder: &Path) -> Result<String> {
    let mut text = String::new();
    for path in files(folder)? {
        let name = path
            .strip_prefix(folder)?
            .to_string_lossy()
            .replace('\\', "/");
        if name != CHECKSUMS {
            let hash = Sha256::digest(fs::read(&path)?);
            let hash: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
            text += &format!("{hash}  {name}\n");
        }
    }
    Ok(text)
}

/// The commit that is built, `-dirty` where files differ from it.
fn commit(workspace: &Workspace) -> Result<String> {
    let mut git = workspace.command("git");
    let commit = output(git.args(["describe", "--always", "--dirty", "--abbrev=40"]));
    let commit = commit.context("the commit that the README names")?;
    Ok(commit.trim().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_older_result_is_replaced_and_its_files_are_summed() {
        let folder = std::env::temp_dir().join(format!("xtask-dist-{}", std::process::id()));
        fs::create_dir_all(folder.join("win64")).unwrap();
        fs::write(folder.join("win64/x.exe"), "abc").unwrap();
        let refused = clear(&folder).unwrap_err().to_string();
        assert!(refused.contains("holds other files"), "{refused}");
        // The digest of `abc` in FIPS 180-4.
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let expected = format!("{sum}  win64/x.exe\n");
        assert_eq!(checksums(&folder).unwrap(), expected);
        fs::write(folder.join(CHECKSUMS), &expected).unwrap();
        assert_eq!(checksums(&folder).unwrap(), expected, "not of itself");
        clear(&folder).unwrap();
        assert!(!folder.exists());
        clear(&folder).unwrap();
    }
}
