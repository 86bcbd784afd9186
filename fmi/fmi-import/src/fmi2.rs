//! The calls of FMI 2.0.
#![allow(unsafe_code)]

use std::any::Any;
use std::cell::Cell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;
use std::rc::Rc;
use std::sync::Arc;

use anyhow::{Result, bail};
use fmi_description::Access;
use fmi_import::calls::{Callbacks, Functions2};
use fmi_import::standard::Pointer;

use super::answer::{Answer, Ended, call};
use super::border::{Arguments, Border, Call};
use super::fmi3::owned;
use super::messages::{Speaker, receive};
use super::owner::{Owner, StateFunctions, state_functions};
use crate::io::value::{Value, fits};
use crate::wiring::batch::Batch;

/// `fmi2CoSimulation`.
const CO_SIMULATION: c_int = 1;
/// `fmi2Pending`.
const PENDING: c_int = 5;
/// `fmi2LastSuccessfulTime`.
const LAST_SUCCESSFUL_TIME: c_int = 2;
/// `fmi2Terminated`.
const TERMINATED: c_int = 3;

unsafe extern "C" {
    /// The logger of FMI 2.0, in logger.c.
    fn cosim_logger(
        environment: *mut c_void,
        instance: *const c_char,
        status: c_int,
        category: *const c_char,
        message: *const c_char,
        ...
    );
}

/// What [`cosim_logger`] calls with the formatted text.
#[unsafe(no_mangle)]
unsafe extern "C" fn cosim_receive(
    environment: *mut c_void,
    _instance: *const c_char,
    status: c_int,
    text: *const c_char,
) {
    // SAFETY: a C string of the logger's own.
    let text = unsafe { CStr::from_ptr(text) };
    receive(environment.addr(), status, &text.to_string_lossy());
}

/// A component; freed when dropped.
pub struct Component {
    api: Arc<Functions2>,
    component: Pointer,
    /// Start of the run that it was set up for, s; NaN: for none.
    start: Cell<f64>,
    owner: Rc<Owner>,
}

impl Component {
    /// `fmi2Instantiate` for co-simulation; None where the FMU gives no component.
    pub fn new(api: &Arc<Functions2>, arguments: &Arguments) -> Result<Option<Self>> {
        if !api.exports("fmi2Instantiate") || !api.exports("fmi2FreeInstance") {
            bail!("its library does not export fmi2Instantiate and fmi2FreeInstance");
        }
        let speaker = Speaker::new(&arguments.name);
        let callbacks = Box::new(Callbacks {
            logger: cosim_logger as *const c_void,
            allocate_memory: Some(libc::calloc),
            free_memory: Some(libc::free),
            step_finished: ptr::null(),
            environment: speaker.environment(),
        });
        // SAFETY: valid C strings; the callbacks outlive the component.
        let component = unsafe {
            let texts = [&arguments.name, &arguments.token, &arguments.resources];
            let [name, guid, resources] = texts.map(|text| text.as_ptr());
            (api.fmi2Instantiate)(name, CO_SIMULATION, guid, resources, &*callbacks, 0, 1)
        };
        let functions = state_functions!(api, fmi2FreeInstance fmi2FreeFMUstate;
            get fmi2GetFMUstate set fmi2SetFMUstate size fmi2SerializedFMUstateSize
            write fmi2SerializeFMUstate read fmi2DeSerializeFMUstate);
        // FMI: the callbacks must outlive the component.
        let kept = (api.clone(), callbacks, speaker);
        Ok((!component.is_null()).then(|| Self {
            api: api.clone(),
            component,
            start: Cell::new(f64::NAN),
            // SAFETY: the component and the functions of its library.
            owner: unsafe { Owner::new(component, functions, kept) },
        }))
    }

    /// No stop time: a run may be continued.
    fn set_up(&self, start: f64) -> Result<()> {
        let (api, c) = (&self.api, self.component);
        self.start.set(start);
        // SAFETY: plain values.
        unsafe { call!(api, fmi2SetupExperiment(c, 0, 0.0, start, 0, 0.0)) }
    }

    fn step(&self, t: f64, h: f64) -> Result<()> {
        let (api, c) = (&self.api, self.component);
        // SAFETY: plain values.
        let Err(error) = (unsafe { call!(api, fmi2DoStep(c, t, h, 1)) }) else {
            return Ok(());
        };
        let status = Answer::status(&error);
        if status == Some(PENDING) {
            bail!("fmi2DoStep answered fmi2Pending, but steps in the background are not supported");
        }
        let (mut ends, kind) = (0, TERMINATED);
        if status == Some(Answer::DISCARD) {
            // SAFETY: room for one value.
            let told = unsafe { call!(api, fmi2GetBooleanStatus(c, kind, &mut ends)) };
            if told.is_ok() && ends != 0 {
                let (call, time) = ("fmi2DoStep", self.time().unwrap_or(t));
                bail!(Ended { call, time });
            }
        }
        Err(error)
    }

    fn time(&self) -> Result<f64> {
        let (mut time, kind) = (f64::NAN, LAST_SUCCESSFUL_TIME);
        // SAFETY: room for one value.
        let told = unsafe { call!(self.api, fmi2GetRealStatus(self.component, kind, &mut time)) };
        match told {
            Ok(()) => Ok(time),
            Err(_) => bail!("fmi2GetRealStatus does not tell the last successful time"),
        }
    }
}

impl Border for Component {
    fn log_only(&self, categories: &[CString]) -> Result<()> {
        let pointers: Vec<_> = categories.iter().map(|c| c.as_ptr()).collect();
        let (api, c, n) = (&self.api, self.component, pointers.len());
        // SAFETY: as many valid C strings as said.
        unsafe { call!(api, fmi2SetDebugLogging(c, 1, n, pointers.as_ptr())) }
    }

    /// Only texts do not pass as numbers.
    fn get_whole(&self, batch: &Batch, values: &mut [Value]) -> Result<()> {
        assert!(batch.access == Access::String && batch.references.len() == values.len());
        for (vr, value) in batch.references.iter().zip(values) {
            let mut text = ptr::null();
            // SAFETY: one reference and room for one text, which is valid until the next call.
            unsafe {
                call!(self.api, fmi2GetString(self.component, vr, 1, &mut text))?;
                *value = Value::Text(owned(text));
            }
        }
        Ok(())
    }

    fn set_whole(&self, batch: &Batch, values: &[Value]) -> Result<()> {
        let (api, c) = (&self.api, self.component);
        for (vr, value) in batch.references.iter().zip(values) {
            // SAFETY: one reference and one value of the type of the call.
            unsafe {
                match (value, batch.access) {
                    (Value::Real(number), _) => call!(api, fmi2SetReal(c, vr, 1, number)),
                    (Value::Text(text), _) => call!(api, fmi2SetString(c, vr, 1, &text.as_ptr())),
                    (_, Access::Boolean) => call!(api, fmi2SetBoolean(c, vr, 1, &int(value))),
                    _ => call!(api, fmi2SetInteger(c, vr, 1, &int(value))),
                }?;
            }
        }
        Ok(())
    }

    fn call(&self, call: Call) -> Result<f64> {
        let (api, c) = (&self.api, self.component);
        // SAFETY: the component is alive.
        let done = unsafe {
            match call {
                Call::Step(t, h) => self.step(t, h),
                Call::SetUp(start) => self.set_up(start),
                Call::EnterInitialization(start) => {
                    if self.start.get() != start {
                        self.set_up(start)?;
                    }
                    call!(api, fmi2EnterInitializationMode(c))
                }
                Call::ExitInitialization => call!(api, fmi2ExitInitializationMode(c)),
                Call::Time => return self.time(),
                Call::NextEvent => return Ok(f64::INFINITY),
                Call::Terminate => call!(api, fmi2Terminate(c)),
                Call::StopEarly(_)
                | Call::EnterEvents
                | Call::UpdateEvents
                | Call::LeaveEvents
                | Call::Settle
                | Call::Tick(..) => Ok(()),
            }
        };
        done.map(|()| 0.0)
    }

    /// Values that are not Real are read one by one: there are few, and no buffer is needed.
    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        let (api, c, vr) = (&self.api, self.component, &batch.references);
        assert_eq!(vr.len(), values.len());
        if batch.access == Access::Real {
            let (vr, n, values) = (vr.as_ptr(), vr.len(), values.as_mut_ptr());
            // SAFETY: as many readable references as there is room for values.
            return unsafe { call!(api, fmi2GetReal(c, vr, n, values)) };
        }
        for (vr, value) in vr.iter().zip(values) {
            let mut read = 0;
            // SAFETY: one reference and room for one value of the type of the call.
            unsafe {
                match batch.access {
                    Access::Boolean => call!(api, fmi2GetBoolean(c, vr, 1, &mut read)),
                    _ => call!(api, fmi2GetInteger(c, vr, 1, &mut read)),
                }?;
            }
            *value = read.into();
        }
        Ok(())
    }

    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        let (api, c, vr) = (&self.api, self.component, &batch.references);
        assert_eq!(vr.len(), values.len());
        if batch.access == Access::Real {
            // SAFETY: as many readable references as values.
            return unsafe { call!(api, fmi2SetReal(c, vr.as_ptr(), vr.len(), values.as_ptr())) };
        }
        for (vr, value) in vr.iter().zip(values) {
            if !fits(batch.access, *value as i128) {
                return Answer::refuse(Answer::UNFIT, "fmi2SetInteger");
            }
            let written = *value as i32;
            // SAFETY: one reference and one value of the type of the call.
            unsafe {
                match batch.access {
                    Access::Boolean => call!(api, fmi2SetBoolean(c, vr, 1, &written)),
                    _ => call!(api, fmi2SetInteger(c, vr, 1, &written)),
                }?;
            }
        }
        Ok(())
    }

    fn get_derivatives(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        let (vr, n) = (batch.references.as_ptr(), batch.references.len());
        assert_eq!(n, values.len());
        let (api, c, values) = (&self.api, self.component, values.as_mut_ptr());
        let ones = batch.ones.as_ptr();
        // SAFETY: as many readable references and orders as there is room for values.
        unsafe { call!(api, fmi2GetRealOutputDerivatives(c, vr, n, ones, values)) }
    }

    fn set_derivatives(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        let (vr, n) = (batch.references.as_ptr(), batch.references.len());
        assert_eq!(n, values.len());
        let (api, c, values) = (&self.api, self.component, values.as_ptr());
        let ones = batch.ones.as_ptr();
        // SAFETY: as many readable references and orders as values.
        unsafe { call!(api, fmi2SetRealInputDerivatives(c, vr, n, ones, values)) }
    }

    fn directional(&self, of: [&Batch; 2], seeds: &[f64], rates: &mut [f64]) -> Result<()> {
        let [outputs, inputs] = of;
        let (n, m) = (outputs.references.len(), inputs.references.len());
        assert!(n == rates.len() && m == seeds.len());
        let (y, u) = (outputs.references.as_ptr(), inputs.references.as_ptr());
        // SAFETY: as many readable references as seeds, and as there is room for rates.
        unsafe {
            let (api, c, seeds, rates) = (
                &self.api,
                self.component,
                seeds.as_ptr(),
                rates.as_mut_ptr(),
            );
            call!(
                api,
                fmi2GetDirectionalDerivative(c, y, n, u, m, seeds, rates)
            )
        }
    }

    fn save(&self) -> Result<Box<dyn Any>> {
        self.owner.save(self.start.get())
    }

    fn restore(&self, state: &dyn Any) -> Result<()> {
        self.start.set(*self.owner.restore(state)?);
        Ok(())
    }

    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>> {
        self.owner.to_bytes::<f64>(state)
    }

    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>> {
        self.owner.from_bytes::<f64>(bytes)
    }

    fn reset(&self) -> bool {
        self.start.set(f64::NAN);
        // SAFETY: the component is alive.
        unsafe { call!(self.api, fmi2Reset(self.component)) }.is_ok()
    }
}

/// An `fmi2Integer` or `fmi2Boolean`, checked to fit before.
fn int(value: &Value) -> i32 {
    value.bits().cast_signed() as i32
}
