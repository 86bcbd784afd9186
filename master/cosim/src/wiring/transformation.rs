//! Transformations of values between an output and an input (SSP 1.0), composed along a connection:
//! unit conversion, scaling and offset, mapping of values. Wires, start values and tables use them.

use anyhow::{Result, bail};
use fmi_description::{Description, Item, Kind, Unit, Variable};

use crate::structure::Hop;

/// `factor · value + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    pub factor: f64,
    /// Offset, in the unit of the result.
    pub offset: f64,
}

impl Linear {
    /// Leaves every value as it is.
    pub const NONE: Self = Self {
        factor: 1.0,
        offset: 0.0,
    };

    /// The transformed value.
    pub fn apply(&self, value: f64) -> f64 {
        self.factor * value + self.offset
    }

    /// This one, then `next`.
    fn then(&self, next: Self) -> Self {
        Self {
            factor: next.factor * self.factor,
            offset: next.apply(self.offset),
        }
    }
}

/// Transformation of a value between an output and an input.
#[derive(Clone, Debug, PartialEq)]
pub enum Transformation {
    /// Factor and offset, for Reals.
    Linear(Linear),
    /// Replacements for integers and Booleans; other values stay.
    Map(Vec<(f64, f64)>),
}

impl Transformation {
    /// Leaves every value as it is.
    pub const NONE: Self = Self::Linear(Linear::NONE);

    /// The transformed value.
    pub fn apply(&self, value: f64) -> f64 {
        match self {
            Self::Linear(linear) => linear.apply(value),
            Self::Map(entries) => {
                let found = entries.iter().find(|(source, _)| *source == value);
                found.map_or(value, |(_, target)| *target)
            }
        }
    }

    /// The transformed integer. A value that the map does not contain stays exactly as it is.
    pub fn apply_whole(&self, value: i128) -> i128 {
        let Self::Map(entries) = self else {
            return value;
        };
        let mut whole = entries.iter().map(|(s, t)| (*s as i128, *t as i128));
        let found = whole.find(|(source, _)| *source == value);
        found.map_or(value, |(_, target)| target)
    }

    /// The rate of change of the transformed value.
    pub fn apply_rate(&self, rate: f64) -> f64 {
        match self {
            Self::Linear(linear) => linear.factor * rate,
            Self::Map(_) => rate,
        }
    }

    /// The factor and offset; of a map, those that change nothing.
    pub fn linear(&self) -> Linear {
        match self {
            Self::Linear(linear) => *linear,
            Self::Map(_) => Linear::NONE,
        }
    }

    /// This one, then `next`.
    pub(crate) fn then(self, next: Self) -> Self {
        match (self, next) {
            (Self::Linear(a), Self::Linear(b)) => Self::Linear(a.then(b)),
            (a, Self::Linear(Linear::NONE)) => a,
            (Self::Linear(Linear::NONE), b) => b,
            (Self::Map(a), b) => {
                let mut entries: Vec<_> = a.iter().map(|(s, t)| (*s, b.apply(*t))).collect();
                if let Self::Map(b) = b {
                    entries.extend(b.into_iter().filter(|(s, _)| a.iter().all(|(k, _)| k != s)));
                }
                Self::Map(entries)
            }
            (Self::Linear(_), map @ Self::Map(_)) => map,
        }
    }
}

/// What the user can do about different units.
const UNIT_ADVICE: &str = "they are converted where both are defined with the same base units; where the numbers are right as they are, \
     or are made right by a LinearTransformation, the connection must say suppressUnitConversion=\"true\"";

/// The unit of a variable with its definition.
pub(crate) fn unit_of(description: &Description, variable: &Variable) -> Option<Unit> {
    let name = variable.unit.as_ref()?;
    Some(description.unit(name))
}

/// Conversion from the unit `a` to the unit `b`; None if their definitions do not allow it.
pub(crate) fn conversion(a: &Unit, b: &Unit) -> Option<Linear> {
    let is_same = (a.factor, a.offset, a.exponents) == (b.factor, b.offset, b.exponents);
    if a.name == b.name && (is_same || a.exponents.is_none() || b.exponents.is_none()) {
        return Some(Linear::NONE);
    }
    if a.exponents.is_none() || a.exponents != b.exponents {
        return None;
    }
    Some(Linear {
        factor: a.factor / b.factor,
        offset: (a.offset - b.offset) / b.factor,
    })
}

/// The transformations along a `way`, composed: from a variable with the unit `unit` to one with
/// the unit of the last hop. The variables give the items of their enumerations, and whether they
/// are differences, to which offsets of units do not apply. If only one end has a unit, nothing is
/// converted, and `single_unit` receives its name.
pub(crate) fn compose(
    way: &[Hop],
    unit: Option<Unit>,
    [from, to]: [Option<&Variable>; 2],
    single_unit: &mut Option<String>,
) -> Result<Transformation> {
    let (mut whole, mut unit) = (Transformation::NONE, unit);
    let is_relative = [from, to].into_iter().flatten().any(|v| v.is_relative);
    for hop in way {
        if let (Some(a), Some(b), false) = (&unit, &hop.unit, hop.keeps_units) {
            let Some(mut linear) = conversion(a, b) else {
                bail!(
                    "the units differ, `{}` and `{}`; {UNIT_ADVICE}",
                    a.name,
                    b.name
                );
            };
            if is_relative {
                linear.offset = 0.0;
            }
            whole = whole.then(Transformation::Linear(linear));
        }
        if let Some(transformation) = &hop.transformation {
            whole = whole.then(to_numbers(transformation, [from, to])?);
        }
        unit = match hop.keeps_units {
            true => hop.unit.clone(),
            false => hop.unit.clone().or(unit),
        };
    }
    let [first, last] = [from, to].map(|end| end.and_then(|v| v.unit.as_ref()));
    if let (Some(unit), None) | (None, Some(unit)) = (first, last)
        && unit != "1"
        && from.is_some() == to.is_some()
        && way.iter().all(|hop| !hop.keeps_units)
    {
        *single_unit = Some(unit.clone());
    }
    Ok(whole)
}

/// A transformation of the file in terms of numbers.
fn to_numbers(
    transformation: &system_structure::Transformation,
    [from, to]: [Option<&Variable>; 2],
) -> Result<Transformation> {
    use system_structure::Transformation as Of;
    let number = |on: bool| f64::from(u8::from(on));
    let whole = |k: i64| {
        let number = k as f64;
        if k.unsigned_abs() > 1 << f64::MANTISSA_DIGITS {
            bail!("a mapping names {k}; it must lie between -2^53 and 2^53");
        }
        Ok(number)
    };
    Ok(match transformation {
        &Of::Linear { factor, offset } => Transformation::Linear(Linear { factor, offset }),
        Of::Booleans(entries) => {
            let entry = |(s, t): &(bool, bool)| (number(*s), number(*t));
            Transformation::Map(entries.iter().map(entry).collect())
        }
        Of::Integers(entries) => {
            let entry = |(s, t): &(i64, i64)| Ok((whole(*s)?, whole(*t)?));
            Transformation::Map(entries.iter().map(entry).collect::<Result<_>>()?)
        }
        Of::Items(entries) => {
            let item = |variable: Option<&Variable>, name: &str| {
                let items: &[Item] = match variable.map(|v| &v.kind) {
                    Some(Kind::Enumeration(items)) => items,
                    _ => &[],
                };
                if let Some(item) = items.iter().find(|item| item.name == name) {
                    return whole(item.value);
                }
                let names: Vec<_> = items.iter().map(|item| item.name.as_str()).collect();
                bail!(
                    "EnumerationMappingTransformation: the enumeration has no item `{name}`, only {}",
                    names.join(", ")
                )
            };
            let entry = |(s, t): &(String, String)| Ok((item(from, s)?, item(to, t)?));
            Transformation::Map(entries.iter().map(entry).collect::<Result<_>>()?)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(name: &str, exponents: [i32; 8], factor: f64, offset: f64) -> Unit {
        Unit {
            name: name.into(),
            exponents: Some(exponents),
            factor,
            offset,
        }
    }

    /// 25 °C are 298.15 K, 3 mm are 0.003 m, 60 rpm are 2π rad/s; each back again.
    #[test]
    fn units_are_converted_by_their_definitions() {
        let (kelvin, length, rate) = (
            [0, 0, 0, 0, 1, 0, 0, 0],
            [0, 1, 0, 0, 0, 0, 0, 0],
            [0, 0, -1, 0, 0, 0, 0, 1],
        );
        let turn = std::f64::consts::TAU / 60.0;
        for (a, b, value, expected) in [
            (
                unit("°C", kelvin, 1.0, 273.15),
                unit("K", kelvin, 1.0, 0.0),
                25.0,
                298.15,
            ),
            (
                unit("mm", length, 1e-3, 0.0),
                unit("m", length, 1.0, 0.0),
                3.0,
                0.003,
            ),
            (
                unit("rpm", rate, turn, 0.0),
                unit("rad/s", rate, 1.0, 0.0),
                60.0,
                std::f64::consts::TAU,
            ),
        ] {
            let there = conversion(&a, &b).unwrap().apply(value);
            let back = conversion(&b, &a).unwrap().apply(expected);
            // Two rounded operations each.
            assert!(
                (there - expected).abs() <= 2.0 * f64::EPSILON * 300.0,
                "{there}"
            );
            assert!((back - value).abs() <= 2.0 * f64::EPSILON * 300.0, "{back}");
        }
        assert_eq!(
            conversion(&unit("m", length, 1.0, 0.0), &unit("K", kelvin, 1.0, 0.0)),
            None
        );
        assert_eq!(conversion(&Unit::named("m"), &Unit::named("V")), None);
        assert_eq!(
            conversion(&Unit::named("m"), &unit("m", length, 1.0, 0.0)),
            Some(Linear::NONE)
        );
    }

    #[test]
    fn transformations_follow_each_other() {
        let linear = |factor, offset| Transformation::Linear(Linear { factor, offset });
        let both = linear(2.0, 1.0).then(linear(3.0, -1.0));
        assert_eq!((both.apply(5.0), both.apply_rate(1.0)), (32.0, 6.0));
        let map = |entries: &[(f64, f64)]| Transformation::Map(entries.to_vec());
        let both = map(&[(1.0, 2.0)]).then(map(&[(2.0, 5.0), (3.0, 4.0), (1.0, 9.0)]));
        let values = [1.0, 2.0, 3.0, 7.0].map(|k| both.apply(k));
        assert_eq!(values, [5.0, 5.0, 4.0, 7.0]);
        assert_eq!(
            map(&[(1.0, 0.0)]).then(Transformation::NONE).apply(1.0),
            0.0
        );
        let whole = [1, i128::from(u64::MAX)].map(|k| map(&[(1.0, -2.0)]).apply_whole(k));
        assert_eq!(whole, [-2, i128::from(u64::MAX)]);
    }
}
