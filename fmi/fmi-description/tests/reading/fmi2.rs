//! What a description says is what is read; what it must not say is refused by name.

use fmi_description::{Access, Causality, Description, Initial, Item, Kind, Unknown, Variability};

const TEXT: &str = r#"<?xml version="1.0"?>
<fmiModelDescription fmiVersion="2.0" modelName="M" guid="{5}" version="0.7" generationTool="by hand">
  <CoSimulation modelIdentifier="M_lib" canInterpolateInputs="true" maxOutputDerivativeOrder="1" canGetAndSetFMUstate="1">
    <SourceFiles><File name="m.c"/></SourceFiles>
  </CoSimulation>
  <UnitDefinitions>
    <Unit name="N"><BaseUnit kg="1" m="1" s="-2"/><DisplayUnit name="kN" factor="0.001"/></Unit>
    <Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>
    <Unit name="heads"/>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Mode"><Enumeration><Item name="slow" value="1"/><Item name="fast" value="4"/></Enumeration></SimpleType>
    <SimpleType name="Force"><Real unit="N" displayUnit="kN" min="-3" max="5"/></SimpleType>
    <SimpleType name="Count"><Integer min="2" max="9"/></SimpleType>
  </TypeDefinitions>
  <LogCategories><Category name="logStatusError"/><Category name="logEvents"/></LogCategories>
  <DefaultExperiment stopTime="2.5" stepSize="1e-3"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="7" causality="input" description="what comes in"><Real unit="m" start="0.5"/></ScalarVariable>
    <ScalarVariable name="w" valueReference="8" causality="input" variability="discrete"><Integer declaredType="Count" start="3"/></ScalarVariable>
    <ScalarVariable name="k" valueReference="0" causality="parameter" variability="tunable"><Enumeration declaredType="Mode" start="1"/></ScalarVariable>
    <ScalarVariable name="y[1]" valueReference="9" causality="output"><Real declaredType="Force" max="4"/></ScalarVariable>
    <ScalarVariable name="y[2]" valueReference="10" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="q" valueReference="11" causality="output" initial="exact"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="f" valueReference="12"><String/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="4" dependencies="2 3"/><Unknown index="5"/><Unknown index="6" dependencies="1"/></Outputs>
    <InitialUnknowns><Unknown index="4" dependencies="1" dependenciesKind="dependent"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>"#;

fn read() -> Description {
    Description::parse(TEXT).unwrap()
}

#[test]
fn identity_and_capabilities_come_through() {
    let d = read();
    assert_eq!((d.model.as_str(), d.guid.as_str()), ("M", "{5}"));
    assert_eq!((d.version.as_str(), d.tool.as_str()), ("0.7", "by hand"));
    assert_eq!(d.identifier, "M_lib");
    let can = d.capabilities;
    assert!(can.interpolates_inputs && can.saves_state);
    assert!(!can.serializes_state && !can.only_once && !can.variable_step);
    assert_eq!(can.output_derivative_order, 1);
    assert_eq!(d.log_categories, ["logStatusError", "logEvents"]);
    let experiment = d.default_experiment;
    assert_eq!((experiment.start, experiment.stop), (None, Some(2.5)));
    assert_eq!((experiment.step, experiment.tolerance), (Some(1e-3), None));
}

#[test]
fn units_have_exponents_factor_and_offset() {
    let [newton, celsius, heads] = &read().units[..] else {
        panic!("three units");
    };
    assert_eq!(newton.exponents, Some([1, 1, -2, 0, 0, 0, 0, 0]));
    assert_eq!((newton.factor, newton.offset), (1.0, 0.0));
    assert_eq!((celsius.factor, celsius.offset), (1.0, 273.15));
    assert_eq!((heads.name.as_str(), heads.exponents), ("heads", None));
}

#[test]
fn a_variable_is_read_with_its_declared_type() {
    let d = read();
    let v = |name| d.variable(name).unwrap();
    let u = v("u");
    assert_eq!((u.reference, u.access()), (7, Access::Real));
    assert_eq!(u.description, "what comes in");
    assert_eq!(
        (u.causality, u.variability),
        (Causality::Input, Variability::Continuous)
    );
    assert_eq!(u.start_number(), Some(0.5));
    assert_eq!(u.bounds(), [f64::NEG_INFINITY, f64::INFINITY]);
    assert_eq!(
        (v("w").bounds(), v("w").variability),
        ([2.0, 9.0], Variability::Discrete)
    );
    let items = [("slow", 1), ("fast", 4)].map(|(name, value)| Item {
        name: name.to_string(),
        value,
    });
    assert_eq!(v("k").kind, Kind::Enumeration(items.to_vec().into()));
    assert_eq!(
        (v("k").access(), v("k").bounds()),
        (Access::Integer, [1.0, 4.0])
    );
    assert!(v("k").is_tunable() && !u.is_tunable());
    let y = v("y[1]");
    assert_eq!(
        (y.unit.as_deref(), y.display_unit.as_deref()),
        (Some("N"), Some("kN"))
    );
    assert_eq!(
        y.bounds(),
        [-3.0, 4.0],
        "the own bound, else the declared one"
    );
    assert!(y.is_computed() && v("f").is_computed() && !u.is_computed());
    assert_eq!(
        (v("f").causality, v("f").access()),
        (Causality::Local, Access::String)
    );
    assert_eq!(v("q").initial, Some(Initial::Exact));
}

#[test]
fn dependencies_absent_empty_and_listed_differ() {
    let d = read();
    let expected = [(3, Some(vec![1, 2])), (4, None), (5, Some(vec![0]))];
    let expected = expected.map(|(variable, known): (_, Option<Vec<usize>>)| Unknown {
        variable,
        dependencies: known.map(Into::into),
    });
    assert_eq!(d.outputs, expected);
    assert_eq!(
        d.feedthrough(3, false),
        [1],
        "the parameter is not an input"
    );
    assert_eq!(d.feedthrough(4, false), [0, 1], "absent: all inputs");
    assert_eq!(
        d.feedthrough(3, true),
        [0],
        "initialization has its own list"
    );
    assert_eq!(
        d.feedthrough(4, true),
        [0, 1],
        "not listed there: as at communication points"
    );
    assert_eq!(
        d.feedthrough(5, true),
        [],
        "given, so it depends on nothing"
    );
    let empty = TEXT.replace("dependencies=\"2 3\"", "dependencies=\"\"");
    assert_eq!(
        Description::parse(&empty).unwrap().feedthrough(3, false),
        []
    );
}

#[test]
fn what_must_not_be_said_is_refused_by_name() {
    let said = |from: &str, to: &str| {
        assert!(TEXT.contains(from));
        Description::parse(&TEXT.replace(from, to))
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        said("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\""),
        "model `M` is of FMI 1.0; only FMI 2.0 and 3.0 are supported"
    );
    for wrong in ["../x", "", "..", "a/b", "a\\b", "C:x"] {
        let expected = format!("`{wrong}` cannot be the name of a file");
        assert!(said("M_lib", wrong).contains(&expected), "{wrong}");
    }
    assert!(said("<String/>", "").contains("variable `f` has no type"));
    for wrong in ["0", "8", "u"] {
        let text = said("index=\"5\"", &format!("index=\"{wrong}\""));
        assert!(
            text.contains(&format!("number {wrong}, but must name one of 1 to 7")),
            "{text}"
        );
    }
    assert!(said("\"2 3\"", "\"2 9\"").contains("number 9"));
    assert!(said("causality=\"output\"", "causality=\"result\"").contains("result"));
    assert!(said("</ModelVariables>", "").contains("cannot be read"));
    assert_eq!(
        said("CoSimulation", "ModelExchange"),
        "model `M` offers Model Exchange only, no Co-Simulation"
    );
}

#[test]
fn an_unknown_name_is_answered_with_similar_ones() {
    let text = read().variable("y[3]").unwrap_err().to_string();
    assert_eq!(text, "model `M` has no variable `y[3]` (it has y[1], y[2])");
    let text = read().variable("z").unwrap_err().to_string();
    assert_eq!(text, "model `M` has no variable `z`");
}
