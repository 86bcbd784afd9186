//! `#[derive(State)]` for the state of a model of ordinary differential equations, called by
//! `structs`: the attributes of the struct, `impl Vector` and `impl State`.

use crate::attributes::fmu;
use crate::field::{Field, Shape};
use crate::names;
use crate::values::{number, real, start_value, vector, zero};
use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use syn::punctuated::Punctuated;
use syn::spanned::Spanned;
use syn::{DeriveInput, Error, Expr, Ident, LitStr, Result, Token, Type};

pub(crate) const KEYS: &str = "parameters, input, output, max_step, solver, tolerance, model_exchange, scheduled_execution, experiment, info or table_only";

/// The attributes of the struct.
#[derive(Default)]
pub(crate) struct Model {
    parameters: Option<Type>,
    input: Option<Type>,
    output: Option<Type>,
    max_step: Option<Expr>,
    /// The solver for Co-Simulation.
    solver: Option<LitStr>,
    tolerance: Option<Expr>,
    experiment: Vec<Expr>,
    info: Option<Expr>,
    description: String,
    /// Supports Model Exchange too.
    model_exchange: bool,
    /// Supports Scheduled Execution too.
    scheduled_execution: bool,
    pub(crate) table_only: bool,
}

impl Model {
    pub(crate) fn from_input(input: &DeriveInput) -> Result<Self> {
        let mut model = Self {
            description: names::description(&input.attrs),
            ..Self::default()
        };
        for attribute in fmu(&input.attrs) {
            attribute.parse_nested_meta(|meta| {
                let key = meta.path.get_ident().map(ToString::to_string);
                match key.as_deref() {
                    Some("parameters") => model.parameters = Some(meta.value()?.parse()?),
                    Some("input") => model.input = Some(meta.value()?.parse()?),
                    Some("output") => model.output = Some(meta.value()?.parse()?),
                    Some("max_step") => model.max_step = Some(meta.value()?.parse()?),
                    Some("solver") => model.solver = Some(meta.value()?.parse()?),
                    Some("tolerance") => model.tolerance = Some(meta.value()?.parse()?),
                    Some("info") => model.info = Some(meta.value()?.parse()?),
                    Some("model_exchange") => model.model_exchange = true,
                    Some("scheduled_execution") => model.scheduled_execution = true,
                    Some("table_only") => model.table_only = true,
                    Some("experiment") => {
                        let content;
                        syn::parenthesized!(content in meta.input);
                        let list = Punctuated::<Expr, Token![,]>::parse_terminated(&content)?;
                        model.experiment = list.into_iter().collect();
                        if model.experiment.len() != 3 {
                            return Err(meta.error("experiment(start, stop, step), all s"));
                        }
                    }
                    _ => {
                        return Err(
                            meta.error(format!("unknown attribute; on a state it must be {KEYS}"))
                        );
                    }
                }
                Ok(())
            })?;
        }
        model.check(input)?;
        Ok(model)
    }

    /// Whether the struct is the state of a model, not a part of one.
    pub(crate) fn is_whole(&self) -> bool {
        self.parameters.is_some() || self.input.is_some() || self.output.is_some()
    }

    fn check(&self, input: &DeriveInput) -> Result<()> {
        let ident = &input.ident;
        let has_more = self.max_step.is_some()
            || self.solver.is_some()
            || !self.experiment.is_empty()
            || self.info.is_some();
        if has_more && !self.is_whole() {
            let text = "name the model's structs, as far as it has them: `#[fmu(parameters = …, input = …, output = …)]`";
            return Err(Error::new_spanned(ident, text));
        }
        if let Some(solver) = self
            .solver
            .as_ref()
            .filter(|s| !["adaptive", "stiff"].contains(&&*s.value()))
        {
            let text =
                "must be \"adaptive\" or \"stiff\"; without it: fixed steps of at most `max_step`";
            return Err(Error::new_spanned(solver, text));
        }
        if let (None, Some(tolerance)) = (&self.solver, &self.tolerance) {
            let text = "a tolerance belongs to `solver = \"adaptive\"` or `\"stiff\"`";
            return Err(Error::new_spanned(tolerance, text));
        }
        if self.info.is_some() && !self.experiment.is_empty() {
            let text = "with `info`, set the experiment by `Info::experiment`";
            return Err(Error::new_spanned(ident, text));
        }
        if self.is_whole() && self.info.is_none() && self.description.is_empty() {
            let text =
                format!("model `{ident}` has no description: write a doc comment above the struct");
            return Err(Error::new_spanned(ident, text));
        }
        Ok(())
    }
}

pub(crate) fn derive(
    ident: &Ident,
    fields: &[Field],
    model: Option<&Model>,
) -> Result<TokenStream> {
    let vector = vector_impl(ident, fields);
    match model.filter(|model| model.is_whole()) {
        Some(model) => {
            let whole = state_impl(ident, fields, model);
            Ok(quote! {
                #vector
                #whole
                impl __fmu::Output for #ident {}
                impl __fmu::StatePart for #ident {
                    const IS_MODEL: bool = true;
                }
            })
        }
        None => match (fields.iter()).find_map(|field| field.attributes.start.as_ref()) {
            Some(start) => {
                let text = "`start`: the struct is a part of a state; write it on the field that holds the struct";
                Err(Error::new_spanned(start, text))
            }
            None => Ok(quote! {
                #vector
                impl __fmu::Output for #ident {}
                impl __fmu::StatePart for #ident {}
            }),
        },
    }
}

fn vector_impl(ident: &Ident, fields: &[Field]) -> TokenStream {
    let fields: Vec<_> = fields
        .iter()
        .filter(|field| field.is_variable() && !field.attributes.has("discrete"))
        .collect();
    let members: Vec<_> = fields.iter().map(|field| &field.ident).collect();
    let types: Vec<_> = fields.iter().map(|field| &field.ty).collect();
    let names = fields.iter().map(|field| &field.name);
    quote! {
        impl __fmu::Vector for #ident {
            fn len(&self) -> usize {
                0 #(+ __fmu::FieldType::<#types>::len(&self.#members))*
            }

            #[inline]
            fn read<'a>(&self, to: &'a mut [f64]) -> &'a mut [f64] {
                #(let to = __fmu::FieldType::<#types>::read_states(&self.#members, to);)*
                to
            }

            #[inline]
            fn write<'a>(&mut self, from: &'a [f64]) -> &'a [f64] {
                #(let from = __fmu::FieldType::<#types>::write_states(&mut self.#members, from);)*
                from
            }

            fn not_finite(&self) -> ::core::option::Option<(&'static str, f64)> {
                #(
                    if let ::core::option::Option::Some((_, value)) = __fmu::FieldType::<#types>::not_finite(&self.#members) {
                        return ::core::option::Option::Some((#names, value));
                    }
                )*
                ::core::option::Option::None
            }
        }
    }
}

fn state_impl(ident: &Ident, fields: &[Field], model: &Model) -> TokenStream {
    let nothing = || syn::parse_quote!(());
    let p: Type = model.parameters.clone().unwrap_or_else(nothing);
    let u: Type = model.input.clone().unwrap_or_else(nothing);
    let y: Type = model.output.clone().unwrap_or_else(nothing);
    let (solver, usual_step) = match model.solver.as_ref().map(LitStr::value).as_deref() {
        Some("adaptive") => (quote!(Adaptive), quote!(f64::INFINITY)),
        Some(_) => (quote!(Stiff), quote!(f64::INFINITY)),
        None => (quote!(Fixed), quote!(1e-3)),
    };
    let max_step = (model.max_step.as_ref()).map_or(usual_step, |x| positive("max_step", x));
    let usual = quote!(::fmu_export::solver::TOLERANCE);
    let tolerance = (model.tolerance.as_ref()).map_or(usual, |x| positive("tolerance", x));
    let info = info(ident, model);
    let starts = fields.iter().map(|field| {
        let member = &field.ident;
        let value = match &field.attributes.start {
            _ if matches!(field.shape, Shape::Vector) => {
                let (n, vector) = (number(field), vector(field));
                quote!({ let n = #n; #vector })
            }
            Some(start) => start_value(field, start),
            None => zero(field),
        };
        quote!(#member: #value)
    });
    let exchange = model.model_exchange;
    let scheduled = model.scheduled_execution;
    let mut integrated = fields.iter().filter(|field| field.is_variable());
    let integrated = integrated.find(|field| !field.attributes.has("discrete"));
    if let Some(field) = integrated.filter(|_| scheduled) {
        let text = "nothing integrates a continuous state in Scheduled Execution: let it belong to a clock, `clock = …`, or be `discrete`";
        return Error::new(field.span(), text).into_compile_error();
    }
    let states = quote!(&[<#ident as __fmu::Rows<#ident, __fmu::StatePath<#ident>>>::ROWS]);
    // Solvers with a tolerance use them too.
    let derivatives = match exchange || model.solver.is_some() {
        true => quote! {
            const STATES: &[::fmu_export::Variable<#ident>] =
                &__fmu::assemble::<#ident, { __fmu::count::<#ident>(#states) }>(#states);
            const { &__fmu::derivatives::<#ident, { __fmu::count_states(STATES) }>(STATES) }
        },
        false => quote!(&[]),
    };
    let structs = quote! {
        &[
            <#p as __fmu::Rows<#ident, __fmu::Root<#p>>>::ROWS,
            <#u as __fmu::Rows<#ident, __fmu::Root<#u>>>::ROWS,
            <#ident as __fmu::Rows<#ident, __fmu::StatePath<#ident>>>::ROWS,
            <#y as __fmu::Rows<#ident, __fmu::OutputsPath<#ident>>>::ROWS,
        ]
    };
    quote! {
        impl __fmu::State for #ident {
            type P = #p;
            type U = #u;
            type Y = #y;
            const INFO: ::fmu_export::Info = #info;
            const MAX_STEP: f64 = #max_step;
            const SOLVER: __fmu::SolverName = __fmu::SolverName::#solver;
            const TOLERANCE: f64 = #tolerance;
            const MODEL_EXCHANGE: bool = #exchange;
            const SCHEDULED_EXECUTION: bool = #scheduled;

            #[allow(unused_variables)]
            fn start(p: &#p, u: &#u) -> Self {
                Self { #(#starts),* }
            }

            fn table() -> &'static [::fmu_export::Variable<Self>] {
                const { &__fmu::assemble::<#ident, { __fmu::count::<#ident>(#structs) }>(#structs) }
            }

            fn derivatives() -> &'static [::fmu_export::Variable<Self>] {
                #derivatives
            }
        }
    }
}

/// A number, which the compiler refuses if it is not positive.
fn positive(key: &str, value: &Expr) -> TokenStream {
    let (number, text) = (real(value), format!("`{key}` must be positive"));
    quote_spanned!(value.span()=> {
        let number: f64 = #number;
        ::core::assert!(number > 0.0, #text);
        number
    })
}

fn info(ident: &Ident, model: &Model) -> TokenStream {
    if let Some(info) = &model.info {
        return quote!(#info);
    }
    let (name, description) = (names::ident_text(ident), &model.description);
    let experiment = match &model.experiment[..] {
        [] => TokenStream::new(),
        values => {
            let values = values.iter().map(real);
            quote!(.experiment(#(#values),*))
        }
    };
    quote! {
        ::fmu_export::Info::new(#name, #description)
            .version(::core::env!("CARGO_PKG_VERSION"))
            .author(::core::env!("CARGO_PKG_AUTHORS"))
            .license(::core::env!("CARGO_PKG_LICENSE"))
            #experiment
    }
}
