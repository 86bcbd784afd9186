//! The calls of FMI 2.0.

use std::any::Any;
use std::cell::Cell;
use std::ffi::{CString, c_int};
use std::rc::Rc;
use std::sync::Arc;

use anyhow::{Result, bail};
use fmi_description::Access;

use crate::answer::{Answer, Ended, call};
use crate::batch::Batch;
use crate::calls::Functions2;
use crate::fmi_instance::{Call, FmiInstance};
use crate::raw::{Array, Experiment, RawInstance};
use crate::saved;
use crate::standard::Pointer;
use crate::status::{self, PENDING};
use crate::value::{Value, fits};

/// `fmi2Terminated`.
const TERMINATED: c_int = 3;

/// A component; freed when dropped.
pub struct Component {
    api: Arc<Functions2>,
    component: Pointer,
    /// Start of the run that it was set up for, s; NaN: for none.
    start: Cell<f64>,
    raw: Rc<RawInstance>,
}

impl Component {
    /// Of an instance whose functions these are.
    pub fn new(api: Arc<Functions2>, raw: RawInstance) -> Self {
        Self {
            api,
            component: raw.pointer(),
            start: Cell::new(f64::NAN),
            raw: Rc::new(raw),
        }
    }

    /// No stop time: a run may be continued.
    fn set_up(&self, start: f64) -> Result<()> {
        self.start.set(start);
        let experiment = Experiment {
            start,
            ..Experiment::default()
        };
        Answer::check(self.raw.begin(experiment), "fmi2SetupExperiment")
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
        if status == Some(status::DISCARD) {
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
        let mut time = f64::NAN;
        let told = Answer::check(self.raw.last_time(&mut time), "fmi2GetRealStatus");
        match told {
            Ok(()) => Ok(time),
            Err(_) => bail!("fmi2GetRealStatus does not tell the last successful time"),
        }
    }
}

impl FmiInstance for Component {
    fn log_only(&self, categories: &[CString]) -> Result<()> {
        let names: Vec<_> = categories.iter().map(|c| Some(c.as_c_str())).collect();
        let status = self.raw.set_debug_logging(true, Array::Elements(&names));
        Answer::check(status, "fmi2SetDebugLogging")
    }

    /// Only texts do not pass as numbers.
    fn get_whole(&self, batch: &Batch, values: &mut [Value]) -> Result<()> {
        assert!(batch.access == Access::String && batch.references.len() == values.len());
        for (vr, value) in batch.references.iter().zip(values) {
            let (status, texts) = self.raw.get_strings(&[*vr], 1);
            Answer::check(status, "fmi2GetString")?;
            *value = Value::Text(texts.unwrap_or_default().pop().unwrap_or_default());
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
                return Answer::refuse(status::UNFIT, "fmi2SetInteger");
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
        let (vr, ones) = (&batch.references, &batch.ones);
        let status = self.raw.get_output_derivatives(vr, ones, values);
        Answer::check(status, "fmi2GetRealOutputDerivatives")
    }

    fn set_derivatives(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        let (vr, ones) = (&batch.references, &batch.ones);
        let status = self.raw.set_input_derivatives(vr, ones, values);
        Answer::check(status, "fmi2SetRealInputDerivatives")
    }

    fn directional(&self, of: [&Batch; 2], seeds: &[f64], rates: &mut [f64]) -> Result<()> {
        let [y, u] = of.map(|batch| &batch.references[..]);
        let status = self.raw.get_directional_derivative(y, u, seeds, rates);
        Answer::check(status, "fmi2GetDirectionalDerivative")
    }

    fn save(&self) -> Result<Box<dyn Any>> {
        saved::save(&self.raw, self.start.get())
    }

    fn restore(&self, state: &dyn Any) -> Result<()> {
        self.start.set(*saved::restore(&self.raw, state)?);
        Ok(())
    }

    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>> {
        saved::to_bytes::<f64>(&self.raw, state)
    }

    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>> {
        saved::from_bytes::<f64>(&self.raw, bytes)
    }

    fn reset(&self) -> bool {
        self.start.set(f64::NAN);
        Answer::check(self.raw.reset(), "fmi2Reset").is_ok()
    }
}

/// An `fmi2Integer` or `fmi2Boolean`, checked to fit before.
fn int(value: &Value) -> i32 {
    value.bits().cast_signed() as i32
}
