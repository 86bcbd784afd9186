//! What an FMU for Model Exchange must keep to before it is integrated: as many states and event
//! indicators as its description has, values that can be used, and derivatives that are only computed.

use anyhow::{Result, bail, ensure};

use super::plan::ExchangePlan;
use crate::raw::{ContinuousValues, RawInstance};
use crate::status::{OK, WARNING};

/// What stands where nothing was written: a NaN of its own.
const MARK: u64 = 0x7FF8_5EED_0BAD_F00D;
/// Values that are watched after the end of a vector.
pub(super) const BEYOND: usize = 64;

/// What of these values cannot be used, as text; makes all nominal values magnitudes, those of 0 to 1.
pub(super) fn unfit(
    plan: &ExchangePlan,
    x: &[f64],
    z: &[f64],
    nominal: &mut [f64],
) -> Option<String> {
    let name = |k: usize| &plan.names[k];
    let mut found = None;
    if let Some(k) = nominal.iter().position(|n| !n.is_finite()) {
        let (name, value) = (name(k), nominal[k]);
        found = Some(format!(
            "the nominal value of the state `{name}` is {value}; it must be finite"
        ));
    }
    for nominal in nominal {
        *nominal = if *nominal == 0.0 { 1.0 } else { nominal.abs() };
    }
    if let Some(k) = z.iter().position(|z| z.is_nan()) {
        found = Some(format!("event indicator {} is NaN", k + 1));
    }
    if let Some(k) = x.iter().position(|x| !x.is_finite()) {
        found = Some(format!("the state `{}` is {}", name(k), x[k]));
    }
    found
}

/// FMI 3.0: the library must have as many states and event indicators as the description.
pub(super) fn check_numbers(raw: &RawInstance, plan: &ExchangePlan) -> Result<()> {
    for (which, described, what) in [
        (ContinuousValues::States, plan.states, "continuous states"),
        (
            ContinuousValues::Indicators,
            plan.indicators,
            "event indicators",
        ),
    ] {
        let mut own = described;
        let is_known = matches!(raw.number_of(which, &mut own), OK | WARNING);
        ensure!(
            !is_known || own == described,
            "its library has {own} {what}, its description {described}"
        );
    }
    Ok(())
}

/// The vectors must have as many values as the description says, and reading derivatives and
/// indicators must leave the states as they are.
pub(super) fn check_vectors(raw: &RawInstance, plan: &ExchangePlan) -> Result<()> {
    let read = |which: ContinuousValues, n: usize| -> Result<Vec<f64>> {
        if n == 0 {
            return Ok(Vec::new()); // not every FMU takes an array of length 0
        }
        let call = raw.functions().name(which.function());
        let mut values = vec![f64::from_bits(MARK); n + BEYOND];
        let status = raw.get_continuous(which, Some(&mut values), n);
        if !matches!(status, OK | WARNING) {
            return Ok(Vec::new()); // an error is told where the values are needed
        }
        let is_kept = |value: &f64| value.to_bits() == MARK;
        let written = values
            .iter()
            .rposition(|v| !is_kept(v))
            .map_or(0, |k| k + 1);
        match values[..n].iter().position(is_kept) {
            _ if written > n => bail!("{call} writes {written} values; its description has {n}"),
            Some(k) => bail!("{call} writes no value {}; its description has {n}", k + 1),
            None => {}
        }
        values.truncate(n);
        Ok(values)
    };
    let before = read(ContinuousValues::States, plan.states)?;
    for (which, n) in [
        (ContinuousValues::Derivatives, plan.states),
        (ContinuousValues::Indicators, plan.indicators),
    ] {
        read(which, n)?;
        let after = read(ContinuousValues::States, plan.states)?;
        let mut all = before.iter().zip(&after).enumerate();
        if let Some((k, (a, b))) = all.find(|(_, (a, b))| a.to_bits() != b.to_bits()) {
            let call = raw.functions().name(which.function());
            bail!(
                "{call} changes the state `{}` from {a} to {b}; it must only compute",
                plan.names[k]
            );
        }
    }
    Ok(())
}
