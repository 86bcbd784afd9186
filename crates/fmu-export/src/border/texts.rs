//! Texts through C, and the importer's wishes for the log, which are texts too.

use super::arguments::{ArrayMut, texts};
use super::body::{Body, Version};
use super::log::c_string;
use crate::Model;
use crate::core::fault::Fault;
use crate::core::phase::Phase;
use crate::core::place::Place;
use std::ffi::c_char;

impl<M: Model, V: Version> Body<M, V> {
    /// Sets texts, the `k`-th of them in `number(k)`.
    pub(crate) fn set_texts(
        &mut self,
        number: impl Fn(usize) -> u32,
        texts: &[&str],
    ) -> Result<(), Fault> {
        let pairs: Vec<_> = (texts.iter().enumerate())
            .map(|(k, text)| (number(k), *text))
            .collect();
        self.instance.set_texts(&pairs)
    }

    /// Gets `n` texts, which stay valid until the next call of it.
    pub(crate) fn get_texts(
        &mut self,
        n: usize,
        number: impl Fn(usize) -> u32,
        to: ArrayMut<*const c_char>,
    ) -> Result<(), Fault> {
        let mut strings = Vec::with_capacity(n);
        for number in (0..n).map(number) {
            let (_, row) = self.instance.layout.find_any(number)?;
            let is_output = matches!(row.place, Place::StringOut(_));
            if is_output && self.instance.state.phase == Phase::Instantiated {
                self.instance.start_output(row)?;
            }
            strings.push(c_string(self.instance.text(number)?));
        }
        self.strings = strings;
        for (k, text) in self.strings.iter().enumerate() {
            to.put(k, text.as_ptr());
        }
        Ok(())
    }

    /// Switches categories of messages on or off.
    ///
    /// # Safety
    /// `categories` is NULL or points at `n` values, each NULL or a C string.
    pub(crate) unsafe fn set_logging(
        &mut self,
        on: bool,
        n: usize,
        categories: *const *const c_char,
    ) -> Result<(), Fault> {
        // SAFETY: forwarded.
        let names = unsafe { texts("categories", categories, n) }?;
        let enabled = V::switched(&self.log, on, &names)?;
        self.log.enable(enabled);
        self.instance.wanted = self.log.wanted_of_model();
        Ok(())
    }
}
