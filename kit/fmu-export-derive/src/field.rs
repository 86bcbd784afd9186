//! A struct's field as a variable (name, type, shape, attributes), for all derives of structs.

use crate::attributes::Attributes;
use crate::names;
use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::{
    Error, Expr, ExprLit, Field as SynField, GenericArgument, Ident, Lit, PathArguments, Result,
    Type, TypePath,
};

/// What the fields of a struct are: given by the derive.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    Parameter,
    Input,
    Output,
    State,
}

impl Role {
    /// The function that requires the derive of a struct in a field.
    pub(crate) fn requirement(self) -> Ident {
        let name = match self {
            Role::Parameter => "is_parameter",
            Role::Input => "is_input",
            Role::Output => "is_output",
            Role::State => "is_state",
        };
        Ident::new(name, Span::call_site())
    }
}

/// The type of a variable.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Real,
    Integer,
    Boolean,
    /// `String`.
    Text,
    /// `&'static str`.
    StaticText,
    Choice,
    /// Another type of FMI 3.0, by its name in `Fields`.
    Other(&'static str),
    /// A struct with variables of its own.
    Struct,
}

impl Kind {
    /// Whether an array of this type is a variable.
    fn has_arrays(self) -> bool {
        !matches!(self, Kind::StaticText | Kind::Struct)
    }

    /// Whether it has a unit, and may be continuous.
    pub(crate) fn is_float(self) -> bool {
        matches!(self, Kind::Real | Kind::Other("Float32"))
    }

    /// Whether it may have bounds, and may be a constant.
    pub(crate) fn is_number(self) -> bool {
        matches!(self, Kind::Real | Kind::Integer) || self.is_other() && self != Self::BINARY
    }

    /// Whether its values allocate.
    pub(crate) fn is_heap(self) -> bool {
        matches!(self, Kind::Text | Self::BINARY)
    }

    const BINARY: Self = Kind::Other("Binary");

    fn is_other(self) -> bool {
        matches!(self, Kind::Other(_))
    }
}

/// The shape of a field.
pub(crate) enum Shape {
    Scalar,
    /// An array or nested arrays: their lengths, the outermost first.
    Array(Vec<Expr>),
    /// A `Vec`, whose length is the attribute `len`.
    Vector,
}

/// A field of a struct with a derive.
pub(crate) struct Field {
    pub(crate) ident: Ident,
    /// Its name in the table.
    pub(crate) name: String,
    pub(crate) ty: Type,
    pub(crate) kind: Kind,
    pub(crate) shape: Shape,
    pub(crate) description: String,
    /// The struct is a part of a state, whose start value is given where the part is used.
    pub(crate) starts_elsewhere: bool,
    pub(crate) attributes: Attributes,
}

impl Field {
    pub(crate) fn new(field: &SynField) -> Result<Self> {
        let ident = field.ident.clone().expect("named fields only");
        let attributes = Attributes::from_field(field)?;
        let (kind, shape) = match kind(&field.ty) {
            // Of any type; serde has no arrays of more than 32 elements.
            Ok((kind, Shape::Array(lengths))) if attributes.has("skip") && kind.has_arrays() => {
                (kind, Shape::Array(lengths))
            }
            _ if attributes.has("skip") => (Kind::Struct, Shape::Scalar),
            found => found?,
        };
        let name = match &attributes.name {
            Some(name) => name.value(),
            None => names::ident_text(&ident),
        };
        Ok(Self {
            name,
            ident,
            ty: field.ty.clone(),
            kind,
            shape,
            description: names::description(&field.attrs),
            starts_elsewhere: false,
            attributes,
        })
    }

    pub(crate) fn span(&self) -> Span {
        self.ident.span()
    }

    /// The type of one element of an array.
    pub(crate) fn element(&self) -> &Type {
        match (&self.ty, &self.shape) {
            (Type::Array(array), Shape::Array(_)) => &array.elem,
            (ty, _) => ty,
        }
    }

    /// The type of one value in nested arrays or in a `Vec`.
    pub(crate) fn value(&self) -> &Type {
        let mut ty = &self.ty;
        while let Type::Array(array) = ty {
            ty = &array.elem;
        }
        match (ty, &self.shape) {
            (Type::Path(path), Shape::Vector) => vector_of(path).unwrap_or(ty),
            _ => ty,
        }
    }

    /// Whether it is a String parameter, which may have a setter that sets other parameters.
    pub(crate) fn has_setter(&self, role: Role) -> bool {
        let is_text = self.kind == Kind::Text && role == Role::Parameter;
        is_text && matches!(self.shape, Shape::Scalar)
    }

    /// The number of structs in an array of structs.
    pub(crate) fn struct_count(&self) -> Result<Option<usize>> {
        let (Kind::Struct, Shape::Array(lengths)) = (self.kind, &self.shape) else {
            return Ok(None);
        };
        let n = match &lengths[..] {
            [
                Expr::Lit(ExprLit {
                    lit: Lit::Int(n), ..
                }),
            ] => n.base10_parse().ok(),
            _ => None,
        };
        match n {
            Some(n @ 1..=32) => Ok(Some(n)),
            _ => Err(wrong(
                &self.ty,
                "the length of an array of structs must be a literal number, at most 32: each struct has its own rows",
            )),
        }
    }

    /// Whether it is one or more variables.
    pub(crate) fn is_variable(&self) -> bool {
        !self.attributes.has("skip")
    }
}

fn kind(ty: &Type) -> Result<(Kind, Shape)> {
    match ty {
        Type::Array(array) => {
            let mut lengths = vec![array.len.clone()];
            match kind(&array.elem)? {
                (kind, Shape::Scalar) if kind.has_arrays() || kind == Kind::Struct => {
                    Ok((kind, Shape::Array(lengths)))
                }
                (kind, Shape::Array(inner)) if kind.has_arrays() => {
                    lengths.extend(inner);
                    Ok((kind, Shape::Array(lengths)))
                }
                _ => Err(wrong(
                    ty,
                    "an array is of f64, f32, an integer, bool, String, Binary or Choice<…>, of arrays of one of them, or of structs",
                )),
            }
        }
        Type::Group(group) => kind(&group.elem),
        Type::Paren(paren) => kind(&paren.elem),
        Type::Reference(reference) => {
            let is_static = (reference.lifetime.as_ref()).is_some_and(|l| l.ident == "static");
            match &*reference.elem {
                Type::Path(path) if is_static && path.path.is_ident("str") => {
                    Ok((Kind::StaticText, Shape::Scalar))
                }
                _ => Err(wrong(
                    ty,
                    "a reference cannot be a variable, except `&'static str` as an output",
                )),
            }
        }
        Type::Path(path) => {
            let Some(last) = path.path.segments.last() else {
                return Ok((Kind::Struct, Shape::Scalar));
            };
            if let Some(element) = vector_of(path) {
                return match kind(element)? {
                    (kind, Shape::Scalar) if kind.has_arrays() => Ok((kind, Shape::Vector)),
                    _ => Err(wrong(
                        ty,
                        "a Vec is of f64, f32, an integer, bool, String, Binary or Choice<…>; a matrix is stored in one row by row, with `len = (2, 3)`",
                    )),
                };
            }
            let kind = named(ty, &last.ident.to_string(), &last.arguments)?;
            Ok((kind, Shape::Scalar))
        }
        _ => Err(wrong(
            ty,
            "this type cannot be a variable; it must be f64, f32, an integer, bool, String, Binary, Choice<…>, an array or a Vec of one of them, or a struct",
        )),
    }
}

/// The element type of a `Vec`; None for another type.
fn vector_of(path: &TypePath) -> Option<&Type> {
    let last = path.path.segments.last()?;
    if last.ident != "Vec" {
        return None;
    }
    match &last.arguments {
        PathArguments::AngleBracketed(list) => match list.args.first()? {
            GenericArgument::Type(element) => Some(element),
            _ => None,
        },
        _ => None,
    }
}

fn named(ty: &Type, name: &str, arguments: &PathArguments) -> Result<Kind> {
    match name {
        "f64" => Ok(Kind::Real),
        "i32" => Ok(Kind::Integer),
        "bool" => Ok(Kind::Boolean),
        "String" => Ok(Kind::Text),
        "Choice" if has_one_type(arguments) => Ok(Kind::Choice),
        "Option" => Err(wrong(
            ty,
            "a variable always has a value: use the type without Option, and a second field, a bool, that says whether it is valid",
        )),
        "f32" => Ok(Kind::Other("Float32")),
        "i8" => Ok(Kind::Other("Int8")),
        "u8" => Ok(Kind::Other("UInt8")),
        "i16" => Ok(Kind::Other("Int16")),
        "u16" => Ok(Kind::Other("UInt16")),
        "u32" => Ok(Kind::Other("UInt32")),
        "i64" => Ok(Kind::Other("Int64")),
        "u64" => Ok(Kind::Other("UInt64")),
        "Binary" => Ok(Kind::BINARY),
        "usize" | "isize" => Err(wrong(
            ty,
            "FMI has no such type: use i32 (`structural` for a size) or i64",
        )),
        "str" | "char" => Err(wrong(
            ty,
            "a text of FMI is a String; one that never changes may be a `&'static str` as an output",
        )),
        _ => Ok(Kind::Struct),
    }
}

fn has_one_type(arguments: &PathArguments) -> bool {
    match arguments {
        PathArguments::AngleBracketed(list) => {
            matches!(list.args.first(), Some(GenericArgument::Type(_))) && list.args.len() == 1
        }
        _ => false,
    }
}

fn wrong(ty: &Type, reason: &str) -> Error {
    Error::new(ty.span(), reason)
}
