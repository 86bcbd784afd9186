//! Calls that save states, and write them as bytes.

use std::ffi::c_int;
use std::ptr;

use super::{Array, RawInstance, either, room};
use crate::functions::OwnFunctions;
use crate::standard::Pointer;

/// The handle of a saved state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateHandle(Pointer);

impl StateHandle {
    /// NULL, which may be freed.
    pub const NULL: Self = Self(ptr::null_mut());
    /// One that no instance has given.
    pub const INVENTED: Self = Self(ptr::dangling_mut::<u64>().cast());

    /// It is NULL.
    pub fn is_null(self) -> bool {
        self.0.is_null()
    }
}

impl RawInstance {
    /// Saves the state to a handle, which may be that of a saved state.
    pub fn get_state(&self, state: Option<&mut StateHandle>) -> c_int {
        let to = room(state.map(|state| &mut state.0));
        // SAFETY: a live instance or NULL; NULL or a place with a handle.
        unsafe {
            either!(self, f =>
                (f.fmi2GetFMUstate)(self.c, to),
                (f.fmi3GetFMUState)(self.c, to))
        }
    }

    /// Frees what a handle leads to.
    pub fn free_state(&self, state: Option<&mut StateHandle>) -> c_int {
        let to = room(state.map(|state| &mut state.0));
        // SAFETY: a live instance or NULL; NULL or a place with a handle.
        unsafe {
            either!(self, f =>
                (f.fmi2FreeFMUstate)(self.c, to),
                (f.fmi3FreeFMUState)(self.c, to))
        }
    }

    /// Back to a saved state.
    pub fn set_state(&self, StateHandle(state): StateHandle) -> c_int {
        // SAFETY: a live instance or NULL; a handle.
        unsafe {
            either!(self, f =>
                (f.fmi2SetFMUstate)(self.c, state),
                (f.fmi3SetFMUState)(self.c, state))
        }
    }

    /// How many bytes a state takes.
    pub fn serialized_size(
        &self,
        StateHandle(state): StateHandle,
        size: Option<&mut usize>,
    ) -> c_int {
        // SAFETY: a live instance or NULL; a handle; NULL or a place for the result.
        unsafe {
            either!(self, f =>
                (f.fmi2SerializedFMUstateSize)(self.c, state, room(size)),
                (f.fmi3SerializedFMUStateSize)(self.c, state, room(size)))
        }
    }

    /// A state as bytes.
    pub fn serialize(&self, StateHandle(state): StateHandle, bytes: &mut [u8]) -> c_int {
        let (to, n) = (bytes.as_mut_ptr(), bytes.len());
        // SAFETY: a live instance or NULL; a handle; room for as many bytes as said.
        unsafe {
            either!(self, f =>
                (f.fmi2SerializeFMUstate)(self.c, state, to, n),
                (f.fmi3SerializeFMUState)(self.c, state, to, n))
        }
    }

    /// A state of bytes.
    pub fn deserialize(&self, bytes: Array<u8>, state: Option<&mut StateHandle>) -> c_int {
        let to = room(state.map(|state| &mut state.0));
        let (from, n) = (bytes.pointer(), bytes.len());
        // SAFETY: a live instance or NULL; NULL or as many bytes as said; NULL or a place.
        unsafe {
            either!(self, f =>
                (f.fmi2DeSerializeFMUstate)(self.c, from, n, to),
                (f.fmi3DeserializeFMUState)(self.c, from, n, to))
        }
    }
}
