//! Random calls, for `turns`, of functions that only FMI 3.0 has: Event Mode, adjoint derivatives,
//! dependencies; also wrong numbers of values, and functions for what these FMUs lack.

use crate::arguments::{elements, seeds};
use crate::derivative_calls::{is_known, is_unknown};
use crate::oracle::{Call, Expect};
use crate::session::Session;
use anyhow::{Result, bail};
use fmi_description::{Access, Causality};
use fmi_import::raw::{Array, RawInstance, Update};
use fmi_import::standard::Mode;
use fmi_import::status::OK;

/// Most elements of inputs for which an adjoint derivative is compared with directional ones.
const COLUMNS: usize = 8;

impl Session<'_> {
    /// Enters or leaves Event Mode, or makes a call of it.
    pub fn event_call(&mut self, i: usize) -> Result<Call> {
        let mut update = Update::default();
        let which = self.random.below(8);
        let c: &RawInstance = &self.instances[i];
        let (name, next) = match which {
            0..3 => ("fmi3EnterEventMode", Some(Mode::Event)),
            3..6 => ("fmi3EnterStepMode", Some(Mode::Stepping)),
            6 => ("fmi3UpdateDiscreteStates", None),
            _ => ("fmi3EvaluateDiscreteStates", None),
        };
        let status = match which {
            0..3 => c.enter_event_mode(),
            3..6 => c.enter_step_mode(),
            6 => c.update_discrete_states(&mut update),
            _ => c.evaluate_discrete_states(),
        };
        self.trace(i, format_args!("{name}()"));
        let call = self.plain(i, name, status, Expect::Done);
        let announces = update.again || update.terminates || update.next.is_finite();
        if status == OK && announces {
            bail!("{name} announces events, of which these FMUs have none");
        }
        if let (OK, Some(mode)) = (status, next) {
            self.instances[i].known.mode = mode;
        }
        Ok(call)
    }

    /// fmi3GetNumberOfVariableDependencies and fmi3GetVariableDependencies.
    pub fn dependencies(&mut self, i: usize) -> Result<Call> {
        let r = &mut self.random;
        let variables = &self.fmu.description.variables;
        let vr = match r.one_in(8) {
            true => r.of(&[u32::MAX, 1 << 31]),
            false => variables[r.below(variables.len())].reference,
        };
        let (is_null, is_short) = (r.one_in(16), r.one_in(8));
        // Only variables that are initialized or computed must have dependencies.
        let expect = match self.fmu.find(vr) {
            Some(_) if !is_null => Expect::ModelDecides,
            _ => Expect::Refused,
        };
        let mut n = usize::MAX;
        let to = (!is_null).then_some(&mut n);
        let status = self.instances[i].count_dependencies(vr, to);
        let name = "fmi3GetNumberOfVariableDependencies";
        self.trace(i, format_args!("{name}({vr}, NULL: {is_null})"));
        if status != OK || n == 0 {
            return Ok(self.plain(i, name, status, expect));
        }
        let n = if is_short { n - 1 } else { n };
        let (status, _, on) = self.instances[i].get_dependencies(vr, n);
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
        let text = format_args!("{name}({unknown:?}, {known:?}, {v:?}, {short})");
        self.trace(i, text);
        let seed = &v[..v.len() - short];
        let (status, result) = self.instances[i].adjoint(&unknown, &known, seed);
        let claims = self.fmu.description.capabilities.adjoint_derivatives;
        let fit = self.are(&known, is_known(self.fmu)) && self.are(&unknown, is_unknown);
        let sound = claims && short == 0 && fit;
        // A model refuses inconsistent inputs; a huge seed overflows, and NaN is discarded.
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

    /// Functions of types, clocks and structural parameters that these FMUs lack, and wrong numbers
    /// of values.
    pub fn absent(&mut self, i: usize) -> Result<Call> {
        let r = &mut self.random;
        let variables = &self.fmu.description.variables;
        let v = &variables[r.below(variables.len())];
        let (vr, access) = (v.reference, v.access());
        let size = self.fmu.functions.count(&[vr]);
        let mut values_read = vec![0_u64; size + 2];
        let has_sizes = (variables.iter()).any(|v| v.causality == Causality::StructuralParameter);
        let which = match r.below(24) {
            // What this FMU has.
            13 | 14 if has_sizes => 15,
            0..11 if !matches!(access, Access::Real | Access::Integer | Access::Boolean) => 15,
            which => which,
        };
        use Access::*;
        let (c, one) = (&self.instances[i], Array::Elements(&[vr]));
        let names = |access| self.fmu.functions.names_of(access);
        let mut get = |access, n| {
            let status = c.get_numbers(access, one, Some(&mut values_read), n);
            (names(access)[0], status)
        };
        let values = vec![0; size + 2];
        let set = |access, n| {
            let status = c.set_numbers(access, one, Array::Elements(&values), n);
            (names(access)[1], status)
        };
        let (name, status) = match which {
            0..7 => {
                let types = [Float32, Int8, UInt8, Int16, UInt16, UInt32, UInt64];
                get(types[which], size)
            }
            7..11 => set([Float32, Int8, UInt16, UInt64][which - 7], size),
            11 => ("fmi3GetClock", c.get_clock(vr, &mut false)),
            12 => ("fmi3SetClock", c.set_clock(vr, false)),
            13 => ("fmi3EnterConfigurationMode", c.enter_configuration_mode()),
            14 => ("fmi3ExitConfigurationMode", c.exit_configuration_mode()),
            15 => ("fmi3GetIntervalDecimal", c.get_interval(vr, &mut 0.0, None)),
            16 => ("fmi3SetIntervalDecimal", c.set_interval(vr, 0.0)),
            17 => ("fmi3GetShiftDecimal", c.get_shift(vr, &mut 0.0)),
            18 => ("fmi3SetShiftFraction", c.set_shift(vr, 0, 0)),
            19 => get(Real, size + 1),
            20 => set(Real, size + 1),
            21 => get(Real, size - 1),
            22 => set(Real, size - 1),
            _ => get(Int64, size + 1),
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
