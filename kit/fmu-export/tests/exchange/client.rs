//! An importer of both versions of FMI, as far as Model Exchange needs it.

use crate::model::Ball;
use fmu_export::ffi::{CallbackFunctions, CallbackLogger, EventInfo, Str};
use fmu_export::ffi3::LogMessage;
use std::ffi::{CStr, CString, c_int, c_void};
use std::sync::Mutex;
use std::{mem, ptr};

type C = *mut c_void;

macro_rules! functions {
    ($($name:ident($($type:ty),*);)*) => {
        unsafe extern "C-unwind" {
            $(pub fn $name(c: C $(, _: $type)*) -> c_int;)*
        }
    };
}

#[rustfmt::skip]
functions! {
    fmi2SetupExperiment(c_int, f64, f64, c_int, f64); fmi2EnterInitializationMode(); fmi2ExitInitializationMode(); fmi2Terminate(); fmi2Reset();
    fmi2GetReal(*const u32, usize, *mut f64); fmi2SetReal(*const u32, usize, *const f64); fmi2SetInteger(*const u32, usize, *const c_int);
    fmi2GetInteger(*const u32, usize, *mut c_int);
    fmi2EnterEventMode(); fmi2NewDiscreteStates(*mut EventInfo); fmi2EnterContinuousTimeMode();
    fmi2CompletedIntegratorStep(c_int, *mut c_int, *mut c_int); fmi2SetTime(f64); fmi2SetContinuousStates(*const f64, usize);
    fmi2GetDerivatives(*mut f64, usize); fmi2GetEventIndicators(*mut f64, usize); fmi2GetContinuousStates(*mut f64, usize);
    fmi2GetNominalsOfContinuousStates(*mut f64, usize); fmi2GetFMUstate(*mut C); fmi2SetFMUstate(C);
    fmi2SerializedFMUstateSize(C, *mut usize); fmi2SerializeFMUstate(C, *mut u8, usize); fmi2DeSerializeFMUstate(*const u8, usize, *mut C);
    fmi2GetDirectionalDerivative(*const u32, usize, *const u32, usize, *const f64, *mut f64);
    fmi2DoStep(f64, f64, c_int); fmi2GetStatus(c_int, *mut c_int); fmi2SetRealInputDerivatives(*const u32, usize, *const c_int, *const f64);
    fmi3EnterInitializationMode(bool, f64, f64, bool, f64); fmi3ExitInitializationMode(); fmi3Terminate(); fmi3Reset();
    fmi3GetFloat64(*const u32, usize, *mut f64, usize); fmi3SetFloat64(*const u32, usize, *const f64, usize);
    fmi3SetInt32(*const u32, usize, *const c_int, usize); fmi3GetInt32(*const u32, usize, *mut c_int, usize);
    fmi3EnterEventMode(); fmi3UpdateDiscreteStates(*mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64);
    fmi3EnterContinuousTimeMode(); fmi3CompletedIntegratorStep(bool, *mut bool, *mut bool); fmi3SetTime(f64);
    fmi3SetContinuousStates(*const f64, usize); fmi3GetContinuousStateDerivatives(*mut f64, usize); fmi3GetEventIndicators(*mut f64, usize);
    fmi3GetContinuousStates(*mut f64, usize); fmi3GetNominalsOfContinuousStates(*mut f64, usize); fmi3GetNumberOfEventIndicators(*mut usize);
    fmi3GetNumberOfContinuousStates(*mut usize); fmi3GetFMUState(*mut C); fmi3SetFMUState(C);
    fmi3SerializedFMUStateSize(C, *mut usize); fmi3SerializeFMUState(C, *mut u8, usize); fmi3DeserializeFMUState(*const u8, usize, *mut C);
    fmi3GetDirectionalDerivative(*const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize);
    fmi3GetAdjointDerivative(*const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize);
    fmi3EnterStepMode(); fmi3DoStep(f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64); fmi3EvaluateDiscreteStates();
    fmi3GetOutputDerivatives(*const u32, usize, *const c_int, *mut f64, usize);
}

#[rustfmt::skip]
unsafe extern "C-unwind" {
    fn fmi2Instantiate(name: Str, kind: c_int, guid: Str, resources: Str, functions: *const CallbackFunctions, visible: c_int, on: c_int) -> C;
    fn fmi2FreeInstance(c: C);
    fn fmi3InstantiateModelExchange(name: Str, token: Str, resources: Str, visible: bool, on: bool, environment: C, log: Option<LogMessage>) -> C;
    fn fmi3FreeInstance(c: C);
}

type Log = Mutex<Vec<String>>;

unsafe extern "C-unwind" fn told2(env: C, _: Str, _: c_int, _: Str, text: Str) {
    unsafe { told3(env, 0, text, text) }
}

unsafe extern "C-unwind" fn told3(env: C, _: c_int, _: Str, text: Str) {
    let text = unsafe { CStr::from_ptr(text) }
        .to_str()
        .unwrap()
        .replace("%%", "%");
    unsafe { &*env.cast::<Log>() }.lock().unwrap().push(text);
}

/// An instance for Model Exchange (or, of FMI 2.0, for Co-Simulation), with its log.
pub struct Fmu {
    pub c: C,
    pub version: u8,
    log: Box<Log>,
}

/// What an event has led to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Told {
    pub again: bool,
    pub terminate: bool,
    pub nominals: bool,
    pub moved: bool,
    pub next: Option<f64>,
}

fn attribute(xml: &str, name: &str) -> CString {
    let (_, rest) = xml.split_once(&format!("{name}=\"")).unwrap();
    CString::new(rest.split_once('"').unwrap().0).unwrap()
}

impl Fmu {
    pub fn new(version: u8) -> Self {
        Self::of(version, 0)
    }

    /// `kind` is that of FMI 2.0.
    pub fn of(version: u8, kind: c_int) -> Self {
        let log = Box::new(Mutex::new(Vec::new()));
        let environment = ptr::from_ref(&*log).cast_mut().cast();
        let c = unsafe {
            if version == 2 {
                let guid = attribute(&fmu_export::model_description::<Ball>().unwrap(), "guid");
                let functions = CallbackFunctions {
                    // A variadic call with pointers only equals a plain one on the platforms we test on.
                    logger: Some(mem::transmute::<*const (), CallbackLogger>(
                        told2 as *const (),
                    )),
                    allocate_memory: None,
                    free_memory: None,
                    step_finished: None,
                    component_environment: environment,
                };
                fmi2Instantiate(
                    c"ball".as_ptr(),
                    kind,
                    guid.as_ptr(),
                    ptr::null(),
                    &functions,
                    0,
                    1,
                )
            } else {
                let xml = fmu_export::model_description3::<Ball>().unwrap();
                let token = attribute(&xml, "instantiationToken");
                let log = mem::transmute::<*const (), LogMessage>(told3 as *const ());
                fmi3InstantiateModelExchange(
                    c"ball".as_ptr(),
                    token.as_ptr(),
                    ptr::null(),
                    false,
                    true,
                    environment,
                    Some(log),
                )
            }
        };
        assert!(!c.is_null(), "{:?}", log.lock().unwrap());
        Self { c, version, log }
    }

    /// In Event Mode after the initialization.
    pub fn in_event_mode(version: u8) -> Self {
        let fmu = Self::new(version);
        fmu.initialize();
        fmu
    }

    pub fn initialize(&self) {
        self.enter_initialization();
        assert_eq!(
            self.call([fmi2ExitInitializationMode, fmi3ExitInitializationMode]),
            0
        );
    }

    pub fn enter_initialization(&self) {
        let entered = match self.version {
            2 => unsafe { fmi2EnterInitializationMode(self.c) },
            _ => unsafe { fmi3EnterInitializationMode(self.c, false, 0.0, 0.0, false, 0.0) },
        };
        assert_eq!(entered, 0, "{}", self.last());
    }

    /// In Continuous-Time Mode.
    pub fn running(version: u8) -> Self {
        let fmu = Self::in_event_mode(version);
        fmu.update();
        assert_eq!(
            fmu.call([fmi2EnterContinuousTimeMode, fmi3EnterContinuousTimeMode]),
            0
        );
        fmu
    }

    /// Events at the present time, from Continuous-Time Mode and back.
    pub fn event(&self) -> Told {
        assert_eq!(
            self.call([fmi2EnterEventMode, fmi3EnterEventMode]),
            0,
            "{}",
            self.last()
        );
        let told = self.update();
        assert_eq!(
            self.call([fmi2EnterContinuousTimeMode, fmi3EnterContinuousTimeMode]),
            0
        );
        told
    }

    pub fn update(&self) -> Told {
        if self.version == 2 {
            let mut i = EventInfo::default();
            assert_eq!(
                unsafe { fmi2NewDiscreteStates(self.c, &mut i) },
                0,
                "{}",
                self.last()
            );
            return Told {
                again: i.new_discrete_states_needed != 0,
                terminate: i.terminate_simulation != 0,
                nominals: i.nominals_of_continuous_states_changed != 0,
                moved: i.values_of_continuous_states_changed != 0,
                next: (i.next_event_time_defined != 0).then_some(i.next_event_time),
            };
        }
        let (mut flags, mut next) = ([false; 5], f64::NAN);
        let [a, b, c, d, e] = flags.each_mut();
        assert_eq!(
            unsafe { fmi3UpdateDiscreteStates(self.c, a, b, c, d, e, &mut next) },
            0,
            "{}",
            self.last()
        );
        let [again, terminate, nominals, moved, defined] = flags;
        Told {
            again,
            terminate,
            nominals,
            moved,
            next: defined.then_some(next),
        }
    }

    pub fn call(&self, [two, three]: [unsafe extern "C-unwind" fn(C) -> c_int; 2]) -> c_int {
        unsafe {
            if self.version == 2 {
                two(self.c)
            } else {
                three(self.c)
            }
        }
    }

    pub fn set_time(&self, t: f64) -> c_int {
        unsafe {
            if self.version == 2 {
                fmi2SetTime(self.c, t)
            } else {
                fmi3SetTime(self.c, t)
            }
        }
    }

    pub fn set_states(&self, x: &[f64]) -> c_int {
        let f = if self.version == 2 {
            fmi2SetContinuousStates
        } else {
            fmi3SetContinuousStates
        };
        unsafe { f(self.c, x.as_ptr(), x.len()) }
    }

    pub fn try_read<const N: usize>(
        &self,
        [two, three]: [unsafe extern "C-unwind" fn(C, *mut f64, usize) -> c_int; 2],
    ) -> Result<[f64; N], String> {
        let mut x = [f64::NAN; N];
        let f = if self.version == 2 { two } else { three };
        match unsafe { f(self.c, x.as_mut_ptr(), N) } {
            0 => Ok(x),
            _ => Err(self.last()),
        }
    }

    pub fn states(&self) -> [f64; 4] {
        self.try_read([fmi2GetContinuousStates, fmi3GetContinuousStates])
            .unwrap()
    }

    pub fn derivatives(&self) -> [f64; 4] {
        self.try_read([fmi2GetDerivatives, fmi3GetContinuousStateDerivatives])
            .unwrap()
    }

    pub fn floor(&self) -> f64 {
        let [z] = self
            .try_read([fmi2GetEventIndicators, fmi3GetEventIndicators])
            .unwrap();
        z
    }

    pub fn completed(&self) -> [bool; 2] {
        if self.version == 2 {
            let mut told = [7; 2];
            let [a, b] = told.each_mut();
            assert_eq!(
                unsafe { fmi2CompletedIntegratorStep(self.c, 1, a, b) },
                0,
                "{}",
                self.last()
            );
            return told.map(|x| x != 0);
        }
        let mut told = [true; 2];
        let [a, b] = told.each_mut();
        assert_eq!(
            unsafe { fmi3CompletedIntegratorStep(self.c, true, a, b) },
            0,
            "{}",
            self.last()
        );
        told
    }

    /// Sets Real variables, of FMI 3.0 the elements of one.
    pub fn set(&self, vr: u32, values: &[f64]) -> c_int {
        let numbers: Vec<u32> = (vr..).take(values.len()).collect();
        unsafe {
            match self.version {
                2 => fmi2SetReal(self.c, numbers.as_ptr(), numbers.len(), values.as_ptr()),
                _ => fmi3SetFloat64(self.c, &vr, 1, values.as_ptr(), values.len()),
            }
        }
    }

    pub fn set_integer(&self, vr: u32, value: c_int) -> c_int {
        unsafe {
            if self.version == 2 {
                fmi2SetInteger(self.c, &vr, 1, &value)
            } else {
                fmi3SetInt32(self.c, &vr, 1, &value, 1)
            }
        }
    }

    pub fn integer(&self, vr: u32) -> c_int {
        let mut value = -7;
        let status = unsafe {
            match self.version {
                2 => fmi2GetInteger(self.c, &vr, 1, &mut value),
                _ => fmi3GetInt32(self.c, &vr, 1, &mut value, 1),
            }
        };
        assert_eq!(status, 0, "{}", self.last());
        value
    }

    pub fn get<const N: usize>(&self, vr: u32) -> [f64; N] {
        let mut values = [f64::NAN; N];
        let numbers: Vec<u32> = (vr..).take(N).collect();
        let status = unsafe {
            match self.version {
                2 => fmi2GetReal(self.c, numbers.as_ptr(), N, values.as_mut_ptr()),
                _ => fmi3GetFloat64(self.c, &vr, 1, values.as_mut_ptr(), N),
            }
        };
        assert_eq!(status, 0, "{}", self.last());
        values
    }

    pub fn save(&self) -> C {
        let mut state = ptr::null_mut();
        let f = if self.version == 2 {
            fmi2GetFMUstate
        } else {
            fmi3GetFMUState
        };
        assert_eq!(unsafe { f(self.c, &mut state) }, 0, "{}", self.last());
        state
    }

    pub fn restore(&self, state: C) -> c_int {
        unsafe {
            if self.version == 2 {
                fmi2SetFMUstate(self.c, state)
            } else {
                fmi3SetFMUState(self.c, state)
            }
        }
    }

    /// All that is saved of the present state.
    pub fn bytes(&self) -> Vec<u8> {
        let (state, mut size) = (self.save(), 0);
        let [f, g] = if self.version == 2 {
            [
                fmi2SerializedFMUstateSize as *const (),
                fmi2SerializeFMUstate as *const (),
            ]
        } else {
            [
                fmi3SerializedFMUStateSize as *const (),
                fmi3SerializeFMUState as *const (),
            ]
        };
        unsafe {
            let size_of = mem::transmute::<
                *const (),
                unsafe extern "C-unwind" fn(C, C, *mut usize) -> c_int,
            >(f);
            let write = mem::transmute::<
                *const (),
                unsafe extern "C-unwind" fn(C, C, *mut u8, usize) -> c_int,
            >(g);
            assert_eq!(size_of(self.c, state, &mut size), 0);
            let mut bytes = vec![0; size];
            assert_eq!(write(self.c, state, bytes.as_mut_ptr(), size), 0);
            bytes
        }
    }

    pub fn deserialize(&self, bytes: &[u8]) -> Result<C, String> {
        let mut state = ptr::null_mut();
        let f = if self.version == 2 {
            fmi2DeSerializeFMUstate
        } else {
            fmi3DeserializeFMUState
        };
        match unsafe { f(self.c, bytes.as_ptr(), bytes.len(), &mut state) } {
            0 => Ok(state),
            _ => Err(self.last()),
        }
    }

    /// The last message.
    pub fn last(&self) -> String {
        self.log.lock().unwrap().last().cloned().unwrap_or_default()
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        unsafe {
            if self.version == 2 {
                fmi2FreeInstance(self.c)
            } else {
                fmi3FreeInstance(self.c)
            }
        }
    }
}
