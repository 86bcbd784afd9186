//! What frees an instance, after all states that it saved.
#![allow(unsafe_code)]

use std::any::Any;
use std::ffi::c_int;
use std::rc::Rc;

use anyhow::{Context, Result};
use fmi_import::standard::Pointer;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::answer::Answer;

/// A C function and its name.
type Named<F> = (F, &'static str);

/// The functions of either version that free instances, and that save and free their states.
pub struct StateFunctions {
    pub free: unsafe extern "C" fn(Pointer),
    pub free_state: unsafe extern "C" fn(Pointer, *mut Pointer) -> c_int,
    pub get: Named<unsafe extern "C" fn(Pointer, *mut Pointer) -> c_int>,
    pub set: Named<unsafe extern "C" fn(Pointer, Pointer) -> c_int>,
    pub size: Named<unsafe extern "C" fn(Pointer, Pointer, *mut usize) -> c_int>,
    pub write: Named<unsafe extern "C" fn(Pointer, Pointer, *mut u8, usize) -> c_int>,
    pub read: Named<unsafe extern "C" fn(Pointer, *const u8, usize, *mut Pointer) -> c_int>,
}

/// [`StateFunctions`] of a library, by the names that a version has for them.
macro_rules! state_functions {
    ($api:expr, $free:ident $free_state:ident; $($field:ident $function:ident)*) => {
        StateFunctions {
            free: $api.$free,
            free_state: $api.$free_state,
            $($field: ($api.$function, stringify!($function)),)*
        }
    };
}
pub(super) use state_functions;

/// An instance of either version; freed when it and all its saved states are dropped.
pub struct Owner {
    instance: Pointer,
    functions: StateFunctions,
    /// Its library, and what was given to it.
    _kept: Box<dyn Any>,
}

/// A saved state, and what is known of the instance besides.
struct State<T> {
    owner: Rc<Owner>,
    state: Pointer,
    known: T,
}

impl Owner {
    /// Of an instance that needs what is `kept` with it, first of all its library.
    ///
    /// # Safety
    /// It is a live instance of that library, whose functions these are, and nobody else frees it.
    pub unsafe fn new(instance: Pointer, functions: StateFunctions, kept: impl Any) -> Rc<Self> {
        let _kept = Box::new(kept);
        Rc::new(Self {
            instance,
            functions,
            _kept,
        })
    }

    /// The state that the instance is in, with what is `known` besides.
    pub fn save<T: 'static>(self: &Rc<Self>, known: T) -> Result<Box<dyn Any>> {
        let (mut state, (get, name)) = (std::ptr::null_mut(), self.functions.get);
        // SAFETY: room for one state, which is new.
        Answer::check(unsafe { get(self.instance, &mut state) }, name)?;
        Ok(self.owned(state, known))
    }

    /// Back to a state of this instance; what was known besides.
    pub fn restore<'a, T: 'static>(self: &Rc<Self>, state: &'a dyn Any) -> Result<&'a T> {
        let (saved, (set, name)) = (self.state::<T>(state)?, self.functions.set);
        // SAFETY: a state of this instance.
        Answer::check(unsafe { set(self.instance, saved.state) }, name)?;
        Ok(&saved.known)
    }

    /// The bytes of a state of this instance: what is known besides, then its own.
    pub fn to_bytes<T: Serialize + 'static>(self: &Rc<Self>, state: &dyn Any) -> Result<Vec<u8>> {
        let (saved, i) = (self.state::<T>(state)?, self.instance);
        let mut bytes = postcard::to_stdvec(&saved.known)?;
        let (start, mut count) = (bytes.len(), 0);
        let StateFunctions { size, write, .. } = &self.functions;
        // SAFETY: a state of this instance, and room for a size.
        Answer::check(unsafe { size.0(i, saved.state, &mut count) }, size.1)?;
        bytes.resize(start + count, 0);
        let own = bytes[start..].as_mut_ptr();
        // SAFETY: the same, and room for as many bytes as said.
        Answer::check(unsafe { write.0(i, saved.state, own, count) }, write.1)?;
        Ok(bytes)
    }

    /// A state of this instance from such bytes.
    pub fn from_bytes<T>(self: &Rc<Self>, bytes: &[u8]) -> Result<Box<dyn Any>>
    where
        T: DeserializeOwned + 'static,
    {
        let (known, own): (T, _) = postcard::take_from_bytes(bytes)?;
        let (mut state, (read, name)) = (std::ptr::null_mut(), self.functions.read);
        let (p, n) = (own.as_ptr(), own.len());
        // SAFETY: as many bytes as said, and room for one state, which is new.
        Answer::check(unsafe { read(self.instance, p, n, &mut state) }, name)?;
        Ok(self.owned(state, known))
    }

    fn owned<T: 'static>(self: &Rc<Self>, state: Pointer, known: T) -> Box<dyn Any> {
        let owner = self.clone();
        Box::new(State {
            owner,
            state,
            known,
        })
    }

    fn state<'a, T: 'static>(self: &Rc<Self>, state: &'a dyn Any) -> Result<&'a State<T>> {
        let own = state.downcast_ref();
        let own = own.filter(|s: &&State<T>| Rc::ptr_eq(&s.owner, self));
        own.context("a state of another instance")
    }
}

impl Drop for Owner {
    fn drop(&mut self) {
        // SAFETY: freed once; the library is still loaded.
        unsafe { (self.functions.free)(self.instance) };
    }
}

impl<T> Drop for State<T> {
    fn drop(&mut self) {
        let Owner {
            instance,
            functions,
            ..
        } = &*self.owner;
        // SAFETY: a state of this instance, which is still alive, freed once.
        unsafe { (functions.free_state)(*instance, &mut self.state) };
    }
}
