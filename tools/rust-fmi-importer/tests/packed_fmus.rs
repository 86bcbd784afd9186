//! `rust-fmi` reads and runs packed FMUs, so that our reader is not the only one that does. The
//! environment variable `FMU_DIR` names the folder of the FMUs.

use std::{env, fs};
use std::io::{Cursor, Read as _, Write as _};
use std::path::{Path, PathBuf};

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi3::import::Fmi3Import;
use fmi::traits::FmiImport;

/// Communication step, s.
const STEP: f64 = 1e-3;
const STEPS: u32 = 100;

fn packed(name: &str) -> Vec<u8> {
    let folder = env::var_os("FMU_DIR");
    let folder = folder.expect("the variable FMU_DIR names the folder of the packed FMUs");
    let path: PathBuf = Path::new(&folder).join(name);
    fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn open<I: FmiImport>(fmu: Vec<u8>) -> Result<I, fmi::Error> {
    fmi::import::new(Cursor::new(fmu))
}

/// An FMU of FMI 2.0, initialized, stepped, and asked for all its real numbers after each step.
fn run_of_2(fmu: Vec<u8>, settings: &[(&str, f64)], outputs: &[&str]) -> Vec<Vec<f64>> {
    use fmi::fmi2::instance::{CoSimulation as _, Common as _, InstanceCS};
    let import: Fmi2Import = open(fmu).unwrap();
    let reference = |name: &&str| {
        let all = &import.model_description().model_variables.variables;
        let variable = all.iter().find(|variable| variable.name == *name);
        variable
            .unwrap_or_else(|| panic!("no variable {name}"))
            .value_reference
    };
    let outputs: Vec<_> = outputs.iter().map(reference).collect();
    let mut instance = InstanceCS::new(&import, "alone", false, true).unwrap();
    instance.setup_experiment(None, 0.0, None).unwrap();
    instance.enter_initialization_mode().unwrap();
    for (name, value) in settings {
        instance.set_real(&[reference(name)], &[*value]).unwrap();
    }
    instance.exit_initialization_mode().unwrap();
    let rows = (0..STEPS).map(|k| {
        instance.do_step(f64::from(k) * STEP, STEP, true).unwrap();
        let mut row = vec![f64::NAN; outputs.len()];
        instance.get_real(&outputs, &mut row).unwrap();
        row
    });
    let rows = rows.collect();
    instance.terminate().unwrap();
    rows
}

/// The same of an FMU of FMI 3.0, without Event Mode.
fn run_of_3(fmu: Vec<u8>, settings: &[(&str, f64)], outputs: &[&str]) -> Vec<Vec<f64>> {
    use fmi::fmi3::instance::InstanceCS;
    use fmi::fmi3::{CoSimulation as _, Common as _, GetSet as _};
    let import: Fmi3Import = open(fmu).unwrap();
    let reference = |name: &&str| {
        let variable = import
            .model_description()
            .model_variables
            .find_by_name(name);
        variable
            .unwrap_or_else(|| panic!("no variable {name}"))
            .value_reference()
    };
    let outputs: Vec<_> = outputs.iter().map(reference).collect();
    let mut instance = InstanceCS::new(&import, "alone", false, true, false, false, &[]).unwrap();
    instance.enter_initialization_mode(None, 0.0, None).unwrap();
    for (name, value) in settings {
        instance.set_float64(&[reference(name)], &[*value]).unwrap();
    }
    instance.exit_initialization_mode().unwrap();
    let rows = (0..STEPS).map(|k| {
        let (mut event, mut end, mut early, mut time) = (false, false, false, 0.0);
        let t = f64::from(k) * STEP;
        let step = instance.do_step(t, STEP, true, &mut event, &mut end, &mut early, &mut time);
        step.unwrap();
        let mut row = vec![f64::NAN; outputs.len()];
        instance.get_float64(&outputs, &mut row).unwrap();
        row
    });
    let rows = rows.collect();
    instance.terminate().unwrap();
    rows
}

/// The FMU with the model description changed by `edit`.
fn edited(fmu: &[u8], edit: impl Fn(&str) -> String) -> Vec<u8> {
    let mut from = zip::ZipArchive::new(Cursor::new(fmu)).unwrap();
    let mut to = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for i in 0..from.len() {
        let mut file = from.by_index(i).unwrap();
        let name = file.name().to_string();
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).unwrap();
        if name == "modelDescription.xml" {
            bytes = edit(std::str::from_utf8(&bytes).unwrap()).into_bytes();
        }
        to.start_file(name, zip::write::SimpleFileOptions::default())
            .unwrap();
        to.write_all(&bytes).unwrap();
    }
    to.finish().unwrap().into_inner()
}

/// The text without units, and without the attributes that name them.
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
fn it_runs_our_fmus_of_fmi_2() {
    for (name, settings, outputs) in [
        ("Emla", &[("v_q", 12.5)][..], &["F", "i_q", "w_m"][..]),
        (
            "Hdrm",
            &[("inertia_scale", 1.25)],
            &["zeta[1]", "zeta_dot[3]", "tip.position[2]"],
        ),
        (
            "Controller",
            &[],
            &["v_q[2]", "f_required[1]", "tip_error_norm"],
        ),
    ] {
        let rows = run_of_2(packed(&format!("{name}.fmu")), settings, outputs);
        let all: Vec<f64> = rows.concat();
        assert!(all.iter().all(|value| value.is_finite()), "{name}: {all:?}");
        assert!(rows.first() != rows.last(), "{name}: nothing has moved");
    }
}

/// Its reader of FMI 3.0 (`fmi-schema` 0.8.0) knows no units of variables and writes two base units
/// in the wrong case, and refuses what it does not know. Without units it opens and runs the FMU,
/// which gives the numbers of FMI 2.0, every bit.
#[test]
fn it_runs_our_fmu_of_fmi_3_where_that_says_no_units() {
    let fmu = packed("fmi3/Emla.fmu");
    let refused = open::<Fmi3Import>(fmu.clone()).err();
    let refused =
        refused.expect("it reads units now: this test, and docs/fmus/interoperability.md, can say so");
    let refused = format!("{refused:?}");
    assert!(refused.to_lowercase().contains("unit"), "{refused}");
    let settings = [("v_q", 12.5)];
    let outputs = ["F", "i_q", "w_m"];
    let of_3 = run_of_3(edited(&fmu, without_units), &settings, &outputs);
    assert_eq!(of_3, run_of_2(packed("Emla.fmu"), &settings, &outputs));
}
