//! Look-up tables from CSV files, for models: a [`Curve`] of one variable, a [`Map`] of two.
//!
//! A file has a column for each variable, the value last. Its first line names the columns with
//! their units; lines that begin with `#` are comments:
//!
//! ```text
//! # measured on the test stand
//! speed [rpm],torque [N.m],efficiency [1]
//! 0,0,0.10
//! 0,50,0.55
//! 1000,0,0.20
//! 1000,50,0.93
//! ```
//!
//! The variables ascend; in a map the second one has the same numbers for each of the first. Beyond
//! the ends of a table the value at the end is used.

mod csv;
mod interpolation;

pub use self::csv::Column;
pub use interpolation::Between;

use self::csv::rows;
use interpolation::interpolate;
use serde::{Deserialize, Serialize};

/// A table y(x).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    x: Vec<f64>,
    y: Vec<f64>,
    between: Between,
}

impl Curve {
    /// Reads the table from the text of a file with the columns x and y.
    ///
    /// # Errors
    /// The text names the line, the variable, its value and what is allowed.
    pub fn read(text: &str, columns: [Column; 2], between: Between) -> Result<Self, String> {
        let [name, _] = columns.map(|column| column.name);
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for (line, [at, value]) in rows(text, columns)? {
            ascends(line, name, x.last(), at)?;
            x.push(at);
            y.push(value);
        }
        has_two(name, x.len())?;
        Ok(Self { x, y, between })
    }

    /// y at x.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        interpolate(&self.x, |i| self.y[i], x, self.between)
    }

    /// The first and last x of the table.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        [self.x[0], self.x[self.x.len() - 1]]
    }
}

/// A table z(x, y).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Map {
    x: Vec<f64>,
    y: Vec<f64>,
    /// For each x, all y.
    z: Vec<f64>,
    between: Between,
}

impl Map {
    /// Reads the table from the text of a file with the columns x, y and z.
    ///
    /// # Errors
    /// The text names the line, the variable, its value and what is allowed.
    pub fn read(text: &str, columns: [Column; 3], between: Between) -> Result<Self, String> {
        let [x_name, y_name, _] = columns.map(|column| column.name);
        let (mut x, mut y, mut z) = (Vec::<f64>::new(), Vec::new(), Vec::new());
        for (line, [x_at, y_at, value]) in rows(text, columns)? {
            if x.last() != Some(&x_at) {
                has_all(line, y_name, y.len(), z.len(), x.len())?;
                ascends(line, x_name, x.last(), x_at)?;
                x.push(x_at);
            }
            let position = z.len() - (x.len() - 1) * y.len();
            match (x.len(), y.get(position)) {
                (1, _) => {
                    ascends(line, y_name, y.last(), y_at)?;
                    y.push(y_at);
                }
                (_, Some(known)) if *known == y_at => {}
                (_, known) => {
                    let known = known.map_or("no more numbers".into(), f64::to_string);
                    return Err(format!(
                        "line {line}: `{y_name}` = {y_at} must be {known}, as it is for the first `{x_name}`"
                    ));
                }
            }
            z.push(value);
        }
        has_two(x_name, x.len())?;
        has_two(y_name, y.len())?;
        has_all(text.lines().count(), y_name, y.len(), z.len(), x.len())?;
        Ok(Self { x, y, z, between })
    }

    /// z at (x, y): interpolated along y at each x of the table, then along x.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let n = self.y.len();
        let row = |i| interpolate(&self.y, |j| self.z[i * n + j], y, self.between);
        interpolate(&self.x, row, x, self.between)
    }

    /// The first and last x and y of the table.
    #[must_use]
    pub fn range(&self) -> [[f64; 2]; 2] {
        [&self.x, &self.y].map(|points| [points[0], points[points.len() - 1]])
    }
}

fn ascends(line: usize, name: &str, last: Option<&f64>, value: f64) -> Result<(), String> {
    match last {
        Some(last) if value <= *last => Err(format!(
            "line {line}: `{name}` = {value} must be greater than {last} before it"
        )),
        _ => Ok(()),
    }
}

fn has_two(name: &str, count: usize) -> Result<(), String> {
    match count {
        0 | 1 => Err(format!("there must be at least two values of `{name}`")),
        _ => Ok(()),
    }
}

/// Checks that the table has `count` values for each of its `rows` values of the first variable.
fn has_all(
    line: usize,
    name: &str,
    count: usize,
    values: usize,
    rows: usize,
) -> Result<(), String> {
    if values == count * rows {
        return Ok(());
    }
    let there = values + count - count * rows;
    Err(format!(
        "line {line}: there must be {count} values of `{name}` before it, not {there}"
    ))
}
