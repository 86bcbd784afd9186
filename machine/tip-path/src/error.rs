//! Errors of reading or planning a path, for the crate's users; places on a path, for `check`.

use std::fmt;
use thiserror::Error;

/// Largest number of laps.
const LAPS_MAX: usize = 1000;

/// Why a path cannot be read or planned.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PathError {
    /// Neither JSON nor CSV, or not the structure of a path.
    #[error("{0}")]
    Format(String),
    /// An unknown field or column.
    #[error("{place}: `{name}` is unknown{}; it must be one of {}", near.as_ref().map_or(String::new(), |near| format!(", did you mean `{near}`?")), known.join(", "))]
    Unknown {
        /// Where in the file.
        place: String,
        /// The unknown name.
        name: String,
        /// The most similar known name.
        near: Option<String>,
        /// Known names.
        known: Vec<String>,
    },
    /// A value outside its range.
    #[error("{place}: `{name}` = {value} must be {rule}")]
    Value {
        /// Waypoint, sample or line.
        place: String,
        /// Field.
        name: String,
        /// Value.
        value: String,
        /// What must hold.
        rule: String,
    },
    /// Fewer than two waypoints or samples.
    #[error("a path has {count} {what}, it must have at least two")]
    TooFew {
        /// Their number.
        count: usize,
        /// Waypoints or samples.
        what: &'static str,
    },
    /// Two waypoints that are the same.
    #[error(
        "waypoints {first} and {} are the same; to rest there, give waypoint {first} a `dwell` and leave the other out",
        first + 1
    )]
    Same {
        /// The first of them, from 1.
        first: usize,
    },
    /// A waypoint whose time of arrival is too early.
    #[error(
        "waypoint {waypoint}: `time` = {time} s is too early: the tip leaves the waypoint before at {leaves:.3} s and needs {needs:.3} s within the path's limits of speed, \
         acceleration and jerk, so it must be at least {:.3} s", leaves + needs
    )]
    TooEarly {
        /// Counted from 1.
        waypoint: usize,
        /// Given time of arrival, s.
        time: f64,
        /// Time at which the tip leaves the previous waypoint, s.
        leaves: f64,
        /// Shortest time for the way, s.
        needs: f64,
    },
}

/// Where on a path the tip is at some time; waypoints count from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// On the way from the start to the first waypoint.
    Approach,
    /// At rest at a waypoint, or in its corner.
    At(usize),
    /// On the way from a waypoint to the next.
    Between(usize),
    /// On the way from a sample to the next.
    Samples(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Approach => write!(f, "between the start and waypoint 1"),
            Self::At(k) => write!(f, "at waypoint {k}"),
            Self::Between(k) => write!(f, "between waypoints {k} and {}", k + 1),
            Self::Samples(k) => write!(f, "between samples {k} and {}", k + 1),
        }
    }
}

pub(crate) fn refused(
    place: &str,
    name: &str,
    value: impl std::fmt::Display,
    rule: impl Into<String>,
) -> PathError {
    PathError::Value {
        place: place.to_owned(),
        name: name.to_owned(),
        value: value.to_string(),
        rule: rule.into(),
    }
}

pub(crate) fn unknown(place: &str, name: &str, known: Vec<String>) -> PathError {
    let near = machine_file::nearest(name, known.iter().map(String::as_str));
    PathError::Unknown {
        place: place.to_owned(),
        name: name.to_owned(),
        near: near.map(str::to_owned),
        known,
    }
}

/// The number of laps or cycles that `text` gives.
pub(crate) fn counted(
    place: &str,
    name: &str,
    number: f64,
    text: impl fmt::Display,
) -> Result<usize, PathError> {
    if number.fract() == 0.0 && (1.0..=LAPS_MAX as f64).contains(&number) {
        return Ok(number as usize);
    }
    let rule = format!("a whole number of {name} from 1 to {LAPS_MAX}");
    Err(refused(place, name, text, rule))
}
