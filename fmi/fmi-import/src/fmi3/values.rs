//! Values of variables of all types, with a memory of what was given: whole arrays pass, and clocked
//! variables pass at ticks only.

use std::ffi::c_int;

use anyhow::Result;
use fmi_description::Access;

use super::{Instance, Mode};
use crate::answer::Answer;
use crate::batch::Batch;
use crate::encoding::{load, store};
use crate::value::Value;

/// Places in the names of the functions of a type.
const GET: usize = 0;
const SET: usize = 1;

impl Instance {
    #[inline]
    fn check(&self, status: c_int, access: Access, function: usize) -> Result<()> {
        match status {
            0 | 1 => Ok(()),
            _ => Answer::refuse(status, self.raw.functions().names_of(access)[function]),
        }
    }

    /// Set variables to what the memory holds.
    pub(super) fn set_remembered(&self, batch: &Batch) -> Result<()> {
        let vr = &batch.references;
        match batch.access {
            Access::String | Access::Binary => {
                let texts = self.known.texts.borrow();
                let slots = batch.spans.iter().cloned().flatten();
                let values = slots.map(|slot| texts.get(&slot));
                if batch.access == Access::String {
                    let texts = values.map(|value| match value {
                        Some(Value::Text(text)) => Some(text.as_c_str()),
                        _ => Some(c""),
                    });
                    let texts: Vec<_> = texts.collect();
                    return Answer::check(self.raw.set_strings(vr, &texts), "fmi3SetString");
                }
                let all = values.map(|value| match value {
                    Some(Value::Bytes(bytes)) => &bytes[..],
                    _ => &[],
                });
                let all: Vec<_> = all.collect();
                Answer::check(self.raw.set_binaries(vr, &all), "fmi3SetBinary")
            }
            access => {
                let (mut passed, memory) = (self.passed.borrow_mut(), self.known.memory.borrow());
                let slots = batch.spans.iter().flat_map(|span| &memory[span.clone()]);
                for (k, slot) in slots.enumerate() {
                    store(access, &mut passed, k, *slot);
                }
                let (m, n, p) = (vr.len(), batch.passed, passed.as_ptr());
                assert!(n <= passed.len());
                // SAFETY: `m` references, and `n` values of the type of the call, which the memory
                // has for these references.
                let status = unsafe {
                    let (i, vr) = (self.instance, vr.as_ptr());
                    self.api.set_numbers(access, i, vr, m, p, n)
                };
                self.check(status, access, SET)
            }
        }
    }

    /// `fmi3GetXXX` into the room for a call.
    pub(super) fn get_numbers(&self, batch: &Batch, p: *mut u64) -> Result<()> {
        let (i, access, n) = (self.instance, batch.access, batch.passed);
        let (vr, m) = (batch.references.as_ptr(), batch.references.len());
        // SAFETY: `m` references and room for `n` values of at most eight bytes each, the caller's
        // promise.
        let status = unsafe { self.api.get_numbers(access, i, vr, m, p, n) };
        self.check(status, access, GET)
    }

    /// Read variables into the memory.
    pub(super) fn remember(&self, batch: &Batch) -> Result<()> {
        let (vr, n) = (&batch.references, batch.passed);
        let places = batch.slots.iter().zip(&batch.places);
        let values: Vec<Value> = match batch.access {
            Access::String => {
                let (status, texts) = self.raw.get_strings(vr, n);
                Answer::check(status, "fmi3GetString")?;
                texts
                    .unwrap_or_default()
                    .into_iter()
                    .map(Value::Text)
                    .collect()
            }
            Access::Binary => {
                let (status, all) = self.raw.get_binaries(vr, n);
                Answer::check(status, "fmi3GetBinary")?;
                all.into_iter().map(Value::Bytes).collect()
            }
            access => {
                let (mut passed, mut memory) =
                    (self.passed.borrow_mut(), self.known.memory.borrow_mut());
                assert!(n <= passed.len());
                self.get_numbers(batch, passed.as_mut_ptr())?;
                for (slot, place) in places {
                    memory[*slot] = load(access, &passed, *place);
                }
                return Ok(());
            }
        };
        let mut texts = self.known.texts.borrow_mut();
        for (slot, place) in places {
            let value = values.get(*place).cloned();
            texts.insert(*slot, value.unwrap_or_else(|| Value::none(batch.access)));
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
