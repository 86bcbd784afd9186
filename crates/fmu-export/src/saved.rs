//! Saved states: copies inside the instance, handed out as handles, and their bytes.
//!
//! A handle is looked up, never followed, so that a freed or foreign one is an error and not undefined behaviour. The bytes are
//! a header and the state in `postcard` (fixed little-endian reals, so that a return is bit-exact):
//! magic (8), version (4), GUID (16), length of the rest (8), CRC-32 of everything but itself (4).

use crate::Model;
use crate::calls::Mode;
use crate::failure::{Failure, refuse};
use crate::ffi::FmuState;
use crate::instance::{Instance, State};
use crate::log::Category;
use std::ptr;

const MAGIC: &[u8; 8] = b"fmi2-exp";
const VERSION: u32 = 1;
const CRC_AT: usize = 36;
const HEADER: usize = 40;

impl<M: Model> Instance<M> {
    /// fmi2GetFMUstate: a new copy, or one that overwrites the state behind `old`.
    pub(crate) fn save(&mut self, old: FmuState) -> Result<FmuState, Failure> {
        let mut state = Box::new(self.state.clone());
        if state.mode == Mode::Initialization {
            state.model = None; // only kept from one get to the next: made again when needed
        }
        self.keep(state, old)
    }

    fn keep(&mut self, state: Box<State<M>>, old: FmuState) -> Result<FmuState, Failure> {
        if !old.is_null() {
            let Some(place) = self.saved.get_mut(&(old as usize)) else {
                return unknown(old);
            };
            **place = *state;
            return Ok(old);
        }
        let handle = ptr::from_ref(&*state).addr();
        self.saved.insert(handle, state);
        Ok(ptr::without_provenance_mut(handle))
    }

    fn find(&self, handle: FmuState) -> Result<&State<M>, Failure> {
        match self.saved.get(&(handle as usize)) {
            Some(state) => Ok(state),
            None => unknown(handle),
        }
    }

    /// fmi2SetFMUstate.
    pub(crate) fn restore(&mut self, handle: FmuState) -> Result<(), Failure> {
        let state = self.find(handle)?.clone();
        self.log.send(
            Category::Events,
            &format!("state of t = {} s restored", state.time),
        );
        self.replace(state);
        Ok(())
    }

    /// fmi2FreeFMUstate; NULL is ignored.
    pub(crate) fn free(&mut self, handle: FmuState) -> Result<(), Failure> {
        if !handle.is_null() && self.saved.remove(&(handle as usize)).is_none() {
            return unknown(handle);
        }
        Ok(())
    }

    /// fmi2SerializeFMUstate (and the size of it).
    pub(crate) fn serialize(&self, handle: FmuState) -> Result<Vec<u8>, Failure> {
        let state = self.find(handle)?;
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(self.guid.as_bytes());
        bytes.extend([0; HEADER - 28]);
        let mut bytes = postcard::to_extend(state, bytes)
            .map_err(|e| Failure::Error(format!("the state cannot be serialized: {e}")))?;
        let length = (bytes.len() - HEADER) as u64;
        bytes[28..CRC_AT].copy_from_slice(&length.to_le_bytes());
        let crc = checksum(&bytes);
        bytes[CRC_AT..HEADER].copy_from_slice(&crc.to_le_bytes());
        Ok(bytes)
    }

    /// fmi2DeSerializeFMUstate; bytes after the end of the state are ignored.
    pub(crate) fn deserialize(&mut self, bytes: &[u8], old: FmuState) -> Result<FmuState, Failure> {
        let Some((header, rest)) = bytes.split_at_checked(HEADER) else {
            return refuse!(
                "serialized state has {} bytes; allowed are at least {HEADER}",
                bytes.len()
            );
        };
        if &header[..8] != MAGIC {
            return refuse!(
                "serialized state does not start with `fmi2-exp`: it is from elsewhere"
            );
        }
        let version = u32::from_le_bytes(header[8..12].try_into().expect("4 bytes"));
        if version != VERSION {
            return refuse!("serialized state has format version {version}; allowed is {VERSION}");
        }
        if header[12..28] != *self.guid.as_bytes() {
            let guid = uuid::Uuid::from_slice(&header[12..28]).expect("16 bytes");
            return refuse!(
                "serialized state is of an FMU with GUID {{{guid}}}; allowed is {{{}}}",
                self.guid
            );
        }
        let length = u64::from_le_bytes(header[28..CRC_AT].try_into().expect("8 bytes"));
        let Some(body) = usize::try_from(length).ok().and_then(|n| rest.get(..n)) else {
            return refuse!(
                "serialized state is truncated: {} bytes; allowed are {length} after the header",
                rest.len()
            );
        };
        let crc = u32::from_le_bytes(header[CRC_AT..].try_into().expect("4 bytes"));
        let found = checksum(&bytes[..HEADER + body.len()]);
        if crc != found {
            return refuse!(
                "serialized state is damaged: checksum {found:08x}; allowed is {crc:08x}"
            );
        }
        let sound = |state: &State<M>| state.is_sound(self.layout.len());
        match postcard::from_bytes::<State<M>>(body) {
            Ok(state) if sound(&state) => self.keep(Box::new(state), old),
            _ => refuse!("serialized state does not fit this version of the FMU"),
        }
    }
}

fn unknown<T>(handle: FmuState) -> Result<T, Failure> {
    refuse!(
        "FMUstate {handle:?} is not a saved state of this instance (never made by it, or freed); allowed are those that \
             fmi2GetFMUstate or fmi2DeSerializeFMUstate has returned to it"
    )
}

/// CRC-32 of a whole serialized state without its own four bytes.
fn checksum(bytes: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&bytes[..CRC_AT]);
    hasher.update(&bytes[HEADER..]);
    hasher.finalize()
}
