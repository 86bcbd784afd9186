//! Scheduled Execution of the example `clocks`: partitions, callbacks, threads, refusals.
#![allow(missing_docs, clippy::undocumented_unsafe_blocks)]

#[path = "../../examples/clocks.rs"]
mod clocks;
mod random;
#[path = "../border/xorshift.rs"]
mod xorshift;

use clocks::Clocks;
use fmu_export::{check, model_description, model_description3};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;
use std::sync::atomic::{AtomicI32, AtomicPtr, Ordering};
use std::sync::{Mutex, MutexGuard};

type C = *mut c_void;
type Callback = Option<unsafe extern "C-unwind" fn(C)>;
type Preemption = Option<unsafe extern "C-unwind" fn()>;
type Logger = Option<unsafe extern "C-unwind" fn(C, c_int, *const c_char, *const c_char)>;

#[rustfmt::skip]
unsafe extern "C-unwind" {
    fn fmi3InstantiateScheduledExecution(name: *const c_char, token: *const c_char, resources: *const c_char, visible: bool, logging: bool, environment: C, log: Logger, update: Callback, lock: Preemption, unlock: Preemption) -> C;
    fn fmi3InstantiateCoSimulation(name: *const c_char, token: *const c_char, resources: *const c_char, visible: bool, logging: bool, event_mode: bool, early: bool, required: *const u32, n: usize, environment: C, log: Logger, update: C) -> C;
    fn fmi3FreeInstance(c: C);
    fn fmi3EnterInitializationMode(c: C, defined: bool, tolerance: f64, start: f64, stops: bool, stop: f64) -> c_int;
    fn fmi3ExitInitializationMode(c: C) -> c_int;
    fn fmi3EnterStepMode(c: C) -> c_int;
    fn fmi3ActivateModelPartition(c: C, clock: u32, t: f64) -> c_int;
    fn fmi3GetInt32(c: C, vr: *const u32, n: usize, values: *mut i32, n_values: usize) -> c_int;
    fn fmi3SetInt32(c: C, vr: *const u32, n: usize, values: *const i32, n_values: usize) -> c_int;
    fn fmi3GetClock(c: C, vr: *const u32, n: usize, values: *mut bool) -> c_int;
    fn fmi3SetClock(c: C, vr: *const u32, n: usize, values: *const bool) -> c_int;
    fn fmi3GetIntervalDecimal(c: C, vr: *const u32, n: usize, intervals: *mut f64, qualifiers: *mut c_int) -> c_int;
    fn fmi3DoStep(c: C, t: f64, h: f64, no_set: bool, event: *mut bool, terminate: *mut bool, early: *mut bool, last: *mut f64) -> c_int;
    fn fmi3Reset(c: C) -> c_int;
    fn fmi3Terminate(c: C) -> c_int;
}

const IN: [u32; 3] = [1001, 1002, 1003];
const OUT: u32 = 1005;

static INSTANCE: AtomicPtr<c_void> = AtomicPtr::new(ptr::null_mut());
static LOCKS: AtomicI32 = AtomicI32::new(0);
static UPDATES: Mutex<Vec<(bool, c_int)>> = Mutex::new(Vec::new());
static MESSAGES: Mutex<Vec<String>> = Mutex::new(Vec::new());
/// One test at a time, because the callbacks have no argument.
static TEST: Mutex<()> = Mutex::new(());

unsafe extern "C-unwind" fn lock() {
    assert_eq!(LOCKS.fetch_add(1, Ordering::SeqCst), 0, "nested");
}

unsafe extern "C-unwind" fn unlock() {
    assert_eq!(LOCKS.fetch_sub(1, Ordering::SeqCst), 1);
}

/// What an importer does in Clock Update Mode.
unsafe extern "C-unwind" fn update(environment: C) {
    assert_eq!(environment, 7 as C);
    assert_eq!(LOCKS.load(Ordering::SeqCst), 0, "preemption is possible");
    let c = INSTANCE.load(Ordering::SeqCst);
    let (mut ticks, mut interval, mut qualifier) = (false, f64::NAN, -1);
    unsafe {
        assert_eq!(fmi3GetClock(c, &OUT, 1, &mut ticks), 0);
        assert_eq!(
            fmi3GetIntervalDecimal(c, &IN[2], 1, &mut interval, &mut qualifier),
            0
        );
    }
    UPDATES.lock().unwrap().push((ticks, qualifier));
}

unsafe extern "C-unwind" fn log(_: C, _: c_int, _: *const c_char, text: *const c_char) {
    let text = unsafe { CStr::from_ptr(text) };
    MESSAGES
        .lock()
        .unwrap()
        .push(text.to_string_lossy().into_owned());
}

struct Fmu(
    C,
    #[expect(dead_code, reason = "held")] MutexGuard<'static, ()>,
);

fn token() -> CString {
    let xml = model_description3::<Clocks>().unwrap();
    let (_, rest) = xml.split_once("instantiationToken=\"").unwrap();
    CString::new(rest.split_once('"').unwrap().0).unwrap()
}

impl Fmu {
    fn scheduled(lock: Preemption, unlock: Preemption, update: Callback) -> Self {
        let fmu = Self::scheduled_new(lock, unlock, update);
        fmu.initialize();
        fmu
    }

    fn scheduled_new(lock: Preemption, unlock: Preemption, update: Callback) -> Self {
        let guard = TEST.lock().unwrap_or_else(|e| e.into_inner());
        UPDATES.lock().unwrap().clear();
        MESSAGES.lock().unwrap().clear();
        let token = token();
        let c = unsafe {
            fmi3InstantiateScheduledExecution(
                c"clocks".as_ptr(),
                token.as_ptr(),
                ptr::null(),
                false,
                true,
                7 as C,
                Some(log),
                update,
                lock,
                unlock,
            )
        };
        assert!(!c.is_null());
        INSTANCE.store(c, Ordering::SeqCst);
        Self(c, guard)
    }

    fn in_event_mode() -> Self {
        let guard = TEST.lock().unwrap_or_else(|e| e.into_inner());
        let c = stepped(true);
        assert!(!c.is_null());
        Self(c, guard)
    }

    fn initialize(&self) {
        unsafe {
            assert_eq!(
                fmi3EnterInitializationMode(self.0, false, 0.0, 0.0, false, 0.0),
                0
            );
            assert_eq!(fmi3ExitInitializationMode(self.0), 0);
        }
    }

    fn activate(&self, k: usize, t: f64) -> c_int {
        unsafe { fmi3ActivateModelPartition(self.0, IN[k], t) }
    }

    fn get(&self) -> [i32; 6] {
        let (vrs, mut values) = ([2001, 2002, 2003, 2004, 2005, 2007], [0; 6]);
        assert_eq!(
            unsafe { fmi3GetInt32(self.0, vrs.as_ptr(), 6, values.as_mut_ptr(), 6) },
            0
        );
        values
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.0) }
    }
}

fn last_message() -> String {
    MESSAGES.lock().unwrap().last().cloned().unwrap_or_default()
}

/// Oracle: the table of the Reference-FMUs' Clocks: the first at 0, 1, …, 9, the second at 0, 1, 8, 9,
/// the third at 4; outClock at each fifth tick.
#[test]
fn partitions_follow_the_importer() {
    let fmu = Fmu::scheduled(Some(lock), Some(unlock), Some(update));
    let (mut ticks, mut sum) = ([0; 3], 0);
    let mut updates = Vec::new();
    let mut tell = |ticks: &[i32; 3], starts: bool| {
        let is_fifth = ticks.iter().sum::<i32>() % 5 == 0;
        if is_fifth || starts {
            updates.push((is_fifth, if starts { 2 } else { 0 }));
        }
    };
    for k in 0..10 {
        let t = f64::from(k);
        assert_eq!(fmu.activate(0, t), 0);
        ticks[0] += 1;
        tell(&ticks, k == 4);
        if [0, 1, 8, 9].contains(&k) {
            assert_eq!(unsafe { fmi3SetInt32(fmu.0, &2006, 1, &(10 * k), 1) }, 0);
            assert_eq!(fmu.activate(1, t), 0);
            (ticks[1], sum) = (ticks[1] + 1, sum + 10 * k);
            tell(&ticks, false);
        }
        if k == 4 {
            assert_eq!(fmu.activate(2, t), 0);
            ticks[2] += 1;
            tell(&ticks, false);
        }
        let all = ticks.iter().sum();
        let output = if k < 4 { 0 } else { 1000 };
        assert_eq!(fmu.get(), [ticks[0], ticks[1], ticks[2], all, sum, output]);
    }
    // At 4 the countdown is told once; afterwards its interval is not known.
    assert_eq!(*UPDATES.lock().unwrap(), updates);
    assert_eq!(unsafe { fmi3Terminate(fmu.0) }, 0);
}

#[test]
fn threads_wait_for_each_other() {
    struct Shared(C);
    unsafe impl Sync for Shared {}
    let fmu = Fmu::scheduled(None, None, None);
    let shared = &Shared(fmu.0);
    std::thread::scope(|scope| {
        for k in 0..2 {
            scope.spawn(move || {
                let shared: &Shared = shared;
                for n in 0..20_000 {
                    let t = f64::from(n);
                    assert_eq!(unsafe { fmi3ActivateModelPartition(shared.0, IN[k], t) }, 0);
                    let mut value = 0;
                    assert_eq!(
                        unsafe { fmi3GetInt32(shared.0, &[2001, 2002][k], 1, &mut value, 1) },
                        0
                    );
                    assert_eq!(value, n + 1);
                }
            });
        }
    });
    assert_eq!(fmu.get()[..4], [20_000, 20_000, 0, 40_000]);
}

#[test]
fn wrong_calls_are_refused() {
    let fmu = Fmu::scheduled(None, None, None);
    let refused = |status: c_int, words: &str| {
        assert_eq!(status, 3, "{words}");
        let text = last_message();
        assert!(text.contains(words), "{text}");
    };
    assert_eq!(fmu.activate(0, 1.0), 0);
    refused(
        fmu.activate(0, 1.0),
        "must be finite and after its last one, 1 s",
    );
    refused(fmu.activate(0, f64::NAN), "activationTime = NaN s");
    refused(fmu.activate(1, -1.0), "at least the start time = 0 s");
    let partition = |vr| unsafe { fmi3ActivateModelPartition(fmu.0, vr, 2.0) };
    refused(partition(OUT), "`outClock` is a Clock output");
    refused(partition(2001), "must be a Clock");
    assert!(last_message().ends_with("must be a Clock"), "it has some");
    refused(partition(9999), "unknown value reference 9999");
    refused(
        unsafe { fmi3SetClock(fmu.0, &IN[0], 1, &true) },
        "Clock Activation Mode",
    );
    let mut flags = [false; 3];
    let [a, b, c] = flags.each_mut();
    refused(
        unsafe { fmi3DoStep(fmu.0, 0.0, 1.0, true, a, b, c, &mut 0.0) },
        "for Scheduled Execution",
    );
    assert_eq!(fmu.get()[..4], [1, 0, 0, 1]);
    assert_eq!(unsafe { fmi3Reset(fmu.0) }, 0);
    refused(fmu.activate(0, 1.0), "not allowed in state Instantiated");
    fmu.initialize();
    assert_eq!(fmu.activate(0, 0.5), 0);
    assert_eq!(fmu.get()[..4], [1, 0, 0, 1]);
}

#[test]
fn triggered_clocks_are_of_event_mode() {
    assert_eq!(check::<Clocks>(), [""; 0]);
    let error = model_description::<Clocks>().unwrap_err();
    assert!(
        error.contains("clock `inClock2` is triggered, which is of FMI 3.0"),
        "{error}"
    );
    let xml = model_description3::<Clocks>().unwrap();
    assert!(xml.contains("<ScheduledExecution modelIdentifier=\"Clocks\""));
    for (k, name) in ["inClock1", "inClock2", "inClock3"].iter().enumerate() {
        let line = xml
            .lines()
            .find(|line| line.contains(&format!("name=\"{name}\"")))
            .unwrap();
        assert!(line.contains(&format!("priority=\"{k}\"")), "{line}");
    }
    let _guard = TEST.lock().unwrap_or_else(|e| e.into_inner());
    assert!(stepped(false).is_null());
    assert!(
        last_message()
            .contains("eventModeUsed is false; it must be true, because clock `inClock2`")
    );
    let c = stepped(true);
    unsafe {
        assert_eq!(
            fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0),
            0
        );
        assert_eq!(fmi3ExitInitializationMode(c), 0);
        // An output clock is active at once with the clock that makes it tick, and not without.
        let total = || {
            let (mut total, mut ticks) = (0, true);
            assert_eq!(fmi3GetInt32(c, &2004, 1, &mut total, 1), 0);
            assert_eq!(fmi3GetClock(c, &OUT, 1, &mut ticks), 0);
            (total, ticks)
        };
        for n in 1..=10 {
            assert_eq!(fmi3SetClock(c, &IN[1], 1, &true), 0);
            assert_eq!(total(), (n, n % 5 == 0));
            assert_eq!(fmi3SetClock(c, &IN[0], 1, &true), 0);
            assert_eq!(total().0, n + 1);
            assert_eq!(fmi3SetClock(c, &IN[0], 1, &false), 0);
            assert_eq!(total(), (n, n % 5 == 0));
            assert_eq!(update_states(c), 0);
        }
        assert_ne!(
            fmi3GetInt32(c, &2004, 1, &mut 0, 1),
            0,
            "no clock is active"
        );
        // What nobody reads is computed, too.
        for n in [12, 14] {
            assert_eq!(fmi3SetClock(c, &IN[1], 1, &true), 0);
            assert_eq!(update_states(c), 0);
            assert_eq!(fmi3SetClock(c, &IN[1], 1, &true), 0);
            assert_eq!(total(), (n, n % 5 == 0));
            assert_eq!(update_states(c), 0);
        }
        assert_eq!(fmi3EnterStepMode(c), 0);
        fmi3FreeInstance(c);
    }
}

/// An instance for Co-Simulation.
fn stepped(event_mode: bool) -> C {
    let (name, token) = (c"clocks".as_ptr(), token());
    let (none, token) = (ptr::null_mut(), token.as_ptr());
    let resources = ptr::null();
    unsafe {
        #[rustfmt::skip]
        let c = fmi3InstantiateCoSimulation(
            name, token, resources, false, true, event_mode, false, ptr::null(), 0, none, Some(log), none,
        );
        c
    }
}

unsafe fn update_states(c: C) -> c_int {
    unsafe extern "C-unwind" {
        fn fmi3UpdateDiscreteStates(
            c: C,
            a: *mut bool,
            b: *mut bool,
            d: *mut bool,
            e: *mut bool,
            f: *mut bool,
            t: *mut f64,
        ) -> c_int;
    }
    let mut flags = [false; 5];
    let [a, b, d, e, f] = flags.each_mut();
    let status = unsafe { fmi3UpdateDiscreteStates(c, a, b, d, e, f, &mut 0.0) };
    assert_eq!(flags[1..], [false; 4], "no states, and no time events");
    status
}
