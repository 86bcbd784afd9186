//! Saved states.

use std::path::Path;
use std::ptr;

use super::super::outcome::Outcome;
use super::instance::Instance;
use super::{Trial, open, trial};
use crate::fmi::Fmu;
use crate::fmi::functions::{OK, Pointer, WARNING};

const STEPS: usize = 10;

pub const TRIALS: &[Trial] = &[
    trial(
        "restore",
        "saved states",
        restore,
        "a state that is set again leads to the same future, bit for bit, if canGetAndSetFMUstate",
        "iterating and error controlling importers go back and repeat a step",
    ),
    trial(
        "serialize",
        "saved states",
        serialize,
        "bytes of a state carry it to another instance, if canSerializeFMUstate",
        "long simulations are interrupted and go on in another process",
    ),
    trial(
        "damaged",
        "saved states",
        damaged,
        "damaged bytes are refused, if canSerializeFMUstate",
        "files get cut off; a state made of half a file is wrong without a word",
    ),
];

/// A saved state of an instance.
fn save(instance: &Instance) -> Result<Pointer, String> {
    let mut state = ptr::null_mut();
    // SAFETY: a live instance, a place for the result.
    let status = unsafe { instance.fmu.functions.get_fmu_state(instance.c, &mut state) };
    instance.must("fmi2GetFMUstate", status)?;
    match state.is_null() {
        true => Err("fmi2GetFMUstate gave NULL".into()),
        false => Ok(state),
    }
}

fn go_back(instance: &mut Instance, state: Pointer, time: f64) -> Result<(), String> {
    // SAFETY: a live instance and a state of it.
    let status = unsafe { instance.fmu.functions.set_fmu_state(instance.c, state) };
    instance.time = time;
    instance.must("fmi2SetFMUstate", status)
}

fn free(instance: &Instance, mut state: Pointer) -> Result<(), String> {
    // SAFETY: a live instance and a state of it, or NULL.
    let status = unsafe {
        instance
            .fmu
            .functions
            .free_fmu_state(instance.c, &mut state)
    };
    instance.must("fmi2FreeFMUstate", status)
}

fn bytes(instance: &Instance) -> Result<Vec<u8>, String> {
    let f = &instance.fmu.functions;
    let (state, mut size) = (save(instance)?, 0);
    // SAFETY: a live instance, a state of it, a place for the result.
    let status = unsafe { f.serialized_fmu_state_size(instance.c, state, &mut size) };
    instance.must("fmi2SerializedFMUstateSize", status)?;
    let mut bytes = vec![0; size];
    // SAFETY: as many bytes as asked for.
    let status = unsafe { f.serialize_fmu_state(instance.c, state, bytes.as_mut_ptr(), size) };
    instance.must("fmi2SerializeFMUstate", status)?;
    free(instance, state)?;
    Ok(bytes)
}

/// Whether the FMU claims what is to be tried.
fn claims(fmu: &Fmu, serialize: bool, outcome: &mut Outcome) -> bool {
    let capabilities = &fmu.description.capabilities;
    let claimed = capabilities.saves_state && (capabilities.serializes_state || !serialize);
    if !claimed {
        outcome.not_checked = Some("the FMU does not claim it".into());
    }
    claimed
}

fn restore(folder: &Path, outcome: &mut Outcome) -> Result<(), String> {
    let fmu = open(folder)?;
    if !claims(&fmu, false, outcome) {
        return Ok(());
    }
    let mut instance = Instance::started(&fmu, "restore")?;
    let at_start = save(&instance)?;
    let (t0, first) = (instance.time, instance.motion(STEPS, 0)?);
    let in_between = save(&instance)?;
    let (t1, second) = (instance.time, instance.motion(STEPS, STEPS)?);
    for (state, time, phase, expected) in [
        (at_start, t0, 0, &first),
        (in_between, t1, STEPS, &second),
        (at_start, t0, 0, &first),
    ] {
        go_back(&mut instance, state, time)?;
        if instance.motion(STEPS, phase)? != *expected {
            outcome.fail(format!(
                "back at t = {time} s, the steps that follow give other numbers than before"
            ));
        }
    }
    free(&instance, at_start)?;
    free(&instance, in_between)?;
    free(&instance, ptr::null_mut())
}

fn serialize(folder: &Path, outcome: &mut Outcome) -> Result<(), String> {
    let fmu = open(folder)?;
    if !claims(&fmu, true, outcome) {
        return Ok(());
    }
    let mut instance = Instance::started(&fmu, "first")?;
    instance.motion(STEPS, 0)?;
    let (bytes, time) = (bytes(&instance)?, instance.time);
    let expected = instance.motion(STEPS, STEPS)?;
    drop(instance); // it may be the only one that can be made
    outcome.note(format!("{} bytes", bytes.len()));
    let mut other = Instance::started(&fmu, "other")?;
    let mut state = ptr::null_mut();
    // SAFETY: a live instance, bytes of the length given, a place for the result.
    let status = unsafe {
        fmu.functions
            .deserialize_fmu_state(other.c, bytes.as_ptr(), bytes.len(), &mut state)
    };
    other.must("fmi2DeSerializeFMUstate", status)?;
    go_back(&mut other, state, time)?;
    if other.motion(STEPS, STEPS)? != expected {
        outcome.fail("another instance goes on with other numbers");
    }
    free(&other, state)
}

fn damaged(folder: &Path, outcome: &mut Outcome) -> Result<(), String> {
    let fmu = open(folder)?;
    if !claims(&fmu, true, outcome) {
        return Ok(());
    }
    let mut instance = Instance::started(&fmu, "damaged")?;
    instance.motion(STEPS, 0)?;
    let whole = bytes(&instance)?;
    let (half, mut flipped) = (whole[..whole.len() / 2].to_vec(), whole.clone());
    if let Some(byte) = flipped.get_mut(whole.len() / 3) {
        *byte ^= 0x10;
    }
    for (what, bytes) in [
        ("half of the bytes", half),
        ("bytes with one bit changed", flipped),
    ] {
        let mut state = ptr::null_mut();
        // SAFETY: a live instance, bytes of the length given, a place for the result.
        let status = unsafe {
            fmu.functions
                .deserialize_fmu_state(instance.c, bytes.as_ptr(), bytes.len(), &mut state)
        };
        if matches!(status, OK | WARNING) {
            outcome.remark(format!("fmi2DeSerializeFMUstate took {what}"));
            free(&instance, state)?;
        }
    }
    instance.motion(STEPS, STEPS).map(drop)
}
