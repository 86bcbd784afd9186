//! The functions that `worker.js` of `page-files` calls. The worker passes texts and bytes in
//! memory that it has allocated here; an answer is valid at [`answer_address`] until the next call.
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

/// Layout of a byte array, as a `Vec` of bytes needs it.
fn layout(size: usize) -> Option<Layout> {
    Layout::array::<u8>(size.max(1)).ok()
}

/// Allocate memory; 0 if there is none.
#[unsafe(no_mangle)]
pub extern "C" fn engine_allocate(size: usize) -> *mut u8 {
    // SAFETY: the size is not 0.
    layout(size).map_or(std::ptr::null_mut(), |layout| unsafe { alloc(layout) })
}

/// Free memory.
///
/// # Safety
/// It was allocated with this size, and is freed once.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn engine_free(address: *mut u8, size: usize) {
    if let Some(layout) = layout(size) {
        // SAFETY: as the caller promises.
        unsafe { dealloc(address, layout) };
    }
}

/// Copy the bytes that the worker passes.
///
/// # Safety
/// `size` bytes, possibly none, are readable at `address`.
unsafe fn bytes(address: *const u8, size: usize) -> Vec<u8> {
    // SAFETY: as the caller promises.
    unsafe { std::slice::from_raw_parts(address, size) }.to_vec()
}

/// Store an answer, an object with a result `ok` or a message `error`; returns its size.
fn store_answer(result: Result<Value>) -> usize {
    let answer = match result {
        Ok(value) => json!({ "ok": value }),
        Err(error) => json!({ "error": format!("{error:#}") }),
    };
    ANSWER.with_borrow_mut(|text| {
        *text = answer.to_string();
        text.len()
    })
}

/// Address of the last answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer_address() -> *const u8 {
    ANSWER.with_borrow(|text| text.as_ptr())
}

/// Size of the last answer; after a panic it is an error message.
#[unsafe(no_mangle)]
pub extern "C" fn answer_size() -> usize {
    ANSWER.with_borrow(String::len)
}

fn with_engine<T>(work: impl FnOnce(&mut Engine) -> Result<T>) -> Result<T> {
    ENGINE.with_borrow_mut(|engine| {
        let engine = engine.as_mut();
        work(engine.context("no package is open")?)
    })
}

/// Open a package in place of the one before; returns the size of the answer. Takes ownership of
/// the bytes, because a copy would enlarge a memory that never shrinks.
///
/// # Safety
/// `size` bytes, at least one, from [`engine_allocate`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn engine_open(address: *mut u8, size: usize) -> usize {
    panic::set_hook(Box::new(|panicked| {
        store_answer(Err(anyhow::anyhow!(
            "the engine failed in an unforeseen way: {panicked}"
        )));
    }));
    // SAFETY: as the caller promises.
    let opened = Engine::open(unsafe { Vec::from_raw_parts(address, size, size) });
    store_answer(opened.map(|engine| {
        ENGINE.set(Some(engine));
        Value::Null
    }))
}

/// Execute a command; returns the size of the answer.
///
/// # Safety
/// `size` bytes are readable at `address`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn engine_command(address: *const u8, size: usize) -> usize {
    // SAFETY: as the caller promises.
    let text = unsafe { bytes(address, size) };
    let text = String::from_utf8_lossy(&text);
    store_answer(with_engine(|engine| command::answer(engine, &text)))
}

/// Make communication steps; returns 0, or the size of the answer if one of them failed.
#[unsafe(no_mangle)]
pub extern "C" fn engine_advance(steps: u32) -> usize {
    let made = with_engine(|engine| engine.advance(steps));
    made.map_or_else(|error| store_answer(Err(error)), |()| 0)
}

/// Address of the history: rows of time and watched values from the last call that made some.
#[unsafe(no_mangle)]
pub extern "C" fn history_address() -> *const f64 {
    ENGINE.with_borrow(|engine| {
        let engine = engine.as_ref();
        engine.map_or(std::ptr::null(), |e| e.history.as_ptr())
    })
}

/// Number of values in the history.
#[unsafe(no_mangle)]
pub extern "C" fn history_size() -> usize {
    ENGINE.with_borrow(|engine| engine.as_ref().map_or(0, |e| e.history.len()))
}

/// Receive a message of the instance with this environment, or of the host itself (0).
///
/// # Safety
/// `size` bytes are readable at `address`.
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
