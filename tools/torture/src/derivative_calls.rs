//! Random calls, for `turns`, that set and get derivatives: input and output derivatives,
//! directional derivatives.

use crate::arguments::*;
use crate::oracle::{Call, Expect};
use crate::session::Session;
use anyhow::{Result, bail};
use fmi_description::{Access, Causality, Variability, Variable};
use fmi_import::Fmu;
use fmi_import::standard::Mode;
use std::ffi::c_int;

/// Whether a variable may be the known of a derivative: an input, or a state of Model Exchange.
pub fn is_known(fmu: &Fmu) -> impl Fn(&Variable) -> bool + Copy {
    |v| v.access() == Access::Real && (v.is_input() || fmu.description.is_state(v))
}

/// Whether a variable may be the unknown of a derivative: outputs and local variables, which
/// include derivatives of states and event indicators.
pub fn is_unknown(v: &Variable) -> bool {
    v.is_computed() && v.access() == Access::Real
}

impl Session<'_> {
    pub fn set_input_derivatives(&mut self, i: usize) -> Result<Call> {
        let is_input = |v: &Variable| {
            v.is_input() && v.access() == Access::Real && v.variability == Variability::Continuous
        };
        let r = &mut self.random;
        let valid = r.one_in(2);
        let vr = references(r, self.fmu, valid, is_input);
        let any = [1, 1, 2, 0, -1, 9, c_int::MAX];
        let order: Vec<c_int> = match valid {
            true => vec![1; vr.len()],
            false => vr.iter().map(|_| r.of(&any)).collect(),
        };
        let values = seeds(r, vr.len(), valid);
        let known = |vr: &u32| self.fmu.find(*vr).is_some_and(is_input);
        // FMI 2.0 declares no highest order.
        let answer = |((vr, order), value): ((&u32, &c_int), &f64)| match known(vr) && *order >= 1 {
            false => Expect::Refused,
            true if !value.is_finite() => Expect::Discarded,
            true => Expect::Done,
        };
        let mut answers = vr.iter().zip(&order).zip(&values).map(answer);
        let expect = answers.find(|a| *a != Expect::Done);
        let expect = expect.unwrap_or(Expect::Done);
        let name = "fmi2SetRealInputDerivatives";
        self.trace(i, format_args!("{name}({vr:?}, {order:?}, {values:?})"));
        let status = self.instances[i].set_input_derivatives(&vr, &order, &values);
        Ok(self.with_variables(i, name, status, expect, &vr, false))
    }

    pub fn get_output_derivatives(&mut self, i: usize) -> Result<Call> {
        let is_output =
            |v: &Variable| v.causality == Causality::Output && v.access() == Access::Real;
        let r = &mut self.random;
        let valid = r.one_in(2);
        let vr = references(r, self.fmu, valid, is_output);
        let order: Vec<c_int> = match valid {
            true => vec![1; vr.len()],
            false => vr.iter().map(|_| r.of(&[1, 1, 1, 0, 2, -5])).collect(),
        };
        let known = |vr: &u32| self.fmu.find(*vr).is_some_and(is_output);
        let has_them = self.fmu.description.capabilities.output_derivative_order > 0;
        let expect = match has_them && vr.iter().all(known) && order.iter().all(|o| *o == 1) {
            true if vr.is_empty() => Expect::Done,
            true => Expect::ModelDecides, // it may overflow
            false => Expect::Refused,
        };
        let name = self.fmu.functions.name("fmi2GetRealOutputDerivatives");
        self.trace(i, format_args!("{name}({vr:?}, {order:?})"));
        let (status, values) = self.instances[i].output_derivatives(&vr, &order);
        if values.iter().any(|v| !v.is_finite()) {
            bail!("{name}({vr:?}) gave {status} and {values:?}");
        }
        Ok(self.with_variables(i, name, status, expect, &vr, !has_them))
    }

    /// Knowns and unknowns of a derivative, and whether they are valid.
    pub fn for_derivative(&mut self) -> (bool, Vec<u32>, Vec<u32>) {
        let r = &mut self.random;
        let valid = r.one_in(2);
        let known = references(r, self.fmu, valid, is_known(self.fmu));
        (valid, known, references(r, self.fmu, valid, is_unknown))
    }

    /// Whether all references are of variables that are `wanted`.
    pub fn are(&self, vr: &[u32], wanted: impl Fn(&Variable) -> bool) -> bool {
        let find = |vr: &u32| self.fmu.find(*vr);
        vr.iter().all(|vr| find(vr).is_some_and(&wanted))
    }

    pub fn get_directional_derivative(&mut self, i: usize) -> Result<Call> {
        let (valid, known, unknown) = self.for_derivative();
        let n = elements(self.fmu, &known).count();
        let seed = seeds(&mut self.random, n, valid);
        // Knowns are checked first, each with its seed.
        let is_3 = self.fmu.functions.is_fmi3();
        let are_there = self.are(&known, |_| true) && self.are(&unknown, |_| true);
        let wrong_known = elements(self.fmu, &known)
            .zip(&seed)
            .find_map(|((v, _), seed)| match v.is_some_and(is_known(self.fmu)) {
                false => Some(Expect::Refused),
                true => (!seed.is_finite()).then_some(Expect::Discarded),
            });
        let is_initializing = self.instances[i].known.mode == Mode::Initialization;
        let is_output = |v: &Variable| v.causality == Causality::Output;
        let is_of_outputs = !self.fmu.description.model_exchange
            || self.are(&known, Variable::is_input) && self.are(&unknown, is_output);
        let expect = match wrong_known {
            _ if !self.fmu.description.capabilities.directional_derivatives => Expect::Refused,
            _ if is_3 && !are_there => Expect::Refused,
            // FMI 3.0 names whole arrays, so the exporter decides what is checked first.
            Some(_) if is_3 && seed.iter().any(|s| !s.is_finite()) => Expect::RefusedOrDiscarded,
            Some(answer) => answer,
            None if !self.are(&unknown, is_unknown) => Expect::Refused,
            // Overflow, inconsistent start values, or a finite difference whose end point the model
            // refuses.
            None if !valid || is_initializing || !is_of_outputs => Expect::ModelDecides,
            None => Expect::Done,
        };
        let name = self.fmu.functions.name("fmi2GetDirectionalDerivative");
        self.trace(i, format_args!("{name}({unknown:?}, {known:?}, {seed:?})"));
        let (status, result) = self.instances[i].directional(&unknown, &known, &seed);
        if result.iter().any(|v| !v.is_finite()) {
            bail!("{name}({unknown:?}) gave {status} and {result:?}");
        }
        let vr = [known, unknown].concat();
        let without = !self.fmu.description.capabilities.directional_derivatives;
        Ok(self.with_variables(i, name, status, expect, &vr, without))
    }
}
