//! Two test FMUs, built as examples of this crate and packed as a system into a folder of their
//! own.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use cargo_fmu::library::exported_files;
use cosim::master::{Schedule, Stepping};
use cosim::structure::package::FmuPlace;
use cosim::structure::system::{Setting, System};
use fmi_description::Version;
use zip::CompressionMethod;
use zip::write::SimpleFileOptions;

/// A spring and a mass; `connections` is the content of `<ssd:Connections>`.
pub fn ssd(connections: &str) -> String {
    let connectors = |list: &[(&str, &str)]| -> String {
        list.iter()
            .map(|(name, kind)| {
                let data_type = match *name {
                    "off" | "is_left" => "Boolean",
                    "stage" | "steps" => "Integer",
                    _ => "Real",
                };
                format!(
                    "<ssd:Connector name=\"{name}\" kind=\"{kind}\"><ssc:{data_type}/></ssd:Connector>"
                )
            })
            .collect()
    };
    let component = |name: &str, source: &str, list: &[(&str, &str)]| {
        format!(
            "<ssd:Component name=\"{name}\" source=\"resources/{source}.fmu\"><ssd:Connectors>{}</ssd:Connectors></ssd:Component>",
            connectors(list)
        )
    };
    let spring = component(
        "spring",
        "Spring",
        &[
            ("x", "input"),
            ("x_dot", "input"),
            ("x_ddot", "input"),
            ("off", "input"),
            ("stage", "input"),
            ("F", "output"),
            ("F_mean", "output"),
        ],
    );
    let mass = component(
        "mass",
        "Mass",
        &[
            ("f", "input"),
            ("x", "output"),
            ("x_dot", "output"),
            ("x_ddot", "output"),
            ("is_left", "output"),
            ("steps", "output"),
        ],
    );
    format!(
        "<ssd:SystemStructureDescription xmlns:ssd=\"urn:ssd\" xmlns:ssc=\"urn:ssc\" version=\"1.0\" name=\"s\"><ssd:System name=\"s\">\
         <ssd:Elements>{spring}{mass}</ssd:Elements><ssd:Connections>{connections}</ssd:Connections></ssd:System>\
         <ssd:DefaultExperiment startTime=\"0.5\" stopTime=\"2.5\"/></ssd:SystemStructureDescription>"
    )
}

pub fn link(from: (&str, &str), to: (&str, &str), content: &str) -> String {
    format!(
        "<ssd:Connection startElement=\"{}\" startConnector=\"{}\" endElement=\"{}\" endConnector=\"{}\">{content}</ssd:Connection>",
        from.0, from.1, to.0, to.1
    )
}

/// The oscillator: motion to the spring, force to the mass as a power bond.
pub fn oscillator() -> String {
    ssd(&oscillator_links("", "", ""))
}

/// Its connections; `motion` and `force` stand in those of the motion and of the force, `bond` are
/// further attributes of the power bond.
pub fn oscillator_links(motion: &str, force: &str, bond: &str) -> String {
    let bond = format!(
        "<ssd:Annotations><ssc:Annotation type=\"io.github.hdrm-fmu.power-bond\"><PowerBond stepMean=\"F_mean\" flow=\"x_dot\" {bond}/>\
         </ssc:Annotation></ssd:Annotations>"
    );
    link(("mass", "x"), ("spring", "x"), motion)
        + &link(("mass", "x_dot"), ("spring", "x_dot"), motion)
        + &link(("spring", "F"), ("mass", "f"), &format!("{force}{bond}"))
}

/// Oscillators side by side, each pushed by the acceleration of the one before; numbered from 1.
pub fn oscillators(count: usize) -> String {
    let one = oscillator();
    let between = |tag: &str| {
        let (start, end) = (format!("<ssd:{tag}>"), format!("</ssd:{tag}>"));
        let from = one.find(&start).unwrap() + start.len();
        one[from..one.find(&end).unwrap()].to_string()
    };
    let (mut elements, mut connections) = (String::new(), String::new());
    for k in 1..=count {
        let numbered = |text: String| {
            let [spring, mass] = ["spring", "mass"].map(|name| format!("\"{name}{k}\""));
            text.replace("\"spring\"", &spring)
                .replace("\"mass\"", &mass)
        };
        elements += &numbered(between("Elements"));
        connections += &numbered(between("Connections"));
        if k > 1 {
            let [from, to] = [format!("mass{}", k - 1), format!("spring{k}")];
            connections += &link((&from, "x_ddot"), (&to, "x_ddot"), "");
        }
    }
    one.replace(&between("Elements"), &elements)
        .replace(&between("Connections"), &connections)
}

/// Pack a system and load it. `name` keeps the files of several tests apart.
pub fn system(name: &str, structure: &str) -> anyhow::Result<System> {
    edited(name, structure, |_, description| description.to_string())
}

/// The same with other model descriptions; `edit` is given the name of each example and the text of
/// its own.
pub fn edited(
    name: &str,
    structure: &str,
    edit: impl Fn(&str, &str) -> String,
) -> anyhow::Result<System> {
    edited_of(Version::Fmi2, name, structure, edit)
}

/// The same with FMUs of a version of FMI.
pub fn edited_of(
    version: Version,
    name: &str,
    structure: &str,
    edit: impl Fn(&str, &str) -> String,
) -> anyhow::Result<System> {
    let dir = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&dir).unwrap();
    let path = dir.join("system.ssp");
    let mut entries = vec![(
        "SystemStructure.ssd".to_string(),
        structure.as_bytes().to_vec(),
    )];
    for example in ["spring", "mass"] {
        let model = example[..1].to_uppercase() + &example[1..];
        let mut files = files(example, version);
        for (name, bytes) in &mut files {
            if name == "modelDescription.xml" {
                let text = edit(example, std::str::from_utf8(bytes).unwrap());
                *bytes = text.into_bytes();
            }
        }
        entries.push((format!("resources/{model}.fmu"), packed(&files)));
    }
    write_zip(File::create(&path).unwrap(), &entries);
    load(&path)
}

/// Load a system with its FMUs where it says.
pub fn load(path: &Path) -> anyhow::Result<System> {
    let else_in = Vec::new();
    System::load(path, None, &FmuPlace::Structure { else_in }, &[], &[])
}

/// The FMU of an example.
pub fn fmu(example: &str) -> Vec<u8> {
    packed(&files(example, Version::Fmi2))
}

pub fn packed(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    write_zip(&mut bytes, files);
    bytes.into_inner()
}

pub fn files(example: &str, version: Version) -> Vec<(String, Vec<u8>)> {
    let library = library(example);
    let mut files = exported_files(&library, version).unwrap();
    let model = example[..1].to_uppercase() + &example[1..];
    let platform = fmi_description::platform::host().unwrap();
    let file = platform.library(version, &model).unwrap();
    files.insert(file, fs::read(library).unwrap());
    files.into_iter().collect()
}

/// Pack an FMU with this description, and with libraries in the folder of a platform.
pub fn pack(file: &Path, description: &str, platform: &str, libraries: &[&Path]) {
    let mut files = vec![("modelDescription.xml".to_string(), description.into())];
    for library in libraries {
        let name = library.file_name().unwrap().to_string_lossy();
        let bytes = fs::read(library).unwrap();
        files.push((format!("binaries/{platform}/{name}"), bytes));
    }
    write_zip(File::create(file).unwrap(), &files);
}

/// The library of an example.
pub fn library(example: &str) -> PathBuf {
    let file = format!(
        "{}test_{example}{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    );
    let built = std::env::current_exe()
        .unwrap()
        .ancestors()
        .nth(2)
        .unwrap()
        .join("examples")
        .join(file);
    assert!(
        built.is_file(),
        "{} is missing; `cargo test -p cosim` builds it, `--test` alone does not",
        built.display()
    );
    built
}

pub fn write_zip<W: Write + std::io::Seek>(out: W, entries: &[(String, Vec<u8>)]) {
    // Not compressed: libraries with debug information are large, and nobody keeps these archives.
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let mut zip = zip::ZipWriter::new(out);
    for (name, bytes) in entries {
        zip.start_file(name.as_str(), options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
}

pub fn settings(system: &System, texts: &[&str]) -> anyhow::Result<Vec<Setting>> {
    let settings = texts.iter().map(|text| system.parse_settings(text));
    let settings: Vec<_> = settings.collect::<anyhow::Result<_>>()?;
    Ok(settings.concat())
}

pub fn stepping(step: f64, schedule: Schedule) -> Stepping {
    Stepping::new(0.5, step, schedule)
}

/// A text, such as that of an error, has these parts.
#[track_caller]
pub fn assert_contains(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "`{part}` is missing in: {text}");
    }
}

/// A file beside the packed systems.
pub fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}
