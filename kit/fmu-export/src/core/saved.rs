//! Saved states, for `c_api`: copies that an instance keeps by handle, and their serialization.
//!
//! A handle is a number that is looked up and never reused, so that a freed or foreign one is an
//! error. The bytes are a header and the state in `postcard` (little-endian reals, so that a
//! restored state is bit-exact). The header: magic (8 bytes), format version (4), version of FMI
//! (4), hash of the model (16), length of the rest (8), CRC-32 of everything but itself (4).

use super::fault::{Fault, refuse};
use super::instance::Instance;
use super::message::{Kind, shown};
use super::phase::Phase;
use super::state::State;
use crate::Model;
use std::sync::atomic::{AtomicUsize, Ordering};

const MAGIC: &[u8; 8] = b"fmu-exp\0";
const VERSION: u32 = 7;
const MODEL_AT: usize = 16;
const LENGTH_AT: usize = 32;
const CRC_AT: usize = 40;
const HEADER: usize = 44;

/// The next handle, for all instances; 0 means none.
static NEXT: AtomicUsize = AtomicUsize::new(1);

impl<M: Model> Instance<M> {
    /// Saves the present state under the handle `old`, or under a new one if `old` is 0.
    pub(crate) fn save(&mut self, old: usize) -> Result<usize, Fault> {
        let handle = match self.saved.get_mut(&old) {
            Some(state) => {
                state.copy(&self.state);
                old
            }
            None => self.keep(Box::new(self.state.clone()), old)?,
        };
        let state = self.saved.get_mut(&handle).expect("kept above");
        state.first = self.workspace.first;
        if state.phase == Phase::Initialization {
            state.model = None; // only a cache in this mode: recomputed when needed
        }
        Ok(handle)
    }

    /// Stores a state under the handle `old`, or under a new one if `old` is 0.
    fn keep(&mut self, state: Box<State<M>>, old: usize) -> Result<usize, Fault> {
        let handle = match old {
            0 => NEXT.fetch_add(1, Ordering::Relaxed),
            old if self.saved.contains_key(&old) => old,
            old => return unknown(old),
        };
        self.saved.insert(handle, state);
        Ok(handle)
    }

    /// Restores a saved state.
    pub(crate) fn restore(&mut self, handle: usize) -> Result<(), Fault> {
        let Some(saved) = self.saved.get(&handle) else {
            return unknown(handle);
        };
        self.state.copy(saved);
        let text = format!("state of t = {} s restored", shown(self.state.time));
        self.report(Kind::Event, text);
        self.adopt_state();
        Ok(())
    }

    /// Frees a saved state; 0 is ignored.
    pub(crate) fn free(&mut self, handle: usize) -> Result<(), Fault> {
        if handle != 0 && self.saved.remove(&handle).is_none() {
            return unknown(handle);
        }
        Ok(())
    }

    /// The bytes of a saved state.
    pub(crate) fn serialize(&self, handle: usize) -> Result<Vec<u8>, Fault> {
        let Some(state) = self.saved.get(&handle) else {
            return unknown(handle);
        };
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(self.identity.version);
        bytes.extend(self.identity.model);
        bytes.extend([0; HEADER - LENGTH_AT]);
        let mut bytes = postcard::to_extend(state, bytes)
            .map_err(|e| Fault::Refused(format!("the state cannot be serialized: {e}")))?;
        let length = (bytes.len() - HEADER) as u64;
        bytes[LENGTH_AT..CRC_AT].copy_from_slice(&length.to_le_bytes());
        let crc = checksum(&bytes);
        bytes[CRC_AT..HEADER].copy_from_slice(&crc.to_le_bytes());
        Ok(bytes)
    }

    /// Reads a saved state from bytes; bytes after its end are ignored.
    pub(crate) fn deserialize(&mut self, bytes: &[u8], old: usize) -> Result<usize, Fault> {
        let Some((header, rest)) = bytes.split_at_checked(HEADER) else {
            return refuse!(
                "serialized state has {} bytes; it must have at least {HEADER}",
                bytes.len()
            );
        };
        if &header[..8] != MAGIC {
            return refuse!("serialized state does not start with `fmu-exp`: it is from elsewhere");
        }
        let version = u32::from_le_bytes(header[8..12].try_into().expect("4 bytes"));
        if version != VERSION {
            return refuse!("serialized state has format version {version}; it must be {VERSION}");
        }
        if header[12..MODEL_AT] != self.identity.version {
            let name = |v: &[u8]| {
                let version = String::from_utf8_lossy(v).replace('\0', "");
                version.replace('X', " for Model Exchange")
            };
            return refuse!(
                "serialized state is of an instance of FMI {}; it must be of FMI {}",
                name(&header[12..MODEL_AT]),
                name(&self.identity.version)
            );
        }
        if header[MODEL_AT..LENGTH_AT] != self.identity.model {
            let of = |id: &[u8]| uuid::Uuid::from_slice(id).expect("16 bytes");
            return refuse!(
                "serialized state is of the model {{{}}}; it must be of {{{}}}",
                of(&header[MODEL_AT..LENGTH_AT]),
                of(&self.identity.model)
            );
        }
        let length = u64::from_le_bytes(header[LENGTH_AT..CRC_AT].try_into().expect("8 bytes"));
        let Some(body) = usize::try_from(length).ok().and_then(|n| rest.get(..n)) else {
            return refuse!(
                "serialized state is truncated: {} bytes after the header; there must be {length}",
                rest.len()
            );
        };
        let crc = u32::from_le_bytes(header[CRC_AT..].try_into().expect("4 bytes"));
        let found = checksum(&bytes[..HEADER + body.len()]);
        if crc != found {
            return refuse!(
                "serialized state is damaged: checksum {found:08x}; it must be {crc:08x}"
            );
        }
        match postcard::from_bytes::<State<M>>(body) {
            Ok(state) if state.is_sound() => self.keep(Box::new(state), old),
            _ => refuse!("serialized state does not fit this version of the model"),
        }
    }
}

fn unknown<T>(handle: usize) -> Result<T, Fault> {
    refuse!(
        "state {handle} is not a saved state of this instance (never made by it, or freed); it must be one that saving or \
             deserializing has returned"
    )
}

/// CRC-32 of a serialized state except its own four bytes.
fn checksum(bytes: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&bytes[..CRC_AT]);
    hasher.update(&bytes[HEADER..]);
    hasher.finalize()
}
