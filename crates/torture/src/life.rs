//! Lives of instances from load to unload. Under valgrind this shows that nothing is read wrongly
//! and nothing is left.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, anyhow};

use crate::subject::{Subject, first_steps};
use cargo_fmu::fmi::Fmu;
use cargo_fmu::fmi::symbols::OK;

/// Instances alive at a time.
const ALIVE: usize = 10;

/// Loads each FMU `loads` times, with `instances` in total.
pub fn run(paths: &[PathBuf], instances: usize, loads: usize) -> Result<()> {
    for path in paths {
        let clock = Instant::now();
        let mut expected = None;
        for _ in 0..loads {
            let fmu = Fmu::open(path)?;
            for _ in 0..(instances / loads).div_ceil(ALIVE) {
                let generation: Result<Vec<_>, String> = (0..ALIVE).map(|_| live(&fmu)).collect();
                for (_, bits) in generation.map_err(|e| anyhow!("{}: {e}", path.display()))? {
                    let first = expected.get_or_insert_with(|| bits.clone());
                    anyhow::ensure!(*first == bits, "{}: instances differ", path.display());
                }
            }
        }
        let made = loads * (instances / loads).div_ceil(ALIVE) * ALIVE;
        println!(
            "{}: {loads} loads, {made} instances with 10 steps and 3 saved states each, {:.1} s",
            path.display(),
            clock.elapsed().as_secs_f64()
        );
    }
    Ok(())
}

/// One life: steps, a state saved and carried over as bytes, misuse, reset; left alive with a saved
/// state not freed.
fn live(fmu: &Fmu) -> Result<(Subject<'_>, Vec<u64>), String> {
    let mut instance = Subject::new(fmu, "life")?;
    first_steps(&mut instance)?;
    let bytes = instance.bytes()?;
    let (status, state) = instance.deserialize(&bytes);
    instance.must("fmi2DeSerializeFMUstate", status)?;
    instance.go_back(state, 0.0)?;
    let (damaged, _) = instance.deserialize(&bytes[..bytes.len() - 1]);
    let unknown = instance.set_reals(&[u32::MAX], &[0.0]);
    if damaged == OK || unknown == OK {
        return Err("a wrong call was accepted".into());
    }
    instance.reset()?;
    let bits = first_steps(&mut instance)?;
    Ok((instance, bits))
}
