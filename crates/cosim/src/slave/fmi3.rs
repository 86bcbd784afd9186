//! The calls of FMI 3.0, over the raw binding of the `fmi` crate.
//!
//! The crate's own `Instance` is not used, because its slices become lengths that the FMU is told without a check, its logger does not say
//! which instance spoke and panics on an unknown status, and a missing function panics.
#![allow(unsafe_code)]

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, CString, c_char};
use std::ptr;
use std::sync::Arc;

use anyhow::{Result, bail};
use fmi::fmi3::binding::{self, Fmi3Binding};
use fmu_description::{Access, Variable};

use super::{Answer, Border, Value};
use crate::batch::{Batch, Layout};
use crate::messages;

/// An instance; freed when dropped.
pub struct Instance {
    api: Arc<Fmi3Binding>,
    instance: binding::fmi3Instance,
    has_events: bool,
    in_events: Cell<bool>,
    /// End of the last step, s.
    time: Cell<f64>,
    /// What was last given to each element.
    memory: RefCell<Vec<u64>>,
    /// Room for what one call passes.
    passed: RefCell<Vec<u64>>,
    /// Texts of arrays of strings, by slot of the memory.
    texts: RefCell<std::collections::BTreeMap<usize, CString>>,
    layout: Arc<Layout>,
    /// Name of the instance, which the logger is handed.
    _name: Box<CString>,
}

/// What an instance is made with.
pub struct Made<'a> {
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
    pub fn new(api: &Arc<Fmi3Binding>, layout: &Arc<Layout>, made: &Made) -> Option<Self> {
        let name = Box::new(CString::from(made.name));
        // SAFETY: valid C strings; the environment is the name, which outlives the instance.
        let instance = unsafe {
            api.fmi3InstantiateCoSimulation(
                made.name.as_ptr(),
                made.token.as_ptr(),
                made.resources.as_ptr(),
                false,
                true,
                made.has_events,
                false,
                ptr::null(),
                0,
                ptr::from_ref(&*name).cast_mut().cast(),
                Some(log),
                None,
            )
        };
        (!instance.is_null()).then(|| Self {
            api: api.clone(),
            instance,
            has_events: made.has_events,
            in_events: Cell::new(false),
            time: Cell::new(f64::NAN),
            memory: RefCell::new(layout.initial.clone()),
            passed: RefCell::new(vec![0; layout.initial.len()]),
            texts: RefCell::default(),
            layout: layout.clone(),
            _name: name,
        })
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
                    $(Access::$access => (api.$name(i, vr, m, p.cast(), n), stringify!($name)),)*
                    other => unreachable!("{other:?} is no number"),
                }
            };
        }
        // SAFETY: `m` references, and `n` values of the type of the call, which the memory has for these references.
        let (status, call) = unsafe {
            calls! {
                Real fmi3SetFloat64 Float32 fmi3SetFloat32 Int8 fmi3SetInt8 UInt8 fmi3SetUInt8 Int16 fmi3SetInt16 UInt16 fmi3SetUInt16
                Integer fmi3SetInt32 UInt32 fmi3SetUInt32 Int64 fmi3SetInt64 UInt64 fmi3SetUInt64 Boolean fmi3SetBoolean
            }
        };
        Answer::new(status, call)
    }

    /// `fmi3GetXXX` into the room for a call.
    fn get_numbers(&self, batch: &Batch, p: *mut u64) -> Answer {
        let (api, i, n) = (&self.api, self.instance, batch.passed);
        let (vr, m) = (batch.references.as_ptr(), batch.references.len());
        macro_rules! calls {
            ($($access:ident $name:ident)*) => {
                match batch.access {
                    $(Access::$access => (api.$name(i, vr, m, p.cast(), n), stringify!($name)),)*
                    other => unreachable!("{other:?} is no number"),
                }
            };
        }
        // SAFETY: `m` references and room for `n` values of at most eight bytes each, the caller's promise.
        let (status, call) = unsafe {
            calls! {
                Real fmi3GetFloat64 Float32 fmi3GetFloat32 Int8 fmi3GetInt8 UInt8 fmi3GetUInt8 Int16 fmi3GetInt16 UInt16 fmi3GetUInt16
                Integer fmi3GetInt32 UInt32 fmi3GetUInt32 Int64 fmi3GetInt64 UInt64 fmi3GetUInt64 Boolean fmi3GetBoolean
            }
        };
        Answer::new(status, call)
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
        let status = unsafe {
            (self.api).fmi3SetString(self.instance, vr.as_ptr(), 1, all.as_ptr(), all.len())
        };
        Answer::new(status, "fmi3SetString")
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: freed once; the library is still loaded.
        unsafe { self.api.fmi3FreeInstance(self.instance) };
    }
}

impl Border for Instance {
    fn log_only(&self, categories: &[CString]) -> Answer {
        let pointers: Vec<_> = categories.iter().map(|c| c.as_ptr()).collect();
        // SAFETY: as many valid C strings as said. All categories are on from instantiation, so that it may say why it fails.
        let status = unsafe {
            let n = pointers.len();
            match (self.api).fmi3SetDebugLogging(self.instance, false, 0, ptr::null()) {
                0 | 1 => (self.api).fmi3SetDebugLogging(self.instance, true, n, pointers.as_ptr()),
                status => status,
            }
        };
        Answer::new(status, "fmi3SetDebugLogging")
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

    fn enter_initialization(&self, start: f64) -> Answer {
        self.time.set(start);
        // SAFETY: plain values. No stop time: a run may be continued.
        let status = unsafe {
            (self.api).fmi3EnterInitializationMode(self.instance, false, 0.0, start, false, 0.0)
        };
        Answer::new(status, "fmi3EnterInitializationMode")
    }

    /// Leads into Event Mode where the master uses it.
    fn exit_initialization(&self) -> Answer {
        // SAFETY: the instance is alive.
        let status = unsafe { self.api.fmi3ExitInitializationMode(self.instance) };
        self.in_events.set(self.has_events);
        Answer::new(status, "fmi3ExitInitializationMode")
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
        // SAFETY: as many readable references as orders, and room for the values that belong to them.
        let status = unsafe {
            let (vr, m) = (batch.references.as_ptr(), batch.references.len());
            let (ones, room) = (ones.as_ptr(), passed.as_mut_ptr().cast());
            (self.api).fmi3GetOutputDerivatives(self.instance, vr, m, ones, room, batch.passed)
        };
        let answer = Answer::new(status, "fmi3GetOutputDerivatives");
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
        let status = unsafe {
            let (event, ends, early) = (&mut event, &mut ends, &mut early);
            (self.api).fmi3DoStep(self.instance, t, h, true, event, ends, early, &mut time)
        };
        let answer = Answer::new(status, "fmi3DoStep");
        if answer.is_done() {
            self.time.set(time);
            if ends {
                bail!("fmi3DoStep asks to end the simulation at {time} s");
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
            return Answer::new(0, "");
        }
        // SAFETY: the instance is alive.
        let status = unsafe { self.api.fmi3EnterEventMode(self.instance) };
        self.in_events.set(true);
        Answer::new(status, "fmi3EnterEventMode")
    }

    fn update_events(&self) -> Result<(Answer, bool)> {
        if !self.in_events.get() {
            return Ok((Answer::new(0, ""), false));
        }
        let [mut again, mut ends, mut nominals, mut values, mut has_next] = [false; 5];
        let mut next = 0.0;
        // SAFETY: the instance is alive; places for the results.
        let status = unsafe {
            (self.api).fmi3UpdateDiscreteStates(
                self.instance,
                &mut again,
                &mut ends,
                &mut nominals,
                &mut values,
                &mut has_next,
                &mut next,
            )
        };
        let answer = Answer::new(status, "fmi3UpdateDiscreteStates");
        if answer.is_done() && ends {
            bail!("fmi3UpdateDiscreteStates asks to end the simulation");
        }
        Ok((answer, again))
    }

    fn leave_events(&self) -> Answer {
        if !self.in_events.replace(false) {
            return Answer::new(0, "");
        }
        // SAFETY: the instance is alive.
        let status = unsafe { self.api.fmi3EnterStepMode(self.instance) };
        Answer::new(status, "fmi3EnterStepMode")
    }

    fn terminate(&self) -> Answer {
        // SAFETY: the instance is alive.
        let status = unsafe { self.api.fmi3Terminate(self.instance) };
        Answer::new(status, "fmi3Terminate")
    }

    /// The memory of what was last given would have to be as new, too: another instance is made instead.
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

/// The importer's logger: what is not a warning is a reason.
unsafe extern "C" fn log(
    environment: binding::fmi3InstanceEnvironment,
    status: binding::fmi3Status,
    _category: *const c_char,
    message: *const c_char,
) {
    if environment.is_null() || message.is_null() {
        return;
    }
    // SAFETY: the environment is the name of the instance, the message a C string of the FMU.
    let (name, text) = unsafe { (&*environment.cast::<CString>(), CStr::from_ptr(message)) };
    let is_warning = status <= binding::fmi3Status_fmi3Warning;
    messages::add(&name.to_string_lossy(), is_warning, &text.to_string_lossy());
}
