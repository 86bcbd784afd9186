//! What frees an instance, after all states that it saved.
#![allow(unsafe_code)]

use std::any::Any;
use std::ffi::c_int;
use std::rc::Rc;

use anyhow::{Context, Result};
use fmu_description::functions::Pointer;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// An instance of either version; freed when it and all its saved states are dropped.
pub struct Owner {
    instance: Pointer,
    free: unsafe extern "C" fn(Pointer),
    free_state: unsafe extern "C" fn(Pointer, *mut Pointer) -> c_int,
    /// Its library, and what was given to it.
    _kept: Box<dyn Any>,
}

impl Owner {
    /// Of an instance that needs what is `kept` with it, first of all its library.
    ///
    /// # Safety
    /// It is a live instance of that library, whose functions these are, and nobody else frees it.
    pub unsafe fn new(
        instance: Pointer,
        free: unsafe extern "C" fn(Pointer),
        free_state: unsafe extern "C" fn(Pointer, *mut Pointer) -> c_int,
        kept: impl Any,
    ) -> Rc<Self> {
        let _kept = Box::new(kept);
        Rc::new(Self {
            instance,
            free,
            free_state,
            _kept,
        })
    }
}

impl Drop for Owner {
    fn drop(&mut self) {
        // SAFETY: freed once; the library is still loaded.
        unsafe { (self.free)(self.instance) };
    }
}

/// A saved state, and what is known of the instance besides.
pub struct State<T> {
    owner: Rc<Owner>,
    state: Pointer,
    /// What is known besides.
    pub known: T,
}

impl<T: 'static> State<T> {
    /// The state that `save` saves, of this instance.
    pub fn saved(
        owner: &Rc<Owner>,
        known: T,
        save: impl FnOnce(&mut Pointer) -> Result<()>,
    ) -> Result<Box<dyn Any>> {
        let mut state = std::ptr::null_mut();
        save(&mut state)?;
        let owner = owner.clone();
        Ok(Box::new(Self {
            owner,
            state,
            known,
        }))
    }

    /// The bytes of a state: what is known besides, then those that `write` writes into room of the
    /// size that `size` tells.
    pub fn to_bytes(
        owner: &Rc<Owner>,
        state: &dyn Any,
        size: impl FnOnce(Pointer, &mut usize) -> Result<()>,
        write: impl FnOnce(Pointer, &mut [u8]) -> Result<()>,
    ) -> Result<Vec<u8>>
    where
        T: Serialize,
    {
        let (saved, state) = Self::of(owner, state)?;
        let mut bytes = postcard::to_stdvec(&saved.known)?;
        let (start, mut count) = (bytes.len(), 0);
        size(state, &mut count)?;
        bytes.resize(start + count, 0);
        write(state, &mut bytes[start..])?;
        Ok(bytes)
    }

    /// A state of this instance from such bytes, which `read` reads.
    pub fn from_bytes(
        owner: &Rc<Owner>,
        bytes: &[u8],
        read: impl FnOnce(&[u8], &mut Pointer) -> Result<()>,
    ) -> Result<Box<dyn Any>>
    where
        T: DeserializeOwned,
    {
        let (known, bytes) = postcard::take_from_bytes(bytes)?;
        Self::saved(owner, known, |state| read(bytes, state))
    }

    /// A state of this instance, and its handle.
    pub fn of<'a>(owner: &Rc<Owner>, state: &'a dyn Any) -> Result<(&'a Self, Pointer)> {
        let own = state.downcast_ref();
        let own = own.filter(|s: &&Self| Rc::ptr_eq(&s.owner, owner));
        let own = own.context("a state of another instance")?;
        Ok((own, own.state))
    }
}

impl<T> Drop for State<T> {
    fn drop(&mut self) {
        // SAFETY: a state of this instance, which is still alive, freed once.
        unsafe { (self.owner.free_state)(self.owner.instance, &mut self.state) };
    }
}
