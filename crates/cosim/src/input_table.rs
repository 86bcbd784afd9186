//! Inputs from a file: values over time for inputs that no connection drives.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use fmu_description::{Kind, Variability};

use crate::exchange::{Write, writes};
use crate::package::read;
use crate::slave::{At, Slave};
use crate::system::System;
use crate::transformation::{Transformation, along};
use crate::wiring::Port;

/// Columns of values over time, and the inputs that they go to.
pub struct InputTable {
    times: Vec<f64>,
    columns: Vec<Column>,
    writes: Vec<Write>,
    /// Present values, a slot for each column.
    values: Vec<f64>,
    buffer: Vec<f64>,
    /// Row that the last time was found in.
    row: usize,
}

struct Column {
    values: Vec<f64>,
    /// Between two rows the value lies between theirs; else that of the row before holds.
    is_linear: bool,
}

impl InputTable {
    /// Read a CSV file for `system`: a line of names, the first of which is `time`, the others
    /// `component.variable` or inputs of the system; then rows of numbers, with increasing times.
    ///
    /// # Errors
    /// File, row and column of what is wrong.
    pub fn load(path: &Path, system: &System) -> Result<Self> {
        let file = path.display();
        let text = String::from_utf8(read(path).context("input file")?);
        let text = text.with_context(|| format!("input file `{file}` is not UTF-8 text"))?;
        Self::parse(&text, system).with_context(|| format!("input file `{file}`"))
    }

    fn parse(text: &str, system: &System) -> Result<Self> {
        let mut lines = (1..)
            .zip(text.lines())
            .filter(|(_, line)| !line.trim().is_empty());
        let (_, header) = lines.next().context("it is empty")?;
        let header = header.trim_start_matches('\u{feff}');
        ensure!(
            header.contains(',') || !header.contains(';'),
            "row 1: columns are separated by `;`; they must be separated by commas"
        );
        let names: Vec<&str> = header
            .split(',')
            .map(|name| name.trim().trim_matches('"'))
            .collect();
        ensure!(
            names[0] == "time",
            "row 1: the first column is `{}`; it must be `time`",
            names[0]
        );
        let mut table = Self::empty(system, &names[1..], "row 1, ")?;
        for (row, line) in lines {
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            ensure!(
                cells.len() == names.len(),
                "row {row} has {} columns; it must have {}",
                cells.len(),
                names.len()
            );
            let number = |k: usize| {
                let number = match cells[k] {
                    "true" => Some(1.0),
                    "false" => Some(0.0),
                    text => text.parse().ok().filter(|x: &f64| x.is_finite()),
                };
                let (name, text) = (names[k], cells[k]);
                number.with_context(|| {
                    format!("row {row}, column `{name}`: `{text}` is not a finite number")
                })
            };
            let time = number(0)?;
            table.add_time(time).with_context(|| format!("row {row}"))?;
            for (k, column) in table.columns.iter_mut().enumerate() {
                column.values.push(number(k + 1)?);
            }
        }
        ensure!(!table.times.is_empty(), "it has no rows of numbers");
        Ok(table)
    }

    /// A table of `columns` with their names, as in a file, and a value at each of the `times`, s.
    ///
    /// # Errors
    /// Column and time of what is wrong.
    pub fn from_columns(
        system: &System,
        times: &[f64],
        columns: Vec<(String, Vec<f64>)>,
    ) -> Result<Self> {
        let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut table = Self::empty(system, &names, "")?;
        ensure!(!times.is_empty(), "it has no rows of numbers");
        times.iter().try_for_each(|time| table.add_time(*time))?;
        for (column, (name, values)) in table.columns.iter_mut().zip(columns) {
            ensure!(
                values.len() == times.len(),
                "column `{name}` has {} values at {} times",
                values.len(),
                times.len()
            );
            if let Some((t, value)) = times.iter().zip(&values).find(|(_, x)| !x.is_finite()) {
                bail!("column `{name}`: at {t} s `{value}` is not a finite number");
            }
            column.values = values;
        }
        Ok(table)
    }

    /// A table without rows for the inputs `names`; `place` begins what is said of a column.
    fn empty(system: &System, names: &[&str], place: &str) -> Result<Self> {
        let wiring = system.wiring()?;
        let mut columns = Vec::new();
        let mut targets: Vec<(Port, Transformation, usize)> = Vec::new();
        for (slot, name) in names.iter().enumerate() {
            ensure!(
                !names[..slot].contains(name),
                "{place}two columns are named `{name}`"
            );
            let place = || format!("{place}column `{name}`");
            let ends = ends(system, name).with_context(place)?;
            for (port, transformation) in &ends {
                if let Some(link) = wiring.driver(*port) {
                    let driver = wiring.name(wiring.links[link].from);
                    bail!("{}: the connection from `{driver}` drives it", place());
                }
                if let Some((.., other)) = targets.iter().find(|(p, ..)| p == port) {
                    let other = names[*other];
                    bail!("{}: the column `{other}` gives this input, too", place());
                }
                targets.push((*port, transformation.clone(), slot));
            }
            let is_linear = ends.iter().all(|(port, _)| {
                let variable = system.variable(*port);
                variable.kind == Kind::Real && variable.variability == Variability::Continuous
            });
            columns.push(Column {
                values: Vec::new(),
                is_linear,
            });
        }
        let targets = targets.into_iter().map(|(port, t, slot)| (port, slot, t));
        let targets: Vec<_> = targets.collect();
        Ok(Self {
            times: Vec::new(),
            values: vec![0.0; columns.len()],
            columns,
            buffer: vec![0.0; targets.len()],
            writes: writes(&wiring, targets.into_iter()),
            row: 0,
        })
    }

    fn add_time(&mut self, time: f64) -> Result<()> {
        ensure!(time.is_finite(), "the time {time} s must be finite");
        if let Some(before) = self.times.last() {
            ensure!(
                time > *before,
                "the time {time} s must be greater than the one before, {before} s"
            );
        }
        self.times.push(time);
        Ok(())
    }

    /// Set the inputs to their values at `t`, s; before the first row and after the last one those
    /// hold.
    pub fn set(&mut self, slaves: &[Slave], t: f64, at: At) -> Result<()> {
        while self.times.get(self.row + 1).is_some_and(|next| *next <= t) {
            self.row += 1;
        }
        let row = self.row;
        let share = match self.times.get(row + 1) {
            Some(next) => ((t - self.times[row]) / (next - self.times[row])).max(0.0),
            None => 0.0,
        };
        for (value, column) in self.values.iter_mut().zip(&self.columns) {
            let here = column.values[row];
            *value = match column.values.get(row + 1) {
                Some(next) if column.is_linear => here + share * (next - here),
                _ => here,
            };
        }
        let (values, buffer) = (&self.values, &mut self.buffer);
        let mut writes = self.writes.iter();
        writes.try_for_each(|write| write.run(slaves, values, buffer, at))
    }
}

/// The inputs that a name stands for, and what becomes of values on their way there.
fn ends(system: &System, name: &str) -> Result<Vec<(Port, Transformation)>> {
    let mut inputs = system.structure.inputs.iter();
    if let Some(input) = inputs.find(|input| input.name == name) {
        let end = |((component, variable), way): &((String, String), Vec<_>)| {
            let port = system.port(&format!("{component}.{variable}"))?;
            let ends = [None, Some(system.variable(port))];
            Ok((port, along(way, input.unit.clone(), ends, &mut None)?))
        };
        return input.ends.iter().map(end).collect();
    }
    let port = system.port(name)?;
    let variable = system.variable(port);
    ensure!(
        variable.is_input() && variable.access().is_number(),
        "`{}` is no input that takes numbers; it is of type {}, {}",
        system.name(port),
        variable.kind.name(),
        format!("{:?}", variable.causality).to_lowercase()
    );
    Ok(vec![(port, Transformation::NONE)])
}
