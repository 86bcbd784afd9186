//! Saved states of an [`Instance`], and their bytes, for `fmu-check` and `torture`.

use std::ffi::c_int;

use anyhow::{Result, bail, ensure};

use crate::instance::Instance;
use crate::raw::{Array, RawInstance, StateHandle};

impl Instance<'_> {
    /// Saves the state (fmi2GetFMUstate).
    pub fn save(&self) -> Result<StateHandle> {
        let (name, mut state) = ("fmi2GetFMUstate", StateHandle::NULL);
        self.done(name, |raw| raw.get_state(Some(&mut state)))?;
        ensure!(!state.is_null(), "{name} gave NULL");
        Ok(state)
    }

    /// Restores a saved state of this time, s.
    pub fn go_back(&mut self, state: StateHandle, time: f64) -> Result<()> {
        self.time = time;
        self.done("fmi2SetFMUstate", |raw| raw.set_state(state))
    }

    /// Frees a saved state, or NULL.
    pub fn free(&self, mut state: StateHandle) -> Result<()> {
        self.done("fmi2FreeFMUstate", |raw| raw.free_state(Some(&mut state)))
    }

    /// The present state as bytes.
    pub fn bytes(&self) -> Result<Vec<u8>> {
        let (state, mut size) = (self.save()?, 0);
        let name = "fmi2SerializedFMUstateSize";
        self.done(name, |raw| raw.serialized_size(state, Some(&mut size)))?;
        let mut bytes = Vec::new();
        if bytes.try_reserve_exact(size).is_err() {
            bail!("{name} gave {size} bytes");
        }
        bytes.resize(size, 0_u8);
        let serialize = |raw: &RawInstance| raw.serialize(state, &mut bytes);
        self.done("fmi2SerializeFMUstate", serialize)?;
        self.free(state)?;
        Ok(bytes)
    }

    /// The status, and a saved state made of bytes.
    pub fn state_from_bytes(&self, bytes: &[u8]) -> (c_int, StateHandle) {
        let mut state = StateHandle::NULL;
        let status = self.deserialize(Array::Elements(bytes), Some(&mut state));
        (status, state)
    }

    /// Restores a state of this time, s, from its bytes.
    pub fn restore(&mut self, bytes: &[u8], time: f64) -> Result<()> {
        let (status, state) = self.state_from_bytes(bytes);
        self.must("fmi2DeSerializeFMUstate", status)?;
        self.go_back(state, time)?;
        self.free(state)
    }
}
