//! Instances in parallel threads: each must do what one alone does, bit for bit. Under helgrind this shows that they share nothing.

use std::path::PathBuf;
use std::thread;
use std::time::Instant;

use anyhow::{Result, anyhow, ensure};

use crate::fmu::Fmu;
use crate::instance::Instance;

/// `threads` instances of each FMU, `steps` steps each, all at once.
///
/// Helgrind does not understand atomics, by which the libraries publish what they compute once (their GUID, the processor's
/// abilities); `is_warm` has that done before the threads start, so that what helgrind still finds is a finding.
pub fn run(paths: &[PathBuf], threads: usize, steps: usize, is_warm: bool) -> Result<()> {
    let clock = Instant::now();
    let fmus = paths
        .iter()
        .map(|p| Fmu::open(p))
        .collect::<Result<Vec<_>>>()?;
    if is_warm {
        let first = fmus.iter().try_for_each(|fmu| trajectory(fmu, 1).map(drop));
        first.map_err(|e| anyhow!(e))?;
    }
    // Made at once, so that also the first instance of a library is made by several threads.
    let results: Vec<Vec<Result<Vec<u64>, String>>> = thread::scope(|scope| {
        let spawn = |fmu| {
            (0..threads)
                .map(|_| scope.spawn(move || trajectory(fmu, steps)))
                .collect::<Vec<_>>()
        };
        let running: Vec<_> = fmus.iter().map(spawn).collect();
        let join = |t: thread::ScopedJoinHandle<'_, _>| {
            t.join()
                .unwrap_or_else(|_| Err("the thread panicked".into()))
        };
        running
            .into_iter()
            .map(|group| group.into_iter().map(join).collect())
            .collect()
    });
    for ((path, fmu), group) in paths.iter().zip(&fmus).zip(results) {
        let alone = trajectory(fmu, steps).map_err(|e| anyhow!(e))?;
        for result in group {
            let bits = result.map_err(|e| anyhow!("{}: {e}", path.display()))?;
            ensure!(
                bits == alone,
                "{}: in parallel the outputs differ",
                path.display()
            );
        }
    }
    println!(
        "{} threads with an instance each, {steps} steps of each, {:.1} s: all as one alone, bit for bit",
        threads * paths.len(),
        clock.elapsed().as_secs_f64()
    );
    Ok(())
}

/// Outputs of an instance that is made, stepped, saved and freed in this thread. Wrong calls in between exercise the log.
fn trajectory(fmu: &Fmu, steps: usize) -> Result<Vec<u64>, String> {
    let mut instance = Instance::new(fmu, "thread")?;
    instance.initialize()?;
    let mut bits = Vec::new();
    for k in 0..steps {
        instance.advance(1e-3)?;
        let (status, values) = instance.outputs();
        instance.must("fmi2GetReal", status)?;
        bits.extend(values.iter().map(|v| v.to_bits()));
        if k % 16 == 0 {
            instance.snapshot()?;
            // SAFETY: a live instance; the reference is unknown, which must be refused.
            unsafe { (fmu.functions.fmi2SetReal)(instance.c, &u32::MAX, 1, &0.0) };
        }
    }
    Ok(bits)
}
