//! Archives as other tools make them, written here byte by byte where the ZIP writer knows no such
//! thing.

use std::io::{Cursor, Write};
use std::path::PathBuf;

use fmi_description::{Archive, Remark, platform};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

const TEXT: &str = r#"<fmiModelDescription fmiVersion="2.0" modelName="Lag" guid="{1}">
  <CoSimulation modelIdentifier="Lag"/><ModelVariables/><ModelStructure/></fmiModelDescription>"#;

pub fn zip(names: &[&str], options: SimpleFileOptions) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for name in names {
        if name.ends_with('/') {
            zip.add_directory(*name, options).unwrap();
        } else {
            zip.start_file(*name, options).unwrap();
            zip.write_all(content(name)).unwrap();
        }
    }
    zip.finish().unwrap().into_inner()
}

fn content(name: &str) -> &[u8] {
    match name.ends_with("modelDescription.xml") {
        true => TEXT.as_bytes(),
        false => b"library",
    }
}

/// An archive by hand: each file stored, sizes in a data descriptor behind it (bit 3 of the flags),
/// as those write who cannot go back in their output (APPNOTE, sections 4.3.9 and 4.4.4); with
/// `zip64` the sizes stand in an extra field of the directory (section 4.5.3).
pub fn by_hand(names: &[&str], zip64: bool) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for name in names {
        let (content, offset) = (content(name), u32::try_from(bytes.len()).unwrap());
        let crc = crc32(content).to_le_bytes();
        let size = u32::try_from(content.len()).unwrap();
        let length = u16::try_from(name.len()).unwrap();
        bytes.extend(b"PK\x03\x04\x14\0\x08\0\0\0\0\0\x21\0");
        bytes.extend([0; 12]); // what the descriptor says
        bytes.extend(length.to_le_bytes());
        bytes.extend([0; 2]);
        bytes.extend(name.as_bytes());
        bytes.extend(content);
        bytes.extend(b"PK\x07\x08");
        bytes.extend(crc);
        bytes.extend([size.to_le_bytes(); 2].concat());
        let (sizes, extra) = match zip64 {
            false => ([size; 2], Vec::new()),
            true => {
                let sizes = [u64::from(size).to_le_bytes(); 2].concat();
                ([u32::MAX; 2], [&[1, 0, 16, 0], &sizes[..]].concat())
            }
        };
        directory.extend(b"PK\x01\x02\x2d\0\x2d\0\x08\0\0\0\0\0\x21\0");
        directory.extend(crc);
        directory.extend(sizes.map(u32::to_le_bytes).concat());
        directory.extend(length.to_le_bytes());
        directory.extend(u16::try_from(extra.len()).unwrap().to_le_bytes());
        directory.extend([0; 10]); // no comment, first disk, attributes
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
        directory.extend(extra);
    }
    let (offset, size) = (bytes.len(), directory.len());
    let number = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
    let count = u16::try_from(names.len()).unwrap().to_le_bytes();
    bytes.extend(directory);
    bytes.extend(b"PK\x05\x06\0\0\0\0");
    bytes.extend([count; 2].concat());
    bytes.extend([number(size), number(offset)].concat());
    bytes.extend([0; 2]);
    bytes
}

/// CRC-32 of ISO 3309, bit by bit.
pub fn crc32(bytes: &[u8]) -> u32 {
    let bit = |crc: u32, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
    !bytes
        .iter()
        .fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), bit))
}

const SOUND: [&str; 5] = [
    "resources/",
    "binaries/",
    "binaries/linux64/",
    "binaries/linux64/Lag.so",
    "modelDescription.xml",
];

fn check(bytes: Vec<u8>) {
    let mut archive = Archive::open(bytes).unwrap();
    let names: Vec<_> = archive.names().collect();
    assert_eq!(names, ["binaries/linux64/Lag.so", "modelDescription.xml"]);
    let description = archive.description().unwrap();
    assert_eq!(description.model, "Lag");
    let library = archive.library(&description, platform::LINUX).unwrap();
    assert_eq!(library, ("binaries/linux64/Lag.so".to_string(), None));
    let folder = scratch();
    archive.unpack(&folder).unwrap();
    let unpacked = std::fs::read(folder.join("binaries/linux64/Lag.so")).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(unpacked, b"library");
}

fn scratch() -> PathBuf {
    use std::sync::atomic::{AtomicU32, Ordering};
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let name = format!("fmu-description-{}-{number}", std::process::id());
    std::env::temp_dir().join(name)
}

#[test]
fn every_kind_of_zip_is_opened() {
    let options = SimpleFileOptions::default();
    check(zip(&SOUND, options));
    check(zip(
        &SOUND,
        options.compression_method(CompressionMethod::Stored),
    ));
    check(zip(&SOUND, options.large_file(true)));
    check(by_hand(&SOUND[3..], false));
    check(by_hand(&SOUND[3..], true));
    check(by_hand(
        &["./modelDescription.xml", "binaries//linux64/Lag.so"],
        false,
    ));
}

#[test]
fn windows_separators_are_read_with_a_remark() {
    let names = ["modelDescription.xml", "binaries\\linux64\\Lag.so"];
    check(by_hand(&names, false));
    let description = Archive::open(by_hand(&names, false)).unwrap().description();
    assert_eq!(
        description.unwrap().remarks,
        [Remark::Backslash("binaries\\linux64\\Lag.so".into())]
    );
}

#[test]
fn a_single_library_of_another_name_is_taken() {
    let library = |names: &[&str]| {
        let mut archive = Archive::open(by_hand(names, false)).unwrap();
        let description = archive.description().unwrap();
        let found = archive.library(&description, platform::LINUX);
        found.map_err(|e| e.to_string())
    };
    let xml = "modelDescription.xml";
    let other = "binaries/linux64/libLag.so";
    let (found, remark) = library(&[xml, other, "binaries/win64/Lag.dll"]).unwrap();
    assert_eq!(found, other);
    assert_eq!(
        remark.unwrap().to_string(),
        "there is no `binaries/linux64/Lag.so`; the only library there is `binaries/linux64/libLag.so`"
    );
    let two = library(&[xml, other, "binaries/linux64/helper.so"]);
    let expected = "it holds no binaries/linux64/Lag.so, the library for this platform; it has binaries/linux64/helper.so, binaries/linux64/libLag.so";
    assert_eq!(two.unwrap_err(), expected);
    let none = library(&[xml, "binaries/linux64/deep/Lag.so"]).unwrap_err();
    assert!(
        none.contains("it has binaries/linux64/deep/Lag.so"),
        "{none}"
    );
    let sources = library(&[xml, "sources/all.c"]).unwrap_err();
    assert!(sources.ends_with("it has C sources only"), "{sources}");
}

#[test]
fn what_leads_out_of_the_folder_is_refused() {
    for name in ["../x", "a/../../x", "/x", "C:/x", "..\\x", "C:\\x"] {
        let error = Archive::open(by_hand(&["modelDescription.xml", name], false));
        let error = error.err().expect(name).to_string();
        assert_eq!(
            error,
            format!("`{name}` in it is a path that leads elsewhere")
        );
    }
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default();
    zip.add_symlink("resources/out", "/etc", options).unwrap();
    let error = Archive::open(zip.finish().unwrap().into_inner())
        .err()
        .unwrap();
    assert_eq!(error.to_string(), "`resources/out` in it is a link");
}

#[test]
fn what_is_no_fmu_is_refused() {
    let error = |bytes: Vec<u8>| match Archive::open(bytes) {
        Ok(mut archive) => archive.description().unwrap_err().to_string(),
        Err(error) => error.to_string(),
    };
    let text = error(b"text".to_vec());
    assert!(text.starts_with("it is not a ZIP archive"), "{text}");
    let package_cut_off = [&[7; 30], &by_hand(&["modelDescription.xml"], false)[..]].concat();
    let text = error(package_cut_off);
    assert!(text.starts_with("it is not a ZIP archive"), "{text}");
    let nested = error(by_hand(&["Lag/modelDescription.xml"], false));
    assert_eq!(nested, "it holds no modelDescription.xml");
    let mut damaged = by_hand(&["modelDescription.xml"], false);
    damaged[60] ^= 1;
    let text = error(damaged);
    assert!(
        text.starts_with("`modelDescription.xml` in it cannot be read: "),
        "{text}"
    );
}
