//! `torture threads`: instances in parallel threads, each of which must compute the same as one
//! alone, bit for bit. Under helgrind this shows that they share nothing.

use std::path::PathBuf;
use std::thread;
use std::time::Instant;

use anyhow::{Context, Result, anyhow, ensure};

use crate::subject::Subject;
use fmi_import::Fmu;

/// Runs `threads` instances of each FMU at once, `steps` steps each.
///
/// Helgrind does not understand atomics and futexes, with which the libraries publish what they
/// compute once (their GUID, the processor's features, the network). With `is_warm` an instance of
/// each FMU lives from before the threads start until they have ended, so that all of that is
/// published before and whatever helgrind reports is an error.
pub fn run(paths: &[PathBuf], threads: usize, steps: usize, is_warm: bool) -> Result<()> {
    let clock = Instant::now();
    let fmus = paths
        .iter()
        .map(|p| Fmu::open(p))
        .collect::<Result<Vec<_>>>()?;
    let first = if is_warm { &fmus[..] } else { &[] };
    let kept = first.iter().map(warm_up).collect::<Result<Vec<_>>>()?;
    // Several threads make the first instance of a library at once.
    let results: Vec<Vec<Result<Vec<u64>>>> = thread::scope(|scope| {
        let spawn = |fmu| {
            (0..threads)
                .map(|_| scope.spawn(move || trajectory(fmu, steps)))
                .collect::<Vec<_>>()
        };
        let running: Vec<_> = fmus.iter().map(spawn).collect();
        let join = |t: thread::ScopedJoinHandle<'_, _>| {
            t.join()
                .unwrap_or_else(|_| Err(anyhow!("the thread panicked")))
        };
        running
            .into_iter()
            .map(|group| group.into_iter().map(join).collect())
            .collect()
    });
    drop(kept);
    for ((path, fmu), group) in paths.iter().zip(&fmus).zip(results) {
        let alone = trajectory(fmu, steps)?;
        for result in group {
            let path = || path.display().to_string();
            let is_same = result.with_context(path)? == alone;
            ensure!(is_same, "{}: in parallel the outputs differ", path());
        }
    }
    println!(
        "{} threads with an instance each, {steps} steps of each, {:.1} s: all as one alone, bit for bit",
        threads * paths.len(),
        clock.elapsed().as_secs_f64()
    );
    Ok(())
}

/// An instance that has done everything once.
fn warm_up(fmu: &Fmu) -> Result<Subject<'_>> {
    let mut instance = Subject::new(fmu, "first")?;
    run_steps(&mut instance, 1)?;
    Ok(instance)
}

/// Outputs of an instance that lives in this thread.
fn trajectory(fmu: &Fmu, steps: usize) -> Result<Vec<u64>> {
    run_steps(&mut Subject::new(fmu, "thread")?, steps)
}

/// Outputs over some steps. Saved states and wrong calls in between exercise memory and log.
fn run_steps(instance: &mut Subject, steps: usize) -> Result<Vec<u64>> {
    instance.initialize()?;
    let mut bits = Vec::new();
    for k in 0..steps {
        bits.extend(instance.observed_step(1e-3)?);
        if k % 16 == 0 {
            instance.bytes()?;
            instance.set_reals(&[u32::MAX], &[0.0]); // unknown, which must be refused
        }
    }
    Ok(bits)
}
