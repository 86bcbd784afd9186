//! Feeds inputs that no connection drives with values over time, from a CSV file (`--input`) or
//! from memory (the Python API).

use std::collections::{HashMap, HashSet};
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail, ensure};
use fmi_description::{Kind, Unit, Variability, Variable};

use crate::exchange::faults::Alteration;
use crate::exchange::{Write, writes};
use crate::instance::{At, Instance};
use crate::io::cells::cells;
use crate::io::numbers::{allowed, fits, number};
use crate::structure::Hop;
use crate::structure::package::read_text;
use crate::structure::system::{Names, System};
use crate::structure::units::{common_unit, defined_units};
use crate::wiring::transformation::{Transformation, compose, conversion, unit_of};
use crate::wiring::{Port, Wiring};
use fmi_import::digits::short;

/// Values over time as a user gives them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Times of the rows, s, increasing; two rows of one time are a jump.
    pub times: Vec<f64>,
    /// Columns.
    pub columns: Vec<Column>,
}

/// Values of one input.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// An input or a tunable parameter, `component.variable`; or an input of the system.
    pub name: String,
    /// Unit of the values; None for the unit of the input.
    pub unit: Option<String>,
    /// A value for each time: of a Boolean 0 or 1, of an enumeration the number of the item.
    pub values: Vec<f64>,
}

impl Table {
    /// Read a CSV file for `system`: a line of names, `time` first, then rows of values. The units
    /// are those of the file `NAME.units.csv` in the same folder, if there is one. `chosen` pairs
    /// inputs with the columns that feed them; if it is empty, each column feeds the input of its
    /// name.
    pub fn load(path: &Path, system: &System, chosen: &[(String, String)]) -> Result<Self> {
        let mut units = Vec::new();
        let units_file = path.with_extension("units.csv");
        if units_file.is_file() {
            let text = read_text(&units_file)?;
            let read = parse_units(&text);
            units = read.with_context(|| format!("units `{}`", units_file.display()))?;
        }
        let text = read_text(path).context("input file")?;
        let table = Self::parse(&text, &units, system, chosen);
        table.with_context(|| format!("input file `{}`", path.display()))
    }

    fn parse(
        text: &str,
        units: &[(String, String)],
        system: &System,
        chosen: &[(String, String)],
    ) -> Result<Self> {
        let mut lines = rows(text);
        let (_, header) = lines.next().context("it is empty")?;
        let header = header.trim_start_matches('\u{feff}');
        ensure!(
            header.contains(',') || !header.contains(';'),
            "row 1: columns are separated by `;`; they must be separated by commas"
        );
        let names = cells(header);
        if let Some(unnamed) = names.iter().position(String::is_empty) {
            bail!(
                "row 1: column {} has no name{}",
                unnamed + 1,
                trailing(&names)
            );
        }
        ensure!(
            names[0] == "time",
            "row 1: the first column is `{}`; it must be `time`",
            names[0]
        );
        let units: HashMap<&String, &String> = units.iter().rev().map(|(s, u)| (s, u)).collect();
        let columns: HashMap<&String, usize> = names.iter().zip(0..).skip(1).collect();
        let all = names[1..].iter().map(|name| (name.clone(), name.clone()));
        let chosen = match chosen.is_empty() {
            true => all.collect(),
            false => by_element(system, chosen, &columns),
        };
        let (mut table, mut places) = (Self::default(), Vec::new());
        for (name, column) in chosen {
            let place = columns.get(&column).with_context(|| {
                let all = names[1..].join(", ");
                format!("row 1: there is no column `{column}` for `{name}`; there are {all}")
            })?;
            places.push(*place);
            table.columns.push(Column {
                name,
                unit: units.get(&column).map(|unit| (*unit).clone()),
                values: Vec::new(),
            });
        }
        let wiring = system.wiring()?;
        let targets = targets(system, &wiring, &table.columns, "row 1, ")?;
        for (row, line) in lines {
            let cells = cells(line);
            ensure!(
                cells.len() == names.len(),
                "row {row} has {} columns; it must have {}{}",
                cells.len(),
                names.len(),
                trailing(&cells)
            );
            let (text, place) = (&cells[0], || format!("row {row}"));
            let time = text.parse().ok().filter(|t: &f64| t.is_finite());
            let unfit = || format!("row {row}, column `time`: `{text}` is not a finite number");
            let time = time.with_context(unfit)?;
            check_order(&table.times, time).with_context(place)?;
            table.times.push(time);
            for ((column, target), place) in table.columns.iter_mut().zip(&targets).zip(&places) {
                let (value, name) = (target.number(&cells[*place]), &names[*place]);
                let value = value.with_context(|| format!("row {row}, column `{name}`"))?;
                column.values.push(value);
            }
        }
        ensure!(!table.times.is_empty(), "it has no rows of numbers");
        Ok(table)
    }
}

/// Pairs of inputs and columns, of arrays whose elements have a column each by element.
fn by_element(
    system: &System,
    chosen: &[(String, String)],
    columns: &HashMap<&String, usize>,
) -> Vec<(String, String)> {
    let each = |(input, column): &(String, String)| {
        let name = |port: &Port| system.name(*port);
        let names = system.ports(input).unwrap_or_default();
        let names: Vec<String> = names.iter().map(name).collect();
        let of = |name: &String| format!("{column}{}", &name[name.rfind('[').unwrap_or(0)..]);
        match names.len() > 1 && names.iter().all(|name| columns.contains_key(&of(name))) {
            true => names.iter().map(|name| (name.clone(), of(name))).collect(),
            false => vec![(input.clone(), column.clone())],
        }
    };
    chosen.iter().flat_map(each).collect()
}

/// A hint for a row that ends in a comma, which begins one more cell.
fn trailing(cells: &[String]) -> &'static str {
    match cells.last().is_some_and(String::is_empty) {
        true => ": it ends in a comma, after which one more column begins",
        false => "",
    }
}

/// The lines that are not empty, with their numbers.
fn rows(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = (1..).zip(text.lines());
    lines.filter(|(_, line)| !line.trim().is_empty())
}

/// Signals and their units, from a file as [`crate::io::csv::Log`] writes it.
fn parse_units(text: &str) -> Result<Vec<(String, String)>> {
    let header = text.lines().next().map(cells);
    ensure!(
        header.is_some_and(|header| header == ["signal", "unit"]),
        "row 1: it must be `signal,unit`"
    );
    let mut units = Vec::new();
    for (row, line) in rows(text).skip(1) {
        let cells = cells(line);
        let [signal, unit] = cells.as_slice() else {
            bail!("row {row} has {} columns; it must have 2", cells.len());
        };
        ensure!(
            signal != "time" || unit == "s",
            "row {row}: the unit of `time` is `{unit}`; it must be `s`"
        );
        units.push((signal.clone(), unit.clone()));
    }
    Ok(units)
}

/// Check that a time is no earlier than the last one, and the third of no jump.
fn check_order(times: &[f64], time: f64) -> Result<()> {
    let last = times.last().copied().unwrap_or(f64::NEG_INFINITY);
    ensure!(
        time >= last,
        "the time {} s must not be less than the one before, {} s",
        short(time),
        short(last)
    );
    ensure!(
        times.len() < 2 || time > times[times.len() - 2],
        "the time {} s stands in three rows: two are a jump, from the value of the first to that of the second",
        short(time)
    );
    Ok(())
}

/// A table that feeds the inputs of a run.
#[derive(Default)]
pub struct InputTable {
    times: Vec<f64>,
    /// Values of each column, and whether they are interpolated linearly between rows; else the
    /// value of the row before holds.
    columns: Vec<(Vec<f64>, bool)>,
    ports: Vec<Port>,
    pub(crate) writes: Vec<Write>,
    /// Present value of each column.
    values: Vec<f64>,
    /// Last row that the time has reached.
    row: usize,
}

impl InputTable {
    /// Check a table and plan how it feeds its inputs.
    pub fn new(system: &System, table: &Table) -> Result<Self> {
        let wiring = system.wiring()?;
        let targets = targets(system, &wiring, &table.columns, "")?;
        ensure!(!table.times.is_empty(), "the input table has no rows");
        for (k, time) in table.times.iter().enumerate() {
            ensure!(time.is_finite(), "the time {time} s must be finite");
            check_order(&table.times[..k], *time)?;
        }
        for (column, target) in table.columns.iter().zip(&targets) {
            ensure!(
                column.values.len() == table.times.len(),
                "column `{}` has {} values at {} times",
                column.name,
                column.values.len(),
                table.times.len()
            );
            for (t, value) in table.times.iter().zip(&column.values) {
                let checked = target.check(*value);
                let (name, t) = (&column.name, short(*t));
                checked.map_err(|unfit| anyhow!("column `{name}`: at {t} s {unfit}"))?;
            }
        }
        let (mut columns, mut inputs) = (Vec::new(), Vec::new());
        for (slot, (column, target)) in table.columns.iter().zip(targets).enumerate() {
            columns.push((column.values.clone(), target.is_linear));
            let ends = target.ends.into_iter();
            inputs.extend(ends.map(|(port, transformation)| (port, slot, transformation)));
        }
        Ok(Self {
            times: table.times.clone(),
            values: vec![0.0; columns.len()],
            columns,
            ports: inputs.iter().map(|(port, ..)| *port).collect(),
            writes: writes(&wiring, inputs.into_iter()),
            row: 0,
        })
    }

    /// The inputs that it feeds.
    pub fn ports(&self) -> &[Port] {
        &self.ports
    }

    /// A table without inputs; `t`, s, may be any time.
    pub(crate) fn empty(t: f64) -> Self {
        Self {
            times: vec![t],
            ..Self::default()
        }
    }

    /// Feed an input with a constant.
    pub(crate) fn hold(&mut self, wiring: &Wiring, port: Port, value: f64) {
        let slot = self.columns.len();
        self.columns.push((vec![value; self.times.len()], false));
        let target = (port, slot, Transformation::NONE);
        self.writes.extend(writes(wiring, std::iter::once(target)));
        self.values.push(value);
        self.ports.push(port);
    }

    /// Allow earlier times again, after a state was restored.
    pub(crate) fn rewind(&mut self) {
        self.row = 0;
    }

    /// Set the inputs to their values at `t`, s. Before the first row and after the last one, the
    /// values of that row hold.
    pub(crate) fn set(
        &mut self,
        instances: &[Instance],
        mut faults: Option<&mut Alteration>,
        t: f64,
    ) -> Result<()> {
        // Rounding may put the time of a step just before the time in the table.
        let reached = t + 4.0 * f64::EPSILON * t.abs();
        let next = |row: usize| self.times.get(row + 1);
        while next(self.row).is_some_and(|next| *next <= reached) {
            self.row += 1;
        }
        let row = self.row;
        let share = match self.times.get(row + 1) {
            Some(next) => ((t - self.times[row]) / (next - self.times[row])).max(0.0),
            None => 0.0,
        };
        for (value, (column, is_linear)) in self.values.iter_mut().zip(&self.columns) {
            let here = column[row];
            *value = match column.get(row + 1) {
                Some(next) if *is_linear => here + share * (next - here),
                _ => here,
            };
        }
        if let Some(faults) = &mut faults {
            faults.begin(t);
        }
        let mut writes = self.writes.iter_mut();
        writes.try_for_each(|write| {
            let faults = faults.as_deref_mut();
            write.run(instances, &self.values, faults, At::Time(t))
        })
    }
}

/// The inputs that a column feeds.
struct Target<'a> {
    /// Inputs, with the transformations of the values.
    ends: Vec<(Port, Transformation)>,
    /// The input whose values the column has; None if they are transformed.
    variable: Option<&'a Variable>,
    is_linear: bool,
}

impl Target<'_> {
    fn number(&self, text: &str) -> Result<f64> {
        if let Some(variable) = self.variable {
            return number(variable, text);
        }
        let number = match text {
            "true" | "True" => Some(1.0),
            "false" | "False" => Some(0.0),
            _ => text.parse().ok().filter(|x: &f64| x.is_finite()),
        };
        number.with_context(|| format!("`{text}` is not a finite number"))
    }

    fn check(&self, value: f64) -> Result<()> {
        let is_fit = self.variable.map_or(value.is_finite(), |v| fits(v, value));
        let needed = self.variable.map_or("a finite number".into(), allowed);
        ensure!(is_fit, "`{value}` is not {needed}");
        Ok(())
    }
}

/// The inputs that each column feeds; `place` begins the messages about a column.
fn targets<'a>(
    system: &'a System,
    wiring: &Wiring,
    columns: &[Column],
    place: &str,
) -> Result<Vec<Target<'a>>> {
    let mut taken: HashMap<Port, &str> = HashMap::new();
    let (mut seen, mut targets) = (HashSet::new(), Vec::new());
    let names = Names::new(system);
    let units = match columns.iter().any(|column| column.unit.is_some()) {
        true => defined_units(system),
        false => HashMap::new(),
    };
    for column in columns {
        let name = column.name.as_str();
        ensure!(seen.insert(name), "{place}two columns are named `{name}`");
        let place = || format!("{place}column `{name}`");
        let ends = ends(&names, &units, column).with_context(place)?;
        for (port, _) in &ends {
            if let Some(driver) = wiring.source(*port) {
                let driver = wiring.name(driver);
                bail!("{}: the connection from `{driver}` drives it", place());
            }
            if let Some(other) = taken.insert(*port, name) {
                bail!("{}: the column `{other}` gives this input, too", place());
            }
        }
        let mut variables = ends.iter().map(|(port, _)| system.variable(*port));
        let is_plain = ends.iter().all(|(_, t)| *t == Transformation::NONE);
        let is_linear =
            |v: &Variable| v.kind == Kind::Real && v.variability == Variability::Continuous;
        targets.push(Target {
            is_linear: variables.clone().all(is_linear),
            variable: variables.next().filter(|_| is_plain),
            ends,
        });
    }
    Ok(targets)
}

/// The inputs that a column feeds, with the transformations of its values.
fn ends(
    names: &Names,
    units: &HashMap<String, Unit>,
    column: &Column,
) -> Result<Vec<(Port, Transformation)>> {
    let (name, system) = (&column.name, names.system);
    let unit = column.unit.as_deref().map(str::trim);
    let unit = unit.filter(|unit| !matches!(*unit, "" | "1"));
    let defined = |name: &str| units.get(name).cloned();
    let unit = unit.map(|name| defined(name).unwrap_or_else(|| common_unit(name)));
    if let Some(input) = names.inputs.get(&**name) {
        let first = match (&unit, &input.unit) {
            (Some(unit), Some(own)) => unit_conversion(unit, own)?,
            _ => Transformation::NONE,
        };
        let unit = input.unit.clone().or(unit);
        let end = |((component, variable), way): &((String, String), Vec<Hop>)| {
            let port = names.port(&format!("{component}.{variable}"))?;
            let ends = [None, Some(system.variable(port))];
            let rest = compose(way, unit.clone(), ends, &mut None)?;
            Ok((port, first.clone().then(rest)))
        };
        return input.ends.iter().map(end).collect();
    }
    let ports = names.ports(name)?.into_iter();
    ports.map(|port| end(system, port, unit.as_ref())).collect()
}

/// An input that a column with this unit feeds, with the transformation of its values.
fn end(system: &System, port: Port, unit: Option<&Unit>) -> Result<(Port, Transformation)> {
    let variable = system.variable(port);
    ensure!(
        (variable.is_input() || variable.is_tunable()) && variable.access().is_number(),
        "`{}` is no input that takes numbers; it is of type {}, {}",
        system.name(port),
        variable.kind.name(),
        format!("{:?}", variable.causality).to_lowercase()
    );
    let own = unit_of(&system.fmus[port.component].description, variable);
    let mut transformation = match (unit, own) {
        (Some(unit), Some(own)) => unit_conversion(unit, &own)?,
        _ => Transformation::NONE,
    };
    // Offsets of units do not apply to differences.
    if let Transformation::Linear(linear) = &mut transformation
        && variable.is_relative
    {
        linear.offset = 0.0;
    }
    Ok((port, transformation))
}

/// The conversion from the unit of a column to that of an input.
fn unit_conversion(unit: &Unit, own: &Unit) -> Result<Transformation> {
    let known = match own.exponents {
        Some(_) => own.clone(),
        None => common_unit(&own.name),
    };
    let linear = conversion(unit, own).or_else(|| conversion(unit, &known));
    linear.map(Transformation::Linear).with_context(|| {
        format!(
            "its unit is `{}`, that of the input is `{}`: it must be the same, or one that is defined with the same base units",
            unit.name, own.name
        )
    })
}
