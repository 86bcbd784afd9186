//! The calls of FMI 3.0.
#![allow(unsafe_code)]

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::ffi::{CStr, CString};
use std::ptr;
use std::sync::Arc;

use anyhow::{Result, bail};
use fmu_description::{Access, Variable};

use super::answer::{Answer, Ended};
use super::border::{Border, Value};
use super::messages::{Speaker, receive_3};
use crate::batch::{Batch, Layout};
use crate::fmu::functions::{Functions3, Handle, call};

/// An instance; freed when dropped.
pub struct Instance {
    api: Arc<Functions3>,
    instance: Handle,
    has_events: bool,
    in_events: Cell<bool>,
    /// End of the last step, s.
    time: Cell<f64>,
    /// What was last given to each element.
    memory: RefCell<Vec<u64>>,
    /// Room for what one call passes.
    passed: RefCell<Vec<u64>>,
    /// Texts of arrays of strings, by slot of the memory.
    texts: RefCell<BTreeMap<usize, CString>>,
    layout: Arc<Layout>,
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
    /// The master goes through Event Mode at each communication point.
    pub has_events: bool,
}

impl Instance {
    /// `fmi3InstantiateCoSimulation`; None where the FMU gives no instance.
    pub fn new(
        api: &Arc<Functions3>,
        layout: &Arc<Layout>,
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
                false,
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
            in_events: Cell::new(false),
            time: Cell::new(f64::NAN),
            memory: RefCell::new(layout.initial.clone()),
            passed: RefCell::new(vec![0; layout.initial.len()]),
            texts: RefCell::default(),
            layout: layout.clone(),
            _speaker: speaker,
        }))
    }

    /// Write what the memory holds for these slots into the room for a call.
    fn gather(&self, access: Access, spans: &[std::ops::Range<usize>], passed: &mut [u64]) {
        let memory = self.memory.borrow();
        let slots = spans.iter().flat_map(|span| &memory[span.clone()]);
        for (k, slot) in slots.enumerate() {
            store(access, passed, k, *slot);
        }
    }

    /// `fmi3SetXXX` with what the memory holds.
    fn set_numbers(&self, access: Access, vr: &[u32], spans: &[std::ops::Range<usize>]) -> Answer {
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

    fn set_text(&self, variable: &Variable, text: &CString) -> Answer {
        let span = self.layout.span(variable.reference);
        let mut texts = self.texts.borrow_mut();
        texts.insert(span.start + variable.element.unwrap_or(0), text.clone());
        let empty = CString::default();
        let all: Vec<_> = span
            .map(|k| texts.get(&k).unwrap_or(&empty).as_ptr())
            .collect();
        let vr = [variable.reference];
        // SAFETY: one reference, and a C string for each of its elements.
        unsafe {
            let (all, n) = (all.as_ptr(), all.len());
            call!(
                self.api,
                fmi3SetString(self.instance, vr.as_ptr(), 1, all, n)
            )
        }
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

    fn set_one(&self, variable: &Variable, value: &Value) -> Answer {
        match value {
            Value::Text(text) => self.set_text(variable, text),
            Value::Bits(bits) => {
                let span = self.layout.span(variable.reference);
                self.memory.borrow_mut()[span.start + variable.element.unwrap_or(0)] = *bits;
                self.set_numbers(variable.access(), &[variable.reference], &[span])
            }
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
    fn exit_initialization(&self) -> Answer {
        // SAFETY: the instance is alive.
        let answer = unsafe { call!(self.api, fmi3ExitInitializationMode(self.instance)) };
        self.in_events.set(self.has_events);
        answer
    }

    fn get(&self, batch: &Batch, values: &mut [f64]) -> Answer {
        assert_eq!(batch.len(), values.len());
        if batch.is_whole && batch.access == Access::Real {
            return self.get_numbers(batch, values.as_mut_ptr().cast());
        }
        let mut passed = self.passed.borrow_mut();
        assert!(batch.passed <= passed.len());
        let answer = self.get_numbers(batch, passed.as_mut_ptr());
        if answer.is_done() {
            for (value, place) in values.iter_mut().zip(&batch.places) {
                *value = load(batch.access, &passed, *place);
            }
        }
        answer
    }

    fn set(&self, batch: &Batch, values: &[f64]) -> Answer {
        assert_eq!(batch.len(), values.len());
        let mut memory = self.memory.borrow_mut();
        for (value, slot) in values.iter().zip(&batch.slots) {
            memory[*slot] = as_bits(batch.access, *value);
        }
        drop(memory);
        self.set_numbers(batch.access, &batch.references, &batch.spans)
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

    fn step(&self, t: f64, h: f64) -> Result<Answer> {
        let [mut event, mut ends, mut early] = [false; 3];
        let mut time = self.time.get();
        // SAFETY: plain values and places for the results.
        let answer = unsafe {
            let (i, time) = (self.instance, &mut time);
            let (event, ends, early) = (&mut event, &mut ends, &mut early);
            call!(
                self.api,
                fmi3DoStep(i, t, h, true, event, ends, early, time)
            )
        };
        if answer.is_done() {
            self.time.set(time);
            if ends {
                bail!(Ended {
                    call: "fmi3DoStep",
                    time
                });
            }
            if early {
                bail!("fmi3DoStep returned early, at {time} s, which it was not allowed to");
            }
        }
        Ok(answer)
    }

    fn time(&self) -> Result<f64> {
        Ok(self.time.get())
    }

    fn enter_events(&self) -> Answer {
        if !self.has_events || self.in_events.get() {
            return Answer::done();
        }
        // SAFETY: the instance is alive.
        let answer = unsafe { call!(self.api, fmi3EnterEventMode(self.instance)) };
        self.in_events.set(true);
        answer
    }

    fn update_events(&self) -> Result<(Answer, bool)> {
        if !self.in_events.get() {
            return Ok((Answer::done(), false));
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
        if answer.is_done() && ends {
            bail!(Ended {
                call: "fmi3UpdateDiscreteStates",
                time: self.time.get()
            });
        }
        Ok((answer, again))
    }

    fn leave_events(&self) -> Answer {
        if !self.in_events.replace(false) {
            return Answer::done();
        }
        // SAFETY: the instance is alive.
        unsafe { call!(self.api, fmi3EnterStepMode(self.instance)) }
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

/// The number at place `k` of an array of the type of `access`.
#[expect(
    clippy::cast_precision_loss,
    reason = "an i64 beyond 2^53 is told to the nearest number"
)]
fn load(access: Access, array: &[u64], k: usize) -> f64 {
    assert!(k < array.len());
    let array = array.as_ptr();
    // SAFETY: `k` is a place of the array, since no type is larger than its elements.
    unsafe {
        by_type!(
            access,
            f64::from_bits(*array.add(k)),
            f64::from(*array.cast::<f32>().add(k)),
            |T| *array.cast::<T>().add(k) as f64
        )
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
