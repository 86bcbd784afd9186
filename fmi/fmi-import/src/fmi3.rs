//! An instance of FMI 3.0 behind [`FmiInstance`], made by `instantiate`: what a master asks of it,
//! done by the C functions of this version. FMI 3.0 passes whole arrays and exchanges clocked
//! variables at ticks only, so the instance keeps a memory of all values that it was given.

mod events;
mod values;

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::ffi::CString;
use std::rc::Rc;
use std::sync::Arc;

use anyhow::{Result, bail};
use fmi_description::Access;
use serde::{Deserialize, Serialize};

use crate::answer::{Answer, Ended, Stopped};
use crate::batch::{Batch, Layout};
use crate::clocks::{Clock, ClockPlan, TickTimes};
use crate::digits::short;
use crate::encoding::{as_bits, load, number};
use crate::fmi_instance::{Arguments, Call, FmiInstance};
use crate::raw::{Array, BinaryRoom, Experiment, RawInstance, StepEnd};
use crate::saved;
use crate::status::UNFIT;
use crate::value::{Value, fits};

/// How many early returns there may be in a row that advance by less than a millionth of the step.
const MAX_RETURNS: usize = 1000;

/// The state of the instance in the state machine of the standard, as far as it matters here.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
enum Mode {
    /// Instantiated or Initialization Mode.
    Initialization,
    Event,
    Step,
}

/// What is tracked of an instance, and saved with the state of its FMU.
#[derive(Clone, Deserialize, Serialize)]
struct Tracked {
    mode: Cell<Mode>,
    /// End of the last step, s.
    time: Cell<f64>,
    /// Last value of each element that was set, and of clocked ones that was read at a tick, by
    /// slot of the [`Layout`].
    memory: RefCell<Vec<u64>>,
    /// The same for texts and bytes.
    texts: RefCell<BTreeMap<usize, Value>>,
    clocks: RefCell<Vec<TickTimes>>,
    /// References of the clocks that are active.
    active: RefCell<Vec<u32>>,
    /// Time of the next event that the FMU announced, s.
    announced: Cell<f64>,
}

/// An instance of FMI 3.0; freed when dropped.
pub struct Fmi3Instance {
    /// It was instantiated for Model Exchange.
    is_exchange: bool,
    has_events: bool,
    returns_early: bool,
    /// A step that ends early is not continued, but reported as [`Stopped`].
    stops_early: Cell<bool>,
    /// What the run is told to be, until it begins.
    experiment: Cell<Experiment>,
    tracked: Tracked,
    /// An event that was not updated yet: one that a step has found, or a discrete input changed.
    has_event: Cell<bool>,
    /// Output clocks that are connected: their ticks are passed on.
    listened: RefCell<Vec<u32>>,
    /// Clocks of model partitions that others have ticked, until their inputs are there.
    waiting: RefCell<Vec<u32>>,
    /// Workspace for the values that one call passes.
    passed: RefCell<Vec<u64>>,
    /// The same for bytes.
    binaries: RefCell<BinaryRoom>,
    /// Workspace for the derivatives that one call passes.
    rates: RefCell<Vec<f64>>,
    plan: Arc<ClockPlan>,
    raw: Rc<RawInstance>,
}

impl Fmi3Instance {
    /// `raw` must have just been instantiated with these arguments.
    pub fn new(
        raw: Rc<RawInstance>,
        layout: &Layout,
        plan: &Arc<ClockPlan>,
        arguments: &Arguments,
        is_exchange: bool,
    ) -> Self {
        Self {
            is_exchange,
            has_events: arguments.has_events || is_exchange,
            returns_early: arguments.returns_early,
            stops_early: Cell::new(false),
            experiment: Cell::new(Experiment::from_start(f64::NAN)),
            tracked: Tracked {
                mode: Cell::new(Mode::Initialization),
                time: Cell::new(f64::NAN),
                memory: RefCell::new(layout.initial.clone()),
                texts: RefCell::new(layout.texts.clone()),
                clocks: RefCell::new(plan.clocks.iter().map(Clock::initial_ticks).collect()),
                active: RefCell::new(Vec::with_capacity(plan.count())),
                announced: Cell::new(f64::INFINITY),
            },
            has_event: Cell::new(false),
            listened: RefCell::default(),
            waiting: RefCell::new(Vec::with_capacity(plan.count())),
            binaries: RefCell::default(),
            passed: RefCell::new(vec![0; layout.initial.len()]),
            rates: RefCell::new(vec![0.0; layout.initial.len()]),
            plan: plan.clone(),
            raw,
        }
    }

    fn enter_initialization(&self, start: f64) -> Result<()> {
        self.tracked.time.set(start);
        let told = Some(self.experiment.get()).filter(|told| told.start == start);
        let status = (self.raw).begin(told.unwrap_or(Experiment::from_start(start)));
        Answer::check(status, "fmi3EnterInitializationMode")
    }

    /// To Event Mode if the master uses it, else to Step Mode.
    fn exit_initialization(&self) -> Result<()> {
        if self.has_events {
            self.start_clocks()?;
        }
        self.tracked.mode.set(match self.has_events {
            true => Mode::Event,
            false => Mode::Step,
        });
        let status = self.raw.exit_initialization_mode();
        Answer::check(status, "fmi3ExitInitializationMode")
    }

    /// Makes a step. One that ends early is continued after its event, unless `stops_early` is set.
    fn step(&self, t: f64, h: f64) -> Result<()> {
        if self.tracked.mode.get() == Mode::Event {
            self.settle()?;
        }
        if self.plan.is_scheduled {
            self.tracked.time.set(t + h);
            return Ok(());
        }
        let (mut from, mut rest, mut stays) = (t, h, 0);
        loop {
            let mut step = StepEnd {
                time: self.tracked.time.get(),
                ..StepEnd::default()
            };
            let (call, status) = ("fmi3DoStep", self.raw.do_step(from, rest, 1, &mut step));
            Answer::check(status, call)?;
            let StepEnd { early, time, .. } = step;
            self.tracked.time.set(time);
            if step.terminates {
                bail!(Ended { call, time });
            }
            if early && !self.returns_early {
                bail!(
                    "fmi3DoStep returned early, at {} s, which it was not allowed to",
                    short(time)
                );
            }
            let end = t + h;
            let is_short = early && end - time > f64::EPSILON * end.abs();
            if is_short && self.stops_early.get() {
                let (name, time) = (String::new(), Some(time));
                bail!(Stopped { name, time });
            }
            if step.event_needed && self.has_events {
                self.enter_events()?;
                self.has_event.set(true);
                // The event of a whole step is handled by the master, who passes ticks on.
                if is_short || self.listened.borrow().is_empty() {
                    self.settle()?;
                }
            }
            if !is_short {
                return Ok(());
            }
            stays = if time - from > 1e-6 * h { 0 } else { stays + 1 };
            if stays == MAX_RETURNS {
                bail!(
                    "fmi3DoStep returned early {MAX_RETURNS} times in a row and hardly advanced, at {} s",
                    short(time)
                );
            }
            (from, rest) = (time, end - time);
        }
    }
}

impl FmiInstance for Fmi3Instance {
    fn log_only(&self, categories: &[CString]) -> Result<()> {
        let names: Vec<_> = categories.iter().map(|c| Some(c.as_c_str())).collect();
        // Instantiation switches all categories on, so that the FMU can report why it fails.
        for (on, names) in [(false, Array::Null(0)), (true, Array::Elements(&names[..]))] {
            let status = self.raw.set_debug_logging(on, names);
            Answer::check(status, "fmi3SetDebugLogging")?;
        }
        Ok(())
    }

    fn call(&self, call: Call) -> Result<f64> {
        let done = match call {
            Call::Step(t, h) => self.step(t, h),
            // FMI 3.0 has no call before Initialization Mode for this.
            Call::SetUp(experiment) => {
                self.experiment.set(experiment);
                Ok(())
            }
            Call::EnterConfiguration => {
                let status = self.raw.enter_configuration_mode();
                Answer::check(status, "fmi3EnterConfigurationMode")
            }
            Call::ExitConfiguration => {
                let status = self.raw.exit_configuration_mode();
                Answer::check(status, "fmi3ExitConfigurationMode")
            }
            Call::EnterInitialization(start) => self.enter_initialization(start),
            Call::ExitInitialization => self.exit_initialization(),
            Call::Time => return Ok(self.tracked.time.get()),
            Call::StopEarly(stops) => {
                self.stops_early.set(stops);
                Ok(())
            }
            Call::EnterEvents => self.enter_events(),
            Call::InEvents => return Ok(self.in_events()),
            Call::UpdateEvents => {
                return self.update_events().map(|again| f64::from(u8::from(again)));
            }
            Call::LeaveEvents => self.leave_events(),
            Call::Settle => self.settle(),
            Call::NextEvent => return Ok(self.next_event()),
            Call::NextTimeEvent => return Ok(self.tracked.announced.get()),
            Call::SetTime(time) => {
                self.tracked.time.set(time);
                Answer::check(self.raw.set_time(time), "fmi3SetTime")
            }
            Call::Tick(t, tolerance) => self.tick(t, tolerance),
            Call::Terminate => Answer::check(self.raw.terminate(), "fmi3Terminate"),
        };
        done.map(|()| 0.0)
    }

    fn get_values(&self, batch: &Batch, values: &mut [Value]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        if self.is_accessible(batch) {
            self.read_to_memory(batch)?;
        }
        let (memory, texts) = (self.tracked.memory.borrow(), self.tracked.texts.borrow());
        for (value, slot) in values.iter_mut().zip(&batch.slots) {
            match batch.access {
                Access::String | Access::Binary => match texts.get(slot) {
                    Some(text) => value.clone_from(text),
                    None => *value = Value::empty(batch.access),
                },
                Access::UInt64 => *value = Value::Whole(memory[*slot].into()),
                _ => *value = Value::Whole(memory[*slot].cast_signed().into()),
            }
        }
        Ok(())
    }

    fn set_values(&self, batch: &Batch, values: &[Value]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        let is_text = matches!(batch.access, Access::String | Access::Binary);
        self.enter_events_if(batch, |slot, k| match is_text {
            true => self.tracked.texts.borrow().get(&slot) != Some(&values[k]),
            false => self.tracked.memory.borrow()[slot] != values[k].bits(),
        })?;
        for (value, slot) in values.iter().zip(&batch.slots) {
            match is_text {
                true => self.keep_text(*slot, value),
                false => self.tracked.memory.borrow_mut()[*slot] = value.bits(),
            }
        }
        self.set_if_accessible(batch)
    }

    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        if batch.access == Access::Clock {
            return self.get_clocks(&batch.references, values);
        }
        if !batch.clocks.is_empty() {
            if self.is_accessible(batch) {
                self.read_to_memory(batch)?;
            }
            let memory = self.tracked.memory.borrow();
            for (value, slot) in values.iter_mut().zip(&batch.slots) {
                *value = number(batch.access, memory[*slot]);
            }
            return Ok(());
        }
        if batch.is_whole && batch.access == Access::Real {
            let vr = Array::Elements(&batch.references[..]);
            return Answer::check(self.raw.get_reals(vr, Some(values)), "fmi3GetFloat64");
        }
        let mut passed = self.passed.borrow_mut();
        self.get_numbers(batch, &mut passed)?;
        for (value, place) in values.iter_mut().zip(&batch.places) {
            *value = number(batch.access, load(batch.access, &passed, *place));
        }
        Ok(())
    }

    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        let access = batch.access;
        if access == Access::Clock {
            return self.set_clocks(&batch.references, values);
        }
        let is_float = matches!(access, Access::Real | Access::Float32);
        if !is_float && values.iter().any(|value| !fits(access, *value as i128)) {
            return Answer::refuse(UNFIT, "fmi3Set");
        }
        self.enter_events_if(batch, |slot, k| {
            as_bits(access, values[k]) != self.tracked.memory.borrow()[slot]
        })?;
        let mut memory = self.tracked.memory.borrow_mut();
        for (value, slot) in values.iter().zip(&batch.slots) {
            memory[*slot] = as_bits(access, *value);
        }
        drop(memory);
        self.set_if_accessible(batch)
    }

    fn get_derivatives(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        let mut rates = self.rates.borrow_mut();
        let (vr, orders) = (&batch.references, &batch.first_orders);
        let passed = &mut rates[..batch.passed];
        let status = self.raw.get_output_derivatives(vr, orders, passed);
        Answer::check(status, "fmi3GetOutputDerivatives")?;
        for (value, place) in values.iter_mut().zip(&batch.places) {
            *value = rates[*place];
        }
        Ok(())
    }

    fn set_derivatives(&self, _: &Batch, _: &[f64]) -> Result<()> {
        bail!("FMI 3.0 has no derivatives of inputs")
    }

    /// The seeds of elements that are passed, but not in the batch, are 0.
    fn directional(&self, of: [&Batch; 2], seeds: &[f64], rates: &mut [f64]) -> Result<()> {
        let [outputs, inputs] = of;
        assert!(outputs.len() == rates.len() && inputs.len() == seeds.len());
        let mut workspace = self.rates.borrow_mut();
        // It is large enough for both, since it has a place for each element of the FMU.
        let (given, found) = workspace.split_at_mut(inputs.passed);
        given.fill(0.0);
        for (seed, place) in seeds.iter().zip(&inputs.places) {
            given[*place] = *seed;
        }
        let (y, u) = (&outputs.references, &inputs.references);
        let found = &mut found[..outputs.passed];
        let status = self.raw.get_directional_derivative(y, u, given, found);
        Answer::check(status, "fmi3GetDirectionalDerivative")?;
        for (rate, place) in rates.iter_mut().zip(&outputs.places) {
            *rate = found[*place];
        }
        Ok(())
    }

    fn save(&self) -> Result<Box<dyn Any>> {
        saved::save(&self.raw, self.tracked.clone())
    }

    fn restore(&self, state: &dyn Any) -> Result<()> {
        let (saved, own): (&Tracked, _) = (saved::restore(&self.raw, state)?, &self.tracked);
        own.mode.set(saved.mode.get());
        own.time.set(saved.time.get());
        own.memory.borrow_mut().clone_from(&saved.memory.borrow());
        own.texts.borrow_mut().clone_from(&saved.texts.borrow());
        own.clocks.borrow_mut().clone_from(&saved.clocks.borrow());
        own.active.borrow_mut().clone_from(&saved.active.borrow());
        own.announced.set(saved.announced.get());
        self.has_event.set(false);
        Ok(())
    }

    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>> {
        saved::to_bytes::<Tracked>(&self.raw, state)
    }

    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>> {
        saved::from_bytes::<Tracked>(&self.raw, bytes)
    }

    /// The memory would have to be reset too, so the master makes another instance instead.
    fn reset(&self) -> bool {
        false
    }
}
