//! Descriptions as other tools write them: what is unusual, or wrong but harmless, is read.

use fmi_description::{Description, Remark};

/// As Dymola and others write: a schema instance on the root, annotations of their own, comments,
/// Windows line ends.
const TEXT: &str = "<?xml version=\"1.0\" encoding=\"ENCODING\"?>\r
<!-- made by a tool -->\r
<fmiModelDescription xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xmlns=\"urn:of-a-vendor\"\r
  xsi:noNamespaceSchemaLocation=\"fmi2ModelDescription.xsd\" fmiVersion=\"2.0\" modelName=\"Träger\" guid=\"{5}\" numberOfEventIndicators=\"0\">\r
  <ModelExchange modelIdentifier=\"Traeger-2\"/>\r
  <CoSimulation modelIdentifier=\"Traeger-2\" needsExecutionTool=\"true\" vendor:flag=\"7\" xmlns:vendor=\"urn:x\"/>\r
  <VendorAnnotations><Tool name=\"x\"><ModelVariables><ScalarVariable/></ModelVariables> text &amp; more <![CDATA[<b]]></Tool></VendorAnnotations>\r
  <ModelVariables>\r
    <!-- 1 -->\r
    <ScalarVariable name=\"u\" valueReference=\" 7 \" causality=\"input\"><Annotations><Tool name=\"x\"><Real/></Tool></Annotations><Real start=\"1\" min=\"-INF\" max=\" 4.0 \"/></ScalarVariable>\r
    <ScalarVariable name=\"y\" valueReference=\"8\" causality=\"output\" description=\"a &quot;y&quot;&#10;here\"><Real declaredType=\"Lost\"/></ScalarVariable>\r
    <ScalarVariable name=\"z\" valueReference=\"9\" causality=\"output\"><Real/></ScalarVariable>\r
  </ModelVariables>\r
  <ModelStructure><Outputs><Unknown index=\"2\"/></Outputs><Outputs/></ModelStructure>\r
</fmiModelDescription>\r
";

fn check(bytes: &[u8]) -> Description {
    let d = Description::read(bytes).unwrap();
    assert_eq!(
        (d.model.as_str(), d.identifier.as_str()),
        ("Träger", "Traeger-2")
    );
    assert!(d.capabilities.needs_execution_tool);
    let [u, y, z] = &d.variables[..] else {
        panic!("three variables: {:?}", d.variables);
    };
    assert_eq!((u.reference, u.bounds()), (7, [f64::NEG_INFINITY, 4.0]));
    assert_eq!(y.description, "a \"y\"\nhere");
    assert_eq!(z.name, "z");
    d
}

#[test]
fn every_usual_encoding_is_read() {
    let named = |name: &str| TEXT.replace("ENCODING", name);
    let utf8 = named("UTF-8").into_bytes();
    check(&utf8);
    check(&[&[0xef, 0xbb, 0xbf], &utf8[..]].concat());
    let latin = named("ISO-8859-1");
    let latin: Vec<u8> = latin.chars().map(|c| u8::try_from(c).unwrap()).collect();
    assert!(std::str::from_utf8(&latin).is_err(), "one byte a letter");
    check(&latin);
    let wide = named("UTF-16");
    let wide = wide.encode_utf16();
    let marked: Vec<u8> = std::iter::once(0xfeff)
        .chain(wide)
        .flat_map(u16::to_be_bytes)
        .collect();
    check(&marked);
}

#[test]
fn what_is_wrong_but_harmless_is_remarked() {
    let remarks = check(TEXT.replace("ENCODING", "utf-8").as_bytes()).remarks;
    assert_eq!(
        remarks,
        [
            Remark::Identifier("Traeger-2".into()),
            Remark::UnknownType {
                variable: "y".into(),
                declared: "Lost".into(),
                count: 1
            },
            Remark::UnlistedOutputs {
                variable: "z".into(),
                count: 1
            },
        ]
    );
    assert_eq!(
        remarks[0].to_string(),
        "modelIdentifier `Traeger-2` is no C identifier"
    );
    let patch = TEXT
        .replace("ENCODING", "utf-8")
        .replace("fmiVersion=\"2.0\"", "fmiVersion=\"2.0.4\"");
    assert_eq!(
        check(patch.as_bytes()).remarks[1],
        Remark::Version("2.0.4".into())
    );
    let twice = TEXT
        .replace("ENCODING", "utf-8")
        .replace("name=\"y\"", "name=\"u\"");
    let twice = Description::read(twice.as_bytes()).unwrap();
    assert_eq!(twice.remarks.last(), Some(&Remark::SameName("u".into())));
}

#[test]
fn what_nobody_declared_differs_from_nothing() {
    let d = check(TEXT.replace("ENCODING", "utf-8").as_bytes());
    for (output, why) in [(1, "no dependencies"), (2, "not listed")] {
        for initialization in [false, true] {
            assert_eq!(
                d.declared_feedthrough(output, initialization),
                None,
                "{why}"
            );
            assert_eq!(d.feedthrough(output, initialization), [0], "{why}");
        }
    }
    let empty = TEXT.replace("index=\"2\"", "index=\"2\" dependencies=\"\"");
    let d = check(empty.replace("ENCODING", "utf-8").as_bytes());
    assert_eq!(d.declared_feedthrough(1, false), Some(vec![]));
}

#[test]
fn other_interfaces_are_named() {
    let offers = |from: &str, to: &str| {
        let text = TEXT
            .replace("ENCODING", "utf-8")
            .replace("<CoSimulation", "<Other");
        Description::parse(&text.replace(from, to))
            .unwrap_err()
            .to_string()
    };
    let model = "model `Träger` offers";
    assert_eq!(
        offers("", ""),
        format!("{model} Model Exchange only, no Co-Simulation")
    );
    let nothing = offers("<ModelExchange", "<Nothing");
    assert_eq!(nothing, format!("{model} no interface, no Co-Simulation"));
    let scheduled = offers("<ModelExchange", "<ScheduledExecution");
    assert_eq!(
        scheduled,
        format!("{model} Scheduled Execution only, no Co-Simulation")
    );
}

#[test]
fn errors_name_line_element_and_value() {
    for (from, to, expected) in [
        (
            "start=\"1\"",
            "min=\"low\"",
            "line 10: Real has min = `low`; it must be a number",
        ),
        (
            "valueReference=\"8\"",
            "",
            "line 11: ScalarVariable has no attribute valueReference (of `y`)",
        ),
        (
            "needsExecutionTool=\"true\"",
            "needsExecutionTool=\"yes\"",
            "line 6: CoSimulation has needsExecutionTool = `yes`; it must be true or false",
        ),
        (
            "guid=\"{5}\"",
            "",
            "line 3: fmiModelDescription has no attribute guid",
        ),
    ] {
        let text = TEXT
            .replace("ENCODING", "utf-8")
            .replacen(" min=\"-INF\"", "", 1);
        assert!(text.contains(from), "{from}");
        let error = Description::parse(&text.replace(from, to)).unwrap_err();
        let expected = format!("the model description cannot be read: {expected}");
        assert_eq!(error.to_string(), expected);
    }
    let other = Description::parse("<html fmiVersion=\"2.0\"/>").unwrap_err();
    assert!(
        other
            .to_string()
            .contains("its outermost element is not fmiModelDescription"),
        "{other}"
    );
}
