//! The calls of FMI 3.0.
#![allow(unsafe_code)]

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::ffi::{CStr, CString};
use std::ops::Range;
use std::ptr;
use std::sync::Arc;

use anyhow::{Result, bail};
use fmu_description::Access;

use super::answer::{Answer, Ended};
use super::border::Border;
use super::clocks::{Clock, Interval, Plan};
use super::fmi2::owned;
use super::messages::{Speaker, receive_3};
use crate::batch::{Batch, Layout};
use crate::fmu::functions::{Functions3, Handle, call};
use crate::value::{Value, fits};

/// Updates of discrete states, or early returns, at one time after which that is a failure.
const PASSES: usize = 100;

/// Where an instance is in the state machine of the standard.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    /// Instantiated or Initialization Mode.
    Initialization,
    Event,
    Step,
}

/// Leaves the function with an answer that is not done.
macro_rules! done {
    ($answer:expr) => {{
        let answer: Answer = $answer;
        if !answer.is_done() {
            return Ok(answer);
        }
    }};
}

/// An instance; freed when dropped.
pub struct Instance {
    api: Arc<Functions3>,
    instance: Handle,
    has_events: bool,
    returns_early: bool,
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
    _speaker: Speaker,
}

/// What an instance is made with.
pub struct Arguments<'a> {
    /// Name.
    pub name: &'a CStr,
    /// `instantiationToken`.
    pub token: &'a CStr,
    /// Folder of the unpacked resources.
    pub resources: &'a CStr,
    /// The master goes through Event Mode where it is needed.
    pub has_events: bool,
    /// Steps may end early.
    pub returns_early: bool,
}

impl Instance {
    /// `fmi3InstantiateCoSimulation`; None where the FMU gives no instance.
    pub fn new(
        api: &Arc<Functions3>,
        layout: &Layout,
        plan: &Arc<Plan>,
        arguments: &Arguments,
    ) -> Result<Option<Self>> {
        let (Some(instantiate), Some(_)) = (api.fmi3InstantiateCoSimulation, api.fmi3FreeInstance)
        else {
            bail!("its library does not export fmi3InstantiateCoSimulation and fmi3FreeInstance");
        };
        let speaker = Speaker::new(arguments.name);
        // SAFETY: valid C strings; the logger looks the environment up before it trusts it.
        let instance = unsafe {
            instantiate(
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
        Ok((!instance.is_null()).then(|| Self {
            api: api.clone(),
            instance,
            has_events: arguments.has_events,
            returns_early: arguments.returns_early,
            mode: Cell::new(Mode::Initialization),
            time: Cell::new(f64::NAN),
            memory: RefCell::new(layout.initial.clone()),
            texts: RefCell::new(layout.texts.clone()),
            passed: RefCell::new(vec![0; layout.initial.len()]),
            plan: plan.clone(),
            clocks: RefCell::new(plan.clocks.iter().map(Clock::new).collect()),
            active: RefCell::new(Vec::with_capacity(plan.clocks.len())),
            announced: Cell::new(f64::INFINITY),
            _speaker: speaker,
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

    /// `fmi3SetXXX` with what the memory holds.
    fn set_numbers(&self, access: Access, vr: &[u32], spans: &[Range<usize>]) -> Answer {
        let mut passed = self.passed.borrow_mut();
        self.gather(access, spans, &mut passed);
        let n = spans.iter().map(ExactSizeIterator::len).sum();
        assert!(n <= passed.len());
        let (api, i, p) = (&self.api, self.instance, passed.as_ptr());
        let (vr, m) = (vr.as_ptr(), vr.len());
        macro_rules! calls {
            ($($access:ident $name:ident)*) => {
                match access {
                    $(Access::$access => call!(api, $name(i, vr, m, p.cast(), n)),)*
                    other => unreachable!("{other:?} is no number"),
                }
            };
        }
        // SAFETY: `m` references, and `n` values of the type of the call, which the memory has for
        // these references.
        unsafe {
            calls! {
                Real fmi3SetFloat64 Float32 fmi3SetFloat32 Int8 fmi3SetInt8 UInt8 fmi3SetUInt8 Int16 fmi3SetInt16 UInt16 fmi3SetUInt16
                Integer fmi3SetInt32 UInt32 fmi3SetUInt32 Int64 fmi3SetInt64 UInt64 fmi3SetUInt64 Boolean fmi3SetBoolean
            }
        }
    }

    /// `fmi3GetXXX` into the room for a call.
    fn get_numbers(&self, batch: &Batch, p: *mut u64) -> Answer {
        let (api, i, n) = (&self.api, self.instance, batch.passed);
        let (vr, m) = (batch.references.as_ptr(), batch.references.len());
        macro_rules! calls {
            ($($access:ident $name:ident)*) => {
                match batch.access {
                    $(Access::$access => call!(api, $name(i, vr, m, p.cast(), n)),)*
                    other => unreachable!("{other:?} is no number"),
                }
            };
        }
        // SAFETY: `m` references and room for `n` values of at most eight bytes each, the caller's
        // promise.
        unsafe {
            calls! {
                Real fmi3GetFloat64 Float32 fmi3GetFloat32 Int8 fmi3GetInt8 UInt8 fmi3GetUInt8 Int16 fmi3GetInt16 UInt16 fmi3GetUInt16
                Integer fmi3GetInt32 UInt32 fmi3GetUInt32 Int64 fmi3GetInt64 UInt64 fmi3GetUInt64 Boolean fmi3GetBoolean
            }
        }
    }

    /// `fmi3SetString` or `fmi3SetBinary` with what the memory holds.
    fn set_texts(&self, access: Access, vr: &[u32], spans: &[Range<usize>]) -> Answer {
        let (texts, empty) = (self.texts.borrow(), CString::default());
        let slots = || spans.iter().cloned().flatten();
        let (i, api, m) = (self.instance, &self.api, vr.len());
        if access == Access::String {
            let text = |slot| match texts.get(&slot) {
                Some(Value::Text(text)) => text.as_ptr(),
                _ => empty.as_ptr(),
            };
            let all: Vec<_> = slots().map(text).collect();
            // SAFETY: `m` references, and a C string for each of their elements.
            return unsafe {
                call!(
                    api,
                    fmi3SetString(i, vr.as_ptr(), m, all.as_ptr(), all.len())
                )
            };
        }
        let bytes = |slot| match texts.get(&slot) {
            Some(Value::Bytes(bytes)) => bytes.as_slice(),
            _ => &[],
        };
        let sizes: Vec<_> = slots().map(|slot| bytes(slot).len()).collect();
        let all: Vec<_> = slots().map(|slot| bytes(slot).as_ptr()).collect();
        let (vr, sizes, p) = (vr.as_ptr(), sizes.as_ptr(), all.as_ptr());
        // SAFETY: `m` references, and for each of their elements as many bytes as said.
        unsafe { call!(api, fmi3SetBinary(i, vr, m, sizes, p, all.len())) }
    }

    /// Set variables to what the memory holds.
    fn set_remembered(&self, batch: &Batch) -> Answer {
        match batch.access {
            access @ (Access::String | Access::Binary) => {
                self.set_texts(access, &batch.references, &batch.spans)
            }
            access => self.set_numbers(access, &batch.references, &batch.spans),
        }
    }

    /// `fmi3GetString` or `fmi3GetBinary`, one value for each element.
    fn get_texts(&self, batch: &Batch, mut take: impl FnMut(usize, Value)) -> Answer {
        let (api, i, n) = (&self.api, self.instance, batch.passed);
        let (vr, m) = (batch.references.as_ptr(), batch.references.len());
        if batch.access == Access::String {
            let mut texts = vec![ptr::null(); n];
            // SAFETY: `m` references and room for `n` texts, which are valid until the next call.
            unsafe {
                let answer = call!(api, fmi3GetString(i, vr, m, texts.as_mut_ptr(), n));
                for (k, place) in batch.places.iter().enumerate() {
                    if answer.is_done() {
                        take(k, Value::Text(owned(texts[*place])));
                    }
                }
                return answer;
            }
        }
        let (mut sizes, mut bytes) = (vec![0; n], vec![ptr::null(); n]);
        // SAFETY: `m` references and room for `n` sizes and addresses; what they tell is valid
        // until the next call.
        unsafe {
            let (sizes_at, bytes_at) = (sizes.as_mut_ptr(), bytes.as_mut_ptr());
            let answer = call!(api, fmi3GetBinary(i, vr, m, sizes_at, bytes_at, n));
            for (k, place) in batch.places.iter().enumerate() {
                let (size, first) = (sizes[*place], bytes[*place]);
                let is_some = size > 0 && !first.is_null();
                if answer.is_done() {
                    let all = is_some.then(|| std::slice::from_raw_parts(first, size));
                    take(k, Value::Bytes(all.unwrap_or_default().to_vec()));
                }
            }
            answer
        }
    }

    /// Keep in the memory what variables have.
    fn remember(&self, batch: &Batch) -> Answer {
        if matches!(batch.access, Access::String | Access::Binary) {
            let mut texts = self.texts.borrow_mut();
            return self.get_texts(batch, |k, value| {
                texts.insert(batch.slots[k], value);
            });
        }
        let mut passed = self.passed.borrow_mut();
        assert!(batch.passed <= passed.len());
        let answer = self.get_numbers(batch, passed.as_mut_ptr());
        if answer.is_done() {
            let mut memory = self.memory.borrow_mut();
            for (slot, place) in batch.slots.iter().zip(&batch.places) {
                memory[*slot] = load(batch.access, &passed, *place);
            }
        }
        answer
    }

    /// Whether these variables may be set and read now.
    fn is_open(&self, batch: &Batch) -> bool {
        batch.clocks.is_empty()
            || !self.has_events
            || self.mode.get() == Mode::Initialization
            || self
                .active
                .borrow()
                .iter()
                .any(|k| batch.clocks.contains(k))
    }

    /// Discrete values change in Event Mode: into it, where one of them is not what it was.
    fn open(&self, batch: &Batch, is_changed: impl Fn(usize, usize) -> bool) -> Answer {
        let is_stepping = self.has_events && self.mode.get() == Mode::Step;
        let mut all = batch.discrete.iter();
        if is_stepping && all.any(|(slot, k)| is_changed(*slot, *k)) {
            return self.enter_events();
        }
        Answer::done()
    }

    /// What the FMU says of the interval of a clock.
    fn interval(&self, reference: u32) -> (Answer, Interval) {
        let (mut interval, mut qualifier, vr) = (f64::NAN, 0, [reference]);
        // SAFETY: one reference, and room for one interval and one qualifier.
        let answer = unsafe {
            let (i, vr) = (self.instance, vr.as_ptr());
            let (interval, qualifier) = (&raw mut interval, &raw mut qualifier);
            call!(
                self.api,
                fmi3GetIntervalDecimal(i, vr, 1, interval, qualifier)
            )
        };
        let interval = match qualifier {
            0 => Interval::Unknown,
            1 => Interval::Unchanged(interval),
            _ => Interval::Changed(interval),
        };
        (answer, interval)
    }

    /// When the clocks tick for the first time; in Initialization Mode.
    fn begin_clocks(&self) -> Result<Answer> {
        for clock in self.clocks.borrow_mut().iter_mut() {
            let (mut interval, mut shift) = (None, None);
            if clock.asks {
                let (answer, told) = self.interval(clock.reference);
                done!(answer);
                interval = Some(told);
                if clock.is_periodic() {
                    let (mut told, vr) = (f64::NAN, [clock.reference]);
                    // SAFETY: one reference and room for one value.
                    done!(unsafe {
                        let (i, vr) = (self.instance, vr.as_ptr());
                        call!(self.api, fmi3GetShiftDecimal(i, vr, 1, &raw mut told))
                    });
                    shift = Some(told);
                }
            }
            clock.begin(self.time.get(), interval, shift)?;
        }
        Ok(Answer::done())
    }

    /// In Event Mode: the clocks that are due by `until`, s, tick; their inputs are set.
    fn activate(&self, until: f64) -> Answer {
        for clock in self.clocks.borrow_mut().iter_mut() {
            if clock.next > until {
                continue;
            }
            let (vr, on) = ([clock.reference], [true]);
            // SAFETY: one reference and one value.
            let answer = unsafe {
                call!(
                    self.api,
                    fmi3SetClock(self.instance, vr.as_ptr(), 1, on.as_ptr())
                )
            };
            if !answer.is_done() {
                return answer;
            }
            clock.tick();
            self.active.borrow_mut().push(clock.reference);
        }
        let open = self.plan.given.iter().filter(|batch| self.is_open(batch));
        let answers = open.map(|batch| self.set_remembered(batch));
        answers
            .into_iter()
            .find(|answer| !answer.is_done())
            .unwrap_or(Answer::done())
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some(free) = self.api.fmi3FreeInstance {
            // SAFETY: freed once; the library is still loaded.
            unsafe { free(self.instance) };
        }
    }
}

impl Border for Instance {
    fn log_only(&self, categories: &[CString]) -> Answer {
        let pointers: Vec<_> = categories.iter().map(|c| c.as_ptr()).collect();
        // SAFETY: as many valid C strings as said. All categories are on from instantiation, so
        // that it may say why it fails.
        unsafe {
            let (api, i, n) = (&self.api, self.instance, pointers.len());
            let off = call!(api, fmi3SetDebugLogging(i, false, 0, ptr::null()));
            match off.is_done() {
                true => call!(api, fmi3SetDebugLogging(i, true, n, pointers.as_ptr())),
                false => off,
            }
        }
    }

    fn get_whole(&self, batch: &Batch, values: &mut [Value]) -> Answer {
        assert_eq!(batch.len(), values.len());
        if self.is_open(batch) {
            let answer = match batch.access {
                Access::String | Access::Binary if batch.clocks.is_empty() => {
                    return self.get_texts(batch, |k, value| values[k] = value);
                }
                _ => self.remember(batch),
            };
            if !answer.is_done() {
                return answer;
            }
        }
        let (memory, texts) = (self.memory.borrow(), self.texts.borrow());
        for (value, slot) in values.iter_mut().zip(&batch.slots) {
            let bits = memory[*slot];
            *value = match batch.access {
                access @ (Access::String | Access::Binary) => {
                    texts.get(slot).cloned().unwrap_or(Value::none(access))
                }
                Access::UInt64 => Value::Whole(bits.into()),
                _ => Value::Whole(bits.cast_signed().into()),
            };
        }
        Answer::done()
    }

    fn set_whole(&self, batch: &Batch, values: &[Value]) -> Answer {
        assert_eq!(batch.len(), values.len());
        let is_changed = |slot: usize, k: usize| match &values[k] {
            value @ (Value::Real(_) | Value::Whole(_)) => {
                value.bits() != self.memory.borrow()[slot]
            }
            text => self.texts.borrow().get(&slot) != Some(text),
        };
        let answer = self.open(batch, is_changed);
        for (value, slot) in values.iter().zip(&batch.slots) {
            match value {
                Value::Real(_) | Value::Whole(_) => self.memory.borrow_mut()[*slot] = value.bits(),
                text => drop(self.texts.borrow_mut().insert(*slot, text.clone())),
            }
        }
        match answer.is_done() && self.is_open(batch) {
            true => self.set_remembered(batch),
            false => answer,
        }
    }

    /// There is nothing to say before Initialization Mode is entered.
    fn set_up(&self, _: f64) -> Answer {
        Answer::done()
    }

    fn enter_initialization(&self, start: f64) -> Answer {
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
    fn exit_initialization(&self) -> Result<Answer> {
        if self.has_events {
            done!(self.begin_clocks()?);
        }
        // SAFETY: the instance is alive.
        let answer = unsafe { call!(self.api, fmi3ExitInitializationMode(self.instance)) };
        let mode = if self.has_events {
            Mode::Event
        } else {
            Mode::Step
        };
        self.mode.set(mode);
        Ok(answer)
    }

    fn get(&self, batch: &Batch, values: &mut [f64]) -> Answer {
        assert_eq!(batch.len(), values.len());
        if batch.is_whole && batch.access == Access::Real && batch.clocks.is_empty() {
            return self.get_numbers(batch, values.as_mut_ptr().cast());
        }
        if !batch.clocks.is_empty() {
            let is_open = self.is_open(batch);
            let answer = if is_open {
                self.remember(batch)
            } else {
                Answer::done()
            };
            let memory = self.memory.borrow();
            for (value, slot) in values.iter_mut().zip(&batch.slots) {
                *value = number(batch.access, memory[*slot]);
            }
            return answer;
        }
        let mut passed = self.passed.borrow_mut();
        assert!(batch.passed <= passed.len());
        let answer = self.get_numbers(batch, passed.as_mut_ptr());
        if answer.is_done() {
            for (value, place) in values.iter_mut().zip(&batch.places) {
                *value = number(batch.access, load(batch.access, &passed, *place));
            }
        }
        answer
    }

    fn set(&self, batch: &Batch, values: &[f64]) -> Answer {
        assert_eq!(batch.len(), values.len());
        let access = batch.access;
        let is_float = matches!(access, Access::Real | Access::Float32);
        #[expect(clippy::cast_possible_truncation, reason = "it was an integer")]
        if !is_float && values.iter().any(|value| !fits(access, *value as i128)) {
            return Answer::unfit("fmi3Set");
        }
        let is_changed =
            |slot: usize, k: usize| as_bits(access, values[k]) != self.memory.borrow()[slot];
        let answer = self.open(batch, is_changed);
        let mut memory = self.memory.borrow_mut();
        for (value, slot) in values.iter().zip(&batch.slots) {
            memory[*slot] = as_bits(access, *value);
        }
        drop(memory);
        match answer.is_done() && self.is_open(batch) {
            true => self.set_numbers(access, &batch.references, &batch.spans),
            false => answer,
        }
    }

    fn get_derivatives(&self, batch: &Batch, ones: &[i32], values: &mut [f64]) -> Answer {
        assert!(batch.len() == values.len() && batch.references.len() <= ones.len());
        let mut passed = self.passed.borrow_mut();
        assert!(batch.passed <= passed.len());
        // SAFETY: as many readable references as orders, and room for the values that belong to
        // them.
        let answer = unsafe {
            let (i, vr, m) = (
                self.instance,
                batch.references.as_ptr(),
                batch.references.len(),
            );
            let (ones, room) = (ones.as_ptr(), passed.as_mut_ptr().cast());
            call!(
                self.api,
                fmi3GetOutputDerivatives(i, vr, m, ones, room, batch.passed)
            )
        };
        if answer.is_done() {
            for (value, place) in values.iter_mut().zip(&batch.places) {
                *value = f64::from_bits(passed[*place]);
            }
        }
        answer
    }

    fn set_derivatives(&self, _: &Batch, _: &[i32], _: &[f64]) -> Result<Answer> {
        bail!("FMI 3.0 has no derivatives of inputs")
    }

    /// A step that ends early is gone on with, after the event that ended it.
    fn step(&self, t: f64, h: f64) -> Result<Answer> {
        if self.mode.get() == Mode::Event {
            done!(self.settle()?);
        }
        let (mut from, mut rest, mut stays) = (t, h, 0);
        loop {
            let [mut event, mut ends, mut early] = [false; 3];
            let mut time = self.time.get();
            // SAFETY: plain values and places for the results.
            let answer = unsafe {
                let (i, time) = (self.instance, &mut time);
                let (event, ends, early) = (&mut event, &mut ends, &mut early);
                call!(
                    self.api,
                    fmi3DoStep(i, from, rest, true, event, ends, early, time)
                )
            };
            done!(answer);
            self.time.set(time);
            if ends {
                bail!(Ended {
                    call: "fmi3DoStep",
                    time
                });
            }
            if early && !self.returns_early {
                bail!("fmi3DoStep returned early, at {time} s, which it was not allowed to");
            }
            if event && self.has_events {
                done!(self.enter_events());
                done!(self.settle()?);
            }
            let end = t + h;
            if !early || end - time <= f64::EPSILON * end.abs() {
                return Ok(answer);
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

    fn enter_events(&self) -> Answer {
        if !self.has_events || self.mode.get() == Mode::Event {
            return Answer::done();
        }
        // SAFETY: the instance is alive.
        let answer = unsafe { call!(self.api, fmi3EnterEventMode(self.instance)) };
        self.mode.set(Mode::Event);
        answer
    }

    /// What clocked variables have at the tick is remembered before it is over. A clock that ticks
    /// again at the same time is active afterwards.
    fn update_events(&self) -> Result<(Answer, bool)> {
        if self.mode.get() != Mode::Event {
            return Ok((Answer::done(), false));
        }
        if !self.active.borrow().is_empty() {
            let open = self
                .plan
                .computed
                .iter()
                .filter(|batch| self.is_open(batch));
            for answer in open.map(|batch| self.remember(batch)) {
                if !answer.is_done() {
                    return Ok((answer, false));
                }
            }
        }
        let [mut again, mut ends, mut nominals, mut values, mut has_next] = [false; 5];
        let mut next = 0.0;
        // SAFETY: the instance is alive; places for the results.
        let answer = unsafe {
            let (i, again, ends) = (self.instance, &mut again, &mut ends);
            let (nominals, values) = (&mut nominals, &mut values);
            let (has_next, next) = (&mut has_next, &mut next);
            call!(
                self.api,
                fmi3UpdateDiscreteStates(i, again, ends, nominals, values, has_next, next)
            )
        };
        self.active.borrow_mut().clear();
        if !answer.is_done() {
            return Ok((answer, false));
        }
        let now = self.time.get();
        if ends {
            bail!(Ended {
                call: "fmi3UpdateDiscreteStates",
                time: now
            });
        }
        let is_ahead = has_next && next > now;
        self.announced
            .set(if is_ahead { next } else { f64::INFINITY });
        let mut is_due = false;
        for clock in self
            .clocks
            .borrow_mut()
            .iter_mut()
            .filter(|clock| clock.asks)
        {
            let (answer, interval) = self.interval(clock.reference);
            if !answer.is_done() {
                return Ok((answer, false));
            }
            clock.told(now, &interval)?;
            is_due |= clock.next <= now;
        }
        let answer = if is_due { self.activate(now) } else { answer };
        Ok((answer, again || is_due))
    }

    fn leave_events(&self) -> Answer {
        if self.mode.get() != Mode::Event {
            return Answer::done();
        }
        self.mode.set(Mode::Step);
        // SAFETY: the instance is alive.
        unsafe { call!(self.api, fmi3EnterStepMode(self.instance)) }
    }

    fn settle(&self) -> Result<Answer> {
        for _ in 0..PASSES {
            let (answer, again) = self.update_events()?;
            done!(answer);
            if !again {
                return Ok(self.leave_events());
            }
        }
        bail!("discrete states still change after {PASSES} passes of Event Mode")
    }

    fn next_event(&self) -> f64 {
        let clocks = self.clocks.borrow();
        let ticks = clocks.iter().map(|clock| clock.next);
        ticks.fold(self.announced.get(), f64::min)
    }

    fn tick(&self, t: f64, tolerance: f64) -> Result<Answer> {
        let late = |clock: &&Clock| clock.next < t - tolerance;
        if let Some(Clock { name, next, .. }) = self.clocks.borrow().iter().find(late) {
            bail!("its clock `{name}` ticks at {next} s, between two communication points");
        }
        done!(self.enter_events());
        Ok(self.activate(t + tolerance))
    }

    fn terminate(&self) -> Answer {
        // SAFETY: the instance is alive.
        unsafe { call!(self.api, fmi3Terminate(self.instance)) }
    }

    /// The memory of what was last given would have to be as new, too: another instance is made
    /// instead.
    fn reset(&self) -> Option<Answer> {
        None
    }
}

macro_rules! by_type {
    ($access:expr, $real:expr, $single:expr, |$t:ident| $integer:expr) => {
        match $access {
            Access::Real => $real,
            Access::Float32 => $single,
            Access::Int8 => {
                type $t = i8;
                $integer
            }
            Access::UInt8 => {
                type $t = u8;
                $integer
            }
            Access::Int16 => {
                type $t = i16;
                $integer
            }
            Access::UInt16 => {
                type $t = u16;
                $integer
            }
            Access::Integer => {
                type $t = i32;
                $integer
            }
            Access::UInt32 => {
                type $t = u32;
                $integer
            }
            Access::UInt64 => {
                type $t = u64;
                $integer
            }
            Access::Boolean => {
                type $t = u8;
                $integer
            }
            _ => {
                type $t = i64;
                $integer
            }
        }
    };
}

/// Write a value of the memory to place `k` of an array of the type of `access`.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the FMU's own value, or checked when it was read"
)]
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
#[expect(clippy::cast_lossless, reason = "one expression for all integer types")]
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

/// What the memory has, as a number.
#[expect(
    clippy::cast_precision_loss,
    reason = "an integer beyond 2^53 is told to the nearest number"
)]
fn number(access: Access, bits: u64) -> f64 {
    match access {
        Access::Real | Access::Float32 => f64::from_bits(bits),
        Access::UInt64 => bits as f64,
        _ => bits.cast_signed() as f64,
    }
}

/// A number as the memory has it.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it was an integer"
)]
fn as_bits(access: Access, value: f64) -> u64 {
    match access {
        Access::Real | Access::Float32 => value.to_bits(),
        Access::UInt64 => value as u64,
        _ => (value as i64).cast_unsigned(),
    }
}
