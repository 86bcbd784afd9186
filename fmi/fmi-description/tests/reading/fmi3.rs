//! A description of FMI 3.0: arrays, types, aliases, dependencies; and its elements as FMI
//! 2.0 would have them.

use fmi_description::{
    Access, Causality, ClockInterval, ClockTiming, Description, Initial, Kind, Unknown,
    Variability, Version,
};

const TEXT: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="{5}" generationTool="by hand">
  <CoSimulation modelIdentifier="M" hasEventMode="true" canGetAndSetFMUState="1" providesAdjointDerivatives="true" maxOutputDerivativeOrder="1" fixedInternalStepSize="0.02"/>
  <UnitDefinitions><Unit name="rad"><BaseUnit rad="1"/></Unit></UnitDefinitions>
  <TypeDefinitions>
    <Float64Type name="Angle" unit="rad" min="-4" max="4" relativeQuantity="true"/>
    <ClockType name="Every" intervalVariability="constant" intervalDecimal="0.5"/>
    <EnumerationType name="Mode"><Item name="slow" value="1"/><Item name="fast" value="4"/></EnumerationType>
  </TypeDefinitions>
  <LogCategories><Category name="logEvents"/></LogCategories>
  <DefaultExperiment stopTime="2.5"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <UInt64 name="n" valueReference="1" causality="structuralParameter" start="2"/>
    <Float64 name="zeta" valueReference="2" causality="input" declaredType="Angle" max="3" start="0.5 -0.25 1"><Dimension start="3"/><Alias name="q" description="the same"/></Float64>
    <Float64 name="A" valueReference="3" causality="parameter" variability="tunable" start="7"><Dimension start="3"/><Dimension valueReference="1"/></Float64>
    <Enumeration name="mode" valueReference="4" causality="parameter" declaredType="Mode" start="4"/>
    <String name="file" valueReference="5" causality="parameter"><Start value="a b.json"/></String>
    <Int8 name="count" valueReference="6" causality="output"/>
    <Float64 name="y" valueReference="7" causality="output" initial="exact" start="0 0"><Dimension start="2"/></Float64>
    <Boolean name="on" valueReference="8" causality="input" start="true"/>
    <Clock name="c" valueReference="9" causality="input" intervalVariability="triggered"/>
    <Clock name="tick" valueReference="10" causality="input" declaredType="Every" shiftDecimal="0.25"/>
    <Clock name="counted" valueReference="11" causality="local" intervalVariability="fixed" resolution="1000" intervalCounter="40"/>
    <Float64 name="sampled" valueReference="12" causality="input" variability="discrete" clocks="10 9" start="0"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="6"/>
    <Output valueReference="7" dependencies="2 8" dependenciesKind="dependent dependent"/>
    <InitialUnknown valueReference="6" dependencies="3"/>
    <EventIndicator valueReference="7"/>
  </ModelStructure>
</fmiModelDescription>"#;

fn read() -> Description {
    Description::parse(TEXT).unwrap()
}

/// The same derivatives in both versions: a number from 1 in the one, a reference in the other.
#[test]
fn states_are_what_derivatives_are_of() {
    for text in [
        include_str!("../../../../modelDescription/DcLink.xml"),
        include_str!("../../../../modelDescription/fmi3/DcLink.xml"),
    ] {
        let d = Description::parse(text).unwrap();
        let d = d.by_element();
        let states = d.variables.iter().filter(|v| d.is_state(v));
        let states: Vec<_> = states.map(|v| v.name.as_str()).collect();
        let expected = "soc v_pairs[1] v_pairs[2] v_dc T_battery energy.battery energy.load energy.brake energy.loss";
        let mut expected: Vec<_> = expected.split(' ').collect();
        expected.sort_unstable_by_key(|name| d.index(name));
        assert_eq!(states, expected);
    }
    assert!(!read().is_state(read().variable("y").unwrap()));
}

#[test]
fn arrays_are_one_variable() {
    let d = read();
    assert_eq!((d.fmi, d.guid.as_str()), (Version::Fmi3, "{5}"));
    let can = d.capabilities;
    assert!(can.event_mode && can.saves_state && can.adjoint_derivatives);
    assert!(!can.interpolates_inputs && !can.serializes_state);
    assert_eq!(can.internal_step, Some(0.02));
    let zeta = d.variable("zeta").unwrap();
    assert_eq!((zeta.reference, zeta.size()), (2, 3));
    assert_eq!(zeta.start, ["0.5", "-0.25", "1"]);
    assert_eq!(zeta.bounds(), [-4.0, 3.0], "own before declared");
    assert_eq!(zeta.unit.as_deref(), Some("rad"));
    assert!(zeta.is_relative && !d.variable("A").unwrap().is_relative);
    assert_eq!(zeta.variability, Variability::Continuous);
    let q = d.variable("q").unwrap();
    assert_eq!((q.reference, q.description.as_str()), (2, "the same"));
    let a = d.variable("A").unwrap();
    assert_eq!((a.dimensions.as_slice(), a.size()), (&[3, 2][..], 6));
}

#[test]
fn types_have_their_functions() {
    let d = read();
    let of = |name: &str| {
        let v = d.variable(name).unwrap();
        (v.kind.clone(), v.access(), v.variability)
    };
    assert_eq!(
        of("count"),
        (Kind::Integer, Access::Int8, Variability::Discrete)
    );
    assert_eq!(
        of("on"),
        (Kind::Boolean, Access::Boolean, Variability::Discrete)
    );
    assert_eq!(of("c"), (Kind::Clock, Access::Clock, Variability::Discrete));
    let (kind, access, variability) = of("mode");
    let Kind::Enumeration(items) = kind else {
        panic!("{kind:?}")
    };
    assert_eq!((items[1].name.as_str(), items[1].value), ("fast", 4));
    assert_eq!(
        (access, variability),
        (Access::Int64, Variability::Fixed),
        "a parameter"
    );
    assert_eq!(d.variable("file").unwrap().start, ["a b.json"]);
    assert_eq!(
        d.variable("n").unwrap().causality,
        Causality::StructuralParameter
    );
}

#[test]
fn clocks_say_when_they_tick() {
    let d = read();
    let timing = |name: &str| d.variable(name).unwrap().timing;
    let of = |interval, period, shift| {
        Some(ClockTiming {
            interval,
            period,
            shift,
            priority: 0,
        })
    };
    assert_eq!(timing("c"), of(ClockInterval::Triggered, None, 0.0));
    let every = of(ClockInterval::Constant, Some(0.5), 0.25);
    assert_eq!(timing("tick"), every, "declared, and its own shift");
    let counted = of(ClockInterval::Fixed, Some(0.04), 0.0);
    assert_eq!(timing("counted"), counted);
    assert_eq!(timing("sampled"), None);
    assert_eq!(d.variable("sampled").unwrap().clocks, [10, 9]);
}

#[test]
fn structure_names_value_references() {
    let d = read();
    let index = |name: &str| d.index(name).unwrap();
    let unknown = |name: &str, known: Option<&[&str]>| Unknown {
        variable: index(name),
        dependencies: known.map(|names| names.iter().map(|n| index(n)).collect()),
    };
    assert_eq!(
        d.outputs,
        [unknown("count", None), unknown("y", Some(&["zeta", "on"]))]
    );
    assert_eq!(d.initial_unknowns, [unknown("count", Some(&["A"]))]);
    assert_eq!(
        d.feedthrough(index("y"), false),
        [index("zeta"), index("on")]
    );
    assert_eq!(d.feedthrough(index("y"), true), [0; 0], "it is given");
    assert_eq!(d.variables[index("y")].initial, Some(Initial::Exact));
}

#[test]
fn elements_are_named_as_in_version_2() {
    let d = read().by_element();
    let names: Vec<_> = d.variables.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(
        names[2..8],
        ["zeta[1]", "zeta[2]", "zeta[3]", "q[1]", "q[2]", "q[3]"]
    );
    assert_eq!(
        names[8..14],
        ["A[1,1]", "A[1,2]", "A[2,1]", "A[2,2]", "A[3,1]", "A[3,2]"]
    );
    let second = d.variable("zeta[2]").unwrap();
    assert_eq!((second.reference, second.element), (2, Some(1)));
    assert_eq!(
        (second.start_number(), second.size()),
        (Some(-0.25), 1),
        "{second:?}"
    );
    assert_eq!(d.variable("A[3,2]").unwrap().start_number(), Some(7.0));
    let index = |name: &str| d.index(name).unwrap();
    let inputs = d.feedthrough(index("y[2]"), false);
    let inputs: Vec<_> = inputs.iter().map(|k| names[*k]).collect();
    assert_eq!(inputs, ["zeta[1]", "zeta[2]", "zeta[3]", "on"]);
}

#[test]
fn what_makes_no_sense_is_refused() {
    for (was, is, expected) in [
        (
            "<Output valueReference=\"6\"/>",
            "<Output valueReference=\"66\"/>",
            "ModelStructure names value reference 66, which no variable has",
        ),
        (
            "<Dimension start=\"2\"/>",
            "<Dimension start=\"0\"/>",
            "a dimension of `y` must be a number of at least 1 or name a structural parameter that starts at one",
        ),
        (
            "<Dimension valueReference=\"1\"/>",
            "<Dimension valueReference=\"7\"/>",
            "a dimension of `A` must be",
        ),
        (
            "<Dimension start=\"2\"/>",
            "<Dimension start=\"4294967296\"/><Dimension start=\"4294967296\"/>",
            "a dimension of `y` must be",
        ),
        (
            "fmiVersion=\"3.0\"",
            "fmiVersion=\"4.0\"",
            "model `M` is of FMI 4.0; only FMI 2.0 and 3.0 are supported",
        ),
        (
            "<CoSimulation",
            "<ModelExchange",
            "model `M` offers Model Exchange only, no Co-Simulation",
        ),
    ] {
        let error = Description::parse(&TEXT.replace(was, is)).unwrap_err();
        assert!(error.to_string().contains(expected), "{is}: {error}");
    }
}
