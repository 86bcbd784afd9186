//! The calls of FMI 3.0.
#![allow(unsafe_code)]

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char};
use std::ops::Range;
use std::ptr;
use std::rc::Rc;
use std::sync::Arc;

use anyhow::{Result, bail};
use fmu_description::Access;
use fmu_description::calls::Functions3;
use fmu_description::functions::Pointer;
use serde::{Deserialize, Serialize};

use super::answer::{Answer, Ended, Stopped, call};
use super::border::{Arguments, Border};
use super::clocks::{Clock, Interval, Plan, Ticking};
use super::messages::{Speaker, receive_3};
use super::owner::{Owner, State};
use crate::batch::{Batch, Layout};
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

/// `fmi3GetXXX` or `fmi3SetXXX` of numbers, by type.
macro_rules! by_function {
    ($api:expr, $access:expr, $arguments:tt: $($of:ident $function:ident)*) => {
        match $access {
            $(Access::$of => by_function!(call $api, $function $arguments),)*
            other => unreachable!("{other:?} is no number"),
        }
    };
    (call $api:expr, $function:ident ($($argument:expr),*)) => { call!($api, $function($($argument),*)) };
}

/// What is known of an instance beside a saved state of it.
#[derive(Deserialize, Serialize)]
struct Known {
    mode: Mode,
    time: f64,
    memory: Vec<u64>,
    texts: BTreeMap<usize, Value>,
    clocks: Vec<Ticking>,
    active: Vec<u32>,
    announced: f64,
}

/// An instance; freed when dropped.
pub struct Instance {
    api: Arc<Functions3>,
    instance: Pointer,
    has_events: bool,
    returns_early: bool,
    /// A step that ends early is left there.
    stops_early: Cell<bool>,
    mode: Cell<Mode>,
    /// End of the last step, s.
    time: Cell<f64>,
    /// What was last given to each element; of clocked ones also what they had at the last tick.
    memory: RefCell<Vec<u64>>,
    /// The same of texts and bytes, by slot of the memory.
    texts: RefCell<BTreeMap<usize, Value>>,
    /// Room for what one call passes.
    passed: RefCell<Vec<u64>>,
    plan: Arc<Plan>,
    clocks: RefCell<Vec<Clock>>,
    /// References of the clocks that are active.
    active: RefCell<Vec<u32>>,
    /// Time of the next event that the FMU announced, s.
    announced: Cell<f64>,
    owner: Rc<Owner>,
}

impl Instance {
    /// `fmi3InstantiateCoSimulation`; None where the FMU gives no instance.
    pub fn new(
        api: &Arc<Functions3>,
        layout: &Layout,
        plan: &Arc<Plan>,
        arguments: &Arguments,
    ) -> Result<Option<Self>> {
        let names = ["fmi3InstantiateCoSimulation", "fmi3FreeInstance"];
        if !names.iter().all(|name| api.exports(name)) {
            bail!("its library does not export {} and {}", names[0], names[1]);
        }
        let speaker = Speaker::new(arguments.name);
        // SAFETY: valid C strings; the logger looks the environment up before it trusts it.
        let instance = unsafe {
            (api.fmi3InstantiateCoSimulation)(
                arguments.name.as_ptr(),
                arguments.token.as_ptr(),
                arguments.resources.as_ptr(),
                false,
                true,
                arguments.has_events,
                arguments.returns_early,
                ptr::null(),
                0,
                speaker.environment(),
                Some(receive_3),
                ptr::null_mut(),
            )
        };
        let (free, free_state) = (api.fmi3FreeInstance, api.fmi3FreeFMUState);
        let kept = (api.clone(), speaker);
        Ok((!instance.is_null()).then(|| Self {
            api: api.clone(),
            instance,
            has_events: arguments.has_events,
            returns_early: arguments.returns_early,
            stops_early: Cell::new(false),
            mode: Cell::new(Mode::Initialization),
            time: Cell::new(f64::NAN),
            memory: RefCell::new(layout.initial.clone()),
            texts: RefCell::new(layout.texts.clone()),
            passed: RefCell::new(vec![0; layout.initial.len()]),
            plan: plan.clone(),
            clocks: RefCell::new(plan.clocks.iter().map(Clock::new).collect()),
            active: RefCell::new(Vec::with_capacity(plan.clocks.len())),
            announced: Cell::new(f64::INFINITY),
            // SAFETY: the instance and the functions of its library.
            owner: unsafe { Owner::new(instance, free, free_state, kept) },
        }))
    }

    /// Write what the memory holds for these slots into the room for a call.
    fn gather(&self, access: Access, spans: &[Range<usize>], passed: &mut [u64]) {
        let memory = self.memory.borrow();
        let slots = spans.iter().flat_map(|span| &memory[span.clone()]);
        for (k, slot) in slots.enumerate() {
            store(access, passed, k, *slot);
        }
    }

    /// Set variables to what the memory holds.
    fn set_remembered(&self, batch: &Batch) -> Result<()> {
        let (api, i) = (&self.api, self.instance);
        let (vr, m) = (batch.references.as_ptr(), batch.references.len());
        let n = batch.passed;
        match batch.access {
            Access::String | Access::Binary => {
                let (texts, is_text) = (self.texts.borrow(), batch.access == Access::String);
                let slots = batch.spans.iter().cloned().flatten();
                let all: Vec<_> = slots.map(|slot| texts.get(&slot)).collect();
                let all = all.iter().map(|value| match value {
                    Some(Value::Text(text)) => text.as_bytes_with_nul(),
                    Some(Value::Bytes(bytes)) => bytes,
                    _ if is_text => c"".to_bytes_with_nul(),
                    _ => &[],
                });
                let sizes: Vec<_> = all.clone().map(<[u8]>::len).collect();
                let all: Vec<_> = all.map(<[u8]>::as_ptr).collect();
                let (p, sizes) = (all.as_ptr(), sizes.as_ptr());
                // SAFETY: `m` references, and for each of their elements a C string, or as many
                // bytes as said.
                unsafe {
                    match is_text {
                        true => call!(api, fmi3SetString(i, vr, m, p.cast(), n)),
                        false => call!(api, fmi3SetBinary(i, vr, m, sizes, p, n)),
                    }
                }
            }
            access => {
                let mut passed = self.passed.borrow_mut();
                self.gather(access, &batch.spans, &mut passed);
                assert!(n <= passed.len());
                let p = passed.as_ptr();
                // SAFETY: `m` references, and `n` values of the type of the call, which the memory
                // has for these references.
                unsafe {
                    by_function! { api, access, (i, vr, m, p.cast(), n):
                        Real fmi3SetFloat64 Float32 fmi3SetFloat32 Int8 fmi3SetInt8 UInt8 fmi3SetUInt8
                        Int16 fmi3SetInt16 UInt16 fmi3SetUInt16 Integer fmi3SetInt32 UInt32 fmi3SetUInt32
                        Int64 fmi3SetInt64 UInt64 fmi3SetUInt64 Boolean fmi3SetBoolean
                    }
                }
            }
        }
    }

    /// `fmi3GetXXX` into the room for a call.
    fn get_numbers(&self, batch: &Batch, p: *mut u64) -> Result<()> {
        let (api, i, n) = (&self.api, self.instance, batch.passed);
        let (vr, m) = (batch.references.as_ptr(), batch.references.len());
        // SAFETY: `m` references and room for `n` values of at most eight bytes each, the caller's
        // promise.
        unsafe {
            by_function! { api, batch.access, (i, vr, m, p.cast(), n):
                Real fmi3GetFloat64 Float32 fmi3GetFloat32 Int8 fmi3GetInt8 UInt8 fmi3GetUInt8
                Int16 fmi3GetInt16 UInt16 fmi3GetUInt16 Integer fmi3GetInt32 UInt32 fmi3GetUInt32
                Int64 fmi3GetInt64 UInt64 fmi3GetUInt64 Boolean fmi3GetBoolean
            }
        }
    }

    /// Read variables into the memory.
    fn remember(&self, batch: &Batch) -> Result<()> {
        let (api, i, n) = (&self.api, self.instance, batch.passed);
        let (vr, m) = (batch.references.as_ptr(), batch.references.len());
        let places = batch.slots.iter().zip(&batch.places);
        match batch.access {
            Access::String => {
                let mut texts = vec![ptr::null(); n];
                // SAFETY: `m` references and room for `n` texts, valid until the next call.
                unsafe { call!(api, fmi3GetString(i, vr, m, texts.as_mut_ptr(), n))? };
                for (slot, place) in places {
                    // SAFETY: as above.
                    let text = unsafe { owned(texts[*place]) };
                    self.texts.borrow_mut().insert(*slot, Value::Text(text));
                }
            }
            Access::Binary => {
                let (mut sizes, mut all) = (vec![0; n], vec![ptr::null(); n]);
                let (sizes_at, all_at) = (sizes.as_mut_ptr(), all.as_mut_ptr());
                // SAFETY: `m` references and room for `n` sizes and addresses.
                unsafe { call!(api, fmi3GetBinary(i, vr, m, sizes_at, all_at, n))? };
                for (slot, place) in places {
                    let (first, size) = (all[*place], sizes[*place]);
                    let is_some = size > 0 && !first.is_null();
                    // SAFETY: as many bytes as said, valid until the next call.
                    let bytes = is_some.then(|| unsafe { std::slice::from_raw_parts(first, size) });
                    let value = Value::Bytes(bytes.unwrap_or_default().to_vec());
                    self.texts.borrow_mut().insert(*slot, value);
                }
            }
            access => {
                let (mut passed, mut memory) = (self.passed.borrow_mut(), self.memory.borrow_mut());
                assert!(n <= passed.len());
                self.get_numbers(batch, passed.as_mut_ptr())?;
                for (slot, place) in places {
                    memory[*slot] = load(access, &passed, *place);
                }
            }
        }
        Ok(())
    }

    /// Whether these variables may be set and read now.
    fn is_open(&self, batch: &Batch) -> bool {
        let is_active = |clock: &u32| self.active.borrow().contains(clock);
        let is_free = batch.clocks.is_empty() || !self.has_events;
        is_free || self.mode.get() == Mode::Initialization || batch.clocks.iter().any(is_active)
    }

    /// Discrete values change in Event Mode: into it, where one of them is not what it was.
    fn open(&self, batch: &Batch, is_changed: impl Fn(usize, usize) -> bool) -> Result<()> {
        let is_stepping = self.has_events && self.mode.get() == Mode::Step;
        let mut all = batch.discrete.iter();
        match is_stepping && all.any(|(slot, k)| is_changed(*slot, *k)) {
            true => self.enter_events(),
            false => Ok(()),
        }
    }

    /// What the FMU says of the interval of a clock.
    fn interval(&self, reference: u32) -> Result<Interval> {
        let (mut interval, mut qualifier, vr) = (f64::NAN, 0, [reference]);
        let (told, how) = (&raw mut interval, &raw mut qualifier);
        // SAFETY: one reference, and room for one interval and one qualifier.
        unsafe {
            let (i, vr) = (self.instance, vr.as_ptr());
            call!(self.api, fmi3GetIntervalDecimal(i, vr, 1, told, how))?;
        }
        Ok(match qualifier {
            0 => Interval::Unknown,
            1 => Interval::Unchanged(interval),
            _ => Interval::Changed(interval),
        })
    }

    /// When the clocks tick for the first time; in Initialization Mode.
    fn begin_clocks(&self) -> Result<()> {
        for clock in self.clocks.borrow_mut().iter_mut() {
            let (mut interval, mut shift, vr) = (None, None, [clock.reference]);
            if clock.asks {
                interval = Some(self.interval(clock.reference)?);
            }
            if clock.asks && clock.is_periodic() {
                let told = shift.insert(f64::NAN);
                // SAFETY: one reference and room for one value.
                unsafe {
                    call!(
                        self.api,
                        fmi3GetShiftDecimal(self.instance, vr.as_ptr(), 1, told)
                    )?;
                }
            }
            clock.begin(self.time.get(), interval, shift)?;
        }
        Ok(())
    }

    /// In Event Mode: the clocks that are due by `until`, s, tick; their inputs are set.
    fn activate(&self, until: f64) -> Result<()> {
        let mut clocks = self.clocks.borrow_mut();
        for clock in clocks.iter_mut().filter(|clock| clock.next <= until) {
            let (vr, on) = ([clock.reference], [true]);
            let (i, vr, on) = (self.instance, vr.as_ptr(), on.as_ptr());
            // SAFETY: one reference and one value.
            unsafe { call!(self.api, fmi3SetClock(i, vr, 1, on))? };
            clock.tick();
            self.active.borrow_mut().push(clock.reference);
        }
        let mut open = self.plan.given.iter().filter(|batch| self.is_open(batch));
        open.try_for_each(|batch| self.set_remembered(batch))
    }
}

impl Border for Instance {
    fn log_only(&self, categories: &[CString]) -> Result<()> {
        let pointers: Vec<_> = categories.iter().map(|c| c.as_ptr()).collect();
        // SAFETY: as many valid C strings as said. All categories are on from instantiation, so
        // that it may say why it fails.
        unsafe {
            let (api, i, n) = (&self.api, self.instance, pointers.len());
            call!(api, fmi3SetDebugLogging(i, false, 0, ptr::null()))?;
            call!(api, fmi3SetDebugLogging(i, true, n, pointers.as_ptr()))
        }
    }

    fn get_whole(&self, batch: &Batch, values: &mut [Value]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        if self.is_open(batch) {
            self.remember(batch)?;
        }
        let (memory, texts) = (self.memory.borrow(), self.texts.borrow());
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
            true => self.texts.borrow().get(&slot) != Some(&values[k]),
            false => self.memory.borrow()[slot] != values[k].bits(),
        })?;
        for (value, slot) in values.iter().zip(&batch.slots) {
            match is_text {
                true => drop(self.texts.borrow_mut().insert(*slot, value.clone())),
                false => self.memory.borrow_mut()[*slot] = value.bits(),
            }
        }
        match self.is_open(batch) {
            true => self.set_remembered(batch),
            false => Ok(()),
        }
    }

    /// There is nothing to say before Initialization Mode is entered.
    fn set_up(&self, _: f64) -> Result<()> {
        Ok(())
    }

    fn enter_initialization(&self, start: f64) -> Result<()> {
        self.time.set(start);
        // SAFETY: plain values. No stop time: a run may be continued.
        unsafe {
            let i = self.instance;
            call!(
                self.api,
                fmi3EnterInitializationMode(i, false, 0.0, start, false, 0.0)
            )
        }
    }

    /// Leads into Event Mode where the master uses it.
    fn exit_initialization(&self) -> Result<()> {
        if self.has_events {
            self.begin_clocks()?;
        }
        self.mode.set(match self.has_events {
            true => Mode::Event,
            false => Mode::Step,
        });
        // SAFETY: the instance is alive.
        unsafe { call!(self.api, fmi3ExitInitializationMode(self.instance)) }
    }

    fn get(&self, batch: &Batch, values: &mut [f64]) -> Result<()> {
        assert_eq!(batch.len(), values.len());
        if !batch.clocks.is_empty() {
            if self.is_open(batch) {
                self.remember(batch)?;
            }
            let memory = self.memory.borrow();
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
            return Answer::refuse(Answer::UNFIT, "fmi3Set");
        }
        self.open(batch, |slot, k| {
            as_bits(access, values[k]) != self.memory.borrow()[slot]
        })?;
        let mut memory = self.memory.borrow_mut();
        for (value, slot) in values.iter().zip(&batch.slots) {
            memory[*slot] = as_bits(access, *value);
        }
        drop(memory);
        match self.is_open(batch) {
            true => self.set_remembered(batch),
            false => Ok(()),
        }
    }

    fn get_derivatives(&self, batch: &Batch, ones: &[i32], values: &mut [f64]) -> Result<()> {
        assert!(batch.len() == values.len() && batch.references.len() <= ones.len());
        let mut passed = self.passed.borrow_mut();
        assert!(batch.passed <= passed.len());
        // SAFETY: as many readable references as orders, and room for the values that belong to
        // them.
        unsafe {
            let (i, n, vr) = (self.instance, batch.passed, &batch.references);
            let (m, vr) = (vr.len(), vr.as_ptr());
            let (ones, room) = (ones.as_ptr(), passed.as_mut_ptr().cast());
            call!(self.api, fmi3GetOutputDerivatives(i, vr, m, ones, room, n))?;
        }
        for (value, place) in values.iter_mut().zip(&batch.places) {
            *value = f64::from_bits(passed[*place]);
        }
        Ok(())
    }

    fn set_derivatives(&self, _: &Batch, _: &[i32], _: &[f64]) -> Result<()> {
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

    /// A step that ends early is gone on with, after the event that ended it.
    fn step(&self, t: f64, h: f64) -> Result<()> {
        if self.mode.get() == Mode::Event {
            self.settle()?;
        }
        let (mut from, mut rest, mut stays) = (t, h, 0);
        loop {
            let [mut event, mut ends, mut early] = [false; 3];
            let mut time = self.time.get();
            // SAFETY: plain values and places for the results.
            unsafe {
                let (i, time) = (self.instance, &mut time);
                let (event, ends, early) = (&mut event, &mut ends, &mut early);
                call!(
                    self.api,
                    fmi3DoStep(i, from, rest, true, event, ends, early, time)
                )?;
            }
            self.time.set(time);
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

    fn time(&self) -> Result<f64> {
        Ok(self.time.get())
    }

    fn enter_events(&self) -> Result<()> {
        if !self.has_events || self.mode.replace(Mode::Event) == Mode::Event {
            return Ok(());
        }
        // SAFETY: the instance is alive.
        unsafe { call!(self.api, fmi3EnterEventMode(self.instance)) }
    }

    /// What clocked variables have at the tick is remembered before it is over. A clock that ticks
    /// again at the same time is active afterwards.
    fn update_events(&self) -> Result<bool> {
        if self.mode.get() != Mode::Event {
            return Ok(false);
        }
        if !self.active.borrow().is_empty() {
            let mut open = self
                .plan
                .computed
                .iter()
                .filter(|batch| self.is_open(batch));
            open.try_for_each(|batch| self.remember(batch))?;
        }
        let [mut again, mut ends, mut nominals, mut values, mut has_next] = [false; 5];
        let mut next = 0.0;
        // SAFETY: the instance is alive; places for the results.
        unsafe {
            let (i, again, ends) = (self.instance, &mut again, &mut ends);
            let (nominals, values) = (&mut nominals, &mut values);
            let (has_next, next) = (&mut has_next, &mut next);
            call!(
                self.api,
                fmi3UpdateDiscreteStates(i, again, ends, nominals, values, has_next, next)
            )?;
        }
        self.active.borrow_mut().clear();
        let time = self.time.get();
        if ends {
            let call = "fmi3UpdateDiscreteStates";
            bail!(Ended { call, time });
        }
        let is_ahead = has_next && next > time;
        self.announced
            .set(if is_ahead { next } else { f64::INFINITY });
        let mut is_due = false;
        for clock in self
            .clocks
            .borrow_mut()
            .iter_mut()
            .filter(|clock| clock.asks)
        {
            clock.told(time, &self.interval(clock.reference)?)?;
            is_due |= clock.next <= time;
        }
        if is_due {
            self.activate(time)?;
        }
        Ok(again || is_due)
    }

    fn leave_events(&self) -> Result<()> {
        if self.mode.get() != Mode::Event {
            return Ok(());
        }
        self.mode.set(Mode::Step);
        // SAFETY: the instance is alive.
        unsafe { call!(self.api, fmi3EnterStepMode(self.instance)) }
    }

    fn settle(&self) -> Result<()> {
        for _ in 0..PASSES {
            if !self.update_events()? {
                return self.leave_events();
            }
        }
        bail!("discrete states still change after {PASSES} passes of Event Mode")
    }

    fn next_event(&self) -> f64 {
        let clocks = self.clocks.borrow();
        let ticks = clocks.iter().map(|clock| clock.next);
        ticks.fold(self.announced.get(), f64::min)
    }

    fn tick(&self, t: f64, tolerance: f64) -> Result<()> {
        let late = |clock: &&Clock| clock.next < t - tolerance;
        if let Some(Clock { name, next, .. }) = self.clocks.borrow().iter().find(late) {
            bail!("its clock `{name}` ticks at {next} s, between two communication points");
        }
        self.enter_events()?;
        self.activate(t + tolerance)
    }

    fn terminate(&self) -> Result<()> {
        // SAFETY: the instance is alive.
        unsafe { call!(self.api, fmi3Terminate(self.instance)) }
    }

    fn save(&self) -> Result<Box<dyn Any>> {
        let known = Known {
            mode: self.mode.get(),
            time: self.time.get(),
            memory: self.memory.borrow().clone(),
            texts: self.texts.borrow().clone(),
            clocks: self.clocks.borrow().iter().map(Clock::ticking).collect(),
            active: self.active.borrow().clone(),
            announced: self.announced.get(),
        };
        // SAFETY: room for one state, which is new.
        State::saved(&self.owner, known, |state| unsafe {
            call!(self.api, fmi3GetFMUState(self.instance, state))
        })
    }

    fn restore(&self, state: &dyn Any) -> Result<()> {
        let (saved, state) = State::<Known>::of(&self.owner, state)?;
        // SAFETY: a state of this instance.
        unsafe { call!(self.api, fmi3SetFMUState(self.instance, state))? };
        let saved = &saved.known;
        self.mode.set(saved.mode);
        self.time.set(saved.time);
        self.memory.borrow_mut().clone_from(&saved.memory);
        self.texts.borrow_mut().clone_from(&saved.texts);
        for (clock, ticking) in self.clocks.borrow_mut().iter_mut().zip(&saved.clocks) {
            clock.go_on(*ticking);
        }
        self.active.borrow_mut().clone_from(&saved.active);
        self.announced.set(saved.announced);
        Ok(())
    }

    fn state_to_bytes(&self, state: &dyn Any) -> Result<Vec<u8>> {
        let (api, i) = (&self.api, self.instance);
        // SAFETY: a state of this instance, and room for a size.
        let size = |s, n: &mut usize| unsafe { call!(api, fmi3SerializedFMUStateSize(i, s, n)) };
        // SAFETY: the same, and room for as many bytes as said.
        State::<Known>::to_bytes(&self.owner, state, size, |s, bytes| unsafe {
            let (p, n) = (bytes.as_mut_ptr(), bytes.len());
            call!(api, fmi3SerializeFMUState(i, s, p, n))
        })
    }

    fn state_from_bytes(&self, bytes: &[u8]) -> Result<Box<dyn Any>> {
        let (api, i) = (&self.api, self.instance);
        // SAFETY: as many bytes as said, and room for one state, which is new.
        State::<Known>::from_bytes(&self.owner, bytes, |bytes, s| unsafe {
            let (p, n) = (bytes.as_ptr(), bytes.len());
            call!(api, fmi3DeserializeFMUState(i, p, n, s))
        })
    }

    fn stop_early(&self, stops: bool) {
        self.stops_early.set(stops);
    }

    /// The memory of what was last given would have to be as new, too: another instance is made
    /// instead.
    fn reset(&self) -> bool {
        false
    }
}

/// A text of an FMU as our own; none is an empty one.
///
/// # Safety
/// NULL or a C string.
pub(super) unsafe fn owned(text: *const c_char) -> CString {
    match text.is_null() {
        true => CString::default(),
        // SAFETY: as the caller promises.
        false => unsafe { CStr::from_ptr(text) }.to_owned(),
    }
}

/// An expression by type: of floating-point numbers, or of integers of the type that it is given.
macro_rules! by_type {
    ($access:expr, $real:expr, $single:expr, |$t:ident| $integer:expr) => {
        by_type!($access, $real, $single, $t $integer; Int8 i8 UInt8 u8 Int16 i16 UInt16 u16
            Integer i32 UInt32 u32 Int64 i64 UInt64 u64 Boolean u8)
    };
    ($access:expr, $real:expr, $single:expr, $t:ident $integer:expr; $($of:ident $type:ty)*) => {
        match $access {
            Access::Real => $real,
            Access::Float32 => $single,
            $(Access::$of => {
                type $t = $type;
                $integer
            })*
            other => unreachable!("{other:?} is no number"),
        }
    };
}

/// Write a value of the memory to place `k` of an array of the type of `access`.
fn store(access: Access, array: &mut [u64], k: usize, bits: u64) {
    assert!(k < array.len());
    let array = array.as_mut_ptr();
    // SAFETY: `k` is a place of the array, since no type is larger than its elements.
    unsafe {
        by_type!(
            access,
            *array.add(k) = bits,
            *array.cast::<f32>().add(k) = f64::from_bits(bits) as f32,
            |T| *array.cast::<T>().add(k) = bits as T
        );
    }
}

/// What is at place `k` of an array of the type of `access`, as the memory has it.
#[expect(
    clippy::cast_lossless,
    clippy::unnecessary_cast,
    reason = "one expression for all integer types"
)]
fn load(access: Access, array: &[u64], k: usize) -> u64 {
    assert!(k < array.len());
    let array = array.as_ptr();
    // SAFETY: `k` is a place of the array, since no type is larger than its elements.
    unsafe {
        by_type!(
            access,
            *array.add(k),
            f64::from(*array.cast::<f32>().add(k)).to_bits(),
            |T| *array.cast::<T>().add(k) as u64
        )
    }
}

/// What the memory has, as a number: an integer beyond 2^53 as the nearest.
fn number(access: Access, bits: u64) -> f64 {
    match access {
        Access::Real | Access::Float32 => f64::from_bits(bits),
        Access::UInt64 => bits as f64,
        _ => bits.cast_signed() as f64,
    }
}

/// A number as the memory has it.
fn as_bits(access: Access, value: f64) -> u64 {
    match access {
        Access::Real | Access::Float32 => value.to_bits(),
        Access::UInt64 => value as u64,
        _ => (value as i64).cast_unsigned(),
    }
}
