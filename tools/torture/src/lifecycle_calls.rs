//! Random calls about the life cycle of an instance: instantiation, modes, steps, inquiries,
//! logging.

use crate::arguments::{c_string, integer, place, pointer, real};
use crate::oracle::{Call, Expect};
use crate::session::Session;
use anyhow::Result;
use fmi_import::Callbacks;
use fmi_import::functions::{Experiment, OwnFunctions};
use fmi_import::order::Mode;
use fmi_import::symbols::*;
use std::ffi::{CStr, CString, c_int};
use std::ptr;

impl Session<'_> {
    pub fn setup_experiment(&mut self, i: usize) -> Result<Call> {
        let r = &mut self.random;
        let (has_tolerance, has_stop) = (r.one_in(8), r.one_in(8));
        let start = if r.one_in(4) { real(r) } else { 0.0 };
        let tolerance = if r.one_in(2) { real(r) } else { 1e-4 };
        let stop = if r.one_in(2) { real(r) } else { start + 1.0 };
        let is_3 = self.fmu.functions.fmi3().is_some();
        let name = self.fmu.functions.name("fmi2SetupExperiment");
        // The tolerance is for FMUs that control their error, which declare one; no stop time and an
        // infinite one are the same.
        let declared = self.fmu.description.default_experiment.tolerance;
        let is_used = has_tolerance && declared.is_some();
        let is_kept = !is_used || (tolerance > 0.0 && tolerance < 1.0);
        let sound = start.is_finite() && (!has_stop || stop >= start) && is_kept;
        let expect = self.in_order(i, name, Expect::done_if(sound));
        let experiment = Experiment {
            has_tolerance,
            tolerance,
            start,
            has_stop,
            stop,
        };
        self.trace(i, format_args!("{name}({experiment:?})"));
        let instance = &mut self.instances[i];
        // SAFETY: a live instance. FMI 3.0 has this in fmi3EnterInitializationMode.
        let status = unsafe { self.fmu.functions.begin(instance.c, experiment) };
        if status == OK {
            instance.known.time = start;
            instance.known.has_stop = has_stop;
        }
        let call = self.plain(i, name, status, expect);
        if status == OK && is_3 {
            self.instances[i].known.mode = Mode::Initialization;
        }
        Ok(call)
    }

    /// A function without arguments, named as in FMI 2.0.
    pub fn simple(&mut self, i: usize, name: &'static str) -> Result<Call> {
        let (f, c) = (&self.fmu.functions, self.instances[i].c);
        let after_initialization = match f.has_event_mode() {
            true => Mode::Event,
            false => Mode::Stepping,
        };
        let (expect, next) = match name {
            "fmi2EnterInitializationMode" => (Expect::Done, Some(Mode::Initialization)),
            "fmi2ExitInitializationMode" => (Expect::ModelDecides, Some(after_initialization)),
            "fmi2Terminate" => (Expect::Done, Some(Mode::Terminated)),
            "fmi2Reset" => (Expect::Done, Some(Mode::Instantiated)),
            _ => (Expect::Refused, None),
        };
        let own = f.name(name);
        let expect = self.in_order(i, own, expect);
        self.trace(i, format_args!("{own}()"));
        let experiment = Experiment::default();
        // SAFETY: a live instance.
        let status = unsafe {
            match (name, f.own()) {
                ("fmi2EnterInitializationMode", _) => f.enter_initialization_mode(c, experiment),
                ("fmi2ExitInitializationMode", _) => f.exit_initialization_mode(c),
                ("fmi2Terminate", _) => f.terminate(c),
                ("fmi2Reset", _) => f.reset(c),
                (_, OwnFunctions::Fmi2(f)) => (f.fmi2CancelStep)(c),
                (_, OwnFunctions::Fmi3(_)) => return self.event_call(i),
            }
        };
        let is_3 = f.fmi3().is_some();
        let instance = &mut self.instances[i];
        match next {
            Some(Mode::Instantiated) if status == OK => instance.forget(),
            Some(mode) if status == OK => {
                instance.known.mode = mode;
                if is_3 && mode == Mode::Initialization {
                    (instance.known.time, instance.known.has_stop) = (0.0, false);
                }
            }
            _ => {}
        }
        Ok(Call {
            expect,
            ..self.plain(i, own, status, expect)
        })
    }

    pub fn do_step(&mut self, i: usize) -> Result<Call> {
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
        let name = self.fmu.functions.name("fmi2DoStep");
        let end = t + h;
        let sound = t == now && h.is_finite() && h > 0.0 && end > t && end.is_finite();
        // Clocks that add steps up or count nanoseconds are met half-way; twice that is surely a
        // jump.
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
        let status = unsafe { self.fmu.functions.do_step(instance.c, t, h, no_set_prior) };
        let call = self.plain(i, name, status, expect);
        if status == OK {
            let known = &mut self.instances[i].known;
            (known.time, known.mode) = (end, Mode::Stepping);
        }
        Ok(call)
    }

    /// Inquiries of FMI 2.0; in FMI 3.0 about dependencies.
    pub fn status(&mut self, i: usize) -> Result<Call> {
        let OwnFunctions::Fmi2(f) = self.fmu.functions.own() else {
            return self.dependencies(i);
        };
        let (r, c) = (&mut self.random, self.instances[i].c);
        let kind = r.of(&[0, 1, 2, 3, 4, -1, c_int::MAX]);
        let is_null = r.one_in(8);
        let (mut integer, mut number, mut string) = (-1, f64::NAN, ptr::null());
        // The inquiry that each function answers.
        let inquiries = [Some(0), Some(2), None, Some(3), Some(1)];
        let which = r.below(inquiries.len());
        let right = inquiries[which] == Some(kind);
        macro_rules! ask {
            ($function:ident, $place:expr) => {
                (
                    stringify!($function),
                    (f.$function)(c, kind, place($place, is_null)),
                )
            };
        }
        // SAFETY: a live instance; places for one result or NULL.
        let (name, status) = unsafe {
            match which {
                0 => ask!(fmi2GetStatus, &mut integer),
                1 => ask!(fmi2GetRealStatus, &mut number),
                2 => ask!(fmi2GetIntegerStatus, &mut integer),
                3 => ask!(fmi2GetBooleanStatus, &mut integer),
                _ => ask!(fmi2GetStringStatus, &mut string),
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

    pub fn set_debug_logging(&mut self, i: usize) -> Result<Call> {
        let declared = &self.fmu.description.log_categories;
        let r = &mut self.random;
        let on = r.one_in(2);
        let mut sound = true;
        let names: Vec<CString> = (0..r.below(3))
            .map(|_| match r.one_in(6) {
                false => c_string(&declared[r.below(declared.len())]),
                true => {
                    let names = [c"", c"logall", c"logNonlinearSystems", c"\xff\xfe"];
                    let name = r.of::<&CStr>(&names);
                    // Categories that nobody has declared are ignored in FMI 2.0, and refused in
                    // FMI 3.0.
                    sound &= name.to_str().is_ok() && self.fmu.functions.fmi3().is_none();
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
        let list = pointer(&pointers, is_null);
        sound &= !is_null || n == 0;
        let name = self.fmu.functions.name("fmi2SetDebugLogging");
        self.trace(i, format_args!("{name}({on}, {names:?}, NULL: {is_null})"));
        let c = self.instances[i].c;
        // SAFETY: a live instance; NULL or `n` elements, each NULL or a C string.
        let status = unsafe { self.fmu.functions.set_debug_logging(c, on.into(), n, list) };
        let call = self.plain(i, name, status, Expect::done_if(sound));
        if status == OK {
            let named = names.iter().map(|n| n.to_string_lossy().into_owned());
            let adds = self.fmu.functions.fmi3().is_some();
            self.instances[i].logging.set(on, named.collect(), adds);
        }
        Ok(call)
    }

    /// fmi2Instantiate, right or wrong, fmi2FreeInstance, and the two functions that need no
    /// instance.
    pub fn instantiate(&mut self, i: usize) -> Call {
        let r = &mut self.random;
        let guid = match r.below(4) {
            0 => c_string("{00000000-0000-0000-0000-000000000000}"),
            1 => c_string("no guid"),
            _ => c_string(&self.fmu.description.guid),
        };
        let kind = if r.one_in(4) { integer(r) } else { 1 };
        let name = r.of::<Option<&CStr>>(&[Some(c"x"), Some(c"\xff"), Some(c""), None]);
        let uri = r.of::<Option<&CStr>>(&[None, Some(c"file:///tmp"), Some(c"%%%\xff"), Some(c"")]);
        let (no_guid, no_callbacks) = (r.one_in(8), r.one_in(8));
        let missing = [no_guid, no_callbacks];
        self.trace(
            i,
            format_args!("fmi2Instantiate({name:?}, {kind}, {guid:?}, {uri:?}, {missing:?})"),
        );
        let callbacks = Callbacks {
            logger: ptr::null(),
            allocate_memory: None,
            free_memory: None,
            step_finished: ptr::null(),
            environment: ptr::null_mut(),
        };
        let text = |s: Option<&CStr>| s.map_or(ptr::null(), CStr::as_ptr);
        let token = text((!no_guid).then_some(&guid));
        let callbacks = [callbacks];
        let callbacks = pointer(&callbacks, no_callbacks);
        let f = &self.fmu.functions;
        // SAFETY: C strings or NULL, callbacks or NULL; what is made is freed once.
        let is_made = unsafe {
            let c = f.instantiate(text(name), kind, token, text(uri), callbacks, 0, 1);
            f.free_instance(c);
            f.free_instance(ptr::null_mut());
            !c.is_null()
                && match f.own() {
                    OwnFunctions::Fmi2(f) => {
                        CStr::from_ptr((f.fmi2GetVersion)()) == c"2.0"
                            && CStr::from_ptr((f.fmi2GetTypesPlatform)()) == c"default"
                    }
                    OwnFunctions::Fmi3(f) => CStr::from_ptr((f.fmi3GetVersion)()) == c"3.0",
                }
        };
        let right = guid.to_str() == Ok(&self.fmu.description.guid) && !no_guid;
        // Of FMI 3.0 any other number calls the function for Model Exchange.
        let is_exchange = kind == 0 || f.fmi3().is_some();
        let is_offered = kind == 1 || is_exchange && self.fmu.description.model_exchange;
        // FMI 3.0 has a logger instead, which may be NULL.
        let sound = right
            && is_offered
            && (!no_callbacks || f.fmi3().is_some())
            && name.is_some_and(|n| !n.is_empty());
        Call {
            name: f.name("fmi2Instantiate"),
            status: if is_made { OK } else { ERROR },
            expect: Expect::done_if(sound),
            variables: Vec::new(),
            without_instance: true,
        }
    }

    /// Functions with `c` = NULL.
    pub fn without_instance(&mut self, i: usize) -> Result<Call> {
        let (f, c) = (&self.fmu.functions, ptr::null_mut());
        let (vr, mut number, mut state) = (0_u32, 0.0, ptr::null_mut());
        let which = self.random.below(8);
        self.trace(i, format_args!("a call without instance, number {which}"));
        // SAFETY: NULL instead of an instance; places of one number.
        let (name, status) = unsafe {
            match which {
                0 => ("fmi2DoStep", f.do_step(c, 0.0, 1e-3, 1)),
                1 => ("fmi2GetReal", f.get_real(c, &vr, 1, &mut number)),
                2 => ("fmi2SetReal", f.set_real(c, &vr, 1, &number)),
                3 => ("fmi2Reset", f.reset(c)),
                4 => ("fmi2Terminate", f.terminate(c)),
                5 => ("fmi2GetFMUstate", f.get_fmu_state(c, &mut state)),
                6 => match f.own() {
                    OwnFunctions::Fmi2(f) => ("fmi2CancelStep", (f.fmi2CancelStep)(c)),
                    OwnFunctions::Fmi3(f) => ("fmi3EnterStepMode", (f.fmi3EnterStepMode)(c)),
                },
                _ => ("fmi2ExitInitializationMode", f.exit_initialization_mode(c)),
            }
        };
        let name = f.name(name);
        Ok(Call {
            without_instance: true,
            ..self.plain(i, name, status, Expect::Refused)
        })
    }
}
