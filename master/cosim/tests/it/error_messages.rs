//! Error messages: they name component, variable and time, and give the reason that the FMU logged.

use cosim::master::{Master, Schedule};
use cosim::structure::system::System;

use super::support::{
    assert_contains, link, load, oscillator, scratch, settings, ssd, stepping, system, write_zip,
};

fn failure(system: &System, texts: &[&str]) -> String {
    let run = || {
        let settings = settings(system, texts)?;
        let mut master = Master::new(system, &settings, stepping(0.01, Schedule::GaussSeidel))?;
        (0..100).try_for_each(|_| master.step())
    };
    format!("{:#}", run().unwrap_err())
}

#[test]
fn a_refused_step_names_component_time_and_reason() {
    let text = failure(
        &system("step", &oscillator()).unwrap(),
        &["mass.fails_at=0.525"],
    );
    assert_contains(
        &text,
        &[
            "mass",
            "fmi2DoStep",
            "at t = 0.53 s",
            "fmi2Discard",
            "`fails_at` is reached",
        ],
    );
}

#[test]
fn a_refused_value_names_the_variable() {
    // F = −k x = −3000 N is outside the ±1000 N of the mass.
    let text = failure(&system("value", &oscillator()).unwrap(), &["spring.k=3000"]);
    assert_contains(
        &text,
        &["mass", "of f", "in initialization", "fmi2Discard", "1000"],
    );
}

#[test]
fn wrong_settings_name_what_there_is() {
    let system = system("setting", &oscillator()).unwrap();
    for (setting, parts) in [
        ("rope.k=1", ["variable `rope.k`", "spring, mass"]),
        ("spring.kk=1", ["spring", "no variable `kk`"]),
        ("spring.k=soft", ["spring.k", "`soft` is not a number"]),
        ("spring.k=-1", ["spring", "fmi2Discard"]),
    ] {
        assert_contains(&failure(&system, &[setting]), &parts);
    }
}

#[test]
fn an_algebraic_loop_is_named() {
    let connections = link(("spring", "F"), ("mass", "f"), "")
        + &link(("mass", "x_ddot"), ("spring", "x_ddot"), "");
    let system = system("loop", &ssd(&connections)).unwrap();
    let error = Master::new(&system, &[], stepping(0.01, Schedule::Jacobi))
        .err()
        .unwrap()
        .to_string();
    assert_contains(
        &error,
        &[
            "algebraic loop: spring.F -> mass.f -> mass.x_ddot -> spring.x_ddot -> spring.F; ",
            "must have a state, or a delay of a communication step",
        ],
    );
}

#[test]
fn units_that_do_not_fit_are_named() {
    let connections = link(("mass", "x_ddot"), ("spring", "x"), "");
    let system = system("units", &ssd(&connections)).unwrap();
    let error = format!("{:#}", system.wiring().err().unwrap());
    assert_contains(
        &error,
        &[
            "connection mass.x_ddot -> spring.x: the FMUs' units differ, `m/s2` and `m`; ",
            "must say suppressUnitConversion=\"true\"",
        ],
    );
}

#[test]
fn files_that_are_no_systems_are_refused() {
    let error = |name: &str, entries: &[(String, Vec<u8>)]| {
        let path = scratch(name);
        write_zip(std::fs::File::create(&path).unwrap(), entries);
        format!("{:#}", load(&path).err().unwrap())
    };
    assert_contains(
        &error("empty.ssp", &[]),
        &["empty.ssp", "holds no SystemStructure.ssd"],
    );
    let structure = ("SystemStructure.ssd".to_string(), oscillator().into_bytes());
    assert_contains(
        &error("no_fmu.ssp", std::slice::from_ref(&structure)),
        &["component `spring`", "holds no resources/Spring.fmu"],
    );
    let broken = |fmu: &[u8]| {
        [
            structure.clone(),
            ("resources/Spring.fmu".to_string(), fmu.to_vec()),
        ]
    };
    assert_contains(
        &error("no_zip.ssp", &broken(b"text")),
        &["resources/Spring.fmu", "not a ZIP archive"],
    );
    let mut bytes = std::io::Cursor::new(Vec::new());
    write_zip(
        &mut bytes,
        &[(
            "modelDescription.xml".to_string(),
            b"<fmiModelDescription fmiVersion=".to_vec(),
        )],
    );
    assert_contains(
        &error("xml.ssp", &broken(&bytes.into_inner())),
        &["resources/Spring.fmu", "description cannot be read"],
    );
    assert_contains(
        &format!("{:#}", load(&scratch("absent.ssp")).err().unwrap()),
        &["absent.ssp", "cannot be read"],
    );
}
