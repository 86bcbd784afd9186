//! `#[derive(Enumeration)]`, called in `lib`: makes a Rust enumeration the type of a variable.

use crate::attributes::fmu;
use crate::errors::combined;
use crate::names;
use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Error, Fields, LitStr, Result, Variant};

pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let ident = &input.ident;
    let Data::Enum(data) = &input.data else {
        return Err(Error::new_spanned(ident, "must be an enum"));
    };
    if data.variants.is_empty() {
        return Err(Error::new_spanned(ident, "must have a variant"));
    }
    let name = names::ident_text(ident);
    let description = names::description(&input.attrs);
    if description.is_empty() {
        let text = format!("`{name}` has no description: write a doc comment above the enum");
        return Err(Error::new_spanned(ident, text));
    }
    let mut items = Vec::new();
    combined(data.variants.iter().map(|variant| {
        items.push(item(variant)?);
        Ok(())
    }))?;
    let variants: Vec<_> = data.variants.iter().map(|variant| &variant.ident).collect();
    let numbers = 1..=i32::try_from(variants.len()).expect("not so many");
    Ok(quote! {
        #[automatically_derived]
        impl ::fmu_export::derive::Item for #ident {
            const ENUMERATION: ::fmu_export::Enumeration =
                ::fmu_export::Enumeration::new(#name, #description, &[#(#items),*]);
            const ITEMS: &'static [Self] = &[#(Self::#variants),*];

            #[inline]
            fn number(self) -> i32 {
                match self {
                    #(Self::#variants => #numbers,)*
                }
            }
        }
    })
}

/// Name and description of an item.
fn item(variant: &Variant) -> Result<TokenStream> {
    if !matches!(variant.fields, Fields::Unit) {
        let text = "an item of an enumeration of FMI has no data";
        return Err(Error::new_spanned(&variant.fields, text));
    }
    if let Some((_, number)) = &variant.discriminant {
        let text = "items are numbered from 1 in the order of the variants";
        return Err(Error::new_spanned(number, text));
    }
    let mut name = names::ident_text(&variant.ident);
    for attribute in fmu(&variant.attrs) {
        attribute.parse_nested_meta(|meta| {
            if !meta.path.is_ident("name") {
                return Err(meta.error("unknown attribute; on a variant it must be name"));
            }
            name = meta.value()?.parse::<LitStr>()?.value();
            Ok(())
        })?;
    }
    let description = names::description(&variant.attrs);
    if description.is_empty() {
        let text = format!("`{name}` has no description: write a doc comment above the variant");
        return Err(Error::new_spanned(variant, text));
    }
    Ok(quote!((#name, #description)))
}
