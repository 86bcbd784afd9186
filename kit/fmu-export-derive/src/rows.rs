//! Generates a struct's rows of the table of variables (`impl Rows`); `structs` calls it.

use crate::field::{Field, Kind, Role, Shape};
use crate::units;
use crate::values::{element, length, real, start_value, vector};
use proc_macro2::{Delimiter, Span, TokenStream, TokenTree};
use quote::{format_ident, quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Expr, Ident, LitStr};

/// Generates `impl Rows` with the names and paths that it needs.
pub(crate) fn derive(ident: &Ident, fields: &[Field], role: Role) -> TokenStream {
    let owner = match role {
        Role::Parameter => quote!(Parameters),
        Role::Input => quote!(Input),
        Role::Output | Role::State => quote!(Output),
    };
    let fields: Vec<_> = fields.iter().filter(|field| field.is_variable()).collect();
    let names = fields.iter().map(|field| field.name.clone());
    let others = fields.iter().flat_map(|field| &field.attributes.aliases);
    let names = names.chain(others.map(LitStr::value));
    let mut at = fields.len();
    let further = fields
        .iter()
        .filter(|field| !field.attributes.aliases.is_empty());
    let further = further.map(|field| {
        let (from, description) = (at, &field.description);
        at += field.attributes.aliases.len();
        let (aliases, numbers) = (aliases(field), from..at);
        quote! {
            #[allow(non_upper_case_globals)]
            const #aliases: &'static [(&'static str, &'static str)] = &[#((Self::ALL[#numbers].text(), #description)),*];
        }
    });
    let parts = (fields.iter().enumerate()).flat_map(|(k, field)| parts(field, role, k));
    let checks = fields.iter().map(|field| match field.kind {
        Kind::Struct => {
            let (ty, is_there) = (field.element(), role.requirement());
            let mut checks =
                quote_spanned!(ty.span()=> const _: () = __fmu::#is_there::<#ty>(););
            if role == Role::State && field.attributes.start.is_none() && !field.starts_elsewhere {
                let text = format!(
                    "`{0}` is a model, whose start is not zero: write it, `#[fmu(start = Model::start(&p.{0}, &inputs))]`",
                    field.name
                );
                checks.extend(quote_spanned!(ty.span()=>
                    const _: () = ::core::assert!(!__fmu::FieldType::<#ty>::IS_MODEL, #text);
                ));
            }
            checks
        }
        _ => size(field),
    });
    let paths = (fields.iter())
        .filter(|field| field.kind == Kind::Struct)
        .map(|field| path(ident, field));
    quote! {
        /// __Names of the fields, where `At` leads to the struct.
        struct __Names<At>(::core::marker::PhantomData<At>);

        impl<At: __fmu::Path> __Names<At> {
            const ALL: &'static [__fmu::Name] = &[#(At::NAME.join(#names)),*];
            #(#further)*
        }

        #(#checks)*
        #(#paths)*

        impl<M, At> __fmu::Rows<M, At> for #ident
        where
            M: ::fmu_export::Model,
            At: __fmu::Path<From = M::#owner, To = #ident>,
        {
            const ROWS: &'static [__fmu::Part<M>] = {
                #[allow(unused_imports)]
                use __fmu::FallbackRows as _;
                &[#(#parts),*]
            };
        }
    }
}

/// Generates the path to the struct in a field.
fn path(ident: &Ident, field: &Field) -> TokenStream {
    let (path, member, ty, name) = (to(field), &field.ident, field.element(), &field.name);
    let (index, name) = match field.shape {
        Shape::Array(_) => (quote!([K]), quote!(At::NAME.join(#name).element(K))),
        _ => (quote!(), quote!(At::NAME.join(#name))),
    };
    quote! {
        /// The path to a nested struct, or to the one with this index in an array.
        #[allow(non_camel_case_types)]
        struct #path<At, const K: usize>(::core::marker::PhantomData<At>);

        impl<At: __fmu::Path<To = #ident>, const K: usize> __fmu::Path for #path<At, K> {
            type From = At::From;
            type To = #ty;
            const NAME: __fmu::Name = #name;

            #[inline]
            fn get(from: &At::From) -> &#ty {
                &At::get(from).#member #index
            }

            #[inline]
            fn get_mut(from: &mut At::From) -> &mut #ty {
                &mut At::get_mut(from).#member #index
            }
        }
    }
}

/// The constant with the further names of a field.
fn aliases(field: &Field) -> Ident {
    format_ident!("aliases_of_{}", crate::names::ident_text(&field.ident))
}

fn to(field: &Field) -> Ident {
    format_ident!("To_{}", crate::names::ident_text(&field.ident))
}

/// The parts of the table for a field: a row, or the rows of one or more structs.
fn parts(field: &Field, role: Role, k: usize) -> Vec<TokenStream> {
    if field.kind == Kind::Struct {
        let (ty, path) = (field.element(), to(field));
        let structs = field.struct_count().ok().flatten().unwrap_or(1);
        let rows = |k| quote!(__fmu::Part::Struct(__fmu::FieldRows::<#ty, M, #path<At, #k>>::ROWS));
        return (0..structs).map(rows).collect();
    }
    let (constructor, description) = (constructor(field, role), &field.description);
    let (accessors, more) = (accessors(field, role), more(field, role));
    vec![quote! {
        __fmu::Part::Row(
            ::fmu_export::Variable::<M>::#constructor(__Names::<At>::ALL[#k].text(), #description, #accessors) #more
        )
    }]
}

/// Name of the constructor of the row.
fn constructor(field: &Field, role: Role) -> Ident {
    let (ty, of) = match field.kind {
        Kind::Real => ("", ""),
        Kind::Integer => ("integer_", ""),
        Kind::Boolean => ("boolean_", ""),
        _ if fields(field, role).is_some() => ("", "_of"),
        _ => ("string_", ""),
    };
    let causality = match role {
        Role::Parameter if field.attributes.has("constant") => "constant",
        Role::Parameter => "parameter",
        Role::Input => "input",
        _ if field.attributes.has("calculated") => "calculated_parameter",
        _ if field.attributes.has("local") => "local",
        Role::Output | Role::State => "output",
    };
    let plural = match field.shape {
        Shape::Scalar => "",
        _ => "s",
    };
    Ident::new(&format!("{ty}{causality}{plural}{of}"), field.span())
}

/// The variant of `Fields` for a type without constructors of its own.
fn fields(field: &Field, role: Role) -> Option<&'static str> {
    match field.kind {
        Kind::Text if !field.has_setter(role) => Some("String"),
        Kind::Choice => Some("Integer"),
        Kind::Other(name) => Some(name),
        _ => None,
    }
}

/// Accessors of a slice of all elements.
fn slices(field: &Field, name: &str) -> TokenStream {
    let (member, name) = (&field.ident, Ident::new(name, Span::call_site()));
    let [get, get_mut] =
        [("", "as_flattened"), ("_mut", "as_flattened_mut")].map(|(ending, flat)| {
            let at = format_ident!("get{ending}");
            let place = match ending {
                "" => quote!(&At::#at(s).#member),
                _ => quote!(&mut At::#at(s).#member),
            };
            let flat = flattened(field, flat);
            let slice = match (&field.shape, ending) {
                (Shape::Scalar, "") => quote!(::core::slice::from_ref(#place)),
                (Shape::Scalar, _) => quote!(::core::slice::from_mut(#place)),
                _ => quote!((#place) #flat),
            };
            let numbers = format_ident!("numbers{ending}");
            match field.kind {
                Kind::Choice => {
                    let ty = field.value();
                    quote!(__fmu::FieldType::<#ty>::#numbers(#slice))
                }
                _ => slice,
            }
        });
    quote!(::fmu_export::Fields::#name(|s| #get, |s| #get_mut))
}

fn accessors(field: &Field, role: Role) -> TokenStream {
    let member = &field.ident;
    if field.attributes.has("constant") {
        let value = (field.attributes.start.as_ref()).map(|start| start_value(field, start));
        let (flat, ty) = (flattened(field, "as_flattened"), &field.ty);
        return match (fields(field, role), &field.shape) {
            (None, _) => quote!(|_| (&#value) #flat),
            (Some(name), shape) => {
                let name = Ident::new(name, Span::call_site());
                let slice = match shape {
                    Shape::Scalar => quote!(::core::slice::from_ref(VALUE)),
                    _ => quote!(VALUE #flat),
                };
                let none = quote!(|_| ::core::unreachable!("a constant"));
                quote!(::fmu_export::Fields::#name(|_| { const VALUE: &#ty = &#value; #slice }, #none))
            }
        };
    }
    if let Some(name) = fields(field, role) {
        return slices(field, name);
    }
    let is_written = matches!(role, Role::Parameter | Role::Input);
    match (field.kind, is_written) {
        (Kind::Text, _) => {
            let set = match &field.attributes.set {
                Some(set) => quote!(|s, text, folder| #set(At::get_mut(s), text, folder)),
                None => quote!(|s, text, _| {
                    text.clone_into(&mut At::get_mut(s).#member);
                    ::core::result::Result::Ok(())
                }),
            };
            quote!(|s| At::get(s).#member.as_str(), #set)
        }
        (Kind::StaticText, _) => quote!(|s| At::get(s).#member),
        (_, true) => {
            let [read, write] =
                ["as_flattened", "as_flattened_mut"].map(|name| flattened(field, name));
            quote!(|s| (&At::get(s).#member) #read, |s| (&mut At::get_mut(s).#member) #write)
        }
        (_, false) => {
            let read = flattened(field, "as_flattened");
            quote!(|s| (&At::get(s).#member) #read)
        }
    }
}

/// The calls that flatten nested arrays to one slice.
fn flattened(field: &Field, name: &str) -> TokenStream {
    let (Shape::Array(lengths), name) = (&field.shape, Ident::new(name, Span::call_site())) else {
        return TokenStream::new();
    };
    (1..lengths.len()).map(|_| quote!(.#name())).collect()
}

/// The length of each dimension, and the function that resizes a `Vec`.
fn shape(field: &Field, role: Role) -> TokenStream {
    match &field.shape {
        Shape::Array(lengths) if lengths.len() > 1 => {
            let lengths = lengths.iter().map(length);
            quote!(.shape(&[#(#lengths),*]))
        }
        Shape::Vector => {
            let owner = match role {
                Role::Parameter => quote!(Parameter),
                Role::Input => quote!(Input),
                Role::Output | Role::State => quote!(Output),
            };
            let zero = element(field);
            let value = match role {
                Role::State => quote!(::std::vec![#zero; n]), // `State::start` has the start values
                _ => vector(field),
            };
            let (member, lengths) = (&field.ident, field.attributes.len.iter().map(length));
            quote!(.vector(&[#(#lengths),*], ::fmu_export::Resize::#owner(|s, n| At::get_mut(s).#member = #value)))
        }
        _ => TokenStream::new(),
    }
}

/// A compile-time check that an array is not too large for the stack.
fn size(field: &Field) -> TokenStream {
    let (Shape::Array(_), ty, name) = (&field.shape, &field.ty, &field.name) else {
        return TokenStream::new();
    };
    let text = format!(
        "`{name}` is longer than 64 kB, which would go through the stack: write a Vec, and its length as `#[fmu(len = …)]`"
    );
    quote_spanned! { ty.span()=>
        const _: () = ::core::assert!(::core::mem::size_of::<#ty>() <= 1 << 16, #text);
    }
}

/// The attributes of the row, as calls after its constructor.
fn more(field: &Field, role: Role) -> TokenStream {
    let (attributes, ty) = (&field.attributes, field.value());
    let mut calls = TokenStream::new();
    if let Some(definition) = &attributes.of_type {
        calls.extend(quote!(.of_type(&#definition)));
    }
    match &attributes.unit {
        Some(Expr::Lit(name)) => calls.extend(quote!(.unit(#name))),
        Some(unit) => calls.extend(quote!(.own_unit(&#unit))),
        None => {}
    }
    if field.kind == Kind::Choice {
        let enumeration = quote_spanned!(ty.span()=> <#ty as __fmu::Enumerated>::ENUMERATION);
        calls.extend(quote!(.enumeration(&#enumeration)));
    }
    if let Some(unit) = &attributes.display_unit {
        calls.extend(quote!(.display_unit(#unit)));
    }
    let is_integrated = role == Role::State && !attributes.has("discrete");
    if let Some(rate) = field
        .unit()
        .filter(|_| is_integrated)
        .and_then(units::per_second)
    {
        calls.extend(quote!(.rate_unit(#rate)));
    }
    for (key, value) in [
        ("min", &attributes.min),
        ("max", &attributes.max),
        ("nominal", &attributes.nominal),
    ] {
        if let Some(value) = value {
            let (key, value) = (Ident::new(key, Span::call_site()), bound(value, field.kind));
            calls.extend(quote!(.#key(#value)));
        }
    }
    if let Some(text) = &attributes.mime_type {
        calls.extend(quote!(.mime_type(#text)));
    }
    if let Some(bytes) = &attributes.max_size {
        calls.extend(quote!(.max_size(#bytes)));
    }
    if !attributes.aliases.is_empty() {
        let aliases = aliases(field);
        calls.extend(quote!(.aliases(__Names::<At>::#aliases)));
    }
    if let Some(reference) = &attributes.at {
        calls.extend(quote!(.at(#reference)));
    }
    calls.extend(shape(field, role));
    for flag in ["structural", "tunable", "discrete", "not_in_evaluation"] {
        if attributes.has(flag) && (flag != "discrete" || field.kind.is_float()) {
            let flag = Ident::new(flag, Span::call_site());
            calls.extend(quote!(.#flag()));
        }
    }
    if !attributes.clocks.is_empty() {
        let clocks = &attributes.clocks;
        calls.extend(quote!(.clocks(&[#(#clocks),*])));
    }
    if let Some(previous) = &attributes.previous {
        calls.extend(quote!(.previous(#previous)));
    }
    calls.extend(dependencies(field, role));
    calls
}

fn dependencies(field: &Field, role: Role) -> TokenStream {
    let attributes = &field.attributes;
    let mut calls = TokenStream::new();
    let is_output = !attributes.has("local") && !attributes.has("calculated");
    match &attributes.depends_on {
        Some(names) => {
            let names = names.iter().map(known);
            calls.extend(quote!(.depends_on(&[#(#names),*])));
        }
        // At a tick it may depend on all inputs.
        None if attributes.has("clock") => {}
        None if role == Role::State && is_output && attributes.has("discrete") => {
            calls.extend(quote!(.depends_on(&[::fmu_export::NO_STATES])));
        }
        None if role == Role::State && is_output => calls.extend(quote!(.depends_on(&[]))),
        None => {}
    }
    if let Some(names) = &attributes.rate_depends_on {
        calls.extend(quote!(.rate_depends_on(&[#(#names),*])));
    }
    let knowns = match &attributes.initially_depends_on {
        Some(names) => Some(names.iter().map(known).collect()),
        None if role == Role::State && is_output => start_dependencies(field),
        None => None,
    };
    if let Some::<Vec<TokenStream>>(knowns) = knowns {
        calls.extend(quote!(.initially_depends_on(&[#(#knowns),*])));
    }
    if role == Role::State && !field.starts_elsewhere {
        calls.extend(quote!(.forget_own_names(!At::NAME.is_empty())));
    }
    calls
}

fn known(name: &LitStr) -> TokenStream {
    match name.value().as_str() {
        "parameters" => quote!(::fmu_export::ALL_PARAMETERS),
        "no_states" => quote!(::fmu_export::NO_STATES),
        _ => quote!(#name),
    }
}

/// The parameters and inputs in the start value of a state; None if they cannot be determined.
fn start_dependencies(field: &Field) -> Option<Vec<TokenStream>> {
    if field.starts_elsewhere {
        return None;
    }
    let Some(start) = &field.attributes.start else {
        return Some(Vec::new());
    };
    let mut names = Vec::new();
    let is_vector = matches!(field.shape, Shape::Vector);
    collect(quote!(#start), is_vector, &mut names)?;
    // An array that starts as another array depends on it element by element.
    if let ([name], Shape::Array(_), Expr::Field(_)) = (&mut names[..], &field.shape, start) {
        name.push_str("[i]");
    }
    Some(names.iter().map(|name| quote!(#name)).collect())
}

/// Finds `p.a.b` and `u.a`; None where `p` or `u` is used as a whole, or a method of it is called.
///
/// In the start of each element of a vector, `p.a[i]` and `p.a[i-1]` are elements.
fn collect(tokens: TokenStream, is_vector: bool, names: &mut Vec<String>) -> Option<()> {
    let tokens: Vec<_> = tokens.into_iter().collect();
    let is_dot =
        |k: usize| matches!(tokens.get(k), Some(TokenTree::Punct(p)) if p.as_char() == '.');
    let mut k = 0;
    while k < tokens.len() {
        match &tokens[k] {
            TokenTree::Group(group) => collect(group.stream(), is_vector, names)?,
            TokenTree::Ident(ident)
                if (ident == "p" || ident == "u") && (k == 0 || !is_dot(k - 1)) =>
            {
                let mut name: Vec<String> = Vec::new();
                while is_dot(k + 1) {
                    let Some(TokenTree::Ident(member)) = tokens.get(k + 2) else {
                        return None;
                    };
                    let next = tokens.get(k + 3);
                    if matches!(next, Some(TokenTree::Group(g)) if g.delimiter() != Delimiter::Bracket)
                    {
                        break; // a method of a number
                    }
                    name.push(crate::names::ident_text(member));
                    k += 2;
                }
                if name.is_empty() {
                    return None;
                }
                let mut name = name.join(".");
                if let Some(TokenTree::Group(index)) = tokens.get(k + 1)
                    && is_vector
                {
                    let index = index.stream().to_string().replace(' ', "");
                    if index == "i" || index.starts_with("i+") || index.starts_with("i-") {
                        name = format!("{name}[{index}]");
                    }
                }
                names.push(name);
            }
            _ => {}
        }
        k += 1;
    }
    Some(())
}

/// A bound, which is an f64 whatever the type of the variable.
fn bound(value: &Expr, kind: Kind) -> TokenStream {
    match kind {
        Kind::Integer | Kind::Other(_) if !is_literal(value) => quote!((#value) as f64),
        _ => real(value),
    }
}

fn is_literal(value: &Expr) -> bool {
    match value {
        Expr::Lit(_) => true,
        Expr::Unary(unary) => is_literal(&unary.expr),
        _ => false,
    }
}
