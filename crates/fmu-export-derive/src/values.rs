//! Values in the code that is written: numbers, start values, zeros.

use crate::field::{Field, Kind};
use proc_macro2::TokenStream;
use quote::quote;
use syn::{Expr, ExprLit, Lit, LitFloat};

/// A number as an f64: `2` is written `2.0` for the compiler.
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

/// A start value as the field needs it: a number for an array is that of each element.
pub(crate) fn start_value(field: &Field, start: &Expr) -> TokenStream {
    let value = match field.kind {
        Kind::Real => real(start),
        Kind::Text => return quote!(::core::convert::From::from(#start)),
        Kind::Choice => {
            let ty = &field.ty;
            return quote!(__fmu::Of::<#ty>::choice(#start));
        }
        _ => quote!(#start),
    };
    match (&field.len, start) {
        (Some(len), Expr::Lit(_) | Expr::Unary(_)) => quote!([#value; #len]),
        _ => value,
    }
}

/// The zero of a field's type.
pub(crate) fn zero(field: &Field) -> TokenStream {
    let zero = match field.kind {
        Kind::Real => quote!(0.0),
        Kind::Integer => quote!(0),
        Kind::Boolean => quote!(false),
        Kind::StaticText => quote!(""),
        Kind::Text | Kind::Choice => quote!(::core::default::Default::default()),
        Kind::Struct => {
            let ty = &field.ty;
            quote!(__fmu::Of::<#ty>::zero())
        }
    };
    match &field.len {
        Some(len) => quote!([#zero; #len]),
        None => zero,
    }
}
