//! Random calls, for `turns`, that set and get variables of any type.

use crate::arguments::*;
use crate::oracle::{Call, Expect};
use crate::session::Session;
use anyhow::{Result, bail};
use fmi_description::{Access, Causality, Variable};
use fmi_import::standard::Mode;
use fmi_import::status::OK;
use std::ffi::{CStr, c_int};

impl Session<'_> {
    /// The record of a call with value references.
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
        // Time is no variable of the model.
        let is_own = |v: &&Variable| v.causality != Causality::Independent;
        let found = vr.iter().map(|vr| self.fmu.find(*vr).filter(is_own));
        let variables: Vec<_> = found.flatten().map(|v| v.name.clone()).collect();
        let is_complete = variables.len() == vr.len();
        let is_refusal = matches!(expect, Expect::Refused | Expect::Discarded);
        let by_value = in_order && is_complete && !is_null && is_refusal;
        Call {
            variables: if by_value { variables } else { Vec::new() },
            ..call
        }
    }

    /// What fmi2SetXxx may return, by NULL, causality, variability and bounds. If a call of FMI
    /// 3.0, whose variables are arrays, has several mistakes, the exporter decides which is met
    /// first.
    fn settable(
        &self,
        i: usize,
        vr: &[u32],
        kind: Access,
        values: &[f64],
        is_null: bool,
    ) -> Expect {
        let are_several = self.fmu.functions.is_fmi3() && vr.len() > 1;
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

    /// Notes a set that was done.
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

    /// A type other than Real of which the FMU has variables; in FMI 2.0 strings are left to
    /// [`Session::set_string`].
    fn other_access(&mut self) -> Access {
        let is_3 = self.fmu.functions.is_fmi3();
        let is_other = |a: &Access| a.is_number() || is_3 && *a != Access::Clock;
        let accesses = self.fmu.accesses().into_iter().filter(is_other);
        let others: Vec<_> = accesses.filter(|a| *a != Access::Real).collect();
        match others.is_empty() {
            true => Access::Integer,
            false => self.random.of(&others),
        }
    }

    pub fn set_other(&mut self, i: usize) -> Result<Call> {
        let access = self.other_access();
        self.set(i, access)
    }

    /// Sets variables of a type. If it is only one, its value is read back.
    pub fn set(&mut self, i: usize, access: Access) -> Result<Call> {
        let wanted = self.is_settable(i, access);
        let r = &mut self.random;
        let valid = r.one_in(2);
        let vr = references(r, self.fmu, valid, &wanted);
        let values: Vec<_> = elements(self.fmu, &vr)
            .map(|(v, k)| value_for(r, v, access, k, valid))
            .collect();
        let may_be_null = !valid && access.is_number();
        let nulls = [(); 2].map(|()| may_be_null && r.one_in(16));
        let is_null = nulls.contains(&true) && !vr.is_empty();
        // Bytes have no bounds.
        let number = |text: &String| text.parse().unwrap_or(0.0);
        let numbers: Vec<_> = match access {
            Access::Binary => vec![0.0; values.len()],
            _ => values.iter().map(number).collect(),
        };
        let expect = match access {
            Access::String if self.are(&vr, &wanted) && !vr.is_empty() => Expect::FileDecides,
            _ => self.settable(i, &vr, access, &numbers, is_null),
        };
        let [_, name] = self.fmu.functions.names_of(access);
        self.trace(i, format_args!("{name}({vr:?}, {values:?}, {nulls:?})"));
        let status = self.instances[i].set_values_of(access, &vr, &values, nulls);
        let is_readable = match self.instances[i].known.mode {
            Mode::Initialization | Mode::Event => true,
            Mode::Stepping => !self.fmu.functions.is_fmi3(),
            _ => false,
        };
        self.note_set(i, status);
        // Any number but 0 is a truth value.
        let is_one = vr.len() == 1 && access != Access::Boolean;
        if is_one && status == OK && is_readable {
            let (got, back) = self.instances[i].values_of(access, &vr, false);
            if (got, &back) != (OK, &values) {
                bail!(
                    "value reference {}: {values:?} was set, {back:?} came back",
                    vr[0]
                );
            }
        }
        Ok(self.with_variables(i, name, status, expect, &vr, is_null))
    }

    pub fn set_string(&mut self, i: usize) -> Result<Call> {
        let wanted = self.is_settable(i, Access::String);
        let r = &mut self.random;
        let valid = r.one_in(2);
        let vr = references(r, self.fmu, valid, &wanted);
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
        let mut values: Vec<_> = texts.iter().map(|t| Some(*t)).collect();
        if !valid && !values.is_empty() && r.one_in(8) {
            values[0] = None;
        }
        let expect = match self.are(&vr, wanted) {
            _ if vr.is_empty() => Expect::Done,
            true => Expect::FileDecides,
            false => Expect::Refused,
        };
        let name = self.fmu.functions.name("fmi2SetString");
        self.trace(i, format_args!("{name}({vr:?}, {values:?})"));
        let status = self.instances[i].set_strings(&vr, &values);
        let call = self.plain(i, name, status, expect);
        self.note_set(i, status);
        Ok(call)
    }

    /// What fmi2GetXxx may return. The model may refuse inconsistent inputs, or in Initialization
    /// Mode start values.
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

    pub fn get_other(&mut self, i: usize) -> Result<Call> {
        let access = self.other_access();
        self.get(i, access)
    }

    /// Gets variables of a type.
    pub fn get(&mut self, i: usize, access: Access) -> Result<Call> {
        let r = &mut self.random;
        let valid = r.one_in(2);
        let vr = references(r, self.fmu, valid, |v| v.access() == access);
        let no_values = !valid && access.is_number() && r.one_in(16);
        let is_null = no_values && !vr.is_empty();
        let expect = match is_null {
            true => Expect::Refused,
            false => self.readable(&vr, access),
        };
        let [name, _] = self.fmu.functions.names_of(access);
        self.trace(i, format_args!("{name}({vr:?}, {no_values})"));
        let (status, values) = self.instances[i].values_of(access, &vr, no_values);
        let is_no_number = |text: &String| text.parse().is_ok_and(|x: f64| !x.is_finite());
        let is_float = matches!(access, Access::Real | Access::Float32);
        if is_float && values.iter().any(is_no_number) {
            bail!("{name}({vr:?}) gave {status} and {values:?}");
        }
        // Where the model computes a value before a wrong reference is met, it may refuse first.
        let mut found = vr.iter().filter_map(|vr| self.fmu.find(*vr));
        let is_computing = found.any(|v| v.is_computed() && v.access() == access);
        Ok(self.with_variables(i, name, status, expect, &vr, is_null || is_computing))
    }
}
