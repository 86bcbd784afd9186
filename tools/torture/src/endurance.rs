//! `torture long`: long runs, in which memory must not grow, time must not drift and no step may
//! fail.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, ensure};

use crate::arguments::start;
use crate::subject::Subject;
use fmi_description::Access;
use fmi_import::Fmu;
use fmi_import::status::WARNING;

const STEP: f64 = 1e-3;
/// Allowed growth of memory, kB: some pages that the allocator keeps.
const GROWTH: i64 = 256;

/// Makes `steps` steps of 1 ms of an FMU, with all Real inputs swinging around their start values.
pub fn run(path: &Path, steps: u64) -> Result<()> {
    let (clock, fmu) = (Instant::now(), Fmu::open(path)?);
    let mut instance = Subject::new(&fmu, "long")?;
    instance.initialize()?;
    let inputs: Vec<_> = fmu
        .description
        .variables
        .iter()
        .filter(|v| v.is_input() && v.access() == Access::Real)
        .collect();
    let vr: Vec<u32> = inputs.iter().map(|v| v.reference).collect();
    let elements: Vec<_> = inputs
        .iter()
        .flat_map(|v| (0..v.size()).map(move |k| (start(v, k), v.bounds())))
        .collect();
    let (mut values, mut largest) = (vec![0.0; elements.len()], 0.0_f64);
    let (mut warned, mut failed) = (0_u64, 0_u64);
    let mut before = 0;
    for k in 0..steps {
        if k == steps / 10 {
            before = resident()?;
        }
        for (i, (value, (start, [min, max]))) in values.iter_mut().zip(&elements).enumerate() {
            let phase = 2e-3 * k as f64 * (1.0 + 0.1 * i as f64);
            *value = (start + 0.1 * start.abs().max(1e-2) * phase.sin()).clamp(*min, *max);
        }
        // t_k from an integer, as a good importer does it.
        let t = k as f64 * STEP;
        let set = instance.set_reals(&vr, &values);
        let stepped = instance.step_from(t, STEP);
        let (status, outputs) = instance.outputs();
        let done = (instance.must("fmi2SetReal", set))
            .and_then(|()| instance.must("fmi2DoStep", stepped))
            .and_then(|()| instance.must("fmi2GetReal", status));
        done.with_context(|| format!("step {k}"))?;
        // Inputs without a machine behind them may cause warnings, but no step may fail.
        let messages = instance.messages();
        warned += u64::from(messages.iter().any(|m| m.status == WARNING));
        failed += u64::from(messages.iter().any(|m| m.status > WARNING));
        largest = outputs.iter().fold(largest, |a, y| a.max(y.abs()));
    }
    let growth = resident()? - before;
    let mut end = f64::NAN;
    instance.last_time(&mut end);
    let drift = end - steps as f64 * STEP;
    println!(
        "{}: {steps} steps of 1 ms in {:.0} s; memory after the first tenth {before} kB, growth {growth} kB; drift of time {drift:e} s; \
         largest output {largest:.3e}; steps with a warning {warned}, with an error {failed}",
        path.display(),
        clock.elapsed().as_secs_f64()
    );
    ensure!(
        growth <= GROWTH,
        "memory grew by {growth} kB, but must grow by {GROWTH} kB at most"
    );
    ensure!(
        drift.abs() <= f64::EPSILON * end,
        "time drifted by {drift} s"
    );
    ensure!(failed == 0, "{failed} steps came with an error");
    Ok(())
}

/// Resident memory of this process, kB; 0 on systems that do not report it.
fn resident() -> Result<i64> {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else {
        return Ok(0);
    };
    let line = status.lines().find(|l| l.starts_with("VmRSS:"));
    let number = line.and_then(|l| l.split_whitespace().nth(1));
    number
        .context("VmRSS in /proc/self/status")?
        .parse()
        .context("VmRSS")
}
