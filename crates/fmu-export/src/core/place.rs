//! Where the elements of a row live in a model's structs, and their type.

use super::copied::copied;
use std::path::Path;
use std::slice;

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
    /// An Integer that is a size.
    pub(crate) size: &'static str,
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
        size: "Integer",
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
pub(crate) enum Place<P, U, Y> {
    RealIn(Write<U, f64>),
    IntegerIn(Write<U, i32>),
    BooleanIn(Write<U, bool>),
    RealOut(Read<Y, f64>),
    IntegerOut(Read<Y, i32>),
    BooleanOut(Read<Y, bool>),
    StringOut(fn(&Y) -> &str),
    RealParameter(Write<P, f64>),
    IntegerParameter(Write<P, i32>),
    BooleanParameter(Write<P, bool>),
    StringParameter(fn(&P) -> &str, SetText<P>),
    /// The derivative of the state that the row is named after, behind the table.
    Derivative,
    /// An event indicator, behind the table.
    Indicator,
}

/// Setter of a String parameter: parameters, text, the FMU's resources folder if the importer gave
/// one.
pub(crate) type SetText<P> = fn(&mut P, &str, Option<&Path>) -> Result<(), String>;

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

copied! {
    [P, U, Y] Place<P, U, Y>;
    [S, T] Read<S, T>;
    [S, T] Write<S, T>;
}

impl<P, U, Y> Place<P, U, Y> {
    pub(crate) fn len(&self, p: &P, u: &U, y: &Y) -> usize {
        match self {
            Place::RealIn(place) => place.len(u),
            Place::IntegerIn(place) => place.len(u),
            Place::BooleanIn(place) => place.len(u),
            Place::RealOut(place) => place.len(y),
            Place::IntegerOut(place) => place.len(y),
            Place::BooleanOut(place) => place.len(y),
            Place::RealParameter(place) => place.len(p),
            Place::IntegerParameter(place) => place.len(p),
            Place::BooleanParameter(place) => place.len(p),
            Place::StringParameter(..) | Place::StringOut(_) | Place::Indicator => 1,
            Place::Derivative => 0, // as many as the state has
        }
    }

    /// Its type.
    pub(crate) fn kind(&self) -> Kind {
        match self {
            Place::RealIn(_) | Place::RealOut(_) | Place::RealParameter(_) => Kind::Real,
            Place::Derivative | Place::Indicator => Kind::Real,
            Place::IntegerIn(_) | Place::IntegerOut(_) | Place::IntegerParameter(_) => {
                Kind::Integer
            }
            Place::BooleanIn(_) | Place::BooleanOut(_) | Place::BooleanParameter(_) => {
                Kind::Boolean
            }
            Place::StringParameter(..) | Place::StringOut(_) => Kind::String,
        }
    }

    /// Whether the row is the derivative of a state.
    pub(crate) fn is_derivative(&self) -> bool {
        matches!(self, Place::Derivative)
    }

    /// Whether the row is behind the table, of what is for Model Exchange.
    pub(crate) fn is_behind(&self) -> bool {
        matches!(self, Place::Derivative | Place::Indicator)
    }

    pub(crate) fn is_real(&self) -> bool {
        self.kind() == Kind::Real
    }
}

impl<S, T: Copy> Read<S, T> {
    fn len(&self, s: &S) -> usize {
        self.slice(s).len()
    }

    /// All elements of the row.
    #[inline]
    pub(crate) fn slice<'a>(&self, s: &'a S) -> &'a [T] {
        match self {
            Read::Scalar(get) => slice::from_ref(get(s)),
            Read::Vector(get) => get(s),
        }
    }

    #[inline]
    pub(crate) fn get(&self, s: &S, i: usize) -> T {
        self.slice(s)[i]
    }
}

impl<S, T: Copy> Write<S, T> {
    pub(crate) fn len(&self, s: &S) -> usize {
        self.slice(s).len()
    }

    /// All elements of the row.
    #[inline]
    pub(crate) fn slice<'a>(&self, s: &'a S) -> &'a [T] {
        match self {
            Write::Scalar(get, _) => slice::from_ref(get(s)),
            Write::Vector(get, _) => get(s),
        }
    }

    #[inline]
    pub(crate) fn get(&self, s: &S, i: usize) -> T {
        self.slice(s)[i]
    }

    /// All elements of the row, to write.
    #[inline]
    pub(crate) fn slice_mut<'a>(&self, s: &'a mut S) -> &'a mut [T] {
        match self {
            Write::Scalar(_, get_mut) => slice::from_mut(get_mut(s)),
            Write::Vector(_, get_mut) => get_mut(s),
        }
    }

    #[inline]
    pub(crate) fn get_mut<'a>(&self, s: &'a mut S, i: usize) -> &'a mut T {
        &mut self.slice_mut(s)[i]
    }
}
