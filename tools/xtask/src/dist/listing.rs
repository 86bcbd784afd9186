//! The listing that `cargo xtask dist` and `test` print: for each platform, what was built, what
//! was run, and what was not and why.

use std::collections::BTreeMap;
use std::path::Path;
use std::{fmt, fs};

use anyhow::{Context, Result, bail, ensure};
use cargo_fmu::pack::FMI3_FOLDER;
use fmi_description::entries::{self, Entries};
use fmi_import::platform::Platform;
use fmi_import::portability::Needs;

use super::folder::Dist;
use crate::workspace::file_name;

#[derive(Default)]
pub struct Listing {
    /// By platform folder.
    lines: BTreeMap<String, Vec<String>>,
    lacking: Vec<String>,
}

impl Listing {
    /// Adds runs, a line each: platform, kind and text, separated by tabs. The kind is `run`, `not
    /// run`, or `lacks` if this machine should have made the run and could not.
    pub fn add_runs(&mut self, lines: &str) -> Result<()> {
        for line in lines.lines() {
            let mut parts = line.splitn(3, '\t');
            match [parts.next(), parts.next(), parts.next()] {
                [Some(platform), Some("lacks"), Some(why)] => {
                    self.add(platform, "not run", why);
                    self.lacking.push(format!("{platform}: {why}"));
                }
                [Some(platform), Some(kind @ ("run" | "not run")), Some(text)] => {
                    self.add(platform, kind, text);
                }
                _ => bail!("`{line}` must be platform, kind and text"),
            }
        }
        Ok(())
    }

    /// What this machine lacked; empty where every run was made.
    pub fn lacking(&self) -> String {
        self.lacking.join("; ")
    }

    /// Adds a line; the kind is one such as `not built`.
    pub fn add(&mut self, platform: &str, kind: &str, text: &str) {
        let lines = self.lines.entry(platform.to_string()).or_default();
        lines.push(format!("{kind:<10} {text}"));
    }

    /// Adds every library and program in the folder, with what its headers say it needs.
    pub fn built(&mut self, dist: &Dist) -> Result<()> {
        for fmu in dist.fmus_3()? {
            let entries = entries::read(&fmu)?;
            for target in &dist.targets {
                let Platform {
                    folder, folder_3, ..
                } = target.platform;
                let library = library(&entries, folder_3, &fmu)?;
                self.binary(folder, &file_name(&fmu), library)?;
                let needs = Needs::read(library)?;
                ensure!(
                    needs.mathematics().is_empty(),
                    "the library for {folder} in {} takes {} from the platform, so its numbers would differ between platforms; models \
                     must call these functions of the crate `libm`",
                    fmu.display(),
                    needs.mathematics().join(", ")
                );
            }
        }
        for fmu in dist.fmus()? {
            let other = dist.folder.join(FMI3_FOLDER).join(file_name(&fmu));
            let (entries, entries_3) = (entries::read(&fmu)?, entries::read(&other)?);
            for platform in dist.targets.iter().map(|target| target.platform) {
                if platform.is_in_fmi2() {
                    let [a, b] = [
                        library(&entries, platform.folder, &fmu)?,
                        library(&entries_3, platform.folder_3, &other)?,
                    ];
                    ensure!(
                        a == b,
                        "{}: not the library of FMI 3.0's archive",
                        fmu.display()
                    );
                }
            }
        }
        for ((folder, _), path) in &dist.programs {
            if path.starts_with(&dist.folder) {
                self.binary(folder, &file_name(path), &fs::read(path)?)?;
            }
        }
        for ssp in dist.systems()? {
            let size = fs::metadata(&ssp)?.len() / 1000;
            let text = format!("{:<16} {size:>6} kB", file_name(&ssp));
            self.add("all", "built", &text);
        }
        Ok(())
    }

    fn binary(&mut self, platform: &str, name: &str, bytes: &[u8]) -> Result<()> {
        let needs = Needs::read(bytes)?;
        let glibc = needs.glibc().map(|version| format!("GLIBC_{version}, "));
        let libraries: Vec<_> = needs.libraries.iter().map(String::as_str).collect();
        let text = format!(
            "{name:<16} {:>6} kB, needs {}{}",
            bytes.len() / 1000,
            glibc.unwrap_or_default(),
            libraries.join(" ")
        );
        self.add(platform, "built", &text);
        Ok(())
    }
}

/// The library in a folder of an FMU.
fn library<'a>(entries: &'a Entries, folder: &str, fmu: &Path) -> Result<&'a [u8]> {
    let inside = format!("binaries/{folder}/");
    let library = entries.iter().find(|(name, _)| name.starts_with(&inside));
    let library = library.with_context(|| format!("{inside} in {}", fmu.display()))?;
    Ok(library.1)
}

impl fmt::Display for Listing {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (platform, lines) in &self.lines {
            writeln!(f, "{platform}")?;
            for line in lines {
                writeln!(f, "  {line}")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Listing;

    #[test]
    fn a_run_that_was_left_out_is_told_from_one_that_could_not_be_made() {
        let mut listing = Listing::default();
        let lines = "linux64\trun\ta system\nlinux64\tnot run\tit was left out\n";
        listing.add_runs(lines).unwrap();
        assert_eq!(listing.lacking(), "");
        listing
            .add_runs("win64\tlacks\tthere is no Wine\n")
            .unwrap();
        assert!(listing.add_runs("win64\tran\tx\n").is_err());
        assert_eq!(listing.lacking(), "win64: there is no Wine");
        let text = "linux64\n  run        a system\n  not run    it was left out\nwin64\n  not run    there is no Wine\n";
        assert_eq!(listing.to_string(), text);
    }
}
