//! Constructors and attributes of [`Variable`], with which a model's author writes the rows of the
//! table, and the names of their elements.
//!
//! A row is a scalar (`x`) or a vector (`x[1]`, `x[2]`, …). The value reference of an element is
//! its running number in the table, over all types, unless the row sets that of its first element.

use super::causality::{Causality, Dependencies};
use super::enumeration::{Enumeration, Items};
use super::layout::state;
use super::length::Length;
use super::model::{Model, SetString, Variable};
use super::packed_file::PackedFile;
use super::setters::setters;
use super::storage::{Accessor, Fields, Getter, Storage, TypeNames};
use super::type_definition::TypeDefinition;
use fmi_units::Unit;
use std::ops::RangeInclusive;

macro_rules! writable_rows {
    ($($scalar:ident $vector:ident $what:literal $causality:ident $storage:ident $owner:ident $type:ty;)*) => {$(
        #[doc = concat!("A scalar ", $what, ".")]
        pub const fn $scalar(
            name: &'static str,
            description: &'static str,
            get: fn(&M::$owner) -> &$type,
            get_mut: fn(&mut M::$owner) -> &mut $type,
        ) -> Self {
            Self::row(name, description, Causality::$causality, Storage::$storage(Accessor::Scalar(get, get_mut)), true)
        }

        #[doc = concat!("A vector ", $what, ".")]
        pub const fn $vector(
            name: &'static str,
            description: &'static str,
            get: fn(&M::$owner) -> &[$type],
            get_mut: fn(&mut M::$owner) -> &mut [$type],
        ) -> Self {
            Self::row(name, description, Causality::$causality, Storage::$storage(Accessor::Vector(get, get_mut)), false)
        }
    )*};
}

macro_rules! readable_rows {
    ($($scalar:ident $vector:ident $what:literal $causality:ident $storage:ident $type:ty;)*) => {$(
        #[doc = concat!("A scalar ", $what, ".")]
        pub const fn $scalar(
            name: &'static str,
            description: &'static str,
            get: fn(&M::Output) -> &$type,
        ) -> Self {
            Self::row(name, description, Causality::$causality, Storage::$storage(Getter::Scalar(get)), true)
        }

        #[doc = concat!("A vector ", $what, ".")]
        pub const fn $vector(
            name: &'static str,
            description: &'static str,
            get: fn(&M::Output) -> &[$type],
        ) -> Self {
            Self::row(name, description, Causality::$causality, Storage::$storage(Getter::Vector(get)), false)
        }
    )*};
}

macro_rules! rows_of {
    ($($scalar:ident $vector:ident $what:literal $causality:ident $storage:ident $owner:ident;)*) => {$(
        #[doc = concat!("A scalar ", $what, " of any type.")]
        pub const fn $scalar(name: &'static str, description: &'static str, fields: Fields<M::$owner>) -> Self {
            Self::row(name, description, Causality::$causality, Storage::$storage(fields), true)
        }

        #[doc = concat!("A vector ", $what, " of any type.")]
        pub const fn $vector(name: &'static str, description: &'static str, fields: Fields<M::$owner>) -> Self {
            Self::row(name, description, Causality::$causality, Storage::$storage(fields), false)
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
        calculated_parameter calculated_parameters "Real parameter that is calculated from others, in [`Model::output`](crate::Model::output)" CalculatedParameter RealOut f64;
        integer_calculated_parameter integer_calculated_parameters "Integer parameter that is calculated from others" CalculatedParameter IntegerOut i32;
        boolean_calculated_parameter boolean_calculated_parameters "Boolean parameter that is calculated from others" CalculatedParameter BooleanOut bool;
        constant constants "Real constant; `|_| &9.80665` is the accessor of a number" Constant RealOut f64;
        integer_constant integer_constants "Integer constant" Constant IntegerOut i32;
        boolean_constant boolean_constants "Boolean constant" Constant BooleanOut bool;
    }

    rows_of! {
        input_of inputs_of "input" Input of_input Input;
        parameter_of parameters_of "parameter" Parameter of_parameter Parameters;
        output_of outputs_of "output" Output of_output Output;
        local_of locals_of "local variable" Local of_output Output;
        calculated_parameter_of calculated_parameters_of "parameter that is calculated of others" CalculatedParameter of_output Output;
        constant_of constants_of "constant" Constant of_output Output;
    }

    /// A String output.
    pub const fn string_output(
        name: &'static str,
        description: &'static str,
        get: fn(&M::Output) -> &str,
    ) -> Self {
        let storage = Storage::TextOut(get);
        Self::row(name, description, Causality::Output, storage, true)
    }

    /// A String parameter (fixed). `set` may read a file and set any other parameter; values that
    /// the importer has set explicitly override it, in whatever order they are set.
    pub const fn string_parameter(
        name: &'static str,
        description: &'static str,
        get: fn(&M::Parameters) -> &str,
        set: SetString<M>,
    ) -> Self {
        let storage = Storage::Text(get, set);
        Self::row(name, description, Causality::Parameter, storage, true)
    }

    /// The derivative `der(state)` of the scalar output or local variable `state`, for
    /// [`Continuous::derivative_rows`](crate::Continuous::derivative_rows). It
    /// [depends on](Self::depends_on) inputs and states, without a list on all.
    pub const fn derivative_of(state: &'static str) -> Self {
        let storage = Storage::Derivative;
        Self::row(state, "Time derivative", Causality::Local, storage, true)
    }

    /// The derivatives of the vector `state`.
    pub const fn derivatives_of(state: &'static str) -> Self {
        let storage = Storage::Derivative;
        Self::row(state, "Time derivative", Causality::Local, storage, false)
    }

    /// An event indicator, for [`Continuous::INDICATORS`](crate::Continuous::INDICATORS).
    pub const fn indicator(name: &'static str, description: &'static str) -> Self {
        let storage = Storage::Indicator;
        Self::row(name, description, Causality::Local, storage, true)
    }

    pub(super) const fn row(
        name: &'static str,
        description: &'static str,
        causality: Causality,
        storage: Storage<M::Parameters, M::Input, M::Output>,
        scalar: bool,
    ) -> Self {
        Self {
            name,
            description,
            causality,
            storage,
            scalar,
            shape: &[],
            resize: None,
            structural: false,
            tunable: false,
            discrete: false,
            clocks: &[],
            previous: None,
            not_in_evaluation: false,
            read_by_string_setters: false,
            packed_file: None,
            counter: None,
            at: None,
            unit: None,
            own_unit: None,
            rate_unit: None,
            each_unit: &[],
            display_unit: None,
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            nominal: None,
            enumeration: None,
            declared_type: None,
            aliases: &[],
            is_alias: false,
            mime_type: "",
            rate_of: None,
            rate_dependencies: None,
            dependencies: Dependencies::Unknown,
            initial_dependencies: Dependencies::Unknown,
        }
    }

    /// Whether it can be a continuous state.
    #[cfg(feature = "derive")]
    pub(crate) const fn is_continuous(&self) -> bool {
        matches!(self.storage, Storage::RealOut(_)) && !self.discrete
    }

    /// The derivative of this row.
    #[cfg(feature = "derive")]
    pub(crate) const fn derivative(&self) -> Self {
        let mut row = Self::derivative_of(self.name);
        row.scalar = self.scalar;
        row.unit = self.rate_unit;
        if let Some(knowns) = self.rate_dependencies {
            row.dependencies = Dependencies::Same(knowns);
        }
        row
    }

    /// A placeholder row without elements.
    #[cfg(feature = "derive")]
    pub(crate) const NOTHING: Self = {
        let storage = Storage::RealOut(Getter::Vector(|_| &[]));
        Self::row("", "", Causality::Local, storage, false)
    };

    setters! {
        /// The file that the start value of a String parameter stands for, and whose content is
        /// compiled in. Where the one in the FMU's `resources` folder differs, the setter is called
        /// with its path when an instance is made. Without this, a start value that names a file
        /// in that folder stands for it.
        packed_file(file: PackedFile) packed_file = Some(file);

        /// The value reference of the first element, at most 65535; its further elements and the
        /// rows below follow. It does not change when a row is inserted above.
        at(reference: u32) at = Some(reference);

        /// Unit of a Real row: any expression that [`Unit::find`] reads, such as `m3/(s.Pa)`, or one
        /// of [`Info::units`](crate::Info::units).
        unit(unit: &'static str) unit = Some(unit);

        /// Like [`unit`](Self::unit), one for each element of a vector, e.g. of a wrench.
        each_unit(units: &'static [&'static str]) each_unit = units;

        /// Unit in which tools show values; any of the same dimension.
        display_unit(unit: &'static str) display_unit = Some(unit);

        /// Minimum; a smaller value is refused when set.
        min(min: f64) min = min;

        /// Maximum; a larger value is refused when set.
        max(max: f64) max = max;

        /// Typical magnitude (> 0).
        nominal(nominal: f64) nominal = Some(nominal);

        /// The parameter may be set between steps, which calls [`Model::tune`](crate::Model::tune);
        /// else it is fixed after initialization. A calculated parameter is tunable if it is
        /// calculated from a tunable one.
        tunable() tunable = true;

        /// An Integer parameter that is a size: a structural parameter in FMI 3.0; in FMI 2.0 a
        /// constant that is chosen when the FMU is packed. It has bounds, with `min` at least 1.
        structural() structural = true;

        /// The dimensions of an array, stored row by row: `&[Length::Fixed(2), Length::Fixed(3)]`
        /// for a matrix. A row in a `Vec` has [`vector`](Self::vector) instead.
        shape(shape: &'static [Length]) shape = shape;

        /// A Real input or output that changes at communication points only; else it is continuous.
        discrete() discrete = true;

        /// The clocks by name at whose ticks alone it changes: a discrete variable.
        clocks(clocks: &'static [&'static str]) clocks = clocks;

        /// The variable, of the same type and discrete, that has the value of this clocked one at
        /// the tick before; the model sets it.
        previous(row: &'static str) previous = Some(row);

        /// An input that `Evaluation::new` does not read: setting it keeps the evaluation.
        not_in_evaluation() not_in_evaluation = true;

        /// A parameter that setters of String parameters read: they see the value that the importer
        /// has set explicitly, in whatever order.
        read_by_string_setters() read_by_string_setters = true;

        /// A field that counts how often this input was set, for a model that reacts to setting it
        /// to the same value again. The count wraps around.
        counted(counter: fn(&mut M::Input) -> &mut u32) counter = Some(counter);

        /// Makes an Integer row an enumeration; values outside its items are refused.
        enumeration(enumeration: &'static Enumeration) enumeration = Some(*enumeration);

        /// Further names of the row, each with a description: of FMI 3.0's `Alias`, and in FMI 2.0
        /// local variables with the same value references.
        aliases(names: &'static [(&'static str, &'static str)]) aliases = names;

        /// What the bytes of a Binary row are, `application/octet-stream` if it is not said.
        mime_type(mime_type: &'static str) mime_type = mime_type;

        /// Most bytes of a Binary row; more are refused when set.
        max_size(bytes: u32) max = bytes as f64;

        /// The inputs that an output depends on directly (at fixed state): `"u"` the scalar or the
        /// whole vector, `"u[2]"` one element, `"u[i]"` the element with the output's own index;
        /// `&[]` none. Without a list, an output depends on all inputs.
        ///
        /// For Model Exchange the list names states too; if it names none, the output depends on
        /// all of them, unless the list has [`NO_STATES`](crate::NO_STATES).
        depends_on(inputs: &'static [&'static str]) dependencies = Dependencies::Same(inputs);

        /// The row is the time derivative of this one of the same length, a velocity of a position:
        /// both Real inputs, or both Real outputs. An importer of Model Exchange may then let the
        /// input follow its derivative within a step.
        rate_of(row: &'static str) rate_of = Some(row);

        /// The unit of the derivative, if the row is a state of a model with derives.
        rate_unit(unit: &'static str) rate_unit = Some(unit);

        /// The dependencies of the derivative, if the row is a state of a model with derives.
        rate_depends_on(knowns: &'static [&'static str]) rate_dependencies = Some(knowns);

        /// Like [`depends_on`](Self::depends_on), with a list for each element of a vector.
        each_depends_on(inputs: &'static [&'static [&'static str]]) dependencies = Dependencies::Each(inputs);

        /// The inputs AND parameters that an output depends on in Initialization Mode, also through
        /// [`Model::initialize`](crate::Model::initialize), written as in
        /// [`depends_on`](Self::depends_on); [`ALL_PARAMETERS`](crate::ALL_PARAMETERS) stands for
        /// every parameter. Without a list it depends on all: importers may see algebraic loops.
        initially_depends_on(knowns: &'static [&'static str]) initial_dependencies = Dependencies::Same(knowns);

        /// Like `initially_depends_on`, with a list for each element of a vector.
        each_initially_depends_on(knowns: &'static [&'static [&'static str]]) initial_dependencies = Dependencies::Each(knowns);
    }

    /// Unit of a Real row that no expression says, and that is not in [`Info::units`](crate::Info::units).
    pub const fn own_unit(mut self, unit: &'static Unit) -> Self {
        self.unit = Some(unit.name);
        self.own_unit = Some(unit);
        self
    }

    /// The type of a Real row, which sets its unit, bounds and nominal value, as far as it has them.
    pub const fn of_type(mut self, definition: &'static TypeDefinition) -> Self {
        self.declared_type = Some(definition);
        if definition.unit.is_some() {
            self.unit = definition.unit;
        }
        if definition.display_unit.is_some() {
            self.display_unit = definition.display_unit;
        }
        if definition.nominal.is_some() {
            self.nominal = definition.nominal;
        }
        (self.min, self.max) = (definition.min, definition.max);
        self
    }

    /// Without the dependencies that a model within another model has, whose names are its own.
    #[cfg(feature = "derive")]
    #[doc(hidden)]
    pub const fn forget_own_names(mut self, is_forgotten: bool) -> Self {
        if is_forgotten {
            self.initial_dependencies = Dependencies::Unknown;
            self.rate_dependencies = None;
        }
        self
    }

    /// Unit of element `i`.
    pub(crate) fn unit_of(&self, i: usize) -> Option<&'static str> {
        self.each_unit.get(i).copied().or(self.unit)
    }

    /// Minimum and maximum, like [`min`](Self::min) and [`max`](Self::max).
    pub const fn range(self, values: RangeInclusive<f64>) -> Self {
        self.min(*values.start()).max(*values.end())
    }

    /// Like [`enumeration`](Self::enumeration), with items that stand for values of a Rust type.
    pub const fn items<T, const N: usize>(mut self, items: &'static Items<T, N>) -> Self {
        self.enumeration = Some(items.enumeration());
        self
    }

    /// After [`depends_on`](Self::depends_on): in Initialization Mode the output depends on the
    /// same inputs and also on these; for an output that does not depend on the initial state.
    pub const fn initially_also_on(mut self, knowns: &'static [&'static str]) -> Self {
        if !matches!(self.dependencies, Dependencies::Same(_)) {
            panic!("`initially_also_on` comes after `depends_on`");
        }
        self.initial_dependencies = Dependencies::Also(knowns);
        self
    }
}

impl<M: Model> Variable<M> {
    /// Name of an element: `x`, or `x[1]` for the first of a vector. In a matrix whose size is a
    /// parameter, elements are numbered consecutively.
    pub(crate) fn element_name(&self, index: usize) -> String {
        let fixed = |length: &Length| match *length {
            Length::Fixed(n) => Some(n),
            Length::Parameter(_) => None,
        };
        let dimensions: Option<Vec<_>> = self.lengths().iter().map(fixed).collect();
        self.name_in(&dimensions.unwrap_or_default(), index)
    }

    /// The same with these dimensions: `A[1,2]`.
    pub(crate) fn name_in(&self, dimensions: &[usize], index: usize) -> String {
        if self.scalar {
            return self.full_name();
        }
        let (mut rest, mut indices) = (index, String::new());
        for n in dimensions.iter().skip(1).rev() {
            indices = format!(",{}{indices}", rest % n + 1);
            rest /= n;
        }
        self.named(format!("{}[{}{indices}]", self.name, rest + 1))
    }

    /// The row by each of its further names.
    pub(crate) fn by_aliases(&self) -> impl Iterator<Item = Self> {
        (self.aliases.iter()).map(|&(name, description)| Self {
            name,
            description,
            is_alias: true,
            ..*self
        })
    }

    /// Further names of an element.
    pub(crate) fn alias_names(&self, i: usize) -> impl Iterator<Item = String> {
        self.by_aliases().map(move |row| row.element_name(i))
    }

    /// Name of the whole row.
    pub(crate) fn full_name(&self) -> String {
        self.named(self.name.to_owned())
    }

    fn named(&self, name: String) -> String {
        match self.storage {
            Storage::Derivative => format!("der({name})"),
            _ => name,
        }
    }

    /// The length of each dimension; a derivative has those of its state.
    pub(crate) fn lengths(&self) -> &'static [Length] {
        match self.storage {
            Storage::Derivative => state::<M>(self.name).map_or(&[], |state| state.shape),
            _ => self.shape,
        }
    }

    /// Type and causality for messages: `an Integer input`.
    pub(crate) fn kind(&self, names: &TypeNames) -> String {
        let causality = match self.causality {
            Causality::Input => "input",
            Causality::Output => "output",
            Causality::Local => "local variable",
            Causality::Parameter if self.structural => "structural parameter",
            Causality::Parameter if self.tunable => "tunable parameter",
            Causality::Parameter => "fixed parameter",
            Causality::CalculatedParameter => "calculated parameter",
            Causality::Constant => "constant",
        };
        let name = self.type_name(names);
        let article = if name.starts_with(['I', 'E', 'U']) {
            "an"
        } else {
            "a"
        };
        format!("{article} {name} {causality}")
    }

    /// Name of its type.
    pub(crate) fn type_name(&self, names: &TypeNames) -> &'static str {
        match self.enumeration {
            Some(_) => names.enumeration,
            None if self.structural => names.size,
            None if self.storage.is_clock() => "Clock",
            None => self.storage.kind().name(names),
        }
    }

    /// Name of the type by which it is set and read.
    pub(crate) fn access(&self, names: &TypeNames) -> &'static str {
        match self.enumeration {
            Some(_) => names.enumeration_access,
            None if self.structural => names.size,
            None if self.storage.is_clock() => "Clock",
            None => self.storage.kind().name(names),
        }
    }

    /// Smallest and largest allowed value, both finite, from `min`, `max` and the enumeration.
    pub(crate) fn bounds(&self) -> [f64; 2] {
        let [first, last] = match self.enumeration {
            Some(enumeration) => [1.0, enumeration.items.len() as f64],
            None => [f64::MIN, f64::MAX],
        };
        [self.min.max(first), self.max.min(last)]
    }
}
