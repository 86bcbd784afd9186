//! Saved states in the C interface, for `fmi2` and `fmi3`: saving, freeing, serializing and
//! deserializing. `name` is the argument's name in messages, which differs between versions.

use super::arguments::{array_mut, bytes, output_argument};
use super::fmi_instance::{FmiInstance, Version};
use crate::Model;
use crate::core::fault::{Fault, refuse};
use std::ffi::c_void;
use std::ptr;

/// The pointer that C receives for a saved state: a number that is looked up, never dereferenced.
fn to_c(handle: usize) -> *mut c_void {
    ptr::without_provenance_mut(handle)
}

impl<M: Model, V: Version> FmiInstance<M, V> {
    /// Saves the present state in the handle that `state` holds, or in a new one if it holds NULL.
    ///
    /// # Safety
    /// `state` is NULL or points at a handle that is readable and writable.
    pub(crate) unsafe fn save(&mut self, name: &str, state: *mut *mut c_void) -> Result<(), Fault> {
        // SAFETY: forwarded; not NULL where it is read, as `place` has checked.
        unsafe {
            let to = output_argument(name, state)?;
            let handle = self.instance.save(state.read_unaligned().addr())?;
            to.put(0, to_c(handle));
        }
        Ok(())
    }

    /// Frees a saved state and sets its handle to NULL; NULL is ignored.
    ///
    /// # Safety
    /// As for [`Self::save`].
    pub(crate) unsafe fn free(&mut self, name: &str, state: *mut *mut c_void) -> Result<(), Fault> {
        if state.is_null() {
            return Ok(());
        }
        // SAFETY: forwarded; not NULL.
        unsafe {
            self.instance.free(state.read_unaligned().addr())?;
            output_argument(name, state)?.put(0, ptr::null_mut());
        }
        Ok(())
    }

    /// Returns the number of bytes of a serialized state.
    ///
    /// # Safety
    /// `size` is NULL or writable.
    pub(crate) unsafe fn serialized_size(
        &self,
        state: *mut c_void,
        size: *mut usize,
    ) -> Result<(), Fault> {
        // SAFETY: forwarded.
        let to = unsafe { output_argument("size", size) }?;
        to.put(0, self.instance.serialize(state.addr())?.len());
        Ok(())
    }

    /// Writes the bytes of a saved state; the rest of the buffer is not changed.
    ///
    /// # Safety
    /// `bytes` is NULL or points at `size` writable bytes.
    pub(crate) unsafe fn serialize(
        &self,
        state: *mut c_void,
        bytes: *mut u8,
        size: usize,
    ) -> Result<(), Fault> {
        let state = self.instance.serialize(state.addr())?;
        let needed = state.len();
        if size < needed {
            return refuse!("size = {size} must be at least {needed} bytes");
        }
        // SAFETY: forwarded.
        let to = unsafe { array_mut("serializedState", bytes, size) }?;
        for (k, byte) in state.into_iter().enumerate() {
            to.put(k, byte);
        }
        Ok(())
    }

    /// Reads a saved state from bytes into the handle in `state`, or a new one if it is NULL.
    ///
    /// # Safety
    /// `serialized` is NULL or points at `size` constant bytes; `state` as for [`Self::save`].
    pub(crate) unsafe fn deserialize(
        &mut self,
        serialized: *const u8,
        size: usize,
        name: &str,
        state: *mut *mut c_void,
    ) -> Result<(), Fault> {
        // SAFETY: forwarded; not NULL where it is read, as `place` has checked.
        unsafe {
            let bytes = bytes("serializedState", serialized, size)?;
            let to = output_argument(name, state)?;
            let handle = (self.instance).deserialize(bytes, state.read_unaligned().addr())?;
            to.put(0, to_c(handle));
        }
        Ok(())
    }
}
