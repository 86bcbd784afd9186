//! Random calls in random order with random arguments: nothing crashes, and a refused call changes
//! nothing.

use crate::client::*;
use crate::vr;
use crate::xorshift::Random;
use fmu_export::ffi::EventInfo;
use std::ffi::{c_int, c_void};
use std::ptr;

impl Random {
    fn real(&mut self) -> f64 {
        self.of(&[
            0.0,
            1.0,
            -1.0,
            0.25,
            0.625,
            1e-320,
            1e300,
            f64::NAN,
            f64::INFINITY,
        ])
    }

    /// Numbers of the right length, most of the time, and sound ones.
    fn reals(&mut self) -> Vec<f64> {
        let n = self.of(&[4, 4, 4, 4, 0, 1, 3, 5]);
        let is_sound = self.below(3) > 0;
        (0..n)
            .map(|k| {
                if is_sound {
                    0.5 + k as f64
                } else {
                    self.real()
                }
            })
            .collect()
    }
}

/// One random call. A panic of the model is tested elsewhere: it ends an instance.
fn call(fmu: &Fmu, r: &mut Random, states: &mut Vec<*mut c_void>) -> c_int {
    let (c, x, any) = (fmu.c, r.reals(), r.real());
    let (n, mut out, mut out_of_one) = (x.len(), vec![0.0; x.len()], 0.0);
    let null = r.below(16) == 0;
    let to = if null {
        ptr::null_mut()
    } else {
        out.as_mut_ptr()
    };
    let one = if null {
        ptr::null_mut()
    } else {
        &raw mut out_of_one
    };
    let (mut flags, mut flags2) = ([false; 5], [0; 2]);
    let [a, b, d, e, g] = flags.each_mut();
    let vr = r.of(&[
        vr::WIND,
        vr::KICK,
        vr::POSITION,
        vr::ENERGY,
        vr::DER_VELOCITY,
        vr::FLOOR,
        vr::RESTITUTION,
        40,
    ]);
    let is_2 = fmu.version == 2;
    let either = |two: unsafe extern "C-unwind" fn(*mut c_void, *mut f64, usize) -> c_int,
                  three| {
        let f = if is_2 { two } else { three };
        unsafe { f(c, to, n) }
    };
    unsafe {
        match r.below(20) {
            0 if is_2 => fmi2EnterInitializationMode(c),
            0 => fmi3EnterInitializationMode(c, false, 0.0, any, r.below(2) == 0, 2.0),
            1 => fmu.call([fmi2ExitInitializationMode, fmi3ExitInitializationMode]),
            2 if r.below(6) == 0 => fmu.call([fmi2Terminate, fmi3Terminate]),
            3 if r.below(6) == 0 => fmu.call([fmi2Reset, fmi3Reset]),
            4 => fmu.call([fmi2EnterEventMode, fmi3EnterEventMode]),
            5 if is_2 => fmi2NewDiscreteStates(
                c,
                if null {
                    ptr::null_mut()
                } else {
                    &mut EventInfo::default()
                },
            ),
            5 => fmi3UpdateDiscreteStates(
                c,
                a,
                b,
                d,
                if null { ptr::null_mut() } else { e },
                g,
                &mut 0.0,
            ),
            6 | 7 => fmu.call([fmi2EnterContinuousTimeMode, fmi3EnterContinuousTimeMode]),
            8 if is_2 => fmi2CompletedIntegratorStep(
                c,
                1,
                &mut flags2[0],
                if null {
                    ptr::null_mut()
                } else {
                    &mut flags2[1]
                },
            ),
            8 => fmi3CompletedIntegratorStep(c, true, a, if null { ptr::null_mut() } else { b }),
            9 => fmu.set_time(any),
            10 => fmu.set_states(&x),
            11 => either(fmi2GetDerivatives, fmi3GetContinuousStateDerivatives),
            12 => either(fmi2GetEventIndicators, fmi3GetEventIndicators),
            13 => either(fmi2GetContinuousStates, fmi3GetContinuousStates),
            14 => either(
                fmi2GetNominalsOfContinuousStates,
                fmi3GetNominalsOfContinuousStates,
            ),
            15 => fmu.set(vr, &x[..n.min(2)]),
            16 if is_2 => fmi2GetDirectionalDerivative(c, &vr, 1, &8, 1, &any, one),
            16 => fmi3GetDirectionalDerivative(c, &vr, 1, &8, 1, x.as_ptr(), n.min(2), one, 1),
            17 => {
                states.push(fmu.save());
                0
            }
            18 if !states.is_empty() => fmu.restore(r.of(states)),
            _ => fmu.set_integer(vr::FAULT, r.of(&[0, 0, 1, 30, 31, -1])),
        }
    }
}

#[test]
fn a_refused_call_changes_nothing() {
    for version in [2, 3] {
        let (mut refused, mut counts) = (0, [0; 4]);
        for seed in 1..=40_u64 {
            let mut r = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let (mut fmu, mut states) = (Fmu::new(version), Vec::new());
            for _ in 0..500 {
                let before = fmu.bytes();
                let status = call(&fmu, &mut r, &mut states);
                counts[status as usize] += 1;
                if status == 0 {
                    continue;
                }
                refused += 1;
                assert!(fmu.bytes() == before, "seed {seed}: {}", fmu.last());
                if r.below(64) == 0 {
                    (fmu, states) = (Fmu::running(version), Vec::new());
                }
            }
        }
        // Most states are visited: a third and more of the calls succeed.
        assert!(
            refused > 5_000 && counts[0] > 5_000 && counts[2] > 50 && counts[1] == 0,
            "{counts:?}"
        );
    }
}
