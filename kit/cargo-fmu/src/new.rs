//! `cargo fmu new`: makes a crate with a small model, its tests, and the other files of its FMU.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};

/// The files of a new crate. `{{…}}` is replaced.
const TEMPLATE: [(&str, &str); 5] = [
    ("Cargo.toml", include_str!("../template/Cargo.toml.in")),
    ("src/lib.rs", "{{source}}"),
    (
        "documentation/index.html",
        include_str!("../template/documentation/index.html.in"),
    ),
    ("README.md", include_str!("../template/README.md.in")),
    (".gitignore", include_str!("../template/gitignore.in")),
];

/// A model to begin with.
struct Example {
    source: &'static str,
    /// The text in the source that is replaced by the name of the model.
    name: &'static str,
    /// Its line among the dependencies.
    serde: &'static str,
    /// Path and text of further files.
    files: &'static [(&'static str, &'static str)],
}

/// The names of the examples for `--example`.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum Name {
    /// Conduction of heat: a stiff model, its solver, its sparse Jacobian
    Rod,
    /// A motor whose efficiency is a map from a file
    Map,
    /// Cells as an equivalent circuit with one heat node
    Battery,
    /// An oven with a thermostat: events within steps, messages, an enumeration
    Events,
}

const LAG: Example = Example {
    source: include_str!("../template/src/lib.rs.in"),
    name: "{{model}}",
    serde: "",
    files: &[],
};

const ROD: Example = Example {
    source: include_str!("../template/rod/lib.rs"),
    name: "Rod",
    ..LAG
};

const DRIVE: Example = Example {
    source: include_str!("../template/map/lib.rs"),
    name: "Drive",
    files: &[(
        "resources/efficiency.csv",
        include_str!("../template/map/resources/efficiency.csv"),
    )],
    ..LAG
};

const BATTERY: Example = Example {
    source: include_str!("../template/battery/lib.rs"),
    name: "Battery",
    ..LAG
};

/// Its source is also compiled and tested in place, as the crate `fmu-oven` of fmu-export.
const OVEN: Example = Example {
    source: include_str!("../template/events/lib.rs"),
    name: "Oven",
    serde: "serde = { version = \"1\", features = [\"derive\"] }\n",
    ..LAG
};

/// Words that are reserved by cargo or the compiler.
const RESERVED: &str = "\
    abstract alloc as async await become box break const continue core crate do dyn else enum extern \
    false final fn for if impl in let loop macro match mod move mut override priv proc-macro pub return \
    self static std struct super test trait true type use";

/// Names that the source uses for something else.
const MEANT: &str = "Parameters Input Output State Ode Model Mode Log Self";

/// Makes the crate at `path`, whose last part is its name. `fmu_export` is the folder of that crate
/// if it is not the one that this program was built with. The default model is a first-order lag.
pub fn new(path: &Path, fmu_export: Option<&Path>, example: Option<Name>) -> Result<()> {
    let example = match example {
        None => LAG,
        Some(Name::Rod) => ROD,
        Some(Name::Map) => DRIVE,
        Some(Name::Battery) => BATTERY,
        Some(Name::Events) => OVEN,
    };
    let name = path.file_name().and_then(|name| name.to_str());
    let name = name.with_context(|| format!("`{}` names no crate", path.display()))?;
    let model = model(name)?;
    let fmu_export = fmu_export_folder(fmu_export)?;
    ensure!(!path.exists(), "{} is already there", path.display());
    // Written to a temporary folder and renamed, so that a failure leaves no half of a crate.
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
    let parent = parent.unwrap_or(Path::new("."));
    let folder = tempfile::TempDir::with_prefix_in(".cargo-fmu-", parent)
        .with_context(|| parent.display().to_string())?;
    let content = folder.path().join("new");
    for (file, text) in TEMPLATE.iter().chain(example.files) {
        let source = example.source.replace(example.name, &model);
        let text = (text.replace("{{source}}", &source))
            .replace("{{serde}}", example.serde)
            .replace("{{name}}", name)
            .replace("{{model}}", &model);
        let file = content.join(file);
        fs::create_dir_all(file.parent().unwrap_or(&content))
            .and_then(|()| fs::write(&file, text.replace("{{fmu-export}}", &fmu_export)))
            .with_context(|| file.display().to_string())?;
    }
    fs::rename(&content, path).with_context(|| path.display().to_string())?;
    println!(
        "made {0}: `cd {0}`, then `cargo test` and `cargo fmu pack`; \
         `cargo fmu pack --target wasm` and `cargo fmu web` make a page of it",
        path.display()
    );
    Ok(())
}

/// Name of the model and its FMU: `HeatStore` for the crate `heat-store`.
fn model(name: &str) -> Result<String> {
    let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '_';
    let is_name = name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(is_word)
        && name.ends_with(|c: char| c.is_ascii_alphanumeric());
    if !is_name || name.len() > 64 {
        bail!(
            "the name `{name}` must be at most 64 lower-case letters (a to z), digits, `-` and `_`, begin with a letter and end with a \
             letter or digit"
        );
    }
    ensure!(
        !RESERVED.split(' ').any(|word| word == name),
        "the name `{name}` is a word of Rust or cargo; take another one"
    );
    let words = name.split(['-', '_']);
    let model: String = words
        .map(|word| word[..word.len().min(1)].to_uppercase() + word.get(1..).unwrap_or(""))
        .collect();
    ensure!(
        !MEANT.split(' ').any(|word| word == model),
        "the name `{name}` would make a model `{model}`, which fmu-export has a meaning for; take another one"
    );
    Ok(model)
}

/// The folder of fmu-export, as it is written into Cargo.toml.
fn fmu_export_folder(given: Option<&Path>) -> Result<String> {
    let built_from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fmu-export");
    let folder = given.map_or(built_from, PathBuf::from);
    let text = fs::read_to_string(folder.join("Cargo.toml")).unwrap_or_default();
    let is_it = (text.lines()).any(|line| line.trim() == "name = \"fmu-export\"");
    ensure!(
        is_it,
        "{} is not the folder of the crate fmu-export; it is on no registry yet, so say where its source is: --fmu-export PATH",
        folder.display()
    );
    let folder = fs::canonicalize(&folder).with_context(|| folder.display().to_string())?;
    let text = folder.to_str();
    let text = text.with_context(|| format!("{} must be UTF-8", folder.display()))?;
    // A backslash begins an escape in TOML; cargo accepts slashes on Windows too.
    Ok(text.trim_start_matches(r"\\?\").replace('\\', "/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_models() {
        assert_eq!(model("heat-store_2").unwrap(), "HeatStore2");
        assert_eq!(model("x").unwrap(), "X");
        for wrong in [
            "", "2x", "X", "a b", "a/", "ä", "a-", "self", "input", "std",
        ] {
            let refused = model(wrong).unwrap_err().to_string();
            assert!(
                refused.starts_with(&format!("the name `{wrong}`")),
                "{refused}"
            );
        }
        assert!(model(&"a".repeat(65)).is_err());
    }

    #[test]
    fn what_is_there_is_left_alone_and_nothing_half_made() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("lag");
        new(&path, None, None).unwrap();
        let manifest = fs::read_to_string(path.join("Cargo.toml")).unwrap();
        assert!(
            manifest.contains("name = \"lag\"") && !manifest.contains("{{"),
            "{manifest}"
        );
        let again = new(&path, None, Some(Name::Rod)).unwrap_err().to_string();
        assert!(again.ends_with("lag is already there"), "{again}");
        let nowhere = Path::new("/nowhere");
        let nowhere = new(&folder.path().join("other"), Some(nowhere), None).unwrap_err();
        assert!(
            nowhere.to_string().contains("--fmu-export PATH"),
            "{nowhere}"
        );
        let left: Vec<_> = fs::read_dir(folder.path())
            .unwrap()
            .map(|e| e.unwrap().file_name())
            .collect();
        assert_eq!(left, ["lag"]);
    }

    #[test]
    fn a_model_with_events_has_the_name_of_the_crate() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("heat-store");
        new(&path, None, Some(Name::Events)).unwrap();
        let read = |file: &str| fs::read_to_string(path.join(file)).unwrap();
        let (source, manifest) = (read("src/lib.rs"), read("Cargo.toml"));
        assert!(source.contains("impl Model for HeatStore") && !source.contains("Oven"));
        assert!(manifest.contains("\nserde = ") && !manifest.contains("{{"));
        assert!(!read("documentation/index.html").contains("{{"));
    }
}
