//! The calls of FMI 2.0, over the raw binding of the `fmi` crate.
//!
//! The crate's own `Instance` is not used, because it offers neither `fmi2SetRealInputDerivatives` nor `fmi2GetRealOutputDerivatives`
//! (and keeps the component private), and panics on a missing function, on slices of different length and on `fmi2Pending`.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString};
use std::ptr;
use std::sync::Arc;

use anyhow::{Result, bail};
use fmi::fmi2::binding::Fmi2Binding;
use fmi::fmi2::{CallbackFunctions, binding};
use fmu_description::{Access, Variable};

use super::{Answer, Border, Value};
use crate::batch::Batch;

/// A component; freed when dropped.
pub struct Component {
    api: Arc<Fmi2Binding>,
    component: binding::fmi2Component,
    /// FMI: must outlive the component.
    _callbacks: Box<CallbackFunctions>,
}

impl Component {
    /// `fmi2Instantiate` for co-simulation; None where the FMU gives no component.
    pub fn new(api: &Arc<Fmi2Binding>, name: &CStr, guid: &CStr, resources: &CStr) -> Option<Self> {
        let callbacks = Box::<CallbackFunctions>::default();
        // SAFETY: valid C strings; the callbacks have the layout of fmi2CallbackFunctions and outlive the component.
        let component = unsafe {
            api.fmi2Instantiate(
                name.as_ptr(),
                binding::fmi2Type_fmi2CoSimulation,
                guid.as_ptr(),
                resources.as_ptr(),
                ptr::from_ref(&*callbacks).cast(),
                0,
                1,
            )
        };
        (!component.is_null()).then(|| Self {
            api: api.clone(),
            component,
            _callbacks: callbacks,
        })
    }
}

impl Drop for Component {
    fn drop(&mut self) {
        // SAFETY: freed once; the library is still loaded.
        unsafe { self.api.fmi2FreeInstance(self.component) };
    }
}

impl Border for Component {
    fn log_only(&self, categories: &[CString]) -> Answer {
        let pointers: Vec<_> = categories.iter().map(|c| c.as_ptr()).collect();
        // SAFETY: as many valid C strings as said.
        let status = unsafe {
            let n = pointers.len();
            (self.api).fmi2SetDebugLogging(self.component, 1, n, pointers.as_ptr())
        };
        Answer::new(status, "fmi2SetDebugLogging")
    }

    fn set_one(&self, variable: &Variable, value: &Value) -> Answer {
        let (api, c, vr) = (&self.api, self.component, [variable.reference]);
        // SAFETY: one reference and one value of the type of the call.
        unsafe {
            match value {
                Value::Bits(bits) => match variable.access() {
                    Access::Real => {
                        let status = api.fmi2SetReal(c, vr.as_ptr(), 1, &f64::from_bits(*bits));
                        Answer::new(status, "fmi2SetReal")
                    }
                    Access::Boolean => {
                        let status = api.fmi2SetBoolean(c, vr.as_ptr(), 1, &int(*bits));
                        Answer::new(status, "fmi2SetBoolean")
                    }
                    _ => {
                        let status = api.fmi2SetInteger(c, vr.as_ptr(), 1, &int(*bits));
                        Answer::new(status, "fmi2SetInteger")
                    }
                },
                Value::Text(text) => {
                    let status = api.fmi2SetString(c, vr.as_ptr(), 1, &text.as_ptr());
                    Answer::new(status, "fmi2SetString")
                }
            }
        }
    }

    fn enter_initialization(&self, start: f64) -> Answer {
        // SAFETY: plain values. No stop time: a run may be continued.
        let status =
            unsafe { (self.api).fmi2SetupExperiment(self.component, 0, 0.0, start, 0, 0.0) };
        if !Answer::new(status, "").is_done() {
            return Answer::new(status, "fmi2SetupExperiment");
        }
        // SAFETY: the component is alive.
        let status = unsafe { self.api.fmi2EnterInitializationMode(self.component) };
        Answer::new(status, "fmi2EnterInitializationMode")
    }

    fn exit_initialization(&self) -> Answer {
        // SAFETY: the component is alive.
        let status = unsafe { self.api.fmi2ExitInitializationMode(self.component) };
        Answer::new(status, "fmi2ExitInitializationMode")
    }

    /// Values that are not Real are read one by one: there are few, and no buffer is needed.
    fn get(&self, batch: &Batch, values: &mut [f64]) -> Answer {
        let (api, c, vr) = (&self.api, self.component, &batch.references);
        assert_eq!(vr.len(), values.len());
        if batch.access == Access::Real {
            // SAFETY: as many readable references as there is room for values.
            let status = unsafe { api.fmi2GetReal(c, vr.as_ptr(), vr.len(), values.as_mut_ptr()) };
            return Answer::new(status, "fmi2GetReal");
        }
        let mut answer = Answer::new(0, "fmi2GetInteger");
        for (vr, value) in vr.iter().zip(values) {
            let mut read = 0;
            // SAFETY: one reference and room for one value of the type of the call.
            answer = unsafe {
                match batch.access {
                    Access::Boolean => {
                        Answer::new(api.fmi2GetBoolean(c, vr, 1, &mut read), "fmi2GetBoolean")
                    }
                    _ => Answer::new(api.fmi2GetInteger(c, vr, 1, &mut read), "fmi2GetInteger"),
                }
            };
            if !answer.is_done() {
                break;
            }
            *value = read.into();
        }
        answer
    }

    #[expect(clippy::cast_possible_truncation, reason = "it was an i32")]
    fn set(&self, batch: &Batch, values: &[f64]) -> Answer {
        let (api, c, vr) = (&self.api, self.component, &batch.references);
        assert_eq!(vr.len(), values.len());
        if batch.access == Access::Real {
            // SAFETY: as many readable references as values.
            let status = unsafe { api.fmi2SetReal(c, vr.as_ptr(), vr.len(), values.as_ptr()) };
            return Answer::new(status, "fmi2SetReal");
        }
        let mut answer = Answer::new(0, "fmi2SetInteger");
        for (vr, value) in vr.iter().zip(values) {
            let written = *value as i32;
            // SAFETY: one reference and one value of the type of the call.
            answer = unsafe {
                match batch.access {
                    Access::Boolean => {
                        Answer::new(api.fmi2SetBoolean(c, vr, 1, &written), "fmi2SetBoolean")
                    }
                    _ => Answer::new(api.fmi2SetInteger(c, vr, 1, &written), "fmi2SetInteger"),
                }
            };
            if !answer.is_done() {
                break;
            }
        }
        answer
    }

    fn get_derivatives(&self, batch: &Batch, ones: &[i32], values: &mut [f64]) -> Answer {
        let vr = &batch.references;
        assert!(vr.len() == values.len() && vr.len() <= ones.len());
        // SAFETY: as many readable references and orders as there is room for values.
        let status = unsafe {
            let (n, vr, ones) = (vr.len(), vr.as_ptr(), ones.as_ptr());
            let values = values.as_mut_ptr();
            (self.api).fmi2GetRealOutputDerivatives(self.component, vr, n, ones, values)
        };
        Answer::new(status, "fmi2GetRealOutputDerivatives")
    }

    fn set_derivatives(&self, batch: &Batch, ones: &[i32], values: &[f64]) -> Result<Answer> {
        let vr = &batch.references;
        assert!(vr.len() == values.len() && vr.len() <= ones.len());
        // SAFETY: as many readable references and orders as values.
        let status = unsafe {
            let (n, vr, ones, values) = (vr.len(), vr.as_ptr(), ones.as_ptr(), values.as_ptr());
            (self.api).fmi2SetRealInputDerivatives(self.component, vr, n, ones, values)
        };
        Ok(Answer::new(status, "fmi2SetRealInputDerivatives"))
    }

    fn step(&self, t: f64, h: f64) -> Result<Answer> {
        // SAFETY: plain values.
        let status = unsafe { self.api.fmi2DoStep(self.component, t, h, 1) };
        if status == binding::fmi2Status_fmi2Pending {
            bail!("fmi2DoStep answered fmi2Pending, but steps in the background are not supported");
        }
        Ok(Answer::new(status, "fmi2DoStep"))
    }

    fn time(&self) -> Result<f64> {
        let mut time = f64::NAN;
        // SAFETY: room for one value.
        let status = unsafe {
            let kind = binding::fmi2StatusKind_fmi2LastSuccessfulTime;
            (self.api).fmi2GetRealStatus(self.component, kind, &mut time)
        };
        match Answer::new(status, "").is_done() {
            true => Ok(time),
            false => bail!("fmi2GetRealStatus does not tell the last successful time"),
        }
    }

    /// There is no Event Mode in co-simulation.
    fn enter_events(&self) -> Answer {
        Answer::new(0, "")
    }

    fn update_events(&self) -> Result<(Answer, bool)> {
        Ok((Answer::new(0, ""), false))
    }

    fn leave_events(&self) -> Answer {
        Answer::new(0, "")
    }

    fn terminate(&self) -> Answer {
        // SAFETY: the component is alive.
        let status = unsafe { self.api.fmi2Terminate(self.component) };
        Answer::new(status, "fmi2Terminate")
    }

    fn reset(&self) -> Option<Answer> {
        if self.api.fmi2Reset.is_err() {
            return None;
        }
        // SAFETY: the component is alive, and the library has the function.
        let status = unsafe { self.api.fmi2Reset(self.component) };
        Some(Answer::new(status, "fmi2Reset"))
    }
}

/// An `fmi2Integer` or `fmi2Boolean` from the bits of a value; the reader of values has checked that it fits.
#[expect(clippy::cast_possible_truncation, reason = "checked when it was read")]
fn int(bits: u64) -> i32 {
    bits.cast_signed() as i32
}
