//! A node with differential equations, whose events send: no importer loses a frame, and no step
//! ends early because of one.
#![allow(clippy::undocumented_unsafe_blocks)]

#[path = "../ways/mod.rs"]
#[expect(dead_code, reason = "for several tests")]
mod ways;

use allocation_counter::measure;
use fmu_export::can::{CanInput, CanOutput, Operation};
use fmu_export::{Terminal, can_clocks, check, prelude::*};
use std::ffi::{CStr, c_char, c_int};
use ways::{C, Instance, Way, attribute};

#[derive(Input)]
pub struct Input {
    /// A change of its sign is sent
    #[fmu(unit = "1")]
    u: f64,
    body: CanInput<64>,
    other: CanInput<64>,
}

/// Sends at 0.25 s, and when the sign of its input changes
#[derive(State)]
#[fmu(input = Input, info = INFO, model_exchange)]
pub struct Driven {
    /// A state
    #[fmu(unit = "1")]
    x: f64,
    body: CanOutput<64>,
    other: CanOutput<64>,
    #[fmu(skip)]
    is_late: bool,
    #[fmu(skip)]
    is_negative: bool,
}

/// A gateway: a node of the one network, and the bus of the other.
const INFO: Info = Info::new("Driven", "A node").terminals(&[
    Terminal::can("body", "the body's network"),
    Terminal::can("other", "a network that it simulates").of_bus_simulation(),
]);

impl Driven {
    fn receive(&mut self, _p: &(), u: &Input, _tick: Tick) -> Result<(), ModelError> {
        for operation in u.body.operations().flatten() {
            self.body.send(&operation)?;
        }
        Ok(())
    }
}

impl Ode for Driven {
    const CLOCKS: &'static [Clock<Self>] =
        can_clocks!("body" = body: Self::receive, "other" = other: |_, _, _, _| Ok(()));

    const INDICATORS: &'static [Variable<Self>] =
        &[Variable::indicator("never", "Never").unit("1")];

    fn indicators(&self, _p: &(), _u: &Input, _t: f64, z: &mut [f64]) {
        z[0] = 1.0;
    }

    fn derivative(&self, _p: &(), _u: &Input, _t: f64, dx: &mut Self) {
        dx.x = 1.0;
    }

    fn event(&mut self, _p: &(), u: &Input, t: f64) -> Event {
        for (was, is, id) in [
            (&mut self.is_late, t >= 0.25 - 1e-9, 0x25),
            (&mut self.is_negative, u.u < 0.0, 7),
        ] {
            if std::mem::replace(was, is) != is {
                self.body.send(&Operation::Confirm(id)).unwrap();
            }
        }
        match self.is_late {
            true => Event::NONE,
            false => Event::at(0.25),
        }
    }
}

fmu_export::export_fmu!(Driven);

#[rustfmt::skip]
unsafe extern "C-unwind" {
    fn fmi3GetClock(c: C, vr: *const u32, n: usize, values: *mut bool) -> c_int;
    fn fmi3GetBinary(c: C, vr: *const u32, n: usize, sizes: *mut usize, values: *mut *const u8, n_values: usize) -> c_int;
    fn fmi3GetFMUState(c: C, state: *mut C) -> c_int;
    fn fmi3SetFMUState(c: C, state: C) -> c_int;
    fn fmi3SerializedFMUStateSize(c: C, state: C, size: *mut usize) -> c_int;
    fn fmi3SerializeFMUState(c: C, state: C, bytes: *mut u8, size: usize) -> c_int;
    fn fmi3DeserializeFMUState(c: C, bytes: *const u8, size: usize, state: *mut C) -> c_int;
    fn fmi3Reset(c: C) -> c_int;
    fn fmi3ExportFiles(context: C, receive: extern "C" fn(C, *const c_char, *const u8, usize)) -> c_int;
}

/// The manifest among the files that are packed: an FMU that simulates one of its networks simulates a bus.
#[test]
fn one_simulated_network_is_enough_for_a_bus() {
    extern "C" fn receive(to: C, path: *const c_char, bytes: *const u8, size: usize) {
        let path = unsafe { CStr::from_ptr(path) };
        if path == c"extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml" {
            let to = unsafe { &mut *to.cast::<Vec<u8>>() };
            to.extend(unsafe { std::slice::from_raw_parts(bytes, size) });
        }
    }
    let mut manifest = Vec::<u8>::new();
    let status = unsafe { fmi3ExportFiles((&raw mut manifest).cast(), receive) };
    let text = String::from_utf8(manifest).unwrap();
    assert_eq!(status, 0);
    assert!(text.contains("isBusSimulationFMU=\"true\""), "{text}");
}

fn vr(name: &str) -> u32 {
    let xml = Way::Events3.description::<Driven>();
    let vr = attribute(&xml, &format!(" name=\"{name}\""), "valueReference");
    vr.unwrap().parse().unwrap()
}

/// What is sent, if the clock ticks.
fn sent(fmu: &Instance) -> Option<Vec<u8>> {
    let (mut on, mut size, mut data) = (false, 0, std::ptr::null());
    unsafe {
        assert_eq!(fmi3GetClock(fmu.c, &vr("body.Tx_Clock"), 1, &mut on), 0);
        let status = fmi3GetBinary(fmu.c, &vr("body.Tx_Data"), 1, &mut size, &mut data, 1);
        assert_eq!(status == 0, on);
        on.then(|| std::slice::from_raw_parts(data, size).to_vec())
    }
}

/// The bytes of a frame's confirmation.
fn confirm(id: u8) -> Vec<u8> {
    vec![0x20, 0, 0, 0, 12, 0, 0, 0, id, 0, 0, 0]
}

fn stepping(returns_early: bool) -> Instance {
    let fmu = Instance::new::<Driven>(Way::Events3, returns_early);
    start(&fmu);
    fmu.enter_steps();
    fmu
}

fn start(fmu: &Instance) {
    fmu.enter_initialization();
    fmu.exit_initialization();
    assert!(!fmu.update().0);
}

/// In Event Mode: these frames tick once, in the next instant.
fn ticks(fmu: &Instance, frames: &[u8]) {
    assert_eq!(sent(fmu), None);
    assert!(fmu.update().0, "once more");
    assert_eq!(sent(fmu), Some(frames.to_vec()));
    assert!(!fmu.update().0);
    assert_eq!(sent(fmu), None);
}

/// FMI-LS-BUS 1.0, 4.3.1: triggered clocks tick at communication points, after a step that has not
/// ended early.
#[test]
fn a_frame_waits_for_the_end_of_the_step() {
    assert_eq!(check::<Driven>(), [""; 0]);
    for returns_early in [false, true] {
        let fmu = stepping(returns_early);
        assert_eq!(fmu.step(0.0, 0.5), ([true, false, false], 0.5));
        fmu.enter_events();
        ticks(&fmu, &confirm(0x25));
        fmu.enter_steps();
        assert_eq!(fmu.step(0.5, 0.5), ([false; 3], 1.0));
    }
}

/// Oracle: an allocator that counts.
#[test]
fn a_step_whose_event_sends_does_not_allocate() {
    let fmu = stepping(false);
    assert_eq!(fmu.step(0.0, 0.125), ([false; 3], 0.125));
    let sends = || assert_eq!(fmu.step(0.125, 0.25), ([true, false, false], 0.375));
    assert_eq!(measure(sends).count_total, 0);
    fmu.enter_events();
    ticks(&fmu, &confirm(0x25));
}

/// What is set in Step Mode is an event at the start of the step.
#[test]
fn a_frame_of_an_input_is_told_at_the_end_of_the_step() {
    let fmu = stepping(false);
    assert_eq!(fmu.set(vr("u"), -2.0), 0);
    assert_eq!(fmu.step(0.0, 0.125), ([true, false, false], 0.125));
    fmu.enter_events();
    ticks(&fmu, &confirm(7));
    fmu.enter_steps();
    assert_eq!(fmu.step(0.125, 0.0625), ([false; 3], 0.1875));
}

#[test]
fn frames_tick_in_model_exchange() {
    let fmu = Instance::new::<Driven>(Way::Exchange3, false);
    start(&fmu);
    fmu.enter_continuous_time();
    fmu.set_time(0.25, 0.25);
    fmu.enter_events();
    ticks(&fmu, &confirm(0x25));
    fmu.enter_continuous_time();
}

/// Frames that wait are part of a saved state, also of one that another instance reads from bytes;
/// a reset forgets them.
#[test]
fn frames_that_wait_are_saved_and_reset() {
    let (fmu, other) = (
        stepping(false),
        Instance::new::<Driven>(Way::Events3, false),
    );
    assert!(fmu.step(0.0, 0.5).0[0]);
    let (mut state, mut size, none) = (std::ptr::null_mut(), 0, std::ptr::null_mut());
    let mut copy = none;
    unsafe {
        assert_eq!(fmi3GetFMUState(fmu.c, &mut state), 0);
        assert_eq!(fmi3SerializedFMUStateSize(fmu.c, state, &mut size), 0);
        let mut bytes = vec![0; size];
        assert_eq!(
            fmi3SerializeFMUState(fmu.c, state, bytes.as_mut_ptr(), size),
            0
        );
        assert_eq!(
            fmi3DeserializeFMUState(other.c, bytes.as_ptr(), size, &mut copy),
            0
        );
        for (fmu, state) in [(&fmu, state), (&other, copy), (&fmu, state)] {
            assert_eq!(fmi3SetFMUState(fmu.c, state), 0);
            fmu.enter_events();
            ticks(fmu, &confirm(0x25));
        }
        assert_eq!(fmi3SetFMUState(fmu.c, state), 0);
        assert_eq!(fmi3Reset(fmu.c), 0);
    }
    start(&fmu);
    assert_eq!(sent(&fmu), None);
}
