//! A scalar variable (section 2.2.7).

use serde::Deserialize;

/// A scalar variable.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Name, unique in the FMU.
    pub name: String,
    /// What it means, empty where nothing is said.
    pub description: String,
    /// Value reference, unique among the variables with the same [`Access`].
    pub reference: u32,
    /// Type.
    pub kind: Kind,
    /// Role.
    pub causality: Causality,
    /// When its value may change.
    pub variability: Variability,
    /// How it gets its initial value, if that is said.
    pub initial: Option<Initial>,
    /// Start value as written.
    pub start: Option<String>,
    /// Least value allowed.
    pub min: Option<f64>,
    /// Greatest value allowed.
    pub max: Option<f64>,
    /// Order of magnitude of a Real.
    pub nominal: Option<f64>,
    /// Unit of a Real.
    pub unit: Option<String>,
    /// Unit in which people read a Real.
    pub display_unit: Option<String>,
}

/// Type of a variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `fmi2Real`.
    Real,
    /// `fmi2Integer`.
    Integer,
    /// `fmi2Boolean`.
    Boolean,
    /// `fmi2String`.
    String,
    /// `fmi2Integer` with named values.
    Enumeration(Vec<Item>),
}

/// A named value of an enumeration.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Item {
    /// Name.
    #[serde(rename = "@name")]
    pub name: String,
    /// Value.
    #[serde(rename = "@value")]
    pub value: i32,
}

/// The functions by which a variable is read and written: `fmi2GetReal` and `fmi2SetReal`, and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Access {
    /// Of a Real.
    Real,
    /// Of an Integer or an enumeration.
    Integer,
    /// Of a Boolean.
    Boolean,
    /// Of a String.
    String,
}

/// Role of a variable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Causality {
    /// Set before initialization, `tunable` ones also between steps.
    Parameter,
    /// Computed from parameters.
    CalculatedParameter,
    /// Given from outside.
    Input,
    /// Computed, for others to read.
    Output,
    /// Computed, for looking at.
    #[default]
    Local,
    /// Time.
    Independent,
}

/// When the value of a variable may change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Variability {
    /// Never.
    Constant,
    /// Not after initialization.
    Fixed,
    /// Between steps.
    Tunable,
    /// At events.
    Discrete,
    /// Always; only a Real can.
    #[default]
    Continuous,
}

/// How a variable gets its initial value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Initial {
    /// It is the start value.
    Exact,
    /// By an iteration that begins at the start value.
    Approx,
    /// From other variables.
    Calculated,
}

impl Kind {
    /// The functions that read and write it.
    pub fn access(&self) -> Access {
        match self {
            Self::Real => Access::Real,
            Self::Integer | Self::Enumeration(_) => Access::Integer,
            Self::Boolean => Access::Boolean,
            Self::String => Access::String,
        }
    }
}

impl Variable {
    /// The functions that read and write it.
    pub fn access(&self) -> Access {
        self.kind.access()
    }

    /// An input of any type.
    pub fn is_input(&self) -> bool {
        self.causality == Causality::Input
    }

    /// An output, or a local variable.
    pub fn is_computed(&self) -> bool {
        matches!(self.causality, Causality::Output | Causality::Local)
    }

    /// A parameter that may be set between steps.
    pub fn is_tunable(&self) -> bool {
        self.causality == Causality::Parameter && self.variability == Variability::Tunable
    }

    /// The start value of a Real, Integer or enumeration.
    pub fn start_number(&self) -> Option<f64> {
        self.start.as_deref()?.trim().parse().ok()
    }

    /// Least and greatest value allowed: infinite where nothing is said, the items of an enumeration.
    pub fn bounds(&self) -> [f64; 2] {
        let items = match &self.kind {
            Kind::Enumeration(items) => &items[..],
            _ => &[],
        };
        let values = || items.iter().map(|item| item.value);
        let least = values().min().map_or(f64::NEG_INFINITY, f64::from);
        let greatest = values().max().map_or(f64::INFINITY, f64::from);
        [self.min.unwrap_or(least), self.max.unwrap_or(greatest)]
    }
}
