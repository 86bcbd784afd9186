//! Saved states.

use anyhow::Result;

use super::trial::trials;
use crate::outcome::Outcome;
use fmi_import::raw::StateHandle;
use fmi_import::status::{OK, WARNING};
use fmi_import::{Fmu, Instance};

const STEPS: usize = 10;

trials! {
    "saved states" {
        opened restore.if_claimed(|c| c.saves_state):
            "a state that is set again leads to the same future, bit for bit, if canGetAndSetFMUstate",
            "iterating and error controlling importers go back and repeat a step";
        opened serialize.if_claimed(|c| c.saves_state && c.serializes_state):
            "bytes of a state carry it to another instance, if canSerializeFMUstate",
            "long simulations are interrupted and go on in another process";
        opened damaged.if_claimed(|c| c.saves_state && c.serializes_state):
            "damaged bytes are refused, if canSerializeFMUstate",
            "files get cut off; a state made of half a file is wrong without a word";
    }
}

fn restore(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::started(fmu, "restore")?;
    let at_start = instance.save()?;
    let (t0, first) = (instance.time, instance.motion(STEPS, 0)?);
    let in_between = instance.save()?;
    let (t1, second) = (instance.time, instance.motion(STEPS, STEPS)?);
    for (state, time, phase, expected) in [
        (at_start, t0, 0, &first),
        (in_between, t1, STEPS, &second),
        (at_start, t0, 0, &first),
    ] {
        instance.go_back(state, time)?;
        if instance.motion(STEPS, phase)? != *expected {
            outcome.fail(format!(
                "back at t = {time} s, the steps that follow give other numbers than before"
            ));
        }
    }
    instance.free(at_start)?;
    instance.free(in_between)?;
    instance.free(StateHandle::NULL)
}

fn serialize(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::started(fmu, "first")?;
    instance.motion(STEPS, 0)?;
    let (bytes, time) = (instance.bytes()?, instance.time);
    let expected = instance.motion(STEPS, STEPS)?;
    drop(instance); // it may be the only one that can be made
    outcome.note(format!("{} bytes", bytes.len()));
    let mut other = Instance::started(fmu, "other")?;
    let (status, state) = other.state_of(&bytes);
    other.must("fmi2DeSerializeFMUstate", status)?;
    other.go_back(state, time)?;
    if other.motion(STEPS, STEPS)? != expected {
        outcome.fail("another instance goes on with other numbers");
    }
    other.free(state)
}

fn damaged(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::started(fmu, "damaged")?;
    instance.motion(STEPS, 0)?;
    let whole = instance.bytes()?;
    let (half, mut flipped) = (whole[..whole.len() / 2].to_vec(), whole.clone());
    if let Some(byte) = flipped.get_mut(whole.len() / 3) {
        *byte ^= 0x10;
    }
    for (what, bytes) in [
        ("half of the bytes", half),
        ("bytes with one bit changed", flipped),
    ] {
        let (status, state) = instance.state_of(&bytes);
        if matches!(status, OK | WARNING) {
            outcome.remark(format!("fmi2DeSerializeFMUstate took {what}"));
            instance.free(state)?;
        }
    }
    // An error may end the simulation, by the standard.
    if let Err(reason) = instance.motion(STEPS, STEPS) {
        outcome.remark(format!("after that it does not go on: {reason}"));
    }
    Ok(())
}
