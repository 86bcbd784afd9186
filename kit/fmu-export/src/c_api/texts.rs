//! Getting and setting strings, and switching log categories by name, for `fmi2` and `fmi3`.

use super::arguments::{ArrayMut, texts};
use super::fmi_instance::{FmiInstance, Version};
use super::log::{Logger, c_string};
use crate::Model;
use crate::core::fault::Fault;
use std::ffi::c_char;

impl<M: Model, V: Version> FmiInstance<M, V> {
    /// Sets the texts of elements.
    pub(crate) fn set_texts(
        &mut self,
        elements: impl Iterator<Item = u32>,
        texts: &[&str],
    ) -> Result<(), Fault> {
        let texts = texts.iter().map(|text| (*text).to_owned());
        self.instance.set_texts(elements.zip(texts).collect())
    }

    /// Gets the texts of elements, which stay valid until its next call.
    pub(crate) fn get_texts(
        &mut self,
        elements: impl ExactSizeIterator<Item = u32>,
        to: ArrayMut<*const c_char>,
    ) -> Result<(), Fault> {
        let mut strings = Vec::with_capacity(elements.len());
        for number in elements {
            strings.push(c_string(self.instance.text(number)?));
        }
        self.strings = strings;
        for (k, text) in self.strings.iter().enumerate() {
            to.put(k, text.as_ptr());
        }
        Ok(())
    }

    /// Switches log categories on or off.
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
        let enabled = V::Logger::switch(&self.log, on, &names)?;
        self.log.enable(enabled);
        self.instance.log_filter = self.log.model_filter();
        Ok(())
    }
}
