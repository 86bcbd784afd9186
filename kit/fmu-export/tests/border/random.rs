//! Random calls in random order with random arguments: nothing crashes, and a refused call changes
//! nothing.

use crate::client::*;
use crate::xorshift::Random;
use fmu_export::ffi::*;
use std::ptr;

impl Random {
    fn real(&mut self) -> f64 {
        self.of(&[
            0.0,
            1.0,
            -1.0,
            0.5,
            9.0,
            1e-320,
            1e300,
            -1e300,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
        ])
    }

    fn integer(&mut self) -> i32 {
        self.of(&[0, 1, 2, 3, 5, 6, 7, -3, i32::MIN, i32::MAX])
    }

    /// Value references, most of them known; 19 and up are not.
    fn references(&mut self) -> Vec<u32> {
        (0..self.below(4)).map(|_| self.below(20) as u32).collect()
    }
}

/// One random call. Panics of the model (faults 1 and 4) are tested elsewhere: they end an
/// instance.
fn call(fmu: &Fmu, r: &mut Random, states: &mut Vec<FmuState>) -> Status {
    let c = fmu.c;
    let vr = r.references();
    let n = vr.len();
    let reals: Vec<f64> = (0..n).map(|_| r.real()).collect();
    let integers: Vec<i32> = (0..n)
        .map(|_| r.integer())
        .filter(|i| *i != 1 && *i != 4)
        .collect();
    let state = if states.is_empty() {
        ptr::null_mut()
    } else {
        r.of(states)
    };
    let mut out = vec![0.0; n];
    let (t, any) = (fmu.time(), r.real());
    // SAFETY: arrays have the lengths given or are NULL; handles are only looked up.
    unsafe {
        match r.below(24) {
            0 => fmi2SetupExperiment(c, r.integer(), r.real(), r.real(), r.integer(), r.real()),
            1 => fmi2EnterInitializationMode(c),
            2 => fmi2ExitInitializationMode(c),
            3 if r.below(4) == 0 => fmi2Terminate(c),
            4 if r.below(4) == 0 => fmi2Reset(c),
            5 => fmi2SetReal(c, vr.as_ptr(), n, reals.as_ptr()),
            6 => fmi2SetReal(c, vr.as_ptr(), n, ptr::null()),
            7 => fmi2SetInteger(c, vr.as_ptr(), integers.len(), integers.as_ptr()),
            8 => fmi2SetBoolean(c, vr.as_ptr(), integers.len(), integers.as_ptr()),
            9 => fmu.set_string(r.of(&[6, 6, 3, 40]), r.of(&[c"3", c"", c"x", c"\xff"])),
            10 => fmi2GetReal(c, vr.as_ptr(), n, out.as_mut_ptr()),
            11 => fmi2GetInteger(c, vr.as_ptr(), n, vec![0; n].as_mut_ptr()),
            12 => fmi2GetBoolean(c, vr.as_ptr(), n, vec![0; n].as_mut_ptr()),
            13 => fmi2GetString(c, vr.as_ptr(), n, vec![ptr::null(); n].as_mut_ptr()),
            14 => {
                states.push(fmu.save());
                Status::Ok
            }
            15 => fmi2SetFMUstate(c, state),
            16 => fmi2FreeFMUstate(c, &mut { state }),
            17 => {
                let mut bytes = fmu.snapshot();
                let at = r.below(bytes.len());
                bytes[at] ^= r.below(2) as u8;
                let (status, state) = fmu.deserialize(&bytes[..bytes.len() - r.below(2)]);
                states.push(state);
                status
            }
            18 => fmi2SetRealInputDerivatives(
                c,
                vr.as_ptr(),
                integers.len(),
                integers.as_ptr(),
                reals.as_ptr(),
            ),
            19 => fmi2GetRealOutputDerivatives(
                c,
                vr.as_ptr(),
                integers.len(),
                integers.as_ptr(),
                out.as_mut_ptr(),
            ),
            20 => fmi2GetDirectionalDerivative(
                c,
                vr.as_ptr(),
                n,
                vr.as_ptr(),
                n,
                reals.as_ptr(),
                out.as_mut_ptr(),
            ),
            21 => fmi2GetRealStatus(c, r.integer(), &mut 0.0),
            _ => fmi2DoStep(
                c,
                r.of(&[t, t, t, 0.0, any]),
                r.of(&[0.1, 0.1, 1.0, any]),
                0,
            ),
        }
    }
}

impl Fmu {
    /// Time of the instance, or 0 where it does not tell.
    fn time(&self) -> f64 {
        let mut t = 0.0;
        // SAFETY: a live instance, a place.
        unsafe { fmi2GetRealStatus(self.c, LAST_SUCCESSFUL_TIME, &mut t) };
        t
    }
}

#[test]
fn random_calls_do_no_harm() {
    const SEEDS: u64 = if cfg!(miri) { 2 } else { 200 };
    const CALLS: u64 = if cfg!(miri) { 60 } else { 300 };
    let (mut accepted, mut refused) = (0, 0);
    for seed in 1..=SEEDS {
        let (mut r, mut states) = (Random(0x9e37_79b9_7f4a_7c15 ^ seed), Vec::new());
        let fmu = if seed % 2 == 0 {
            Fmu::stepping()
        } else {
            Fmu::instantiated()
        };
        for k in 0..CALLS {
            let before = fmu.snapshot();
            match call(&fmu, &mut r, &mut states) {
                Status::Ok => accepted += 1,
                Status::Error | Status::Discard => {
                    refused += 1;
                    assert_eq!(
                        fmu.snapshot(),
                        before,
                        "seed {seed}, call {k}: {:?}",
                        fmu.last()
                    );
                }
                status => panic!("seed {seed}, call {k}: {status:?}, {:?}", fmu.last()),
            }
        }
    }
    assert!(
        6 * accepted.min(refused) > CALLS * SEEDS,
        "{accepted} accepted, {refused} refused"
    );
}
