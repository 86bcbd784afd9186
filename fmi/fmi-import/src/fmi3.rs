//! The calls of FMI 3.0.

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

use crate::answer::{Answer, Ended, Stopped, call};
use crate::batch::{Batch, Layout};
use crate::calls::Functions3;
use crate::clocks::{Clock, Plan, Ticking};
use crate::encoding::{as_bits, load, number};
use crate::fmi_instance::{Arguments, Call, FmiInstance};
use crate::raw::{Array, Experiment, RawInstance};
use crate::saved;
use crate::standard::Pointer;
use crate::status;
use crate::value::{Value, fits};

/// Updates of discrete states, or early returns, at one time after which that is a failure.
const PASSES: usize = 100;

/// Where an instance is in the state machine of the standard.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
enum Mode {
    /// Instantiated or Initialization Mode.
    Initialization,
    Event,
    Step,
}

/// What is known of an instance beside what its FMU saves.
#[derive(Clone, Deserialize, Serialize)]
struct Known {
    mode: Cell<Mode>,
    /// End of the last step, s.
    time: Cell<f64>,
    /// What was last given to each element; of clocked ones also what they had at the last tick.
    memory: RefCell<Vec<u64>>,
    /// The same of texts and bytes, by slot of the memory.
    texts: RefCell<BTreeMap<usize, Value>>,
    /// When each clock ticks.
    clocks: RefCell<Vec<Ticking>>,
    /// References of the clocks that are active.
    active: RefCell<Vec<u32>>,
    /// Time of the next event that the FMU announced, s.
    announced: Cell<f64>,
}

/// An instance; freed when dropped.
pub struct Instance {
    api: Arc<Functions3>,
    instance: Pointer,
    has_events: bool,
    returns_early: bool,
    /// A step that ends early is left there.
    stops_early: Cell<bool>,
    known: Known,
    /// Room for what one call passes.
    passed: RefCell<Vec<u64>>,
    plan: Arc<Plan>,
    raw: Rc<RawInstance>,
}

impl Instance {
    /// Of an instance whose functions these are, as it was made.
    pub fn new(
        api: Arc<Functions3>,
        raw: RawInstance,
        layout: &Layout,
        plan: &Arc<Plan>,
        arguments: &Arguments,
    ) -> Self {
        Self {
            api,
            instance: raw.pointer(),
            has_events: arguments.has_events,
            returns_early: arguments.returns_early,
            stops_early: Cell::new(false),
            known: Known {
                mode: Cell::new(Mode::Initialization),
                time: Cell::new(f64::NAN),
                memory: RefCell::new(layout.initial.clone()),
                texts: RefCell::new(layout.texts.clone()),
                clocks: RefCell::new(plan.clocks.iter().map(Clock::ticking).collect()),
                active: RefCell::new(Vec::with_capacity(plan.clocks.len())),
                announced: Cell::new(f64::INFINITY),
            },
            passed: RefCell::new(vec![0; layout.initial.len()]),
            plan: plan.clone(),
            raw: Rc::new(raw),
        }
    }

    /// No stop time: a run may be continued.
    fn enter_initialization(&self, start: f64) -> Result<()> {
        self.known.time.set(start);
        let experiment = Experiment {
            start,
            ..Experiment::default()
        };
        Answer::check(self.raw.begin(experiment), "fmi3EnterInitializationMode")
    }

    /// Leads into Event Mode where the master uses it.
    fn exit_initialization(&self) -> Result<()> {
        if self.has_events {
            self.begin_clocks()?;
        }
        self.known.mode.set(match self.has_events {
            true => Mode::Event,
            false => Mode::Step,
        });
        let status = self.raw.exit_initialization_mode();
        Answer::check(status, "fmi3ExitInitializationMode")
    }

    /// A step that ends early is gone on with, after the event that ended it.
    fn step(&self, t: f64, h: f64) -> Result<()> {
        if self.known.mode.get() == Mode::Event {
            self.settle()?;
        }
        let (mut from, mut rest, mut stays) = (t, h, 0);
        loop {
            let [mut event, mut ends, mut early] = [false; 3];
            let mut time = self.known.time.get();
            // SAFETY: plain values and places for the results.
            unsafe {
                let (api, i, time) = (&self.api, self.instance, &mut time);
                let (event, ends, early) = (&mut event, &mut ends, &mut early);
                call!(
                    api,
                    fmi3DoStep(i, from, rest, true, event, ends, early, time)
                )?;
            }
            self.known.time.set(time);
            if ends {
                let call = "fmi3DoStep";
                bail!(Ended { call, time });
            }
            if early && !self.returns_early {
                bail!("fmi3DoStep returned early, at {time} s, which it was not allowed to");
            }
            let end = t + h;
            let is_short = early && end - time > f64::EPSILON * end.abs();
            if is_short && self.stops_early.get() {
                let (name, time) = (String::new(), Some(time));
                bail!(Stopped { name, time });
            }
            if event && self.has_events {
                self.enter_events()?;
                self.settle()?;
            }
            if !is_short {
                return Ok(());
            }
            stays = if time > from { 0 } else { stays + 1 };
            if stays == PASSES {
                bail!("fmi3DoStep returned early {PASSES} times at {time} s");
            }
            (from, rest) = (time, end - time);
        }
    }
}

impl FmiInstance for Instance {
    fn log_only(&self, categories: &[CString]) -> Result<()> {
        let names: Vec<_> = categories.iter().map(|c| Some(c.as_c_str())).collect();
        // All categories are on from instantiation, so that it may say why it fails.
        for (on, names) in [(false, Array::Null(0)), (true, Array::Elements(&names[..]))] {
            let status = self.raw.set_debug_logging(on, names);
            Answer::check(status, "fmi3SetDebugLogging")?;
        }
        Ok(())
    }

    fn call(&self, call: Call) -> Result<f64> {
        let done = match call {
            Call::Step(t, h) => self.step(t, h),
            // There is nothing to say before Initialization Mode is entered.
            Call::SetUp(_) => Ok(()),
            Call::EnterInitialization(start) => self.enter_initialization(start),
            Call::ExitInitialization => self.exit_initialization(),
            Call::Time => return Ok(self.known.time.get()),
            Call::StopEarly(stops) => {
                self.stops_early.set(stops);
                Ok(())
            }
            Call::EnterEvents => self.enter_events(),
            Call::UpdateEvents => {
                return self.update_events().map(|again| f64::from(u8::from(again)));
            }
            Call::LeaveEvents => self.leave_events(),
            Call::Settle => self.settle(),
            Call::NextEvent => return Ok(self.next_event()),
            Call::Tick(t, tolerance) => self.tick(t, tolerance),
            Call::Terminate => Answer::check(self.raw.terminate(), "fmi3Terminate"),
        };
        done.map(|()| 0.0)
    }

    fn get_whole(&self, batch: &Batch, values: &mut [Value]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        if self.is_open(batch) {
            self.remember(batch)?;
        }
        let (memory, texts) = (self.known.memory.borrow(), self.known.texts.borrow());
        for (value, slot) in values.iter_mut().zip(&batch.slots) {
            *value = match batch.access {
                Access::String | Access::Binary => {
                    let text = texts.get(slot).cloned();
                    text.unwrap_or_else(|| Value::none(batch.access))
                }
                Access::UInt64 => Value::Whole(memory[*slot].into()),
                _ => Value::Whole(memory[*slot].cast_signed().into()),
            };
        }
        Ok(())
    }

    fn set_whole(&self, batch: &Batch, values: &[Value]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        let is_text = matches!(batch.access, Access::String | Access::Binary);
        self.open(batch, |slot, k| match is_text {
            true => self.known.texts.borrow().get(&slot) != Some(&values[k]),
            false => self.known.memory.borrow()[slot] != values[k].bits(),
        })?;
        for (value, slot) in values.iter().zip(&batch.slots) {
            match is_text {
                true => drop(self.known.texts.borrow_mut().insert(*slot, value.clone())),
                false => self.known.memory.borrow_mut()[*slot] = value.bits(),
            }
        }
        match self.is_open(batch) {
            true => self.set_remembered(batch),
            false => Ok(()),
        }
    }

    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        if !batch.clocks.is_empty() {
            if self.is_open(batch) {
                self.remember(batch)?;
            }
            let memory = self.known.memory.borrow();
            for (value, slot) in values.iter_mut().zip(&batch.slots) {
                *value = number(batch.access, memory[*slot]);
            }
            return Ok(());
        }
        if batch.is_whole && batch.access == Access::Real {
            return self.get_numbers(batch, values.as_mut_ptr().cast());
        }
        let mut passed = self.passed.borrow_mut();
        assert!(batch.passed <= passed.len());
        self.get_numbers(batch, passed.as_mut_ptr())?;
        for (value, place) in values.iter_mut().zip(&batch.places) {
            *value = number(batch.access, load(batch.access, &passed, *place));
        }
        Ok(())
    }

    fn set(&self, batch: &Batch, values: &[f64]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        let access = batch.access;
        let is_float = matches!(access, Access::Real | Access::Float32);
        if !is_float && values.iter().any(|value| !fits(access, *value as i128)) {
            return Answer::refuse(status::UNFIT, "fmi3Set");
        }
        self.open(batch, |slot, k| {
            as_bits(access, values[k]) != self.known.memory.borrow()[slot]
        })?;
        let mut memory = self.known.memory.borrow_mut();
        for (value, slot) in values.iter().zip(&batch.slots) {
            memory[*slot] = as_bits(access, *value);
        }
        drop(memory);
        match self.is_open(batch) {
            true => self.set_remembered(batch),
            false => Ok(()),
        }
    }

    fn get_derivatives(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        let mut passed = self.passed.borrow_mut();
        assert!(batch.passed <= passed.len());
        // SAFETY: as many readable references as orders, and room for the values that belong to
        // them.
        unsafe {
            let (i, n, vr) = (self.instance, batch.passed, &batch.references);
            let (m, vr) = (vr.len(), vr.as_ptr());
            let (ones, room) = (batch.ones.as_ptr(), passed.as_mut_ptr().cast());
            call!(self.api, fmi3GetOutputDerivatives(i, vr, m, ones, room, n))?;
        }
        for (value, place) in values.iter_mut().zip(&batch.places) {
            *value = f64::from_bits(passed[*place]);
        }
        Ok(())
    }

    fn set_derivatives(&self, _: &Batch, _: &[f64]) -> Result<()> {
        bail!("FMI 3.0 has no derivatives of inputs")
    }

    /// Other elements of the arrays that are passed do not change.
    fn directional(&self, of: [&Batch; 2], seeds: &[f64], rates: &mut [f64]) -> Result<()> {
        let [outputs, inputs] = of;
        assert!(outputs.len() == rates.len() && inputs.len() == seeds.len());
        let mut passed = self.passed.borrow_mut();
        // Every variable has slots of its own there, so that there is room for both.
        let (given, found) = passed.split_at_mut(inputs.passed);
        assert!(outputs.passed <= found.len());
        given.fill(0);
        for (seed, place) in seeds.iter().zip(&inputs.places) {
            given[*place] = seed.to_bits();
        }
        let (y, u) = (&outputs.references, &inputs.references);
        let (n, m, y, u) = (y.len(), u.len(), y.as_ptr(), u.as_ptr());
        // SAFETY: readable references, and as many seeds and as much room as their arrays have
        // elements.
        unsafe {
            let (api, i) = (&self.api, self.instance);
            let (seeds, a) = (given.as_ptr().cast(), given.len());
            let (rates, b) = (found.as_mut_ptr().cast(), outputs.passed);
            call!(
                api,
                fmi3GetDirectionalDerivative(i, y, n, u, m, seeds, a, rates, b)
            )?;
        }
        for (rate, place) in rates.iter_mut().zip(&outputs.places) {
            *rate = f64::from_bits(found[*place]);
        }
        Ok(())
    }

    fn save(&self) -> Result<Box<dyn Any>> {
        saved::save(&self.raw, self.known.clone())
    }

    fn restore(&self, state: &dyn Any) -> Result<()> {
        let (saved, own): (&Known, _) = (saved::restore(&self.raw, state)?, &self.known);
        own.mode.set(saved.mode.get());
        own.time.set(saved.time.get());
        own.memory.borrow_mut().clone_from(&saved.memory.borrow());
        own.texts.borrow_mut().clone_from(&saved.texts.borrow());
        own.clocks.borrow_mut().clone_from(&saved.clocks.borrow());
        own.active.borrow_mut().clone_from(&saved.active.borrow());
        own.announced.set(saved.announced.get());
        Ok(())
    }

    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>> {
        saved::to_bytes::<Known>(&self.raw, state)
    }

    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>> {
        saved::from_bytes::<Known>(&self.raw, bytes)
    }

    /// The memory of what was last given would have to be as new, too: another instance is made
    /// instead.
    fn reset(&self) -> bool {
        false
    }
}
