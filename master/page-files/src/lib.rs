//! The HTML, CSS and JavaScript files of the page that runs an FMU or a packed system in a browser.
//! `cargo fmu web` joins them into one file; the page of the machine takes common parts from here.
//!
//! ```
//! let page = page_files::file("model.html").unwrap();
//! assert!(page.contains("model.js") && page_files::file("other.html").is_none());
//! ```
#![forbid(unsafe_code)]

mod policy;

pub use policy::{with_data, with_policy};

macro_rules! files {
    ($($name:literal)*) => {
        [$(($name, include_str!(concat!("../page/", $name)))),*]
    };
}

/// Name and text of each file.
const FILES: [(&str, &str); 10] = files!(
    "engine.js" "model.html" "model.js" "page.js" "parts.js" "records.js" "scopes.js" "style.css"
    "variables.js" "worker.js"
);

/// The text of the file `name`.
pub fn file(name: &str) -> Option<&'static str> {
    let mut files = FILES.iter();
    files.find(|(file, _)| *file == name).map(|(_, text)| *text)
}
