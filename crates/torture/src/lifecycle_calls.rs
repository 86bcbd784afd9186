//! Random calls about the life cycle of an instance: instantiation, modes, steps, inquiries, logging.

use crate::arguments::{integer, real};
use crate::instance::text;
use crate::oracle::{Call, Expect};
use crate::session::Session;
use cargo_fmu::fmi2::functions::*;
use cargo_fmu::fmi2::order::Mode;
use std::ffi::{CStr, CString, c_int};
use std::ptr;

impl Session<'_> {
    pub fn setup_experiment(&mut self, i: usize) -> Result<Call, String> {
        let r = &mut self.random;
        let (has_tolerance, has_stop) = (r.one_in(8), r.one_in(8));
        let start = if r.one_in(4) { real(r) } else { 0.0 };
        let tolerance = if r.one_in(2) { real(r) } else { 1e-4 };
        let stop = if r.one_in(2) { real(r) } else { start + 1.0 };
        let name = "fmi2SetupExperiment";
        // The tolerance is for FMUs that control their error; no stop time and an infinite one are the same.
        let sound = start.is_finite() && (!has_stop || stop >= start);
        let expect = self.in_order(i, name, Expect::done_if(sound));
        self.trace(
            i,
            format_args!("{name}({has_tolerance}, {tolerance}, {start}, {has_stop}, {stop})"),
        );
        let instance = &mut self.instances[i];
        // SAFETY: a live instance.
        let status = unsafe {
            (self.fmu.functions.fmi2SetupExperiment)(
                instance.c,
                has_tolerance.into(),
                tolerance,
                start,
                has_stop.into(),
                stop,
            )
        };
        if status == OK {
            instance.known.time = start;
            instance.known.has_stop = has_stop;
        }
        Ok(self.plain(i, name, status, expect))
    }

    pub fn simple(&mut self, i: usize, name: &'static str) -> Result<Call, String> {
        let f = &self.fmu.functions;
        let (function, expect, next) = match name {
            "fmi2EnterInitializationMode" => (
                f.fmi2EnterInitializationMode,
                Expect::Done,
                Some(Mode::Initialization),
            ),
            "fmi2ExitInitializationMode" => (
                f.fmi2ExitInitializationMode,
                Expect::ModelDecides,
                Some(Mode::Stepping),
            ),
            "fmi2Terminate" => (f.fmi2Terminate, Expect::Done, Some(Mode::Terminated)),
            "fmi2Reset" => (f.fmi2Reset, Expect::Done, Some(Mode::Instantiated)),
            _ => (f.fmi2CancelStep, Expect::Refused, None),
        };
        let expect = self.in_order(i, name, expect);
        self.trace(i, format_args!("{name}()"));
        let instance = &mut self.instances[i];
        // SAFETY: a live instance.
        let status = unsafe { function(instance.c) };
        match next {
            Some(Mode::Instantiated) if status == OK => instance.forget(),
            Some(mode) if status == OK => instance.known.mode = mode,
            _ => {}
        }
        Ok(Call {
            expect,
            ..self.plain(i, name, status, expect)
        })
    }

    pub fn do_step(&mut self, i: usize) -> Result<Call, String> {
        let r = &mut self.random;
        let now = self.instances[i].known.time;
        let t = match r.below(16) {
            0 => real(r),
            1 => now + 1e-3,
            _ => now,
        };
        let h = match r.below(32) {
            0..26 => r.of(&[1e-3, 1e-3, 1e-3, 1e-4, 3.7e-4, 1e-7]),
            26 => r.of(&[0.01, 0.02]),
            27 => r.of(&[0.0, -0.0, -1e-3, 5e-324, 1e-30]),
            _ => r.of(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 1e8]),
        };
        let name = "fmi2DoStep";
        let end = t + h;
        let sound = t == now && h.is_finite() && h > 0.0 && end > t && end.is_finite();
        // Clocks that add steps up or count nanoseconds are met half-way; twice that is surely a jump.
        let near = (t - now).abs() <= 2.0 * (1e-3 * h).max(1e-9 * now.abs().max(1.0));
        let expect = match (sound, near, self.instances[i].known.has_stop) {
            (true, _, false) => Expect::Step,
            (false, false, _) => Expect::Refused,
            (true, ..) => Expect::StepOrRefused,
            (false, true, _) if !(h.is_finite() && h > 0.0 && end > t) => Expect::Refused,
            (false, true, _) => Expect::StepOrRefused,
        };
        let no_set_prior = r.of(&[0, 1, -7]);
        self.trace(i, format_args!("{name}({t:?}, {h:?}, {no_set_prior})"));
        let instance = &mut self.instances[i];
        // SAFETY: a live instance.
        let status = unsafe { (self.fmu.functions.fmi2DoStep)(instance.c, t, h, no_set_prior) };
        let call = self.plain(i, name, status, expect);
        if status == OK {
            self.instances[i].known.time = end;
        }
        Ok(call)
    }

    pub fn status(&mut self, i: usize) -> Result<Call, String> {
        let (f, r, c) = (&self.fmu.functions, &mut self.random, self.instances[i].c);
        let kind = r.of(&[0, 1, 2, 3, 4, -1, c_int::MAX]);
        let is_null = r.one_in(8);
        let (mut integer, mut number, mut string) = (-1, f64::NAN, ptr::null());
        let integer_place: *mut c_int = if is_null {
            ptr::null_mut()
        } else {
            &mut integer
        };
        let which = r.below(5);
        // SAFETY: a live instance; places for one result or NULL.
        let (name, status, right) = unsafe {
            match which {
                0 => (
                    "fmi2GetStatus",
                    (f.fmi2GetStatus)(c, kind, integer_place),
                    kind == 0,
                ),
                1 => {
                    let place = if is_null {
                        ptr::null_mut()
                    } else {
                        &mut number
                    };
                    (
                        "fmi2GetRealStatus",
                        (f.fmi2GetRealStatus)(c, kind, place),
                        kind == 2,
                    )
                }
                2 => (
                    "fmi2GetIntegerStatus",
                    (f.fmi2GetIntegerStatus)(c, kind, integer_place),
                    false,
                ),
                3 => (
                    "fmi2GetBooleanStatus",
                    (f.fmi2GetBooleanStatus)(c, kind, integer_place),
                    kind == 3,
                ),
                _ => {
                    let place = if is_null {
                        ptr::null_mut()
                    } else {
                        &mut string
                    };
                    (
                        "fmi2GetStringStatus",
                        (f.fmi2GetStringStatus)(c, kind, place),
                        kind == 1,
                    )
                }
            }
        };
        self.trace(i, format_args!("{name}({kind}, NULL: {is_null})"));
        let expect = match (right, which) {
            _ if is_null => Expect::Refused,
            (true, 4) | (false, _) => Expect::Discarded, // what the standard has for an inquiry without answer
            (true, _) => Expect::Done,
        };
        Ok(self.plain(i, name, status, expect))
    }

    pub fn set_debug_logging(&mut self, i: usize) -> Result<Call, String> {
        let declared = &self.fmu.description.log_categories;
        let r = &mut self.random;
        let on = r.one_in(2);
        let mut sound = true;
        let names: Vec<CString> = (0..r.below(3))
            .map(|_| match r.one_in(6) {
                false => text(&declared[r.below(declared.len())]),
                true => {
                    let name =
                        r.of::<&CStr>(&[c"", c"logall", c"logNonlinearSystems", c"\xff\xfe"]);
                    sound &= name.to_str().is_ok(); // categories that nobody has declared are ignored
                    name.to_owned()
                }
            })
            .collect();
        let mut pointers: Vec<Text> = names.iter().map(|n| n.as_ptr()).collect();
        if r.one_in(16) {
            pointers.push(ptr::null());
            sound = false;
        }
        let (n, is_null) = (pointers.len(), r.one_in(16));
        let list = if is_null {
            ptr::null()
        } else {
            pointers.as_ptr()
        };
        sound &= !is_null || n == 0;
        let name = "fmi2SetDebugLogging";
        self.trace(i, format_args!("{name}({on}, {names:?}, NULL: {is_null})"));
        let c = self.instances[i].c;
        // SAFETY: a live instance; NULL or `n` elements, each NULL or a C string.
        let status = unsafe { (self.fmu.functions.fmi2SetDebugLogging)(c, on.into(), n, list) };
        let call = self.plain(i, name, status, Expect::done_if(sound));
        if status == OK {
            let named = names.iter().map(|n| n.to_string_lossy().into_owned());
            self.instances[i].logging.set(on, named.collect());
        }
        Ok(call)
    }

    /// fmi2Instantiate, right or wrong, fmi2FreeInstance, and the two functions that need no instance.
    pub fn instantiate(&mut self, i: usize) -> Call {
        let r = &mut self.random;
        let guid = match r.below(4) {
            0 => text("{00000000-0000-0000-0000-000000000000}"),
            1 => text("no guid"),
            _ => text(&self.fmu.description.guid),
        };
        let kind = if r.one_in(4) { integer(r) } else { 1 };
        let name = r.of::<Option<&CStr>>(&[Some(c"x"), Some(c"\xff"), Some(c""), None]);
        let uri = r.of::<Option<&CStr>>(&[None, Some(c"file:///tmp"), Some(c"%%%\xff"), Some(c"")]);
        let (no_guid, no_callbacks) = (r.one_in(8), r.one_in(8));
        self.trace(
            i,
            format_args!(
                "fmi2Instantiate({name:?}, {kind}, {guid:?}, {uri:?}, {no_guid}, {no_callbacks})"
            ),
        );
        let callbacks = Callbacks {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: ptr::null_mut(),
            environment: ptr::null_mut(),
        };
        let pointer = |s: Option<&CStr>| s.map_or(ptr::null(), CStr::as_ptr);
        let f = &self.fmu.functions;
        // SAFETY: C strings or NULL, callbacks or NULL; what is made is freed once.
        let is_made = unsafe {
            let c = (f.fmi2Instantiate)(
                pointer(name),
                kind,
                if no_guid { ptr::null() } else { guid.as_ptr() },
                pointer(uri),
                if no_callbacks {
                    ptr::null()
                } else {
                    &callbacks
                },
                0,
                1,
            );
            (f.fmi2FreeInstance)(c);
            (f.fmi2FreeInstance)(ptr::null_mut());
            !c.is_null()
                && CStr::from_ptr((f.fmi2GetVersion)()) == c"2.0"
                && CStr::from_ptr((f.fmi2GetTypesPlatform)()) == c"default"
        };
        let right = guid.to_str() == Ok(&self.fmu.description.guid) && !no_guid;
        let sound = right && kind == 1 && !no_callbacks && name.is_some_and(|n| !n.is_empty());
        Call {
            name: "fmi2Instantiate",
            status: if is_made { OK } else { ERROR },
            expect: Expect::done_if(sound),
            variables: Vec::new(),
            without_instance: true,
        }
    }

    /// Functions with `c` = NULL.
    pub fn without_instance(&mut self, i: usize) -> Result<Call, String> {
        let (f, c) = (&self.fmu.functions, ptr::null_mut());
        let (vr, mut number, mut state) = ([0_u32], [0.0], ptr::null_mut());
        let which = self.random.below(8);
        self.trace(i, format_args!("a call without instance, number {which}"));
        // SAFETY: NULL instead of an instance; arrays of one element.
        let (name, status) = unsafe {
            match which {
                0 => ("fmi2DoStep", (f.fmi2DoStep)(c, 0.0, 1e-3, 1)),
                1 => (
                    "fmi2GetReal",
                    (f.fmi2GetReal)(c, vr.as_ptr(), 1, number.as_mut_ptr()),
                ),
                2 => (
                    "fmi2SetReal",
                    (f.fmi2SetReal)(c, vr.as_ptr(), 1, number.as_ptr()),
                ),
                3 => ("fmi2Reset", (f.fmi2Reset)(c)),
                4 => ("fmi2Terminate", (f.fmi2Terminate)(c)),
                5 => ("fmi2GetFMUstate", (f.fmi2GetFMUstate)(c, &mut state)),
                6 => ("fmi2CancelStep", (f.fmi2CancelStep)(c)),
                _ => (
                    "fmi2ExitInitializationMode",
                    (f.fmi2ExitInitializationMode)(c),
                ),
            }
        };
        Ok(Call {
            without_instance: true,
            ..self.plain(i, name, status, Expect::Refused)
        })
    }
}
