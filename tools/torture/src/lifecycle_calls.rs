//! Random calls, for `turns`, of the life cycle: instantiation, modes, steps, inquiries, logging.

use crate::arguments::{c_string, integer, real};
use crate::oracle::{Call, Expect};
use crate::session::Session;
use crate::subject::NEW;
use anyhow::Result;
use fmi_import::log::Log;
use fmi_import::raw::{
    Array, CallbackSet, Experiment, Inquiry, InstanceKind, RawInstance, Request, StateHandle,
    StepEnd,
};
use fmi_import::standard::Mode;
use fmi_import::status::{ERROR, OK};
use std::ffi::{CStr, CString, c_int};

impl Session<'_> {
    pub fn setup_experiment(&mut self, i: usize) -> Result<Call> {
        let r = &mut self.random;
        let (has_tolerance, has_stop) = (r.one_in(8), r.one_in(8));
        let start = if r.one_in(4) { real(r) } else { 0.0 };
        let tolerance = if r.one_in(2) { real(r) } else { 1e-4 };
        let stop = if r.one_in(2) { real(r) } else { start + 1.0 };
        let is_3 = self.fmu.functions.is_fmi3();
        let name = self.fmu.functions.name("fmi2SetupExperiment");
        // The tolerance matters only to FMUs that declare one; an infinite stop time is none.
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
        // FMI 3.0 has this in fmi3EnterInitializationMode.
        let status = instance.begin(experiment);
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
        let f = &self.fmu.functions;
        let after_initialization = match f.has_event_mode() {
            true => Mode::Event,
            false => Mode::Stepping,
        };
        let own = f.name(name);
        self.trace(i, format_args!("{own}()"));
        let experiment = Experiment::default();
        let instance = &self.instances[i];
        let (expect, next, status) = match name {
            "fmi2EnterInitializationMode" => {
                let status = instance.enter_initialization_mode(experiment);
                (Expect::Done, Some(Mode::Initialization), status)
            }
            "fmi2ExitInitializationMode" => {
                let status = instance.exit_initialization_mode();
                (Expect::ModelDecides, Some(after_initialization), status)
            }
            "fmi2Terminate" => (Expect::Done, Some(Mode::Terminated), instance.terminate()),
            "fmi2Reset" => {
                let status = RawInstance::reset(instance);
                (Expect::Done, Some(Mode::Instantiated), status)
            }
            _ if f.is_fmi3() => return self.event_call(i),
            _ => (Expect::Refused, None, instance.cancel_step()),
        };
        let expect = self.in_order(i, own, expect);
        let is_3 = f.is_fmi3();
        let instance = &mut self.instances[i];
        match next {
            Some(Mode::Instantiated) if status == OK => instance.known = NEW,
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
        // Importers that add up steps or count nanoseconds are tolerated; twice that is a jump.
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
        let status = self.instances[i].do_step(t, h, no_set_prior, &mut StepEnd::default());
        let call = self.plain(i, name, status, expect);
        if status == OK {
            let known = &mut self.instances[i].known;
            (known.time, known.mode) = (end, Mode::Stepping);
        }
        Ok(call)
    }

    /// Inquiries of FMI 2.0; in FMI 3.0 about dependencies.
    pub fn status(&mut self, i: usize) -> Result<Call> {
        if self.fmu.functions.is_fmi3() {
            return self.dependencies(i);
        }
        let r = &mut self.random;
        let kind = r.of(&[0, 1, 2, 3, 4, -1, c_int::MAX]);
        let is_null = r.one_in(8);
        // The inquiry that each function answers.
        let inquiries = [
            (Inquiry::Status, Some(0)),
            (Inquiry::Real, Some(2)),
            (Inquiry::Integer, None),
            (Inquiry::Boolean, Some(3)),
            (Inquiry::String, Some(1)),
        ];
        let (by, answered) = inquiries[r.below(inquiries.len())];
        let right = answered == Some(kind);
        let (name, status) = self.instances[i].inquire(by, kind, is_null);
        self.trace(i, format_args!("{name}({kind}, NULL: {is_null})"));
        let expect = match (right, by) {
            _ if is_null => Expect::Refused,
            (true, Inquiry::String) | (false, _) => Expect::Discarded, // as the standard says of an inquiry without answer
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
                    // Undeclared categories are ignored in FMI 2.0, and refused in FMI 3.0.
                    sound &= name.to_str().is_ok() && !self.fmu.functions.is_fmi3();
                    name.to_owned()
                }
            })
            .collect();
        let mut list: Vec<Option<&CStr>> = names.iter().map(|n| Some(n.as_c_str())).collect();
        if r.one_in(16) {
            list.push(None);
            sound = false;
        }
        let is_null = r.one_in(16);
        sound &= !is_null || list.is_empty();
        let name = self.fmu.functions.name("fmi2SetDebugLogging");
        self.trace(i, format_args!("{name}({on}, {names:?}, NULL: {is_null})"));
        let list = Array::or_null(&list, is_null);
        let status = self.instances[i].set_debug_logging(on, list);
        let call = self.plain(i, name, status, Expect::done_if(sound));
        if status == OK {
            let named = names.iter().map(|n| n.to_string_lossy().into_owned());
            let adds = self.fmu.functions.is_fmi3();
            self.instances[i].set_logging(on, named.collect(), adds);
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
        let request = Request {
            kind: match kind {
                0 => InstanceKind::ModelExchange,
                1 => InstanceKind::CoSimulation,
                other => InstanceKind::Other(other),
            },
            name,
            token: (!no_guid).then_some(&guid),
            resources: uri,
            is_logging: true,
            has_events: self.fmu.functions.has_event_mode(),
            returns_early: false,
            given: match no_callbacks {
                true => CallbackSet::Nothing,
                false => CallbackSet::NoLogger,
            },
        };
        let f = &self.fmu.functions;
        let made = RawInstance::new(f, &request, Log::new("x")).is_ok();
        RawInstance::free_null(f);
        let versions = f.versions().into_iter().map(|(_, text)| text);
        let versions: Vec<_> = versions.flatten().collect();
        let is_made = made && (versions == ["2.0", "default"] || versions == ["3.0"]);
        let right = guid.to_str() == Ok(&self.fmu.description.guid) && !no_guid;
        // In FMI 3.0 any other number calls the function for Model Exchange.
        let is_exchange = kind == 0 || f.is_fmi3();
        let is_offered = kind == 1 || is_exchange && self.fmu.description.model_exchange;
        // FMI 3.0 has a logger instead, which may be NULL.
        let sound = right
            && is_offered
            && (!no_callbacks || f.is_fmi3())
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
        let f = &self.fmu.functions;
        let c = RawInstance::null(f);
        let (vr, mut number) = (Array::Elements(&[0]), [0.0]);
        let (mut end, mut state) = (StepEnd::default(), StateHandle::NULL);
        let which = self.random.below(8);
        self.trace(i, format_args!("a call without instance, number {which}"));
        let (name, status) = match which {
            0 => ("fmi2DoStep", c.do_step(0.0, 1e-3, 1, &mut end)),
            1 => ("fmi2GetReal", c.get_reals(vr, Some(&mut number))),
            2 => ("fmi2SetReal", c.set_reals(vr, Array::Elements(&number))),
            3 => ("fmi2Reset", c.reset()),
            4 => ("fmi2Terminate", c.terminate()),
            5 => ("fmi2GetFMUstate", c.get_state(Some(&mut state))),
            6 if f.is_fmi3() => ("fmi3EnterStepMode", c.enter_step_mode()),
            6 => ("fmi2CancelStep", c.cancel_step()),
            _ => ("fmi2ExitInitializationMode", c.exit_initialization_mode()),
        };
        let name = f.name(name);
        Ok(Call {
            without_instance: true,
            ..self.plain(i, name, status, Expect::Refused)
        })
    }
}
