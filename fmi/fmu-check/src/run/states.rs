//! Probes of saved states (restored, in another instance, damaged bytes), for `supervision`.

use anyhow::Result;

use super::instances::compare;
use super::probe::probes;
use crate::outcome::Outcome;
use fmi_import::raw::StateHandle;
use fmi_import::status::{OK, WARNING};
use fmi_import::{Fmu, Instance};

const STEPS: usize = 10;

probes! {
    "saved states" {
        opened restore.if_claimed(|c| c.saves_state):
            "a state that is set again leads to the same future, bit for bit, if canGetAndSetFMUstate",
            "iterating and error controlling importers go back and repeat a step [FMI 2.0, 2.1.8; FMI 3.0, 2.2.7.4]";
        opened serialize.if_claimed(|c| c.saves_state && c.serializes_state):
            "bytes of a state carry it to another instance, if canSerializeFMUstate",
            "long simulations are interrupted and go on in another process [FMI 2.0, 2.1.8; FMI 3.0, 2.2.7.4]";
        opened damaged.if_claimed(|c| c.saves_state && c.serializes_state):
            "damaged bytes are refused, if canSerializeFMUstate",
            "files get truncated, and a state made of half a file is wrong unnoticed";
    }
}

fn restore(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::started(fmu, "restore")?;
    let at_start = instance.save()?;
    let (t0, first) = (instance.time, instance.run_excited(STEPS, 0)?);
    let in_between = instance.save()?;
    let (t1, second) = (instance.time, instance.run_excited(STEPS, STEPS)?);
    for (state, time, phase, expected) in [
        (at_start, t0, 0, &first),
        (in_between, t1, STEPS, &second),
        (at_start, t0, 0, &first),
    ] {
        instance.go_back(state, time)?;
        let found = instance.run_excited(STEPS, phase)?;
        compare(
            expected,
            &found,
            &format!("after the state of {time} s is set"),
            outcome,
        );
    }
    instance.free(at_start)?;
    instance.free(in_between)?;
    instance.free(StateHandle::NULL)
}

fn serialize(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::started(fmu, "first")?;
    instance.run_excited(STEPS, 0)?;
    let (bytes, time) = (instance.bytes()?, instance.time);
    let expected = instance.run_excited(STEPS, STEPS)?;
    drop(instance); // the FMU may allow one instance only
    outcome.note(format!("{} bytes", bytes.len()));
    let mut other = Instance::started(fmu, "other")?;
    let (status, state) = other.state_from_bytes(&bytes);
    other.must("fmi2DeSerializeFMUstate", status)?;
    other.go_back(state, time)?;
    let found = other.run_excited(STEPS, STEPS)?;
    compare(&expected, &found, "in the other instance", outcome);
    other.free(state)
}

fn damaged(fmu: &Fmu, outcome: &mut Outcome) -> Result<()> {
    let mut instance = Instance::started(fmu, "damaged")?;
    instance.run_excited(STEPS, 0)?;
    let whole = instance.bytes()?;
    let (half, mut flipped) = (whole[..whole.len() / 2].to_vec(), whole.clone());
    if let Some(byte) = flipped.get_mut(whole.len() / 3) {
        *byte ^= 0x10;
    }
    for (what, bytes) in [
        ("half of the bytes", half),
        ("bytes with one bit changed", flipped),
    ] {
        let (status, state) = instance.state_from_bytes(&bytes);
        if matches!(status, OK | WARNING) {
            outcome.remark(format!("fmi2DeSerializeFMUstate took {what}"));
            instance.free(state)?;
        }
    }
    // By the standard, an error may end the simulation.
    if let Err(reason) = instance.run_excited(STEPS, STEPS) {
        outcome.remark(format!("after that it does not go on: {reason}"));
    }
    Ok(())
}
