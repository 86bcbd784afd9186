//! Saved states.

use crate::client::*;
use crate::probe::vr;
use fmu_export::ffi::*;
use std::ptr;

/// Steps four times with numbers that round, and returns the bits of all outputs on the way.
fn go_on(fmu: &Fmu, k0: u32) -> Vec<u64> {
    let mut bits = Vec::new();
    for k in k0..k0 + 4 {
        let u = (f64::from(k) * 0.7).sin();
        assert_eq!(fmu.set(&[vr::U[0], vr::U[1]], &[u, u * u]), Status::Ok);
        assert_eq!(
            fmu.step(f64::from(k) * 0.1, 0.1),
            Status::Ok,
            "{:?}",
            fmu.messages()
        );
        bits.extend(fmu.get([vr::X[0], vr::X[1], vr::Y]).map(f64::to_bits));
    }
    bits
}

#[test]
fn a_restored_state_continues_bit_for_bit() {
    let fmu = Fmu::stepping();
    go_on(&fmu, 0);
    let state = fmu.save();
    let expected = go_on(&fmu, 4);
    assert_eq!(fmu.restore(state), Status::Ok);
    assert_eq!(fmu.last_time(), 3.0 * 0.1 + 0.1);
    assert_eq!(go_on(&fmu, 4), expected);
    // Also through bytes, straight into a fresh instance, whatever its mode.
    let bytes = fmu.serialize(state);
    for fresh in [Fmu::instantiated(), Fmu::initializing(), Fmu::stepping()] {
        let (status, copy) = fresh.deserialize(&bytes);
        assert_eq!((status, fresh.restore(copy)), (Status::Ok, Status::Ok));
        assert_eq!(go_on(&fresh, 4), expected);
        assert_eq!(fresh.serialize(copy), bytes);
    }
}

#[test]
fn a_state_holds_mode_parameters_and_pending_derivatives() {
    let fmu = Fmu::initializing();
    assert_eq!(fmu.set(&[vr::RATE[0]], &[2.0]), Status::Ok);
    assert_eq!(fmu.derivatives(&[vr::U[0]], &[1], &[8.0]), Status::Ok);
    let bytes = fmu.serialize(fmu.save());
    let fresh = Fmu::instantiated();
    assert_eq!(fresh.restore(fresh.deserialize(&bytes).1), Status::Ok);
    assert_eq!(fresh.set_string(vr::FILE, c"1"), Status::Ok); // rate[1] counts as set by hand
    fresh.start(); // it was in Initialization Mode
    assert_eq!(fresh.step(0.0, 1.0), Status::Ok);
    assert_eq!(fresh.get([vr::X[0], vr::RATE[1]]), [2.0 + 8.0 / 2.0, 8.5]);
}

#[test]
fn an_existing_state_is_overwritten() {
    let fmu = Fmu::stepping();
    let mut state = fmu.save();
    let old = state;
    assert_eq!(fmu.step(0.0, 0.5), Status::Ok);
    // SAFETY: a live instance and one of its handles.
    assert_eq!(unsafe { fmi2GetFMUstate(fmu.c, &mut state) }, Status::Ok);
    assert_eq!(state, old);
    assert_eq!(fmu.call(fmi2Reset), Status::Ok);
    assert_eq!(fmu.restore(state), Status::Ok);
    assert_eq!(fmu.last_time(), 0.5);
    assert_eq!(fmu.free(&mut state), Status::Ok);
    assert!(state.is_null());
    assert_eq!(fmu.free(&mut state), Status::Ok);
}

#[test]
fn freed_foreign_and_invented_states_are_refused() {
    let (fmu, other) = (Fmu::stepping(), Fmu::stepping());
    let freed = {
        let mut state = fmu.save();
        let copy = state;
        assert_eq!(fmu.free(&mut state), Status::Ok);
        copy
    };
    let invented = ptr::without_provenance_mut(0xdead_beef);
    for mut state in [freed, other.save(), invented] {
        let before = fmu.snapshot();
        assert_eq!(fmu.restore(state), Status::Error);
        assert_eq!(fmu.free(&mut state), Status::Error);
        // SAFETY: the handle is only looked up.
        unsafe {
            assert_eq!(fmi2GetFMUstate(fmu.c, &mut state), Status::Error);
            assert_eq!(
                fmi2SerializedFMUstateSize(fmu.c, state, &mut 0),
                Status::Error
            );
        }
        let text = fmu.last().text;
        assert!(
            text.contains(&format!(
                "state {} is not a saved state of this instance",
                state.addr()
            )),
            "{text}"
        );
        assert_eq!(fmu.snapshot(), before);
    }
    assert_eq!(fmu.restore(ptr::null_mut()), Status::Error);
}

/// Of the bytes of a state, each is tried; under Miri some of each part.
pub const STRIDE: usize = if cfg!(miri) { 5 } else { 1 };

#[test]
fn foreign_truncated_and_damaged_bytes_are_refused() {
    let fmu = Fmu::stepping();
    let bytes = fmu.serialize(fmu.save());
    let mut damaged: Vec<(Vec<u8>, &str)> = vec![
        (vec![], "0 bytes; it must have at least 44"),
        (
            b"something that is not a state at all, but long enough".to_vec(),
            "does not start with `fmu-exp`",
        ),
    ];
    damaged.extend((0..bytes.len()).step_by(STRIDE).map(|n| {
        (
            bytes[..n].to_vec(),
            if n < 44 {
                "it must have at least 44"
            } else {
                "truncated"
            },
        )
    }));
    for i in (0..bytes.len()).step_by(STRIDE) {
        for bit in [0, 7] {
            let mut copy = bytes.clone();
            copy[i] ^= 1 << bit;
            let text = match i {
                0..8 => "does not start with",
                8..12 => "format version",
                12..16 => "is of an instance of FMI",
                16..32 => "is of the model {",
                32..40 => "", // the length: truncated or damaged
                _ => "damaged: checksum",
            };
            damaged.push((copy, text));
        }
    }
    for (bytes, text) in damaged {
        let (status, state) = fmu.deserialize(&bytes);
        assert_eq!(status, Status::Error);
        assert!(state.is_null());
        assert!(
            fmu.last().text.contains(text),
            "{} lacks {text}",
            fmu.last().text
        );
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert_eq!(fmu.deserialize(&longer).0, Status::Ok);
}

/// The bytes after a change, with the length (32..40) and the CRC-32 of all the rest (40..44) put
/// right.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let length = (bytes.len() - 44) as u64;
    bytes[32..40].copy_from_slice(&length.to_le_bytes());
    let crc = crc32fast::hash(&[&bytes[..40], &bytes[44..]].concat());
    bytes[40..44].copy_from_slice(&crc.to_le_bytes());
    bytes
}

/// Bytes that are whole, but hold what no instance can hold. Places in `postcard`: phase (44),
/// start, stop, time (54..62), 29 bytes of parameters, the number of elements (91) and what was set
/// of each; at the end the order of the input derivatives, no held inputs, no model and no clocks.
#[test]
fn whole_bytes_of_an_impossible_state_are_refused() {
    let fmu = Fmu::instantiated();
    let bytes = fmu.serialize(fmu.save());
    let end = bytes.len();
    assert_eq!((bytes[44], u32::from(bytes[108])), (0, vr::COUNT));
    assert_eq!(bytes[end - 4..], [0; 4]);
    let changed = |change: fn(&mut Vec<u8>)| {
        let mut copy = bytes.clone();
        change(&mut copy);
        let (status, state) = fmu.deserialize(&sealed(copy));
        assert_eq!(status == Status::Ok, !state.is_null());
        status
    };
    let possible: [fn(&mut Vec<u8>); 4] = [
        |_| {},
        |b| b[54..62].copy_from_slice(&0.25_f64.to_le_bytes()),
        |b| b[44] = 1, // Initialization Mode needs no model
        |b| *b.iter_mut().nth_back(3).unwrap() = 3,
    ];
    for (i, change) in possible.into_iter().enumerate() {
        assert_eq!(changed(change), Status::Ok, "{i}");
    }
    let impossible: [fn(&mut Vec<u8>); 6] = [
        |b| b[54..62].copy_from_slice(&f64::NAN.to_le_bytes()),
        |b| b[54..62].copy_from_slice(&f64::INFINITY.to_le_bytes()),
        |b| b[44] = 2,                              // stepping, without a model
        |b| b[44] = 3,                              // terminated, without a model
        |b| *b.iter_mut().nth_back(3).unwrap() = 4, // an order that there is not
        |b| {
            b[108] -= 1;
            b.remove(109); // an element too few
        },
    ];
    for (i, change) in impossible.into_iter().enumerate() {
        assert_eq!(changed(change), Status::Error, "{i}");
        let text = fmu.last().text;
        assert!(
            text.contains("does not fit this version of the model"),
            "{text}"
        );
    }
}

#[test]
fn a_buffer_that_is_too_small_is_refused() {
    let fmu = Fmu::stepping();
    let state = fmu.save();
    let needed = fmu.serialize(state).len();
    let mut bytes = vec![0; needed + 3];
    for size in [0, 1, needed - 1] {
        // SAFETY: the buffer has more than `size` bytes.
        let status = unsafe { fmi2SerializeFMUstate(fmu.c, state, bytes.as_mut_ptr(), size) };
        assert_eq!(status, Status::Error);
        assert!(
            fmu.last()
                .text
                .contains(&format!("size = {size} must be at least {needed} bytes"))
        );
    }
    // SAFETY: the buffer has that size.
    assert_eq!(
        unsafe { fmi2SerializeFMUstate(fmu.c, state, bytes.as_mut_ptr(), bytes.len()) },
        Status::Ok
    );
}

/// States left behind go with the instance (the leak shows under valgrind, the crash here).
#[test]
fn states_may_be_left_to_the_instance() {
    let fmu = Fmu::stepping();
    let states: Vec<_> = (0..100).map(|_| fmu.save()).collect();
    assert_eq!(
        states
            .iter()
            .collect::<std::collections::BTreeSet<_>>()
            .len(),
        100
    );
}
