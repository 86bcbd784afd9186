//! Reads path files in CSV, for `reading`: a header with the names of the columns, then a row for
//! each point; lines that begin with `#` are comments.

use crate::error::{PathError, refused, unknown};
use crate::file::{Load, MotionLimits, PathFile, Points, Sample, Waypoint};
use crate::quaternion::unit;
use csv::{ReaderBuilder, StringRecord, Trim};

const POSITION: [&str; 3] = ["x", "y", "z"];
const ORIENTATION: [&str; 4] = ["qw", "qx", "qy", "qz"];
const COM: [&str; 3] = ["com_x", "com_y", "com_z"];
/// Further columns of a path of waypoints.
const AT_WAYPOINT: [&str; 6] = ["dwell", "speed", "time", "blend", "load_mass", "load_over"];

/// Reads a path without checking its values. With a column `t` the points are samples.
pub(crate) fn parse(text: &str) -> Result<PathFile, PathError> {
    let format = |e: csv::Error| PathError::Format(format!("path CSV: {e}"));
    let mut reader = ReaderBuilder::new()
        .trim(Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    let header = reader.headers().map_err(format)?.clone();
    let is_sampled = header.iter().any(|name| name == "t");
    let known = match is_sampled {
        true => [&["t"], &POSITION[..], &ORIENTATION].concat(),
        false => [&POSITION[..], &ORIENTATION, &AT_WAYPOINT, &COM].concat(),
    };
    for (k, name) in header.iter().enumerate() {
        if name.contains(';') {
            return Err(PathError::Format(
                "path CSV: its columns are separated by semicolons (`;`), but they must be separated by commas, with a point in numbers"
                    .into(),
            ));
        }
        if !known.contains(&name) {
            let known = known.into_iter().map(str::to_owned).collect();
            return Err(unknown("the header", name, known));
        }
        if header.iter().take(k).any(|other| other == name) {
            return Err(PathError::Format(format!(
                "path CSV: the column `{name}` appears twice"
            )));
        }
    }
    let is_missing = |name: &&str| !header.iter().any(|column| column == *name);
    if let Some(missing) = POSITION.into_iter().find(is_missing) {
        let text =
            format!("path CSV: the header must have columns x, y and z; `{missing}` is missing");
        return Err(PathError::Format(text));
    }
    let rows = reader
        .records()
        .collect::<Result<Vec<_>, _>>()
        .map_err(format)?;
    let points = if is_sampled {
        Points::Samples(each(&header, rows, "sample", Row::sample)?)
    } else {
        Points::Waypoints(each(&header, rows, "waypoint", Row::waypoint)?)
    };
    Ok(PathFile {
        points,
        relative: false,
        limits: MotionLimits::DEFAULT,
        laps: None,
        test: None,
    })
}

fn each<'a, T>(
    header: &'a StringRecord,
    rows: Vec<StringRecord>,
    what: &str,
    read: impl Fn(&Row<'a>) -> Result<T, PathError>,
) -> Result<Vec<T>, PathError> {
    let numbered = (1..).zip(rows);
    let row = |(k, cells): (usize, _)| Row {
        place: format!("{what} {k}"),
        header,
        cells,
    };
    numbered.map(row).map(|row| read(&row)).collect()
}

struct Row<'a> {
    place: String,
    header: &'a StringRecord,
    cells: StringRecord,
}

impl Row<'_> {
    /// The number in a column; None if the column is missing or the cell is empty.
    fn number(&self, name: &str) -> Result<Option<f64>, PathError> {
        let column = self.header.iter().position(|column| column == name);
        let cell = column
            .and_then(|k| self.cells.get(k))
            .filter(|cell| !cell.is_empty());
        let parse = |cell: &str| {
            let number = cell.parse::<f64>();
            number.map_err(|_| refused(&self.place, name, cell, "a number"))
        };
        cell.map(parse).transpose()
    }

    fn given(&self, name: &str) -> Result<f64, PathError> {
        let number = self.number(name)?;
        number.ok_or_else(|| refused(&self.place, name, "left out", "given"))
    }

    /// The numbers of several columns, which are given all or none.
    fn numbers<const N: usize>(&self, names: [&str; N]) -> Result<Option<[f64; N]>, PathError> {
        let mut numbers = [0.0; N];
        let mut given = 0;
        for (name, number) in names.iter().zip(&mut numbers) {
            if let Some(value) = self.number(name)? {
                (*number, given) = (value, given + 1);
            }
        }
        match given {
            0 => Ok(None),
            _ if given == N => Ok(Some(numbers)),
            _ => {
                let (all, rule) = (names.join(", "), "given all or left out");
                Err(refused(&self.place, &all, "given in part", rule))
            }
        }
    }

    fn position(&self) -> Result<[f64; 3], PathError> {
        Ok([self.given("x")?, self.given("y")?, self.given("z")?])
    }

    fn waypoint(&self) -> Result<Waypoint, PathError> {
        let q = self.numbers(ORIENTATION)?;
        let com = self.numbers(COM)?;
        let load = self.number("load_mass")?.map(|mass| Load {
            mass,
            com: com.unwrap_or_default(),
        });
        if load.is_none() && com.is_some() {
            let rule = "given with com_x, com_y, com_z";
            return Err(refused(&self.place, "load_mass", "left out", rule));
        }
        Ok(Waypoint {
            position: self.position()?.into(),
            orientation: q.map(|q| unit(&self.place, q)).transpose()?,
            dwell: self.number("dwell")?.unwrap_or(0.0),
            speed: self.number("speed")?,
            time: self.number("time")?,
            blend: self.number("blend")?.unwrap_or(0.0),
            load,
            over: self.number("load_over")?.unwrap_or(0.0),
        })
    }

    fn sample(&self) -> Result<Sample, PathError> {
        let q = self.numbers(ORIENTATION)?;
        Ok(Sample {
            t: self.given("t")?,
            position: self.position()?.into(),
            orientation: q.map(|q| unit(&self.place, q)).transpose()?,
        })
    }
}
