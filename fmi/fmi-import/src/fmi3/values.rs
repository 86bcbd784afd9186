//! Sets and reads variables of an instance of FMI 3.0 through its memory, for `fmi3` and `events`:
//! whole arrays are passed from there although only some elements are set, and clocked variables
//! although they were set earlier.

use anyhow::Result;
use fmi_description::Access;

use super::{Fmi3Instance, Mode};
use crate::answer::Answer;
use crate::batch::Batch;
use crate::encoding::{load, store};
use crate::raw::Array;
use crate::status::NO_TEXT;
use crate::value::Value;

impl Fmi3Instance {
    /// Sets variables to what the memory holds, if they may be set now.
    pub(super) fn set_if_accessible(&self, batch: &Batch) -> Result<()> {
        match self.is_accessible(batch) {
            true => self.set_from_memory(batch),
            false => Ok(()),
        }
    }

    /// Sets variables to what the memory holds.
    pub(super) fn set_from_memory(&self, batch: &Batch) -> Result<()> {
        let vr = &batch.references;
        match batch.access {
            Access::String | Access::Binary => {
                let texts = self.tracked.texts.borrow();
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
                let room = &mut self.binaries.borrow_mut();
                Answer::check(self.raw.set_binaries_from(vr, all, room), "fmi3SetBinary")
            }
            access => {
                let (mut passed, memory) = (self.passed.borrow_mut(), self.tracked.memory.borrow());
                let slots = batch.spans.iter().flat_map(|span| &memory[span.clone()]);
                for (k, slot) in slots.enumerate() {
                    store(access, &mut passed, k, *slot);
                }
                let (vr, passed) = (Array::Elements(&vr[..]), Array::Elements(&passed[..]));
                let status = self.raw.set_numbers(access, vr, passed, batch.passed);
                Answer::check_named(status, || self.raw.functions().names_of(access)[1])
            }
        }
    }

    /// Gets the numbers of a batch, each in the size of its C type.
    pub(super) fn get_numbers(&self, batch: &Batch, values: &mut [u64]) -> Result<()> {
        let (access, vr) = (batch.access, Array::Elements(&batch.references[..]));
        let status = (self.raw).get_numbers(access, vr, Some(values), batch.passed);
        Answer::check_named(status, || self.raw.functions().names_of(access)[0])
    }

    /// Reads variables into the memory.
    pub(super) fn read_to_memory(&self, batch: &Batch) -> Result<()> {
        let (vr, n) = (&batch.references, batch.passed);
        let places = batch.slots.iter().zip(&batch.places);
        let values: Vec<Value> = match batch.access {
            Access::String => {
                let (status, texts) = self.raw.get_strings(vr, n);
                Answer::check(status, "fmi3GetString")?;
                let Some(texts) = texts else {
                    return Answer::refuse(NO_TEXT, "fmi3GetString");
                };
                texts.into_iter().map(Value::Text).collect()
            }
            Access::Binary => {
                let room = &mut self.binaries.borrow_mut();
                let status = self.raw.get_binaries_into(vr, n, room);
                Answer::check(status, "fmi3GetBinary")?;
                for (slot, place) in places {
                    self.keep_text(*slot, &room.values[*place]);
                }
                return Ok(());
            }
            access => {
                let (mut passed, mut memory) =
                    (self.passed.borrow_mut(), self.tracked.memory.borrow_mut());
                self.get_numbers(batch, &mut passed)?;
                for (slot, place) in places {
                    memory[*slot] = load(access, &passed, *place);
                }
                return Ok(());
            }
        };
        let mut texts = self.tracked.texts.borrow_mut();
        for (slot, place) in places {
            let value = values.get(*place).cloned();
            texts.insert(*slot, value.unwrap_or_else(|| Value::empty(batch.access)));
        }
        Ok(())
    }

    /// Keeps a text or bytes in the memory.
    pub(super) fn keep_text(&self, slot: usize, value: &Value) {
        let mut texts = self.tracked.texts.borrow_mut();
        match texts.get_mut(&slot) {
            Some(own) => own.clone_from(value),
            None => drop(texts.insert(slot, value.clone())),
        }
    }

    /// Whether these variables may be set and read now: clocked ones only while a clock of theirs
    /// is active.
    pub(super) fn is_accessible(&self, batch: &Batch) -> bool {
        let is_active = |clock: &u32| self.tracked.active.borrow().contains(clock);
        let is_free = batch.clocks.is_empty() || !self.has_events;
        is_free
            || self.tracked.mode.get() == Mode::Initialization
            || batch.clocks.iter().any(is_active)
    }

    /// Enters Event Mode if a discrete input of the batch is about to change, which is allowed
    /// there only. `is_changed` is asked with its slot and its place in the batch.
    pub(super) fn enter_events_if(
        &self,
        batch: &Batch,
        is_changed: impl Fn(usize, usize) -> bool,
    ) -> Result<()> {
        let may_enter = self.has_events && self.tracked.mode.get() != Mode::Initialization;
        let mut all = batch.discrete.iter();
        if !may_enter || !all.any(|(slot, k)| is_changed(*slot, *k)) {
            return Ok(());
        }
        self.has_event.set(true);
        self.enter_events()
    }
}
