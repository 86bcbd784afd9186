//! Robustness: random calls, sanitizers, valgrind, threads, fuzzing and long runs on the FMUs.
//!
//! Without options it does what CI does. The nightly compiler, valgrind and cargo-fuzz are only needed by the options that say so.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::workspace::{Workspace, execute, output};
use crate::{libclang, pack, sanitize};

/// Options of `cargo xtask torture`.
#[derive(Args)]
pub struct Options {
    /// Random calls in total, on all three FMUs
    #[arg(long, value_name = "NUMBER")]
    calls: Option<usize>,
    /// Seed of the first batch of random calls
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Repeat one batch of random calls, printing every call before it is made
    #[arg(long, value_name = "SEED")]
    replay: Option<u64>,
    /// Steps of each FMU alone and of all together in long runs; 10000000 are 2.8 h of machine time
    #[arg(long, value_name = "STEPS")]
    long: Option<u64>,
    /// AddressSanitizer and LeakSanitizer on the export layer's tests, on random calls, on lives of instances, on instances in threads
    /// and on a coupled run (rustup toolchain install nightly)
    #[arg(long)]
    asan: bool,
    /// Memcheck on loads, instances and unloads (apt-get install valgrind)
    #[arg(long)]
    valgrind: bool,
    /// Helgrind on instances in parallel threads (apt-get install valgrind)
    #[arg(long)]
    threads: bool,
    /// Coverage-guided fuzzing, this many seconds for each target (nightly as above; cargo install cargo-fuzz)
    #[arg(long, value_name = "SECONDS")]
    fuzz: Option<u64>,
}

/// Calls in CI: about a minute on two cores.
const CI_CALLS: usize = 1_000_000;
/// Steps of each FMU in CI.
const CI_STEPS: u64 = 100_000;
/// Steps of all five instances together in CI.
const CI_COUPLED_STEPS: u64 = 100_000;
/// Calls under AddressSanitizer.
const ASAN_CALLS: usize = 100_000;

/// Do what the options say.
pub fn run(workspace: &Workspace, options: &Options) -> Result<()> {
    let Options {
        calls,
        seed,
        replay,
        long,
        asan,
        valgrind,
        threads,
        fuzz,
    } = *options;
    if let Some(seconds) = fuzz {
        self::fuzz(workspace, seconds)?;
    }
    if asan {
        sanitize::run(workspace, calls.unwrap_or(ASAN_CALLS), seed)?;
    }
    let is_plain =
        !(asan || valgrind || threads) && fuzz.or(replay).or(long).or(calls.map(|_| 0)).is_none();
    let needs_fmus =
        is_plain || valgrind || threads || replay.or(long).is_some() || (calls.is_some() && !asan);
    if !needs_fmus {
        return Ok(());
    }
    pack::suite(workspace, &workspace.fmu_dir())?;
    if is_plain {
        return check(workspace);
    }
    let driver = Driver::build(workspace)?;
    if let Some(seed) = replay {
        driver.run(&["calls", "--replay", &seed.to_string()])?;
    }
    if let Some(calls) = calls.filter(|_| !asan) {
        driver.run(&[
            "calls",
            "--calls",
            &calls.to_string(),
            "--seed",
            &seed.to_string(),
        ])?;
    }
    if let Some(steps) = long {
        driver.run(&["long", "--steps", &steps.to_string()])?;
        let environment = libclang::provide(workspace)?;
        let cosim = workspace.build_program("cosim", "cosim", &environment)?;
        execute(
            workspace
                .command(cosim)
                .args(["endurance", "--steps", &steps.to_string()]),
        )?;
        println!("long runs: {steps} steps of each FMU alone and of all five instances together");
    }
    if valgrind {
        driver.under(MEMCHECK, &["life", "--instances", "1000", "--loads", "5"])?;
        println!(
            "memcheck: 3 x 1000 instances over 5 loads and unloads of each FMU: 0 errors, 0 bytes definitely lost"
        );
    }
    if threads {
        driver.run(&["threads", "--threads", "8", "--steps", "2000"])?;
        driver.under(
            HELGRIND,
            &["threads", "--warm", "--threads", "4", "--steps", "200"],
        )?;
        println!(
            "threads: 24 in parallel with 2000 steps each, then 12 with 200 steps each under helgrind: 0 errors"
        );
    }
    Ok(())
}

/// What CI does, on the FMUs as they are packed.
pub fn check(workspace: &Workspace) -> Result<()> {
    let driver = Driver::build(workspace)?;
    driver.run(&["calls", "--calls", &CI_CALLS.to_string()])?;
    driver.run(&["threads"])?;
    driver.run(&["long", "--steps", &CI_STEPS.to_string()])?;
    let mut coupled = workspace.command(libclang::build_cosim(workspace)?);
    coupled.args(["endurance", "--steps", &CI_COUPLED_STEPS.to_string()]);
    execute(&mut coupled)
}

const MEMCHECK: &[&str] = &[
    "--error-exitcode=99",
    "--leak-check=full",
    "--show-leak-kinds=definite",
    "--errors-for-leak-kinds=definite",
    "--keep-debuginfo=yes",
];
const HELGRIND: &[&str] = &[
    "--tool=helgrind",
    "--error-exitcode=99",
    "--keep-debuginfo=yes",
    "--suppressions=crates/torture/helgrind.supp",
];

/// The program that mistreats FMUs, and the FMUs.
struct Driver<'a> {
    workspace: &'a Workspace,
    program: PathBuf,
    fmus: Vec<PathBuf>,
}

impl<'a> Driver<'a> {
    /// Built here, for the packed FMUs.
    fn build(workspace: &'a Workspace) -> Result<Self> {
        let fmus = ["Emla", "Hdrm", "Controller"];
        Ok(Self {
            workspace,
            program: workspace.build_program("torture", "torture", &[])?,
            fmus: fmus
                .map(|name| workspace.fmu_dir().join(name).with_extension("fmu"))
                .into(),
        })
    }

    fn run(&self, arguments: &[&str]) -> Result<()> {
        let mut command = self.workspace.command(&self.program);
        execute(command.args(arguments).args(&self.fmus))
    }

    /// Under a tool of valgrind, which fails on any error it finds.
    fn under(&self, tool: &[&str], arguments: &[&str]) -> Result<()> {
        let mut command = self.workspace.command("valgrind");
        command.args(tool).arg(&self.program).args(arguments);
        execute(command.args(&self.fmus))
            .context("valgrind; install it with `apt-get install valgrind`")
    }
}

/// The nightly compiler's cargo.
pub fn nightly(workspace: &Workspace) -> Command {
    let mut command = workspace.command("rustup");
    command.args(["run", "nightly", "cargo"]);
    command.env_remove("CARGO").env_remove("RUSTUP_TOOLCHAIN");
    command
}

/// Each fuzz target for some time, from the committed corpus on; what it finds beyond goes to the target directory.
fn fuzz(workspace: &Workspace, seconds: u64) -> Result<()> {
    let folder = workspace.root.join("fuzz");
    let list = output(
        nightly(workspace)
            .args(["fuzz", "list", "--fuzz-dir"])
            .arg(&folder),
    )
    .context("cargo-fuzz; install it with `cargo install cargo-fuzz`")?;
    let mut total = 0;
    for target in list.lines() {
        let inputs = fuzz_target(workspace, &folder, target, seconds)?;
        println!("{target}: {inputs} inputs in {seconds} s, no complaint");
        total += inputs;
    }
    println!(
        "fuzzing: {} targets, {total} inputs: 0 crashes, 0 hangs",
        list.lines().count()
    );
    Ok(())
}

/// Fuzz one target; the number of inputs it was given.
fn fuzz_target(workspace: &Workspace, folder: &Path, target: &str, seconds: u64) -> Result<u64> {
    let found = workspace.target.join("fuzz-corpus").join(target);
    std::fs::create_dir_all(&found)?;
    let mut command = nightly(workspace);
    command
        .args(["fuzz", "run", "--fuzz-dir"])
        .arg(folder)
        .arg(target)
        .arg(&found)
        .arg(seeds(folder, target))
        .env("CARGO_TARGET_DIR", workspace.target.join("fuzz"))
        .arg("--")
        .arg(format!("-max_total_time={seconds}"))
        .args(["-timeout=20", "-print_final_stats=1", "-print_funcs=0"]);
    let done = command.output().context("cargo-fuzz")?;
    let log = String::from_utf8_lossy(&done.stderr);
    if !done.status.success() {
        bail!("fuzz target {target}, {}:\n{log}", done.status);
    }
    let count = log
        .lines()
        .find_map(|l| l.strip_prefix("stat::number_of_executed_units:"));
    let count = count.context("libFuzzer printed no statistics")?;
    Ok(count.trim().parse()?)
}

fn seeds(folder: &Path, target: &str) -> PathBuf {
    folder.join("seeds").join(target)
}
