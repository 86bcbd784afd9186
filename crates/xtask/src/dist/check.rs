//! Runs of what was built: on this machine, in an old Debian and under Wine. The same inputs must
//! give the same numbers everywhere.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use cargo_fmu::process::{execute, output};
use cargo_fmu::target::Tools;

use super::folder::{self, Dist};
use super::listing::Listing;
use super::numbers;
use super::userland::Userland;
use super::wine::Wine;
use crate::workspace::Workspace;

/// Random calls under Wine.
const CALLS: &str = "100000";
/// The system of the table of experiments.
const MANIPULATOR: &str = "Manipulator.ssp";
const LINUX: &str = "linux64";
const WINDOWS: &str = "win64";
const ARM: &str = "aarch64-linux";
/// Debian's package `libc6-arm64-cross`: the C library of that platform.
const ARM_SYSTEM: &str = "/usr/aarch64-linux-gnu";
/// Numbers of ARM may differ from those of x86-64 by this part of the largest value of their
/// signal: vector instructions of other widths add the products of the surrogate network in another
/// order.
const ARM_TOLERANCE: f64 = 1e-9;

/// Install what the runs for [`super::CI_PLATFORMS`] need. What cannot be had here is listed when
/// it is missing.
pub fn prepare(workspace: &Workspace) -> Result<()> {
    let folder = folder(workspace)?;
    if let Err(why) = Userland::provide(&folder) {
        println!("no old Debian: {why:#}");
    }
    Wine::find(&folder).map_or(Ok(()), |wine| wine.prepare())
}

fn folder(workspace: &Workspace) -> Result<PathBuf> {
    let folder = workspace.target.join("dist-check");
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    Ok(folder)
}

/// Run what can be run here; what cannot is listed.
pub fn run(workspace: &Workspace, dist: &Dist, listing: &mut Listing) -> Result<()> {
    let folder = folder(workspace)?;
    let runs = Runs {
        dist,
        folder,
        systems: dist.systems()?,
        fmus: dist.fmus()?,
    };
    for target in &dist.targets {
        match target.platform.folder {
            LINUX => {
                runs.linux(listing)?;
                runs.promises(workspace, listing)?;
            }
            WINDOWS => runs.windows(listing)?,
            ARM => runs.arm(listing)?,
            other => listing.not_run(other, "there is no machine of this kind here"),
        }
    }
    Ok(())
}

struct Runs<'a> {
    dist: &'a Dist,
    folder: PathBuf,
    systems: Vec<PathBuf>,
    fmus: Vec<PathBuf>,
}

impl Runs<'_> {
    fn linux(&self, listing: &mut Listing) -> Result<()> {
        for system in &self.systems {
            let lines = self.cosim(self.native("cosim")?, system, LINUX)?;
            let text = format!("{} in `cosim` on this machine: {lines} lines", name(system));
            listing.run(LINUX, &text);
        }
        let userland = match Userland::provide(&self.folder) {
            Ok(userland) => userland,
            Err(why) => {
                listing.lacks(LINUX, &format!("in an old Debian: {why:#}"));
                return Ok(());
            }
        };
        userland.copy(&self.dist.folder)?;
        for system in &self.systems {
            let csv = self.csv(system, "debian");
            let inside = Path::new("/dist").join(name(system));
            let mut cosim = userland.command("/dist/linux64/cosim");
            execute(cosim.args(arguments(&inside, Path::new("/tmp/run.csv"))))?;
            fs::copy(userland.file("tmp/run.csv"), &csv)?;
            let numbers = self.equal(system, "debian")?;
            let text = format!(
                "{} in {}: {numbers} numbers equal in every digit",
                name(system),
                userland.name
            );
            listing.run(LINUX, &text);
        }
        Ok(())
    }

    /// What importers rely on, with the library for Linux.
    fn promises(&self, workspace: &Workspace, listing: &mut Listing) -> Result<()> {
        let program = workspace.build_programs(&["cargo-fmu"])?;
        let mut check = Command::new(program);
        execute(check.args(["fmu", "check", "--strict"]).args(&self.fmus))?;
        let count = self.fmus.len();
        let text = format!("`cargo fmu check --strict` of {count} FMUs: no failure, no remark");
        listing.run(LINUX, &text);
        Ok(())
    }

    fn windows(&self, listing: &mut Listing) -> Result<()> {
        let Some(wine) = Wine::find(&self.folder) else {
            listing.lacks(WINDOWS, "there is no Wine: `apt-get install wine64`");
            return Ok(());
        };
        wine.prepare()?;
        let program = |name: &str| Ok(wine.command(self.program(WINDOWS, name)?));
        for system in &self.systems {
            let lines = self.cosim(program("cosim")?, system, WINDOWS)?;
            let text = format!("{} in `cosim.exe` under Wine: {lines} lines", name(system));
            listing.run(WINDOWS, &text);
        }
        let mut calls = program("torture")?;
        calls.args(["calls", "--calls", CALLS]).args(&self.fmus);
        execute(&mut calls)?;
        listing.run(
            WINDOWS,
            &format!("{CALLS} random calls under Wine: all as the standard says"),
        );
        match self.has(LINUX, "cosim") {
            true => self.compare(program, listing)?,
            false => listing.not_run(WINDOWS, "comparison with Linux, which was not built"),
        }
        Ok(())
    }

    /// FMUs of FMI 3.0 on ARM, whose instructions QEMU carries out.
    fn arm(&self, listing: &mut Listing) -> Result<()> {
        let qemu = Tools::default().find("qemu-aarch64");
        let (Some(qemu), true) = (qemu, Path::new(ARM_SYSTEM).is_dir()) else {
            let why =
                "there is no QEMU with a system: `apt-get install qemu-user libc6-arm64-cross`";
            listing.lacks(ARM, why);
            return Ok(());
        };
        let system = &self.dist.folder.join(MANIPULATOR);
        let csv = self.csv(system, ARM);
        let mut cosim = Command::new(qemu);
        cosim.args(["-L", ARM_SYSTEM]);
        cosim.arg(self.program(ARM, "cosim")?);
        cosim.args(arguments(system, &csv));
        cosim
            .args(["--fmi", "3", "--fmu-dir"])
            .arg(&self.dist.folder);
        execute(&mut cosim)?;
        let there = read(&csv)?;
        let lines = there.lines().count();
        let text = format!("{MANIPULATOR} by FMI 3.0 in `cosim` under QEMU: {lines} lines");
        listing.run(ARM, &text);
        if self.has(LINUX, "cosim") {
            let here = read(&self.csv(system, LINUX))?;
            let (numbers, worst) = numbers::close(&here, &there, ARM_TOLERANCE)
                .with_context(|| format!("{LINUX} by FMI 2.0 and {ARM} by FMI 3.0"))?;
            let text = format!(
                "{numbers} numbers of that run differ from those on {LINUX} by FMI 2.0 by at most {worst:.0e} of the signal's largest value"
            );
            listing.run(ARM, &text);
        }
        Ok(())
    }

    /// Linux and Windows: numbers of the runs, the table of experiments, and states that one saves
    /// and the other continues.
    fn compare(&self, wine: impl Fn(&str) -> Result<Command>, listing: &mut Listing) -> Result<()> {
        for system in &self.systems {
            let numbers = self.equal(system, WINDOWS)?;
            let text = format!(
                "{}: {numbers} numbers equal those on Linux in every digit",
                name(system)
            );
            listing.run(WINDOWS, &text);
        }
        match self.has(LINUX, "hdrm-fmu") {
            true => self.table(wine("hdrm-fmu")?, listing)?,
            false => listing.not_run(WINDOWS, "`hdrm-fmu.exe table`: it was left out"),
        }
        let torture = |platform| match platform {
            LINUX => self.native("torture"),
            _ => wine("torture"),
        };
        for (from, to) in [(LINUX, WINDOWS), (WINDOWS, LINUX)] {
            let place = self.folder.join(format!("states-{from}"));
            fs::create_dir_all(&place)?;
            let mut save = torture(from)?;
            execute(save.arg("save").arg("--to").arg(&place).args(&self.fmus))?;
            let mut continued = torture(to)?;
            continued.arg("continue").arg("--from").arg(&place);
            execute(continued.args(&self.fmus))?;
            let count = self.fmus.len();
            let text = format!("states of {count} FMUs saved by {from} continue bit for bit");
            listing.run(to, &text);
        }
        Ok(())
    }

    /// The table of experiments.
    fn table(&self, there: Command, listing: &mut Listing) -> Result<()> {
        let table = |mut command: Command| {
            let system = self.dist.folder.join(MANIPULATOR);
            output(command.args(["table", "--system"]).arg(system))
        };
        let rows = table(self.native("hdrm-fmu")?)?;
        let count = rows.lines().count();
        ensure!(
            rows == table(there)? && count > 10,
            "`hdrm-fmu.exe table` differs from that on Linux:\n{rows}"
        );
        let text = format!("`hdrm-fmu.exe table` prints the {count} lines of Linux");
        listing.run(WINDOWS, &text);
        Ok(())
    }

    fn has(&self, platform: &'static str, name: &str) -> bool {
        let key = (platform, name.to_string());
        self.dist.programs.contains_key(&key)
    }

    fn program(&self, platform: &'static str, name: &str) -> Result<&Path> {
        let found = self.dist.programs.get(&(platform, name.to_string()));
        let path = found.with_context(|| format!("`{name}` was not built for {platform}"))?;
        Ok(path)
    }

    fn native(&self, name: &str) -> Result<Command> {
        Ok(Command::new(self.program(LINUX, name)?))
    }

    /// A system over its default experiment, with all outputs; the lines of the table that it
    /// writes.
    fn cosim(&self, mut cosim: Command, system: &Path, place: &str) -> Result<usize> {
        let csv = self.csv(system, place);
        execute(cosim.args(arguments(system, &csv)))?;
        Ok(read(&csv)?.lines().count())
    }

    /// Where that table lies.
    fn csv(&self, system: &Path, place: &str) -> PathBuf {
        let name = name(system);
        self.folder.join(format!("{name}.{place}.csv"))
    }

    /// Numbers of that table, which must be those of the run on this machine.
    fn equal(&self, system: &Path, place: &str) -> Result<usize> {
        let [here, there] = [LINUX, place].map(|place| read(&self.csv(system, place)));
        numbers::same(&here?, &there?)
            .with_context(|| format!("{}: {LINUX} and {place}", name(system)))
    }
}

fn read(path: &Path) -> Result<String> {
    fs::read_to_string(path).with_context(|| path.display().to_string())
}

fn name(path: &Path) -> String {
    folder::file_name(path)
}

fn arguments(system: &Path, csv: &Path) -> Vec<PathBuf> {
    let words = ["run", "--quiet", "--signals", "*", "--system"].map(PathBuf::from);
    let mut words = Vec::from(words);
    words.extend([system.to_path_buf(), "--csv".into(), csv.to_path_buf()]);
    // Without its gains that machine swings, which is the hardest of these comparisons.
    if name(system) == "Real.ssp" {
        words.extend(["--variant", "bare.ssd"].map(PathBuf::from));
    }
    words
}
