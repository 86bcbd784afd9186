//! `cargo fmu web`: makes one HTML file that runs an FMU or a packed system in a browser without a
//! server. It contains the page, the master's module, and the archive with the modules of the FMUs.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::library::{self, Version};
use crate::pack;
use crate::target::{self, Tools};
use crate::workspace::{Source, Workspace};
use fmi_description::entries::{self, Entries};
use fmu_check::component;

/// The parts that a page is made of.
pub struct Page<'a> {
    /// An HTML file; files that it names are looked for in its folder, then among those of the page
    /// for any model. None means that page.
    pub html: Option<&'a Path>,
    /// The master's module; None builds it from the source that this program was built from.
    pub engine: Option<&'a Path>,
    /// The cargo profile with which it is built.
    pub profile: &'a str,
    /// Texts for the page's script, each as NAME=FILE.
    pub data: &'a [String],
}

impl Page<'_> {
    /// Writes the page of an FMU or a packed system; returns its size in bytes.
    pub fn write(&self, model: &Path, out: &Path) -> Result<usize> {
        let name = || model.display().to_string();
        output_file::note_read(model)?;
        let entries = entries::read(model)?;
        let entries = match model.extension().is_some_and(|suffix| suffix == "ssp") {
            true => system(entries, &model.with_file_name(pack::FMI3_FOLDER)),
            false => fmu(entries),
        };
        // The browser inflates the whole archive faster than the page's master each file.
        let archive = entries::stored(&entries.with_context(name)?)?;
        let engine = match self.engine {
            Some(engine) => engine.to_path_buf(),
            None => built_engine(self.profile)?,
        };
        let engine = fs::read(&engine).with_context(|| engine.display().to_string())?;
        let mut parts = vec![
            binary("part-engine", &engine)?,
            binary("part-system", &archive)?,
            script("text/plain", "part-worker", &self.source("worker.js")?)?,
        ];
        for data in self.data {
            let (name, file) = data.split_once('=').context("data is NAME=FILE")?;
            let text = fs::read_to_string(file).with_context(|| file.to_string())?;
            // `<` is escaped, since `</` could end the script element.
            let text = text.replace('<', "\\u003c");
            parts.push(script("application/json", name, &text)?);
        }
        let page = page_files::with_policy(&self.inlined(&parts.concat())?)
            .context("the page's head must begin with <meta charset=\"utf-8\">")?;
        output_file::write(out, &page)?;
        Ok(page.len())
    }

    fn source(&self, name: &str) -> Result<String> {
        let own = self.html.map(|page| page.with_file_name(name));
        match (own.filter(|file| file.is_file()), page_files::file(name)) {
            (Some(file), _) => {
                fs::read_to_string(&file).with_context(|| file.display().to_string())
            }
            (None, Some(text)) => Ok(text.to_string()),
            (None, None) => bail!("the page has no {name}"),
        }
    }

    /// The page with the files that it names inserted, and these elements before its script.
    fn inlined(&self, parts: &str) -> Result<String> {
        let html = self.html.and_then(Path::file_name);
        let html = html.map_or("model.html".into(), |name| name.to_string_lossy());
        let mut page = String::new();
        for line in self.source(&html)?.lines() {
            let line = match between(line, r#"<link rel="stylesheet" href=""#, r#"">"#) {
                Some(file) => format!("<style>\n{}</style>", self.source(file)?),
                None => match between(line, r#"<script src=""#, r#""></script>"#) {
                    Some(file) => script("text/javascript", file, &self.source(file)?)?,
                    None => match between(line, r#"<script type="module" src=""#, r#""></script>"#)
                    {
                        Some(file) => parts.to_string() + &self.bundle(file)?,
                        None => line.to_string(),
                    },
                },
            };
            page += &line;
            page.push('\n');
        }
        Ok(page)
    }

    /// A module and those that it imports as one script. Each import must be in a line of its own,
    /// and names must not clash between modules.
    fn bundle(&self, entry: &str) -> Result<String> {
        let (mut order, mut text) = (Vec::new(), String::new());
        self.visit(entry, &mut order, &mut text)?;
        let own = format!("(() => {{\n\"use strict\";\n{text}}})();\n");
        script("text/javascript", entry, &own)
    }

    fn visit(&self, name: &str, order: &mut Vec<String>, text: &mut String) -> Result<()> {
        if order.iter().any(|visited| visited == name) {
            return Ok(());
        }
        order.push(name.to_string());
        let mut own = String::new();
        for line in self.source(name)?.lines() {
            if let Some(imported) =
                between(line, "from \"./", "\";").filter(|_| line.starts_with("import "))
            {
                self.visit(imported, order, text)?;
                continue;
            }
            ensure!(
                !line.starts_with("import "),
                "{name}: `{line}` must import from a module beside it"
            );
            own += line.strip_prefix("export ").unwrap_or(line);
            own.push('\n');
        }
        *text += &own;
        Ok(())
    }
}

fn between<'a>(line: &'a str, before: &str, after: &str) -> Option<&'a str> {
    line.split_once(before)?.1.strip_suffix(after)
}

/// A script element that contains a text.
fn script(kind: &str, name: &str, text: &str) -> Result<String> {
    ensure!(!text.contains("</script"), "{name} would end its element");
    Ok(format!(
        "<script type=\"{kind}\" id=\"{name}\">\n{text}</script>\n"
    ))
}

/// A script element that contains compressed bytes.
fn binary(name: &str, bytes: &[u8]) -> Result<String> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
    gzip.write_all(bytes)?;
    let text = STANDARD.encode(gzip.finish()?);
    script("application/octet-stream;base64", name, &text)
}

/// The files of an FMU for a page, with its plain module instead of all libraries.
fn fmu(mut entries: Entries) -> Result<Entries> {
    let description = library::description(&entries)?;
    let identifier = description.identifier;
    ensure!(
        description.fmi == Version::Fmi3,
        "it is of FMI 2.0, for which there is no WebAssembly: take the FMU of FMI 3.0 instead, which `cargo fmu pack --target wasm` puts into the folder fmi3/ for a model in Rust with fmu-export"
    );
    let plain = format!("binaries/wasm32-unknown-unknown/{identifier}.wasm");
    let module = match (
        entries.get(&plain),
        entries.get(&component::path(&identifier)),
    ) {
        (Some(module), _) => module.clone(),
        (None, Some(component)) => component::module(component)?
            .context("its component holds no module")?
            .to_vec(),
        (None, None) => bail!(
            "it has no WebAssembly ({}); for a model in Rust with fmu-export, `cargo fmu pack --target wasm` packs it into the FMU of FMI 3.0, in the folder fmi3/",
            component::path(&identifier)
        ),
    };
    let exports = component::exports(&module)?;
    ensure!(
        exports.iter().any(|name| name == "fmi3DoStep"),
        "its WebAssembly does not export the C functions of FMI 3.0, which a page calls; fmu-export makes such modules"
    );
    entries.retain(|name, _| !name.starts_with("binaries/") && !name.starts_with("sources/"));
    entries.insert(plain, module);
    Ok(entries)
}

/// The files of a packed system for a page. An FMU of FMI 2.0 has no WebAssembly: the one of FMI 3.0
/// with its file name in the folder `fmi3`, where `cargo fmu pack` puts it, is taken in its place.
fn system(entries: Entries, fmi3: &Path) -> Result<Entries> {
    let for_page = |(name, bytes): (String, Vec<u8>)| {
        if !name.ends_with(".fmu") {
            return Ok((name, bytes));
        }
        let mut entries = entries::read_bytes(bytes).with_context(|| name.clone())?;
        let file = Path::new(&name).file_name().unwrap_or_default();
        let other = fmi3.join(file);
        let description = library::description(&entries).with_context(|| name.clone())?;
        if description.fmi == Version::Fmi2 {
            ensure!(
                other.is_file(),
                "{name} in it is of FMI 2.0, for which there is no WebAssembly, and there is no {}: put the FMU of FMI 3.0 with \
                 WebAssembly there, or into the package; for a model in Rust with fmu-export, `cargo fmu pack --target wasm` makes it",
                other.display()
            );
            let replaced = entries::read(&other).with_context(|| other.display().to_string())?;
            let model = library::description(&replaced)?.model;
            ensure!(
                model == description.model,
                "{name} in it is the model `{}` of FMI 2.0, but {} is `{model}`",
                description.model,
                other.display()
            );
            eprintln!(
                "takes {} in the place of {name}, which is of FMI 2.0",
                other.display()
            );
            entries = replaced;
        }
        let entries = fmu(entries).with_context(|| name.clone())?;
        let bytes = entries::stored(&entries)?;
        Ok((name, bytes))
    };
    entries.into_iter().map(for_page).collect()
}

/// Builds the master's module from the source that this program was built from.
fn built_engine(profile: &str) -> Result<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../master/cosim-page");
    ensure!(
        source.join("Cargo.toml").is_file(),
        "the page needs its master, and its source is not at {}: download cosim_page.wasm of the release {} and say where it is: --engine cosim_page.wasm",
        source.display(),
        env!("CARGO_PKG_VERSION")
    );
    eprintln!(
        "compiling the page's engine for WebAssembly, which takes minutes the first time (--profile release: fewer)"
    );
    let workspace = Workspace::containing(&source)?;
    let build = target::WASM.build(&workspace, &Tools::default())?;
    let sources = [Source::Package("cosim-page".to_string())];
    let profile = pack::profile(profile);
    let mut built = workspace.build_with(build, &sources, &profile)?;
    Ok(built.remove(0).0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A module that exports an empty function fmi3DoStep.
    const MODULE: &[u8] = b"\0asm\x01\0\0\0\x01\x04\x01\x60\0\0\x03\x02\x01\0\x07\x0e\x01\x0afmi3DoStep\0\0\x0a\x04\x01\x02\0\x0b";

    fn archive(version: &str, model: &str, hash: &str) -> Vec<u8> {
        let kind = match version {
            "2.0" => "ModelVariables/><ModelStructure",
            _ => {
                "ModelVariables><Float64 name=\"time\" valueReference=\"0\" causality=\"independent\"/></ModelVariables><ModelStructure"
            }
        };
        let xml = format!(
            "<fmiModelDescription fmiVersion=\"{version}\" modelName=\"{model}\" {hash}=\"x\"><CoSimulation modelIdentifier=\"{model}\"/><{kind}/></fmiModelDescription>"
        );
        let mut files = Entries::from([("modelDescription.xml".to_string(), xml.into_bytes())]);
        if version == "3.0" {
            let module = format!("binaries/wasm32-unknown-unknown/{model}.wasm");
            files.insert(module, MODULE.to_vec());
        }
        entries::stored(&files).unwrap()
    }

    #[test]
    fn a_package_of_fmi_2_takes_the_fmus_of_fmi_3_next_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let fmi3 = folder.path().join("fmi3");
        let package = || {
            let files = [
                ("SystemStructure.ssd", b"x".to_vec()),
                ("resources/Lag.fmu", archive("2.0", "Lag", "guid")),
            ];
            Entries::from(files.map(|(name, bytes)| (name.to_string(), bytes)))
        };
        let refused = system(package(), &fmi3).unwrap_err().to_string();
        assert!(
            refused.starts_with("resources/Lag.fmu in it is of FMI 2.0")
                && refused.contains("--target wasm"),
            "{refused}"
        );
        fs::create_dir(&fmi3).unwrap();
        fs::write(
            fmi3.join("Lag.fmu"),
            archive("3.0", "Other", "instantiationToken"),
        )
        .unwrap();
        let refused = system(package(), &fmi3).unwrap_err().to_string();
        assert!(refused.ends_with("is `Other`"), "{refused}");
        fs::write(
            fmi3.join("Lag.fmu"),
            archive("3.0", "Lag", "instantiationToken"),
        )
        .unwrap();
        let mut taken = system(package(), &fmi3).unwrap();
        assert_eq!(taken["SystemStructure.ssd"], b"x");
        let inside = entries::read_bytes(taken.remove("resources/Lag.fmu").unwrap()).unwrap();
        assert_eq!(inside["binaries/wasm32-unknown-unknown/Lag.wasm"], MODULE);
    }
}
