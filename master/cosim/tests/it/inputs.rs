//! Inputs as tables: from memory, with units, and from what another run has written.

use std::fs;
use std::sync::Arc;

use cosim::cli::CsvArgs;
use cosim::io::input_table::{Column, Table};
use cosim::io::numbers::number;
use cosim::master::Schedule;
use cosim::run::observer::Observer;
use cosim::run::recording::Recording;
use cosim::run::simulate::{self, Experiment};
use cosim::structure::FmuUse;
use cosim::structure::system::System;

use super::support::{fmu, oscillator, scratch, settings, stepping, system};

/// The spring alone.
pub fn spring(name: &str) -> System {
    let folder = scratch(name);
    fs::create_dir_all(&folder).unwrap();
    let file = folder.join("spring.fmu");
    fs::write(&file, fmu("spring")).unwrap();
    System::from_fmus(&[file], &[], &FmuUse::default()).unwrap()
}

fn experiment(system: &System, table: Option<Table>) -> Experiment {
    Experiment {
        stop: Some(1.5),
        settings: settings(system, &["spring.k=2"]).unwrap(),
        inputs: table.map(Arc::new),
        ..Experiment::new(stepping(0.25, Schedule::Jacobi))
    }
}

/// The signals of a run.
fn record(
    system: &System,
    experiment: &Experiment,
    names: &[&str],
) -> anyhow::Result<Vec<Vec<f64>>> {
    let ports: Vec<_> = names.iter().map(|n| system.port(n).unwrap()).collect();
    let mut recording = Recording::new(system, &ports)?;
    let (master, stop) = (experiment.start(system)?, experiment.stop(system)?);
    simulate::run(system, master, stop, &|_, _| (), |master| {
        recording.add(master)
    })?;
    Ok(ports
        .iter()
        .map(|p| recording.column(*p).unwrap().to_vec())
        .collect())
}

fn table(times: &[f64], columns: &[(&str, Option<&str>, &[f64])]) -> Table {
    let column = |(name, unit, values): &(&str, Option<&str>, &[f64])| Column {
        name: (*name).into(),
        unit: unit.map(String::from),
        values: values.to_vec(),
    };
    Table {
        times: times.to_vec(),
        columns: columns.iter().map(column).collect(),
    }
}

/// F = −k (1 + stage) x; x in mm, linear between rows and held outside of them; the stage holds.
#[test]
fn a_table_in_memory_is_an_input() {
    let system = spring("memory");
    let rows = table(
        &[0.75, 1.25],
        &[
            ("spring.x", Some("mm"), &[1000.0, 3000.0]),
            ("spring.stage", None, &[0.0, 2.0]),
        ],
    );
    let found = record(&system, &experiment(&system, Some(rows)), &["spring.F"]).unwrap();
    assert_eq!(found[0], [-2.0, -2.0, -4.0, -18.0, -18.0]);
    for (times, columns, part) in [
        (
            &[0.0, 0.0, 0.0][..],
            table(&[], &[("spring.x", None, &[1.0, 2.0, 3.0])]),
            "the time 0 s stands in three rows",
        ),
        (
            &[1.0, 0.0][..],
            table(&[], &[("spring.x", None, &[1.0, 2.0])]),
            "the time 0 s must not be less than the one before, 1 s",
        ),
        (
            &[][..],
            table(&[], &[("spring.x", None, &[])]),
            "has no rows",
        ),
        (
            &[0.0][..],
            table(&[], &[("spring.x", None, &[1.0, 2.0])]),
            "column `spring.x` has 2 values at 1 times",
        ),
        (
            &[0.0][..],
            table(&[], &[("spring.x", None, &[f64::NAN])]),
            "column `spring.x`: at 0 s `NaN` is not a finite number",
        ),
        (
            &[0.0][..],
            table(&[], &[("spring.stage", None, &[0.5])]),
            "`0.5` is not a whole number from -2147483648",
        ),
        (
            &[0.0][..],
            table(&[], &[("spring.off", None, &[2.0])]),
            "`2` is not true (1) or false (0)",
        ),
        (
            &[0.0][..],
            table(&[], &[("spring.x", Some("V"), &[1.0])]),
            "column `spring.x`: its unit is `V`, that of the input is `m`",
        ),
        (
            &[0.0][..],
            table(&[], &[("spring.k", None, &[1.0])]),
            "`spring.k` is no input that takes numbers",
        ),
    ] {
        let table = Table {
            times: times.to_vec(),
            ..columns
        };
        let error = record(&system, &experiment(&system, Some(table)), &[]).unwrap_err();
        assert!(format!("{error:#}").contains(part), "{error:#}");
    }
}

/// Two rows of one time are a jump: the line before ends in the first value, at the time itself the
/// second one counts; the first and the last row may jump too.
#[test]
fn two_rows_of_one_time_are_a_jump() {
    let system = spring("jump");
    let rows = table(
        &[0.0, 0.0, 0.5, 0.5, 1.0, 1.5, 1.5],
        &[("spring.x", None, &[9.0, 1.0, 2.0, -1.0, 0.0, 4.0, 7.0])],
    );
    // Points from 0.5 to 1.5 s; F = -2 x.
    let found = record(&system, &experiment(&system, Some(rows)), &["spring.F"]).unwrap();
    assert_eq!(found[0], [-1.0, -0.5, 0.0, 2.0, 7.0].map(|x: f64| -2.0 * x));
}

/// The motion that one run wrote, with its units, moves the spring of another one: the same force,
/// bit for bit.
#[test]
fn what_a_run_writes_another_one_reads() {
    let whole = system("writes", &oscillator()).unwrap();
    let csv = scratch("writes.csv");
    let args = CsvArgs {
        csv: Some(csv.clone()),
        signals: vec![
            "spring.x".into(),
            "spring.x_dot".into(),
            "spring.off".into(),
            "mass.steps".into(),
            "spring.F".into(),
        ],
        interval: None,
    };
    let first = experiment(&whole, None);
    let mut log = args
        .log(&whole, &first, false, || unreachable!())
        .unwrap()
        .unwrap();
    let master = first.start(&whole).unwrap();
    simulate::run(&whole, master, 1.5, &|_, _| (), |master| {
        log.observe(master)
    })
    .unwrap();
    log.finish().unwrap();
    let alone = spring("reads");
    let chosen = [
        ("spring.x", "spring.x"),
        ("spring.x_dot", "spring.x_dot"),
        ("spring.off", "spring.off"),
        ("spring.stage", "mass.steps"),
    ];
    let chosen = chosen.map(|(a, b)| (a.to_string(), b.to_string()));
    let read = Table::load(&csv, &alone, &chosen[..3]).unwrap();
    let force = record(&alone, &experiment(&alone, Some(read)), &["spring.F"]).unwrap();
    let text = fs::read_to_string(&csv).unwrap();
    let place = text
        .lines()
        .next()
        .unwrap()
        .split(',')
        .position(|name| name == "spring.F");
    let cell = |line: &str| {
        line.split(',')
            .nth(place.unwrap())
            .unwrap()
            .parse()
            .unwrap()
    };
    let written: Vec<f64> = text.lines().skip(1).map(cell).collect();
    assert_eq!((force[0].len(), &force[0]), (5, &written));
    // Integers are written as 3.0 and read as 3.
    let stages = Table::load(&csv, &alone, &chosen).unwrap();
    assert_eq!(stages.columns[3].values, [0.0, 1.0, 2.0, 3.0, 4.0]);
    // The same numbers in another unit are others.
    fs::write(
        csv.with_extension("units.csv"),
        "signal,unit\ntime,s\nspring.x,mm\n",
    )
    .unwrap();
    let smaller = Table::load(&csv, &alone, &chosen[..1]).unwrap();
    let force = record(&alone, &experiment(&alone, Some(smaller)), &["spring.F"]).unwrap();
    let expected = -2.0 * 1e-3 * stages.columns[0].values[2];
    assert!(
        (force[0][2] - expected).abs() <= 2.0 * f64::EPSILON,
        "{force:?}"
    );
    let missing = [("spring.x".to_string(), "mass.y".to_string())];
    let error = format!("{:#}", Table::load(&csv, &alone, &missing).unwrap_err());
    assert!(
        error.contains(
            "writes.csv`: row 1: there is no column `mass.y` for `spring.x`; there are spring.x, "
        ),
        "{error}"
    );
    fs::write(csv.with_extension("units.csv"), "signal,unit\ntime,ms\n").unwrap();
    let error = format!("{:#}", Table::load(&csv, &alone, &chosen).unwrap_err());
    assert!(
        error.contains("writes.units.csv`: row 2: the unit of `time` is `ms`; it must be `s`"),
        "{error}"
    );
}

/// Items by name or number, truth values by word or number, integers as they are written; what a
/// variable cannot take is told with what it can.
#[test]
fn values_are_numbers_that_their_variables_can_take() {
    let text = r#"<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="t"><CoSimulation modelIdentifier="M"/>
      <TypeDefinitions><EnumerationType name="Gear"><Item name="low" value="1"/><Item name="high" value="4"/></EnumerationType></TypeDefinitions>
      <ModelVariables><Enumeration name="gear" valueReference="1" causality="input" declaredType="Gear" start="1"/>
      <Int8 name="n" valueReference="2" causality="input" start="0"/><Float64 name="x" valueReference="3" causality="input" start="0" max="2.5"/>
      <Boolean name="on" valueReference="4" causality="input" start="true"/></ModelVariables><ModelStructure/></fmiModelDescription>"#;
    let description = fmi_description::Description::parse(text).unwrap();
    for (name, text, expected) in [
        ("gear", "high", Ok(4.0)),
        ("gear", "4", Ok(4.0)),
        ("gear", "1.0", Ok(1.0)),
        ("gear", "2", Err("`2` is not one of low (1), high (4)")),
        ("n", "-128", Ok(-128.0)),
        ("n", "3.0", Ok(3.0)),
        (
            "n",
            "128",
            Err("`128` is not a whole number from -128 to 127"),
        ),
        (
            "n",
            "0.5",
            Err("`0.5` is not a whole number from -128 to 127"),
        ),
        ("x", "2.5", Ok(2.5)),
        ("x", "2.6", Err("`2.6` is not a number of at most 2.5")),
        ("on", "true", Ok(1.0)),
        ("on", "True", Ok(1.0)),
        ("on", "False", Ok(0.0)),
        ("on", "0", Ok(0.0)),
        ("on", "1.0", Ok(1.0)),
        ("on", "yes", Err("`yes` is not true (1) or false (0)")),
    ] {
        let found = number(description.variable(name).unwrap(), text);
        let found = found.map_err(|error| error.to_string());
        assert_eq!(found, expected.map_err(String::from), "{name} {text}");
    }
}

/// Setting an input forgets its derivative, so derivatives are passed after all that is set: a table
/// that says what is there anyway leaves every bit.
#[test]
fn derivatives_pass_beside_a_table() {
    let system = system("derivatives-and-table", &oscillator()).unwrap();
    let of = |inputs: Option<Table>| {
        let experiment = Experiment {
            stepping: stepping(0.01, Schedule::JacobiDerivatives),
            settings: settings(&system, &["mass.x_start=1"]).unwrap(),
            ..experiment(&system, inputs)
        };
        record(&system, &experiment, &["mass.x", "spring.F"]).unwrap()
    };
    let same = table(&[0.0], &[("spring.stage", None, &[0.0])]);
    assert_eq!(of(Some(same)), of(None));
}
