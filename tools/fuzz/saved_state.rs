//! Serialized states with a right header and checksum but a damaged body: refused, or usable
//! without a crash or panic.
//!
//! A valid state is taken from the FMU and patched as the fuzzer says, so that small inputs reach
//! deep into large states.

use fmi_description::Description;
use fmu_export::Model;
use fmu_export::ffi::*;
use std::cell::RefCell;
use std::ffi::{CString, c_int};
use std::ptr;

#[rustfmt::skip]
unsafe extern "C" {
    fn fmi2Instantiate(name: Str, kind: c_int, guid: Str, resources: Str, functions: *const CallbackFunctions, visible: Boolean, on: Boolean) -> Component;
    fn fmi2FreeInstance(c: Component);
    fn fmi2EnterInitializationMode(c: Component) -> Status;
    fn fmi2ExitInitializationMode(c: Component) -> Status;
    fn fmi2Reset(c: Component) -> Status;
    fn fmi2GetReal(c: Component, vr: *const u32, n: usize, value: *mut Real) -> Status;
    fn fmi2GetRealStatus(c: Component, kind: c_int, value: *mut Real) -> Status;
    fn fmi2DoStep(c: Component, t: Real, h: Real, no_set_prior: Boolean) -> Status;
    fn fmi2GetFMUstate(c: Component, state: *mut FmuState) -> Status;
    fn fmi2SetFMUstate(c: Component, state: FmuState) -> Status;
    fn fmi2FreeFMUstate(c: Component, state: *mut FmuState) -> Status;
    fn fmi2SerializedFMUstateSize(c: Component, state: FmuState, size: *mut usize) -> Status;
    fn fmi2SerializeFMUstate(c: Component, state: FmuState, bytes: *mut Byte, size: usize) -> Status;
    fn fmi2DeSerializeFMUstate(c: Component, bytes: *const Byte, size: usize, state: *mut FmuState) -> Status;
}

/// Bytes before the body: magic, version, GUID, length, checksum.
const HEADER: usize = 40;
const LENGTH_AT: usize = 28;
const CRC_AT: usize = 36;

struct Target {
    c: Component,
    template: Vec<u8>,
}

thread_local! {
    static TARGET: RefCell<Option<Target>> = const { RefCell::new(None) };
}

impl Target {
    fn new<M: Model>() -> Self {
        let xml = fmu_export::model_description::<M>().expect("a table in order");
        let guid = Description::parse(&xml).expect("a description").guid;
        let guid = CString::new(guid).expect("no NUL");
        let callbacks = CallbackFunctions {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: ptr::null_mut(),
        };
        // SAFETY: valid arguments throughout.
        unsafe {
            let c = fmi2Instantiate(c"fuzz".as_ptr(), 1, guid.as_ptr(), ptr::null(), &callbacks, 0, 0);
            assert!(!c.is_null());
            assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
            assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
            let (mut state, mut size) = (ptr::null_mut(), 0);
            assert_eq!(fmi2GetFMUstate(c, &mut state), Status::Ok);
            assert_eq!(fmi2SerializedFMUstateSize(c, state, &mut size), Status::Ok);
            let mut template = vec![0_u8; size];
            assert_eq!(fmi2SerializeFMUstate(c, state, template.as_mut_ptr().cast(), size), Status::Ok);
            fmi2FreeFMUstate(c, &mut state);
            Self { c, template }
        }
    }

    /// Restores the bytes and works with them; false if the instance was lost by a panic.
    fn bear(&self, bytes: &[u8]) -> bool {
        let mut state = ptr::null_mut();
        let mut values = [0.0; 8];
        let references: [u32; 8] = std::array::from_fn(|k| 6 + k as u32);
        let mut t = 0.0;
        // SAFETY: a live instance, arrays of the lengths given, places for the results.
        let statuses = unsafe {
            if fmi2DeSerializeFMUstate(self.c, bytes.as_ptr().cast(), bytes.len(), &mut state) != Status::Ok {
                return true;
            }
            let restored = fmi2SetFMUstate(self.c, state);
            let inquired = fmi2GetRealStatus(self.c, LAST_SUCCESSFUL_TIME, &mut t);
            let stepped = fmi2DoStep(self.c, t, 1e-3, 0);
            let got = fmi2GetReal(self.c, references.as_ptr(), 8, values.as_mut_ptr());
            let freed = fmi2FreeFMUstate(self.c, &mut state);
            [restored, inquired, stepped, got, freed, fmi2Reset(self.c)]
        };
        assert!(values.iter().all(|v| v.is_finite()));
        !statuses.contains(&Status::Fatal)
    }
}

/// One input of the fuzzer.
pub fn run<M: Model>(data: &[u8]) {
    TARGET.with_borrow_mut(|target| {
        let target = target.get_or_insert_with(Target::new::<M>);
        let Some((&how, rest)) = data.split_first() else {
            return;
        };
        let mut bytes = target.template.clone();
        match how % 3 {
            0 => bytes = rest.to_vec(), // nothing is right
            1 => {
                bytes.truncate(HEADER);
                bytes.extend(rest);
            }
            _ => patch(&mut bytes, rest),
        }
        if how % 3 != 0 {
            seal(&mut bytes);
        }
        if !target.bear(&bytes) {
            // SAFETY: made above, not used afterwards.
            unsafe { fmi2FreeInstance(target.c) };
            panic!("a damaged state made the model panic");
        }
    });
}

/// Four bytes each: where (24 bits) and what; the place beyond the end cuts the state there.
fn patch(bytes: &mut Vec<u8>, patches: &[u8]) {
    for &[a, b, c, value] in patches.as_chunks::<4>().0 {
        let body = bytes.len() - HEADER;
        let at = usize::from(a) | usize::from(b) << 8 | usize::from(c & 0x7f) << 16;
        if body == 0 {
            return;
        }
        let at = HEADER + at % body;
        if c & 0x80 != 0 {
            bytes.truncate(at);
        } else {
            bytes[at] = value;
        }
    }
}

/// Length and checksum as they should be.
fn seal(bytes: &mut [u8]) {
    let length = (bytes.len() - HEADER) as u64;
    bytes[LENGTH_AT..CRC_AT].copy_from_slice(&length.to_le_bytes());
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&bytes[..CRC_AT]);
    hasher.update(&bytes[HEADER..]);
    let crc = hasher.finalize();
    bytes[CRC_AT..HEADER].copy_from_slice(&crc.to_le_bytes());
}
