//! An importer: the C functions by their C names, and an instance with a log.

use crate::probe::Probe;
use crate::states::saved_states;
use fmu_export::ffi::*;
use std::ffi::{CStr, CString, c_int, c_void};
use std::ptr;
use std::sync::{Arc, Mutex, OnceLock};

#[rustfmt::skip]
unsafe extern "C-unwind" {
    pub safe fn fmi2GetTypesPlatform() -> Str;
    pub safe fn fmi2GetVersion() -> Str;
    pub fn fmi2Instantiate(name: Str, kind: c_int, guid: Str, resources: Str, functions: *const CallbackFunctions, visible: Boolean, on: Boolean) -> Component;
    pub fn fmi2FreeInstance(c: Component);
    pub fn fmi2SetDebugLogging(c: Component, on: Boolean, n: usize, categories: *const Str) -> Status;
    pub fn fmi2SetupExperiment(c: Component, tolerance_defined: Boolean, tolerance: Real, start: Real, stop_defined: Boolean, stop: Real) -> Status;
    pub fn fmi2EnterInitializationMode(c: Component) -> Status;
    pub fn fmi2ExitInitializationMode(c: Component) -> Status;
    pub fn fmi2Terminate(c: Component) -> Status;
    pub fn fmi2Reset(c: Component) -> Status;
    pub fn fmi2GetReal(c: Component, vr: *const u32, n: usize, value: *mut Real) -> Status;
    pub fn fmi2GetInteger(c: Component, vr: *const u32, n: usize, value: *mut Integer) -> Status;
    pub fn fmi2GetBoolean(c: Component, vr: *const u32, n: usize, value: *mut Boolean) -> Status;
    pub fn fmi2GetString(c: Component, vr: *const u32, n: usize, value: *mut Str) -> Status;
    pub fn fmi2SetReal(c: Component, vr: *const u32, n: usize, value: *const Real) -> Status;
    pub fn fmi2SetInteger(c: Component, vr: *const u32, n: usize, value: *const Integer) -> Status;
    pub fn fmi2SetBoolean(c: Component, vr: *const u32, n: usize, value: *const Boolean) -> Status;
    pub fn fmi2SetString(c: Component, vr: *const u32, n: usize, value: *const Str) -> Status;
    pub fn fmi2GetFMUstate(c: Component, state: *mut FmuState) -> Status;
    pub fn fmi2SetFMUstate(c: Component, state: FmuState) -> Status;
    pub fn fmi2FreeFMUstate(c: Component, state: *mut FmuState) -> Status;
    pub fn fmi2SerializedFMUstateSize(c: Component, state: FmuState, size: *mut usize) -> Status;
    pub fn fmi2SerializeFMUstate(c: Component, state: FmuState, bytes: *mut Byte, size: usize) -> Status;
    pub fn fmi2DeSerializeFMUstate(c: Component, bytes: *const Byte, size: usize, state: *mut FmuState) -> Status;
    pub fn fmi2GetDirectionalDerivative(c: Component, unknown: *const u32, n_unknown: usize, known: *const u32, n_known: usize, seed: *const Real, result: *mut Real) -> Status;
    pub fn fmi2SetRealInputDerivatives(c: Component, vr: *const u32, n: usize, order: *const Integer, value: *const Real) -> Status;
    pub fn fmi2GetRealOutputDerivatives(c: Component, vr: *const u32, n: usize, order: *const Integer, value: *mut Real) -> Status;
    pub fn fmi2DoStep(c: Component, t: Real, h: Real, no_set_prior: Boolean) -> Status;
    pub fn fmi2CancelStep(c: Component) -> Status;
    pub fn fmi2GetStatus(c: Component, kind: c_int, value: *mut Status) -> Status;
    pub fn fmi2GetRealStatus(c: Component, kind: c_int, value: *mut Real) -> Status;
    pub fn fmi2GetIntegerStatus(c: Component, kind: c_int, value: *mut Integer) -> Status;
    pub fn fmi2GetBooleanStatus(c: Component, kind: c_int, value: *mut Boolean) -> Status;
    pub fn fmi2GetStringStatus(c: Component, kind: c_int, value: *mut Str) -> Status;
    pub fn fmi2ExportFiles(context: *mut c_void, receive: Option<ReceiveFile>) -> c_int;
}

/// A message as the logger got it.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    pub name: String,
    pub status: Status,
    pub category: String,
    /// As it came: a format without arguments.
    pub format: String,
    /// What it prints.
    pub text: String,
}

/// The logger without arguments after the format.
type Fixed = unsafe extern "C-unwind" fn(ComponentEnvironment, Str, Status, Str, Str);

unsafe extern "C-unwind" fn logger(
    env: ComponentEnvironment,
    name: Str,
    status: Status,
    category: Str,
    format: Str,
) {
    // SAFETY: the environment is the log of the instance; all strings are C strings.
    unsafe {
        let string = |s: Str| CStr::from_ptr(s).to_str().unwrap().to_owned();
        let message = Message {
            name: string(name),
            status,
            category: string(category),
            format: string(format),
            text: string(format).replace("%%", "%").replace("##", "#"),
        };
        (*env.cast::<Mutex<Vec<Message>>>())
            .lock()
            .unwrap()
            .push(message);
    }
}

/// Callbacks that log into `log`. A variadic call with pointers only equals a plain one on the
/// platforms we test on.
pub fn callbacks(log: &Mutex<Vec<Message>>) -> CallbackFunctions {
    CallbackFunctions {
        // SAFETY: see above.
        logger: Some(unsafe { std::mem::transmute::<Fixed, CallbackLogger>(logger) }),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: ptr::from_ref(log).cast_mut().cast(),
    }
}

/// The GUID, read from the model description, once.
pub fn guid() -> &'static CStr {
    static GUID: OnceLock<CString> = OnceLock::new();
    GUID.get_or_init(|| {
        let xml = fmu_export::model_description::<Probe>().unwrap();
        let (_, rest) = xml.split_once("guid=\"").unwrap();
        CString::new(rest.split_once('"').unwrap().0).unwrap()
    })
}

/// An instance with its log.
pub struct Fmu {
    pub c: Component,
    /// Shared, not boxed: a box that is moved would invalidate the pointer that the logger has.
    pub log: Arc<Mutex<Vec<Message>>>,
}

/// Every call goes to the C functions with pointers that are valid for the slices they come from.
impl Fmu {
    pub fn instantiated() -> Self {
        Self::with(callbacks, c"file:///tmp/a%20b/", true)
    }

    pub fn with(
        callbacks: impl Fn(&Mutex<Vec<Message>>) -> CallbackFunctions,
        resources: &CStr,
        on: bool,
    ) -> Self {
        let log = Arc::new(Mutex::new(Vec::new()));
        let (functions, guid) = (callbacks(&log), guid());
        // SAFETY: valid strings and callbacks.
        let c = unsafe {
            fmi2Instantiate(
                c"probe 1".as_ptr(),
                1,
                guid.as_ptr(),
                resources.as_ptr(),
                &functions,
                0,
                on.into(),
            )
        };
        assert!(!c.is_null(), "{:?}", log.lock().unwrap());
        Self { c, log }
    }

    pub fn initializing() -> Self {
        let fmu = Self::instantiated();
        fmu.setup(0.0, None);
        assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
        fmu
    }

    pub fn stepping() -> Self {
        let fmu = Self::initializing();
        fmu.start();
        fmu
    }

    pub fn start(&self) {
        assert_eq!(
            self.call(fmi2ExitInitializationMode),
            Status::Ok,
            "{:?}",
            self.messages()
        );
    }

    pub fn call(&self, function: unsafe extern "C-unwind" fn(Component) -> Status) -> Status {
        // SAFETY: a live instance.
        unsafe { function(self.c) }
    }

    pub fn setup(&self, start: f64, stop: Option<f64>) {
        // SAFETY: a live instance.
        let status = unsafe {
            fmi2SetupExperiment(
                self.c,
                0,
                0.0,
                start,
                stop.is_some().into(),
                stop.unwrap_or(0.0),
            )
        };
        assert_eq!(status, Status::Ok, "{:?}", self.messages());
    }

    pub fn set(&self, vr: &[u32], values: &[f64]) -> Status {
        assert_eq!(vr.len(), values.len());
        // SAFETY: live instance, slices of equal length.
        unsafe { fmi2SetReal(self.c, vr.as_ptr(), vr.len(), values.as_ptr()) }
    }

    pub fn set_integer(&self, vr: u32, value: i32) -> Status {
        // SAFETY: live instance, one element each.
        unsafe { fmi2SetInteger(self.c, &vr, 1, &value) }
    }

    pub fn set_boolean(&self, vr: u32, value: i32) -> Status {
        // SAFETY: live instance, one element each.
        unsafe { fmi2SetBoolean(self.c, &vr, 1, &value) }
    }

    pub fn set_string(&self, vr: u32, value: &CStr) -> Status {
        // SAFETY: live instance, one element each.
        unsafe { fmi2SetString(self.c, &vr, 1, &value.as_ptr()) }
    }

    pub fn get<const N: usize>(&self, vr: [u32; N]) -> [f64; N] {
        let mut values = [f64::NAN; N];
        // SAFETY: live instance, arrays of equal length.
        let status = unsafe { fmi2GetReal(self.c, vr.as_ptr(), N, values.as_mut_ptr()) };
        assert_eq!(status, Status::Ok, "{:?}", self.messages());
        values
    }

    pub fn try_get(&self, vr: u32) -> Status {
        // SAFETY: live instance, one element each.
        unsafe { fmi2GetReal(self.c, &vr, 1, &mut 0.0) }
    }

    pub fn get_integer(&self, vr: u32) -> i32 {
        let mut value = i32::MIN;
        // SAFETY: live instance, one element each.
        assert_eq!(
            unsafe { fmi2GetInteger(self.c, &vr, 1, &mut value) },
            Status::Ok
        );
        value
    }

    pub fn get_boolean(&self, vr: u32) -> i32 {
        let mut value = i32::MIN;
        // SAFETY: live instance, one element each.
        assert_eq!(
            unsafe { fmi2GetBoolean(self.c, &vr, 1, &mut value) },
            Status::Ok
        );
        value
    }

    pub fn get_string(&self, vr: u32) -> String {
        let mut value = ptr::null();
        // SAFETY: live instance, one element each; the text lives until the next call.
        unsafe {
            assert_eq!(fmi2GetString(self.c, &vr, 1, &mut value), Status::Ok);
            CStr::from_ptr(value).to_str().unwrap().to_owned()
        }
    }

    pub fn derivatives(&self, vr: &[u32], order: &[i32], values: &[f64]) -> Status {
        // SAFETY: live instance, slices of equal length.
        unsafe {
            fmi2SetRealInputDerivatives(
                self.c,
                vr.as_ptr(),
                vr.len(),
                order.as_ptr(),
                values.as_ptr(),
            )
        }
    }

    pub fn output_derivative(&self, vr: u32, order: i32) -> (Status, f64) {
        let mut value = f64::NAN;
        // SAFETY: live instance, one element each.
        let status = unsafe { fmi2GetRealOutputDerivatives(self.c, &vr, 1, &order, &mut value) };
        (status, value)
    }

    pub fn directional(&self, unknown: &[u32], known: &[u32], seed: &[f64]) -> (Status, Vec<f64>) {
        let mut result = vec![f64::NAN; unknown.len()];
        // SAFETY: live instance, slices of fitting length.
        let status = unsafe {
            fmi2GetDirectionalDerivative(
                self.c,
                unknown.as_ptr(),
                unknown.len(),
                known.as_ptr(),
                known.len(),
                seed.as_ptr(),
                result.as_mut_ptr(),
            )
        };
        (status, result)
    }

    pub fn step(&self, t: f64, h: f64) -> Status {
        // SAFETY: a live instance.
        unsafe { fmi2DoStep(self.c, t, h, 1) }
    }

    pub fn last_time(&self) -> f64 {
        let mut t = f64::NAN;
        // SAFETY: live instance, a place for one number.
        assert_eq!(
            unsafe { fmi2GetRealStatus(self.c, LAST_SUCCESSFUL_TIME, &mut t) },
            Status::Ok
        );
        t
    }

    pub fn messages(&self) -> Vec<Message> {
        self.log.lock().unwrap().clone()
    }

    /// The last message, which must be about a status.
    pub fn last(&self) -> Message {
        self.messages().last().expect("a message").clone()
    }
}

saved_states! { Fmu:
    fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate
    fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate
}

impl Drop for Fmu {
    fn drop(&mut self) {
        // SAFETY: a live instance, freed once.
        unsafe { fmi2FreeInstance(self.c) }
    }
}
