//! Random calls of what FMI 3.0 has and FMI 2.0 has not: Event Mode, adjoint derivatives,
//! dependencies, wrong numbers of values, and the functions of what these FMUs declare not to have.

use crate::arguments::{elements, place, seeds};
use crate::derivative_calls::{is_known, is_unknown};
use crate::oracle::{Call, Expect};
use crate::session::Session;
use anyhow::{Result, bail};
use fmi_description::{Access, Causality};
use fmi_import::Functions3;
use fmi_import::order::Mode;
use fmi_import::symbols::*;
use std::ptr;

/// Elements of inputs up to which an adjoint derivative is compared with the directional ones.
const COLUMNS: usize = 8;

impl<'a> Session<'a> {
    fn fmi3(&self) -> &'a Functions3 {
        self.fmu.functions.fmi3().expect("called for FMI 3.0 only")
    }

    /// Into Event Mode, in it, and out of it.
    pub fn event_call(&mut self, i: usize) -> Result<Call> {
        let (f, c) = (self.fmi3(), self.instances[i].c);
        let (mut flags, mut next_time) = ([false; 5], f64::NAN);
        let [a, b, d, e, g] = &mut flags;
        let which = self.random.below(8);
        // SAFETY: a live instance, places for the results.
        let (name, status) = unsafe {
            match which {
                0..3 => ("fmi3EnterEventMode", (f.fmi3EnterEventMode)(c)),
                3..6 => ("fmi3EnterStepMode", (f.fmi3EnterStepMode)(c)),
                6 => {
                    let status = (f.fmi3UpdateDiscreteStates)(c, a, b, d, e, g, &mut next_time);
                    ("fmi3UpdateDiscreteStates", status)
                }
                _ => (
                    "fmi3EvaluateDiscreteStates",
                    (f.fmi3EvaluateDiscreteStates)(c),
                ),
            }
        };
        self.trace(i, format_args!("{name}()"));
        let call = self.plain(i, name, status, Expect::Done);
        let [needs_update, terminates, _, _, has_next_time] = flags;
        if status == OK && (needs_update || terminates || has_next_time) {
            bail!("{name} announces events, of which these FMUs have none");
        }
        let next = match which {
            0..3 => Some(Mode::Event),
            3..6 => Some(Mode::Stepping),
            _ => None,
        };
        if let (OK, Some(mode)) = (status, next) {
            self.instances[i].known.mode = mode;
        }
        Ok(call)
    }

    /// fmi3GetNumberOfVariableDependencies and fmi3GetVariableDependencies.
    pub fn dependencies(&mut self, i: usize) -> Result<Call> {
        let (f, c) = (self.fmi3(), self.instances[i].c);
        let r = &mut self.random;
        let variables = &self.fmu.description.variables;
        let vr = match r.one_in(8) {
            true => r.of(&[u32::MAX, 1 << 31]),
            false => variables[r.below(variables.len())].reference,
        };
        let (is_null, is_short) = (r.one_in(16), r.one_in(8));
        // What is initialized or computed has dependencies; what they are asked of else is the
        // exporter's decision.
        let expect = match self.fmu.find(vr) {
            Some(_) if !is_null => Expect::ModelDecides,
            _ => Expect::Refused,
        };
        let mut n = usize::MAX;
        let to = place(&mut n, is_null);
        // SAFETY: a live instance; NULL or a place for the result.
        let status = unsafe { (f.fmi3GetNumberOfVariableDependencies)(c, vr, to) };
        let name = "fmi3GetNumberOfVariableDependencies";
        self.trace(i, format_args!("{name}({vr}, NULL: {is_null})"));
        if status != OK || n == 0 {
            return Ok(self.plain(i, name, status, expect));
        }
        let n = if is_short { n - 1 } else { n };
        let (mut of, mut on, mut of_on, mut kinds) =
            (vec![0; n], vec![0; n], vec![0; n], vec![0; n]);
        // SAFETY: a live instance; room for `n` of each.
        let status = unsafe {
            let (of, on, of_on) = (of.as_mut_ptr(), on.as_mut_ptr(), of_on.as_mut_ptr());
            (f.fmi3GetVariableDependencies)(c, vr, of, on, of_on, kinds.as_mut_ptr(), n)
        };
        let name = "fmi3GetVariableDependencies";
        self.trace(i, format_args!("{name}({vr}, {n}, too few: {is_short})"));
        if status == OK && on.iter().any(|vr| self.fmu.find(*vr).is_none()) {
            bail!("{name}({vr}) names {on:?}, which are not all there");
        }
        Ok(self.plain(i, name, status, Expect::done_if(!is_short)))
    }

    /// fmi3GetAdjointDerivative, which must be the transpose of fmi3GetDirectionalDerivative.
    pub fn adjoint(&mut self, i: usize) -> Result<Call> {
        let (valid, known, unknown) = self.for_derivative();
        let r = &mut self.random;
        let of = |vr: &[u32]| elements(self.fmu, vr).count();
        let [v, u] = [&unknown, &known].map(|vr| seeds(r, of(vr), valid));
        let short = usize::from(!valid && r.one_in(4) && !v.is_empty());
        let name = "fmi3GetAdjointDerivative";
        self.trace(
            i,
            format_args!("{name}({unknown:?}, {known:?}, {v:?}, {short})"),
        );
        let seed = &v[..v.len() - short];
        let (status, result) = self.instances[i].adjoint(&unknown, &known, seed);
        let claims = self.fmu.description.capabilities.adjoint_derivatives;
        let fit = self.are(&known, is_known(self.fmu)) && self.are(&unknown, is_unknown);
        let sound = claims && short == 0 && fit;
        // A model refuses inputs that are impossible together; a huge seed leaves the range of
        // numbers, one that is none is discarded.
        let expect = match sound {
            true if valid => Expect::ModelDecides,
            true => Expect::FileDecides,
            false if v.iter().all(|v| v.is_finite()) => Expect::Refused,
            false => Expect::RefusedOrDiscarded,
        };
        if result.iter().any(|x| !x.is_finite()) {
            bail!("{name}({unknown:?}) gave {status} and {result:?}");
        }
        if status == OK && valid && u.len() <= COLUMNS {
            self.check_transpose(i, [&unknown, &known], &v, &result)?;
        }
        Ok(self.plain(i, name, status, expect))
    }

    /// Each element of the adjoint derivative must be the product of `v` with the derivative along
    /// that element alone.
    fn check_transpose(
        &self,
        i: usize,
        [unknown, known]: [&[u32]; 2],
        v: &[f64],
        adjoint: &[f64],
    ) -> Result<()> {
        for (k, expected) in adjoint.iter().enumerate() {
            let mut seed = vec![0.0; adjoint.len()];
            seed[k] = 1.0;
            let (status, column) = self.instances[i].directional(unknown, known, &seed);
            let terms = || v.iter().zip(&column).map(|(v, y)| v * y);
            let (product, scale) = (terms().sum::<f64>(), terms().map(f64::abs).sum::<f64>());
            if status == OK && (product - expected).abs() > 1e-12 * scale {
                bail!(
                    "element {k} of the adjoint derivative is {expected}, but v times the derivative along it {product}"
                );
            }
        }
        self.instances[i].messages();
        Ok(())
    }

    /// Functions of types, clocks, structural parameters and interfaces that these FMUs have not,
    /// and wrong numbers of values.
    pub fn absent(&mut self, i: usize) -> Result<Call> {
        let (f, c) = (self.fmi3(), self.instances[i].c);
        let r = &mut self.random;
        let variables = &self.fmu.description.variables;
        let v = &variables[r.below(variables.len())];
        let (vr, access) = (v.reference, v.access());
        let size = self.fmu.functions.count(&[vr]);
        let mut room = vec![0_u64; size + 2];
        let (p, q) = (&raw const vr, room.as_mut_ptr());
        let has_sizes = (variables.iter()).any(|v| v.causality == Causality::StructuralParameter);
        let which = match r.below(24) {
            // What this FMU has.
            13 | 14 if has_sizes => 15,
            0..11 if !matches!(access, Access::Real | Access::Integer | Access::Boolean) => 15,
            which => which,
        };
        macro_rules! call {
            ($name:ident($($argument:expr),*)) => { (stringify!($name), (f.$name)(c $(, $argument)*)) };
        }
        // SAFETY: a live instance; room for more values than the variable has, of at most eight
        // bytes each.
        let (name, status) = unsafe {
            match which {
                0 => call!(fmi3GetFloat32(p, 1, q.cast(), size)),
                1 => call!(fmi3GetInt8(p, 1, q.cast(), size)),
                2 => call!(fmi3GetUInt8(p, 1, q.cast(), size)),
                3 => call!(fmi3GetInt16(p, 1, q.cast(), size)),
                4 => call!(fmi3GetUInt16(p, 1, q.cast(), size)),
                5 => call!(fmi3GetUInt32(p, 1, q.cast(), size)),
                6 => call!(fmi3GetUInt64(p, 1, q, size)),
                7 => call!(fmi3SetFloat32(p, 1, q.cast(), size)),
                8 => call!(fmi3SetInt8(p, 1, q.cast(), size)),
                9 => call!(fmi3SetUInt16(p, 1, q.cast(), size)),
                10 => call!(fmi3SetUInt64(p, 1, q, size)),
                11 => call!(fmi3GetClock(p, 1, q.cast())),
                12 => call!(fmi3SetClock(p, 1, q.cast())),
                13 => call!(fmi3EnterConfigurationMode()),
                14 => call!(fmi3ExitConfigurationMode()),
                15 => call!(fmi3GetIntervalDecimal(p, 1, q.cast(), ptr::null_mut())),
                16 => call!(fmi3SetIntervalDecimal(p, 1, q.cast())),
                17 => call!(fmi3GetShiftDecimal(p, 1, q.cast())),
                18 => call!(fmi3SetShiftFraction(p, 1, q, q)),
                19 => call!(fmi3GetFloat64(p, 1, q.cast(), size + 1)),
                20 => call!(fmi3SetFloat64(p, 1, q.cast(), size + 1)),
                21 => call!(fmi3GetFloat64(p, 1, q.cast(), size - 1)),
                22 => call!(fmi3SetFloat64(p, 1, q.cast(), size - 1)),
                _ => call!(fmi3GetInt64(p, 1, q.cast(), size + 1)),
            }
        };
        self.trace(i, format_args!("{name} of {vr}, number {which}"));
        // A value that is given may be out of bounds, too.
        let expect = match which {
            20 | 22 => Expect::RefusedOrDiscarded,
            _ => Expect::Refused,
        };
        Ok(self.plain(i, name, status, expect))
    }
}
