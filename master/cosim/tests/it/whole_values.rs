//! Values of FMI 3.0 that do not pass as numbers one by one: arrays, integers of 64 bits, texts and
//! bytes.

use std::fs;

use cosim::io::csv::Log;
use cosim::master::{Master, Schedule};
use cosim::run::observer::Observer;
use cosim::run::signals::matching_any;

use super::events::{
    ABLE, CLOCKED, H, PERIODIC, SCHEDULES, assert_holds, fmu, master, number, run, two,
};
use super::support::{load, scratch, stepping};

/// Connectors with dimensions, as SSP 2.0 has them: element by element, in their order.
#[test]
fn arrays_are_connected_as_a_whole() {
    for name in ["a", "b"] {
        fmu("arrays", name, "", ABLE);
    }
    let component = |name: &str, size: usize, start: &str| {
        format!(
            r#"<ssd:Component name="{name}" source="{name}.fmu"><ssd:Connectors>
            <ssd:Connector name="v" kind="input"><ssc:Float64/><ssc:Dimension size="{size}"/></ssd:Connector>
            <ssd:Connector name="v_out" kind="output"><ssc:Float64/><ssc:Dimension/></ssd:Connector></ssd:Connectors>
            <ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version="2.0" name="p"><ssv:Parameters>
            <ssv:Parameter name="v"><ssv:Float64 value="{start}"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues>
            </ssd:ParameterBinding></ssd:ParameterBindings></ssd:Component>"#
        )
    };
    let text = |size: usize| {
        format!(
            r#"<ssd:SystemStructureDescription xmlns:ssd="d" xmlns:ssc="c" xmlns:ssv="v" version="2.0" name="s"><ssd:System name="s">
            <ssd:Connectors><ssd:Connector name="all" kind="input"><ssc:Float64/><ssc:Dimension size="2"/></ssd:Connector></ssd:Connectors>
            <ssd:Elements>{}{}</ssd:Elements><ssd:Connections><ssd:Connection startElement="a" startConnector="v_out" endElement="b" endConnector="v"/>
            <ssd:Connection startConnector="all" endElement="a" endConnector="v"/></ssd:Connections></ssd:System>
            </ssd:SystemStructureDescription>"#,
            component("a", size, "3 5"),
            component("b", 2, "8 9")
        )
    };
    let file = scratch("arrays").join("s.ssd");
    fs::write(&file, text(2)).unwrap();
    let system = load(&file).unwrap();
    let mut settings = system.parse_settings("all[1]=7").unwrap();
    for (start, expected) in [
        (Vec::new(), [3.0, 5.0]),
        (std::mem::take(&mut settings), [7.0, 5.0]),
    ] {
        let mut started = Master::new(&system, &start, stepping(H, Schedule::Standard)).unwrap();
        run(&mut started, 2).unwrap();
        let found = ["b.v_out[1]", "b.v_out[2]"].map(|name| number(&system, &started, name));
        assert_eq!(found, expected);
    }
    fs::write(&file, text(3)).unwrap();
    let parts = ["connector `a.v` is declared with 3 elements, but its FMU has 2"];
    assert_holds(load(&file).map(|_| ()), &parts);
    let lone = text(2).replace(
        "endElement=\"b\" endConnector=\"v\"",
        "endElement=\"b\" endConnector=\"T\"",
    );
    let scalar =
        "<ssd:Connector name=\"T\" kind=\"input\"><ssc:Float64/></ssd:Connector></ssd:Connectors>";
    let (first, last) = lone.rsplit_once("</ssd:Connectors>").unwrap();
    fs::write(&file, format!("{first}{scalar}{last}")).unwrap();
    assert_holds(
        load(&file).map(|_| ()),
        &["a.v_out -> b.T: its ends have 2 and 1 elements"],
    );
}

/// 2^53 + 1, the greatest of 64 bits, texts and bytes go from one to the other, and into a file.
#[test]
fn whole_values_pass_through_wires_and_into_files() {
    let connections =
        ["whole", "natural", "text", "bytes"].map(|name| format!("a.{name}_out=b.{name}"));
    let connections = connections.each_ref().map(String::as_str);
    let system = two("whole", "", &connections).unwrap();
    let start = [
        "a.whole=-9007199254740993",
        "a.natural=18446744073709551615",
        "a.text=a \"b\", c",
        "a.bytes=00FFA7",
    ];
    let ports = matching_any(&system, &["b.*_out".into()]).unwrap();
    for schedule in SCHEDULES {
        let mut master = master(&system, &start, schedule).unwrap();
        let path = scratch("whole.csv");
        let mut log = Log::create(&path, &system, &ports, None, master.stepping(), false).unwrap();
        run(&mut master, 2).unwrap();
        log.observe(&master).unwrap();
        log.finish().unwrap();
        let text = fs::read_to_string(path).unwrap();
        assert_eq!(
            text,
            "time,b.whole_out,b.natural_out,b.small_out,b.text_out,b.bytes_out,b.dT_out,b.T_out\n\
             0.7,-9007199254740993,18446744073709551615,0.0,\"a \"\"b\"\", c\",00FFA7,0.0,0.0\n",
            "{schedule:?}"
        );
    }
    for (setting, part) in [
        (
            "a.whole=9223372036854775808",
            "a whole number from -9223372036854775808 to",
        ),
        (
            "a.natural=-1",
            "a whole number from 0 to 18446744073709551615",
        ),
        ("a.bytes=00F", "bytes, each as two hexadecimal digits"),
    ] {
        assert_holds(master(&system, &[setting], Schedule::Standard), &[part]);
    }
}

/// Integers of 64 bits on wires and ticks of clocks need no memory.
#[test]
fn whole_numbers_and_ticks_allocate_nothing() {
    let clocks = PERIODIC.to_string() + CLOCKED;
    let connections = ["a.whole_out=b.whole", "a.natural_out=b.natural", "a.y=b.u"];
    let system = two("lean", &clocks, &connections).unwrap();
    for schedule in SCHEDULES {
        let mut master = master(&system, &["a.whole=3"], schedule).unwrap();
        run(&mut master, 2).unwrap();
        let steps = allocation_counter::measure(|| run(&mut master, 20).unwrap());
        assert_eq!(steps.count_total, 0, "{schedule:?}");
    }
}

/// What does not fit the type of the input is refused, not cut off.
#[test]
fn integers_that_do_not_fit_are_refused() {
    for (test, connection, start, parts) in [
        (
            "to-small",
            "a.whole_out=b.small",
            "a.whole=2147483648",
            ["b (FMU", "of small"],
        ),
        (
            "to-natural",
            "a.whole_out=b.natural",
            "a.whole=-1",
            ["b (FMU", "of natural"],
        ),
        (
            "from-small",
            "a.small_out=b.natural",
            "a.small=-1",
            ["b (FMU", "of natural"],
        ),
    ] {
        let system = two(test, "", &[connection]).unwrap();
        let run = || run(&mut master(&system, &[start], Schedule::Standard)?, 1);
        assert_holds(run(), &parts);
        assert_holds(run(), &["a value is outside of the range of its type"]);
        let name = connection.split('=').nth(1).unwrap();
        let mut fitting = master(&system, &["a.whole=17", "a.small=17"], Schedule::Jacobi).unwrap();
        fitting.step().unwrap();
        assert_eq!(number(&system, &fitting, name), 17.0);
    }
}

/// As a system structure has it: connectors of the types, values as bindings.
#[test]
fn texts_and_bytes_are_connected_by_a_structure() {
    for name in ["a", "b"] {
        fmu("structure", name, "", ABLE);
    }
    let component = |name: &str, parameters: &str| {
        format!(
            r#"<ssd:Component name="{name}" source="{name}.fmu"><ssd:Connectors>
            <ssd:Connector name="text" kind="input"><ssc:String/></ssd:Connector><ssd:Connector name="bytes" kind="input"><ssc:Binary/></ssd:Connector>
            <ssd:Connector name="text_out" kind="output"><ssc:String/></ssd:Connector>
            <ssd:Connector name="bytes_out" kind="output"><ssc:Binary/></ssd:Connector></ssd:Connectors>{parameters}</ssd:Component>"#
        )
    };
    let values = r#"<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>
        <ssv:Parameter name="text"><ssv:String value="up"/></ssv:Parameter><ssv:Parameter name="bytes"><ssv:Binary value="0a"/></ssv:Parameter>
        </ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"#;
    let wire = |name: &str| {
        format!(
            r#"<ssd:Connection startElement="a" startConnector="{name}_out" endElement="b" endConnector="{name}"/>"#
        )
    };
    let text = format!(
        r#"<ssd:SystemStructureDescription xmlns:ssd="d" xmlns:ssc="c" xmlns:ssv="v" version="1.0" name="s"><ssd:System name="s">
        <ssd:Elements>{}{}</ssd:Elements><ssd:Connections>{}{}</ssd:Connections></ssd:System></ssd:SystemStructureDescription>"#,
        component("a", values),
        component("b", ""),
        wire("text"),
        wire("bytes"),
    );
    let file = scratch("structure").join("s.ssd");
    fs::write(&file, &text).unwrap();
    let system = load(&file).unwrap();
    let mut started = master(&system, &[], Schedule::Standard).unwrap();
    run(&mut started, 2).unwrap();
    let value = |name: &str| started.text(system.port(name).unwrap()).unwrap();
    assert_eq!([value("b.text_out"), value("b.bytes_out")], ["up", "0A"]);
    fs::write(
        &file,
        text.replace(
            "\"bytes\" kind=\"input\"><ssc:Binary/>",
            "\"bytes\" kind=\"input\"><ssc:String/>",
        ),
    )
    .unwrap();
    assert_holds(
        load(&file).map(|_| ()),
        &["line ", "the types differ, Binary and String"],
    );
}

/// 10 K of difference are 10 °C of difference; a temperature takes the offset.
#[test]
fn differences_take_no_offset() {
    for (test, output, expected) in [
        ("difference", "dT_out", 10.0),
        ("absolute", "T_out", 10.0 - 273.15),
    ] {
        let system = two(test, "", &[&format!("a.{output}=b.T")]).unwrap();
        let mut started = master(&system, &["a.T=10"], Schedule::Standard).unwrap();
        run(&mut started, 1).unwrap();
        let found = number(&system, &started, "b.T");
        assert_eq!(found, expected, "{output}");
    }
}
