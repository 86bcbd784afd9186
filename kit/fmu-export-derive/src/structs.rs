//! Generates all code for a struct with a derive: its rows, its start values, and the other traits
//! that a model's struct needs. The derive macros in `lib` call it.

use crate::attributes::fmu;
use crate::errors::combined;
use crate::field::{Field, Kind, Role, Shape};
use crate::values::{start_value, zero};
use crate::{check, rows, state};
use proc_macro2::{Span, TokenStream};
use quote::{format_ident, quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Attribute, Data, DeriveInput, Error, Fields, Ident, Result};

pub(crate) fn derive(input: &DeriveInput, role: Role) -> Result<TokenStream> {
    let ident = &input.ident;
    let mut fields = fields(input)?;
    let model = match role {
        Role::State => Some(state::Model::from_input(input)?),
        _ => None,
    };
    let table_only = match &model {
        Some(model) => model.table_only,
        None => is_table_only(&input.attrs)?,
    };
    if model.as_ref().is_some_and(|model| !model.is_whole()) {
        (fields.iter_mut()).for_each(|field| field.starts_elsewhere = true);
    }
    combined(fields.iter().map(|field| check::check(field, role)))?;
    let rows = rows::derive(ident, &fields, role);
    let kind = match role {
        Role::Parameter => start(ident, &fields, "Parameters"),
        Role::Input => start(ident, &fields, "Input"),
        Role::Output => quote!(impl __fmu::Output for #ident {}),
        Role::State => state::derive(ident, &fields, model.as_ref())?,
    };
    let skipped = fields.iter().filter(|field| !field.is_variable());
    let skipped = skipped.map(|field| {
        let ty = field.value();
        let has_start = role == Role::Parameter && field.attributes.start.is_some();
        let is_saved = format_ident!(
            "{}",
            if has_start {
                "is_saved"
            } else {
                "is_saved_default"
            }
        );
        quote_spanned!(ty.span()=> const _: () = __fmu::#is_saved::<#ty>();)
    });
    let skipped: TokenStream = skipped.collect();
    let data = if table_only {
        TokenStream::new()
    } else {
        data(ident, &fields, role)
    };
    Ok(quote! {
        #[automatically_derived]
        const _: () = {
            use ::fmu_export::derive as __fmu;
            #[allow(unused_imports)]
            use __fmu::Fallback as _;
            #rows
            #skipped
            #kind
            #data
        };
    })
}

fn fields(input: &DeriveInput) -> Result<Vec<Field>> {
    if !input.generics.params.is_empty() {
        let text = "a generic struct cannot have a table of variables";
        return Err(Error::new_spanned(&input.generics, text));
    }
    let fields = match &input.data {
        Data::Struct(data) => match &data.fields {
            Fields::Named(fields) => fields.named.iter().collect(),
            Fields::Unit => Vec::new(),
            Fields::Unnamed(fields) => {
                let text = "the fields must have names, which the variables get";
                return Err(Error::new_spanned(fields, text));
            }
        },
        _ => {
            let text = "must be a struct; an enumeration derives `Enumeration` and is the type of a field, Choice<…>";
            return Err(Error::new_spanned(&input.ident, text));
        }
    };
    let mut read = Vec::new();
    combined(fields.into_iter().map(|field| {
        read.push(Field::new(field)?);
        Ok(())
    }))?;
    Ok(read)
}

fn is_table_only(attributes: &[Attribute]) -> Result<bool> {
    let mut found = false;
    for attribute in fmu(attributes) {
        attribute.parse_nested_meta(|meta| {
            if meta.path.is_ident("table_only") {
                found = true;
                return Ok(());
            }
            Err(meta.error("unknown attribute; on this struct it must be table_only"))
        })?;
    }
    Ok(found)
}

/// Generates the function `start` with the start values.
fn start(ident: &Ident, fields: &[Field], kind: &str) -> TokenStream {
    let kind = Ident::new(kind, Span::call_site());
    let function = format_ident!("start_{}", kind.to_string().to_lowercase());
    let values = fields.iter().map(|field| {
        let member = &field.ident;
        let ty = field.element();
        let value = match (&field.attributes.start, field.kind) {
            (None, Kind::Struct) if field.is_variable() => {
                let start = quote!(__fmu::FieldType::<#ty>::#function());
                match field.shape {
                    Shape::Scalar => start,
                    _ => quote!(::core::array::from_fn(|_| #start)),
                }
            }
            _ if matches!(field.shape, Shape::Vector) => zero(field),
            (None, _) => zero(field),
            (Some(start), _) => start_value(field, start),
        };
        quote!(#member: #value)
    });
    quote! {
        impl __fmu::#kind for #ident {
            fn start() -> Self {
                Self { #(#values),* }
            }
        }
    }
}

/// Generates `Clone`, serde's traits, and except for parameters `Default`, and `Copy` if possible.
fn data(ident: &Ident, fields: &[Field], role: Role) -> TokenStream {
    let members: Vec<_> = fields.iter().map(|field| &field.ident).collect();
    let [copies, moves] = ["copied", "copied_to"].map(|function| {
        let function = Ident::new(function, Span::call_site());
        let types = fields.iter().map(|field| &field.ty);
        Vec::from_iter(types.map(|ty| quote!(__fmu::FieldType::<#ty>::#function)))
    });
    let mut impls = quote! {
        impl ::core::clone::Clone for #ident {
            #[inline]
            fn clone(&self) -> Self {
                Self { #(#members: #copies(&self.#members)),* }
            }

            #[inline]
            fn clone_from(&mut self, from: &Self) {
                #(#moves(&from.#members, &mut self.#members);)*
            }
        }
    };
    if role != Role::Parameter {
        let zeros = fields.iter().map(zero);
        // With a lifetime, the compiler accepts a bound that does not hold.
        let structs = (fields.iter()).filter(|field| field.kind == Kind::Struct);
        let structs = structs.map(|field| &field.ty);
        let is_heap = |field: &Field| matches!(field.shape, Shape::Vector) || field.kind.is_heap();
        if !fields.iter().any(is_heap) {
            impls.extend(quote! {
                impl ::core::marker::Copy for #ident where #(for<'a> #structs: ::core::marker::Copy),* {}
            });
        }
        impls.extend(quote! {
            impl ::core::default::Default for #ident {
                #[inline]
                fn default() -> Self {
                    Self { #(#members: #zeros),* }
                }
            }
        });
    }
    if role != Role::Output {
        impls.extend(serde(ident, fields));
    }
    impls
}

/// Generates serde's traits: fields as a tuple of tuples, as serde's tuples have 16 elements.
fn serde(ident: &Ident, fields: &[Field]) -> TokenStream {
    let groups: Vec<_> = fields.chunks(16).collect();
    let read = groups.iter().map(|group| {
        let members = group.iter().map(|field| {
            let member = &field.ident;
            match (field.kind, &field.shape) {
                (Kind::Struct, _) | (_, Shape::Scalar | Shape::Vector) => quote!(#member),
                (_, Shape::Array(_)) => quote!(__fmu::DeserializedArray(#member)),
            }
        });
        quote!((#(#members,)*))
    });
    let written = groups.iter().map(|group| {
        let values = group.iter().map(|field| {
            let (member, ty) = (&field.ident, &field.ty);
            match (field.kind, &field.shape) {
                (Kind::Struct, _) => quote!(__fmu::FieldType::<#ty>::written(&self.#member)),
                (_, Shape::Array(_)) => quote!(__fmu::SerializedArray(&self.#member)),
                _ => quote!(&self.#member),
            }
        });
        quote!((#(#values,)*))
    });
    let members = fields.iter().map(|field| {
        let (member, ty) = (&field.ident, &field.ty);
        match field.kind {
            Kind::Struct => quote!(#member: __fmu::FieldType::<#ty>::read(#member)),
            _ => quote!(#member),
        }
    });
    quote! {
        impl __fmu::serde::Serialize for #ident {
            fn serialize<S: __fmu::serde::Serializer>(&self, to: S) -> ::core::result::Result<S::Ok, S::Error> {
                __fmu::serde::Serialize::serialize(&(#(#written,)*), to)
            }
        }

        impl<'de> __fmu::serde::Deserialize<'de> for #ident {
            fn deserialize<D: __fmu::serde::Deserializer<'de>>(from: D) -> ::core::result::Result<Self, D::Error> {
                let (#(#read,)*) = __fmu::serde::Deserialize::deserialize(from)?;
                ::core::result::Result::Ok(Self { #(#members),* })
            }
        }
    }
}
