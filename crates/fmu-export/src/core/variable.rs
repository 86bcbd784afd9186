//! Rows of the table of variables.
//!
//! A row is a scalar (`x`) or a vector (`x[1]`, `x[2]`, …). The value reference of an element is its running number across
//! the table, counted over all types, unless a row says where its elements begin.

use super::enumeration::{Enumeration, Items};
use crate::{Model, Unit};
use std::ops::RangeInclusive;
use std::path::Path;

/// In a list of initial dependencies: every parameter of the model.
pub const ALL_PARAMETERS: &str = "*parameters";

/// A row of the table: name, place in the model's structs, and what the model description says about it.
///
/// Constructors take (name, description, accessors). Singular ones (`input`, `integer_output` …) make a scalar, plural ones a
/// vector, whose length is that of the slice in the default values and must not change.
pub struct Variable<M: Model> {
    pub(crate) name: &'static str,
    pub(crate) description: &'static str,
    pub(crate) causality: Causality,
    pub(crate) place: Place<M>,
    /// `x`, not `x[1]`.
    pub(crate) scalar: bool,
    pub(crate) tunable: bool,
    pub(crate) discrete: bool,
    /// Not read by the model's [`Evaluation`](crate::Evaluation).
    pub(crate) beside_evaluation: bool,
    /// String setters read this parameter.
    pub(crate) read_by_texts: bool,
    /// Counts how often the importer has set this input.
    pub(crate) counter: Option<fn(&mut M::Input) -> &mut u32>,
    /// Value reference of the first element; None: the next one.
    pub(crate) at: Option<u32>,
    pub(crate) unit: Option<&'static str>,
    /// The definition of `unit`, where the row brings it along.
    pub(crate) own_unit: Option<&'static Unit>,
    /// Units element by element, where they differ.
    pub(crate) each_unit: &'static [&'static str],
    pub(crate) display_unit: Option<&'static str>,
    pub(crate) min: f64,
    pub(crate) max: f64,
    pub(crate) nominal: Option<f64>,
    pub(crate) enumeration: Option<Enumeration>,
    pub(crate) dependencies: Dependencies,
    pub(crate) initial_dependencies: Dependencies,
}

impl<M: Model> Clone for Variable<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Model> Copy for Variable<M> {}

/// Causality of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Causality {
    Input,
    Output,
    Local,
    Parameter,
    /// A function of parameters.
    CalculatedParameter,
    /// Always the same.
    Constant,
}

/// What the elements of a row depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Dependencies {
    /// Not said: on everything.
    Unknown,
    /// The same lists, one after the other, for each element (`[i]`: same index).
    Same([&'static [&'static str]; 2]),
    /// A list for each element.
    Each(&'static [&'static [&'static str]]),
}

/// Type of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Real,
    Integer,
    Boolean,
    String,
}

/// What a border calls the types.
pub(crate) struct Names {
    pub(crate) real: &'static str,
    pub(crate) integer: &'static str,
    pub(crate) boolean: &'static str,
    pub(crate) string: &'static str,
    /// An Integer with an enumeration.
    pub(crate) enumeration: &'static str,
    /// As what it is set and read.
    pub(crate) enumeration_access: &'static str,
}

impl Names {
    /// As the constructors of rows call them.
    pub(crate) const PLAIN: Self = Self {
        real: "Real",
        integer: "Integer",
        boolean: "Boolean",
        string: "String",
        enumeration: "Integer",
        enumeration_access: "Integer",
    };
}

impl Kind {
    /// Its name.
    pub(crate) fn name(self, names: &Names) -> &'static str {
        match self {
            Kind::Real => names.real,
            Kind::Integer => names.integer,
            Kind::Boolean => names.boolean,
            Kind::String => names.string,
        }
    }
}

/// Where the elements of a row live, and their type.
pub(crate) enum Place<M: Model> {
    RealIn(Write<M::Input, f64>),
    IntegerIn(Write<M::Input, i32>),
    BooleanIn(Write<M::Input, bool>),
    RealOut(Read<M::Output, f64>),
    IntegerOut(Read<M::Output, i32>),
    BooleanOut(Read<M::Output, bool>),
    StringOut(fn(&M::Output) -> &str),
    RealParameter(Write<M::Parameters, f64>),
    IntegerParameter(Write<M::Parameters, i32>),
    BooleanParameter(Write<M::Parameters, bool>),
    StringParameter(fn(&M::Parameters) -> &str, SetString<M>),
}

impl<M: Model> Clone for Place<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Model> Copy for Place<M> {}

/// Setter of a String parameter: parameters, text, the FMU's resources folder if the importer gave one.
pub type SetString<M> =
    fn(&mut <M as Model>::Parameters, &str, Option<&Path>) -> Result<(), String>;

/// Read access to a scalar or a vector in `S`.
pub(crate) enum Read<S, T> {
    Scalar(fn(&S) -> &T),
    Vector(fn(&S) -> &[T]),
}

/// Read and write access to a scalar or a vector in `S`.
pub(crate) enum Write<S, T> {
    Scalar(fn(&S) -> &T, fn(&mut S) -> &mut T),
    Vector(fn(&S) -> &[T], fn(&mut S) -> &mut [T]),
}

macro_rules! copied {
    ($($type:ident)*) => {$(
        impl<S, T> Clone for $type<S, T> {
            fn clone(&self) -> Self {
                *self
            }
        }

        impl<S, T> Copy for $type<S, T> {}
    )*};
}

copied! { Read Write }

macro_rules! writable_rows {
    ($($scalar:ident $vector:ident $what:literal $causality:ident $place:ident $owner:ident $type:ty;)*) => {$(
        #[doc = concat!("A scalar ", $what, ".")]
        pub const fn $scalar(
            name: &'static str,
            description: &'static str,
            get: fn(&M::$owner) -> &$type,
            get_mut: fn(&mut M::$owner) -> &mut $type,
        ) -> Self {
            Self::row(name, description, Causality::$causality, Place::$place(Write::Scalar(get, get_mut)), true)
        }

        #[doc = concat!("A vector ", $what, ".")]
        pub const fn $vector(
            name: &'static str,
            description: &'static str,
            get: fn(&M::$owner) -> &[$type],
            get_mut: fn(&mut M::$owner) -> &mut [$type],
        ) -> Self {
            Self::row(name, description, Causality::$causality, Place::$place(Write::Vector(get, get_mut)), false)
        }
    )*};
}

macro_rules! readable_rows {
    ($($scalar:ident $vector:ident $what:literal $causality:ident $place:ident $type:ty;)*) => {$(
        #[doc = concat!("A scalar ", $what, ".")]
        pub const fn $scalar(
            name: &'static str,
            description: &'static str,
            get: fn(&M::Output) -> &$type,
        ) -> Self {
            Self::row(name, description, Causality::$causality, Place::$place(Read::Scalar(get)), true)
        }

        #[doc = concat!("A vector ", $what, ".")]
        pub const fn $vector(
            name: &'static str,
            description: &'static str,
            get: fn(&M::Output) -> &[$type],
        ) -> Self {
            Self::row(name, description, Causality::$causality, Place::$place(Read::Vector(get)), false)
        }
    )*};
}

impl<M: Model> Variable<M> {
    writable_rows! {
        input inputs "Real input" Input RealIn Input f64;
        integer_input integer_inputs "Integer input" Input IntegerIn Input i32;
        boolean_input boolean_inputs "Boolean input" Input BooleanIn Input bool;
        parameter parameters "Real parameter" Parameter RealParameter Parameters f64;
        integer_parameter integer_parameters "Integer parameter" Parameter IntegerParameter Parameters i32;
        boolean_parameter boolean_parameters "Boolean parameter" Parameter BooleanParameter Parameters bool;
    }

    readable_rows! {
        output outputs "Real output" Output RealOut f64;
        integer_output integer_outputs "Integer output" Output IntegerOut i32;
        boolean_output boolean_outputs "Boolean output" Output BooleanOut bool;
        local locals "Real local variable (a field of `Output` that is not meant for wiring)" Local RealOut f64;
        integer_local integer_locals "Integer local variable" Local IntegerOut i32;
        boolean_local boolean_locals "Boolean local variable" Local BooleanOut bool;
        calculated_parameter calculated_parameters "Real parameter that is calculated of others, in [`Model::output`]" CalculatedParameter RealOut f64;
        integer_calculated_parameter integer_calculated_parameters "Integer parameter that is calculated of others" CalculatedParameter IntegerOut i32;
        boolean_calculated_parameter boolean_calculated_parameters "Boolean parameter that is calculated of others" CalculatedParameter BooleanOut bool;
        constant constants "Real constant; `|_| &9.80665` is the accessor of a number" Constant RealOut f64;
        integer_constant integer_constants "Integer constant" Constant IntegerOut i32;
        boolean_constant boolean_constants "Boolean constant" Constant BooleanOut bool;
    }

    /// A String output.
    pub const fn string_output(
        name: &'static str,
        description: &'static str,
        get: fn(&M::Output) -> &str,
    ) -> Self {
        let place = Place::StringOut(get);
        Self::row(name, description, Causality::Output, place, true)
    }

    /// A String parameter (fixed). `set` may read a file and replace every other parameter: afterwards the layer sets
    /// those again that the importer has set explicitly, so that the order of setting does not matter.
    pub const fn string_parameter(
        name: &'static str,
        description: &'static str,
        get: fn(&M::Parameters) -> &str,
        set: SetString<M>,
    ) -> Self {
        let place = Place::StringParameter(get, set);
        Self::row(name, description, Causality::Parameter, place, true)
    }

    const fn row(
        name: &'static str,
        description: &'static str,
        causality: Causality,
        place: Place<M>,
        scalar: bool,
    ) -> Self {
        Self {
            name,
            description,
            causality,
            place,
            scalar,
            tunable: false,
            discrete: false,
            beside_evaluation: false,
            read_by_texts: false,
            counter: None,
            at: None,
            unit: None,
            own_unit: None,
            each_unit: &[],
            display_unit: None,
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            nominal: None,
            enumeration: None,
            dependencies: Dependencies::Unknown,
            initial_dependencies: Dependencies::Unknown,
        }
    }

    /// A row without elements, in place of which another one is put.
    #[cfg(feature = "derive")]
    pub(crate) const NOTHING: Self = {
        let place = Place::RealOut(Read::Vector(|_| &[]));
        Self::row("", "", Causality::Local, place, false)
    };

    /// The value reference of the first element, at most 65535; further elements, and the rows below, follow on. A reference that is
    /// said does not move when a row is inserted above.
    pub const fn at(mut self, reference: u32) -> Self {
        self.at = Some(reference);
        self
    }

    /// Unit of a Real row, from [`KNOWN_UNITS`](crate::KNOWN_UNITS) or [`Info::units`](crate::Info::units).
    pub const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = Some(unit);
        self
    }

    /// Unit of a Real row that is neither known nor in [`Info::units`](crate::Info::units).
    pub const fn own_unit(mut self, unit: &'static Unit) -> Self {
        self.unit = Some(unit.name);
        self.own_unit = Some(unit);
        self
    }

    /// Like [`unit`](Self::unit), one for each element of a vector, e.g. of a wrench.
    pub const fn each_unit(mut self, units: &'static [&'static str]) -> Self {
        self.each_unit = units;
        self
    }

    /// Unit of element `i`.
    pub(crate) fn unit_of(&self, i: usize) -> Option<&'static str> {
        self.each_unit.get(i).copied().or(self.unit)
    }

    /// Unit that tools show; one of the unit's display units.
    pub const fn display_unit(mut self, unit: &'static str) -> Self {
        self.display_unit = Some(unit);
        self
    }

    /// Least value; a smaller one is refused when set.
    pub const fn min(mut self, min: f64) -> Self {
        self.min = min;
        self
    }

    /// Greatest value; a larger one is refused when set.
    pub const fn max(mut self, max: f64) -> Self {
        self.max = max;
        self
    }

    /// Least and greatest value, as [`min`](Self::min) and [`max`](Self::max).
    pub const fn range(self, values: RangeInclusive<f64>) -> Self {
        self.min(*values.start()).max(*values.end())
    }

    /// Typical magnitude (> 0).
    pub const fn nominal(mut self, nominal: f64) -> Self {
        self.nominal = Some(nominal);
        self
    }

    /// May be set between steps ([`Model::tune`] is told); without it a parameter is fixed after initialization. A calculated parameter
    /// is tunable if it is calculated of one that is.
    pub const fn tunable(mut self) -> Self {
        self.tunable = true;
        self
    }

    /// A Real input or output that changes at communication points only; without it a Real is continuous.
    pub const fn discrete(mut self) -> Self {
        self.discrete = true;
        self
    }

    /// An input that [`Evaluation::of`](crate::Evaluation::of) does not read: setting it keeps the evaluation.
    pub const fn beside_evaluation(mut self) -> Self {
        self.beside_evaluation = true;
        self
    }

    /// A parameter that setters of String parameters read: they find what the importer has set explicitly, in whatever order.
    pub const fn read_by_texts(mut self) -> Self {
        self.read_by_texts = true;
        self
    }

    /// A field of the inputs in which the sets of this input are counted, for a model to which setting it to the same value again
    /// means something. The count wraps around.
    pub const fn counted(mut self, counter: fn(&mut M::Input) -> &mut u32) -> Self {
        self.counter = Some(counter);
        self
    }

    /// Makes an Integer row an enumeration; values outside its items are refused.
    pub const fn enumeration(mut self, enumeration: &'static Enumeration) -> Self {
        self.enumeration = Some(*enumeration);
        self
    }

    /// As [`enumeration`](Self::enumeration), whose items stand for values of a type.
    pub const fn items<T, const N: usize>(mut self, items: &'static Items<T, N>) -> Self {
        self.enumeration = Some(items.enumeration());
        self
    }

    /// The inputs an output depends on directly (at fixed state): `"u"` the scalar or the whole vector, `"u[2]"` one element,
    /// `"u[i]"` the element with the output's own index; `&[]` none. An output that does not say depends on all.
    pub const fn depends_on(mut self, inputs: &'static [&'static str]) -> Self {
        self.dependencies = Dependencies::Same([inputs, &[]]);
        self
    }

    /// Like [`depends_on`](Self::depends_on), with a list for each element of a vector.
    pub const fn each_depends_on(mut self, inputs: &'static [&'static [&'static str]]) -> Self {
        self.dependencies = Dependencies::Each(inputs);
        self
    }

    /// The inputs AND parameters an output depends on in Initialization Mode (through [`Model::initialize`] too), written as in
    /// [`depends_on`](Self::depends_on); [`ALL_PARAMETERS`] stands for every parameter. Without it: on all, which lets an
    /// importer see an algebraic loop at initialization.
    pub const fn initially_depends_on(mut self, knowns: &'static [&'static str]) -> Self {
        self.initial_dependencies = Dependencies::Same([knowns, &[]]);
        self
    }

    /// After [`depends_on`](Self::depends_on): in Initialization Mode on the same inputs, and on these too. That is what an output
    /// depends on that the state at the start has no part in.
    pub const fn initially_also_on(mut self, knowns: &'static [&'static str]) -> Self {
        self.initial_dependencies = match self.dependencies {
            Dependencies::Same([inputs, _]) => Dependencies::Same([inputs, knowns]),
            _ => panic!("`initially_also_on` comes after `depends_on`"),
        };
        self
    }

    /// Like [`initially_depends_on`](Self::initially_depends_on), with a list for each element of a vector.
    pub const fn each_initially_depends_on(
        mut self,
        knowns: &'static [&'static [&'static str]],
    ) -> Self {
        self.initial_dependencies = Dependencies::Each(knowns);
        self
    }
}
