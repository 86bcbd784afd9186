//! `torture save` and `torture continue`: one process saves a state in the middle of a run;
//! another, maybe on another platform, continues from it and must compute the same bits.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use fmi_description::{Access, Variable};
use fmi_import::Fmu;

use crate::arguments::start;
use crate::subject::Subject;

const STEP: f64 = 1e-3;
/// Steps before the state is saved, and after it.
const STEPS: usize = 50;

/// Runs an FMU, and writes its state in the middle and the numbers that follow to the folder.
pub fn save(path: &Path, folder: &Path) -> Result<()> {
    let fmu = Fmu::open(path)?;
    let mut instance = Subject::new(&fmu, "carry")?;
    instance.initialize()?;
    steps(&mut instance, 0)?;
    let state = instance.bytes()?;
    let lines = steps(&mut instance, STEPS)?;
    let file = folder.join(&fmu.description.identifier);
    fs::write(file.with_extension("state"), &state)?;
    fs::write(file.with_extension("outputs"), lines.join("\n"))?;
    let (path, size) = (path.display(), state.len());
    println!("{path}: saved {size} bytes after {STEPS} steps");
    Ok(())
}

/// Continues an FMU from the state in the folder; the numbers that follow must be those written
/// there.
pub fn continue_from(path: &Path, folder: &Path) -> Result<()> {
    let fmu = Fmu::open(path)?;
    let file = folder.join(&fmu.description.identifier);
    let read = |suffix| {
        let file = file.with_extension(suffix);
        fs::read(&file).with_context(|| format!("{}; was it saved?", file.display()))
    };
    let (state, expected) = (read("state")?, String::from_utf8(read("outputs")?)?);
    let mut instance = Subject::new(&fmu, "carry")?;
    let time = STEPS as f64 * STEP;
    instance.restore(&state, time)?;
    instance.known.time = time;
    let lines = steps(&mut instance, STEPS)?;
    for (line, expected) in lines.iter().zip(expected.lines()) {
        ensure!(
            line == expected,
            "after the state was carried over: {line}, but where it was saved: {expected}"
        );
    }
    let are_all = lines.len() == expected.lines().count();
    ensure!(are_all, "lines are missing");
    let (path, count) = (path.display(), lines.len());
    println!("{path}: {count} numbers as where it was saved");
    Ok(())
}

/// Makes steps from number `first` on, with moving inputs; returns every computed number after
/// each, with its bits, as lines.
fn steps(instance: &mut Subject, first: usize) -> Result<Vec<String>> {
    let variables = &instance.fmu.description.variables;
    let reals = || variables.iter().filter(|v| v.access() == Access::Real);
    let inputs: Vec<_> = reals().filter(|v| v.is_input()).collect();
    let computed: Vec<_> = reals().filter(|v| v.is_computed()).collect();
    let references: Vec<u32> = inputs.iter().map(|v| v.reference).collect();
    let mut lines = Vec::new();
    for k in first..first + STEPS {
        let values: Vec<f64> = inputs.iter().flat_map(|v| moving(v, k)).collect();
        let status = instance.set_reals(&references, &values);
        instance.must("fmi2SetReal", status)?;
        instance.known.time = k as f64 * STEP;
        instance.advance(STEP)?;
        let (status, outputs) = instance.outputs();
        instance.must("fmi2GetReal", status)?;
        let line = |(v, y): (&&Variable, f64)| {
            format!("step {k}: `{}` = {y} ({:016x})", v.name, y.to_bits())
        };
        let computed = computed.iter().flat_map(|v| vec![v; v.size()]);
        lines.extend(computed.zip(outputs).map(line));
    }
    Ok(lines)
}

/// Values of an input in a step: a zigzag around its start values, which every platform computes
/// alike.
fn moving(v: &Variable, step: usize) -> Vec<f64> {
    let [min, max] = v.bounds();
    let zigzag = (step % 40).abs_diff(20) as f64 / 10.0 - 1.0;
    let value = |start: f64| (start + 0.1 * start.abs().max(1e-2) * zigzag).clamp(min, max);
    (0..v.size()).map(|k| value(start(v, k))).collect()
}
