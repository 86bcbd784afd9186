//! Where a model stores the elements of a row (parameters, inputs or outputs), their type, and
//! typed access, for all of the crate. The macro `types!` makes all of it from one list of types.

use super::impl_copy::impl_copy;
use std::path::Path;
use std::slice;

/// The names of those types that the versions of FMI call differently.
pub(crate) struct TypeNames {
    pub(crate) real: &'static str,
    pub(crate) integer: &'static str,
    /// An Integer that is a size.
    pub(crate) size: &'static str,
    /// An Integer with an enumeration.
    pub(crate) enumeration: &'static str,
    /// The type as which an enumeration is set and read.
    pub(crate) enumeration_access: &'static str,
}

impl TypeNames {
    /// The names of FMI 2.0, which the constructors of rows use.
    pub(crate) const PLAIN: Self = Self {
        real: "Real",
        integer: "Integer",
        size: "Integer",
        enumeration: "Integer",
        enumeration_access: "Integer",
    };
}

impl Kind {
    /// Its name.
    pub(crate) fn name(self, names: &TypeNames) -> &'static str {
        match self {
            Kind::Real => names.real,
            Kind::Integer => names.integer,
            other => other.plain(),
        }
    }
}

/// A type in which rows store values.
pub(crate) trait StorageType: Sized {
    const KIND: Kind;

    fn into_any(self) -> AnyValue;

    fn input<P, U, Y>(storage: &Storage<P, U, Y>) -> Option<&Accessor<U, Self>>;
    fn parameter<P, U, Y>(storage: &Storage<P, U, Y>) -> Option<&Accessor<P, Self>>;
    fn output<P, U, Y>(storage: &Storage<P, U, Y>) -> Option<&Getter<Y, Self>>;
}

/// Defines the types of rows, with variants of [`Storage`] for inputs, parameters and outputs.
macro_rules! types {
    (($d:tt) $($(#[$doc:meta])* $kind:ident $type:ty: $input:ident $parameter:ident $output:ident;)*) => {
        /// Type of a row.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Kind {
            $($kind,)*
        }

        impl Kind {
            fn plain(self) -> &'static str {
                match self {
                    $(Kind::$kind => stringify!($kind),)*
                }
            }
        }

        /// Where the elements of a row are stored, and their type.
        pub(crate) enum Storage<P, U, Y> {
            $($input(Accessor<U, $type>), $parameter(Accessor<P, $type>), $output(Getter<Y, $type>),)*
            /// A String output that a function returns.
            TextOut(fn(&Y) -> &str),
            /// A String parameter whose setter may set other parameters, for example from a file.
            Text(fn(&P) -> &str, SetText<P>),
            /// The derivative of the state that the row is named after.
            Derivative,
            /// An event indicator.
            Indicator,
            /// A clock.
            Clock,
        }

        impl<P, U, Y> Storage<P, U, Y> {
            pub(crate) fn is_input(&self) -> bool {
                matches!(self, $(Storage::$input(_))|*)
            }

            /// Whether the row is a parameter without a setter that may set other parameters.
            pub(crate) fn is_parameter(&self) -> bool {
                matches!(self, $(Storage::$parameter(_))|*)
            }

            /// Its type.
            pub(crate) fn kind(&self) -> Kind {
                match self {
                    $(Storage::$input(_) | Storage::$parameter(_) | Storage::$output(_) => Kind::$kind,)*
                    Storage::TextOut(_) | Storage::Text(..) => Kind::String,
                    Storage::Derivative | Storage::Indicator => Kind::Real,
                    Storage::Clock => Kind::Boolean,
                }
            }
        }

        /// All values of a row.
        pub(crate) enum Values<'a> {
            $($kind(&'a [$type]),)*
        }

        /// All values of a row, mutable.
        pub(crate) enum ValuesMut<'a> {
            $($kind(&'a mut [$type]),)*
        }

        /// A value of any type.
        pub(crate) enum AnyValue {
            $($kind($type),)*
        }

        /// Evaluates `$then` with the typed slice in [`Values`] or [`ValuesMut`].
        macro_rules! each {
            ($d of:ident, $d values:expr, |$d at:pat_param| $d then:expr) => {
                match $d values {
                    $($crate::core::storage::$d of::$kind($d at) => $d then,)*
                }
            };
        }

        /// Evaluates `$then` with the type of a [`Kind`] as `$T`.
        macro_rules! typed {
            ($d kind:expr, $d T:ident => $d then:expr) => {
                match $d kind {
                    $($crate::core::storage::Kind::$kind => {
                        type $d T = $type;
                        $d then
                    })*
                }
            };
        }

        pub(crate) use {each, typed};

        /// The values of an input, a parameter or a computed row; None for other rows, and for
        /// texts that functions return.
        impl<P, U, Y> Storage<P, U, Y> {
            pub(crate) fn input_values<'a>(&self, u: &'a U) -> Option<Values<'a>> {
                match self {
                    $(Storage::$input(field) => Some(Values::$kind(field.slice(u))),)*
                    _ => None,
                }
            }

            pub(crate) fn input_values_mut<'a>(&self, u: &'a mut U) -> Option<ValuesMut<'a>> {
                match self {
                    $(Storage::$input(field) => Some(ValuesMut::$kind(field.slice_mut(u))),)*
                    _ => None,
                }
            }

            pub(crate) fn parameter_values<'a>(&self, p: &'a P) -> Option<Values<'a>> {
                match self {
                    $(Storage::$parameter(field) => Some(Values::$kind(field.slice(p))),)*
                    _ => None,
                }
            }

            pub(crate) fn parameter_values_mut<'a>(&self, p: &'a mut P) -> Option<ValuesMut<'a>> {
                match self {
                    $(Storage::$parameter(field) => Some(ValuesMut::$kind(field.slice_mut(p))),)*
                    _ => None,
                }
            }

            /// The values of a row of any causality.
            pub(crate) fn values<'a>(&self, p: &'a P, u: &'a U, y: &'a Y) -> Option<Values<'a>> {
                Some(match self {
                    $(
                        Storage::$input(field) => Values::$kind(field.slice(u)),
                        Storage::$parameter(field) => Values::$kind(field.slice(p)),
                        Storage::$output(field) => Values::$kind(field.slice(y)),
                    )*
                    _ => return None,
                })
            }

            pub(crate) fn output_values<'a>(&self, y: &'a Y) -> Option<Values<'a>> {
                match self {
                    $(Storage::$output(field) => Some(Values::$kind(field.slice(y))),)*
                    _ => None,
                }
            }

            /// Writes element `i` of a parameter; returns false for other rows and other types.
            pub(crate) fn put_parameter(&self, p: &mut P, i: usize, value: AnyValue) -> bool {
                match (self.parameter_values_mut(p), value) {
                    $((Some(ValuesMut::$kind(values)), AnyValue::$kind(value)) => values[i] = value,)*
                    _ => return false,
                }
                true
            }

            /// Copies element `i` of a parameter.
            pub(crate) fn copy_parameter(&self, i: usize, from: &P, to: &mut P) {
                match self {
                    $(Storage::$parameter(field) => *field.get_mut(to, i) = field.get(from, i),)*
                    _ => {}
                }
            }
        }

        $(impl StorageType for $type {
            const KIND: Kind = Kind::$kind;

            fn into_any(self) -> AnyValue {
                AnyValue::$kind(self)
            }

            #[inline]
            fn input<P, U, Y>(storage: &Storage<P, U, Y>) -> Option<&Accessor<U, Self>> {
                if let Storage::$input(field) = storage { Some(field) } else { None }
            }

            #[inline]
            fn parameter<P, U, Y>(storage: &Storage<P, U, Y>) -> Option<&Accessor<P, Self>> {
                if let Storage::$parameter(field) = storage { Some(field) } else { None }
            }

            #[inline]
            fn output<P, U, Y>(storage: &Storage<P, U, Y>) -> Option<&Getter<Y, Self>> {
                if let Storage::$output(field) = storage { Some(field) } else { None }
            }
        })*

        /// Accessors of a row of any type, to read and to write all its elements. Those of a scalar
        /// return a slice of one element.
        pub enum Fields<S> {
            $($(#[$doc])* $kind(fn(&S) -> &[$type], fn(&mut S) -> &mut [$type]),)*
        }

        impl<P, U, Y> Storage<P, U, Y> {
            pub(crate) const fn of_input(fields: Fields<U>) -> Self {
                match fields {
                    $(Fields::$kind(get, get_mut) => Storage::$input(Accessor::Vector(get, get_mut)),)*
                }
            }

            pub(crate) const fn of_parameter(fields: Fields<P>) -> Self {
                match fields {
                    $(Fields::$kind(get, get_mut) => Storage::$parameter(Accessor::Vector(get, get_mut)),)*
                }
            }

            pub(crate) const fn of_output(fields: Fields<Y>) -> Self {
                match fields {
                    $(Fields::$kind(get, _) => Storage::$output(Getter::Vector(get)),)*
                }
            }
        }
    };
}

types! { ($)
    /// Real of FMI 2.0, Float64 of FMI 3.0.
    Real f64: RealIn RealParameter RealOut;
    /// Integer of FMI 2.0, Int32 of FMI 3.0.
    Integer i32: IntegerIn IntegerParameter IntegerOut;
    /// Boolean.
    Boolean bool: BooleanIn BooleanParameter BooleanOut;
    /// Texts.
    String String: StringIn StringParameter StringOut;
    /// Float32; this type and all below are of FMI 3.0 only.
    Float32 f32: Float32In Float32Parameter Float32Out;
    /// 8-bit integers.
    Int8 i8: Int8In Int8Parameter Int8Out;
    /// 8-bit unsigned integers.
    UInt8 u8: UInt8In UInt8Parameter UInt8Out;
    /// 16-bit integers.
    Int16 i16: Int16In Int16Parameter Int16Out;
    /// 16-bit unsigned integers.
    UInt16 u16: UInt16In UInt16Parameter UInt16Out;
    /// 32-bit unsigned integers.
    UInt32 u32: UInt32In UInt32Parameter UInt32Out;
    /// 64-bit integers.
    Int64 i64: Int64In Int64Parameter Int64Out;
    /// 64-bit unsigned integers.
    UInt64 u64: UInt64In UInt64Parameter UInt64Out;
    /// Bytes.
    Binary crate::Binary: BinaryIn BinaryParameter BinaryOut;
}

/// Setter of a String parameter, see [`SetString`](crate::SetString).
pub(crate) type SetText<P> = fn(&mut P, &str, Option<&Path>) -> Result<(), String>;

/// Read access to a scalar or a vector in `S`.
pub(crate) enum Getter<S, T> {
    Scalar(fn(&S) -> &T),
    Vector(fn(&S) -> &[T]),
}

/// Read and write access to a scalar or a vector in `S`.
pub(crate) enum Accessor<S, T> {
    Scalar(fn(&S) -> &T, fn(&mut S) -> &mut T),
    Vector(fn(&S) -> &[T], fn(&mut S) -> &mut [T]),
}

impl_copy! {
    [P, U, Y] Storage<P, U, Y>;
    [S, T] Getter<S, T>;
    [S, T] Accessor<S, T>;
}

impl<P, U, Y> Storage<P, U, Y> {
    pub(crate) fn len(&self, p: &P, u: &U, y: &Y) -> usize {
        match self.values(p, u, y) {
            Some(values) => each!(Values, values, |values| values.len()),
            // A derivative has as many elements as its state, see `Layout::new`.
            None => usize::from(!self.is_derivative()),
        }
    }

    /// Whether the values are computed.
    pub(crate) fn is_computed(&self) -> bool {
        !(self.is_input() || self.is_parameter())
    }

    /// Whether the row is the derivative of a state.
    pub(crate) fn is_derivative(&self) -> bool {
        matches!(self, Storage::Derivative)
    }

    /// Whether the row is a derivative or an event indicator, for Model Exchange.
    pub(crate) fn is_equation(&self) -> bool {
        matches!(self, Storage::Derivative | Storage::Indicator)
    }

    /// Whether the row is a clock.
    pub(crate) fn is_clock(&self) -> bool {
        matches!(self, Storage::Clock)
    }

    /// Whether the elements are floating-point numbers, which have units and may be continuous.
    pub(crate) fn is_real(&self) -> bool {
        matches!(self.kind(), Kind::Real | Kind::Float32)
    }
}

impl<S, T: Clone> Getter<S, T> {
    /// All elements of the row.
    #[inline]
    pub(crate) fn slice<'a>(&self, s: &'a S) -> &'a [T] {
        match self {
            Getter::Scalar(get) => slice::from_ref(get(s)),
            Getter::Vector(get) => get(s),
        }
    }

    #[inline]
    pub(crate) fn get(&self, s: &S, i: usize) -> T {
        self.slice(s)[i].clone()
    }
}

impl<S, T: Clone> Accessor<S, T> {
    pub(crate) fn len(&self, s: &S) -> usize {
        self.slice(s).len()
    }

    /// All elements of the row.
    #[inline]
    pub(crate) fn slice<'a>(&self, s: &'a S) -> &'a [T] {
        match self {
            Accessor::Scalar(get, _) => slice::from_ref(get(s)),
            Accessor::Vector(get, _) => get(s),
        }
    }

    #[inline]
    pub(crate) fn get(&self, s: &S, i: usize) -> T {
        self.slice(s)[i].clone()
    }

    /// All elements of the row, mutable.
    #[inline]
    pub(crate) fn slice_mut<'a>(&self, s: &'a mut S) -> &'a mut [T] {
        match self {
            Accessor::Scalar(_, get_mut) => slice::from_mut(get_mut(s)),
            Accessor::Vector(_, get_mut) => get_mut(s),
        }
    }

    #[inline]
    pub(crate) fn get_mut<'a>(&self, s: &'a mut S, i: usize) -> &'a mut T {
        &mut self.slice_mut(s)[i]
    }
}
