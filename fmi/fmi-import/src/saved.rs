//! Saved states of an instance for `fmi2` and `fmi3`. Each holds the state that the FMU saved and
//! what this crate tracks of the instance, and keeps the instance alive until it is freed.

use std::any::Any;
use std::ffi::c_int;
use std::rc::Rc;

use anyhow::{Context, Result, ensure};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::answer::Answer;
use crate::raw::{Array, RawInstance, StateHandle};

/// The most bytes that a serialized state of an instance may have.
pub const MAX_STATE: usize = 1 << 30;

struct State<T> {
    owner: Rc<RawInstance>,
    handle: StateHandle,
    /// What this crate tracked of the instance when the state was saved.
    tracked: T,
}

impl<T> Drop for State<T> {
    fn drop(&mut self) {
        self.owner.free_state(Some(&mut self.handle));
    }
}

fn check(owner: &RawInstance, status: c_int, name: &'static str) -> Result<()> {
    Answer::check_named(status, || owner.functions().name(name))
}

fn state<'a, T: 'static>(owner: &Rc<RawInstance>, state: &'a dyn Any) -> Result<&'a State<T>> {
    let own = state.downcast_ref();
    let own = own.filter(|s: &&State<T>| Rc::ptr_eq(&s.owner, owner));
    own.context("a state of another instance")
}

/// Saves the state that the instance is in, together with what is tracked of it.
pub fn save<T: 'static>(owner: &Rc<RawInstance>, tracked: T) -> Result<Box<dyn Any>> {
    let mut handle = StateHandle::NULL;
    check(owner, owner.get_state(Some(&mut handle)), "fmi2GetFMUstate")?;
    Ok(boxed(owner, handle, tracked))
}

fn boxed<T: 'static>(owner: &Rc<RawInstance>, handle: StateHandle, tracked: T) -> Box<dyn Any> {
    let owner = owner.clone();
    Box::new(State {
        owner,
        handle,
        tracked,
    })
}

/// Restores a saved state of this instance; returns what was tracked when it was saved.
pub fn restore<'a, T: 'static>(owner: &Rc<RawInstance>, saved: &'a dyn Any) -> Result<&'a T> {
    let saved = state::<T>(owner, saved)?;
    check(owner, owner.set_state(saved.handle), "fmi2SetFMUstate")?;
    Ok(&saved.tracked)
}

/// The bytes of a saved state of this instance: what was tracked, then the FMU's own bytes.
pub fn to_bytes<T>(owner: &Rc<RawInstance>, saved: &dyn Any) -> Result<Vec<u8>>
where
    T: Serialize + 'static,
{
    let saved = state::<T>(owner, saved)?;
    let mut bytes = postcard::to_stdvec(&saved.tracked)?;
    let (start, mut count) = (bytes.len(), 0);
    let status = owner.serialized_size(saved.handle, Some(&mut count));
    let name = owner.functions().name("fmi2SerializedFMUstateSize");
    check(owner, status, name)?;
    let is_too_large = count > MAX_STATE || bytes.try_reserve_exact(count).is_err();
    ensure!(
        !is_too_large,
        "{name} says that its state has {count} bytes; at most {MAX_STATE} are kept"
    );
    bytes.resize(start + count, 0);
    let status = owner.serialize(saved.handle, &mut bytes[start..]);
    check(owner, status, "fmi2SerializeFMUstate")?;
    Ok(bytes)
}

/// A state of this instance from the bytes that [`to_bytes`] wrote.
pub fn from_bytes<T>(owner: &Rc<RawInstance>, bytes: &[u8]) -> Result<Box<dyn Any>>
where
    T: DeserializeOwned + 'static,
{
    let (tracked, own): (T, _) = postcard::take_from_bytes(bytes)?;
    let mut handle = StateHandle::NULL;
    let status = owner.deserialize(Array::Elements(own), Some(&mut handle));
    check(owner, status, "fmi2DeSerializeFMUstate")?;
    Ok(boxed(owner, handle, tracked))
}
