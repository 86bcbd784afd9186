//! An importer of FMI 3.0: the C functions by their C names, and an instance with a log.

use crate::probe::Probe;
use fmu_export::ffi3::*;
use std::ffi::{CStr, CString, c_int, c_void};
use std::ptr;
use std::sync::{Arc, Mutex, OnceLock};

pub use fmu_export::ffi3::Status;

macro_rules! functions {
    ($($name:ident($($argument:ident: $type:ty),*);)*) => {
        #[allow(clashing_extern_declarations, dead_code)]
        unsafe extern "C-unwind" {
            $(pub fn $name(c: Instance $(, $argument: $type)*) -> Status;)*
        }
    };
}

#[rustfmt::skip]
unsafe extern "C-unwind" {
    pub safe fn fmi3GetVersion() -> Str;
    pub fn fmi3InstantiateCoSimulation(name: Str, token: Str, resources: Str, visible: Boolean, on: Boolean, event_mode: Boolean, early: Boolean, required: *const u32, n: usize, environment: *mut c_void, log: Option<LogMessage>, update: Option<IntermediateUpdate>) -> Instance;
    pub fn fmi3InstantiateModelExchange(name: Str, token: Str, resources: Str, visible: Boolean, on: Boolean, environment: *mut c_void, log: Option<LogMessage>) -> Instance;
    pub fn fmi3InstantiateScheduledExecution(name: Str, token: Str, resources: Str, visible: Boolean, on: Boolean, environment: *mut c_void, log: Option<LogMessage>, clock: Option<ClockUpdate>, lock: Option<Preemption>, unlock: Option<Preemption>) -> Instance;
    pub fn fmi3FreeInstance(c: Instance);
    pub fn fmi3ExportFiles(context: *mut c_void, receive: Option<ReceiveFile>) -> c_int;
}

#[rustfmt::skip]
functions! {
    fmi3SetDebugLogging(on: Boolean, n: usize, categories: *const Str);
    fmi3EnterInitializationMode(tolerance_defined: Boolean, tolerance: f64, start: f64, stop_defined: Boolean, stop: f64);
    fmi3ExitInitializationMode();
    fmi3EnterEventMode();
    fmi3EnterStepMode();
    fmi3EvaluateDiscreteStates();
    fmi3UpdateDiscreteStates(a: *mut Boolean, b: *mut Boolean, c1: *mut Boolean, d: *mut Boolean, e: *mut Boolean, t: *mut f64);
    fmi3Terminate();
    fmi3Reset();
    fmi3DoStep(t: f64, h: f64, no_set_prior: Boolean, event: *mut Boolean, terminate: *mut Boolean, early: *mut Boolean, last: *mut f64);
    fmi3GetFloat32(vr: *const u32, n: usize, values: *mut f32, n_values: usize);
    fmi3GetFloat64(vr: *const u32, n: usize, values: *mut f64, n_values: usize);
    fmi3GetInt8(vr: *const u32, n: usize, values: *mut i8, n_values: usize);
    fmi3GetUInt8(vr: *const u32, n: usize, values: *mut u8, n_values: usize);
    fmi3GetInt16(vr: *const u32, n: usize, values: *mut i16, n_values: usize);
    fmi3GetUInt16(vr: *const u32, n: usize, values: *mut u16, n_values: usize);
    fmi3GetInt32(vr: *const u32, n: usize, values: *mut i32, n_values: usize);
    fmi3GetUInt32(vr: *const u32, n: usize, values: *mut u32, n_values: usize);
    fmi3GetInt64(vr: *const u32, n: usize, values: *mut i64, n_values: usize);
    fmi3GetUInt64(vr: *const u32, n: usize, values: *mut u64, n_values: usize);
    fmi3GetBoolean(vr: *const u32, n: usize, values: *mut Boolean, n_values: usize);
    fmi3GetString(vr: *const u32, n: usize, values: *mut Str, n_values: usize);
    fmi3GetBinary(vr: *const u32, n: usize, sizes: *mut usize, values: *mut Binary, n_values: usize);
    fmi3GetClock(vr: *const u32, n: usize, values: *mut Boolean);
    fmi3SetFloat32(vr: *const u32, n: usize, values: *const f32, n_values: usize);
    fmi3SetFloat64(vr: *const u32, n: usize, values: *const f64, n_values: usize);
    fmi3SetInt8(vr: *const u32, n: usize, values: *const i8, n_values: usize);
    fmi3SetUInt8(vr: *const u32, n: usize, values: *const u8, n_values: usize);
    fmi3SetInt16(vr: *const u32, n: usize, values: *const i16, n_values: usize);
    fmi3SetUInt16(vr: *const u32, n: usize, values: *const u16, n_values: usize);
    fmi3SetInt32(vr: *const u32, n: usize, values: *const i32, n_values: usize);
    fmi3SetUInt32(vr: *const u32, n: usize, values: *const u32, n_values: usize);
    fmi3SetInt64(vr: *const u32, n: usize, values: *const i64, n_values: usize);
    fmi3SetUInt64(vr: *const u32, n: usize, values: *const u64, n_values: usize);
    fmi3SetBoolean(vr: *const u32, n: usize, values: *const Boolean, n_values: usize);
    fmi3SetString(vr: *const u32, n: usize, values: *const Str, n_values: usize);
    fmi3SetBinary(vr: *const u32, n: usize, sizes: *const usize, values: *const Binary, n_values: usize);
    fmi3SetClock(vr: *const u32, n: usize, values: *const Boolean);
    fmi3GetNumberOfVariableDependencies(dependent: u32, n: *mut usize);
    fmi3GetVariableDependencies(dependent: u32, elements: *mut usize, independents: *mut u32, independent_elements: *mut usize, kinds: *mut c_int, n: usize);
    fmi3GetFMUState(state: *mut FmuState);
    fmi3SetFMUState(state: FmuState);
    fmi3FreeFMUState(state: *mut FmuState);
    fmi3SerializedFMUStateSize(state: FmuState, size: *mut usize);
    fmi3SerializeFMUState(state: FmuState, bytes: *mut Byte, size: usize);
    fmi3DeserializeFMUState(bytes: *const Byte, size: usize, state: *mut FmuState);
    fmi3GetDirectionalDerivative(unknowns: *const u32, n_unknowns: usize, knowns: *const u32, n_knowns: usize, seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize);
    fmi3GetAdjointDerivative(unknowns: *const u32, n_unknowns: usize, knowns: *const u32, n_knowns: usize, seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize);
    fmi3GetOutputDerivatives(vr: *const u32, n: usize, orders: *const i32, values: *mut f64, n_values: usize);
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3GetIntervalDecimal(vr: *const u32, n: usize, intervals: *mut f64, qualifiers: *mut c_int);
    fmi3GetIntervalFraction(vr: *const u32, n: usize, counters: *mut u64, resolutions: *mut u64, qualifiers: *mut c_int);
    fmi3GetShiftDecimal(vr: *const u32, n: usize, shifts: *mut f64);
    fmi3GetShiftFraction(vr: *const u32, n: usize, counters: *mut u64, resolutions: *mut u64);
    fmi3SetIntervalDecimal(vr: *const u32, n: usize, intervals: *const f64);
    fmi3SetIntervalFraction(vr: *const u32, n: usize, counters: *const u64, resolutions: *const u64);
    fmi3SetShiftDecimal(vr: *const u32, n: usize, shifts: *const f64);
    fmi3SetShiftFraction(vr: *const u32, n: usize, counters: *const u64, resolutions: *const u64);
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(no_set_prior: Boolean, enter_event_mode: *mut Boolean, terminate: *mut Boolean);
    fmi3SetTime(time: f64);
    fmi3SetContinuousStates(states: *const f64, n: usize);
    fmi3GetContinuousStateDerivatives(derivatives: *mut f64, n: usize);
    fmi3GetEventIndicators(indicators: *mut f64, n: usize);
    fmi3GetContinuousStates(states: *mut f64, n: usize);
    fmi3GetNominalsOfContinuousStates(nominals: *mut f64, n: usize);
    fmi3GetNumberOfEventIndicators(n: *mut usize);
    fmi3GetNumberOfContinuousStates(n: *mut usize);
    fmi3ActivateModelPartition(clock: u32, time: f64);
}

/// A message as the logger got it.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    pub status: Status,
    pub category: String,
    pub text: String,
}

unsafe extern "C-unwind" fn log_message(
    env: *mut c_void,
    status: Status,
    category: Str,
    text: Str,
) {
    // SAFETY: the environment is the world of the instance; all strings are C strings.
    unsafe {
        let string = |s: Str| CStr::from_ptr(s).to_str().unwrap().to_owned();
        let message = Message {
            status,
            category: string(category),
            text: string(text),
        };
        (*env.cast::<World>()).log.lock().unwrap().push(message);
    }
}

/// An intermediate update: time and flags (set requested, get allowed, step finished, early return possible).
pub type Seen = (f64, [Boolean; 4]);

unsafe extern "C-unwind" fn intermediate_update(
    env: *mut c_void,
    time: f64,
    set: Boolean,
    get: Boolean,
    finished: Boolean,
    early: Boolean,
    _requested: *mut Boolean,
    _early_time: *mut f64,
) {
    // SAFETY: the environment is the world of the instance.
    let world = unsafe { &*env.cast::<World>() };
    world
        .seen
        .lock()
        .unwrap()
        .push((time, [set, get, finished, early]));
    if let Some(look) = world.look {
        look(&Fmu3 {
            c: *world.instance.get().unwrap() as Instance,
            world: None,
        });
    }
}

/// What the callbacks have to do with.
#[derive(Default)]
pub struct World {
    pub log: Mutex<Vec<Message>>,
    pub seen: Mutex<Vec<Seen>>,
    /// What is done within an intermediate update.
    pub look: Option<fn(&Fmu3)>,
    /// The instance, as a number.
    pub instance: OnceLock<usize>,
}

/// How an instance is made.
#[derive(Clone, Copy)]
pub struct Options {
    pub on: bool,
    pub event_mode: bool,
    pub early_return: bool,
    pub required: &'static [u32],
    pub look: Option<fn(&Fmu3)>,
}

pub const PLAIN: Options = Options {
    on: true,
    event_mode: false,
    early_return: false,
    required: &[],
    look: None,
};
pub const EVENTS: Options = Options {
    event_mode: true,
    early_return: true,
    ..PLAIN
};

/// The instantiation token, read from the model description, once.
pub fn token() -> &'static CStr {
    static TOKEN: OnceLock<CString> = OnceLock::new();
    TOKEN.get_or_init(|| {
        let xml = fmu_export::model_description3::<Probe>().unwrap();
        let (_, rest) = xml.split_once("instantiationToken=\"").unwrap();
        CString::new(rest.split_once('"').unwrap().0).unwrap()
    })
}

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    pub event: bool,
    pub terminate: bool,
    pub early: bool,
    pub last: f64,
}

/// An instance with its log.
pub struct Fmu3 {
    pub c: Instance,
    pub world: Option<Arc<World>>,
}

/// Every call goes to the C functions with pointers that are valid for the slices they come from.
impl Fmu3 {
    pub fn instantiated(options: Options) -> Self {
        Self::try_with(options, token(), c"/tmp/a b/").expect("an instance")
    }

    /// An instance, or the messages that say why there is none.
    pub fn try_with(
        options: Options,
        token: &CStr,
        resources: &CStr,
    ) -> Result<Self, Vec<Message>> {
        let world = Arc::new(World {
            look: options.look,
            ..World::default()
        });
        let Options {
            on,
            event_mode,
            early_return,
            required,
            ..
        } = options;
        // SAFETY: valid strings, callbacks and slices.
        let c = unsafe {
            fmi3InstantiateCoSimulation(
                c"probe 1".as_ptr(),
                token.as_ptr(),
                resources.as_ptr(),
                0,
                on.into(),
                event_mode.into(),
                early_return.into(),
                required.as_ptr(),
                required.len(),
                Arc::as_ptr(&world).cast_mut().cast(),
                Some(log_message),
                Some(intermediate_update),
            )
        };
        if c.is_null() {
            return Err(world.log.lock().unwrap().clone());
        }
        world.instance.set(c as usize).unwrap();
        Ok(Self {
            c,
            world: Some(world),
        })
    }

    pub fn initializing(options: Options) -> Self {
        let fmu = Self::instantiated(options);
        assert_eq!(fmu.enter_initialization(0.0, None), Status::Ok);
        fmu
    }

    /// At the first communication point: in Event Mode if it is used.
    pub fn initialized(options: Options) -> Self {
        let fmu = Self::initializing(options);
        assert_eq!(
            fmu.call(fmi3ExitInitializationMode),
            Status::Ok,
            "{:?}",
            fmu.messages()
        );
        fmu
    }

    pub fn stepping(options: Options) -> Self {
        let fmu = Self::initialized(options);
        if options.event_mode {
            assert_eq!(fmu.call(fmi3EnterStepMode), Status::Ok);
        }
        fmu
    }

    pub fn call(&self, function: unsafe extern "C-unwind" fn(Instance) -> Status) -> Status {
        // SAFETY: a live instance.
        unsafe { function(self.c) }
    }

    pub fn enter_initialization(&self, start: f64, stop: Option<f64>) -> Status {
        // SAFETY: a live instance.
        unsafe {
            fmi3EnterInitializationMode(
                self.c,
                0,
                0.0,
                start,
                stop.is_some().into(),
                stop.unwrap_or(0.0),
            )
        }
    }

    pub fn update(&self) -> (Status, [Boolean; 5]) {
        let mut flags = [9; 5];
        let [a, b, c, d, e] = &mut flags;
        // SAFETY: a live instance, places for the results.
        let status = unsafe { fmi3UpdateDiscreteStates(self.c, a, b, c, d, e, &mut 0.0) };
        (status, flags)
    }

    pub fn set(&self, vr: &[u32], values: &[f64]) -> Status {
        // SAFETY: a live instance, valid slices.
        unsafe { fmi3SetFloat64(self.c, vr.as_ptr(), vr.len(), values.as_ptr(), values.len()) }
    }

    pub fn set_int32(&self, vr: u32, value: i32) -> Status {
        // SAFETY: a live instance, one element each.
        unsafe { fmi3SetInt32(self.c, &vr, 1, &value, 1) }
    }

    pub fn set_int64(&self, vr: u32, value: i64) -> Status {
        // SAFETY: as above.
        unsafe { fmi3SetInt64(self.c, &vr, 1, &value, 1) }
    }

    pub fn set_boolean(&self, vr: u32, value: Boolean) -> Status {
        // SAFETY: as above.
        unsafe { fmi3SetBoolean(self.c, &vr, 1, &value, 1) }
    }

    pub fn set_string(&self, vr: u32, value: &CStr) -> Status {
        // SAFETY: as above.
        unsafe { fmi3SetString(self.c, &vr, 1, &value.as_ptr(), 1) }
    }

    pub fn try_get<const N: usize>(&self, vr: &[u32]) -> (Status, [f64; N]) {
        let mut values = [f64::NAN; N];
        // SAFETY: a live instance, valid slices.
        let status =
            unsafe { fmi3GetFloat64(self.c, vr.as_ptr(), vr.len(), values.as_mut_ptr(), N) };
        (status, values)
    }

    pub fn get<const N: usize>(&self, vr: &[u32]) -> [f64; N] {
        let (status, values) = self.try_get(vr);
        assert_eq!(status, Status::Ok, "{:?}", self.messages());
        values
    }

    pub fn get_int32(&self, vr: u32) -> (Status, i32) {
        let mut value = i32::MIN;
        // SAFETY: a live instance, one element each.
        (
            unsafe { fmi3GetInt32(self.c, &vr, 1, &mut value, 1) },
            value,
        )
    }

    pub fn get_int64(&self, vr: u32) -> (Status, i64) {
        let mut value = i64::MIN;
        // SAFETY: as above.
        (
            unsafe { fmi3GetInt64(self.c, &vr, 1, &mut value, 1) },
            value,
        )
    }

    pub fn get_boolean(&self, vr: u32) -> (Status, Boolean) {
        let mut value = 9;
        // SAFETY: as above.
        (
            unsafe { fmi3GetBoolean(self.c, &vr, 1, &mut value, 1) },
            value,
        )
    }

    pub fn get_string(&self, vr: u32) -> (Status, String) {
        let mut value = ptr::null();
        // SAFETY: as above; the text lives until the next call.
        unsafe {
            let status = fmi3GetString(self.c, &vr, 1, &mut value, 1);
            let text = match value.is_null() {
                true => String::new(),
                false => CStr::from_ptr(value).to_str().unwrap().to_owned(),
            };
            (status, text)
        }
    }

    pub fn step(&self, t: f64, h: f64) -> (Status, Step) {
        let (mut event, mut terminate, mut early, mut last) = (9, 9, 9, f64::NAN);
        // SAFETY: a live instance, places for the results.
        let status = unsafe {
            fmi3DoStep(
                self.c,
                t,
                h,
                1,
                &mut event,
                &mut terminate,
                &mut early,
                &mut last,
            )
        };
        let step = Step {
            event: event == 1,
            terminate: terminate == 1,
            early: early == 1,
            last,
        };
        (status, step)
    }

    pub fn directional(
        &self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        n: usize,
    ) -> (Status, Vec<f64>) {
        let mut result = vec![f64::NAN; n];
        // SAFETY: a live instance, valid slices.
        let status = unsafe {
            fmi3GetDirectionalDerivative(
                self.c,
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seed.as_ptr(),
                seed.len(),
                result.as_mut_ptr(),
                n,
            )
        };
        (status, result)
    }

    pub fn adjoint(
        &self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        n: usize,
    ) -> (Status, Vec<f64>) {
        let mut result = vec![f64::NAN; n];
        // SAFETY: a live instance, valid slices.
        let status = unsafe {
            fmi3GetAdjointDerivative(
                self.c,
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                seed.as_ptr(),
                seed.len(),
                result.as_mut_ptr(),
                n,
            )
        };
        (status, result)
    }

    pub fn output_derivatives(&self, vr: &[u32], orders: &[i32], n: usize) -> (Status, Vec<f64>) {
        let mut values = vec![f64::NAN; n];
        // SAFETY: a live instance, valid slices.
        let status = unsafe {
            fmi3GetOutputDerivatives(
                self.c,
                vr.as_ptr(),
                vr.len(),
                orders.as_ptr(),
                values.as_mut_ptr(),
                n,
            )
        };
        (status, values)
    }

    /// Dependencies of a variable: its element, the other variable and its element.
    pub fn dependencies(&self, vr: u32) -> (Status, Vec<(usize, u32, usize)>) {
        let mut n = 0;
        // SAFETY: a live instance; the vectors are as long as asked for.
        unsafe {
            let status = fmi3GetNumberOfVariableDependencies(self.c, vr, &mut n);
            if status != Status::Ok {
                return (status, Vec::new());
            }
            let (mut a, mut b, mut c, mut kinds) = (vec![0; n], vec![0; n], vec![0; n], vec![0; n]);
            let status = fmi3GetVariableDependencies(
                self.c,
                vr,
                a.as_mut_ptr(),
                b.as_mut_ptr(),
                c.as_mut_ptr(),
                kinds.as_mut_ptr(),
                n,
            );
            assert!(kinds.iter().all(|kind| *kind == DEPENDENT));
            let found = (0..n).map(|k| (a[k], b[k], c[k])).collect();
            (status, found)
        }
    }

    pub fn save(&self) -> FmuState {
        let mut state = ptr::null_mut();
        // SAFETY: a live instance, a place for the handle.
        assert_eq!(unsafe { fmi3GetFMUState(self.c, &mut state) }, Status::Ok);
        state
    }

    pub fn restore(&self, state: FmuState) -> Status {
        // SAFETY: a live instance.
        unsafe { fmi3SetFMUState(self.c, state) }
    }

    pub fn free(&self, state: &mut FmuState) -> Status {
        // SAFETY: a live instance, a handle.
        unsafe { fmi3FreeFMUState(self.c, state) }
    }

    pub fn serialize(&self, state: FmuState) -> Vec<u8> {
        let mut size = 0;
        // SAFETY: a live instance; the vector has the size asked for.
        unsafe {
            assert_eq!(
                fmi3SerializedFMUStateSize(self.c, state, &mut size),
                Status::Ok
            );
            let mut bytes = vec![0_u8; size];
            assert_eq!(
                fmi3SerializeFMUState(self.c, state, bytes.as_mut_ptr(), size),
                Status::Ok
            );
            bytes
        }
    }

    pub fn deserialize(&self, bytes: &[u8]) -> (Status, FmuState) {
        let mut state = ptr::null_mut();
        // SAFETY: a live instance, a valid slice.
        let status =
            unsafe { fmi3DeserializeFMUState(self.c, bytes.as_ptr(), bytes.len(), &mut state) };
        (status, state)
    }

    /// All of the instance that can be saved, as bytes: to see that a refused call changed nothing.
    pub fn snapshot(&self) -> Vec<u8> {
        let mut state = self.save();
        let bytes = self.serialize(state);
        assert_eq!(self.free(&mut state), Status::Ok);
        bytes
    }

    pub fn messages(&self) -> Vec<Message> {
        let world = self.world.as_ref();
        world.map_or_else(Vec::new, |world| world.log.lock().unwrap().clone())
    }

    /// The last message.
    pub fn last(&self) -> Message {
        self.messages().last().expect("a message").clone()
    }

    pub fn seen(&self) -> Vec<Seen> {
        self.world.as_ref().unwrap().seen.lock().unwrap().clone()
    }
}

impl Drop for Fmu3 {
    fn drop(&mut self) {
        if self.world.is_some() {
            // SAFETY: a live instance, freed once; one without a world is borrowed from the callback.
            unsafe { fmi3FreeInstance(self.c) }
        }
    }
}
