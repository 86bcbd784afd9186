//! Checks the attributes of a field for `structs`: which are required, which the field's type and
//! role allow, and whether the start value is within the bounds.

use crate::errors::combined;
use crate::field::{Field, Kind, Role, Shape};
use crate::units;
use proc_macro2::Span;
use syn::{Error, Expr, ExprLit, ExprUnary, Lit, Result, UnOp};

/// All errors in a field, each with the span where it occurs.
pub(crate) fn check(field: &Field, role: Role) -> Result<()> {
    let mut wrong: Vec<Error> = Vec::new();
    let is_discrete = role == Role::State && field.attributes.has("discrete");
    let is_integrated = field.is_variable() && !is_discrete;
    if let Some(reason) = type_error(field.kind, role).filter(|_| is_integrated) {
        wrong.push(Error::new(syn::spanned::Spanned::span(&field.ty), reason));
    }
    for (key, span) in &field.attributes.keys {
        if let Some(reason) = key_error(key, field, role) {
            wrong.push(Error::new(*span, format!("`{key}`: {reason}")));
        }
    }
    wrong.extend(field.struct_count().err());
    if wrong.is_empty() {
        wrong.extend(missing_attribute(field, role).map(|text| Error::new(field.span(), text)));
        wrong.extend(bounds(field).err());
        wrong.extend(units::check(field).err());
    }
    combined(wrong.into_iter().map(Err))
}

/// Why a struct of this role cannot have a field of this type.
fn type_error(kind: Kind, role: Role) -> Option<&'static str> {
    match (kind, role) {
        (Kind::StaticText, Role::Parameter) => Some("a text parameter must be a String"),
        (Kind::StaticText, Role::Input | Role::State) => {
            Some("`&'static str` can only be an output")
        }
        (Kind::Real | Kind::Struct, _) => None,
        (_, Role::State) => Some(
            "a continuous state must be an f64, or an array or a Vec of f64; what only events change is `#[fmu(discrete)]`, what is no variable `#[fmu(skip)]`",
        ),
        _ => None,
    }
}

/// Why this field cannot have a key.
fn key_error(key: &str, field: &Field, role: Role) -> Option<String> {
    let (kind, attributes) = (field.kind, &field.attributes);
    let is_number = kind.is_number();
    let of = |what: &str| Some(format!("only {what} can have it"));
    match key {
        "name" => None,
        "skip" if matches!(role, Role::Parameter | Role::State) => None,
        "skip" => of("a parameter or a state"),
        "start" if role == Role::Output => Some("an output has no start value".to_owned()),
        "start" => None,
        _ if attributes.has("skip") => Some("a skipped field is not a variable".to_owned()),
        _ if kind == Kind::Struct => {
            Some("write it on the fields of the struct, which itself is not a variable; an enumeration is the field `Choice<…>`; aliases and `Box` are not known".to_owned())
        }
        "unit" | "display_unit" | "nominal" if !kind.is_float() => of("an f64 or f32"),
        "type" if kind != Kind::Real => of("an f64"),
        "mime_type" | "max_size" if kind != Kind::BINARY => of("a Binary"),
        "min" | "max" if !is_number => of("an f64, an f32 or an integer"),
        "tunable" if role != Role::Parameter || field.has_setter(role) => {
            of("a parameter that is not a String")
        }
        "len" if !matches!(field.shape, Shape::Vector) => {
            Some("only a Vec can have it; an array has its length in its type".to_owned())
        }
        "structural"
            if role != Role::Parameter
                || kind != Kind::Integer
                || !matches!(field.shape, Shape::Scalar) =>
        {
            of("an i32 among the parameters")
        }
        "tunable" if attributes.has("structural") => {
            Some("a structural parameter is set before initialization".to_owned())
        }
        "constant" if matches!(field.shape, Shape::Vector) => of("a number or an array"),
        "constant" if role != Role::Parameter || !(is_number || kind == Kind::Boolean) => {
            of("a number or a Boolean among the parameters")
        }
        "tunable" | "min" | "max" if attributes.has("constant") => {
            Some("a constant cannot be set".to_owned())
        }
        "discrete" if role == Role::State => None,
        "discrete" if !kind.is_float() || !matches!(role, Role::Input | Role::Output) => {
            of("a state, or an f64 or f32 that is an input or an output")
        }
        "clock" if role == Role::Parameter => of("an input, a state or an output"),
        "previous" if !attributes.has("clock") => {
            Some("write the clock too, `clock = …`".to_owned())
        }
        "previous" if role == Role::Input => of("a state or an output"),
        "not_in_evaluation" if role != Role::Input => of("an input"),
        "set" if !field.has_setter(role) => of("a String parameter"),
        "local" if !matches!(role, Role::Output | Role::State) => of("an output or a state"),
        "calculated" if role != Role::Output => of("a field of the outputs"),
        "calculated" if attributes.has("local") => Some("the variable is `local`".to_owned()),
        "rate_depends_on" if role != Role::State || attributes.has("discrete") => {
            of("a state that is integrated")
        }
        "depends_on" if role == Role::State && !attributes.has("clock") => Some("a state depends on no input".to_owned()),
        "depends_on" if !matches!(role, Role::Output | Role::State) => of("an output"),
        "depends_on" if attributes.has("calculated") => {
            Some("a calculated parameter does not depend on inputs".to_owned())
        }
        "depends_on" | "initially_depends_on" if attributes.has("local") => {
            of("an output that is not local")
        }
        "initially_depends_on" if !matches!(role, Role::Output | Role::State) => of("an output"),
        _ => None,
    }
}

/// A required attribute that is missing.
fn missing_attribute(field: &Field, role: Role) -> Option<String> {
    let attributes = &field.attributes;
    if !field.is_variable() || field.kind == Kind::Struct {
        return None;
    }
    let has_bounds = attributes.min.is_some() && attributes.max.is_some();
    let what = if field.description.is_empty() {
        "has no description: write a doc comment above the field"
    } else if matches!(field.shape, Shape::Vector) && attributes.len.is_empty() {
        "has no length: write `#[fmu(len = 5000)]`, or `len = p.n` with `n` a parameter that is `structural`"
    } else if attributes.has("structural") && !has_bounds {
        "is a size without bounds: write `min = 1, max = …`"
    } else if field.kind.is_float() && attributes.unit.is_none() && attributes.of_type.is_none() {
        "has no unit: write `#[fmu(unit = \"…\")]`, with \"1\" for a number without one"
    } else if role == Role::Parameter && !field.kind.is_heap() && attributes.start.is_none() {
        "has no start value: write `#[fmu(start = …)]`"
    } else {
        return None;
    };
    Some(format!("`{}` {what}", field.name))
}

/// Checks that the start value is within the bounds, if they are literal numbers.
fn bounds(field: &Field) -> Result<()> {
    let attributes = &field.attributes;
    let number = |expr: &Option<Expr>| expr.as_ref().and_then(number);
    let (min, max) = (number(&attributes.min), number(&attributes.max));
    let at = |expr: &Option<Expr>| -> Span {
        (expr.as_ref()).map_or_else(|| field.span(), syn::spanned::Spanned::span)
    };
    if let (Some(min), Some(max)) = (min, max)
        && min > max
    {
        let text = format!("max = {max} must be at least min = {min}");
        return Err(Error::new(at(&attributes.max), text));
    }
    let starts = match &attributes.start {
        Some(Expr::Array(array)) => array.elems.iter().collect(),
        Some(start) => vec![start],
        None => return Ok(()),
    };
    for expr in starts {
        let Some(start) = self::number(expr) else {
            continue;
        };
        let bound = match (min, max) {
            (Some(min), _) if start < min => format!("at least min = {min}"),
            (_, Some(max)) if start > max => format!("at most max = {max}"),
            _ => continue,
        };
        let text = format!("start = {start} must be {bound}");
        return Err(Error::new(syn::spanned::Spanned::span(expr), text));
    }
    Ok(())
}

/// The value of a literal number.
fn number(expr: &Expr) -> Option<f64> {
    match expr {
        Expr::Lit(ExprLit { lit, .. }) => match lit {
            Lit::Int(lit) => lit.base10_parse().ok(),
            Lit::Float(lit) => lit.base10_parse().ok(),
            _ => None,
        },
        Expr::Unary(ExprUnary {
            op: UnOp::Neg(_),
            expr,
            ..
        }) => number(expr).map(|value| -value),
        _ => None,
    }
}
