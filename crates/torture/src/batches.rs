//! Batches of random calls in processes of their own; the seed of a batch also decides which FMU it
//! is for.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use std::{fs, thread};

use anyhow::{Context, Result, anyhow, bail, ensure};

use cargo_fmu::fmi::Fmu;
use cargo_fmu::process::wait;
use fmu_description::functions::Function;

use crate::session::{Counts, Session};

/// A batch that takes longer than this hangs. Under valgrind and sanitizers everything is slow.
const PATIENCE: Duration = Duration::from_secs(600);
/// Last calls that are printed of a batch that failed.
const SHOWN: usize = 25;

/// The FMU of a batch, and another one whose serialized states it is given as foreign ones.
fn chosen(fmus: &[PathBuf], seed: u64) -> (&Path, Option<&Path>) {
    let k = (seed % fmus.len() as u64) as usize;
    let other = &fmus[(k + 1) % fmus.len()];
    (&fmus[k], (fmus.len() > 1).then_some(other))
}

/// One batch in this process; the counts go to standard output, which the FMU must leave alone.
pub fn one(fmus: &[PathBuf], calls: usize, seed: u64, is_traced: bool) -> Result<()> {
    let (path, foreign) = chosen(fmus, seed);
    let (fmu, foreign) = (Fmu::open(path)?, foreign.map(Fmu::open).transpose()?);
    let session = Session::new(&fmu, foreign.as_ref(), seed, is_traced);
    let mut session = session.map_err(|e| anyhow!(e))?;
    session.run(calls).map_err(|e| anyhow!(e))?;
    println!("compared {}", session.compared);
    println!("digest {:016x}", session.digest);
    for (name, [done, discarded, refused]) in &session.counts {
        println!("{name} {done} {discarded} {refused}");
    }
    Ok(())
}

/// How a batch is run as a process.
fn process(fmus: &[PathBuf], calls: usize, seed: u64) -> Result<Command> {
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
    let status = process(fmus, calls, seed)?.arg("--trace").status()?;
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
    let jobs = jobs.unwrap_or_else(|| thread::available_parallelism().map_or(1, Into::into));
    let (next, total) = (AtomicUsize::new(0), Mutex::new(Total::default()));
    thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    if k >= batches {
                        return;
                    }
                    let result = match k {
                        0 => twice(|| supervised(fmus, batch, seed)),
                        _ => supervised(fmus, batch, seed + k as u64),
                    };
                    total.lock().expect("no thread panics").add(result);
                }
            });
        }
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

/// A seed is a test case only if a batch can be repeated: the same calls with the same answers, in
/// another process.
fn twice(batch: impl Fn() -> Result<String>) -> Result<String> {
    let (first, second) = (batch()?, batch()?);
    ensure!(
        first == second,
        "repeated, the first batch went otherwise:\n{first}\nthen\n{second}"
    );
    Ok(first)
}

/// Counts of all batches.
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

/// A batch in a process: its report, or why it failed, with its last calls.
fn supervised(fmus: &[PathBuf], calls: usize, seed: u64) -> Result<String> {
    let log = std::env::temp_dir().join(format!("torture-{}-{seed}.log", std::process::id()));
    let (out, err) = (log.with_extension("out"), fs::File::create(&log)?);
    let mut command = process(fmus, calls, seed)?;
    command.stdout(fs::File::create(&out)?).stderr(err);
    let status = wait(command.spawn()?, PATIENCE)?;
    let (report, complaint) = (fs::read_to_string(&out)?, fs::read_to_string(&log)?);
    let traced = || -> Result<String> {
        let mut command = process(fmus, calls, seed)?;
        let file = fs::File::create(&log)?;
        command.arg("--trace").stdout(Stdio::null()).stderr(file);
        wait(command.spawn()?, PATIENCE)?;
        let trace = String::from_utf8_lossy(&fs::read(&log)?).into_owned();
        let lines: Vec<&str> = trace.lines().collect();
        Ok(lines[lines.len().saturating_sub(SHOWN)..].join("\n"))
    };
    let (fmu, _) = chosen(fmus, seed);
    let result = match status {
        Some(status) if status.success() && complaint.is_empty() => Ok(report),
        Some(status) if status.success() => Err(anyhow!(
            "seed {seed}: {} wrote to stderr: {complaint}",
            fmu.display()
        )),
        Some(status) => Err(anyhow!(
            "seed {seed}, {}: {status}: {complaint}last calls of its repetition (all of them with --replay {seed}):\n{}",
            fmu.display(),
            traced()?
        )),
        None => Err(anyhow!(
            "seed {seed}, {}: hangs; see --replay {seed}",
            fmu.display()
        )),
    };
    let _ = (fs::remove_file(&log), fs::remove_file(&out)); // a leftover in the temporary folder does no harm
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn a_batch_that_cannot_be_repeated_is_a_failure() {
        assert_eq!(twice(|| Ok("digest 1".into())).unwrap(), "digest 1");
        let count = Cell::new(0);
        let different = || {
            count.set(count.get() + 1);
            Ok(format!("digest {}", count.get()))
        };
        let text = twice(different).unwrap_err().to_string();
        assert!(text.contains("digest 1\nthen\ndigest 2"), "{text}");
        assert!(twice(|| bail!("crash")).is_err());
    }

    #[test]
    fn reports_add_up_and_stray_words_are_failures() {
        let mut total = Total::default();
        total.add(Ok(
            "compared 3\ndigest 0f\nfmi2DoStep 4 1 2\nfmi2Reset 1 0 0\n".into(),
        ));
        total.add(Ok("compared 2\ndigest 1f\nfmi2DoStep 1 0 0\n".into()));
        assert_eq!(total.compared, 5);
        assert_eq!(total.counts["fmi2DoStep"], [5, 1, 2]);
        assert!(total.failures.is_empty());
        total.add(Ok("hello from the FMU\n".into()));
        total.add(Ok("fmi2DoNothing 1 0 0\n".into()));
        total.add(Err(anyhow!("crash")));
        assert_eq!(total.failures.len(), 3);
    }

    /// The seeds of three batches in a row are for three FMUs, each with another one's states.
    #[test]
    fn seeds_choose_the_fmus_in_turn() {
        let fmus: Vec<PathBuf> = ["a", "b", "c"].map(PathBuf::from).into();
        let names = (0..3).map(|seed| chosen(&fmus, seed));
        let names: Vec<_> = names
            .map(|(own, other)| (own.to_str().unwrap(), other.unwrap().to_str().unwrap()))
            .collect();
        assert_eq!(names, [("a", "b"), ("b", "c"), ("c", "a")]);
        assert!(chosen(&fmus[..1], 5).1.is_none());
    }
}
