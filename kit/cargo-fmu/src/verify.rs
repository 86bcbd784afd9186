//! `cargo fmu verify`: runs the default experiment of an FMU and compares it with the results that
//! the FMU carries (FMI-LS-REF), or writes such results.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use fmi_description::{
    Access, Archive, Causality, ClockInterval, Description, Variability, Variable,
};
use fmi_import::Fmu;
use fmi_import::instance::{Instance, InstanceOptions, start_time, step_size};
use fmi_import::standard::Mode;
use fmi_import::status::OK;

use crate::reference::{References, Table};

/// The arguments of `cargo fmu verify`.
#[derive(Args)]
pub struct Arguments {
    /// FMU with a Co-Simulation interface, whoever made it
    fmu: PathBuf,
    /// Largest allowed deviation, relative to the largest magnitude of the variable in the result
    #[arg(long, value_name = "PART", default_value_t = 1e-6)]
    tolerance: f64,
    /// Write all outputs of the default experiment to this file instead, for `reference/` next to
    /// Cargo.toml
    #[arg(long, value_name = "FILE.csv")]
    write: Option<PathBuf>,
    /// Intervals between the rows that are written
    #[arg(long, value_name = "NUMBER", default_value_t = 20, requires = "write", value_parser = clap::value_parser!(u32).range(1..))]
    rows: u32,
}

impl Arguments {
    /// Verifies the FMU.
    ///
    /// # Errors
    /// It cannot be run, or there is nothing to compare with.
    pub fn run(&self) -> Result<ExitCode> {
        let name = || self.fmu.display().to_string();
        ensure!(
            self.tolerance >= 0.0,
            "--tolerance {} must be at least 0",
            self.tolerance
        );
        let mut archive = Archive::open(fs::read(&self.fmu).with_context(name)?)?;
        let references = References::read(&archive.read_all()?);
        let fmu = Fmu::open(&self.fmu)?;
        if let Some(path) = &self.write {
            let table = self.written(&fmu, &references.unwrap_or_default())?;
            fs::write(path, table).with_context(|| path.display().to_string())?;
            println!("made {}", path.display());
            return Ok(ExitCode::SUCCESS);
        }
        let references = references.with_context(name)?;
        ensure!(
            !references.results.is_empty(),
            "{}: its manifest of FMI-LS-REF names no result",
            name()
        );
        let mut is_same = true;
        for (file, expected) in &references.results {
            let times: Vec<_> = expected.rows.iter().map(|(t, _)| *t).collect();
            let variables = named(&fmu.description, &expected.names).context(file.clone())?;
            let found = simulate(&fmu, &references, &times, &variables)?;
            let (report, is_ok) = self.compared(file, expected, &found, &variables);
            println!("{report}");
            is_same &= is_ok;
        }
        Ok(match is_same {
            true => ExitCode::SUCCESS,
            false => ExitCode::FAILURE,
        })
    }

    /// The text of a result with all outputs.
    fn written(&self, fmu: &Fmu, references: &References) -> Result<Vec<u8>> {
        let (start, stop) = span(fmu)?;
        let part = |k| f64::from(k) / f64::from(self.rows);
        let times: Vec<_> = (0..=self.rows)
            .map(|k| start + (stop - start) * part(k))
            .collect();
        let is_output =
            |v: &&Variable| v.causality == Causality::Output && v.access() != Access::Clock;
        let names = fmu.description.variables.iter().filter(is_output);
        let variables = named(
            &fmu.description,
            &Vec::from_iter(names.map(|v| v.name.clone())),
        )?;
        let found = simulate(fmu, references, &times, &variables)?;
        let mut text = csv::Writer::from_writer(Vec::new());
        let names = variables.iter().map(|column| &*column.name);
        text.write_record(["time"].into_iter().chain(names))?;
        for (t, row) in times.iter().zip(found) {
            text.write_record([t.to_string()].iter().chain(&row))?;
        }
        Ok(text.into_inner()?)
    }

    /// What to say of a result, and whether it agrees.
    fn compared(
        &self,
        file: &str,
        expected: &Table,
        found: &[Vec<String>],
        variables: &[Column],
    ) -> (String, bool) {
        let (mut worst, mut place, mut wrong) = (0.0, String::new(), Vec::new());
        for (k, Column { name, .. }) in variables.iter().enumerate() {
            let numbers = |cell: &str| -> Option<Vec<f64>> {
                let words = cell.split_whitespace();
                words.map(|word| word.parse().ok()).collect()
            };
            let all = expected.rows.iter().filter_map(|(_, row)| numbers(&row[k]));
            let largest = all.flatten().fold(0.0, |a: f64, b| a.max(b.abs()));
            let scale = if largest > 0.0 { largest } else { 1.0 };
            for ((t, row), found) in expected.rows.iter().zip(found) {
                let (a, b) = (&row[k], &found[k]);
                let deviation = match (numbers(a), numbers(b)) {
                    (Some(a), Some(b)) if a.len() == b.len() => {
                        let each = a.iter().zip(&b).map(|(a, b)| (a - b).abs() / scale);
                        let known = each.map(|d| if d.is_nan() { f64::INFINITY } else { d });
                        known.fold(0.0, f64::max)
                    }
                    _ if a.eq_ignore_ascii_case(b) => 0.0,
                    _ => f64::INFINITY,
                };
                if deviation > worst {
                    worst = deviation;
                    place = format!(": `{name}` at {t} s");
                }
                if deviation > self.tolerance && wrong.len() < 5 {
                    wrong.push(format!("\n  t = {t} s: `{name}` = {b}; it must be {a}"));
                }
            }
        }
        let is_ok = wrong.is_empty();
        let verdict = if is_ok { "agrees with" } else { "DIFFERS from" };
        let (n, m) = (variables.len(), expected.rows.len());
        let report = format!(
            "{} {verdict} {file}: {n} variables at {m} times, tolerance {:e} of each variable's largest magnitude, largest deviation {worst:.2e}{place}{}",
            self.fmu.display(),
            self.tolerance,
            wrong.concat()
        );
        (report, is_ok)
    }
}

/// Start and stop time of the default experiment, s.
fn span(fmu: &Fmu) -> Result<(f64, f64)> {
    let stop = fmu.description.default_experiment.stop;
    let stop = stop.context("its DefaultExperiment has no stopTime; it must have one")?;
    Ok((start_time(fmu), stop))
}

/// What a column of a table stands for: a variable, or one element of an array, which FMI 2.0 has
/// as a variable of its own (`x[2]`).
struct Column<'a> {
    name: String,
    v: &'a Variable,
    element: Option<usize>,
}

/// The variables with these names.
fn named<'a>(description: &'a Description, names: &[String]) -> Result<Vec<Column<'a>>> {
    let elements = description.by_element();
    let of = |name: &String| {
        let whole = description.variables.iter().find(|v| v.name == *name);
        if let Some(v) = whole {
            return Some((v, None));
        }
        let found = elements.variables.iter().find(|v| v.name == *name)?;
        let is_it = |v: &&Variable| v.reference == found.reference;
        let v = description.variables.iter().find(is_it)?;
        Some((v, found.element))
    };
    let find = |name: &String| {
        let found = of(name).with_context(|| format!("`{name}` is no variable of the FMU"));
        let (v, element) = found?;
        let name = name.clone();
        Ok(Column { name, v, element })
    };
    names.iter().map(find).collect()
}

/// Runs the default experiment; the values of variables at these times, s.
fn simulate(
    fmu: &Fmu,
    references: &References,
    times: &[f64],
    variables: &[Column],
) -> Result<Vec<Vec<String>>> {
    let ticks_from_outside = |v: &&Variable| {
        let timing = v.timing.as_ref();
        timing.is_some_and(|timing| timing.interval == ClockInterval::Triggered)
    };
    if let Some(clock) = fmu.description.variables.iter().find(ticks_from_outside) {
        bail!(
            "clock `{}` is triggered, in Event Mode; an FMU that is run alone, without it, cannot be verified",
            clock.name
        );
    }
    let (start, stop) = span(fmu)?;
    let end = stop.max(*times.last().unwrap_or(&stop));
    let options = InstanceOptions {
        event_mode: false, // as the results of the Reference-FMUs were made
        ..InstanceOptions::USUAL
    };
    let mut instance = Instance::with_options(fmu, "verified", options)?;
    let mut arrays = BTreeMap::new();
    let (names, values): (Vec<_>, Vec<_>) = references.parameters.iter().cloned().unzip();
    for (column, value) in named(&fmu.description, &names)?.iter().zip(&values) {
        set(&instance, &mut arrays, column, value)?;
    }
    instance.setup(start, Some(end))?;
    instance.enter(Mode::Initialization)?;
    let inputs = match &references.input {
        Some(table) => Some((table, named(&fmu.description, &table.names)?)),
        None => None,
    };
    let mut set_inputs = |instance: &Instance, t: f64| match &inputs {
        Some((table, columns)) => set_inputs(instance, &mut arrays, table, columns, t),
        None => Ok(()),
    };
    set_inputs(&instance, start)?;
    instance.enter(Mode::Stepping)?;
    let (h, mut k) = (step_size(fmu), 0);
    let near = 1e-9 * (end - start) + 1e-12 * end.abs();
    let mut rows = Vec::new();
    for &t in times {
        while instance.time < t - near {
            set_inputs(&instance, instance.time)?;
            let mut next = start + f64::from(k + 1) * h;
            if next < t + near {
                k += 1;
            }
            next = next.min(t);
            let from = instance.time;
            match instance.step_with_end(next - from) {
                Ok(end) => ensure!(
                    !end.terminates || end.time >= next - near,
                    "the FMU ends the simulation at t = {} s, before the last row of the result",
                    end.time
                ),
                Err(error) => {
                    // FMI 2.0 discards the step in which an FMU ends the simulation.
                    let (mut ends, mut last) = (0, from);
                    let is_told = instance.is_terminated(&mut ends) == OK
                        && instance.last_time(&mut last) == OK;
                    if !(is_told && ends != 0 && last >= next - near) {
                        return Err(error);
                    }
                }
            }
            instance.time = next;
        }
        rows.push(read(&instance, variables)?);
    }
    Ok(rows)
}

fn read(instance: &Instance, columns: &[Column]) -> Result<Vec<String>> {
    let cell = |Column { name, v, element }: &Column| {
        let (status, values) = instance.values(v);
        instance.must(&format!("reading `{name}`"), status)?;
        Ok(match element {
            Some(k) => values[*k].clone(),
            None => values.join(" "),
        })
    };
    columns.iter().map(cell).collect()
}

/// The last values of arrays whose elements are set one by one, by reference.
type Arrays = BTreeMap<u32, Vec<String>>;

/// Sets a variable from a cell, an array from its elements with blanks between.
fn set(instance: &Instance, arrays: &mut Arrays, column: &Column, cell: &str) -> Result<()> {
    let Column { name, v, element } = column;
    let values: Vec<_> = match element {
        Some(k) => {
            let start = |k| v.start_of(k).unwrap_or("0").to_owned();
            let all = || (0..v.size()).map(start).collect();
            let all = arrays.entry(v.reference).or_insert_with(all);
            cell.clone_into(&mut all[*k]);
            all.clone()
        }
        None if v.access() == Access::String => vec![cell.to_owned()],
        None => cell.split_whitespace().map(str::to_owned).collect(),
    };
    let n = v.size();
    ensure!(
        values.len() == n,
        "`{name}` has {n} elements; it cannot be `{cell}`"
    );
    let status = instance.set_values(v, &values);
    instance.must(&format!("setting `{name}` = {cell}"), status)
}

/// Sets the inputs of a time, s: continuous ones on the line between two rows, others as the last
/// row says.
fn set_inputs(
    instance: &Instance,
    arrays: &mut Arrays,
    table: &Table,
    columns: &[Column],
    t: f64,
) -> Result<()> {
    let (row, next) = table.at(t);
    for (k, column) in columns.iter().enumerate() {
        let number = |cell: &String| cell.trim().parse::<f64>();
        let is_continuous = column.v.variability == Variability::Continuous;
        let line = next.filter(|_| is_continuous).and_then(|(next, part)| {
            let (a, b) = (number(&row[k]).ok()?, number(&next[k]).ok()?);
            Some((a + part * (b - a)).to_string())
        });
        set(instance, arrays, column, line.as_ref().unwrap_or(&row[k]))?;
    }
    Ok(())
}
