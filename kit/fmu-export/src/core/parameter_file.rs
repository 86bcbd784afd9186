//! Reads files that String parameters name, such as parameter values, for authors of models.

#[cfg(target_arch = "wasm32")]
pub(super) use super::placed_files::{exists, read};
use std::cell::Cell;
use std::fmt::Display;
#[cfg(not(target_arch = "wasm32"))]
pub(super) use std::fs::{exists, read_to_string as read};
use std::path::Path;

thread_local! {
    /// The file is one of the FMU's own, which is not looked up in the working directory.
    static IS_PACKED: Cell<bool> = const { Cell::new(false) };
}

/// Says, until it is dropped, whether the files that are read are the FMU's own.
pub(super) struct Reading;

impl Reading {
    pub(super) fn start(is_packed: bool) -> Self {
        IS_PACKED.set(is_packed);
        Self
    }
}

impl Drop for Reading {
    fn drop(&mut self) {
        IS_PACKED.set(false);
    }
}

/// Reads and parses the file that a String parameter names, for a [`SetString`](crate::SetString).
///
/// A relative path that is not in the working directory is looked up in the `resources` folder.
///
/// # Errors
/// The file cannot be read (the text says where it was looked for), or `parse` fails.
pub fn read_parameter_file<T, E: Display>(
    path: &str,
    resources: Option<&Path>,
    parse: impl FnOnce(&str) -> Result<T, E>,
) -> Result<T, String> {
    read_placed_file(path, resources, |text, _| parse(text))
}

/// Like [`read_parameter_file`], but `parse` also receives the path of the file.
///
/// # Errors
/// As of [`read_parameter_file`].
pub fn read_placed_file<T, E: Display>(
    path: &str,
    resources: Option<&Path>,
    parse: impl FnOnce(&str, &Path) -> Result<T, E>,
) -> Result<T, String> {
    let given = Path::new(path);
    let in_resources = resources.map(|folder| folder.join(given));
    let file = match &in_resources {
        Some(file)
            if given.is_relative() && (IS_PACKED.get() || !exists(given).unwrap_or(false)) =>
        {
            file
        }
        _ => given,
    };
    let text = read(file).map_err(|e| match resources {
        Some(folder) if given.is_relative() => {
            let folder = folder.display();
            format!(
                "file `{path}`: {e}; looked for in the working directory and in the FMU's resources folder {folder}"
            )
        }
        _ => format!("file `{path}`: {e}"),
    })?;
    parse(&text, file).map_err(|e| format!("file `{path}`: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/core");

    fn length(path: &str, resources: Option<&Path>) -> Result<usize, String> {
        read_placed_file(path, resources, |text, file| match text.len() {
            _ if !file.ends_with(path) => Err("another path"),
            0 => Err("empty"),
            length => Ok(length),
        })
    }

    #[test]
    fn a_file_is_found_as_given_and_in_the_resources() {
        let expected = include_str!("parameter_file.rs").len();
        let absolute = format!("{FOLDER}/parameter_file.rs");
        assert_eq!(length(&absolute, None), Ok(expected));
        assert_eq!(length(&absolute, Some(Path::new("/nowhere"))), Ok(expected));
        let relative = "parameter_file.rs";
        assert_eq!(length(relative, Some(Path::new(FOLDER))), Ok(expected));
        // Tests run in the crate's folder: what is there comes before the resources.
        assert_ne!(length("Cargo.toml", Some(Path::new(FOLDER))), Ok(expected));
        assert!(length("Cargo.toml", Some(Path::new(FOLDER))).is_ok());
    }

    #[test]
    fn errors_name_the_file_as_given_and_where_it_was_looked_for() {
        let text = length("none.json", Some(Path::new(FOLDER))).unwrap_err();
        assert!(text.starts_with("file `none.json`: "), "{text}");
        assert!(text.contains(FOLDER), "{text}");
        let text = length("none.json", None).unwrap_err();
        assert!(text.starts_with("file `none.json`: "), "{text}");
        let refuse = |_: &str| Err::<(), _>("`R_s` = -1 must be > 0");
        let text = read_parameter_file("Cargo.toml", None, refuse).unwrap_err();
        assert_eq!(text, "file `Cargo.toml`: `R_s` = -1 must be > 0");
    }
}
