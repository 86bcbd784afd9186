//! An instance of FMI 2.0 behind [`FmiInstance`], made by `instantiate`: what a co-simulation
//! master asks of it, done by the C functions of this version.

use std::any::Any;
use std::cell::Cell;
use std::ffi::CString;
use std::rc::Rc;
use std::slice::from_ref;

use anyhow::{Result, bail};
use fmi_description::Access;

use crate::answer::{Answer, Ended};
use crate::batch::Batch;
use crate::encoding::{load, number, store};
use crate::fmi_instance::{Call, FmiInstance};
use crate::raw::{Array, Experiment, RawInstance, StepEnd, Update};
use crate::saved;
use crate::status::{DISCARD, NO_TEXT, OK, PENDING, UNFIT, WARNING};
use crate::value::{Value, fits};

/// An instance of FMI 2.0; freed when dropped.
pub struct Fmi2Instance {
    /// Start time that fmi2SetupExperiment was given, s; NaN before that.
    start: Cell<f64>,
    /// Time that it was set to, and of the next event that it announced, s: Model Exchange only.
    time: Cell<f64>,
    announced: Cell<f64>,
    raw: Rc<RawInstance>,
}

impl Fmi2Instance {
    pub fn new(raw: Rc<RawInstance>) -> Self {
        Self {
            start: Cell::new(f64::NAN),
            time: Cell::new(f64::NAN),
            announced: Cell::new(f64::INFINITY),
            raw,
        }
    }

    /// Updates discrete states once, in Event Mode of Model Exchange; returns whether another update
    /// is needed.
    fn update_events(&self) -> Result<f64> {
        let (call, mut update) = ("fmi2NewDiscreteStates", Update::default());
        Answer::check(self.raw.update_discrete_states(&mut update), call)?;
        self.announced.set(update.next);
        if update.terminates {
            let time = self.time.get();
            bail!(Ended { call, time });
        }
        Ok(f64::from(u8::from(update.again)))
    }

    fn set_up(&self, experiment: Experiment) -> Result<()> {
        self.start.set(experiment.start);
        let status = self.raw.begin(experiment);
        Answer::check(status, "fmi2SetupExperiment")
    }

    fn step(&self, t: f64, h: f64) -> Result<()> {
        let status = self.raw.do_step(t, h, 1, &mut StepEnd::default());
        if status == PENDING {
            bail!("fmi2DoStep answered fmi2Pending, but steps in the background are not supported");
        }
        if status == DISCARD {
            let mut ends = 0;
            let told = self.raw.is_terminated(&mut ends);
            if matches!(told, OK | WARNING) && ends != 0 {
                let (call, time) = ("fmi2DoStep", self.time().unwrap_or(t));
                bail!(Ended { call, time });
            }
        }
        Answer::check(status, "fmi2DoStep")
    }

    fn time(&self) -> Result<f64> {
        let mut time = f64::NAN;
        match self.raw.last_time(&mut time) {
            OK | WARNING => Ok(time),
            _ => bail!("fmi2GetRealStatus does not tell the last successful time"),
        }
    }

    /// Sets one number of a type, whose 64 bits are as in [`Value::bits`].
    fn set_number(&self, access: Access, vr: &u32, bits: u64) -> Result<()> {
        let (functions, mut passed) = (self.raw.functions(), [0]);
        store(functions.c_type(access), &mut passed, 0, bits);
        let (vr, passed) = (from_ref(vr), Array::Elements(&passed[..]));
        let status = self.raw.set_numbers(access, Array::Elements(vr), passed, 1);
        Answer::check_named(status, || functions.names_of(access)[1])
    }
}

impl FmiInstance for Fmi2Instance {
    fn log_only(&self, categories: &[CString]) -> Result<()> {
        let names: Vec<_> = categories.iter().map(|c| Some(c.as_c_str())).collect();
        let status = self.raw.set_debug_logging(true, Array::Elements(&names));
        Answer::check(status, "fmi2SetDebugLogging")
    }

    /// String is the only type of FMI 2.0 whose values are not numbers.
    fn get_values(&self, batch: &Batch, values: &mut [Value]) -> Result<()> {
        assert!(batch.access == Access::String && batch.references.len() == values.len());
        for (vr, value) in batch.references.iter().zip(values) {
            let (status, texts) = self.raw.get_strings(&[*vr], 1);
            Answer::check(status, "fmi2GetString")?;
            let Some(mut texts) = texts else {
                return Answer::refuse(NO_TEXT, "fmi2GetString");
            };
            *value = Value::Text(texts.pop().unwrap_or_default());
        }
        Ok(())
    }

    fn set_values(&self, batch: &Batch, values: &[Value]) -> Result<()> {
        for (vr, value) in batch.references.iter().zip(values) {
            if let Value::Text(text) = value {
                let status = self.raw.set_strings(from_ref(vr), &[Some(text)]);
                Answer::check(status, "fmi2SetString")?;
            } else {
                self.set_number(batch.access, vr, value.bits())?;
            }
        }
        Ok(())
    }

    fn call(&self, call: Call) -> Result<f64> {
        let raw = &self.raw;
        let (status, name) = match call {
            Call::Step(t, h) => return self.step(t, h).map(|()| 0.0),
            Call::SetUp(experiment) => return self.set_up(experiment).map(|()| 0.0),
            Call::EnterInitialization(start) => {
                self.time.set(start);
                if self.start.get() != start {
                    self.set_up(Experiment::from_start(start))?;
                }
                let status = raw.enter_initialization_mode(Experiment::default());
                (status, "fmi2EnterInitializationMode")
            }
            Call::ExitInitialization => {
                (raw.exit_initialization_mode(), "fmi2ExitInitializationMode")
            }
            Call::Time => return self.time(),
            Call::NextEvent => return Ok(f64::INFINITY),
            Call::NextTimeEvent => return Ok(self.announced.get()),
            Call::UpdateEvents => return self.update_events(),
            Call::SetTime(time) => {
                self.time.set(time);
                (raw.set_time(time), "fmi2SetTime")
            }
            Call::EnterEvents => (raw.enter_event_mode(), "fmi2EnterEventMode"),
            Call::LeaveEvents => (
                raw.enter_continuous_time_mode(),
                "fmi2EnterContinuousTimeMode",
            ),
            Call::Terminate => (raw.terminate(), "fmi2Terminate"),
            Call::StopEarly(_)
            | Call::InEvents
            | Call::EnterConfiguration
            | Call::ExitConfiguration
            | Call::Settle
            | Call::Tick(..) => return Ok(0.0),
        };
        Answer::check(status, name).map(|()| 0.0)
    }

    /// Values that are not Real are read one by one: there are few, and no buffer is needed.
    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        let (access, references) = (batch.access, &batch.references[..]);
        assert_eq!(references.len(), values.len());
        if access == Access::Real {
            let vr = Array::Elements(references);
            return Answer::check(self.raw.get_reals(vr, Some(values)), "fmi2GetReal");
        }
        let functions = self.raw.functions();
        for (vr, value) in references.iter().zip(values) {
            let (vr, mut read) = (Array::Elements(from_ref(vr)), [0]);
            let status = self.raw.get_numbers(access, vr, Some(&mut read), 1);
            Answer::check_named(status, || functions.names_of(access)[0])?;
            *value = number(Access::Integer, load(Access::Integer, &read, 0));
        }
        Ok(())
    }

    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        let (access, references) = (batch.access, &batch.references[..]);
        assert_eq!(references.len(), values.len());
        if access == Access::Real {
            let (vr, values) = (Array::Elements(references), Array::Elements(values));
            return Answer::check(self.raw.set_reals(vr, values), "fmi2SetReal");
        }
        for (vr, value) in references.iter().zip(values) {
            if !fits(access, *value as i128) {
                return Answer::refuse(UNFIT, "fmi2SetInteger");
            }
            let bits = i64::from(*value as i32).cast_unsigned();
            self.set_number(access, vr, bits)?;
        }
        Ok(())
    }

    fn get_derivatives(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        let (vr, orders) = (&batch.references, &batch.first_orders);
        let status = self.raw.get_output_derivatives(vr, orders, values);
        Answer::check(status, "fmi2GetRealOutputDerivatives")
    }

    fn set_derivatives(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        let (vr, orders) = (&batch.references, &batch.first_orders);
        let status = self.raw.set_input_derivatives(vr, orders, values);
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
        self.raw.begin_anew();
        Answer::check(self.raw.reset(), "fmi2Reset").is_ok()
    }
}
