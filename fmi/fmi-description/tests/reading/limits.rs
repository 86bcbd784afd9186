//! Files that would fill memory or disk, or that only some systems can unpack, are refused by name.

use std::io::{Cursor, Write};

use fmi_description::xml::Element;
use fmi_description::{Archive, Description, limits, unportable};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::archives::by_hand;

fn refused(bytes: Vec<u8>) -> String {
    let error = Archive::open(bytes).err().expect("it is refused");
    error.to_string()
}

/// One file of `size` zeros, deflated.
fn zeros(size: usize) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default();
    zip.start_file("resources/zeros", options).unwrap();
    let chunk = vec![0; 1 << 20];
    for _ in 0..size >> 20 {
        zip.write_all(&chunk).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// The place of the directory's first entry.
fn directory(bytes: &[u8]) -> usize {
    let found = bytes.windows(4).position(|four| four == b"PK\x01\x02");
    found.unwrap()
}

/// The directory says what it unpacks to: 600 MiB from less than 1 MB, where 512 MiB are allowed.
#[test]
fn what_unpacks_to_too_much_is_refused() {
    let mut bytes = zeros(1 << 20);
    let (packed, unpacked, at) = (bytes.len(), 600 << 20, directory(&bytes));
    bytes[at + 24..at + 28].copy_from_slice(&u32::to_le_bytes(unpacked));
    let expected = format!(
        "it is too large: {packed} bytes unpack to {unpacked}; at most 536870912 are allowed for an archive of this size"
    );
    let error = refused(bytes);
    assert!(error.starts_with(&expected), "{error}");
    assert!(Archive::open(zeros(8 << 20)).is_ok());
    assert_eq!(limits::unpacked_size(1 << 30), 1 << 34);
    assert_eq!(limits::unpacked_size(10 << 20), 2000 << 20);
}

/// The directory says 5 bytes where there are 8 MiB: reading ends there.
#[test]
fn sizes_that_the_directory_understates_are_found_while_reading() {
    let mut bytes = zeros(8 << 20);
    let at = directory(&bytes);
    bytes[at + 24..at + 28].copy_from_slice(&5_u32.to_le_bytes());
    let mut archive = Archive::open(bytes).unwrap();
    let error = archive.file("resources/zeros").unwrap_err().to_string();
    assert!(
        error.contains("larger than its declared uncompressed size"),
        "{error}"
    );
}

/// A thousand names for the same bytes multiply them (Fifield 2019).
#[test]
fn files_that_share_bytes_are_refused() {
    let names = ["modelDescription.xml", "resources/a", "resources/b"];
    let mut bytes = by_hand(&names, false);
    let first = directory(&bytes);
    let entry = |k: usize| {
        let mut at = first;
        for name in &names[..k] {
            at += 46 + name.len();
        }
        at
    };
    let (second, third) = (entry(1), entry(2));
    bytes.copy_within(second + 42..second + 46, third + 42);
    assert_eq!(
        refused(bytes),
        "`resources/b` in it shares its bytes with another file"
    );
}

#[test]
fn files_that_are_there_twice_are_refused() {
    let xml = "modelDescription.xml";
    assert_eq!(
        refused(by_hand(&[xml, xml], false)),
        "two of its files have the same name"
    );
    assert_eq!(
        refused(by_hand(&[xml, "resources/a", "./resources//a"], false)),
        "`./resources//a` in it is there twice"
    );
}

#[test]
fn too_many_files_are_refused() {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for k in 0..=limits::FILES {
        zip.start_file(format!("{k}"), SimpleFileOptions::default())
            .unwrap();
    }
    let bytes = zip.finish().unwrap().into_inner();
    assert_eq!(
        refused(bytes),
        "it is too large: 100001 files; at most 100000 are allowed"
    );
}

#[test]
fn names_that_windows_cannot_have_are_known() {
    for name in ["resources/a b.txt", "a.b/c", "CONSOLE", "com10", "lpt", "ü"] {
        assert_eq!(unportable(name), None, "{name}");
    }
    for (name, part) in [
        ("resources/a?.txt", "character"),
        ("a:b", "character"),
        ("a\\b", "character"),
        ("a./b", "dot or a blank"),
        ("b/a ", "dot or a blank"),
        ("resources/NUL", "device"),
        ("resources/com1.txt", "device"),
        ("aux .x/y", "device"),
        ("LPT¹", "device"),
    ] {
        let reason = unportable(name).expect(name);
        assert!(reason.contains(part), "{name}: {reason}");
    }
}

#[test]
fn xml_that_multiplies_itself_is_refused() {
    let error = |text: &str| Element::parse(text, "f", "a").unwrap_err().to_string();
    let laughs = r#"<!DOCTYPE a [<!ENTITY l "ha"><!ENTITY m "&l;&l;&l;&l;">]><a b="&m;">&m;</a>"#;
    assert_eq!(
        error(laughs),
        "`f`, line 1: it declares entities (<!ENTITY), which are not read: what they stand for must be written out"
    );
    assert!(Element::parse("<!DOCTYPE a><a/>", "f", "a").is_ok());
    let attributes: String = (0..300).map(|k| format!(" a{k}=''")).collect();
    let text = error(&format!("<a>\n<b{attributes}/></a>"));
    assert_eq!(
        text,
        "`f`, line 2: it is no XML: an element has more than 256 attributes"
    );
}

fn arrays(variables: &str, structure: &str) -> Result<Description, String> {
    let text = format!(
        r#"<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="t"><CoSimulation modelIdentifier="M"/>
        <ModelVariables>{variables}</ModelVariables><ModelStructure>{structure}</ModelStructure></fmiModelDescription>"#
    );
    Description::parse(&text).map_err(|error| error.to_string())
}

#[test]
fn arrays_without_end_are_refused() {
    let array = |k: usize, size: usize, description: &str| {
        format!(
            r#"<Float64 name="a{k}" valueReference="{k}" causality="output" description="{description}"><Dimension start="{size}"/></Float64>"#
        )
    };
    let error = arrays(&(array(0, 1 << 21, "") + &array(1, (1 << 21) + 1, "")), "").unwrap_err();
    assert!(
        error.contains(
            "is too large: all arrays of an FMU may have 4194304 elements together (of `a1`)"
        ),
        "{error}"
    );
    let long = "text ".repeat(10_000);
    assert!(arrays(&array(0, 1 << 20, &long), "").is_err());
    let scalar = |k: usize| format!(r#"<Float64 name="y{k}" valueReference="{k}"/>"#);
    let scalars: String = (1..=20).map(scalar).collect();
    let listed = |k: usize| format!(r#"<Output valueReference="{k}" dependencies="0"/>"#);
    let listed: String = (1..=20).map(listed).collect();
    let error = arrays(&(array(0, 1 << 22, "") + &scalars), &listed).unwrap_err();
    assert!(
        error.contains("dependencies, counted by element"),
        "{error}"
    );
}

/// Elements of arrays share their dependencies: 3000 elements on 3000 others are one list.
#[test]
fn elements_share_their_dependencies() {
    let variables = r#"<Float64 name="u" valueReference="0" causality="input" start="0"><Dimension start="3000"/></Float64>
        <Float64 name="y" valueReference="1" causality="output"><Dimension start="3000"/></Float64>"#;
    let listed = r#"<Output valueReference="1" dependencies="0"/>"#;
    let description = arrays(variables, listed).unwrap().by_element();
    let lists = description.outputs.iter().map(|u| u.dependencies.clone());
    let lists: Vec<_> = lists.map(Option::unwrap).collect();
    assert_eq!((lists.len(), lists[0].len()), (3000, 3000));
    assert!(lists.iter().all(|list| list.as_ptr() == lists[0].as_ptr()));
}
