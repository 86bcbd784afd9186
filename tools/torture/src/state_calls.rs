//! Random calls, for `turns`, that save, restore, free and serialize states, with valid, freed and
//! foreign handles and with whole and damaged bytes.

use crate::oracle::{Call, Expect};
use crate::session::{Bytes, Session};
use crate::subject::KnownState;
use anyhow::{Result, bail};
use fmi_import::raw::{Array, StateHandle};
use fmi_import::standard::Mode;
use fmi_import::status::OK;

/// Most saved states of an instance, so that memory stays bounded.
const MOST_SAVED: usize = 8;
/// Most serialized states of a batch.
const MOST_BYTES: usize = 12;

impl Session<'_> {
    /// A handle for instance `i`: one of its own, with what it holds; or a freed, foreign or
    /// invented one.
    fn handle(&mut self, i: usize) -> (StateHandle, Option<KnownState>) {
        let r = &mut self.random;
        let own = &self.instances[i].saved;
        if !own.is_empty() && !r.one_in(4) {
            let (handle, known) = own[r.below(own.len())];
            return (handle, Some(known));
        }
        let other = &self.instances[r.below(self.instances.len())].saved;
        let handle = match other.is_empty() || r.one_in(2) {
            true => self.stale[r.below(self.stale.len())],
            false => other[r.below(other.len())].0,
        };
        // A freed handle may have been given out again.
        let known = self.instances[i].saved.iter().find(|(h, _)| *h == handle);
        (handle, known.map(|(_, known)| *known))
    }

    /// The handle in which a state is saved: mostly NULL for a new one, as long as there are few;
    /// else one of [`Session::handle`].
    fn new_or_old(&mut self, i: usize) -> (StateHandle, Option<KnownState>) {
        match self.instances[i].saved.len() < MOST_SAVED && !self.random.one_in(4) {
            true => (StateHandle::NULL, None),
            false => self.handle(i),
        }
    }

    /// Remembers that `handle` of instance `i` now holds `known`.
    fn remember(&mut self, i: usize, handle: StateHandle, known: KnownState) {
        let saved = &mut self.instances[i].saved;
        saved.retain(|(h, _)| *h != handle);
        saved.push((handle, known));
    }

    pub fn get_state(&mut self, i: usize) -> Result<Call> {
        let name = self.fmu.functions.name("fmi2GetFMUstate");
        let (old, held) = self.new_or_old(i);
        let is_null = self.random.one_in(16);
        let sound = !is_null && (old.is_null() || held.is_some());
        self.trace(i, format_args!("{name}({old:?}, NULL: {is_null})"));
        let mut state = old;
        let to = (!is_null).then_some(&mut state);
        let status = self.instances[i].get_state(to);
        if status == OK {
            let known = self.instances[i].known;
            self.remember(i, state, known);
        } else if state != old {
            bail!("{name} gave {status} and changed the handle");
        }
        Ok(self.plain(i, name, status, Expect::done_if(sound)))
    }

    pub fn set_state(&mut self, i: usize) -> Result<Call> {
        let name = self.fmu.functions.name("fmi2SetFMUstate");
        let (handle, held) = self.handle(i);
        self.trace(i, format_args!("{name}({handle:?}: {held:?})"));
        let status = self.instances[i].set_state(handle);
        if let (OK, Some(known)) = (status, held) {
            // The restored state includes what was set before it was saved: nothing is pending.
            let mode = match known.mode {
                Mode::SteppingAfterSet => Mode::Stepping,
                mode => mode,
            };
            self.instances[i].known = KnownState { mode, ..known };
        }
        Ok(self.plain(i, name, status, Expect::done_if(held.is_some())))
    }

    pub fn free_state(&mut self, i: usize) -> Result<Call> {
        let name = self.fmu.functions.name("fmi2FreeFMUstate");
        let (handle, held) = self.handle(i);
        let is_null = self.random.one_in(16);
        let sound = is_null || handle.is_null() || held.is_some();
        let text = format_args!("{name}({handle:?}: {held:?}, NULL: {is_null})");
        self.trace(i, text);
        let mut state = handle;
        let to = (!is_null).then_some(&mut state);
        let status = self.instances[i].free_state(to);
        if status == OK && !is_null {
            if !state.is_null() {
                bail!("{name} left a handle behind");
            }
            self.instances[i].saved.retain(|(h, _)| *h != handle);
            let at = 2 + self.random.below(8);
            self.stale.truncate(at);
            self.stale.push(handle);
        }
        Ok(self.plain(i, name, status, Expect::done_if(sound)))
    }

    pub fn serialize(&mut self, i: usize) -> Result<Call> {
        let (handle, held) = self.handle(i);
        let mut size = 0;
        let name = self.fmu.functions.name("fmi2SerializedFMUstateSize");
        self.trace(i, format_args!("{name}({handle:?}: {held:?})"));
        let is_null = self.random.one_in(16);
        let to = (!is_null).then_some(&mut size);
        let status = self.instances[i].serialized_size(handle, to);
        let sound = held.is_some() && !is_null;
        if status != OK || !sound {
            return Ok(self.plain(i, name, status, Expect::done_if(sound)));
        }
        let len = match self.random.below(8) {
            0 => self.random.below(size),
            1 => size + 1 + self.random.below(64),
            _ => size,
        };
        let mut bytes = vec![0xa5; len];
        let name = self.fmu.functions.name("fmi2SerializeFMUstate");
        self.trace(i, format_args!("{name}({handle:?}, {len} of {size})"));
        let status = self.instances[i].serialize(handle, &mut bytes);
        if bytes.iter().skip(size).any(|b| *b != 0xa5) {
            bail!("{name} wrote beyond the end of the state");
        }
        if status == OK {
            let at = match self.bytes.len() < MOST_BYTES {
                true => self.bytes.len(),
                false => 2 + self.random.below(MOST_BYTES - 2),
            };
            self.bytes.truncate(at);
            self.bytes.push(Bytes { bytes, known: held });
        }
        Ok(self.plain(i, name, status, Expect::done_if(len >= size)))
    }

    pub fn deserialize(&mut self, i: usize) -> Result<Call> {
        let name = self.fmu.functions.name("fmi2DeSerializeFMUstate");
        let (old, held) = self.new_or_old(i);
        let r = &mut self.random;
        let pick = r.below(self.bytes.len());
        let mut bytes = self.bytes[pick].bytes.clone();
        let mut known = self.bytes[pick].known;
        let what = damage(r, &mut bytes);
        if what != "whole" {
            known = None;
        }
        let (no_bytes, no_handle) = (r.one_in(16), r.one_in(16));
        let sound = known.is_some() && !no_bytes && !no_handle && (old.is_null() || held.is_some());
        let count = bytes.len();
        let text = format_args!("{name}({count} bytes, {what}, {no_bytes}, {old:?}, {no_handle})");
        self.trace(i, text);
        let mut state = old;
        let from = Array::or_null(&bytes, no_bytes);
        let to = (!no_handle).then_some(&mut state);
        let status = self.instances[i].deserialize(from, to);
        if let (OK, Some(known)) = (status, known) {
            self.remember(i, state, known);
        } else if state != old {
            bail!("{name} gave {status} and changed the handle");
        }
        Ok(self.plain(i, name, status, Expect::done_if(sound)))
    }
}

/// Damages the bytes of a state in half of the calls, so that a sound reader must refuse them;
/// returns how.
fn damage(r: &mut crate::random::Random, bytes: &mut Vec<u8>) -> &'static str {
    // Bytes after the end of a state are allowed, so only the state itself is damaged.
    let state = 44 + u64::from_le_bytes(bytes[32..40].try_into().expect("8 bytes")) as usize;
    match r.below(8) {
        0 => {
            let at = r.below(state);
            bytes[at] ^= 1 << r.below(8);
            "one bit flipped"
        }
        1 => {
            bytes.truncate(r.below(state));
            "cut off"
        }
        2 => {
            let (at, n) = (r.below(state), 1 + r.below(16));
            let sound = bytes.clone();
            for b in bytes.iter_mut().skip(at).take(n) {
                *b = r.byte();
            }
            if sound == *bytes {
                "whole"
            } else {
                "overwritten"
            }
        }
        3 => {
            *bytes = (0..r.below(100)).map(|_| r.byte()).collect();
            "noise"
        }
        _ => "whole",
    }
}
