//! Parses `#[fmu(…)]` on a field for `field`; finds it for `state`, `structs` and `enumeration`.

use proc_macro2::Span;
use quote::quote;
use syn::punctuated::Punctuated;
use syn::{
    Attribute, Error, Expr, ExprLit, Field, Index, Lit, LitStr, Member, Path, Result, Token,
};

/// The keys and values of `#[fmu(…)]` on a field.
#[derive(Default)]
pub(crate) struct Attributes {
    pub(crate) name: Option<LitStr>,
    pub(crate) unit: Option<Expr>,
    pub(crate) display_unit: Option<LitStr>,
    pub(crate) start: Option<Expr>,
    pub(crate) min: Option<Expr>,
    pub(crate) max: Option<Expr>,
    pub(crate) nominal: Option<Expr>,
    /// The constant with the variable's type.
    pub(crate) of_type: Option<Expr>,
    pub(crate) aliases: Vec<LitStr>,
    pub(crate) mime_type: Option<LitStr>,
    pub(crate) max_size: Option<Expr>,
    pub(crate) at: Option<Expr>,
    /// The lengths of the dimensions of a `Vec`.
    pub(crate) len: Vec<Expr>,
    pub(crate) set: Option<Path>,
    /// The clocks that it belongs to.
    pub(crate) clocks: Vec<LitStr>,
    /// The variable with its value at the tick before.
    pub(crate) previous: Option<LitStr>,
    pub(crate) depends_on: Option<Vec<LitStr>>,
    pub(crate) initially_depends_on: Option<Vec<LitStr>>,
    pub(crate) rate_depends_on: Option<Vec<LitStr>>,
    /// All keys in order, with their spans.
    pub(crate) keys: Vec<(String, Span)>,
}

/// All keys, for messages.
const KEYS: &str = "unit, display_unit, type, start, min, max, nominal, len, name, alias, at, mime_type, max_size, structural, tunable, constant, discrete, clock, previous, set, depends_on, \
                    initially_depends_on, rate_depends_on, not_in_evaluation, local, calculated or skip";

impl Attributes {
    pub(crate) fn from_field(field: &Field) -> Result<Self> {
        let mut all = Self::default();
        for attribute in fmu(&field.attrs) {
            all.read(attribute)?;
        }
        Ok(all)
    }

    fn read(&mut self, attribute: &Attribute) -> Result<()> {
        attribute.parse_nested_meta(|meta| {
            let Some(key) = meta.path.get_ident().map(ToString::to_string) else {
                return Err(meta.error(format!("unknown attribute; it must be {KEYS}")));
            };
            if self.keys.iter().any(|(known, _)| *known == key) {
                return Err(meta.error(format!("`{key}` is given twice")));
            }
            match key.as_str() {
                "name" => self.name = Some(meta.value()?.parse()?),
                "unit" => self.unit = Some(meta.value()?.parse()?),
                "display_unit" => self.display_unit = Some(meta.value()?.parse()?),
                "start" => self.start = Some(meta.value()?.parse()?),
                "min" => self.min = Some(meta.value()?.parse()?),
                "max" => self.max = Some(meta.value()?.parse()?),
                "nominal" => self.nominal = Some(meta.value()?.parse()?),
                "at" => self.at = Some(meta.value()?.parse()?),
                "type" => self.of_type = Some(meta.value()?.parse()?),
                "mime_type" => self.mime_type = Some(meta.value()?.parse()?),
                "max_size" => self.max_size = Some(meta.value()?.parse()?),
                "alias" => {
                    let names;
                    syn::parenthesized!(names in meta.input);
                    let names = Punctuated::<LitStr, Token![,]>::parse_terminated(&names)?;
                    self.aliases = names.into_iter().collect();
                }
                "len" => {
                    self.len = match meta.value()?.parse()? {
                        Expr::Tuple(lengths) => lengths.elems.into_iter().collect(),
                        length => vec![length],
                    }
                }
                "clock" => {
                    self.clocks = match meta.value()?.parse()? {
                        Expr::Tuple(names) => names
                            .elems
                            .iter()
                            .map(variable_name)
                            .collect::<Result<_>>()?,
                        name => vec![variable_name(&name)?],
                    }
                }
                "previous" => {
                    self.previous = Some(variable_name(&meta.value()?.parse()?)?);
                }
                "set" => self.set = Some(meta.value()?.parse()?),
                "depends_on" | "initially_depends_on" | "rate_depends_on" => {
                    let content;
                    syn::parenthesized!(content in meta.input);
                    let list = Punctuated::<Expr, Token![,]>::parse_terminated(&content)?;
                    let names = list.iter().map(variable_name).collect::<Result<_>>()?;
                    match key.as_str() {
                        "depends_on" => self.depends_on = Some(names),
                        "rate_depends_on" => self.rate_depends_on = Some(names),
                        _ => self.initially_depends_on = Some(names),
                    }
                }
                "structural" | "tunable" | "constant" | "discrete" | "not_in_evaluation"
                | "local" | "calculated" | "skip" => {} // without a value
                _ => {
                    return Err(meta.error(format!("unknown attribute `{key}`; it must be {KEYS}")));
                }
            }
            self.keys.push((key, span(&meta.path)));
            Ok(())
        })
    }

    /// Whether a key is there; what belongs to a clock is discrete.
    pub(crate) fn has(&self, key: &str) -> bool {
        let is_meant = key == "discrete" && !self.clocks.is_empty();
        is_meant || self.keys.iter().any(|(known, _)| known == key)
    }
}

/// The attributes named `fmu`.
pub(crate) fn fmu(attributes: &[Attribute]) -> impl Iterator<Item = &Attribute> {
    (attributes.iter()).filter(|attribute| attribute.path().is_ident("fmu"))
}

fn span(path: &Path) -> Span {
    syn::spanned::Spanned::span(path)
}

/// The name of a variable in a list of dependencies, `motor.u[2]` or `"motor.u[2]"`.
fn variable_name(expr: &Expr) -> Result<LitStr> {
    let text = match expr {
        Expr::Lit(ExprLit {
            lit: Lit::Str(text),
            ..
        }) => return Ok(text.clone()),
        _ => path_text(expr),
    };
    let span = syn::spanned::Spanned::span(expr);
    text.map(|text| LitStr::new(&text, span)).ok_or_else(|| {
        Error::new(
            span,
            "not a variable; write `u`, `u[2]`, `u[i]`, `u[i-1]` or `motor.u`",
        )
    })
}

fn path_text(expr: &Expr) -> Option<String> {
    match expr {
        Expr::Path(path) => path.path.get_ident().map(crate::names::ident_text),
        Expr::Field(field) => {
            let member = match &field.member {
                Member::Named(name) => crate::names::ident_text(name),
                Member::Unnamed(Index { .. }) => return None,
            };
            Some(format!("{}.{member}", path_text(&field.base)?))
        }
        Expr::Index(index) => {
            let place = &index.index;
            let number = quote!(#place).to_string().replace(' ', "");
            let neighbour = number.strip_prefix("i+").or(number.strip_prefix("i-"));
            let is_number = neighbour.unwrap_or(&number).parse::<u32>().is_ok();
            if !is_number && number != "i" {
                return None;
            }
            Some(format!("{}[{number}]", path_text(&index.expr)?))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::KEYS;

    #[test]
    fn the_readme_of_the_kit_lists_all_keys() {
        let readme = include_str!("../../README.md");
        let keys = KEYS.split(|c: char| c != '_' && !c.is_alphanumeric());
        for key in keys.filter(|key| !["", "or"].contains(key)) {
            assert!(readme.contains(&format!("`{key}`")), "{key}");
        }
        for key in crate::state::KEYS
            .split(", ")
            .flat_map(|keys| keys.split(" or "))
        {
            assert!(readme.contains(&format!("`{key}`")), "{key}");
        }
    }
}
