//! The model description: structure here; the schema and FMPy's rules in
//! `tests/test_export_example.py`.

use crate::client::fmi2ExportFiles;
use crate::probe::{Probe, vr};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::collections::BTreeMap;
use std::ffi::{CStr, c_char, c_void};
use std::{ptr, slice};

/// An element: its path from the root and its attributes.
type Element = (String, BTreeMap<String, String>);

fn elements(xml: &str) -> Vec<Element> {
    let mut reader = Reader::from_str(xml);
    let (mut path, mut elements) = (Vec::new(), Vec::new());
    let name = |e: &BytesStart<'_>| e.name().as_ref().to_owned();
    loop {
        let (start, nested) = match reader.read_event().unwrap() {
            Event::Start(start) => (start, true),
            Event::Empty(start) => (start, false),
            Event::End(_) => {
                path.pop();
                continue;
            }
            Event::Eof => return elements,
            _ => continue,
        };
        path.push(name(&start));
        let attributes = start.attributes().map(|a| {
            let a = a.unwrap();
            let value = a
                .normalized_value(XmlVersion::Implicit1_0)
                .unwrap()
                .into_owned();
            (a.key.as_ref().to_owned(), value)
        });
        elements.push((path.join("/"), attributes.collect()));
        if !nested {
            path.pop();
        }
    }
}

fn probe() -> Vec<Element> {
    elements(&fmu_export::model_description::<Probe>().unwrap())
}

fn show((path, attributes): &Element) -> String {
    let attributes: Vec<_> = attributes.iter().map(|(k, v)| format!("{k}={v}")).collect();
    format!(
        "{}: {}",
        path.rsplit('/').next().unwrap(),
        attributes.join(" ")
    )
}

fn under(part: &str) -> Vec<String> {
    let path = format!("fmiModelDescription/{part}");
    probe()
        .iter()
        .filter(|(p, _)| p.starts_with(&path))
        .map(show)
        .collect()
}

#[test]
fn value_references_count_the_elements() {
    let variables = under("ModelVariables/ScalarVariable");
    let names: Vec<_> = probe()
        .into_iter()
        .filter(|(p, _)| p.ends_with("/ScalarVariable"))
        .collect();
    assert_eq!(names.len(), vr::COUNT as usize);
    for (reference, (_, attributes)) in names.iter().enumerate() {
        assert_eq!(attributes["valueReference"], reference.to_string());
    }
    assert_eq!(names[vr::U[1] as usize].1["name"], "u[2]");
    #[rustfmt::skip]
    let expected = [
        "ScalarVariable: causality=parameter description=factor of y initial=exact name=gain valueReference=0 variability=tunable",
        "Real: max=10.0 min=0.0 start=3.0 unit=1",
        "ScalarVariable: causality=parameter description=added to u initial=exact name=rate[1] valueReference=1 variability=fixed",
        "Real: displayUnit=mm/s start=0.0 unit=m/s",
        "Enumeration: declaredType=Law start=1",
        "Integer: max=7 min=-3 start=4",
        "Boolean: start=true",
        "String: start=4",
        "ScalarVariable: causality=input description=changes at communication points name=held valueReference=9 variability=discrete",
        "Real: start=1.5",
        "ScalarVariable: causality=input description=what is integrated name=u[1] valueReference=7 variability=continuous",
        "ScalarVariable: causality=output description=integral of u + rate initial=calculated name=x[1] valueReference=12 variability=continuous",
        "Real: nominal=2.5 unit=m",
        "ScalarVariable: causality=local description=not for wiring initial=calculated name=inner valueReference=17 variability=continuous",
    ];
    for line in expected {
        assert!(
            variables.iter().any(|found| found == line),
            "{line}\nnot in\n{variables:#?}"
        );
    }
}

#[test]
fn header_and_capabilities_are_complete() {
    let all = probe();
    let root = &all[0].1;
    assert_eq!(
        root["description"],
        "a \"model\" to be tested & nothing else"
    );
    let rest: Vec<_> = [
        "fmiVersion",
        "modelName",
        "version",
        "author",
        "variableNamingConvention",
    ]
    .map(|k| root[k].as_str())
    .into();
    assert_eq!(rest, ["2.0", "Probe", "1.2.3", "nobody", "structured"]);
    assert!(!root.contains_key("generationDateAndTime"));
    assert_eq!(
        under("CoSimulation"),
        [
            "CoSimulation: canBeInstantiatedOnlyOncePerProcess=false canGetAndSetFMUstate=true \
          canHandleVariableCommunicationStepSize=true canInterpolateInputs=true canNotUseMemoryManagementFunctions=true \
          canRunAsynchronuously=false canSerializeFMUstate=true maxOutputDerivativeOrder=1 modelIdentifier=Probe \
          needsExecutionTool=false providesDirectionalDerivative=true"
        ]
    );
    assert_eq!(
        under("DefaultExperiment"),
        ["DefaultExperiment: startTime=0.0 stepSize=0.125 stopTime=2.0"]
    );
    let mut order: Vec<_> = all
        .iter()
        .filter(|(p, _)| p.matches('/').count() == 1)
        .map(|(p, _)| p.split_once('/').unwrap().1)
        .collect();
    order.dedup();
    let expected = [
        "CoSimulation",
        "UnitDefinitions",
        "TypeDefinitions",
        "LogCategories",
        "DefaultExperiment",
        "ModelVariables",
        "ModelStructure",
    ];
    assert_eq!(order, expected);
}

#[test]
fn units_in_use_are_defined_with_base_and_display_units() {
    let expected = [
        "UnitDefinitions: ",
        "Unit: name=1",
        "BaseUnit: ",
        "DisplayUnit: factor=100.0 name=%",
        "Unit: name=m/s",
        "BaseUnit: m=1 s=-1",
        "DisplayUnit: factor=1000.0 name=mm/s",
        "Unit: name=m",
        "BaseUnit: m=1",
        "DisplayUnit: factor=1000.0 name=mm",
    ];
    assert_eq!(under("UnitDefinitions"), expected);
    let items = [
        "Item: description=first & <plain> name=plain value=1",
        "Item: description=the other name=other value=2",
    ];
    assert_eq!(under("TypeDefinitions/SimpleType/Enumeration/"), items);
}

/// Positions count from 1: x[1] = 13, x[2] = 14, y = 15, doubled = 16, on = 17; u[1] = 8, u[2] = 9,
/// fault = 11, switch = 12.
#[test]
fn dependencies_are_exact() {
    let outputs = [
        "Outputs: ",
        "Unknown: dependencies= index=13",
        "Unknown: dependencies= index=14",
        "Unknown: dependencies=9 11 index=15",
        "Unknown: index=16",
        "Unknown: dependencies=12 index=17",
    ];
    assert_eq!(under("ModelStructure/Outputs"), outputs);
    let initial = [
        "InitialUnknowns: ",
        "Unknown: dependencies=2 index=13",
        "Unknown: dependencies=1 2 3 4 5 6 7 index=14",
        "Unknown: dependencies=1 8 9 index=15",
        "Unknown: index=16",
        "Unknown: index=17",
    ];
    assert_eq!(under("ModelStructure/InitialUnknowns"), initial);
}

unsafe extern "C" fn receive(
    context: *mut c_void,
    path: *const c_char,
    bytes: *const u8,
    size: usize,
) {
    // SAFETY: the context is the list below; path and bytes are valid during the call.
    unsafe {
        let path = CStr::from_ptr(path).to_str().unwrap().to_owned();
        let bytes = slice::from_raw_parts(bytes, size).to_vec();
        (*context.cast::<Vec<(String, Vec<u8>)>>()).push((path, bytes));
    }
}

#[test]
fn files_can_be_read_from_the_library() {
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    // SAFETY: the context is what `receive` expects.
    assert_eq!(
        unsafe { fmi2ExportFiles((&raw mut files).cast(), Some(receive)) },
        0
    );
    let xml = fmu_export::model_description::<Probe>().unwrap();
    let expected: [(&str, &[u8]); 4] = [
        ("modelDescription.xml", xml.as_bytes()),
        ("model.png", b"png"),
        ("documentation/index.html", b"<p>probe</p>"),
        ("resources/a/b.txt", b"text"),
    ];
    assert_eq!(
        files,
        expected.map(|(path, bytes)| (path.to_owned(), bytes.to_vec()))
    );
    // SAFETY: NULL is refused.
    assert_eq!(unsafe { fmi2ExportFiles(ptr::null_mut(), None) }, 1);
}
