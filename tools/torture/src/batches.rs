//! `torture calls`: batches of random calls, each in a process of its own, so that a crash or a
//! hang is caught. The seed of a batch also selects its FMU.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

use fmi_import::process::{self, Process};
use fmi_import::standard::Function;
use fmi_import::{Fmu, Limits};
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use crate::session::{Counts, Session};

/// A batch that takes longer than this counts as hanging. Valgrind and sanitizers are slow.
const PATIENCE: Duration = Duration::from_secs(600);
/// Number of last calls that are printed of a failed batch.
const SHOWN: usize = 25;

/// The FMU of a batch, and another one whose serialized states it must refuse.
fn select(fmus: &[PathBuf], seed: u64) -> (&Path, Option<&Path>) {
    let k = (seed % fmus.len() as u64) as usize;
    let other = &fmus[(k + 1) % fmus.len()];
    (&fmus[k], (fmus.len() > 1).then_some(other))
}

/// Runs a batch in this process. The counts go to standard output, to which the FMU must not print.
pub fn run_here(fmus: &[PathBuf], calls: usize, seed: u64, is_traced: bool) -> Result<()> {
    let time = Some(PATIENCE);
    process::watch(Limits { time, memory: None }, None);
    process::begin_call();
    let (path, foreign) = select(fmus, seed);
    let (fmu, foreign) = (Fmu::open(path)?, foreign.map(Fmu::open).transpose()?);
    let mut session = Session::new(&fmu, foreign.as_ref(), seed, is_traced)?;
    session.run(calls)?;
    println!("compared {}", session.compared);
    println!("digest {:016x}", session.digest);
    for (name, [done, discarded, refused]) in &session.counts {
        println!("{name} {done} {discarded} {refused}");
    }
    Ok(())
}

/// The command that runs a batch as a process.
fn batch_command(fmus: &[PathBuf], calls: usize, seed: u64) -> Result<Command> {
    let mut command = Command::new(std::env::current_exe()?);
    let (calls, seed) = (calls.to_string(), seed.to_string());
    command
        .args(["batch", "--calls", &calls, "--seed", &seed])
        .args(fmus);
    command.stdin(Stdio::null());
    Ok(command)
}

/// Repeats a batch with every call printed.
pub fn replay(fmus: &[PathBuf], calls: usize, seed: u64) -> Result<()> {
    let status = batch_command(fmus, calls, seed)?.arg("--trace").status()?;
    ensure!(status.success(), "batch of seed {seed}: {status}");
    println!("batch of seed {seed}: no complaint");
    Ok(())
}

/// Runs batches until `calls` are made; fails if any batch does.
pub fn run(
    fmus: &[PathBuf],
    calls: usize,
    batch: usize,
    seed: u64,
    jobs: Option<usize>,
) -> Result<()> {
    let clock = Instant::now();
    let batches = calls.div_ceil(batch);
    // 0 stands for the number of cores.
    let pool = ThreadPoolBuilder::new().num_threads(jobs.unwrap_or(0));
    let total = Mutex::new(Total::default());
    pool.build()?.install(|| {
        (0..batches as u64).into_par_iter().for_each(|k| {
            let result = match k {
                0 => twice(|| supervised(fmus, batch, seed)),
                _ => supervised(fmus, batch, seed + k),
            };
            total.lock().expect("no thread panics").add(result);
        });
    });
    let total = total.into_inner().expect("no thread panics");
    total.print(batches, clock.elapsed());
    ensure!(
        total.failures.is_empty(),
        "{} of {batches} batches failed",
        total.failures.len()
    );
    Ok(())
}

/// Runs a batch twice, in two processes: both must make the same calls with the same answers, else
/// a seed would be no test case.
fn twice(batch: impl Fn() -> Result<String>) -> Result<String> {
    let (first, second) = (batch()?, batch()?);
    ensure!(
        first == second,
        "repeated, the first batch differed:\n{first}\nthen\n{second}"
    );
    Ok(first)
}

/// Counts and failures of all batches.
#[derive(Default)]
struct Total {
    counts: Counts,
    compared: u64,
    failures: Vec<String>,
}

impl Total {
    fn add(&mut self, result: Result<String>) {
        let added = result.and_then(|report| self.count(&report));
        if let Err(error) = added {
            eprintln!("{error:#}\n");
            self.failures.push(format!("{error:#}"));
        }
    }

    fn count(&mut self, report: &str) -> Result<()> {
        for line in report.lines() {
            let words: Vec<&str> = line.split(' ').collect();
            match *words {
                ["compared", n] => self.compared += n.parse::<u64>()?,
                ["digest", _] => (),
                [name, done, discarded, refused] => {
                    let known = Function::named(name).with_context(|| line.to_string())?;
                    let counts = self.counts.entry(known.name).or_default();
                    for (count, word) in counts.iter_mut().zip([done, discarded, refused]) {
                        *count += word.parse::<u64>()?;
                    }
                }
                _ => bail!("something was written to standard output: {line}"),
            }
        }
        Ok(())
    }

    fn print(&self, batches: usize, time: Duration) {
        println!(
            "{:30} {:>9} {:>9} {:>9}",
            "function", "done", "discarded", "refused"
        );
        for (name, [done, discarded, refused]) in &self.counts {
            println!("{name:30} {done:9} {discarded:9} {refused:9}");
        }
        let all: u64 = self.counts.values().flatten().sum();
        println!(
            "{all} random calls in {batches} processes, {:.0} s: {} batches failed; after {} refused calls the instance was compared \
             with before; the first batch, repeated, made the same calls with the same answers",
            time.as_secs_f64(),
            self.failures.len(),
            self.compared
        );
    }
}

/// Runs a batch in a process; returns its report, or why it failed with its last calls.
fn supervised(fmus: &[PathBuf], calls: usize, seed: u64) -> Result<String> {
    let log = std::env::temp_dir().join(format!("torture-{}-{seed}.log", std::process::id()));
    let (out, err) = (log.with_extension("out"), fs::File::create(&log)?);
    let mut command = batch_command(fmus, calls, seed)?;
    command.stdout(fs::File::create(&out)?).stderr(err);
    let status = Process::start(&mut command)?.wait(PATIENCE)?;
    let (report, complaint) = (fs::read_to_string(&out)?, fs::read_to_string(&log)?);
    let traced = || -> Result<String> {
        let mut command = batch_command(fmus, calls, seed)?;
        let file = fs::File::create(&log)?;
        command.arg("--trace").stdout(Stdio::null()).stderr(file);
        Process::start(&mut command)?.wait(PATIENCE)?;
        let trace = String::from_utf8_lossy(&fs::read(&log)?).into_owned();
        let lines: Vec<&str> = trace.lines().collect();
        Ok(lines[lines.len().saturating_sub(SHOWN)..].join("\n"))
    };
    let (fmu, _) = select(fmus, seed);
    let problem = match status {
        Some(status) if status.success() && complaint.is_empty() => None,
        Some(status) if status.success() => Some(format!("it wrote to stderr: {complaint}")),
        Some(status) => Some(format!(
            "{status}: {complaint}last calls of its repetition (all of them with --replay {seed}):\n{}",
            traced()?
        )),
        None => Some(format!("hangs; see --replay {seed}")),
    };
    let _ = (fs::remove_file(&log), fs::remove_file(&out)); // a leftover in the temporary folder does no harm
    match problem {
        None => Ok(report),
        Some(problem) => bail!("seed {seed}, {}: {problem}", fmu.display()),
    }
}
