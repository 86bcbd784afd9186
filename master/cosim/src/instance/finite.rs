//! Refuses numbers that are not finite on their way into an instance or out of it, except of the
//! variables that may be so (`--allow-nonfinite`): the exchange, start values and `Master` ask here.

use anyhow::{Result, bail};
use fmi_description::Access;
use fmi_import::batch::Batch;
use fmi_import::value::Value;

use super::{At, Instance};

/// Whether all numbers are finite, without a branch for each: where all bits of the exponent are
/// set, adding the lowest of them carries into the sign.
#[inline]
pub(crate) fn are_finite(values: &[f64]) -> bool {
    const LOWEST: u64 = 1 << (f64::MANTISSA_DIGITS - 1);
    let carried = |value: &f64| value.abs().to_bits().wrapping_add(LOWEST);
    values.iter().fold(0, |all, value| all | carried(value)) >> 63 == 0
}

/// The value that a variable of this type gets: a number may be too large for a Float32.
fn as_stored(access: Access, value: f64) -> f64 {
    match access {
        Access::Float32 => f64::from(value as f32),
        _ => value,
    }
}

impl Instance {
    /// From now on these variables alone, in order, may have values that are not finite.
    pub(crate) fn allow_nonfinite(&mut self, variables: Vec<usize>) {
        self.nonfinite = variables;
    }

    pub(crate) fn may_be_nonfinite(&self, variable: usize) -> bool {
        self.nonfinite.binary_search(&variable).is_ok()
    }

    /// As [`Instance::get`], for values that go on to other components.
    #[inline]
    pub(crate) fn get_finite(&self, batch: &Batch, values: &mut [f64], at: At) -> Result<()> {
        self.get(batch, values, at)?;
        self.check_read(batch, values, at)
    }

    /// Refuses values that were read and go on to other components.
    #[inline]
    pub(crate) fn check_read(&self, batch: &Batch, values: &[f64], at: At) -> Result<()> {
        match are_finite(values) {
            true => Ok(()),
            false => self.refuse(batch, values, at, ["became", "passes on"]),
        }
    }

    /// Refuses values that are to be set, before they are.
    pub(crate) fn check_given(&self, batch: &Batch, values: &[f64], at: At) -> Result<()> {
        let is_single = batch.access == Access::Float32;
        let fits = |value: &f64| as_stored(batch.access, *value).is_finite();
        match are_finite(values) && (!is_single || values.iter().all(fits)) {
            true => Ok(()),
            false => self.refuse(batch, values, at, ["would be set to", "is given"]),
        }
    }

    /// Refuses first time derivatives of variables, which are read or to be set.
    pub(super) fn check_derivatives(&self, batch: &Batch, values: &[f64], at: At) -> Result<()> {
        match are_finite(values) {
            true => Ok(()),
            false => self.refuse(batch, values, at, ["has the derivative", "has"]),
        }
    }

    /// Refuses the first value that is not finite, unless its variable may be so.
    #[cold]
    fn refuse(&self, batch: &Batch, values: &[f64], at: At, words: [&str; 2]) -> Result<()> {
        for (variable, value) in batch.variables.iter().zip(values) {
            let (is_number, stored) = (
                matches!(batch.access, Access::Real | Access::Float32),
                as_stored(batch.access, *value),
            );
            if stored.is_finite() || is_number && self.may_be_nonfinite(*variable) {
                continue;
            }
            let (name, [done, does]) = (self.variable_name(*variable), words);
            let too_large = match value.is_finite() {
                true => ", too large for a Float32",
                false => "",
            };
            let advice = match is_number {
                true => format!("; --allow-nonfinite {name} lets it have such values"),
                false => String::new(),
            };
            bail!(
                "`{name}` {done} {value:?}{too_large} {at}: what it {does} must be finite{advice} (FMU `{}`)",
                self.fmu.file
            );
        }
        Ok(())
    }

    /// Refuses a start value, or a value that a script or a page sets.
    pub(super) fn check_value(&self, variable: usize, value: &Value, text: &str) -> Result<()> {
        let access = self.fmu.description.variables[variable].access();
        let is_fit = match value {
            Value::Real(number) => as_stored(access, *number).is_finite(),
            _ => true,
        };
        if is_fit || self.may_be_nonfinite(variable) {
            return Ok(());
        }
        let name = self.variable_name(variable);
        bail!(
            "`{name}` = {text}: it must be a finite number; --allow-nonfinite {name} lets it have such values"
        )
    }

    fn variable_name(&self, variable: usize) -> String {
        let variable = &self.fmu.description.variables[variable];
        format!("{}.{}", self.name, variable.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_is_found_among_others() {
        let finite = [0.0, -0.0, 1.0, f64::MAX, f64::MIN, 5e-324, -1e-310];
        assert!(are_finite(&finite) && are_finite(&[]));
        for wrong in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for k in 0..finite.len() {
                let mut values = finite;
                values[k] = wrong;
                assert!(!are_finite(&values), "{wrong} at {k}");
            }
        }
    }
}
