//! Units of fields: checks them for `check`, and finds those of derivatives for `rows`.

use crate::field::Field;
use fmi_units::{KNOWN_UNITS, Unit};
use syn::{Error, Result};

/// The unit with this name.
fn find(name: &str) -> Option<Unit> {
    Unit::find(name.to_owned().leak()) // a compiler's process ends soon
}

/// Checks that unit and display unit are known, and of one dimension.
pub(crate) fn check(field: &Field) -> Result<()> {
    let Some(name) = field.unit() else {
        return Ok(());
    };
    let (name, span) = (name.value(), name.span());
    let Some(unit) = find(&name) else {
        let text = format!(
            "unit `{name}` is no expression of units such as `m3/(s.Pa)`, `K/m` or `l/min`; define it, `const MINE: Unit = \
             Unit::new(\"{name}\")…;`, and write `unit = MINE`"
        );
        return Err(Error::new(span, text));
    };
    let Some(display) = &field.attributes.display_unit else {
        return Ok(());
    };
    if unit.shown_in(display.value().leak()).is_some() {
        return Ok(());
    }
    let usual = unit
        .display
        .iter()
        .map(|shown| format!("`{}`, ", shown.name));
    let text = format!(
        "`{}` is not a display unit of `{name}`; it may be {}or any unit of the same dimension",
        display.value(),
        usual.collect::<String>()
    );
    Err(Error::new(display.span(), text))
}

/// The name of the unit of the rate of change of values in a unit: a known one, or an expression.
pub(crate) fn per_second(name: &syn::LitStr) -> Option<String> {
    let name = name.value();
    let unit = find(&name)?;
    let mut exponents = unit.exponents;
    exponents[2] -= 1; // s
    let is_it = |rate: &Unit| {
        rate.exponents == exponents && rate.factor == unit.factor && rate.offset == 0.0
    };
    // The last: `1/s`, not `Hz`.
    if let Some(rate) = KNOWN_UNITS.iter().rev().find(|rate| is_it(rate)) {
        return Some(rate.name.to_owned());
    }
    let rate = match name.split_once('/') {
        None => format!("{name}/s"),
        Some((above, below)) => {
            let below = below
                .strip_prefix('(')
                .and_then(|rest| rest.strip_suffix(')'))
                .unwrap_or(below);
            format!("{above}/({below}.s)")
        }
    };
    find(&rate).filter(is_it).map(|_| rate)
}

#[cfg(test)]
mod tests {
    use super::per_second;

    #[test]
    fn rates_have_their_units() {
        let rate = |name| per_second(&syn::LitStr::new(name, proc_macro2::Span::call_site()));
        for (unit, expected) in [
            ("rad", "rad/s"),
            ("1", "1/s"),
            ("J", "W"),
            ("degC", "K/s"),
            ("A.h", "A.h/s"),
            ("Pa", "Pa/s"),
            ("m3", "m3/s"),
            ("1/K", "1/(K.s)"),
            ("m3/(s.Pa)", "m3/(s.Pa.s)"),
            ("l/min", "l/(min.s)"),
        ] {
            assert_eq!(rate(unit).as_deref(), Some(expected), "{unit}");
        }
        assert_eq!(rate("1/(m2/s)"), None);
        assert_eq!(rate("furlong"), None);
    }
}
