//! The Content-Security-Policy of a page that is one file: it runs its own scripts and loads nothing.
//! `cargo fmu web` and the report of the studies put it into their pages.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

/// The element after which the policy stands: it applies to what follows it.
const BEFORE: &str = "<meta charset=\"utf-8\">";

/// The page with a policy: scripts are those that the page holds now, by their hashes. Documentation
/// and other texts that it shows can neither run scripts nor load from a network, nor go elsewhere.
/// Returns None if the page does not declare its encoding, `<meta charset="utf-8">`.
///
/// ```
/// let page = "<head><meta charset=\"utf-8\"></head><script>run()</script>";
/// assert!(page_files::with_policy(page).unwrap().contains("default-src 'none'"));
/// ```
pub fn with_policy(page: &str) -> Option<String> {
    let hashes: String = scripts(page)
        .map(|script| format!("'sha256-{}' ", STANDARD.encode(Sha256::digest(script))))
        .collect();
    let policy = format!(
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; base-uri 'none'; form-action 'none'; \
         script-src {hashes}'wasm-unsafe-eval'; worker-src blob:; connect-src data:; img-src data: blob:; font-src data:; \
         style-src 'unsafe-inline'\">"
    );
    let (head, rest) = page.split_once(BEFORE)?;
    Some([head, BEFORE, "\n", &policy, rest].concat())
}

/// The page with other JSON in its script element `name`, which is data: the policy stays. Returns
/// None if the page has no such element.
///
/// ```
/// let page = r#"<script type="application/json" id="a">1</script>"#;
/// let other = page_files::with_data(page, "a", "[2]").unwrap();
/// assert_eq!(other, "<script type=\"application/json\" id=\"a\">\n[2]</script>");
/// ```
pub fn with_data(page: &str, name: &str, json: &str) -> Option<String> {
    let begin = format!("<script type=\"application/json\" id=\"{name}\">");
    let (head, rest) = page.split_once(&begin)?;
    let (_, rest) = rest.split_once("</script>")?;
    // `<` is escaped, since `</` could end the script element.
    let json = json.replace('<', "\\u003c");
    Some([head, &begin, "\n", &json, "</script>", rest].concat())
}

/// The texts of the script elements that the browser runs; those of another type are data.
fn scripts(page: &str) -> impl Iterator<Item = &str> {
    let mut rest = page;
    std::iter::from_fn(move || {
        loop {
            let (attributes, after) = rest.split_once("<script")?.1.split_once('>')?;
            let (text, after) = after.split_once("</script>")?;
            rest = after;
            if !attributes.contains("type=") || attributes.contains("javascript") {
                return Some(text);
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_are_allowed_by_their_hash_and_data_are_none() {
        let page = "<meta charset=\"utf-8\"><script>alert('Hello, world.');</script>\
            <script type=\"application/json\">{}</script><script type=\"text/javascript\" id=\"a\">\n1</script>";
        let found: Vec<&str> = scripts(page).collect();
        assert_eq!(found, ["alert('Hello, world.');", "\n1"]);
        // The hash is that of the example in the standard (CSP Level 3, 2.3.1).
        let with = with_policy(page).unwrap();
        assert!(with.contains("'sha256-qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng='"));
        assert!(with_policy("<script>1</script>").is_none());
    }
}
