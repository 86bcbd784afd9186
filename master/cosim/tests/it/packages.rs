//! Packed systems: what they may name, packages in packages, encodings, and values as other tools
//! write them.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use cosim::structure::package::{FmuPlace, Package};
use cosim::structure::system::System;

use super::program::cosim;
use super::support::{
    assert_contains, edited, fmu, link, load, oscillator, scratch, ssd, write_zip,
};

/// A folder with the FMUs of the oscillator, and a packed system with the same in `resources`.
fn folder(name: &str, structure: &str) -> (PathBuf, Vec<(String, Vec<u8>)>) {
    let folder = scratch(name);
    fs::create_dir_all(&folder).unwrap();
    let mut files = vec![("SystemStructure.ssd".to_string(), structure.into())];
    for (file, example) in [("Spring.fmu", "spring"), ("Mass.fmu", "mass")] {
        fs::write(folder.join(file), fmu(example)).unwrap();
        files.push((format!("resources/{file}"), fmu(example)));
    }
    (folder, files)
}

fn pack(path: &Path, files: &[(String, Vec<u8>)]) {
    write_zip(File::create(path).unwrap(), files);
}

/// Loads a system whose FMUs also lie in `folder`, where a structure by itself may take them.
fn load_near(path: &Path, folder: &Path) -> Result<System, String> {
    let else_in = vec![folder.to_path_buf()];
    let system = System::load(path, None, &FmuPlace::Structure { else_in }, &[], &[]);
    system.map_err(|error| format!("{error:#}"))
}

#[test]
fn a_package_takes_nothing_from_outside() {
    let (folder, files) = folder("outside", &oscillator());
    let path = folder.join("system.ssp");
    let spring = folder.join("Spring.fmu").display().to_string();
    let from = |source: &str| {
        let structure = oscillator().replace("resources/Spring.fmu", source);
        pack(
            &path,
            &[
                ("SystemStructure.ssd".into(), structure.into()),
                files[2].clone(),
            ],
        );
        load_near(&path, &folder).map(drop)
    };
    let missing = from("resources/Spring.fmu").unwrap_err();
    let told = [
        "system.ssp` holds no resources/Spring.fmu",
        "--fmu COMPONENT=FILE",
    ];
    assert_contains(&missing, &told);
    let leads_out = "leads out of the package";
    let elsewhere = "is no path in the package";
    for (source, reason) in [
        ("../Spring.fmu", leads_out),
        ("resources/../../Spring.fmu", leads_out),
        ("resources\\..\\..\\Spring.fmu", leads_out),
        ("%2e%2e/Spring.fmu", leads_out),
        ("resources%2F..%2f%2E./Spring.fmu", leads_out),
        ("file://../Spring.fmu", leads_out),
        (&spring, elsewhere),
        (&format!("file://{spring}"), elsewhere),
        ("file:Spring.fmu", elsewhere),
        ("http://localhost/Spring.fmu", elsewhere),
        ("C:/Spring.fmu", elsewhere),
        ("C%3A\\Spring.fmu", elsewhere),
        ("\\\\server\\Spring.fmu", elsewhere),
    ] {
        let error = from(source).unwrap_err();
        assert_contains(&error, &["FMU of component `spring`", reason]);
    }
    // What stays inside is read, whoever wrote it.
    pack(&path, &files);
    load_near(&path, &folder).unwrap();
    for source in [
        "resources\\Spring.fmu",
        "x/../resources/./Spring.fmu",
        "file://resources/Spring.fmu",
    ] {
        let structure = oscillator().replace("resources/Spring.fmu", source);
        let own = ("SystemStructure.ssd".to_string(), structure.into_bytes());
        pack(&path, &[own, files[1].clone(), files[2].clone()]);
        load_near(&path, &folder).map(drop).expect(source);
    }
    // What the user names is taken from anywhere.
    pack(&path, &[files[0].clone(), files[2].clone()]);
    let file = path.display().to_string();
    let run = |more: &[&str]| {
        let base = ["run", "--quiet", "--stop-time", "0.6", "--system", &file];
        cosim(&[&base[..], more].concat())
    };
    assert_eq!(run(&[]).0, 1);
    let named = format!("spring={spring}");
    assert_eq!(run(&["--fmu", &named]).0, 0);
    assert_eq!(run(&["--fmu-dir", &folder.display().to_string()]).0, 0);
}

#[test]
fn other_files_of_a_package_come_from_it_too() {
    let bound = "<ssd:ParameterBindings><ssd:ParameterBinding source=\"SOURCE\"/></ssd:ParameterBindings><ssd:Elements>";
    let (folder, files) = folder("outside-files", &oscillator());
    let path = folder.join("system.ssp");
    fs::write(folder.join("x.ssv"), "<ssv:ParameterSet/>").unwrap();
    let component = |kind: &str, source: &str| {
        format!(
            "<ssd:Component name=\"n\" type=\"application/x-ssp-{kind}\" source=\"{source}\"/></ssd:Elements>"
        )
    };
    for (old, new) in [
        ("<ssd:Elements>", bound.replace("SOURCE", "../x.ssv")),
        ("</ssd:Elements>", component("definition", "../x.ssd")),
        ("</ssd:Elements>", component("package", "../x.ssp")),
    ] {
        let structure = oscillator().replacen(old, &new, 1);
        let own = ("SystemStructure.ssd".to_string(), structure.into_bytes());
        pack(&path, &[own, files[1].clone(), files[2].clone()]);
        let error = load_near(&path, &folder).err().expect(&new);
        assert_contains(&error, &["leads out of the package"]);
    }
}

/// A structure in a folder keeps its `../`, and finds FMUs where the programs look for them.
#[test]
fn a_structure_by_itself_may_name_its_neighbours() {
    let (folder, _) = folder("loose", &oscillator());
    let inner = folder.join("deep");
    fs::create_dir_all(&inner).unwrap();
    let structure = oscillator().replace("resources/Spring.fmu", "../Spring.fmu");
    fs::write(inner.join("s.ssd"), &structure).unwrap();
    load_near(&inner.join("s.ssd"), &folder).unwrap();
    let absolute = folder.join("Spring.fmu").display().to_string();
    let structure = oscillator().replace("resources/Spring.fmu", &absolute);
    fs::write(inner.join("s.ssd"), &structure).unwrap();
    load_near(&inner.join("s.ssd"), &folder).unwrap();
}

fn nest(source: &str) -> String {
    format!(
        "<ssd:SystemStructureDescription xmlns:ssd=\"urn:ssd\" version=\"1.0\" name=\"s\"><ssd:System name=\"s\"><ssd:Elements>\
         <ssd:Component name=\"in\" type=\"application/x-ssp-package\" source=\"{source}\"/></ssd:Elements></ssd:System>\
         <ssd:DefaultExperiment stopTime=\"1\"/></ssd:SystemStructureDescription>"
    )
}

/// Sixteen packages in each other run; the seventeenth is refused. None leads out of itself.
#[test]
fn packages_in_packages_are_read() {
    let (folder, files) = folder("nested", &oscillator());
    let path = folder.join("system.ssp");
    let packed = |files: &[(String, Vec<u8>)]| {
        pack(&path, files);
        fs::read(&path).unwrap()
    };
    let wrap = |inner: Vec<u8>, source: &str| {
        let own = ("SystemStructure.ssd".to_string(), nest(source).into_bytes());
        packed(&[own, (source.to_string(), inner)])
    };
    let mut bytes = packed(&files);
    for k in 0..16 {
        bytes = wrap(bytes, ["parts/inner.ssp", "inner.zip"][k % 2]);
    }
    let system = load(&path).unwrap();
    let names: Vec<_> = system
        .structure
        .components
        .iter()
        .map(|c| &c.name)
        .collect();
    assert_eq!(names[1], &("in.".repeat(16) + "mass"));
    // The same from a structure in a folder.
    fs::write(folder.join("s.ssd"), nest("system.ssp")).unwrap();
    let error = format!("{:#}", load(&folder.join("s.ssd")).err().unwrap());
    assert_contains(&error, &["nested deeper than 16"]);
    wrap(packed(&files), "inner.ssp");
    let system = load(&folder.join("s.ssd")).unwrap();
    assert_eq!(system.structure.components[1].name, "in.in.mass");
    // An inner package is shut as the outer one is.
    let spring = folder.join("Spring.fmu").display().to_string();
    for (source, reason) in [
        ("../resources/Spring.fmu", "leads out of the package"),
        (&*spring, "is no path in the package"),
        ("resources/None.fmu", "holds no resources/None.fmu"),
    ] {
        let structure = oscillator().replace("resources/Spring.fmu", source);
        let own = ("SystemStructure.ssd".to_string(), structure.into_bytes());
        let inner = packed(&[own, files[2].clone()]);
        let outer = (
            "SystemStructure.ssd".to_string(),
            nest("inner.ssp").into_bytes(),
        );
        pack(
            &path,
            &[outer, ("inner.ssp".into(), inner), files[1].clone()],
        );
        for file in ["system.ssp", "s.ssd"] {
            let error = load_near(&folder.join(file), &folder).err().expect(source);
            assert_contains(&error, &[reason]);
        }
    }
}

fn encodings(text: &str) -> Vec<Vec<u8>> {
    let declared = format!("<?xml version=\"1.0\" encoding=\"UTF-16\"?>{text}");
    let little: Vec<u8> = declared.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = declared.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let marked = [&[0xff, 0xfe][..], &little].concat();
    vec![marked, [&[0xfe, 0xff][..], &big].concat(), little, big]
}

#[test]
fn files_of_a_system_may_be_in_utf_16() {
    let bound = "<ssd:ParameterBindings><ssd:ParameterBinding source=\"k.ssv\"><ssd:ParameterMapping source=\"k.ssm\"/></ssd:ParameterBinding>\
        </ssd:ParameterBindings><ssd:SignalDictionaries><ssd:SignalDictionary name=\"d\" source=\"d.ssb\"/></ssd:SignalDictionaries><ssd:Elements>";
    let structure = oscillator().replacen("<ssd:Elements>", bound, 1);
    let set = "<ssv:ParameterSet version=\"1.0\" name=\"ü\"><ssv:Parameters><ssv:Parameter name=\"ü\"><ssv:Real value=\"\r\n 7.5 \t\" unit=\"\"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>";
    let mapping = "<ssm:ParameterMapping version=\"1.0\"><ssm:MappingEntry source=\"ü\" target=\"spring.k\"/></ssm:ParameterMapping>";
    let dictionary = "<ssb:SignalDictionary version=\"1.0\"/>";
    let (folder, files) = folder("utf16", &structure);
    let path = folder.join("system.ssp");
    let texts = [
        ("SystemStructure.ssd", &*structure),
        ("k.ssv", set),
        ("k.ssm", mapping),
        ("d.ssb", dictionary),
    ];
    for k in 0..4 {
        let own = texts.map(|(name, text)| (name.to_string(), encodings(text)[k].clone()));
        pack(&path, &[&own[..], &files[1..]].concat());
        let system = load(&path).unwrap();
        let spring = &system.structure.components[0];
        assert_eq!(spring.parameters[0].value.trim(), "7.5");
        let port = system.port("spring.k").unwrap();
        assert_eq!(cosim::master::start_value(&system, &[], port).unwrap(), 7.5);
    }
    let cut = [&encodings("<a/>")[0][..], &[0]].concat();
    pack(&path, &[("SystemStructure.ssd".into(), cut)]);
    let error = format!("{:#}", load(&path).err().unwrap());
    assert_contains(
        &error,
        &["`SystemStructure.ssd` is no text", "it is not UTF-16"],
    );
}

/// OMSimulator names the enclosing system by an empty element, and no unit by an empty one.
#[test]
fn an_empty_element_is_the_system_and_an_empty_unit_is_none() {
    let outer = "<ssd:Connectors><ssd:Connector name=\"pull\" kind=\"input\"><ssc:Real unit=\"\"/></ssd:Connector></ssd:Connectors><ssd:Elements>";
    let links = link(("mass", "x"), ("spring", "x"), "") + &link(("", "pull"), ("mass", "f"), "");
    let structure = ssd(&links).replacen("<ssd:Elements>", outer, 1);
    let structure = structure.replace("<ssc:Real/>", "<ssc:Real unit=\"\"/>");
    let system = edited("empty-names", &structure, |_, text| {
        text.replace("unit=\"m\"", "unit=\"\"")
    });
    let system = system.unwrap();
    let input = &system.structure.inputs[0];
    assert_eq!((input.name.as_str(), &input.unit), ("pull", &None));
    assert_eq!(input.ends[0].0, ("mass".into(), "f".into()));
    let x = system.variable(system.port("mass.x").unwrap());
    assert_eq!(x.unit, None);
    assert!(system.wiring().unwrap().remarks.is_empty());
}

/// `stage` of the spring as an enumeration with the items 0 and 2.
fn with_stages(name: &str, structure: &str) -> System {
    let system = edited(name, structure, |_, text| {
        let items = "<SimpleType name=\"Stage\"><Enumeration><Item name=\"soft\" value=\"0\"/><Item name=\"hard\" value=\"2\"/></Enumeration></SimpleType>";
        let text = match text.contains("<TypeDefinitions>") {
            true => text.replace("<TypeDefinitions>", &format!("<TypeDefinitions>{items}")),
            false => text.replace(
                "<ModelVariables>",
                &format!("<TypeDefinitions>{items}</TypeDefinitions><ModelVariables>"),
            ),
        };
        let at = text.find("name=\"stage\"").unwrap_or(0);
        let (before, after) = text.split_at(at);
        before.to_string() + &after.replacen("<Integer", "<Enumeration declaredType=\"Stage\"", 1)
    });
    system.unwrap()
}

#[test]
fn numbers_that_are_no_item_of_an_enumeration_are_refused() {
    let structure = oscillator().replace(
        "name=\"stage\" kind=\"input\"><ssc:Integer/>",
        "name=\"stage\" kind=\"input\"><ssc:Enumeration/>",
    );
    let system = with_stages("items", &structure);
    let start = |text: &str| {
        let settings = system.parse_settings(text).unwrap();
        let port = settings[0].port;
        cosim::master::start_value(&system, &settings, port).map_err(|e| format!("{e:#}"))
    };
    assert_eq!(start("spring.stage= 2 "), Ok(2.0));
    assert_eq!(start("spring.stage=hard"), Ok(2.0));
    for text in ["1", "3", "-1"] {
        let error = start(&format!("spring.stage={text}")).unwrap_err();
        let expected = format!("spring.stage: `{text}` is not one of soft (0), hard (2)");
        assert_contains(&error, &[&expected]);
    }
    let set = scratch("items.ssv");
    let value = |text: &str| {
        let text = format!(
            "<ssv:ParameterSet version=\"1.0\" name=\"x\"><ssv:Parameters><ssv:Parameter name=\"spring.stage\"><ssv:{text}/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>"
        );
        fs::write(&set, text).unwrap();
        let mut system = system.clone();
        system.apply_set(&set).unwrap();
        let port = system.port("spring.stage").unwrap();
        cosim::master::start_value(&system, &[], port).map_err(|e| format!("{e:#}"))
    };
    assert_eq!(value("Enumeration value=\"hard\""), Ok(2.0));
    assert_eq!(value("Integer value=\"\n2\t\""), Ok(2.0));
    for text in ["Enumeration value=\"1\"", "Integer value=\"1\""] {
        assert_contains(
            &value(text).unwrap_err(),
            &["items.ssv", "`1` is not one of soft"],
        );
    }
    let path = scratch("items").join("system.ssp").display().to_string();
    let table = scratch("items.csv");
    fs::write(&table, "time,spring.stage\n0,2\n1,1\n").unwrap();
    let arguments = [
        "run",
        "--quiet",
        "--system",
        &path,
        "--input",
        &table.display().to_string(),
    ];
    let (code, _, error) = cosim(&arguments);
    assert_eq!(code, 1, "{error}");
    assert_contains(
        &error,
        &["row 3, column `spring.stage`: `1` is not one of soft (0), hard (2)"],
    );
}

/// A package may unpack to no more with the packages and FMUs in it than by itself.
#[test]
fn what_is_packed_inside_counts() {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    zip.start_file("resources/zeros", options).unwrap();
    std::io::Write::write_all(&mut zip, &vec![0; 1 << 20]).unwrap();
    let mut bytes = zip.finish().unwrap().into_inner();
    let at = bytes
        .windows(4)
        .position(|four| four == b"PK\x01\x02")
        .unwrap();
    bytes[at + 24..at + 28].copy_from_slice(&(300_u32 << 20).to_le_bytes());
    let path = scratch("inside.ssp");
    let inner = |k: usize| (format!("{k}.ssp"), bytes.clone());
    pack(&path, &[inner(0), inner(1)]);
    let mut package = Package::open(&path).unwrap();
    let none = |error: anyhow::Error| format!("{error:#}");
    let first = package.file("0.ssp/none").map_err(none).unwrap_err();
    assert_contains(&first, &["inside.ssp/0.ssp` holds no none"]);
    let second = package.file("1.ssp/none").map_err(none).unwrap_err();
    assert_contains(&second, &["with what is packed inside, it is too large"]);
}
