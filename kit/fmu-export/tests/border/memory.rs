//! Memory of the importer: anywhere, uninitialised, the same for several arguments.

use crate::client::*;
use crate::probe::vr;
use fmu_export::ffi::*;
use std::mem::MaybeUninit;
use std::ptr;

/// On 32-bit platforms compilers put numbers of eight bytes at multiples of four.
#[test]
fn arrays_need_no_alignment() {
    let fmu = Fmu::stepping();
    let mut bytes = [0_u8; 64];
    let start = bytes.as_mut_ptr();
    for offset in 1..8 {
        let (vr_at, value_at) = (start.wrapping_add(offset), start.wrapping_add(offset + 16));
        let (references, values) = (vr_at.cast::<u32>(), value_at.cast::<f64>());
        // SAFETY: two elements each within `bytes`, written and read unaligned.
        unsafe {
            references.cast::<[u32; 2]>().write_unaligned(vr::U);
            values
                .cast::<[f64; 2]>()
                .write_unaligned([1.5, offset as f64]);
            assert_eq!(fmi2SetReal(fmu.c, references, 2, values), Status::Ok);
            values.cast::<[f64; 2]>().write_unaligned([0.0; 2]);
            assert_eq!(fmi2GetReal(fmu.c, references, 2, values), Status::Ok);
            let read = values.cast::<[f64; 2]>().read_unaligned();
            assert_eq!(read, [1.5, offset as f64]);
            let handle = vr_at.cast::<FmuState>();
            handle.write_unaligned(ptr::null_mut());
            assert_eq!(fmi2GetFMUstate(fmu.c, handle), Status::Ok);
            assert_eq!(fmi2FreeFMUstate(fmu.c, handle), Status::Ok);
            assert!(handle.read_unaligned().is_null());
        }
    }
}

/// Results are written without a look at what was there, which Miri and valgrind would see.
#[test]
fn places_for_results_may_be_uninitialised() {
    let fmu = Fmu::stepping();
    let mut values = [const { MaybeUninit::<f64>::uninit() }; 2];
    let mut status = MaybeUninit::<Status>::uninit();
    // SAFETY: places for the results, read after they were written.
    unsafe {
        let to = values.as_mut_ptr().cast();
        assert_eq!(fmi2GetReal(fmu.c, vr::X.as_ptr(), 2, to), Status::Ok);
        assert_eq!(values.map(|value| value.assume_init()), [0.0, 0.25]);
        assert_eq!(
            fmi2GetStatus(fmu.c, DO_STEP_STATUS, status.as_mut_ptr()),
            Status::Ok
        );
        assert_eq!(status.assume_init(), Status::Ok);
    }
}

/// Seeds and results in one buffer: all seeds are read before a result is written.
#[test]
fn seeds_and_results_may_share_a_buffer() {
    let fmu = Fmu::stepping();
    let (unknown, known) = ([vr::X[0], vr::Y], [vr::U[1], vr::U[0]]);
    let mut buffer = [2.5, 7.0];
    let at = buffer.as_mut_ptr();
    // SAFETY: two elements in each array.
    let status = unsafe {
        fmi2GetDirectionalDerivative(fmu.c, unknown.as_ptr(), 2, known.as_ptr(), 2, at, at)
    };
    assert_eq!((status, buffer), (Status::Ok, [0.0, 2.5]));
}
