//! An importer of FMI 3.0: the C functions by their C names, and an instance with a log.

mod functions;

use crate::probe::Probe;
use crate::states::saved_states;
use fmu_export::ffi3::*;
use std::ffi::{CStr, CString, c_void};
use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

pub use fmu_export::ffi3::Status;
pub use functions::*;

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

/// An intermediate update: time and flags (set requested, get allowed, step finished, early return
/// possible).
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
            c: world.instance.load(Ordering::Relaxed),
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
    /// The instance, once it is made.
    pub instance: AtomicPtr<c_void>,
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
        world.instance.store(c, Ordering::Relaxed);
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

saved_states! { Fmu3:
    fmi3GetFMUState fmi3SetFMUState fmi3FreeFMUState
    fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState
}

impl Drop for Fmu3 {
    fn drop(&mut self) {
        if self.world.is_some() {
            // SAFETY: a live instance, freed once; one without a world is borrowed from the
            // callback.
            unsafe { fmi3FreeInstance(self.c) }
        }
    }
}
