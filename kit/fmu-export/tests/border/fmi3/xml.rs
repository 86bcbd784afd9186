//! `modelDescription.xml`, and the files that a packer gets.

use crate::client3::*;
use crate::probe::Probe;
use std::collections::BTreeMap;
use std::ffi::{CStr, c_char, c_void};

fn xml() -> String {
    fmu_export::model_description3::<Probe>().unwrap()
}

#[test]
fn rows_are_arrays_with_one_reference() {
    let xml = xml();
    for element in [
        r#"<Float64 name="time" valueReference="65536" description="simulated time" causality="independent" variability="continuous"/>"#,
        r#"<Float64 name="gain" valueReference="0" description="factor of y" causality="parameter" variability="tunable" initial="exact" unit="1" min="0.0" max="10.0" start="3.0"/>"#,
        r#"<Float64 name="rate" valueReference="1" description="added to u" causality="parameter" variability="fixed" initial="exact" unit="m/s" displayUnit="mm/s" start="0.0 0.25">
      <Dimension start="2"/>
    </Float64>"#,
        r#"<Enumeration name="law" valueReference="3" description="of the enumeration" causality="parameter" variability="fixed" initial="exact" declaredType="Law" start="1"/>"#,
        r#"<Int32 name="level" valueReference="4" description="a number" causality="parameter" variability="fixed" initial="exact" min="-3" max="7" start="4"/>"#,
        r#"<Boolean name="enabled" valueReference="5" description="a flag" causality="parameter" variability="fixed" initial="exact" start="true"/>"#,
        r#"<String name="file" valueReference="6" description="sets everything" causality="parameter" variability="fixed" initial="exact">
      <Start value="4"/>
    </String>"#,
        r#"<Float64 name="x" valueReference="12" description="integral of u + rate" causality="output" variability="continuous" intermediateUpdate="true" initial="calculated" unit="m" nominal="2.5">
      <Dimension start="2"/>
    </Float64>"#,
        r#"<Output valueReference="12" dependencies="" dependenciesKind=""/>"#,
        r#"<Output valueReference="14" dependencies="7 10" dependenciesKind="dependent dependent"/>"#,
        r#"<Output valueReference="15"/>"#,
        r#"<InitialUnknown valueReference="12" dependencies="0 1 3 4 5 6" dependenciesKind="dependent dependent dependent dependent dependent dependent"/>"#,
        r#"hasEventMode="true""#,
    ] {
        assert!(xml.contains(element), "{xml}\nlacks {element}");
    }
}

#[test]
fn the_token_is_a_hash_of_all_the_rest_and_not_that_of_the_other_version() {
    let (two, three) = (fmu_export::model_description::<Probe>().unwrap(), xml());
    let of = |xml: &str, attribute: &str| {
        let (_, rest) = xml.split_once(&format!("{attribute}=\"")).unwrap();
        rest.split_once('"').unwrap().0.to_owned()
    };
    assert_ne!(of(&two, "guid"), of(&three, "instantiationToken"));
    assert_eq!(three, xml());
}

#[test]
fn the_files_are_those_of_the_version() {
    type Files = BTreeMap<String, Vec<u8>>;
    unsafe extern "C" fn receive(
        to: *mut c_void,
        path: *const c_char,
        bytes: *const u8,
        size: usize,
    ) {
        // SAFETY: what the library promises: a C string, and `size` bytes.
        unsafe {
            let path = CStr::from_ptr(path).to_str().unwrap().to_owned();
            let bytes = std::slice::from_raw_parts(bytes, size).to_vec();
            (*to.cast::<Files>()).insert(path, bytes);
        }
    }
    let mut files = Files::new();
    // SAFETY: the context is what `receive` expects.
    let status = unsafe { fmi3ExportFiles((&raw mut files).cast(), Some(receive)) };
    assert_eq!(status, 0);
    let names: Vec<_> = files.keys().collect();
    assert_eq!(
        names,
        [
            "documentation/index.html",
            "modelDescription.xml",
            "resources/a/b.txt",
            "terminalsAndIcons/icon.png",
            "terminalsAndIcons/terminalsAndIcons.xml"
        ]
    );
    assert_eq!(files["modelDescription.xml"], xml().into_bytes());
    let terminals =
        String::from_utf8(files["terminalsAndIcons/terminalsAndIcons.xml"].clone()).unwrap();
    assert_eq!(
        terminals,
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiTerminalsAndIcons fmiVersion="3.0">
  <Terminals>
    <Terminal name="axle" matchingRule="plug" terminalKind="org.example.axle" description="moves and is moved">
      <TerminalMemberVariable variableName="u" memberName="velocity" variableKind="signal"/>
      <TerminalMemberVariable variableName="x" memberName="position" variableKind="signal"/>
    </Terminal>
  </Terminals>
</fmiTerminalsAndIcons>
"#
    );
}
