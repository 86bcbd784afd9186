//! States that an instance saved, with what is known of it besides: they are freed before it.

use std::any::Any;
use std::ffi::c_int;
use std::rc::Rc;

use anyhow::{Context, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::answer::Answer;
use crate::raw::{Array, RawInstance, StateHandle};

/// A saved state, and what is known of the instance besides.
struct State<T> {
    owner: Rc<RawInstance>,
    handle: StateHandle,
    known: T,
}

impl<T> Drop for State<T> {
    fn drop(&mut self) {
        self.owner.free_state(Some(&mut self.handle));
    }
}

fn check(owner: &RawInstance, status: c_int, name: &'static str) -> Result<()> {
    match status {
        0 | 1 => Ok(()),
        _ => Answer::refuse(status, owner.functions().name(name)),
    }
}

fn state<'a, T: 'static>(owner: &Rc<RawInstance>, state: &'a dyn Any) -> Result<&'a State<T>> {
    let own = state.downcast_ref();
    let own = own.filter(|s: &&State<T>| Rc::ptr_eq(&s.owner, owner));
    own.context("a state of another instance")
}

/// The state that the instance is in, with what is `known` besides.
pub fn save<T: 'static>(owner: &Rc<RawInstance>, known: T) -> Result<Box<dyn Any>> {
    let mut handle = StateHandle::NULL;
    check(owner, owner.get_state(Some(&mut handle)), "fmi2GetFMUstate")?;
    let owner = owner.clone();
    Ok(Box::new(State {
        owner,
        handle,
        known,
    }))
}

/// Back to a state of this instance; what was known besides.
pub fn restore<'a, T: 'static>(owner: &Rc<RawInstance>, saved: &'a dyn Any) -> Result<&'a T> {
    let saved = state::<T>(owner, saved)?;
    check(owner, owner.set_state(saved.handle), "fmi2SetFMUstate")?;
    Ok(&saved.known)
}

/// The bytes of a state of this instance: what is known besides, then its own.
pub fn to_bytes<T>(owner: &Rc<RawInstance>, saved: &dyn Any) -> Result<Vec<u8>>
where
    T: Serialize + 'static,
{
    let saved = state::<T>(owner, saved)?;
    let mut bytes = postcard::to_stdvec(&saved.known)?;
    let (start, mut count) = (bytes.len(), 0);
    let status = owner.serialized_size(saved.handle, Some(&mut count));
    check(owner, status, "fmi2SerializedFMUstateSize")?;
    bytes.resize(start + count, 0);
    let status = owner.serialize(saved.handle, &mut bytes[start..]);
    check(owner, status, "fmi2SerializeFMUstate")?;
    Ok(bytes)
}

/// A state of this instance from such bytes.
pub fn from_bytes<T>(owner: &Rc<RawInstance>, bytes: &[u8]) -> Result<Box<dyn Any>>
where
    T: DeserializeOwned + 'static,
{
    let (known, own): (T, _) = postcard::take_from_bytes(bytes)?;
    let mut handle = StateHandle::NULL;
    let status = owner.deserialize(Array::Elements(own), Some(&mut handle));
    check(owner, status, "fmi2DeSerializeFMUstate")?;
    let owner = owner.clone();
    Ok(Box::new(State {
        owner,
        handle,
        known,
    }))
}
