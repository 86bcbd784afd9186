//! What a derive generates in addition to its error messages, so that the compiler does not complain
//! about everything that a struct with a mistake then lacks. Called in `lib`; it never runs.

use crate::attributes::fmu;
use crate::field::Role;
use crate::structs::serde_impls;
use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Expr, Token, Type};

/// Traits for a struct of this role.
pub(crate) fn of_struct(input: &DeriveInput, role: Role) -> TokenStream {
    let (ident, Data::Struct(data)) = (&input.ident, &input.data) else {
        return TokenStream::new();
    };
    if !input.generics.params.is_empty() {
        return TokenStream::new();
    }
    let start = quote!(
        fn start() -> Self {
            ::core::unreachable!()
        }
    );
    let kind = match role {
        Role::Parameter => quote!(impl __fmu::Parameters for #ident { #start }),
        Role::Input => quote!(impl __fmu::Input for #ident { #start }),
        Role::Output => quote!(impl __fmu::Output for #ident {}),
        Role::State => of_state(input),
    };
    let serde = match role {
        Role::Output => TokenStream::new(),
        _ => serde_impls(
            ident,
            &quote!(::core::unreachable!()),
            &quote!(::core::unreachable!()),
        ),
    };
    let values = match role {
        Role::Parameter => TokenStream::new(),
        _ => {
            let types = data.fields.iter().map(|field| &field.ty);
            quote! {
                impl ::core::marker::Copy for #ident where #(for<'a> #types: ::core::marker::Copy),* {}
                impl ::core::default::Default for #ident { fn default() -> Self { ::core::unreachable!() } }
            }
        }
    };
    quote! {
        const _: () = {
            use ::fmu_export::derive as __fmu;
            impl<M: ::fmu_export::Model, At> __fmu::Rows<M, At> for #ident {
                const ROWS: &'static [__fmu::Part<M>] = &[];
            }
            impl ::core::clone::Clone for #ident { fn clone(&self) -> Self { ::core::unreachable!() } }
            #values
            #serde
            #kind
        };
    }
}

fn of_state(input: &DeriveInput) -> TokenStream {
    let ident = &input.ident;
    let [p, u, y] = parts(input);
    let whole = match (&p, &u, &y) {
        (None, None, None) => TokenStream::new(),
        _ => {
            let [p, u, y] = [p, u, y].map(|ty| ty.unwrap_or_else(|| syn::parse_quote!(())));
            quote! {
                impl __fmu::State for #ident {
                    type P = #p;
                    type U = #u;
                    type Y = #y;
                    const INFO: ::fmu_export::Info = ::fmu_export::Info::new("", "");
                    const MAX_STEP: f64 = 1.0;
                    const SOLVER: __fmu::SolverName = __fmu::SolverName::Fixed;
                    const TOLERANCE: f64 = 1.0;
                    const MODEL_EXCHANGE: bool = false;
                    const SCHEDULED_EXECUTION: bool = false;
                    fn start(_: &#p, _: &#u) -> Self { ::core::unreachable!() }
                    fn table() -> &'static [::fmu_export::Variable<Self>] { &[] }
                    fn derivatives() -> &'static [::fmu_export::Variable<Self>] { &[] }
                }
            }
        }
    };
    quote! {
        impl __fmu::Vector for #ident {
            fn len(&self) -> usize { 0 }
            fn read<'a>(&self, to: &'a mut [f64]) -> &'a mut [f64] { to }
            fn write<'a>(&mut self, from: &'a [f64]) -> &'a [f64] { from }
            fn not_finite(&self) -> ::core::option::Option<(&'static str, f64)> { ::core::option::Option::None }
        }
        impl __fmu::Output for #ident {}
        impl __fmu::StatePart for #ident {}
        #whole
    }
}

/// The types of parameters, inputs and outputs, as far as they can be read.
fn parts(input: &DeriveInput) -> [Option<Type>; 3] {
    let mut types = [None, None, None];
    for attribute in fmu(&input.attrs) {
        // What is wrong here has been told.
        let _ = attribute.parse_nested_meta(|meta| {
            let keys = ["parameters", "input", "output"];
            match keys.iter().position(|key| meta.path.is_ident(key)) {
                Some(k) => types[k] = Some(meta.value()?.parse()?),
                None if meta.input.peek(Token![=]) => {
                    meta.value()?.parse::<Expr>()?;
                }
                None if meta.input.peek(syn::token::Paren) => {
                    let content;
                    syn::parenthesized!(content in meta.input);
                    content.parse::<TokenStream>()?;
                }
                None => {}
            }
            Ok(())
        });
    }
    types
}

/// Traits for an enumeration.
pub(crate) fn of_enumeration(input: &DeriveInput) -> TokenStream {
    let (ident, generics) = (&input.ident, &input.generics.params);
    if !generics.is_empty() {
        return TokenStream::new();
    }
    quote! {
        impl ::fmu_export::derive::Item for #ident {
            const ENUMERATION: ::fmu_export::Enumeration = ::fmu_export::Enumeration::new("", "", &[]);
            const ITEMS: &'static [Self] = &[];
            fn number(self) -> i32 { 1 }
        }
    }
}
