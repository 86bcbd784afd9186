//! Robustness: random calls, sanitizers, valgrind, threads, fuzzing and long runs on the FMUs.
//!
//! Without options it does what CI does. The nightly compiler, valgrind and cargo-fuzz are only
//! needed by the options that say so.

use std::path::PathBuf;

use anyhow::{Context, Result};
use cargo_fmu::process::execute;
use clap::Args;

use crate::workspace::Workspace;
use crate::{fuzz, pack, sanitize};

/// Options of `cargo xtask torture`.
#[derive(Args)]
pub struct Options {
    /// Random calls in total, on all FMUs of both versions of FMI but the slow one
    #[arg(long, value_name = "NUMBER")]
    calls: Option<usize>,
    /// Seed of the first batch of random calls
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Repeat one batch of random calls, printing every call before it is made
    #[arg(long, value_name = "SEED")]
    replay: Option<u64>,
    /// Steps of each FMU of both versions alone, and of all together, in long runs; 10000000 are
    /// 2.8 h of simulated time
    #[arg(long, value_name = "STEPS")]
    long: Option<u64>,
    /// AddressSanitizer and LeakSanitizer on the tests of the C border, on random calls, on lives
    /// of instances, on instances in threads and on a coupled run (rustup toolchain install
    /// nightly)
    #[arg(long)]
    asan: bool,
    /// ThreadSanitizer on the same tests and on instances in threads (nightly as above)
    #[arg(long)]
    tsan: bool,
    /// Miri on the tests of the C border (nightly as above)
    #[arg(long)]
    miri: bool,
    /// Memcheck on loads, instances and unloads (apt-get install valgrind)
    #[arg(long)]
    valgrind: bool,
    /// Helgrind on instances in parallel threads (apt-get install valgrind)
    #[arg(long)]
    threads: bool,
    /// Coverage-guided fuzzing, this many seconds for each target (nightly as above; cargo install
    /// cargo-fuzz)
    #[arg(long, value_name = "SECONDS")]
    fuzz: Option<u64>,
}

/// Calls in CI: about a minute on two cores.
const CI_CALLS: usize = 1_000_000;
/// Its steps cost a hundred times those of the others: it has fewer calls.
const SLOW: &str = "Rig";
/// Calls on that one in CI.
const CI_CALLS_SLOW: usize = 40_000;
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
        tsan,
        miri,
        valgrind,
        threads,
        fuzz: seconds,
    } = *options;
    if let Some(seconds) = seconds {
        fuzz::run(workspace, seconds)?;
    }
    if asan {
        sanitize::address(workspace, calls.unwrap_or(ASAN_CALLS), seed)?;
    }
    if tsan {
        sanitize::thread(workspace)?;
    }
    if miri {
        sanitize::miri(workspace)?;
    }
    let is_plain = !(asan || tsan || miri || valgrind || threads)
        && seconds.or(replay).or(long).or(calls.map(|_| 0)).is_none();
    let needs_fmus =
        is_plain || valgrind || threads || replay.or(long).is_some() || (calls.is_some() && !asan);
    if !needs_fmus {
        return Ok(());
    }
    let fmus = pack::suite(workspace, &workspace.fmu_dir())?;
    if is_plain {
        return check(workspace, fmus);
    }
    let fmus = pack::both_versions(fmus)?;
    let [fast, _] = fast_and_slow(&fmus);
    let driver = Driver::build(workspace, fmus)?;
    let count = driver.fmus.len();
    // A seed chooses among the same FMUs as in CI.
    let random = |arguments: &[&str]| {
        let mut command = workspace.command(&driver.program);
        execute(command.arg("calls").args(arguments).args(&fast))
    };
    if let Some(seed) = replay {
        random(&["--replay", &seed.to_string()])?;
    }
    if let Some(calls) = calls.filter(|_| !asan) {
        random(&["--calls", &calls.to_string(), "--seed", &seed.to_string()])?;
    }
    if let Some(steps) = long {
        driver.run(&["long", "--steps", &steps.to_string()])?;
        let hdrm_fmu = workspace.build_programs(&["hdrm-fmu"])?;
        execute(
            workspace
                .command(hdrm_fmu)
                .args(["endurance", "--steps", &steps.to_string()]),
        )?;
        println!(
            "long runs: {steps} steps of each of {count} FMUs alone and of all five instances together"
        );
    }
    if valgrind {
        // What is lost once in a life is lost in each: some lives tell as much as a thousand.
        driver.under(MEMCHECK, &["life", "--instances", "60", "--loads", "3"])?;
        println!(
            "memcheck: 60 instances of each of {count} FMUs over 3 loads and unloads: 0 errors, 0 bytes definitely lost"
        );
    }
    if threads {
        driver.run(&["threads", "--threads", "8", "--steps", "2000"])?;
        driver.under(
            HELGRIND,
            &["threads", "--warm", "--threads", "4", "--steps", "50"],
        )?;
        println!(
            "threads: {} in parallel with 2000 steps each, then {} with 50 steps each under helgrind: 0 errors",
            8 * count,
            4 * count
        );
    }
    Ok(())
}

/// What CI does, on the FMUs as they are packed, in both versions of FMI.
pub fn check(workspace: &Workspace, fmus: Vec<PathBuf>) -> Result<()> {
    let fmus = pack::both_versions(fmus)?;
    let [fast, slow] = fast_and_slow(&fmus);
    let driver = Driver::build(workspace, fmus)?;
    for (fmus, calls) in [(fast, CI_CALLS), (slow, CI_CALLS_SLOW)] {
        let mut command = workspace.command(&driver.program);
        execute(
            command
                .args(["calls", "--calls", &calls.to_string()])
                .args(fmus),
        )?;
    }
    driver.run(&["threads"])?;
    driver.run(&["long", "--steps", &CI_STEPS.to_string()])?;
    let mut coupled = workspace.command(workspace.build_programs(&["hdrm-fmu"])?);
    coupled.args(["endurance", "--steps", &CI_COUPLED_STEPS.to_string()]);
    execute(&mut coupled)
}

/// The FMUs but the slow one, and that one, each in both versions.
fn fast_and_slow(fmus: &[PathBuf]) -> [Vec<PathBuf>; 2] {
    let is_slow = |fmu: &PathBuf| fmu.file_stem().is_some_and(|name| name == SLOW);
    let (slow, fast) = fmus.iter().cloned().partition(is_slow);
    [fast, slow]
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
    /// Built here, for packed FMUs.
    fn build(workspace: &'a Workspace, fmus: Vec<PathBuf>) -> Result<Self> {
        Ok(Self {
            workspace,
            program: workspace.build_programs(&["torture"])?,
            fmus,
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
