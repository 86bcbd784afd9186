//! Random arguments of calls: if `valid`, ones that an FMU must accept; else anything that C's
//! types allow. For the modules of random calls; long and continued runs take start values from it.

use std::ffi::CString;

use fmi_description::{Access, Variable};
use fmi_import::Fmu;

use crate::random::Random;

const STRANGE: [f64; 12] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    1e300,
    -1e300,
    f64::MIN_POSITIVE,
    5e-324,
    -0.0,
    -1.0,
    1e9,
];

/// Any number, often a strange one.
pub fn real(r: &mut Random) -> f64 {
    match r.below(4) {
        0 => r.unit() * 2.0 - 1.0,
        1 => (r.unit() - 0.5) * 1e4,
        _ => r.of(&STRANGE),
    }
}

/// Seeds of directional derivatives.
pub fn seeds(r: &mut Random, n: usize, valid: bool) -> Vec<f64> {
    let one = |_| if valid { r.unit() } else { real(r) };
    (0..n).map(one).collect()
}

pub fn c_string(text: &str) -> CString {
    CString::new(text).expect("names have no NUL")
}

pub fn integer(r: &mut Random) -> i32 {
    r.of(&[0, 1, 2, 3, 4, 5, 7, -1, 100, i32::MIN, i32::MAX])
}

/// The start value of an element, 0 where it has none.
pub fn start(v: &Variable, element: usize) -> f64 {
    v.start_number_of(element).unwrap_or(0.0)
}

/// A value inside the bounds: near the start value of the element, anywhere, or on a bound.
fn inside(r: &mut Random, v: &Variable, element: usize) -> f64 {
    let ([min, max], start) = (v.bounds(), start(v, element));
    let value = match r.below(8) {
        0..4 => start * (0.5 + r.unit()) + 0.01 * (r.unit() - 0.5),
        4 if min.is_finite() && max.is_finite() => min + (max - min) * r.unit(),
        5 if min.is_finite() => min,
        6 if max.is_finite() => max,
        _ => start + 10.0 * (r.unit() - 0.5),
    };
    value.clamp(min, max)
}

/// A Real value for an element of a variable.
pub fn real_for(r: &mut Random, v: Option<&Variable>, element: usize, valid: bool) -> f64 {
    match v {
        Some(v) if valid || r.one_in(2) => inside(r, v, element),
        Some(v) if r.one_in(4) => {
            let [min, max] = v.bounds();
            r.of(&[min - min.abs() * 1e-9 - 1e-9, max + max.abs() * 1e-9 + 1e-9])
        }
        _ => real(r),
    }
}

/// A value of this type for an element of a variable, as text; unless `valid` it may be out of
/// bounds.
pub fn value_for(
    r: &mut Random,
    v: Option<&Variable>,
    access: Access,
    element: usize,
    valid: bool,
) -> String {
    let [least, most]: [i128; 2] = match access {
        Access::Real => return real_for(r, v, element, valid).to_string(),
        // Within bounds also after rounding.
        Access::Float32 if valid => {
            return ((real_for(r, v, element, true) * 0.999) as f32).to_string();
        }
        Access::Float32 => return (real_for(r, v, element, false) as f32).to_string(),
        Access::Boolean if valid => return r.one_in(2).to_string(),
        Access::Boolean => return r.of(&[0, 1, 2, 7, 100]).to_string(),
        Access::String => return r.of(&["", "a", "{}", "\u{e4}"]).to_string(),
        Access::Binary => return r.of(&["", "00", "ff00", "0123456789abcdef"]).to_string(),
        Access::Clock => return r.one_in(2).to_string(),
        Access::Int8 => [i8::MIN.into(), i8::MAX.into()],
        Access::UInt8 => [0, u8::MAX.into()],
        Access::Int16 => [i16::MIN.into(), i16::MAX.into()],
        Access::UInt16 => [0, u16::MAX.into()],
        Access::Integer => [i32::MIN.into(), i32::MAX.into()],
        Access::UInt32 => [0, u32::MAX.into()],
        Access::Int64 => [i64::MIN.into(), i64::MAX.into()],
        Access::UInt64 => [0, u64::MAX.into()],
    };
    let start = v
        .and_then(|v| v.start_of(element))
        .and_then(|start| start.parse().ok());
    let start: i128 = start.unwrap_or(0);
    let number = match r.one_in(2) {
        true => start + r.below(7) as i128 - 3,
        false => r.of(&[least, most, 0, 1, 2]),
    };
    let [min, max] = v.map_or([f64::NEG_INFINITY, f64::INFINITY], Variable::bounds);
    let fits = !valid || (min..=max).contains(&(number as f64));
    if fits { number } else { start }
        .clamp(least, most)
        .to_string()
}

/// For each value that these references stand for: its variable and its place in the variable's
/// array. An unknown reference counts as a scalar.
pub fn elements<'a>(
    fmu: &'a Fmu,
    vr: &'a [u32],
) -> impl Iterator<Item = (Option<&'a Variable>, usize)> {
    vr.iter().flat_map(|vr| {
        let found = fmu.find(*vr);
        (0..found.map_or(1, Variable::size)).map(move |k| (found, k))
    })
}

/// Value references: those of `wanted` variables if `valid`, else any, known or not.
pub fn references(
    r: &mut Random,
    fmu: &Fmu,
    valid: bool,
    wanted: impl Fn(&Variable) -> bool,
) -> Vec<u32> {
    let n = r.of(&[0, 1, 1, 1, 2, 3, 8]);
    let variables = &fmu.description.variables;
    let wanted = fmi_import::instance::references(variables, |v| valid && wanted(v));
    if valid && wanted.is_empty() {
        return Vec::new();
    }
    let one = |_| match valid {
        true => r.of(&wanted),
        false if r.one_in(16) => r.of(&[u32::MAX, 1 << 31, variables.len() as u32]),
        false => variables[r.below(variables.len())].reference,
    };
    (0..n).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmi_description::Description;

    /// On the committed model descriptions: a valid value lies inside the declared bounds, the rest
    /// leaves them now and then.
    #[test]
    fn valid_values_keep_to_the_bounds() {
        let mut r = Random::new(3);
        for text in [
            include_str!("../../../modelDescription/Emla.xml"),
            include_str!("../../../modelDescription/Hdrm.xml"),
            include_str!("../../../modelDescription/Controller.xml"),
            include_str!("../../../modelDescription/fmi3/Hdrm.xml"),
        ] {
            let description = Description::parse(text).unwrap();
            let mut outside = 0;
            let is_real_input = |v: &&Variable| v.is_input() && v.access() == Access::Real;
            for v in description.variables.iter().filter(is_real_input) {
                let [min, max] = v.bounds();
                assert!(min < max && max.is_finite(), "{}", v.name);
                for _ in 0..200 {
                    let value = real_for(&mut r, Some(v), 0, true);
                    assert!((min..=max).contains(&value), "{} = {value}", v.name);
                    let value = real_for(&mut r, Some(v), 0, false);
                    outside += u32::from(!(min..=max).contains(&value));
                }
            }
            assert!(outside > 100, "{outside}");
            let mode = description.variables.iter().find(|v| v.name == "mode");
            for _ in 0..20 {
                let item = value_for(&mut r, mode, Access::Integer, 0, true);
                let item: i32 = item.parse().unwrap();
                assert!(mode.is_none() || (1..=8).contains(&item), "{item}");
            }
        }
    }
}
