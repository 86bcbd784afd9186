//! Random calls that set and get variables.

use crate::arguments::*;
use crate::oracle::{Call, Expect};
use crate::session::Session;
use anyhow::{Result, bail};
use cargo_fmu::fmi::names_of;
use cargo_fmu::fmi::order::Mode;
use cargo_fmu::fmi::symbols::*;
use fmu_description::{Access, Causality, Variable};
use std::ffi::{CStr, c_int};
use std::ptr;

impl Session<'_> {
    /// Names for the judge, and whether all references are known.
    fn names(&self, vr: &[u32]) -> (Vec<String>, bool) {
        // Time is no variable of the model.
        let is_own = |v: &&Variable| v.causality != Causality::Independent;
        let found = vr.iter().map(|vr| self.fmu.find(*vr).filter(is_own));
        let names: Vec<_> = found.flatten().map(|v| v.name.clone()).collect();
        let is_complete = names.len() == vr.len();
        (names, is_complete)
    }

    /// The verdict on a call with value references.
    pub fn with_variables(
        &self,
        i: usize,
        name: &'static str,
        status: c_int,
        expect: Expect,
        vr: &[u32],
        is_null: bool,
    ) -> Call {
        let call = self.plain(i, name, status, expect);
        let in_order = self.in_order(i, name, Expect::Done) == Expect::Done;
        let (variables, is_complete) = self.names(vr);
        let is_refusal = matches!(expect, Expect::Refused | Expect::Discarded);
        let by_value = in_order && is_complete && !is_null && is_refusal;
        Call {
            variables: if by_value { variables } else { Vec::new() },
            ..call
        }
    }

    /// What fmi2SetXxx may answer, by NULL, causality, variability and bounds. With several mistakes in
    /// a call of FMI 3.0, whose variables are arrays, which is met first is the exporter's affair.
    fn settable(
        &self,
        i: usize,
        vr: &[u32],
        kind: Access,
        values: &[f64],
        is_null: bool,
    ) -> Expect {
        let are_several = self.fmu.functions.fmi3().is_some() && vr.len() > 1;
        let mistake = |expect| match are_several {
            true => Expect::RefusedOrDiscarded,
            false => expect,
        };
        if is_null {
            return mistake(Expect::Refused);
        }
        let (is_running, can_be_set) = (self.is_running(i), self.is_settable(i, kind));
        let mut expect = Expect::Done;
        for ((found, _), &value) in elements(self.fmu, vr).zip(values) {
            let Some(v) = found.filter(|v| can_be_set(v)) else {
                return mistake(Expect::Refused);
            };
            let [min, max] = v.bounds();
            let is_allowed = value.is_finite() && min <= value && value <= max;
            if kind != Access::Boolean && !is_allowed {
                return mistake(Expect::Discarded);
            }
            if v.is_tunable() && is_running {
                expect = Expect::ModelDecides;
            }
        }
        expect
    }

    /// Initialization is over.
    fn is_running(&self, i: usize) -> bool {
        let mode = self.instances[i].known.mode;
        matches!(mode, Mode::Event | Mode::Stepping | Mode::SteppingAfterSet)
    }

    /// Notes what a set that was done leads to.
    fn note_set(&mut self, i: usize, status: c_int) {
        if status == OK {
            self.instances[i].known.note_set(self.fmu);
        }
    }

    fn is_settable(&self, i: usize, kind: Access) -> impl Fn(&Variable) -> bool + use<> {
        let is_running = self.is_running(i);
        move |v| {
            let settable = v.is_input()
                || v.is_tunable()
                || (v.causality == Causality::Parameter && !is_running);
            v.access() == kind && settable
        }
    }

    pub fn set_real(&mut self, i: usize) -> Result<Call> {
        let wanted = self.is_settable(i, Access::Real);
        let r = &mut self.random;
        let valid = r.one_in(2);
        let vr = references(r, self.fmu, valid, wanted);
        let values: Vec<f64> = elements(self.fmu, &vr)
            .map(|(v, k)| real_for(r, v, k, valid))
            .collect();
        let (no_vr, no_values) = (!valid && r.one_in(16), !valid && r.one_in(16));
        let is_null = (no_vr || no_values) && !vr.is_empty();
        let expect = self.settable(i, &vr, Access::Real, &values, is_null);
        let name = self.fmu.functions.name("fmi2SetReal");
        self.trace(
            i,
            format_args!("{name}({vr:?}, {values:?}, {no_vr}, {no_values})"),
        );
        let (f, c) = (&self.fmu.functions, self.instances[i].c);
        let (from, place) = (pointer(&vr, no_vr), pointer(&values, no_values));
        // SAFETY: a live instance; NULL or arrays of equal length.
        let status = unsafe { f.set_real(c, from, vr.len(), place) };
        let readable = match self.instances[i].known.mode {
            Mode::Initialization | Mode::Event => true,
            Mode::Stepping => self.fmu.functions.fmi3().is_none(),
            _ => false,
        };
        self.note_set(i, status);
        if let ([vr], [value], OK, true) = (&*vr, &*values, status, readable) {
            let mut back = f64::NAN;
            // SAFETY: a live instance; one element each.
            let got = unsafe { self.fmu.functions.get_real(c, vr, 1, &mut back) };
            if got != OK || back.to_bits() != value.to_bits() {
                bail!("value reference {vr}: {value} was set, {back} came back");
            }
        }
        Ok(self.with_variables(i, name, status, expect, &vr, is_null))
    }

    /// What fmi2GetInteger and fmi3GetInt64 access. A call with references of Int32 only goes to
    /// fmi3GetInt32.
    fn integer_kind(&self, is_boolean: bool) -> Access {
        match (is_boolean, self.fmu.functions.fmi3()) {
            (true, _) => Access::Boolean,
            (false, None) => Access::Integer,
            (false, Some(_)) => Access::Int64,
        }
    }

    /// As `integer_kind`, with the name of the function, by the first reference.
    fn by_first(
        &self,
        kind: Access,
        vr: &[u32],
        names: [&'static str; 2],
    ) -> (Access, &'static str) {
        let first = vr.first().and_then(|vr| self.fmu.find(*vr));
        match (kind, first.map(Variable::access)) {
            (Access::Int64, Some(Access::Integer)) => (Access::Integer, names[1]),
            // So read, but not so set, by `Functions`.
            (Access::Int64, Some(Access::UInt64)) if names[0] == "fmi2GetInteger" => {
                (Access::UInt64, "fmi3GetUInt64")
            }
            _ => (kind, self.fmu.functions.name(names[0])),
        }
    }

    pub fn set_integer(&mut self, i: usize) -> Result<Call> {
        let is_boolean = self.random.one_in(3);
        let kind = self.integer_kind(is_boolean);
        let wanted = self.is_settable(i, kind);
        let r = &mut self.random;
        let valid = r.one_in(2);
        let vr = references(r, self.fmu, valid, wanted);
        let values: Vec<c_int> = elements(self.fmu, &vr)
            .map(|(v, _)| integer_for(r, v, valid))
            .collect();
        let names = match is_boolean {
            true => ["fmi2SetBoolean"; 2],
            false => ["fmi2SetInteger", "fmi3SetInt32"],
        };
        let (kind, name) = self.by_first(kind, &vr, names);
        let numbers: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
        let no_values = self.random.one_in(16);
        let is_null = no_values && !vr.is_empty();
        let expect = self.settable(i, &vr, kind, &numbers, is_null);
        let (f, c) = (&self.fmu.functions, self.instances[i].c);
        self.trace(i, format_args!("{name}({vr:?}, {values:?}, {no_values})"));
        let place = pointer(&values, no_values);
        // SAFETY: a live instance; NULL or as many values as there are elements.
        let status = unsafe { f.set_integers(is_boolean, c, vr.as_ptr(), vr.len(), place) };
        self.note_set(i, status);
        Ok(self.with_variables(i, name, status, expect, &vr, is_null))
    }

    /// Gets or sets a variable of one of the types that FMI 3.0 has beside those above, or a text or
    /// enumeration. What is set is read back.
    pub fn typed(&mut self, i: usize) -> Result<Call> {
        let others = [
            Access::Real,
            Access::Integer,
            Access::Boolean,
            Access::Clock,
        ];
        let variables = &self.fmu.description.variables;
        let all: Vec<_> = (variables.iter())
            .filter(|v| !others.contains(&v.access()))
            .collect();
        let r = &mut self.random;
        if all.is_empty() {
            return self.absent(i);
        }
        let (v, valid, is_set) = (r.of(&all), r.one_in(2), r.one_in(2));
        let (access, vr) = (v.access(), [v.reference]);
        let [get, set] = names_of(access);
        if !is_set {
            let expect = self.readable(&vr, access);
            self.trace(i, format_args!("{get}({vr:?})"));
            let (status, _) = self.instances[i].values(v);
            return Ok(self.with_variables(i, get, status, expect, &vr, false));
        }
        let values: Vec<_> = (0..v.size()).map(|k| value_for(r, v, k, valid)).collect();
        let numbers: Vec<_> = values
            .iter()
            .map(|value| value.parse().unwrap_or(0.0))
            .collect();
        let expect = match access {
            Access::String => match self.is_settable(i, access)(v) {
                true => Expect::FileDecides,
                false => Expect::Refused,
            },
            Access::Binary => self.settable(i, &vr, access, &vec![0.0; values.len()], false),
            _ => self.settable(i, &vr, access, &numbers, false),
        };
        self.trace(i, format_args!("{set}({vr:?}, {values:?})"));
        let status = self.instances[i].set_values(v, &values);
        let mode = self.instances[i].known.mode;
        self.note_set(i, status);
        if status == OK && matches!(mode, Mode::Initialization | Mode::Event) {
            let (got, back) = self.instances[i].values(v);
            if (got, &back) != (OK, &values) {
                bail!("`{}`: {values:?} was set, {back:?} came back", v.name);
            }
        }
        Ok(self.with_variables(i, set, status, expect, &vr, false))
    }

    pub fn set_string(&mut self, i: usize) -> Result<Call> {
        let wanted = self.is_settable(i, Access::String);
        let r = &mut self.random;
        let valid = r.one_in(2);
        let vr = references(r, self.fmu, valid, wanted);
        let pool: [&CStr; 6] = [
            c"",
            c"reference_machine.json",
            c"no such file",
            c"/",
            c"\xff",
            c"{}",
        ];
        let texts: Vec<&CStr> = elements(self.fmu, &vr)
            .map(|_| r.of(&pool[..if valid { 2 } else { 6 }]))
            .collect();
        let mut values: Vec<Text> = texts.iter().map(|t| t.as_ptr()).collect();
        if !valid && !values.is_empty() && r.one_in(8) {
            values[0] = ptr::null();
        }
        let find = |vr: &u32| self.fmu.find(*vr);
        let can_be_set = self.is_settable(i, Access::String);
        let expect = match vr.iter().all(|vr| find(vr).is_some_and(&can_be_set)) {
            _ if vr.is_empty() => Expect::Done,
            true => Expect::FileDecides,
            false => Expect::Refused,
        };
        let name = self.fmu.functions.name("fmi2SetString");
        self.trace(i, format_args!("{name}({vr:?}, {texts:?}, {values:?})"));
        let (f, c) = (&self.fmu.functions, self.instances[i].c);
        // SAFETY: a live instance; arrays of equal length, each element NULL or a C string.
        let status = unsafe { f.set_string(c, vr.as_ptr(), vr.len(), values.as_ptr()) };
        let call = self.plain(i, name, status, expect);
        self.note_set(i, status);
        Ok(call)
    }

    /// What fmi2GetXxx may answer. The model may find inputs, or in Initialization Mode start
    /// values, impossible together.
    fn readable(&self, vr: &[u32], kind: Access) -> Expect {
        let mut expect = Expect::Done;
        for vr in vr {
            match self.fmu.find(*vr) {
                Some(v) if v.access() != kind => return Expect::Refused,
                None => return Expect::Refused,
                Some(v) if v.is_computed() => expect = Expect::ModelDecides,
                Some(_) => {}
            }
        }
        expect
    }

    /// Whether the model is asked before a wrong reference is met: then the refusal may be the
    /// model's.
    fn computes(&self, vr: &[u32], kind: Access) -> bool {
        let mut found = vr.iter().filter_map(|vr| self.fmu.find(*vr));
        found.any(|v| v.is_computed() && v.access() == kind)
    }

    pub fn get_real(&mut self, i: usize) -> Result<Call> {
        let r = &mut self.random;
        let valid = r.one_in(2);
        let vr = references(r, self.fmu, valid, |v| v.access() == Access::Real);
        let no_values = !valid && r.one_in(16);
        let is_null = no_values && !vr.is_empty();
        let mut values = vec![0.0; self.fmu.functions.count(&vr)];
        let expect = match is_null {
            true => Expect::Refused,
            false => self.readable(&vr, Access::Real),
        };
        let name = self.fmu.functions.name("fmi2GetReal");
        self.trace(i, format_args!("{name}({vr:?}, {no_values})"));
        let place = room(&mut values, no_values);
        let c = self.instances[i].c;
        // SAFETY: a live instance; NULL or arrays of equal length.
        let status = unsafe { self.fmu.functions.get_real(c, vr.as_ptr(), vr.len(), place) };
        if values.iter().any(|v| !v.is_finite()) {
            bail!("{name}({vr:?}) gave {status} and {values:?}");
        }
        let is_computing = self.computes(&vr, Access::Real);
        Ok(self.with_variables(i, name, status, expect, &vr, is_null || is_computing))
    }

    pub fn get_integer(&mut self, i: usize) -> Result<Call> {
        let r = &mut self.random;
        let (valid, is_boolean) = (r.one_in(2), r.one_in(2));
        let kind = self.integer_kind(is_boolean);
        let r = &mut self.random;
        let vr = references(r, self.fmu, valid, |v| v.access() == kind);
        let names = match is_boolean {
            true => ["fmi2GetBoolean"; 2],
            false => ["fmi2GetInteger", "fmi3GetInt32"],
        };
        let (kind, name) = self.by_first(kind, &vr, names);
        let (f, c) = (&self.fmu.functions, self.instances[i].c);
        let mut values = vec![0; f.count(&vr)];
        let expect = self.readable(&vr, kind);
        self.trace(i, format_args!("{name}({vr:?})"));
        let place = values.as_mut_ptr();
        // SAFETY: a live instance; room for all elements.
        let status = unsafe { f.get_integers(is_boolean, c, vr.as_ptr(), vr.len(), place) };
        let is_computing = self.computes(&vr, kind);
        Ok(self.with_variables(i, name, status, expect, &vr, is_computing))
    }

    pub fn get_string(&mut self, i: usize) -> Result<Call> {
        let r = &mut self.random;
        let valid = r.one_in(2);
        let vr = references(r, self.fmu, valid, |v| v.access() == Access::String);
        let mut values: Vec<Text> = vec![ptr::null(); self.fmu.functions.count(&vr)];
        let expect = self.readable(&vr, Access::String);
        let name = self.fmu.functions.name("fmi2GetString");
        self.trace(i, format_args!("{name}({vr:?})"));
        let (f, c) = (&self.fmu.functions, self.instances[i].c);
        let place = values.as_mut_ptr();
        // SAFETY: a live instance; arrays of equal length.
        let status = unsafe { f.get_string(c, vr.as_ptr(), vr.len(), place) };
        for value in values.iter().filter(|_| status == OK) {
            // SAFETY: given out by the FMU, valid until the next call.
            if value.is_null() || unsafe { CStr::from_ptr(*value) }.to_str().is_err() {
                bail!("{name}({vr:?}) gave no text");
            }
        }
        Ok(self.with_variables(i, name, status, expect, &vr, false))
    }
}
