//! An importer of models with clocks, as the standard describes it, for `main`.

use super::model::MOST;
use fmu_export::ffi::{CallbackFunctions, EventInfo, Str};
use fmu_export::{Model, model_description, model_description3};
use std::ffi::{CString, c_int, c_void};
use std::marker::PhantomData;
use std::ptr;

pub type C = *mut c_void;

macro_rules! functions {
    ($($name:ident($($type:ty),*) -> $result:ty;)*) => {
        unsafe extern "C-unwind" { $(pub fn $name($(_: $type),*) -> $result;)* }
    };
}

#[rustfmt::skip]
functions! {
    fmi2Instantiate(Str, c_int, Str, Str, *const CallbackFunctions, c_int, c_int) -> C; fmi2FreeInstance(C) -> ();
    fmi2EnterInitializationMode(C) -> c_int; fmi2ExitInitializationMode(C) -> c_int; fmi2DoStep(C, f64, f64, c_int) -> c_int;
    fmi2SetReal(C, *const u32, usize, *const f64) -> c_int; fmi2GetReal(C, *const u32, usize, *mut f64) -> c_int;
    fmi2EnterEventMode(C) -> c_int; fmi2NewDiscreteStates(C, *mut EventInfo) -> c_int; fmi2EnterContinuousTimeMode(C) -> c_int;
    fmi2SetTime(C, f64) -> c_int; fmi2SetContinuousStates(C, *const f64, usize) -> c_int;
    fmi2GetEventIndicators(C, *mut f64, usize) -> c_int; fmi2GetContinuousStates(C, *mut f64, usize) -> c_int;
    fmi3InstantiateModelExchange(Str, Str, Str, bool, bool, C, C) -> C; fmi3FreeInstance(C) -> ();
    fmi3InstantiateCoSimulation(Str, Str, Str, bool, bool, bool, bool, *const u32, usize, C, C, C) -> C;
    fmi3EnterInitializationMode(C, bool, f64, f64, bool, f64) -> c_int; fmi3ExitInitializationMode(C) -> c_int;
    fmi3DoStep(C, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int; fmi3EnterStepMode(C) -> c_int;
    fmi3SetFloat64(C, *const u32, usize, *const f64, usize) -> c_int; fmi3GetFloat64(C, *const u32, usize, *mut f64, usize) -> c_int;
    fmi3EnterEventMode(C) -> c_int; fmi3UpdateDiscreteStates(C, *mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;
    fmi3EnterContinuousTimeMode(C) -> c_int; fmi3SetTime(C, f64) -> c_int; fmi3SetContinuousStates(C, *const f64, usize) -> c_int;
    fmi3GetEventIndicators(C, *mut f64, usize) -> c_int; fmi3GetContinuousStates(C, *mut f64, usize) -> c_int;
    fmi3SetClock(C, *const u32, usize, *const bool) -> c_int;
    fmi3GetIntervalDecimal(C, *const u32, usize, *mut f64, *mut c_int) -> c_int; fmi3GetShiftDecimal(C, *const u32, usize, *mut f64) -> c_int;
}

/// How an instance is driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    Exchange2,
    Exchange3,
    Steps2,
    /// Without Event Mode: the FMU ticks the clocks itself.
    Steps3,
    Events3,
}

impl Way {
    pub const ALL: [Self; 5] = [
        Way::Exchange2,
        Way::Exchange3,
        Way::Steps2,
        Way::Steps3,
        Way::Events3,
    ];
}

/// The value of an attribute behind a mark.
fn attribute(xml: &str, mark: &str, name: &str) -> Option<String> {
    let (_, rest) = xml.split_once(mark)?;
    let element = rest.split_once('>')?.0;
    let (_, rest) = element.split_once(&format!(" {name}=\""))?;
    Some(rest.split_once('"')?.0.to_owned())
}

pub fn reference(xml: &str, name: &str) -> u32 {
    let vr = attribute(xml, &format!(" name=\"{name}\""), "valueReference");
    vr.unwrap_or_else(|| panic!("{name}")).parse().unwrap()
}

struct Timed {
    vr: u32,
    kind: String,
    interval: f64,
    next: f64,
}

pub struct Fmu<M> {
    pub c: C,
    way: Way,
    xml: String,
    clocks: Vec<Timed>,
    u: f64,
    /// `sum` and `sum_before` when they were last read.
    pub sums: [f64; 2],
    model: PhantomData<M>,
}

impl<M: Model> Fmu<M> {
    pub fn new(way: Way) -> Self {
        let is_2 = matches!(way, Way::Exchange2 | Way::Steps2);
        let (name, none) = (c"ticking".as_ptr(), ptr::null_mut());
        let xml = match is_2 {
            true => model_description::<M>().unwrap(),
            false => model_description3::<M>().unwrap(),
        };
        let token = if is_2 { "guid" } else { "instantiationToken" };
        let token = attribute(&xml, "<fmiModelDescription", token).unwrap();
        let token = CString::new(token).unwrap();
        let token = token.as_ptr();
        let functions = CallbackFunctions {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: none,
        };
        let c = unsafe {
            match way {
                Way::Exchange2 => fmi2Instantiate(name, 0, token, ptr::null(), &functions, 0, 0),
                Way::Steps2 => fmi2Instantiate(name, 1, token, ptr::null(), &functions, 0, 0),
                Way::Exchange3 => {
                    fmi3InstantiateModelExchange(name, token, ptr::null(), false, false, none, none)
                }
                Way::Steps3 | Way::Events3 => fmi3InstantiateCoSimulation(
                    name,
                    token,
                    ptr::null(),
                    false,
                    false,
                    way == Way::Events3,
                    true,
                    ptr::null(),
                    0,
                    none,
                    none,
                    none,
                ),
            }
        };
        assert!(!c.is_null());
        let clocks = xml.split("<Clock ").skip(1).map(|clock| {
            let text = |name| attribute(&format!(" {clock}"), "", name);
            let number = |name| text(name).map(|text| text.parse().unwrap());
            Timed {
                vr: text("valueReference").unwrap().parse().unwrap(),
                kind: text("intervalVariability").unwrap(),
                interval: number("intervalDecimal").unwrap_or(f64::NAN),
                next: number("shiftDecimal").unwrap_or(0.0),
            }
        });
        let clocks = clocks.collect();
        Self {
            c,
            way,
            xml,
            clocks,
            u: 0.0,
            sums: [0.0; 2],
            model: PhantomData,
        }
    }

    fn is_2(&self) -> bool {
        matches!(self.way, Way::Exchange2 | Way::Steps2)
    }

    fn ticks_clocks(&self) -> bool {
        matches!(self.way, Way::Exchange3 | Way::Events3)
    }

    fn vr(&self, name: &str) -> u32 {
        match self.is_2() && self.xml.contains(&format!("\"{name}[1]\"")) {
            true => reference(&self.xml, &format!("{name}[1]")),
            false => reference(&self.xml, name),
        }
    }

    pub fn get<const N: usize>(&self, name: &str) -> Result<[f64; N], c_int> {
        let mut values = [f64::NAN; N];
        let first = self.vr(name);
        let numbers = Vec::from_iter((first..).take(N));
        let status = unsafe {
            match self.is_2() {
                true => fmi2GetReal(self.c, numbers.as_ptr(), N, values.as_mut_ptr()),
                false => fmi3GetFloat64(self.c, &first, 1, values.as_mut_ptr(), N),
            }
        };
        if status == 0 { Ok(values) } else { Err(status) }
    }

    pub fn set(&self, name: &str, value: f64) -> c_int {
        let vr = self.vr(name);
        unsafe {
            match self.is_2() {
                true => fmi2SetReal(self.c, &vr, 1, &value),
                false => fmi3SetFloat64(self.c, &vr, 1, &value, 1),
            }
        }
    }

    /// Asks for an interval; takes it over where it has changed.
    fn ask(&mut self, k: usize, now: f64) {
        let clock = &mut self.clocks[k];
        let (mut interval, mut qualifier) = (f64::NAN, -1);
        let status =
            unsafe { fmi3GetIntervalDecimal(self.c, &clock.vr, 1, &mut interval, &mut qualifier) };
        assert_eq!(status, 0);
        if qualifier == 2 {
            clock.interval = interval;
            if matches!(&*clock.kind, "changing" | "countdown") {
                clock.next = now + interval;
            }
        }
    }

    fn initialize(&mut self) {
        unsafe {
            match self.is_2() {
                true => assert_eq!(fmi2EnterInitializationMode(self.c), 0),
                false => assert_eq!(
                    fmi3EnterInitializationMode(self.c, false, 0.0, 0.0, false, 0.0),
                    0
                ),
            }
        }
        if self.ticks_clocks() {
            for k in 0..self.clocks.len() {
                let clock = &mut self.clocks[k];
                if clock.kind == "countdown" {
                    clock.next = f64::INFINITY;
                }
                if !clock.interval.is_nan() {
                    continue;
                }
                if matches!(&*clock.kind, "fixed" | "tunable") {
                    let status =
                        unsafe { fmi3GetShiftDecimal(self.c, &clock.vr, 1, &mut clock.next) };
                    assert_eq!(status, 0);
                }
                self.ask(k, 0.0);
            }
        } else {
            self.next_input();
        }
        let exit = if self.is_2() {
            fmi2ExitInitializationMode
        } else {
            fmi3ExitInitializationMode
        };
        assert_eq!(unsafe { exit(self.c) }, 0);
    }

    fn next_input(&mut self) {
        self.u += 1.0;
        assert_eq!(self.set("u", self.u), 0);
    }

    /// Event Mode: ticks the clocks that are due, and updates until nothing changes. Returns the time
    /// of the next time event.
    fn events(&mut self, now: f64) -> f64 {
        let mut next = f64::INFINITY;
        for pass in 0.. {
            assert!(pass < 10);
            let (mut again, mut ticked) = (false, Vec::new());
            if self.ticks_clocks() {
                for k in 0..self.clocks.len() {
                    let clock = &mut self.clocks[k];
                    if clock.next > now + 1e-9 {
                        continue;
                    }
                    assert_eq!(unsafe { fmi3SetClock(self.c, &clock.vr, 1, &true) }, 0);
                    clock.next = match &*clock.kind {
                        "changing" | "countdown" => f64::INFINITY,
                        _ => clock.next + clock.interval,
                    };
                    ticked.push(k);
                }
                if ticked.contains(&0) {
                    // What is computed follows the input until the update.
                    let before = self.get::<1>("sum").unwrap()[0];
                    assert_eq!(self.set("u", 1000.0), 0);
                    assert_eq!(self.get::<1>("sum").unwrap()[0], before + 1000.0 - self.u);
                    self.next_input();
                    self.sums = ["sum", "sum_before"].map(|name| self.get::<1>(name).unwrap()[0]);
                }
            }
            unsafe {
                if self.is_2() {
                    let mut info = EventInfo::default();
                    assert_eq!(fmi2NewDiscreteStates(self.c, &mut info), 0);
                    again |= info.new_discrete_states_needed != 0;
                    if info.next_event_time_defined != 0 {
                        next = info.next_event_time;
                    }
                } else {
                    let (mut flags, mut time) = ([false; 5], f64::NAN);
                    let [a, b, c, d, e] = flags.each_mut();
                    assert_eq!(
                        fmi3UpdateDiscreteStates(self.c, a, b, c, d, e, &mut time),
                        0
                    );
                    again |= flags[0];
                }
            }
            if self.ticks_clocks() {
                assert!(self.get::<1>("sum").is_err(), "its clock is not active");
                assert_ne!(self.set("u", 1.0), 0, "its clock is not active");
                for k in 0..self.clocks.len() {
                    let kind = &*self.clocks[k].kind;
                    if kind == "countdown" || kind == "changing" && ticked.contains(&k) {
                        self.ask(k, now);
                        again |= self.clocks[k].next <= now;
                    }
                }
            }
            if !again {
                break;
            }
        }
        self.clocks
            .iter()
            .map(|clock| clock.next)
            .filter(|_| !self.is_2())
            .fold(next, f64::min)
    }

    fn read(
        &self,
        two: unsafe extern "C-unwind" fn(C, *mut f64, usize) -> c_int,
        three: unsafe extern "C-unwind" fn(C, *mut f64, usize) -> c_int,
    ) -> f64 {
        let mut value = f64::NAN;
        let f = if self.is_2() { two } else { three };
        assert_eq!(unsafe { f(self.c, &mut value, 1) }, 0);
        value
    }

    /// Model Exchange to the next event, or to `end`; x' = 1.
    fn integrate(&self, t: f64, until: f64) -> f64 {
        let enter = if self.is_2() {
            fmi2EnterContinuousTimeMode
        } else {
            fmi3EnterContinuousTimeMode
        };
        assert_eq!(unsafe { enter(self.c) }, 0);
        let x = self.read(fmi2GetContinuousStates, fmi3GetContinuousStates);
        let before = self.read(fmi2GetEventIndicators, fmi3GetEventIndicators);
        let go = |to: f64| unsafe {
            let x = x + (to - t);
            match self.is_2() {
                true => assert_eq!(
                    (
                        fmi2SetTime(self.c, to),
                        fmi2SetContinuousStates(self.c, &x, 1)
                    ),
                    (0, 0)
                ),
                false => assert_eq!(
                    (
                        fmi3SetTime(self.c, to),
                        fmi3SetContinuousStates(self.c, &x, 1)
                    ),
                    (0, 0)
                ),
            }
            self.read(fmi2GetEventIndicators, fmi3GetEventIndicators)
        };
        let mut to = until;
        if before > 0.0 && go(until) <= 0.0 {
            to = t + before;
            while go(to) > 0.0 {
                to += f64::EPSILON;
            }
        } else {
            go(until);
        }
        let enter = if self.is_2() {
            fmi2EnterEventMode
        } else {
            fmi3EnterEventMode
        };
        assert_eq!(unsafe { enter(self.c) }, 0);
        to
    }

    /// A run to `stop`, with communication points every 50 ms and at ticks.
    pub fn run(&mut self, stop: f64) {
        self.run_to(stop, |_, _| ());
    }

    /// The same, with something done at each communication point.
    pub fn run_to(&mut self, stop: f64, at: impl Fn(&Self, f64)) {
        self.initialize();
        let (mut t, mut point) = (0.0, 0);
        let steps = matches!(self.way, Way::Steps2 | Way::Steps3);
        let mut next = if steps {
            f64::INFINITY
        } else {
            self.events(0.0)
        };
        while t < stop - 1e-9 {
            at(self, t);
            if steps && t > 0.0 && point % 2 == 0 && t == 0.05 * f64::from(point) {
                self.next_input();
            }
            let grid = 0.05 * f64::from(point + 1);
            let until = if next < grid - 1e-9 { next } else { grid };
            match self.way {
                Way::Exchange2 | Way::Exchange3 => {
                    t = self.integrate(t, until);
                    if self.way == Way::Exchange2 && (t - grid).abs() < 1e-9 && (point + 1) % 2 == 0
                    {
                        self.next_input();
                    }
                    next = self.events(t);
                }
                _ => {
                    if self.way == Way::Events3 {
                        assert_eq!(unsafe { fmi3EnterStepMode(self.c) }, 0);
                    }
                    let (mut flags, mut last) = ([false; 3], until);
                    let [event, terminate, early] = flags.each_mut();
                    let h = until - t;
                    let status = unsafe {
                        match self.is_2() {
                            true => fmi2DoStep(self.c, t, h, 1),
                            false => {
                                fmi3DoStep(self.c, t, h, true, event, terminate, early, &mut last)
                            }
                        }
                    };
                    assert_eq!(status, 0);
                    t = if flags[2] { last } else { until };
                    if self.way == Way::Events3 {
                        assert_eq!(unsafe { fmi3EnterEventMode(self.c) }, 0);
                        next = self.events(t);
                    }
                }
            }
            if (t - grid).abs() < 1e-9 {
                (t, point) = (if t == grid || !steps { t } else { grid }, point + 1);
            }
        }
        if steps {
            // What is due at the stop time belongs to a further step.
            self.next_input();
            let (mut flags, mut last) = ([false; 3], 0.0);
            let [a, b, c] = flags.each_mut();
            let status = unsafe {
                match self.is_2() {
                    true => fmi2DoStep(self.c, t, 1e-6, 1),
                    false => fmi3DoStep(self.c, t, 1e-6, true, a, b, c, &mut last),
                }
            };
            assert_eq!(status, 0);
        }
        if !self.ticks_clocks() {
            self.sums = ["sum", "sum_before"].map(|name| self.get::<1>(name).unwrap()[0]);
        }
    }

    /// The ticks so far: times, kinds and intervals.
    pub fn ticks(&self) -> Vec<[f64; 3]> {
        let [times, kinds, intervals] =
            ["times", "kinds", "intervals"].map(|name| self.get::<MOST>(name).unwrap());
        let all = (0..MOST).map(|k| [times[k], kinds[k], intervals[k]]);
        all.take_while(|tick| tick[1] > 0.0).collect()
    }
}

impl<M> Drop for Fmu<M> {
    fn drop(&mut self) {
        unsafe {
            match self.way {
                Way::Exchange2 | Way::Steps2 => fmi2FreeInstance(self.c),
                _ => fmi3FreeInstance(self.c),
            }
        }
    }
}
