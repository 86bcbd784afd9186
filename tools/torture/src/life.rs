//! `torture life`: loads FMUs, makes, uses and frees instances, and unloads. Under valgrind this
//! shows invalid reads and leaks.

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, ensure};

use crate::subject::{Subject, first_steps};
use fmi_import::Fmu;
use fmi_import::status::OK;

/// Instances alive at a time.
const ALIVE: usize = 10;

/// Loads an FMU `loads` times and makes `instances` instances in total.
pub fn run(path: &Path, instances: usize, loads: usize) -> Result<()> {
    let clock = Instant::now();
    let generations = (instances / loads).div_ceil(ALIVE);
    let mut expected = None;
    for _ in 0..loads {
        let fmu = Fmu::open(path)?;
        for _ in 0..generations {
            let generation: Result<Vec<_>> = (0..ALIVE).map(|_| use_instance(&fmu)).collect();
            for (_, bits) in generation? {
                let first = expected.get_or_insert_with(|| bits.clone());
                ensure!(*first == bits, "instances differ");
            }
        }
    }
    println!(
        "{}: {loads} loads, {} instances with 10 steps and 3 saved states each, {:.1} s",
        path.display(),
        loads * generations * ALIVE,
        clock.elapsed().as_secs_f64()
    );
    Ok(())
}

/// Makes an instance, steps it, restores a state from bytes, misuses and resets it. Returns it with
/// a saved state not freed, and its outputs.
fn use_instance(fmu: &Fmu) -> Result<(Subject<'_>, Vec<u64>)> {
    let mut instance = Subject::new(fmu, "life")?;
    first_steps(&mut instance)?;
    let bytes = instance.bytes()?;
    let (status, state) = instance.state_from_bytes(&bytes);
    instance.must("fmi2DeSerializeFMUstate", status)?;
    instance.go_back(state, 0.0)?;
    let (damaged, _) = instance.state_from_bytes(&bytes[..bytes.len() - 1]);
    let unknown = instance.set_reals(&[u32::MAX], &[0.0]);
    let are_refused = damaged != OK && unknown != OK;
    ensure!(are_refused, "a wrong call was accepted");
    instance.reset()?;
    let bits = first_steps(&mut instance)?;
    Ok((instance, bits))
}
