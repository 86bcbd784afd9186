//! Runs of what was built: on this machine, in an old Debian and under Wine. The same inputs must give the same numbers everywhere.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use cargo_fmu::process::{execute, output};

use super::listing::Listing;
use super::userland::Userland;
use super::wine::Wine;
use super::{Dist, exact};
use crate::workspace::Workspace;

/// Random calls under Wine.
const CALLS: &str = "100000";
/// The system that is run: five FMUs over the cubic trajectory.
const SYSTEM: &str = "Manipulator.ssp";
const LINUX: &str = "linux64";
const WINDOWS: &str = "win64";

/// Run what can be run here; what cannot is listed.
pub fn run(workspace: &Workspace, dist: &Dist, listing: &mut Listing) -> Result<()> {
    let folder = workspace.target.join("dist-check");
    fs::create_dir_all(&folder)?;
    let runs = Runs { dist, folder };
    for target in &dist.targets {
        match target.platform.folder {
            LINUX => runs.linux(listing)?,
            WINDOWS => runs.windows(listing)?,
            other => listing.not_run(other, "there is no machine of this kind here"),
        }
    }
    Ok(())
}

struct Runs<'a> {
    dist: &'a Dist,
    folder: PathBuf,
}

impl Runs<'_> {
    fn linux(&self, listing: &mut Listing) -> Result<()> {
        let here = self.cubic(self.native(LINUX, "cosim")?, "linux64")?;
        listing.run(
            LINUX,
            &format!(
                "five FMUs in `cosim` on this machine: {} lines",
                here.lines().count()
            ),
        );
        let userland = match Userland::provide(&self.folder) {
            Ok(userland) => userland,
            Err(why) => {
                listing.not_run(LINUX, &format!("in an old Debian: {why:#}"));
                return Ok(());
            }
        };
        let mut command = userland.command(&self.dist.folder, "linux64/cosim")?;
        let (system, csv) = (format!("/dist/{SYSTEM}"), "/tmp/linux64.csv");
        execute(command.args(arguments(Path::new(&system), Path::new(csv))))?;
        let there = fs::read_to_string(userland.file(csv))?;
        let numbers = exact::same(&here, &there).with_context(|| userland.name.clone())?;
        listing.run(
            LINUX,
            &format!(
                "the same in {}: {numbers} numbers equal in every digit",
                userland.name
            ),
        );
        Ok(())
    }

    fn windows(&self, listing: &mut Listing) -> Result<()> {
        let Some(wine) = Wine::find(&self.folder) else {
            listing.not_run(WINDOWS, "there is no Wine: `apt-get install wine64`");
            return Ok(());
        };
        wine.prepare()?;
        let program =
            |name: &str| Ok::<_, anyhow::Error>(wine.command(self.program(WINDOWS, name)?));
        let there = self.cubic(program("cosim")?, "win64")?;
        listing.run(
            WINDOWS,
            &format!(
                "five FMUs in `cosim.exe` under Wine: {} lines",
                there.lines().count()
            ),
        );
        let mut calls = program("torture")?;
        calls
            .args(["calls", "--calls", CALLS])
            .args(self.dist.archives("fmu")?);
        execute(&mut calls)?;
        listing.run(
            WINDOWS,
            &format!("{CALLS} random calls under Wine: all as the standard says"),
        );
        if self
            .dist
            .programs
            .contains_key(&(LINUX, "cosim".to_string()))
        {
            self.compare(program, &there, listing)?;
        } else {
            listing.not_run(WINDOWS, "comparison with Linux, which was not built");
        }
        Ok(())
    }

    /// Linux and Windows: numbers of a run, the table of experiments, and states that one saves and the other continues.
    fn compare(
        &self,
        wine: impl Fn(&str) -> Result<Command>,
        there: &str,
        listing: &mut Listing,
    ) -> Result<()> {
        let here = fs::read_to_string(self.folder.join("linux64.csv"))?;
        let numbers = exact::same(&here, there).context("under Wine and on Linux")?;
        listing.run(
            WINDOWS,
            &format!("{numbers} numbers of that run equal those on Linux in every digit"),
        );
        match self
            .dist
            .programs
            .contains_key(&(LINUX, "hdrm-fmu".to_string()))
        {
            true => self.table(&wine, listing)?,
            false => listing.not_run(WINDOWS, "`hdrm-fmu.exe table`: it was left out"),
        }
        let torture = |platform| match platform {
            LINUX => self.native(LINUX, "torture"),
            _ => wine("torture"),
        };
        for (from, to) in [(LINUX, WINDOWS), (WINDOWS, LINUX)] {
            let place = self.folder.join(format!("states-{from}"));
            fs::create_dir_all(&place)?;
            let fmus = self.dist.archives("fmu")?;
            execute(
                torture(from)?
                    .arg("save")
                    .arg("--to")
                    .arg(&place)
                    .args(&fmus),
            )?;
            execute(
                torture(to)?
                    .arg("continue")
                    .arg("--from")
                    .arg(&place)
                    .args(&fmus),
            )?;
            listing.run(
                to,
                &format!(
                    "states of {} FMUs saved by {from} continue bit for bit",
                    fmus.len()
                ),
            );
        }
        Ok(())
    }

    /// The table of experiments.
    fn table(&self, wine: impl Fn(&str) -> Result<Command>, listing: &mut Listing) -> Result<()> {
        let table = |mut command: Command| {
            let system = self.dist.folder.join(SYSTEM);
            let text = output(command.args(["table", "--system"]).arg(system))?;
            // All but what it says about the time that it took.
            let rows = text.lines().filter(|line| line.contains('|'));
            Ok::<_, anyhow::Error>(rows.collect::<Vec<_>>().join("\n"))
        };
        let rows = table(self.native(LINUX, "hdrm-fmu")?)?;
        let equal = rows == table(wine("hdrm-fmu")?)?;
        anyhow::ensure!(
            equal && rows.lines().count() > 10,
            "`hdrm-fmu.exe table` differs from that on Linux:\n{rows}"
        );
        listing.run(
            WINDOWS,
            &format!(
                "`hdrm-fmu.exe table` prints the {} lines of Linux",
                rows.lines().count()
            ),
        );
        Ok(())
    }

    fn program(&self, platform: &'static str, name: &str) -> Result<&Path> {
        let found = self.dist.programs.get(&(platform, name.to_string()));
        let path = found.with_context(|| format!("`{name}` was not built for {platform}"))?;
        Ok(path)
    }

    fn native(&self, platform: &'static str, name: &str) -> Result<Command> {
        Ok(Command::new(self.program(platform, name)?))
    }

    /// The cubic trajectory with all outputs: its CSV.
    fn cubic(&self, mut cosim: Command, name: &str) -> Result<String> {
        let csv = self.folder.join(name).with_extension("csv");
        execute(cosim.args(arguments(&self.dist.folder.join(SYSTEM), &csv)))?;
        fs::read_to_string(&csv).with_context(|| csv.display().to_string())
    }
}

fn arguments(system: &Path, csv: &Path) -> Vec<PathBuf> {
    let words = ["run", "--system", "", "--csv", "", "--signals", "*"].map(PathBuf::from);
    let mut words = Vec::from(words);
    words[2] = system.to_path_buf();
    words[4] = csv.to_path_buf();
    words
}
