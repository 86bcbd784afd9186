//! [`Value`]: a value of any type of FMI, also of those that an `f64` cannot represent (integers of
//! 64 bits, texts and bytes), for the master, which reads, passes on and prints them.
//!
//! ```
//! use fmi_description::Access;
//! use fmi_import::value::Value;
//!
//! let largest = Value::parse(Access::UInt64, "18446744073709551615").unwrap();
//! assert_eq!(largest.to_string(), "18446744073709551615");
//! ```

use std::ffi::CString;
use std::fmt;

use fmi_description::{Access, Kind, Variable};

/// A value of a variable.
#[derive(Debug, PartialEq)]
#[cfg_attr(feature = "master", derive(serde::Deserialize, serde::Serialize))]
pub enum Value {
    /// A floating-point number.
    Real(f64),
    /// An integer of any type, or a Boolean as 0 or 1.
    Whole(i128),
    /// A text.
    Text(CString),
    /// Bytes.
    Bytes(Vec<u8>),
}

/// Bytes are copied into the buffer that is there.
impl Clone for Value {
    fn clone(&self) -> Self {
        match self {
            Self::Real(number) => Self::Real(*number),
            Self::Whole(number) => Self::Whole(*number),
            Self::Text(text) => Self::Text(text.clone()),
            Self::Bytes(bytes) => Self::Bytes(bytes.clone()),
        }
    }

    fn clone_from(&mut self, other: &Self) {
        match (self, other) {
            (Self::Bytes(own), Self::Bytes(other)) => own.clone_from(other),
            (own, other) => *own = other.clone(),
        }
    }
}

impl Value {
    /// The value 0, or an empty text or no bytes.
    pub fn empty(access: Access) -> Self {
        match access {
            Access::Real | Access::Float32 => Self::Real(0.0),
            Access::String => Self::Text(CString::default()),
            Access::Binary => Self::Bytes(Vec::new()),
            _ => Self::Whole(0),
        }
    }

    /// Reads a number, `true` or `false` (Python's `True` and `False` too), a text, or bytes as
    /// hexadecimal digits; None if the type has no such value. As in XML, blanks and line ends
    /// around anything but a text do not count.
    pub fn parse(access: Access, text: &str) -> Option<Self> {
        let text = match access {
            Access::String => text,
            _ => text.trim_matches([' ', '\t', '\r', '\n']),
        };
        match access {
            Access::Real | Access::Float32 => text.parse().ok().map(Self::Real),
            Access::Boolean => match text {
                "true" | "True" | "1" => Some(Self::Whole(1)),
                "false" | "False" | "0" => Some(Self::Whole(0)),
                _ => None,
            },
            Access::String => CString::new(text).ok().map(Self::Text),
            Access::Binary => bytes(text).map(Self::Bytes),
            Access::Clock => None,
            _ => {
                let whole = text.parse().ok().filter(|k| fits(access, *k));
                whole.map(Self::Whole)
            }
        }
    }

    /// As [`Self::parse`], for the type of a variable; an enumeration item may be given by its
    /// name, and its number must be that of an item.
    ///
    /// # Errors
    /// What the text must be instead.
    pub fn parse_for(v: &Variable, text: &str) -> Result<Self, String> {
        let items = v.items();
        let item = items.iter().find(|item| item.name == text);
        let found = match item {
            Some(item) => Some(Self::Whole(item.value.into())),
            None => Self::parse(v.access(), text),
        };
        let is_item = |value: &Self| items.iter().any(|i| *value == Self::Whole(i.value.into()));
        let found = found.filter(|value| items.is_empty() || is_item(value));
        found.ok_or_else(|| match &v.kind {
            Kind::Real => "a number".into(),
            Kind::Integer => {
                let [least, most] = range(v.access());
                format!("a whole number from {least} to {most}")
            }
            Kind::Boolean => "true or false".into(),
            Kind::Enumeration(_) => {
                let names = items
                    .iter()
                    .map(|item| format!("{} ({})", item.name, item.value));
                format!("one of {}", Vec::from_iter(names).join(", "))
            }
            Kind::String => "a string without NUL characters".into(),
            Kind::Binary => "bytes, each as two hexadecimal digits".into(),
            Kind::Clock => "a value: a clock has no start value".into(),
        })
    }

    /// The 64 bits of a number: those of an `f64`, or of an integer of 64 bits; 0 for texts and
    /// bytes.
    pub fn bits(&self) -> u64 {
        match self {
            Self::Real(number) => number.to_bits(),
            Self::Whole(number) => *number as u64,
            Self::Text(_) | Self::Bytes(_) => 0,
        }
    }
}

/// The text that [`Value::parse`] reads.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Real(number) => write!(f, "{number}"),
            Self::Whole(number) => write!(f, "{number}"),
            Self::Text(text) => f.write_str(&text.to_string_lossy()),
            Self::Bytes(bytes) => bytes.iter().try_for_each(|byte| write!(f, "{byte:02X}")),
        }
    }
}

/// Whether an `f64` cannot represent the values of a type.
pub fn is_non_numeric(access: Access) -> bool {
    use Access::{Binary, Int64, String, UInt64};
    matches!(access, Int64 | UInt64 | String | Binary)
}

/// Whether this number is in the range of an integer type.
pub fn fits(access: Access, number: i128) -> bool {
    let [least, most] = range(access);
    (least..=most).contains(&number)
}

/// Smallest and largest value of an integer type.
fn range(access: Access) -> [i128; 2] {
    macro_rules! limits {
        ($($t:ty)*) => { [$(<$t>::MIN.into(), <$t>::MAX.into()),*] };
    }
    match access {
        Access::Int8 => limits!(i8),
        Access::UInt8 => limits!(u8),
        Access::Int16 => limits!(i16),
        Access::UInt16 => limits!(u16),
        Access::Integer => limits!(i32),
        Access::UInt32 => limits!(u32),
        Access::UInt64 => limits!(u64),
        _ => limits!(i64),
    }
}

/// Bytes from hexadecimal digits.
pub(crate) fn bytes(digits: &str) -> Option<Vec<u8>> {
    let digit = |d: u8| char::from(d).to_digit(16);
    let byte = |pair: &[u8]| match pair {
        [high, low] => u8::try_from(16 * digit(*high)? + digit(*low)?).ok(),
        _ => None,
    };
    digits.as_bytes().chunks(2).map(byte).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_written_as_they_are_read() {
        for (access, text) in [
            (Access::Int64, "-9223372036854775808"),
            (Access::UInt64, "18446744073709551615"),
            (Access::String, "a \"b\", ä"),
            (Access::Binary, "00FFA7"),
            (Access::Binary, ""),
            (Access::Real, "0.1"),
        ] {
            let read = Value::parse(access, text).unwrap();
            assert_eq!(read.to_string(), text);
            let blank = Value::parse(access, &format!("\r\n\t {text} \n")).unwrap();
            assert_eq!(blank == read, access != Access::String, "{access:?}");
        }
        for (access, text) in [
            (Access::Int64, "9223372036854775808"),
            (Access::UInt64, "-1"),
            (Access::Int8, "128"),
            (Access::Binary, "ABC"),
            (Access::Binary, "+1"),
            (Access::String, "a\0"),
            (Access::Clock, "true"),
        ] {
            assert_eq!(Value::parse(access, text), None, "{access:?} {text}");
        }
        assert_eq!(
            Value::parse(Access::UInt64, "18446744073709551615")
                .unwrap()
                .bits(),
            u64::MAX
        );
        assert_eq!(Value::Whole(-1).bits(), u64::MAX);
    }
}
