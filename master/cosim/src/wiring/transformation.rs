//! Transformations of values between an output and an input (SSP 1.0), composed along a connection:
//! unit conversion, scaling and offset, mapping of values. Wires, start values and tables use them.

use anyhow::{Result, bail};
use fmi_description::{Description, Kind, Unit, Variable};

use system_structure::Transformation::Items as ItemsOf;

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
    /// Both kinds, one after the other.
    Chain(Vec<Self>),
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
            Self::Chain(all) => all.iter().fold(value, |value, next| next.apply(value)),
        }
    }

    /// The transformed integer. A value that the map does not contain stays exactly as it is.
    pub fn apply_whole(&self, value: i128) -> i128 {
        let entries = match self {
            Self::Linear(_) => return value,
            Self::Map(entries) => entries,
            Self::Chain(all) => return all.iter().fold(value, |k, next| next.apply_whole(k)),
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
            Self::Chain(all) => all.iter().fold(rate, |rate, next| next.apply_rate(rate)),
        }
    }

    /// Whether it, or a part of it, has a factor or an offset.
    pub fn has_linear(&self) -> bool {
        match self {
            Self::Linear(linear) => *linear != Linear::NONE,
            Self::Map(_) => false,
            Self::Chain(all) => all.iter().any(Self::has_linear),
        }
    }

    /// The factor and offset; where values are replaced one by one, those that change nothing.
    pub fn linear(&self) -> Linear {
        match self {
            Self::Linear(linear) => *linear,
            Self::Map(_) | Self::Chain(_) => Linear::NONE,
        }
    }

    /// This one, then `next`.
    pub(crate) fn then(self, next: Self) -> Self {
        match (self, next) {
            (Self::Linear(a), Self::Linear(b)) => Self::Linear(a.then(b)),
            (a, Self::Linear(Linear::NONE)) => a,
            (Self::Linear(Linear::NONE), b) => b,
            (Self::Map(a), Self::Map(b)) => {
                let is_new = |(s, _): &(f64, f64)| a.iter().all(|(k, _)| k != s);
                let others: Vec<_> = b.iter().copied().filter(is_new).collect();
                let next = Self::Map(b);
                let mut entries: Vec<_> = a.iter().map(|(s, t)| (*s, next.apply(*t))).collect();
                entries.extend(others);
                Self::Map(entries)
            }
            (a, b) => Self::Chain([a.into_parts(), b.into_parts()].concat()),
        }
    }

    fn into_parts(self) -> Vec<Self> {
        match self {
            Self::Chain(all) => all,
            one => vec![one],
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
    let mut names = None;
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
            whole = match transformation {
                // Only the names of the items between the first and the last mapping are known.
                ItemsOf(entries) if names.is_none() => {
                    let entries = through_names(way, entries, from);
                    let entries = names.insert(ItemsOf(entries));
                    whole.then(to_numbers(entries, [from, to])?)
                }
                ItemsOf(_) => whole,
                other => whole.then(to_numbers(other, [from, to])?),
            };
        }
        if let Transformation::Linear(Linear { factor, offset }) = whole
            && !(factor.is_finite() && offset.is_finite())
        {
            bail!(
                "its transformations together have the factor {factor} and the offset {offset}; both must be finite"
            );
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

/// The items that each item of the first of several mappings becomes by all of them, by name.
fn through_names(
    way: &[Hop],
    first: &[(String, String)],
    from: Option<&Variable>,
) -> Vec<(String, String)> {
    let lists = way.iter().filter_map(|hop| match &hop.transformation {
        Some(ItemsOf(entries)) => Some(entries),
        _ => None,
    });
    let last = |name: &str| {
        lists.clone().fold(name.to_string(), |name, entries| {
            let found = entries.iter().find(|(source, _)| *source == name);
            found.map_or(name, |(_, target)| target.clone())
        })
    };
    let items = from.map_or(&[][..], Variable::items);
    let is_item = |name: &String| items.iter().any(|item| item.name == *name);
    let mut all: Vec<&String> = first.iter().map(|(source, _)| source).collect();
    for (source, _) in lists.clone().flatten() {
        if is_item(source) && !all.contains(&source) {
            all.push(source);
        }
    }
    let entries = all.into_iter().map(|name| (name.clone(), last(name)));
    entries.collect()
}

/// A transformation of the file in terms of numbers.
fn to_numbers(
    transformation: &system_structure::Transformation,
    [from, to]: [Option<&Variable>; 2],
) -> Result<Transformation> {
    use system_structure::Transformation as Of;
    if let (Some(Kind::Real), Some(_)) = (from.map(|v| &v.kind), to)
        && !matches!(transformation, Of::Linear { .. })
    {
        bail!("a mapping from value to value is for integers, Booleans and items, not for Real");
    }
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
                let items = variable.map_or(&[][..], Variable::items);
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

    /// Random ways over several systems: whatever they are made of, the whole does what the parts do
    /// one after the other. Factors and offsets are such that nothing is rounded.
    #[test]
    fn the_whole_of_a_way_is_its_parts_one_after_the_other() {
        use system_structure::Transformation as Of;
        let mut state = 1u64;
        let mut below = |n: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % n
        };
        for case in 0..2000 {
            let hops = 1 + below(5);
            let way: Vec<Hop> = (0..hops)
                .map(|_| {
                    let transformation = match below(3) {
                        0 => None,
                        1 => Some(Of::Linear {
                            factor: [1.0, 2.0, -1.0, 4.0][below(4) as usize],
                            offset: below(4) as f64 - 1.0,
                        }),
                        _ => {
                            let target = |_| below(6) as i64;
                            let targets = [0, 1, 2].map(target);
                            Some(Of::Integers((0..).zip(targets).collect()))
                        }
                    };
                    Hop {
                        transformation,
                        ..Hop::default()
                    }
                })
                .collect();
            let whole = compose(&way, None, [None, None], &mut None).unwrap();
            for value in -2..7 {
                let mut expected = f64::from(value);
                for hop in &way {
                    expected = match &hop.transformation {
                        None => expected,
                        Some(Of::Linear { factor, offset }) => factor * expected + offset,
                        Some(Of::Integers(entries)) => {
                            let found = entries.iter().find(|(s, _)| *s as f64 == expected);
                            found.map_or(expected, |(_, t)| *t as f64)
                        }
                        Some(other) => panic!("{other:?}"),
                    };
                }
                let found = whole.apply(f64::from(value));
                assert_eq!(found, expected, "case {case}: {value} by {way:?}");
                if !whole.has_linear() {
                    assert_eq!(whole.apply_whole(value.into()) as f64, expected, "{way:?}");
                }
            }
        }
    }

    /// Items pass by name, also where those between two mappings have no numbers here.
    #[test]
    fn mappings_of_items_follow_each_other_by_name() {
        let of = |items: [&str; 3], first: i64| {
            let items: String = (first..)
                .zip(items)
                .map(|(k, name)| format!("<Item name=\"{name}\" value=\"{k}\"/>"))
                .collect();
            let text = format!(
                r#"<fmiModelDescription fmiVersion="2.0" modelName="M" guid="g"><CoSimulation modelIdentifier="M"/><TypeDefinitions>
                <SimpleType name="T"><Enumeration>{items}</Enumeration></SimpleType></TypeDefinitions><ModelVariables>
                <ScalarVariable name="e" valueReference="0"><Enumeration declaredType="T"/></ScalarVariable></ModelVariables><ModelStructure/>
                </fmiModelDescription>"#
            );
            Description::parse(&text).unwrap()
        };
        let [from, to] = [of(["a", "b", "c"], 1), of(["c", "b", "a"], 11)];
        let hop = |pairs: &[(&str, &str)]| Hop {
            transformation: Some(ItemsOf(
                (pairs.iter())
                    .map(|(s, t)| (s.to_string(), t.to_string()))
                    .collect(),
            )),
            ..Hop::default()
        };
        let ends = [Some(&from.variables[0]), Some(&to.variables[0])];
        // a -> between -> c, b -> b, c -> a: the numbers 1, 2, 3 become 11, 12, 13.
        let way = [
            hop(&[("a", "between"), ("b", "b")]),
            hop(&[("between", "c"), ("c", "a")]),
        ];
        let whole = compose(&way, None, ends, &mut None).unwrap();
        assert_eq!([1, 2, 3].map(|k| whole.apply_whole(k)), [11, 12, 13]);
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
