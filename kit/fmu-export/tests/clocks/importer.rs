//! An importer of models with clocks, as the standard describes it, for `main`.

use super::model::MOST;
use super::ways::{C, Instance, Way, attribute};
use fmu_export::Model;
use std::ffi::c_int;
use std::marker::PhantomData;

unsafe extern "C-unwind" {
    fn fmi3SetClock(_: C, _: *const u32, _: usize, _: *const bool) -> c_int;
    fn fmi3GetIntervalDecimal(_: C, _: *const u32, _: usize, _: *mut f64, _: *mut c_int) -> c_int;
    fn fmi3GetShiftDecimal(_: C, _: *const u32, _: usize, _: *mut f64) -> c_int;
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
    at: Instance,
    xml: String,
    clocks: Vec<Timed>,
    u: f64,
    /// `sum` and `sum_before` when they were last read.
    pub sums: [f64; 2],
    model: PhantomData<M>,
}

impl<M: Model> Fmu<M> {
    pub fn new(way: Way) -> Self {
        let xml = way.description::<M>();
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
            at: Instance::new::<M>(way, true),
            xml,
            clocks,
            u: 0.0,
            sums: [0.0; 2],
            model: PhantomData,
        }
    }

    fn ticks_clocks(&self) -> bool {
        matches!(self.at.way, Way::Exchange3 | Way::Events3)
    }

    fn vr(&self, name: &str) -> u32 {
        match self.at.is_2() && self.xml.contains(&format!("\"{name}[1]\"")) {
            true => reference(&self.xml, &format!("{name}[1]")),
            false => reference(&self.xml, name),
        }
    }

    pub fn get<const N: usize>(&self, name: &str) -> Result<[f64; N], c_int> {
        self.at.get(self.vr(name))
    }

    pub fn set(&self, name: &str, value: f64) -> c_int {
        self.at.set(self.vr(name), value)
    }

    /// Asks for an interval; takes it over where it has changed.
    fn ask(&mut self, k: usize, now: f64) {
        let clock = &mut self.clocks[k];
        let (mut interval, mut qualifier) = (f64::NAN, -1);
        let status = unsafe {
            fmi3GetIntervalDecimal(self.at.c, &clock.vr, 1, &mut interval, &mut qualifier)
        };
        assert_eq!(status, 0);
        if qualifier == 2 {
            clock.interval = interval;
            if matches!(&*clock.kind, "changing" | "countdown") {
                clock.next = now + interval;
            }
        }
    }

    fn initialize(&mut self) {
        self.at.enter_initialization();
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
                        unsafe { fmi3GetShiftDecimal(self.at.c, &clock.vr, 1, &mut clock.next) };
                    assert_eq!(status, 0);
                }
                self.ask(k, 0.0);
            }
        } else {
            self.next_input();
        }
        self.at.exit_initialization();
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
                    assert_eq!(unsafe { fmi3SetClock(self.at.c, &clock.vr, 1, &true) }, 0);
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
            let (needs_another, time) = self.at.update();
            again |= needs_another;
            if let Some(time) = time.filter(|_| self.at.is_2()) {
                next = time;
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
            .filter(|_| !self.at.is_2())
            .fold(next, f64::min)
    }

    /// Model Exchange to the next event, or to `end`; x' = 1.
    fn integrate(&self, t: f64, until: f64) -> f64 {
        self.at.enter_continuous_time();
        let (x, before) = (self.at.state(), self.at.indicator());
        let go = |to: f64| {
            self.at.set_time(to, x + (to - t));
            self.at.indicator()
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
        self.at.enter_events();
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
        let steps = matches!(self.at.way, Way::Steps2 | Way::Steps3);
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
            match self.at.way {
                Way::Exchange2 | Way::Exchange3 => {
                    t = self.integrate(t, until);
                    if self.at.way == Way::Exchange2
                        && (t - grid).abs() < 1e-9
                        && (point + 1) % 2 == 0
                    {
                        self.next_input();
                    }
                    next = self.events(t);
                }
                _ => {
                    if self.at.way == Way::Events3 {
                        self.at.enter_steps();
                    }
                    let (flags, last) = self.at.step(t, until - t);
                    t = if flags[2] { last } else { until };
                    if self.at.way == Way::Events3 {
                        self.at.enter_events();
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
            self.at.step(t, 1e-6);
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
