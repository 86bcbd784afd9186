//! An importer of the rod, by the C functions of both versions. Each unsafe call gets an instance
//! that is live, and pointers that are valid for the number beside them.

#[path = "../border/client3/functions.rs"]
#[allow(dead_code)] // of the functions of FMI 3.0, these tests call some
mod functions;

use crate::rod::Rod;
use fmu_export::ffi::{CallbackFunctions, c_int};
use fmu_export::ffi3::{Instance, Str};
use std::ffi::{CStr, CString, c_void};
use std::ptr;
use std::sync::Mutex;

pub use fmu_export::ffi3::Status;
pub use functions::*;

/// Value references of the table, whatever the sizes are.
pub mod vr {
    pub const N: u32 = 0;
    pub const M: u32 = 1;
    pub const T_0: u32 = 3;
    pub const WEIGHTS: u32 = 4;
    pub const TABLE: u32 = 5;
    pub const MATRIX: u32 = 6;
    pub const FLAGS: u32 = 12;
    pub const COUNTS: u32 = 52;
    pub const R: [u32; 2] = [53, 54];
    pub const HEATING: u32 = 55;
    pub const SWITCHES: u32 = 56;
    pub const T: u32 = 57;
    pub const PAIRS: u32 = 58;
    pub const SHOWN: u32 = 59;
    pub const DER_T: u32 = 60;
}

/// The reference of an element of a long row in FMI 2.0.
pub fn element(row: u32, i: u32) -> u32 {
    ((row + 1) << 20) + i
}

pub struct Rod3 {
    pub c: Instance,
    log: Box<Mutex<Vec<String>>>,
}

unsafe extern "C-unwind" fn log(env: *mut c_void, _: Status, _: Str, text: Str) {
    // SAFETY: the environment is the log of the instance; the text is a C string.
    unsafe {
        let text = CStr::from_ptr(text).to_str().unwrap().to_owned();
        (*env.cast::<Mutex<Vec<String>>>())
            .lock()
            .unwrap()
            .push(text);
    }
}

fn token(xml: &str, name: &str) -> CString {
    let (_, rest) = xml.split_once(&format!("{name}=\"")).unwrap();
    CString::new(rest.split_once('"').unwrap().0).unwrap()
}

impl Rod3 {
    pub fn new() -> Self {
        Self::of(false)
    }

    /// For Co-Simulation or Model Exchange.
    pub fn of(is_exchange: bool) -> Self {
        let xml = fmu_export::model_description3::<Rod>().unwrap();
        let token = token(&xml, "instantiationToken");
        let log_to = Box::new(Mutex::new(Vec::new()));
        let env = ptr::from_ref(&*log_to).cast_mut().cast();
        let (name, token, none) = (c"rod".as_ptr(), token.as_ptr(), ptr::null());
        let c = unsafe {
            match is_exchange {
                true => fmi3InstantiateModelExchange(name, token, none, 0, 1, env, Some(log)),
                false => fmi3InstantiateCoSimulation(
                    name,
                    token,
                    none,
                    0,
                    1,
                    0,
                    0,
                    ptr::null(),
                    0,
                    env,
                    Some(log),
                    None,
                ),
            }
        };
        assert!(!c.is_null(), "{:?}", log_to.lock().unwrap());
        Self { c, log: log_to }
    }

    /// With `n` cells, for Co-Simulation.
    pub fn sized(n: u64) -> Self {
        Self::new().with(n)
    }

    pub fn with(self, n: u64) -> Self {
        let fmu = self;
        fmu.ok(unsafe { fmi3EnterConfigurationMode(fmu.c) });
        fmu.ok(fmu.set_size(vr::N, n));
        fmu.ok(unsafe { fmi3ExitConfigurationMode(fmu.c) });
        fmu
    }

    /// The last message.
    pub fn said(&self) -> String {
        self.log.lock().unwrap().last().cloned().unwrap_or_default()
    }

    pub fn ok(&self, status: Status) {
        assert_eq!(status, Status::Ok, "{}", self.said());
    }

    pub fn set_size(&self, vr: u32, n: u64) -> Status {
        unsafe { fmi3SetUInt64(self.c, &vr, 1, &n, 1) }
    }

    pub fn size(&self, vr: u32) -> u64 {
        let mut n = 0;
        self.ok(unsafe { fmi3GetUInt64(self.c, &vr, 1, &mut n, 1) });
        n
    }

    pub fn set(&self, vr: u32, values: &[f64]) -> Status {
        unsafe { fmi3SetFloat64(self.c, &vr, 1, values.as_ptr(), values.len()) }
    }

    pub fn try_get(&self, vr: u32, values: &mut [f64]) -> Status {
        unsafe { fmi3GetFloat64(self.c, &vr, 1, values.as_mut_ptr(), values.len()) }
    }

    pub fn get(&self, vr: u32, n: usize) -> Vec<f64> {
        let mut values = vec![f64::NAN; n];
        self.ok(self.try_get(vr, &mut values));
        values
    }

    pub fn set_whole(&self, vr: u32, values: &[i32]) -> Status {
        unsafe { fmi3SetInt32(self.c, &vr, 1, values.as_ptr(), values.len()) }
    }

    pub fn try_get_whole(&self, vr: u32, values: &mut [i32]) -> Status {
        unsafe { fmi3GetInt32(self.c, &vr, 1, values.as_mut_ptr(), values.len()) }
    }

    pub fn start(&self) {
        self.ok(unsafe { fmi3EnterInitializationMode(self.c, 0, 0.0, 0.0, 0, 0.0) });
        self.ok(unsafe { fmi3ExitInitializationMode(self.c) });
    }

    pub fn step(&self, t: f64, h: f64) {
        let (mut flags, mut last) = ([0; 3], 0.0);
        let [a, b, c] = &mut flags;
        self.ok(unsafe { fmi3DoStep(self.c, t, h, 1, a, b, c, &mut last) });
    }

    pub fn save(&self) -> *mut c_void {
        let mut state = ptr::null_mut();
        self.ok(unsafe { fmi3GetFMUState(self.c, &mut state) });
        state
    }

    pub fn restore(&self, state: *mut c_void) {
        self.ok(unsafe { fmi3SetFMUState(self.c, state) });
    }

    pub fn bytes(&self, state: *mut c_void) -> Vec<u8> {
        let mut size = 0;
        self.ok(unsafe { fmi3SerializedFMUStateSize(self.c, state, &mut size) });
        let mut bytes = vec![0; size];
        self.ok(unsafe { fmi3SerializeFMUState(self.c, state, bytes.as_mut_ptr(), size) });
        bytes
    }

    pub fn state(&self, bytes: &[u8]) -> *mut c_void {
        let mut state = ptr::null_mut();
        self.ok(unsafe {
            fmi3DeserializeFMUState(self.c, bytes.as_ptr(), bytes.len(), &mut state)
        });
        state
    }
}

impl Drop for Rod3 {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.c) }
    }
}

type Status2 = fmu_export::ffi::Status;

unsafe extern "C-unwind" {
    fn fmi2Instantiate(
        name: Str,
        kind: c_int,
        guid: Str,
        resources: Str,
        functions: *const CallbackFunctions,
        visible: c_int,
        on: c_int,
    ) -> *mut c_void;
    fn fmi2FreeInstance(c: *mut c_void);
    fn fmi2EnterInitializationMode(c: *mut c_void) -> Status2;
    fn fmi2ExitInitializationMode(c: *mut c_void) -> Status2;
    fn fmi2SetReal(c: *mut c_void, vr: *const u32, n: usize, values: *const f64) -> Status2;
    fn fmi2GetReal(c: *mut c_void, vr: *const u32, n: usize, values: *mut f64) -> Status2;
    fn fmi2SetInteger(c: *mut c_void, vr: *const u32, n: usize, values: *const c_int) -> Status2;
    fn fmi2DoStep(c: *mut c_void, t: f64, h: f64, no_set_prior: c_int) -> Status2;
}

pub struct Rod2(*mut c_void);

impl Rod2 {
    pub fn new() -> Self {
        let xml = fmu_export::model_description::<Rod>().unwrap();
        let guid = token(&xml, "guid");
        let functions = CallbackFunctions {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: ptr::null_mut(),
        };
        let (name, none) = (c"rod".as_ptr(), ptr::null());
        let c = unsafe { fmi2Instantiate(name, 1, guid.as_ptr(), none, &functions, 0, 0) };
        assert!(!c.is_null());
        Self(c)
    }

    pub fn initialize(&self) {
        assert_eq!(unsafe { fmi2EnterInitializationMode(self.0) }, Status2::Ok);
    }

    pub fn start(&self) {
        assert_eq!(unsafe { fmi2ExitInitializationMode(self.0) }, Status2::Ok);
    }

    pub fn set(&self, vr: &[u32], values: &[f64]) -> Status2 {
        unsafe { fmi2SetReal(self.0, vr.as_ptr(), vr.len(), values.as_ptr()) }
    }

    pub fn set_integer(&self, vr: u32, value: i32) -> Status2 {
        unsafe { fmi2SetInteger(self.0, &vr, 1, &value) }
    }

    pub fn get(&self, vr: &[u32]) -> Vec<f64> {
        let mut values = vec![f64::NAN; vr.len()];
        let status = unsafe { fmi2GetReal(self.0, vr.as_ptr(), vr.len(), values.as_mut_ptr()) };
        assert_eq!(status, Status2::Ok);
        values
    }

    pub fn step(&self, t: f64, h: f64) {
        assert_eq!(unsafe { fmi2DoStep(self.0, t, h, 1) }, Status2::Ok);
    }
}

impl Drop for Rod2 {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.0) }
    }
}
