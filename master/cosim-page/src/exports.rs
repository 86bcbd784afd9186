//! What the worker calls. Texts and bytes lie in memory that it has allocated here; an answer lies
//! where [`answer_address`] says until the next call.
#![allow(unsafe_code)]

use std::alloc::{Layout, alloc, dealloc};
use std::cell::RefCell;
use std::ffi::c_int;
use std::panic;

use anyhow::{Context, Result};
use cosim::instance::receive;
use serde_json::{Value, json};

use crate::command;
use crate::engine::Engine;

thread_local! {
    static ENGINE: RefCell<Option<Engine>> = const { RefCell::new(None) };
    static ANSWER: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Of bytes, so that a `Vec` of them can be made of what is passed.
fn layout(size: usize) -> Option<Layout> {
    Layout::array::<u8>(size.max(1)).ok()
}

/// Memory of this size; 0 where there is none.
#[unsafe(no_mangle)]
pub extern "C" fn engine_allocate(size: usize) -> *mut u8 {
    // SAFETY: the size is not 0.
    layout(size).map_or(std::ptr::null_mut(), |layout| unsafe { alloc(layout) })
}

/// Give memory back.
///
/// # Safety
/// It was allocated with this size, and is given back once.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn engine_free(address: *mut u8, size: usize) {
    if let Some(layout) = layout(size) {
        // SAFETY: as the caller promises.
        unsafe { dealloc(address, layout) };
    }
}

/// What the worker passes, as our own.
///
/// # Safety
/// As many bytes as said, which may be 0.
unsafe fn bytes(address: *const u8, size: usize) -> Vec<u8> {
    // SAFETY: as the caller promises.
    unsafe { std::slice::from_raw_parts(address, size) }.to_vec()
}

/// Keep an answer: an object with what is `ok` or with the text of an `error`; its size.
fn answered(result: Result<Value>) -> usize {
    let answer = match result {
        Ok(value) => json!({ "ok": value }),
        Err(error) => json!({ "error": format!("{error:#}") }),
    };
    ANSWER.with_borrow_mut(|text| {
        *text = answer.to_string();
        text.len()
    })
}

/// Where the last answer is.
#[unsafe(no_mangle)]
pub extern "C" fn answer_address() -> *const u8 {
    ANSWER.with_borrow(|text| text.as_ptr())
}

/// Its size: after a panic it says what failed.
#[unsafe(no_mangle)]
pub extern "C" fn answer_size() -> usize {
    ANSWER.with_borrow(String::len)
}

fn with_engine(work: impl FnOnce(&mut Engine) -> Result<Value>) -> usize {
    answered(ENGINE.with_borrow_mut(|engine| {
        let engine = engine.as_mut();
        work(engine.context("no package is open")?)
    }))
}

/// Open a package in place of the one before; the size of the answer. The bytes are ours from now
/// on: a copy of them would stay in a memory that never shrinks.
///
/// # Safety
/// As many bytes as said, at least one, from [`engine_allocate`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn engine_open(address: *mut u8, size: usize) -> usize {
    panic::set_hook(Box::new(|panicked| {
        answered(Err(anyhow::anyhow!(
            "the engine failed in an unforeseen way: {panicked}"
        )));
    }));
    // SAFETY: as the caller promises.
    let opened = Engine::open(unsafe { Vec::from_raw_parts(address, size, size) });
    answered(opened.map(|engine| {
        ENGINE.set(Some(engine));
        Value::Null
    }))
}

/// Obey a command; the size of the answer.
///
/// # Safety
/// As many bytes as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn engine_command(address: *const u8, size: usize) -> usize {
    // SAFETY: as the caller promises.
    let text = unsafe { bytes(address, size) };
    with_engine(|engine| command::answer(engine, &String::from_utf8_lossy(&text)))
}

/// Make communication steps; 0, or the size of the answer where one of them failed.
#[unsafe(no_mangle)]
pub extern "C" fn engine_advance(steps: u32) -> usize {
    let made = ENGINE.with_borrow_mut(|engine| {
        let engine = engine.as_mut();
        engine.context("no package is open")?.advance(steps)
    });
    made.map_or_else(|error| answered(Err(error)), |()| 0)
}

/// Where the rows of time and watched values are that were made since the last call that made
/// some.
#[unsafe(no_mangle)]
pub extern "C" fn history_address() -> *const f64 {
    ENGINE.with_borrow(|engine| {
        engine
            .as_ref()
            .map_or(std::ptr::null(), |e| e.history.as_ptr())
    })
}

/// Number of values in them.
#[unsafe(no_mangle)]
pub extern "C" fn history_size() -> usize {
    ENGINE.with_borrow(|engine| engine.as_ref().map_or(0, |e| e.history.len()))
}

/// A message of the instance with this environment, or of the host itself, 0.
///
/// # Safety
/// As many bytes as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn engine_message(
    environment: usize,
    status: c_int,
    address: *const u8,
    size: usize,
) {
    // SAFETY: as the caller promises.
    let text = unsafe { bytes(address, size) };
    receive(environment, status, &String::from_utf8_lossy(&text));
}
