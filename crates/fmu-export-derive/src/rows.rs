//! The rows of a struct in the table of variables.

use crate::field::{Field, Kind, Role};
use crate::values::{real, start_value};
use proc_macro2::{Span, TokenStream, TokenTree};
use quote::{format_ident, quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Expr, ExprLit, Ident, Lit, LitStr};

/// `impl Rows`, and what it needs.
pub(crate) fn derive(ident: &Ident, fields: &[Field], role: Role) -> TokenStream {
    let owner = match role {
        Role::Parameter => quote!(Parameters),
        Role::Input => quote!(Input),
        Role::Output | Role::State => quote!(Output),
    };
    let fields: Vec<_> = fields.iter().filter(|field| field.is_seen()).collect();
    let names = fields.iter().map(|field| &field.name);
    let parts = (fields.iter().enumerate()).map(|(k, field)| part(field, role, k));
    let checks = fields.iter().map(|field| match (field.kind, role) {
        (Kind::Struct, Role::Output | Role::State) => {
            let ty = &field.ty;
            quote_spanned!(ty.span()=> const _: () = __fmu::is_output::<#ty>();)
        }
        _ => units(field),
    });
    let paths = (fields.iter())
        .filter(|field| field.kind == Kind::Struct)
        .map(|field| path(ident, field));
    quote! {
        /// __Names of the fields, where `At` leads to the struct.
        struct __Names<At>(::core::marker::PhantomData<At>);

        impl<At: __fmu::Path> __Names<At> {
            const ALL: &'static [__fmu::Name] = &[#(At::NAME.join(#names)),*];
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
                use __fmu::SpareRows as _;
                &[#(#parts),*]
            };
        }
    }
}

/// The way to the struct in a field.
fn path(ident: &Ident, field: &Field) -> TokenStream {
    let (path, member, ty, name) = (to(field), &field.ident, &field.ty, &field.name);
    quote! {
        /// The way to a struct in the struct.
        #[allow(non_camel_case_types)]
        struct #path<At>(::core::marker::PhantomData<At>);

        impl<At: __fmu::Path<To = #ident>> __fmu::Path for #path<At> {
            type From = At::From;
            type To = #ty;
            const NAME: __fmu::Name = At::NAME.join(#name);

            #[inline]
            fn get(from: &At::From) -> &#ty {
                &At::get(from).#member
            }

            #[inline]
            fn get_mut(from: &mut At::From) -> &mut #ty {
                &mut At::get_mut(from).#member
            }
        }
    }
}

fn to(field: &Field) -> Ident {
    format_ident!("To_{}", crate::names::plain(&field.ident))
}

/// One part of the table: a row, or the rows of a struct.
fn part(field: &Field, role: Role, k: usize) -> TokenStream {
    let ty = &field.ty;
    if field.kind == Kind::Struct {
        let path = to(field);
        return quote!(__fmu::Part::Struct(__fmu::RowsOf::<#ty, M, #path<At>>::ROWS));
    }
    let constructor = constructor(field, role);
    let (description, accessors, more) = (
        &field.description,
        accessors(field, role),
        more(field, role),
    );
    quote! {
        __fmu::Part::Row(
            ::fmu_export::Variable::<M>::#constructor(__Names::<At>::ALL[#k].text(), #description, #accessors) #more
        )
    }
}

/// Name of the function that makes the row.
fn constructor(field: &Field, role: Role) -> Ident {
    let ty = match field.kind {
        Kind::Real => "",
        Kind::Integer | Kind::Choice => "integer_",
        Kind::Boolean => "boolean_",
        Kind::Text | Kind::StaticText => "string_",
        Kind::Struct => unreachable!("has no row of its own"),
    };
    let causality = match role {
        Role::Parameter if field.said.has("constant") => "constant",
        Role::Parameter => "parameter",
        Role::Input => "input",
        _ if field.said.has("calculated") => "calculated_parameter",
        _ if field.said.has("local") => "local",
        Role::Output | Role::State => "output",
    };
    let plural = if field.len.is_some() { "s" } else { "" };
    Ident::new(&format!("{ty}{causality}{plural}"), field.span())
}

fn accessors(field: &Field, role: Role) -> TokenStream {
    let (member, ty) = (&field.ident, &field.ty);
    if field.said.has("constant") {
        let value = (field.said.start.as_ref()).map(|start| start_value(field, start));
        return quote!(|_| &#value);
    }
    let is_written = matches!(role, Role::Parameter | Role::Input);
    match (field.kind, is_written) {
        (Kind::Text, _) => {
            let set = match &field.said.set {
                Some(set) => quote!(|s, text, folder| #set(At::get_mut(s), text, folder)),
                None => quote!(|s, text, _| {
                    text.clone_into(&mut At::get_mut(s).#member);
                    ::core::result::Result::Ok(())
                }),
            };
            quote!(|s| At::get(s).#member.as_str(), #set)
        }
        (Kind::StaticText, _) => quote!(|s| At::get(s).#member),
        (Kind::Choice, true) => quote! {
            |s| __fmu::Of::<#ty>::number(&At::get(s).#member),
            |s| __fmu::Of::<#ty>::number_mut(&mut At::get_mut(s).#member)
        },
        (Kind::Choice, false) => quote!(|s| __fmu::Of::<#ty>::number(&At::get(s).#member)),
        (_, true) => quote!(|s| &At::get(s).#member, |s| &mut At::get_mut(s).#member),
        (_, false) => quote!(|s| &At::get(s).#member),
    }
}

/// What the row says beside name, description and place.
fn more(field: &Field, role: Role) -> TokenStream {
    let (said, ty) = (&field.said, &field.ty);
    let mut calls = TokenStream::new();
    match &said.unit {
        Some(Expr::Lit(name)) => calls.extend(quote!(.unit(#name))),
        Some(unit) => calls.extend(quote!(.own_unit(&#unit))),
        None => {}
    }
    if field.kind == Kind::Choice {
        let enumeration = quote_spanned!(ty.span()=> <#ty as __fmu::Enumerated>::ENUMERATION);
        calls.extend(quote!(.enumeration(&#enumeration)));
    }
    if let Some(unit) = &said.display_unit {
        calls.extend(quote!(.display_unit(#unit)));
    }
    for (key, value) in [
        ("min", &said.min),
        ("max", &said.max),
        ("nominal", &said.nominal),
    ] {
        if let Some(value) = value {
            let (key, value) = (Ident::new(key, Span::call_site()), bound(value, field.kind));
            calls.extend(quote!(.#key(#value)));
        }
    }
    if let Some(reference) = &said.at {
        calls.extend(quote!(.at(#reference)));
    }
    for flag in ["tunable", "discrete", "beside_evaluation"] {
        if said.has(flag) && (flag != "discrete" || field.kind == Kind::Real) {
            let flag = Ident::new(flag, Span::call_site());
            calls.extend(quote!(.#flag()));
        }
    }
    calls.extend(dependencies(field, role));
    calls
}

fn dependencies(field: &Field, role: Role) -> TokenStream {
    let said = &field.said;
    let mut calls = TokenStream::new();
    let is_output = !said.has("local") && !said.has("calculated");
    match &said.depends_on {
        Some(names) => {
            let names = names.iter().map(known);
            calls.extend(quote!(.depends_on(&[#(#names),*])));
        }
        None if role == Role::State && is_output && said.has("discrete") => {
            calls.extend(quote!(.depends_on(&[::fmu_export::NO_STATES])));
        }
        None if role == Role::State && is_output => calls.extend(quote!(.depends_on(&[]))),
        None => {}
    }
    if let Some(names) = &said.rate_depends_on {
        calls.extend(quote!(.rate_depends_on(&[#(#names),*])));
    }
    let knowns = match &said.initially_depends_on {
        Some(names) => Some(names.iter().map(known).collect()),
        None if role == Role::State && is_output => start_dependencies(field),
        None => None,
    };
    if let Some::<Vec<TokenStream>>(knowns) = knowns {
        calls.extend(quote!(.initially_depends_on(&[#(#knowns),*])));
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

/// The parameters and inputs in the start value of a state; None: it cannot be told.
fn start_dependencies(field: &Field) -> Option<Vec<TokenStream>> {
    if field.starts_elsewhere {
        return None;
    }
    let Some(start) = &field.said.start else {
        return Some(Vec::new());
    };
    let mut names = Vec::new();
    collect(quote!(#start), &mut names)?;
    // A vector that starts as another one does so element by element.
    if let ([name], true, Expr::Field(_)) = (&mut names[..], field.len.is_some(), start) {
        name.push_str("[i]");
    }
    Some(names.iter().map(|name| quote!(#name)).collect())
}

/// Finds `p.a.b` and `u.a`; None where `p` or `u` is used as a whole, or a method of it is called.
fn collect(tokens: TokenStream, names: &mut Vec<String>) -> Option<()> {
    let tokens: Vec<_> = tokens.into_iter().collect();
    let is_dot =
        |k: usize| matches!(tokens.get(k), Some(TokenTree::Punct(p)) if p.as_char() == '.');
    let mut k = 0;
    while k < tokens.len() {
        match &tokens[k] {
            TokenTree::Group(group) => collect(group.stream(), names)?,
            TokenTree::Ident(ident)
                if (ident == "p" || ident == "u") && (k == 0 || !is_dot(k - 1)) =>
            {
                let mut name: Vec<String> = Vec::new();
                while is_dot(k + 1) {
                    let Some(TokenTree::Ident(member)) = tokens.get(k + 2) else {
                        return None;
                    };
                    if matches!(tokens.get(k + 3), Some(TokenTree::Group(_))) {
                        break; // a method of a number, or an index
                    }
                    name.push(crate::names::plain(member));
                    k += 2;
                }
                if name.is_empty() {
                    return None;
                }
                names.push(name.join("."));
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
        Kind::Integer if !is_literal(value) => quote!((#value) as f64),
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

/// Checks that the compiler makes: units are known.
fn units(field: &Field) -> TokenStream {
    let Some(Expr::Lit(ExprLit {
        lit: Lit::Str(unit),
        ..
    })) = &field.said.unit
    else {
        return TokenStream::new();
    };
    let name = unit.value();
    let text = format!(
        "unit `{name}` is not in fmu_export::KNOWN_UNITS; define it, `const MINE: Unit = Unit::new(\"{name}\")…;`, and write `unit = MINE`"
    );
    let mut checks = quote_spanned! { unit.span()=>
        const _: () = ::core::assert!(__fmu::is_known_unit(#unit), #text);
    };
    if let Some(display) = &field.said.display_unit {
        let text = format!("`{}` is not a display unit of `{name}`", display.value());
        checks.extend(quote_spanned! { display.span()=>
            const _: () = ::core::assert!(!__fmu::is_known_unit(#unit) || __fmu::is_display_unit(#unit, #display), #text);
        });
    }
    checks
}
