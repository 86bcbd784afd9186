//! Names and descriptions of variables, from identifiers and doc comments, for all derives.

use syn::ext::IdentExt;
use syn::{Attribute, Expr, ExprLit, Ident, Lit, Meta};

/// The name of a field or variant, without `r#`.
pub(crate) fn ident_text(ident: &Ident) -> String {
    ident.unraw().to_string()
}

/// The first paragraph of the doc comment, in one line, without its full stop; empty if there is
/// none.
pub(crate) fn description(attributes: &[Attribute]) -> String {
    let mut words = Vec::new();
    for line in attributes.iter().filter_map(doc) {
        for line in line.lines() {
            // Block comments begin their lines with `*`.
            let line = line.trim().trim_start_matches("* ");
            if line.is_empty() && !words.is_empty() {
                return sentence(&words);
            }
            words.extend(line.split_whitespace().map(str::to_owned));
        }
        if line.trim().is_empty() && !words.is_empty() {
            return sentence(&words);
        }
    }
    sentence(&words)
}

fn sentence(words: &[String]) -> String {
    let text = words.join(" ");
    match text.strip_suffix('.') {
        Some(short) if !short.ends_with('.') => short.to_owned(),
        _ => text,
    }
}

fn doc(attribute: &Attribute) -> Option<String> {
    match &attribute.meta {
        Meta::NameValue(doc) if doc.path.is_ident("doc") => match &doc.value {
            Expr::Lit(ExprLit {
                lit: Lit::Str(text),
                ..
            }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use syn::parse_quote;

    fn first_paragraph(input: syn::ItemStruct) -> String {
        description(&input.attrs)
    }

    #[test]
    fn a_description_is_the_first_paragraph_in_one_line() {
        assert_eq!(first_paragraph(parse_quote! { struct A; }), "");
        assert_eq!(
            first_paragraph(parse_quote! { #[doc = " Mass."] struct A; }),
            "Mass"
        );
        let two = parse_quote! { #[doc = " Deflection that"] #[doc = " doubles the force ..."] #[doc = ""] #[doc = " More."] struct A; };
        assert_eq!(
            first_paragraph(two),
            "Deflection that doubles the force ..."
        );
        let block = parse_quote! { #[doc = " Mass\n * of the cart. "] struct A; };
        assert_eq!(first_paragraph(block), "Mass of the cart");
    }
}
