//! Alarms that a structure declares make the verdict bad from the first communication point on at
//! which they hold. The oracle is the recorded variable.

use cosim::master::{Master, Schedule};
use cosim::run::observer::Function;
use cosim::run::simulate::{Outcome, Plan, run, run_plan};
use cosim::structure::system::System;
use cosim::{Experiment, Recording};
use fmi_description::Version;

use super::support::{
    assert_contains, edited, edited_of, load, oscillator, packed, scratch, stepping, system,
    write_zip,
};

/// The oscillator with alarms of the system.
fn with_alarms(alarms: &str) -> String {
    let list = annotation(
        "io.github.hdrm-fmu.alarms",
        &format!("<Alarms>{alarms}</Alarms>"),
    );
    let end = "</ssd:Connections>";
    oscillator().replace(end, &format!("{end}{list}"))
}

fn annotation(kind: &str, content: &str) -> String {
    format!(
        "<ssd:Annotations><ssc:Annotation type=\"{kind}\">{content}</ssc:Annotation></ssd:Annotations>"
    )
}

fn alarm(variable: &str, condition: &str) -> String {
    format!("<Alarm variable=\"{variable}\" {condition} text=\"it is so\"/>")
}

fn outcome(system: &System, schedule: Schedule) -> Outcome {
    let master = Master::new(system, &[], stepping(0.01, schedule)).unwrap();
    run(system, master, 2.5, &|_, _| (), |_| Ok(())).unwrap()
}

/// The first time at which a variable has a value for which `holds`, as text; the values come from
/// a recording.
fn first(system: &System, schedule: Schedule, name: &str, holds: impl Fn(f64) -> bool) -> String {
    let port = system.port(name).unwrap();
    let master = Master::new(system, &[], stepping(0.01, schedule)).unwrap();
    let mut recording = Recording::new(system, &[port]).unwrap();
    run(system, master, 2.5, &|_, _| (), |master| {
        recording.add(master)
    })
    .unwrap();
    let column = recording.column(port).unwrap();
    let k = column.iter().position(|v| holds(*v)).unwrap();
    format!(
        "first at t = {} s",
        (1e9 * recording.times[k]).round() / 1e9
    )
}

const SCHEDULES: [Schedule; 4] = [
    Schedule::Standard,
    Schedule::GaussSeidel,
    Schedule::Jacobi,
    Schedule::JacobiDerivatives,
];

#[test]
fn an_alarm_says_when_it_first_held() {
    let alarms = [
        alarm("mass.is_left", "equals=\"true\""),
        alarm("mass.x_dot", "below=\"-0.5\""),
        alarm("mass.steps", "above=\"17\""),
        alarm("mass.steps", "above=\"1000\""),
        alarm("mass.x", "equals=\"1\""),
    ];
    for version in [Version::Fmi2, Version::Fmi3] {
        let name = format!("alarms_{version:?}");
        let unchanged = |_: &str, text: &str| text.to_string();
        let structure = with_alarms(&alarms.concat());
        let system = edited_of(version, &name, &structure, unchanged).unwrap();
        for schedule in SCHEDULES {
            let outcome = outcome(&system, schedule);
            let bad = outcome.verdict.findings().iter();
            let texts: Vec<_> = bad
                .filter(|f| f.is_bad && f.text.starts_with("it is so"))
                .map(|f| f.text.as_str())
                .collect();
            let first =
                |name: &str, holds: &dyn Fn(f64) -> bool| first(&system, schedule, name, holds);
            assert_eq!(texts.len(), 4, "{texts:?}");
            let left = first("mass.x", &|x| x < 0.0);
            assert_contains(texts[0], &["it is so: `mass.is_left` is true", &left]);
            let fast = first("mass.x_dot", &|v| v < -0.5);
            assert_contains(texts[1], &["`mass.x_dot` is -0.5", &fast]);
            let steps = first("mass.steps", &|n| n > 17.0);
            assert_contains(texts[2], &["`mass.steps` is 18", &steps]);
            assert_contains(texts[3], &["`mass.x` is 1, first at t = 0.5 s"]);
        }
    }
    let good = system("alarms_good", &with_alarms(&alarms[3])).unwrap();
    let text = outcome(&good, Schedule::GaussSeidel).verdict.to_string();
    assert!(!text.contains("it is so"), "{text}");
}

/// A component's own alarm names its variable alone; items are those of its enumeration.
#[test]
fn a_component_declares_its_alarms_by_items_too() {
    let list = annotation(
        "io.github.hdrm-fmu.alarms",
        "<Alarms><Alarm variable=\"steps\" above=\"walks\" text=\"too far\"/></Alarms>",
    );
    let at = oscillator().rfind("</ssd:Component>").unwrap();
    let mut structure = oscillator();
    structure.insert_str(at, &list);
    let items = |_: &str, text: &str| {
        let Some(steps) = text.find("name=\"steps\"") else {
            return text.to_string();
        };
        let (before, own) = text.split_at(steps);
        let own = own.replacen("<Integer", "<Enumeration declaredType=\"Gait\"", 1);
        let types = "<TypeDefinitions><SimpleType name=\"Gait\"><Enumeration><Item name=\"rests\" value=\"0\"/><Item name=\"walks\" value=\"7\"/>\
            <Item name=\"runs\" value=\"8\"/></Enumeration></SimpleType></TypeDefinitions>";
        let start = "<ModelVariables>";
        before.replace(start, &format!("{types}{start}")) + &own
    };
    let structure = structure.replace(
        "name=\"steps\" kind=\"output\"><ssc:Integer/>",
        "name=\"steps\" kind=\"output\"><ssc:Enumeration name=\"Gait\"/>",
    );
    let system = edited("alarms_items", &structure, items).unwrap();
    let text = outcome(&system, Schedule::GaussSeidel).verdict.to_string();
    assert_contains(
        &text,
        &[
            "verdict: BAD",
            "too far: `mass.steps` is runs, first at t = 0.58 s",
        ],
    );
}

#[test]
fn a_resumed_run_knows_what_held_before() {
    let structure = with_alarms(&alarm("mass.steps", "equals=\"3\""));
    let system = system("alarms_resumed", &structure).unwrap();
    let started = || Master::new(&system, &[], stepping(0.01, Schedule::GaussSeidel)).unwrap();
    let file = scratch("alarms_resumed/snapshot");
    let mut nothing = Function(|_: &Master| Ok(()));
    let mut made = |plan: Plan| run_plan(&system, started(), &plan, &|_, _| (), &mut nothing);
    let experiment = Experiment::new(stepping(0.01, Schedule::GaussSeidel));
    let key = Plan::to(0.7).key(&system, &experiment);
    let saving = Plan {
        snapshots: vec![(0.7, file.clone())],
        key: Some(key.clone()),
        ..Plan::to(0.7)
    };
    let first = made(saving).unwrap();
    let resuming = Plan {
        resume: Some(file),
        key: Some(key),
        ..Plan::to(0.9)
    };
    let resumed = made(resuming).unwrap();
    assert_contains(&first.verdict.to_string(), &["first at t = 0.53 s"]);
    assert_contains(
        &resumed.verdict.to_string(),
        &["`mass.steps` is 3, first at t = 0.53 s"],
    );
}

#[test]
fn wrong_alarms_are_refused_by_name() {
    let of = |content: &str| {
        let loaded = system("alarms_refused", &with_alarms(content));
        loaded.map_or_else(|error| format!("{error:#}"), |_| "it was accepted".into())
    };
    let equals = "equals=\"true\"";
    for (content, parts) in [
        (alarm("mass.is_lost", equals), ["line", "`mass.is_lost`"]),
        (
            alarm("moon.is_left", equals),
            ["`moon.is_left`", "spring, mass"],
        ),
        (
            alarm("mass.is_left", "equals=\"perhaps\""),
            ["`mass.is_left`", "`perhaps` is not true"],
        ),
        (
            alarm("mass.is_left", "above=\"0.5\""),
            ["`mass.is_left`", "`0.5`"],
        ),
        (
            alarm("mass.x", "below=\"NaN\""),
            ["`mass.x`", "`NaN` is not a finite number"],
        ),
        (
            alarm("mass.steps", "above=\"many\""),
            ["`mass.steps`", "`many`"],
        ),
        (
            alarm("mass.x", ""),
            ["line", "one condition: equals, above or below"],
        ),
        (
            alarm("mass.x", "below=\"0\" above=\"1\""),
            ["line", "one condition"],
        ),
        (alarm("mass.x", "equal=\"0\""), ["line", "one condition"]),
        (
            "<Alarm variable=\"mass.x\" below=\"0\"/>".into(),
            ["line", "no attribute text"],
        ),
        (
            "<Alarm below=\"0\" text=\"low\"/>".into(),
            ["line", "no attribute variable"],
        ),
        (
            "<Alarn variable=\"mass.x\" below=\"0\" text=\"low\"/>".into(),
            ["line", "elements `Alarm`"],
        ),
    ] {
        assert_contains(&of(&content), &parts);
    }
    let structure = with_alarms("").replace("hdrm-fmu.alarms", "hdrm-fmu.alarm");
    let error = system("alarms_refused", &structure).err().unwrap();
    assert_contains(
        &format!("{error:#}"),
        &["`io.github.hdrm-fmu.alarm`", "`io.github.hdrm-fmu.alarms`"],
    );
    let empty = with_alarms("").replace("<Alarms></Alarms>", "");
    assert!(system("alarms_refused", &empty).is_err());
}

/// Somebody else's FMU need not have the outputs of the one that it stands for.
#[test]
fn an_alarm_on_an_fmu_that_was_replaced_is_left_out() {
    let alarms = alarm("mass.is_left", "equals=\"true\"") + &alarm("mass.steps", "above=\"17\"");
    system("alarms_replaced", &with_alarms(&alarms)).unwrap();
    let folder = scratch("alarms_replaced");
    let mut other = super::support::files("mass", Version::Fmi2);
    for (name, bytes) in &mut other {
        if name == "modelDescription.xml" {
            let text = String::from_utf8(bytes.clone()).unwrap();
            *bytes = text
                .replace("name=\"is_left\"", "name=\"is_west\"")
                .into_bytes();
        }
    }
    let file = folder.join("other.fmu");
    std::fs::write(&file, packed(&other)).unwrap();
    let else_in = Vec::new();
    let place = cosim::structure::package::FmuPlace::Structure { else_in };
    let replaced = [("mass".to_string(), file)];
    let system = System::load(&folder.join("system.ssp"), None, &place, &replaced, &[]).unwrap();
    let remarks = system.structure.remarks.join("\n");
    assert_contains(&remarks, &["alarm on `mass.is_left` left out"]);
    let text = outcome(&system, Schedule::GaussSeidel).verdict.to_string();
    assert_contains(&text, &["`mass.steps` is 18"]);
}

/// Packages in packages: each names what is inside of it.
#[test]
fn alarms_of_nested_systems_and_packages_count() {
    let inner = with_alarms(&alarm("mass.steps", "equals=\"2\""));
    let files = |structure: &str| {
        let mut entries = vec![(
            "SystemStructure.ssd".to_string(),
            structure.as_bytes().to_vec(),
        )];
        for (name, example) in [("Spring", "spring"), ("Mass", "mass")] {
            entries.push((
                format!("resources/{name}.fmu"),
                super::support::fmu(example),
            ));
        }
        entries
    };
    let component = "<ssd:Component name=\"part\" source=\"resources/part.ssp\" type=\"application/x-ssp-package\"><ssd:Connectors/></ssd:Component>";
    let list = annotation(
        "io.github.hdrm-fmu.alarms",
        &format!(
            "<Alarms>{}</Alarms>",
            alarm("part.mass.steps", "equals=\"3\"")
        ),
    );
    let head = inner.split("<ssd:Elements>").next().unwrap().to_string();
    let tail = inner.split("</ssd:System>").nth(1).unwrap();
    let outer = format!("{head}<ssd:Elements>{component}</ssd:Elements>{list}</ssd:System>{tail}");
    let path = scratch("alarms_nested.ssp");
    let part = packed(&files(&inner));
    let entries = [
        ("SystemStructure.ssd".to_string(), outer.into_bytes()),
        ("resources/part.ssp".to_string(), part),
    ];
    write_zip(std::fs::File::create(&path).unwrap(), &entries);
    let system = load(&path).unwrap();
    let text = outcome(&system, Schedule::GaussSeidel).verdict.to_string();
    assert_contains(
        &text,
        &[
            "`part.mass.steps` is 2, first at t = 0.52 s",
            "`part.mass.steps` is 3, first at t = 0.53 s",
        ],
    );
}
