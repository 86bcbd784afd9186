//! Values of variables of all types, with a memory of what was given: whole arrays pass, and clocked
//! variables pass at ticks only.
#![allow(unsafe_code)]

use std::ptr;

use anyhow::Result;
use fmi_description::Access;

use super::encoding::{load, store};
use super::{Instance, Mode, owned};
use crate::io::value::Value;
use crate::slave::answer::{Answer, call};
use crate::wiring::batch::Batch;

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

impl Instance {
    /// Set variables to what the memory holds.
    pub(super) fn set_remembered(&self, batch: &Batch) -> Result<()> {
        let (api, i) = (&self.api, self.instance);
        let (vr, m) = (batch.references.as_ptr(), batch.references.len());
        let n = batch.passed;
        match batch.access {
            Access::String | Access::Binary => {
                let (texts, is_text) = (self.known.texts.borrow(), batch.access == Access::String);
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
                let (mut passed, memory) = (self.passed.borrow_mut(), self.known.memory.borrow());
                let slots = batch.spans.iter().flat_map(|span| &memory[span.clone()]);
                for (k, slot) in slots.enumerate() {
                    store(access, &mut passed, k, *slot);
                }
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
    pub(super) fn get_numbers(&self, batch: &Batch, p: *mut u64) -> Result<()> {
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
    pub(super) fn remember(&self, batch: &Batch) -> Result<()> {
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
                    self.known
                        .texts
                        .borrow_mut()
                        .insert(*slot, Value::Text(text));
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
                    self.known.texts.borrow_mut().insert(*slot, value);
                }
            }
            access => {
                let (mut passed, mut memory) =
                    (self.passed.borrow_mut(), self.known.memory.borrow_mut());
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
    pub(super) fn is_open(&self, batch: &Batch) -> bool {
        let is_active = |clock: &u32| self.known.active.borrow().contains(clock);
        let is_free = batch.clocks.is_empty() || !self.has_events;
        is_free
            || self.known.mode.get() == Mode::Initialization
            || batch.clocks.iter().any(is_active)
    }

    /// Discrete values change in Event Mode: into it, where one of them is not what it was.
    pub(super) fn open(
        &self,
        batch: &Batch,
        is_changed: impl Fn(usize, usize) -> bool,
    ) -> Result<()> {
        let is_stepping = self.has_events && self.known.mode.get() == Mode::Step;
        let mut all = batch.discrete.iter();
        match is_stepping && all.any(|(slot, k)| is_changed(*slot, *k)) {
            true => self.enter_events(),
            false => Ok(()),
        }
    }
}
