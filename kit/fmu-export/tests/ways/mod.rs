//! An instance of a model with one state and one indicator, driven in one of five ways: both
//! interfaces in both versions, and Co-Simulation of FMI 3.0 with Event Mode too. For the tests
//! `events` and `clocks`, whose importers decide when what is called.

use fmu_export::ffi::{CallbackFunctions, EventInfo, Str};
use fmu_export::{Model, model_description, model_description3};
use std::ffi::{CString, c_int, c_void};
use std::ptr;

pub type C = *mut c_void;
type Call = unsafe extern "C-unwind" fn(C) -> c_int;
type Read = unsafe extern "C-unwind" fn(C, *mut f64, usize) -> c_int;

macro_rules! functions {
    ($($name:ident($($type:ty),*) -> $result:ty;)*) => {
        unsafe extern "C-unwind" { $(fn $name($(_: $type),*) -> $result;)* }
    };
}

#[rustfmt::skip]
functions! {
    fmi2Instantiate(Str, c_int, Str, Str, *const CallbackFunctions, c_int, c_int) -> C; fmi2FreeInstance(C) -> ();
    fmi2EnterInitializationMode(C) -> c_int; fmi2ExitInitializationMode(C) -> c_int; fmi2DoStep(C, f64, f64, c_int) -> c_int;
    fmi2SetReal(C, *const u32, usize, *const f64) -> c_int; fmi2GetReal(C, *const u32, usize, *mut f64) -> c_int;
    fmi2EnterEventMode(C) -> c_int; fmi2NewDiscreteStates(C, *mut EventInfo) -> c_int; fmi2EnterContinuousTimeMode(C) -> c_int;
    fmi2SetTime(C, f64) -> c_int; fmi2SetContinuousStates(C, *const f64, usize) -> c_int;
    fmi2GetEventIndicators(C, *mut f64, usize) -> c_int; fmi2GetContinuousStates(C, *mut f64, usize) -> c_int;
    fmi3InstantiateModelExchange(Str, Str, Str, bool, bool, C, C) -> C; fmi3FreeInstance(C) -> ();
    fmi3InstantiateCoSimulation(Str, Str, Str, bool, bool, bool, bool, *const u32, usize, C, C, C) -> C;
    fmi3EnterInitializationMode(C, bool, f64, f64, bool, f64) -> c_int; fmi3ExitInitializationMode(C) -> c_int;
    fmi3DoStep(C, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int; fmi3EnterStepMode(C) -> c_int;
    fmi3SetFloat64(C, *const u32, usize, *const f64, usize) -> c_int; fmi3GetFloat64(C, *const u32, usize, *mut f64, usize) -> c_int;
    fmi3EnterEventMode(C) -> c_int; fmi3UpdateDiscreteStates(C, *mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;
    fmi3EnterContinuousTimeMode(C) -> c_int; fmi3SetTime(C, f64) -> c_int; fmi3SetContinuousStates(C, *const f64, usize) -> c_int;
    fmi3GetEventIndicators(C, *mut f64, usize) -> c_int; fmi3GetContinuousStates(C, *mut f64, usize) -> c_int;
}

/// How an instance is driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    Exchange2,
    Exchange3,
    Steps2,
    /// Without Event Mode.
    Steps3,
    /// Steps of FMI 3.0 with Event Mode.
    Events3,
}

impl Way {
    pub const ALL: [Self; 5] = [
        Way::Exchange2,
        Way::Exchange3,
        Way::Steps2,
        Way::Steps3,
        Way::Events3,
    ];

    pub fn is_2(self) -> bool {
        matches!(self, Way::Exchange2 | Way::Steps2)
    }

    /// The model description of the version.
    pub fn description<M: Model>(self) -> String {
        match self.is_2() {
            true => model_description::<M>().unwrap(),
            false => model_description3::<M>().unwrap(),
        }
    }
}

/// The value of an attribute behind a mark.
pub fn attribute(xml: &str, mark: &str, name: &str) -> Option<String> {
    let (_, rest) = xml.split_once(mark)?;
    let element = rest.split_once('>')?.0;
    let (_, rest) = element.split_once(&format!(" {name}=\""))?;
    Some(rest.split_once('"')?.0.to_owned())
}

pub struct Instance {
    pub c: C,
    pub way: Way,
}

impl Instance {
    /// Steps may end early where `returns_early`.
    pub fn new<M: Model>(way: Way, returns_early: bool) -> Self {
        let (name, none) = (c"driven".as_ptr(), ptr::null_mut());
        let attribute_name = if way.is_2() {
            "guid"
        } else {
            "instantiationToken"
        };
        let token = attribute(
            &way.description::<M>(),
            "<fmiModelDescription",
            attribute_name,
        );
        let token = CString::new(token.unwrap()).unwrap();
        let token = token.as_ptr();
        let functions = CallbackFunctions {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: none,
        };
        let c = unsafe {
            match way {
                Way::Exchange2 | Way::Steps2 => {
                    let kind = c_int::from(way == Way::Steps2);
                    fmi2Instantiate(name, kind, token, ptr::null(), &functions, 0, 0)
                }
                Way::Exchange3 => {
                    fmi3InstantiateModelExchange(name, token, ptr::null(), false, false, none, none)
                }
                Way::Steps3 | Way::Events3 => fmi3InstantiateCoSimulation(
                    name,
                    token,
                    ptr::null(),
                    false,
                    false,
                    way == Way::Events3,
                    returns_early,
                    ptr::null(),
                    0,
                    none,
                    none,
                    none,
                ),
            }
        };
        assert!(!c.is_null());
        Self { c, way }
    }

    pub fn is_2(&self) -> bool {
        self.way.is_2()
    }

    fn call(&self, two: Call, three: Call) {
        let call = if self.is_2() { two } else { three };
        assert_eq!(unsafe { call(self.c) }, 0);
    }

    pub fn enter_initialization(&self) {
        let status = unsafe {
            match self.is_2() {
                true => fmi2EnterInitializationMode(self.c),
                false => fmi3EnterInitializationMode(self.c, false, 0.0, 0.0, false, 0.0),
            }
        };
        assert_eq!(status, 0);
    }

    pub fn exit_initialization(&self) {
        self.call(fmi2ExitInitializationMode, fmi3ExitInitializationMode);
    }

    pub fn enter_events(&self) {
        self.call(fmi2EnterEventMode, fmi3EnterEventMode);
    }

    pub fn enter_continuous_time(&self) {
        self.call(fmi2EnterContinuousTimeMode, fmi3EnterContinuousTimeMode);
    }

    /// Of FMI 3.0, with Event Mode.
    pub fn enter_steps(&self) {
        assert_eq!(unsafe { fmi3EnterStepMode(self.c) }, 0);
    }

    pub fn set(&self, vr: u32, value: f64) -> c_int {
        unsafe {
            match self.is_2() {
                true => fmi2SetReal(self.c, &vr, 1, &value),
                false => fmi3SetFloat64(self.c, &vr, 1, &value, 1),
            }
        }
    }

    /// A variable of N elements whose first has this reference in FMI 2.0.
    pub fn get<const N: usize>(&self, vr: u32) -> Result<[f64; N], c_int> {
        let (mut values, numbers) = ([f64::NAN; N], Vec::from_iter((vr..).take(N)));
        let to = values.as_mut_ptr();
        let status = unsafe {
            match self.is_2() {
                true => fmi2GetReal(self.c, numbers.as_ptr(), N, to),
                false => fmi3GetFloat64(self.c, &vr, 1, to, N),
            }
        };
        if status == 0 { Ok(values) } else { Err(status) }
    }

    pub fn read(&self, two: Read, three: Read) -> f64 {
        let mut value = f64::NAN;
        let read = if self.is_2() { two } else { three };
        assert_eq!(unsafe { read(self.c, &mut value, 1) }, 0);
        value
    }

    pub fn state(&self) -> f64 {
        self.read(fmi2GetContinuousStates, fmi3GetContinuousStates)
    }

    pub fn indicator(&self) -> f64 {
        self.read(fmi2GetEventIndicators, fmi3GetEventIndicators)
    }

    /// Sets time and state.
    pub fn set_time(&self, t: f64, x: f64) {
        let statuses = unsafe {
            match self.is_2() {
                true => [
                    fmi2SetTime(self.c, t),
                    fmi2SetContinuousStates(self.c, &x, 1),
                ],
                false => [
                    fmi3SetTime(self.c, t),
                    fmi3SetContinuousStates(self.c, &x, 1),
                ],
            }
        };
        assert_eq!(statuses, [0, 0]);
    }

    /// Updates the discrete states once: whether it has to be called again, and the time of the next
    /// event.
    pub fn update(&self) -> (bool, Option<f64>) {
        if self.is_2() {
            let mut info = EventInfo::default();
            assert_eq!(unsafe { fmi2NewDiscreteStates(self.c, &mut info) }, 0);
            let has_next = info.next_event_time_defined != 0;
            return (
                info.new_discrete_states_needed != 0,
                has_next.then_some(info.next_event_time),
            );
        }
        let (mut flags, mut next) = ([false; 5], f64::NAN);
        let [a, b, c, d, e] = flags.each_mut();
        let status = unsafe { fmi3UpdateDiscreteStates(self.c, a, b, c, d, e, &mut next) };
        assert_eq!(status, 0);
        (flags[0], flags[4].then_some(next))
    }

    /// A communication step: whether events have to be handled, the simulation is to end, and the
    /// step has ended early; and where it has ended then.
    pub fn step(&self, t: f64, h: f64) -> ([bool; 3], f64) {
        let (mut flags, mut last) = ([false; 3], t + h);
        let [event, terminate, early] = flags.each_mut();
        let status = unsafe {
            match self.is_2() {
                true => fmi2DoStep(self.c, t, h, 1),
                false => fmi3DoStep(self.c, t, h, true, event, terminate, early, &mut last),
            }
        };
        assert_eq!(status, 0);
        (flags, last)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        unsafe {
            if self.is_2() {
                fmi2FreeInstance(self.c)
            } else {
                fmi3FreeInstance(self.c)
            }
        }
    }
}
