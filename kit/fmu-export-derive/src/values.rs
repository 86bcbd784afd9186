//! Numbers, start values, lengths and zeros in the code from `rows`, `state` and `structs`.

use crate::field::{Field, Kind, Shape};
use proc_macro2::TokenStream;
use quote::quote;
use syn::{Expr, ExprLit, Lit, LitFloat, Member};

/// A number as an f64: `2` becomes `2.0`.
pub(crate) fn real(value: &Expr) -> TokenStream {
    match value {
        Expr::Lit(ExprLit {
            lit: Lit::Int(lit), ..
        }) if lit.suffix().is_empty() => {
            let lit = LitFloat::new(&format!("{}.0", lit.base10_digits()), lit.span());
            quote!(#lit)
        }
        Expr::Unary(unary) => {
            let (op, value) = (&unary.op, real(&unary.expr));
            quote!(#op #value)
        }
        Expr::Array(array) => {
            let values = array.elems.iter().map(real);
            quote!([#(#values),*])
        }
        _ => quote!(#value),
    }
}

/// A start value of the field's type: a single number for an array is that of each element.
pub(crate) fn start_value(field: &Field, start: &Expr) -> TokenStream {
    let value = match field.kind {
        kind if kind.is_float() => real(start),
        kind if kind.is_heap() => each(start, &|start| quote!(::core::convert::From::from(#start))),
        Kind::Choice => {
            let ty = field.value();
            let choice = |start: &Expr| quote!(__fmu::FieldType::<#ty>::choice(#start));
            each(start, &choice)
        }
        _ => quote!(#start),
    };
    let is_of_each = match start {
        Expr::Lit(_) | Expr::Unary(_) => true,
        Expr::Path(_) => field.kind == Kind::Choice,
        _ => false,
    };
    match (&field.shape, start) {
        (Shape::Array(lengths), _) if is_of_each => filled(value, lengths, field.kind.is_heap()),
        // Another array, as a whole.
        (Shape::Array(_), start) if !matches!(start, Expr::Array(_)) => quote!(#start),
        _ => value,
    }
}

/// Converts each element of an array expression, or an expression that is not an array.
fn each(start: &Expr, convert: &dyn Fn(&Expr) -> TokenStream) -> TokenStream {
    match start {
        Expr::Array(array) => {
            let values = array.elems.iter().map(|start| each(start, convert));
            quote!([#(#values),*])
        }
        start => convert(start),
    }
}

/// Arrays with the same value everywhere.
fn filled(value: TokenStream, lengths: &[Expr], is_heap: bool) -> TokenStream {
    let wrap = |value, len| match is_heap {
        true => quote!(::core::array::from_fn::<_, { #len }, _>(|_| #value)),
        false => quote!([#value; #len]),
    };
    lengths.iter().rev().fold(value, wrap)
}

/// A `Vec` of `n` elements, each with the start value for its index `i`.
pub(crate) fn vector(field: &Field) -> TokenStream {
    let value = match &field.attributes.start {
        Some(start) => start_value(field, start),
        None => element(field),
    };
    quote! {{
        #[allow(unused_variables)]
        let start = |i: usize| #value;
        (0..n).map(start).collect::<::std::vec::Vec<_>>()
    }}
}

/// The number of elements of a `Vec`, where `p` are the parameters.
pub(crate) fn number(field: &Field) -> TokenStream {
    let lengths = &field.attributes.len;
    quote!(1 #(* ((#lengths) as usize))*)
}

/// A length in the table: a parameter's name if it is a field of `p`, else a number.
pub(crate) fn length(length: &Expr) -> TokenStream {
    match parameter(length) {
        Some(name) => quote!(::fmu_export::Length::Parameter(#name)),
        None => quote!(::fmu_export::Length::Fixed(#length)),
    }
}

fn parameter(expr: &Expr) -> Option<String> {
    let Expr::Field(field) = expr else {
        return None;
    };
    let Member::Named(member) = &field.member else {
        return None;
    };
    let member = crate::names::ident_text(member);
    match &*field.base {
        Expr::Path(path) if path.path.is_ident("p") => Some(member),
        base => Some(format!("{}.{member}", parameter(base)?)),
    }
}

/// The zero of a field's type.
pub(crate) fn zero(field: &Field) -> TokenStream {
    match &field.shape {
        Shape::Scalar => element(field),
        Shape::Array(_) if field.kind == Kind::Struct => {
            let zero = element(field);
            quote!(::core::array::from_fn(|_| #zero))
        }
        Shape::Array(lengths) => filled(element(field), lengths, field.kind.is_heap()),
        Shape::Vector => quote!(::std::vec::Vec::new()),
    }
}

/// The zero of an element of it.
pub(crate) fn element(field: &Field) -> TokenStream {
    match field.kind {
        Kind::Real | Kind::Other("Float32") => quote!(0.0),
        Kind::Other("Binary") => quote!(::core::default::Default::default()),
        Kind::Integer | Kind::Other(_) => quote!(0),
        Kind::Boolean => quote!(false),
        Kind::StaticText => quote!(""),
        Kind::Text | Kind::Choice => quote!(::core::default::Default::default()),
        Kind::Struct => {
            let ty = field.element();
            quote!(__fmu::FieldType::<#ty>::zero())
        }
    }
}
