//! Saved states of an instance, and their bytes.

use std::ffi::c_int;
use std::ptr;

use anyhow::{Result, bail, ensure};

use super::instance::Instance;
use super::symbols::Pointer;

/// A saved state of an instance.
#[derive(Clone, Copy, Debug)]
pub struct SavedState(Pointer);

impl SavedState {
    /// NULL, which may be freed.
    pub const NONE: Self = Self(ptr::null_mut());
}

impl Instance<'_> {
    /// A state of it, saved by fmi2GetFMUstate.
    pub fn save(&self) -> Result<SavedState> {
        let (name, mut state) = ("fmi2GetFMUstate", ptr::null_mut());
        // SAFETY: a live instance, a place for the result.
        self.done(name, |f, c| unsafe { f.get_fmu_state(c, &mut state) })?;
        ensure!(!state.is_null(), "{name} gave NULL");
        Ok(SavedState(state))
    }

    /// Go back to a saved state, of this time in s.
    pub fn go_back(&mut self, SavedState(state): SavedState, time: f64) -> Result<()> {
        self.time = time;
        // SAFETY: a live instance and a state of it.
        self.done("fmi2SetFMUstate", |f, c| unsafe {
            f.set_fmu_state(c, state)
        })
    }

    /// Free a saved state, or NULL.
    pub fn free(&self, SavedState(mut state): SavedState) -> Result<()> {
        // SAFETY: a live instance and a state of it, or NULL.
        self.done("fmi2FreeFMUstate", |f, c| unsafe {
            f.free_fmu_state(c, &mut state)
        })
    }

    /// All of it that can be saved, as bytes.
    pub fn bytes(&self) -> Result<Vec<u8>> {
        let (state, mut size) = (self.save()?, 0);
        let name = "fmi2SerializedFMUstateSize";
        // SAFETY: a live instance, a state of it, a place for the result.
        self.done(name, |f, c| unsafe {
            f.serialized_fmu_state_size(c, state.0, &mut size)
        })?;
        let mut bytes = Vec::new();
        if bytes.try_reserve_exact(size).is_err() {
            bail!("{name} gave {size} bytes");
        }
        bytes.resize(size, 0_u8);
        let to = bytes.as_mut_ptr();
        // SAFETY: as many bytes as asked for.
        self.done("fmi2SerializeFMUstate", |f, c| unsafe {
            f.serialize_fmu_state(c, state.0, to, size)
        })?;
        self.free(state)?;
        Ok(bytes)
    }

    /// A state made of bytes; the status, and what was made.
    pub fn deserialize(&self, bytes: &[u8]) -> (c_int, SavedState) {
        let (from, n, mut state) = (bytes.as_ptr(), bytes.len(), ptr::null_mut());
        let f = &self.fmu.functions;
        // SAFETY: a live instance, readable bytes of the length given, a place for the result.
        let status = unsafe { f.deserialize_fmu_state(self.c, from, n, &mut state) };
        (status, SavedState(state))
    }

    /// Take over a state of this time, s, that was saved as bytes.
    pub fn restore(&mut self, bytes: &[u8], time: f64) -> Result<()> {
        let (status, state) = self.deserialize(bytes);
        self.must("fmi2DeSerializeFMUstate", status)?;
        self.go_back(state, time)?;
        self.free(state)
    }
}
