//! `rust-fmi` reads and runs FMUs that our kit made, so that our reader is not the only one that
//! does.

use cosim::fmu::Fmu;
use fmi::fmi2;
use fmi::fmi3;
use fmi::fmi3::GetSet as _;
use fmi_description::Version;

use super::support::{files, fmu, packed};

/// The spring of FMI 3.0 with its description changed by `edit`.
fn spring_of_3(edit: impl Fn(&str) -> String) -> Vec<u8> {
    let mut files = files("spring", Version::Fmi3);
    for (name, bytes) in &mut files {
        if name == "modelDescription.xml" {
            *bytes = edit(std::str::from_utf8(bytes).unwrap()).into_bytes();
        }
    }
    packed(&files)
}

/// The text without the attributes `names` and without units.
fn without_units(text: &str) -> String {
    let (head, rest) = text.split_once("<UnitDefinitions>").unwrap();
    let (_, tail) = rest.split_once("</UnitDefinitions>").unwrap();
    let mut text = format!("{head}{tail}");
    for name in ["unit", "quantity", "displayUnit", "nominal"] {
        let start = format!(" {name}=\"");
        while let Some(from) = text.find(&start) {
            let value = from + start.len();
            let to = value + text[value..].find('"').unwrap() + 1;
            text.replace_range(from..to, "");
        }
    }
    text
}

#[test]
fn it_opens_our_fmu_of_fmi_2() {
    use fmi2::import::Fmi2Import;
    use fmi2::instance::{CoSimulation as _, Common as _, InstanceCS};
    let import: Fmi2Import = fmi::import::new(std::io::Cursor::new(fmu("spring"))).unwrap();
    let mut spring = InstanceCS::new(&import, "spring", false, true).unwrap();
    spring.setup_experiment(None, 0.0, None).unwrap();
    spring.enter_initialization_mode().unwrap();
    spring.exit_initialization_mode().unwrap();
    spring.do_step(0.0, 0.1, true).unwrap();
}

/// Its reader of FMI 3.0 (`fmi-schema` 0.8.0) knows no units of variables and writes two base units
/// in the wrong case, and refuses what it does not know. Without units it opens and runs the FMU:
/// F = −k x.
#[test]
fn it_opens_our_fmu_of_fmi_3_where_that_says_no_units() {
    use fmi3::Common as _;
    use fmi3::import::Fmi3Import;
    use fmi3::instance::InstanceCS;
    let open = |bytes: Vec<u8>| fmi::import::new::<_, Fmi3Import>(std::io::Cursor::new(bytes));
    let refused = open(spring_of_3(str::to_string)).err();
    let refused =
        refused.expect("it reads units now: this test, and docs/fmus/interoperability.md, can say so");
    assert!(format!("{refused:?}").contains("unit"), "{refused:?}");
    let bytes = spring_of_3(without_units);
    let ours = Fmu::load("Spring.fmu", bytes.clone()).unwrap();
    let reference = |name: &str| ours.description.variable(name).unwrap().reference;
    let import = open(bytes).unwrap();
    let mut spring = InstanceCS::new(&import, "spring", false, true, true, false, &[]).unwrap();
    spring.enter_initialization_mode(None, 0.0, None).unwrap();
    spring.set_float64(&[reference("x")], &[0.25]).unwrap();
    spring.exit_initialization_mode().unwrap();
    let (mut k, mut force) = ([0.0], [0.0]);
    spring.get_float64(&[reference("k")], &mut k).unwrap();
    spring.get_float64(&[reference("F")], &mut force).unwrap();
    assert!(k[0] > 0.0);
    assert_eq!(force[0], -k[0] * 0.25);
}
