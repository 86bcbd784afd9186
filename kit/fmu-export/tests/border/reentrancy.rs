//! A logger that calls back, and calls of two threads at once: answered, never undefined.

use crate::client::*;
use crate::probe::vr;
use fmu_export::ffi::*;
use std::cell::{Cell, RefCell};
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

type Logger = unsafe extern "C-unwind" fn(ComponentEnvironment, Str, Status, Str, Str);
type CallBack = Box<dyn Fn(Component) -> Status>;

thread_local! {
    /// What the logger calls, and on what.
    static BACK: RefCell<Option<(Component, CallBack)>> = const { RefCell::new(None) };
    /// What it was answered.
    static ANSWERS: RefCell<Vec<Status>> = const { RefCell::new(Vec::new()) };
    static DEPTH: Cell<u32> = const { Cell::new(0) };
}

/// Calls back once for each message, but not from within its own calls.
unsafe extern "C-unwind" fn calling_back(
    _: ComponentEnvironment,
    _: Str,
    _: Status,
    _: Str,
    _: Str,
) {
    DEPTH.set(DEPTH.get() + 1);
    if DEPTH.get() == 1 {
        BACK.with_borrow(|back| {
            if let Some((c, call)) = back {
                let answer = call(*c);
                ANSWERS.with_borrow_mut(|answers| answers.push(answer));
            }
        });
    }
    DEPTH.set(DEPTH.get() - 1);
}

/// The answers to `call` from within the messages of `provoke`.
fn answers(
    fmu: &Fmu,
    call: impl Fn(Component) -> Status + 'static,
    provoke: impl FnOnce(),
) -> Vec<Status> {
    BACK.set(Some((fmu.c, Box::new(call))));
    ANSWERS.take();
    provoke();
    BACK.set(None);
    ANSWERS.take()
}

fn with_calling_back() -> Fmu {
    let functions = |log: &Mutex<Vec<Message>>| CallbackFunctions {
        // SAFETY: a variadic call without arguments equals a plain one on the platforms we test on.
        logger: Some(unsafe { std::mem::transmute::<Logger, CallbackLogger>(calling_back) }),
        ..callbacks(log)
    };
    let fmu = Fmu::with(functions, c"file:///tmp", true);
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
    fmu.start();
    fmu
}

/// The instance has been let go of when the logger is called: what it asks for is done.
#[test]
fn a_logger_may_use_the_component() {
    let fmu = with_calling_back();
    assert_eq!(fmu.step(0.0, 0.5), Status::Ok);
    let state = fmu.save();
    let real_status = |c| {
        let mut t = f64::NAN;
        // SAFETY: a live instance, a place.
        let status = unsafe { fmi2GetRealStatus(c, LAST_SUCCESSFUL_TIME, &mut t) };
        assert_eq!(t, 0.5);
        status
    };
    let wrong_step = || assert_eq!(fmu.step(7.0, 0.5), Status::Error);
    assert_eq!(answers(&fmu, real_status, wrong_step), [Status::Ok]);
    let restored = || assert_eq!(fmu.restore(state), Status::Ok);
    assert_eq!(answers(&fmu, real_status, restored), [Status::Ok]);
    // SAFETY: a live instance.
    let restore = move |c| unsafe { fmi2SetFMUstate(c, state) };
    assert_eq!(answers(&fmu, restore, wrong_step), [Status::Ok]);
    // SAFETY: a live instance.
    let reset = |c| unsafe { fmi2Reset(c) };
    assert_eq!(answers(&fmu, reset, wrong_step), [Status::Ok]);
    assert_eq!(fmu.try_get(vr::Y), Status::Error); // it was reset
}

/// The instance and its log are gone when the logger returns; nothing touches them. (Seen by
/// valgrind and AddressSanitizer.)
#[test]
fn a_logger_may_free_the_instance() {
    let mut fmu = with_calling_back();
    assert_eq!(fmu.set_integer(vr::FAULT, 3), Status::Ok); // a warning and, below, an error: two messages
    let free = |c| {
        // SAFETY: a live instance, not used afterwards.
        unsafe { fmi2FreeInstance(c) };
        Status::Ok
    };
    let step = || assert_eq!(fmu.step(0.0, 0.5), Status::Ok);
    assert_eq!(answers(&fmu, free, step), [Status::Ok]);
    fmu.c = ptr::null_mut(); // it is gone
}

/// While a call works on an instance, others get an error, whatever they are, and cannot free it.
#[test]
fn calls_from_within_the_model_are_refused() {
    let fmu = Fmu::stepping();
    assert_eq!(fmu.set_integer(vr::FAULT, 7), Status::Ok);
    let c = fmu.c.addr();
    let (entered, done) = (
        Arc::new(AtomicBool::new(false)),
        Arc::new(AtomicBool::new(false)),
    );
    crate::probe::wait_in_step(Arc::clone(&entered), Arc::clone(&done));
    let other = std::thread::spawn(move || {
        while !entered.load(Ordering::Acquire) {
            std::thread::yield_now();
        }
        let c = ptr::with_exposed_provenance_mut(c);
        // SAFETY: an instance that is in use, which it answers.
        let answers = unsafe {
            fmi2FreeInstance(c);
            [
                fmi2DoStep(c, 0.0, 0.5, 1),
                fmi2Reset(c),
                fmi2GetRealStatus(c, LAST_SUCCESSFUL_TIME, &mut 0.0),
                fmi2SetReal(c, vr::U.as_ptr(), 2, [1.0, 2.0].as_ptr()),
            ]
        };
        done.store(true, Ordering::Release);
        answers
    });
    fmu.c.expose_provenance();
    assert_eq!(fmu.step(0.0, 0.5), Status::Ok);
    assert_eq!(other.join().unwrap(), [Status::Error; 4]);
    assert_eq!(fmu.get(vr::U), [0.0; 2]);
    assert_eq!(fmu.last_time(), 0.5);
}

/// An exception of a C++ importer passes through; the instance can be used afterwards.
#[test]
fn a_logger_may_unwind() {
    unsafe extern "C-unwind" fn throwing(
        _: ComponentEnvironment,
        _: Str,
        _: Status,
        _: Str,
        _: Str,
    ) {
        std::panic::resume_unwind(Box::new("thrown by the importer"));
    }
    let functions = |log: &Mutex<Vec<Message>>| CallbackFunctions {
        // SAFETY: as above.
        logger: Some(unsafe { std::mem::transmute::<Logger, CallbackLogger>(throwing) }),
        ..callbacks(log)
    };
    let fmu = Fmu::with(functions, c"file:///tmp", false);
    let thrown = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| fmu.step(0.0, 0.5)));
    assert!(thrown.is_err());
    assert_eq!(fmu.call(fmi2EnterInitializationMode), Status::Ok);
}
