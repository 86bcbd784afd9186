//! [`Variable`]: a variable of a model description (FMI 2.0, section 2.2.7; FMI 3.0, section
//! 2.4.7), a scalar, an array or an element of one; importer, master, check and Python read it.

use std::sync::Arc;

/// Defines an enumeration with the words for its values in a model description.
macro_rules! words {
    (
        $(#[$attribute:meta])*
        pub enum $name:ident {
            $($(#[$of_value:meta])* $value:ident = $word:literal,)*
        }
    ) => {
        $(#[$attribute])*
        pub enum $name {
            $($(#[$of_value])* $value,)*
        }

        impl $name {
            pub(crate) const WORDS: &[(&str, Self)] = &[$(($word, Self::$value)),*];
        }
    };
}

/// A variable.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Name, unique in the FMU.
    pub name: String,
    /// Its description; empty if there is none.
    pub description: String,
    /// Value reference: in FMI 2.0 unique among the variables with the same [`Access`], in FMI 3.0
    /// among all but aliases; elements have that of their array.
    pub reference: u32,
    /// Lengths of an array of FMI 3.0, the last index runs fastest; empty for a scalar and for an
    /// element.
    pub dimensions: Vec<usize>,
    /// Place of an element in its array, counted from 0; None for scalars and arrays.
    pub element: Option<usize>,
    /// Type.
    pub kind: Kind,
    /// Role.
    pub causality: Causality,
    /// When its value may change.
    pub variability: Variability,
    /// How it gets its initial value, if that is declared.
    pub initial: Option<Initial>,
    /// Start values as written: none, one for all elements, or one for each.
    pub start: Vec<String>,
    /// Least value allowed.
    pub min: Option<f64>,
    /// Greatest value allowed.
    pub max: Option<f64>,
    /// Order of magnitude of a Real.
    pub nominal: Option<f64>,
    /// Unit of a Real.
    pub unit: Option<String>,
    /// Unit in which a Real is shown to users.
    pub display_unit: Option<String>,
    /// It is a difference, to which the offset of a unit does not apply (`relativeQuantity`).
    pub is_relative: bool,
    /// What the bytes of a Binary are, if that is declared (FMI 3.0).
    pub mime_type: Option<String>,
    /// Value references of the clocks at whose ticks it may change (FMI 3.0).
    pub clocks: Vec<u32>,
    /// The variable that it is the derivative of: by number from 1 in FMI 2.0, by value reference
    /// in FMI 3.0.
    pub derivative: Option<u32>,
    /// How a clock ticks (FMI 3.0).
    pub timing: Option<ClockTiming>,
    pub(crate) access: Access,
}

/// Type of a variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `fmi2Real`, `fmi3Float64`, `fmi3Float32`.
    Real,
    /// `fmi2Integer`, `fmi3Int8` to `fmi3UInt64`.
    Integer,
    /// A truth value.
    Boolean,
    /// A text.
    String,
    /// An integer with named values.
    Enumeration(Arc<[Item]>),
    /// Bytes (FMI 3.0).
    Binary,
    /// A clock (FMI 3.0).
    Clock,
}

impl Kind {
    /// Its name, as FMI 2.0 and SSP have it.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Real => "Real",
            Self::Integer => "Integer",
            Self::Boolean => "Boolean",
            Self::String => "String",
            Self::Enumeration(_) => "Enumeration",
            Self::Binary => "Binary",
            Self::Clock => "Clock",
        }
    }
}

/// When a clock ticks (FMI 3.0, section 2.4.7.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockTiming {
    /// `intervalVariability`.
    pub interval: ClockInterval,
    /// Time between ticks, s, if the description has it: `intervalDecimal`, else `intervalCounter`
    /// / `resolution`.
    pub period: Option<f64>,
    /// Delay of the first tick, s: `shiftDecimal`, else `shiftCounter` / `resolution`.
    pub shift: f64,
    /// Of clocks that tick at one time, the one with the least comes first. Of Scheduled Execution.
    pub priority: u64,
}

words! {
    /// `intervalVariability` of a clock.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ClockInterval {
        /// Periodic, known from the description.
        Constant = "constant",
        /// Periodic, known in Initialization Mode.
        Fixed = "fixed",
        /// Periodic, the period may change at events.
        Tunable = "tunable",
        /// The time to the next tick is known at each tick.
        Changing = "changing",
        /// The FMU says at events when it ticks next.
        Countdown = "countdown",
        /// No time determines its ticks.
        Triggered = "triggered",
    }
}

/// A named value of an enumeration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Item {
    /// Name.
    pub name: String,
    /// Value.
    pub value: i64,
}

words! {
    /// The functions by which a variable is read and written: `fmi2GetReal` and `fmi2SetReal`,
    /// `fmi3GetUInt8` and `fmi3SetUInt8`, and so on. The words are the tags of FMI 3.0.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum Access {
        /// `Real` of FMI 2.0, `Float64` of FMI 3.0.
        Real = "Float64",
        /// `Integer` of FMI 2.0, `Int32` of FMI 3.0.
        Integer = "Int32",
        /// A truth value: an int in FMI 2.0, a C bool in FMI 3.0.
        Boolean = "Boolean",
        /// A text.
        String = "String",
        /// `Float32`.
        Float32 = "Float32",
        /// `Int8`.
        Int8 = "Int8",
        /// `UInt8`.
        UInt8 = "UInt8",
        /// `Int16`.
        Int16 = "Int16",
        /// `UInt16`.
        UInt16 = "UInt16",
        /// `UInt32`.
        UInt32 = "UInt32",
        /// `Int64`, and enumerations of FMI 3.0.
        Int64 = "Int64",
        /// `UInt64`.
        UInt64 = "UInt64",
        /// `Binary`.
        Binary = "Binary",
        /// `Clock`.
        Clock = "Clock",
    }
}

words! {
    /// Role of a variable.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub enum Causality {
        /// Set before initialization, `tunable` ones also between steps.
        Parameter = "parameter",
        /// Decides how large arrays are (FMI 3.0).
        StructuralParameter = "structuralParameter",
        /// Computed from parameters.
        CalculatedParameter = "calculatedParameter",
        /// Given from outside.
        Input = "input",
        /// Computed, for others to read.
        Output = "output",
        /// Computed, for looking at.
        #[default]
        Local = "local",
        /// Time.
        Independent = "independent",
    }
}

words! {
    /// When the value of a variable may change.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub enum Variability {
        /// Never.
        Constant = "constant",
        /// Not after initialization.
        Fixed = "fixed",
        /// Between steps.
        Tunable = "tunable",
        /// At events.
        Discrete = "discrete",
        /// Always; only a Real can.
        #[default]
        Continuous = "continuous",
    }
}

words! {
    /// How a variable gets its initial value.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Initial {
        /// It is the start value.
        Exact = "exact",
        /// By an iteration that begins at the start value.
        Approx = "approx",
        /// From other variables.
        Calculated = "calculated",
    }
}

impl Access {
    /// Whether it is a number or a Boolean.
    pub fn is_number(self) -> bool {
        !matches!(self, Self::String | Self::Binary | Self::Clock)
    }
}

impl Variable {
    /// The functions that read and write it.
    pub fn access(&self) -> Access {
        self.access
    }

    /// Number of its values.
    pub fn size(&self) -> usize {
        self.dimensions.iter().product()
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

    /// The start value of a Real, Integer or enumeration; of an array that of its first element.
    pub fn start_number(&self) -> Option<f64> {
        self.start_number_of(0)
    }

    /// The start value of an element, counted from 0, as a number.
    pub fn start_number_of(&self, element: usize) -> Option<f64> {
        self.start_of(element)?.trim().parse().ok()
    }

    /// The start value of an element, counted from 0, as written.
    pub fn start_of(&self, element: usize) -> Option<&str> {
        let own = match self.start.as_slice() {
            [one] => Some(one),
            all => all.get(element),
        };
        own.map(String::as_str)
    }

    /// The items of an enumeration; none of other variables.
    pub fn items(&self) -> &[Item] {
        match &self.kind {
            Kind::Enumeration(items) => items,
            _ => &[],
        }
    }

    /// Smallest and largest value allowed: infinite if not declared, or those of the items of an
    /// enumeration.
    pub fn bounds(&self) -> [f64; 2] {
        let values = || self.items().iter().map(|item| item.value);
        let least = values().min().map_or(f64::NEG_INFINITY, |v| v as f64);
        let greatest = values().max().map_or(f64::INFINITY, |v| v as f64);
        [self.min.unwrap_or(least), self.max.unwrap_or(greatest)]
    }
}
