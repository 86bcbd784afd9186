//! Reads a CSV file of signals over time, as `run --csv` or another importer writes it, with `time`
//! as its first column; for `surrogate loop`, `plot` and `evaluate`.

use std::collections::BTreeMap;
use std::fs;
use std::num::ParseFloatError;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

/// A file of signals over time.
pub struct SignalFile {
    /// Name of each column; the first is `time`.
    pub names: Vec<String>,
    /// Unit of each column; `?` where it is unknown.
    pub units: Vec<String>,
    /// Values of each column; the first is time, s.
    pub columns: Vec<Vec<f64>>,
}

impl SignalFile {
    /// Reads a file, and the units in the file `….units.csv` beside it, if there is one. Fails if it
    /// cannot be read, or is no table of numbers.
    pub fn read(csv: &Path) -> Result<Self> {
        let name = || format!("`{}`", csv.display());
        let bytes = fs::read(csv).with_context(|| {
            let absolute = std::path::absolute(csv).unwrap_or(csv.into());
            format!(
                "{} cannot be read (looked for {})",
                name(),
                absolute.display()
            )
        })?;
        let text = String::from_utf8(bytes);
        let text = text.with_context(|| format!("{} is not UTF-8 text", name()))?;
        let units = fs::read_to_string(csv.with_extension("units.csv")).unwrap_or_default();
        Self::parse(&text, &units).with_context(name)
    }

    fn parse(text: &str, units: &str) -> Result<Self> {
        let mut lines = records(text);
        let names = lines.next().unwrap_or_default();
        ensure!(!names.is_empty(), "it is empty");
        let is_wrong = names[0] != "time" || names.len() == 1;
        ensure!(
            !(is_wrong && names[0].contains(';')),
            "its columns are separated by semicolons (`;`), but they must be separated by commas, with a point in numbers"
        );
        ensure!(
            !is_wrong,
            "its first line must be time and the names of signals, separated by commas"
        );
        let pairs = records(units).filter_map(|cells| <[String; 2]>::try_from(cells).ok());
        let units: BTreeMap<String, String> = pairs.map(|[name, unit]| (name, unit)).collect();
        let unit = |name: &String| units.get(name).map_or("?", String::as_str).to_string();
        let mut columns = vec![Vec::new(); names.len()];
        for (row, line) in (2..).zip(lines) {
            let values: Result<Vec<f64>, _> = line.iter().map(|cell| number(cell)).collect();
            match values {
                Ok(values) if values.len() == names.len() => {
                    let pairs = columns.iter_mut().zip(values);
                    pairs.for_each(|(column, value)| column.push(value));
                }
                _ => {
                    let line = line.join(",");
                    bail!("line {row}: `{line}` must be {} numbers", names.len())
                }
            }
        }
        let units = names.iter().map(unit).collect();
        Ok(Self {
            names,
            units,
            columns,
        })
    }

    /// Times of the rows, s.
    pub fn times(&self) -> &[f64] {
        &self.columns[0]
    }

    /// Values of the signal named `name`.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let k = self.names.iter().position(|n| n == name)?;
        Some(&self.columns[k])
    }
}

/// The cells of each line; quotes are removed, since names may contain commas, `a[1,2]`.
fn records(text: &str) -> impl Iterator<Item = Vec<String>> {
    let mut reader = csv::ReaderBuilder::new();
    let reader = reader.has_headers(false).flexible(true);
    let records = reader.from_reader(text.as_bytes()).into_records();
    // The text is UTF-8 and lines may have any length, so that nothing is left that can fail.
    let records = records.map_while(Result::ok);
    records.map(|record| record.iter().map(String::from).collect())
}

/// A number, or a truth value as 1 or 0.
fn number(cell: &str) -> Result<f64, ParseFloatError> {
    match cell {
        "true" => Ok(1.0),
        "false" => Ok(0.0),
        number => number.parse(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "time,a.x,a.F,b.x\n0,1,2,3\n0.5,4,5,6\n";
    const UNITS: &str = "signal,unit\ntime,s\na.x,m\na.F,N\n";

    #[test]
    fn columns_get_their_units_and_rows_are_whole() {
        let file = SignalFile::parse(TEXT, UNITS).unwrap();
        assert_eq!(file.units, ["s", "m", "N", "?"]);
        let quoted = SignalFile::parse("time,\"a.M[1,2]\"\n0,7\n", "\"a.M[1,2]\",N\n").unwrap();
        assert_eq!((&*quoted.names[1], &*quoted.units[1]), ("a.M[1,2]", "N"));
        let switched = SignalFile::parse("time,a.on\n0,false\n1,true\n", "").unwrap();
        assert_eq!(switched.columns[1], [0.0, 1.0]);
        assert_eq!(file.columns[3], [3.0, 6.0]);
        for (text, expected) in [
            ("x,y\n1,2\n", "first line"),
            ("time\n1\n", "first line"),
            ("time;a.x\n0;1\n", "separated by semicolons (`;`)"),
            ("time,a.x\n0,1\n1\n", "line 3: `1` must be 2 numbers"),
            ("time,a.x\n0,one\n", "line 2: `0,one`"),
        ] {
            let error = SignalFile::parse(text, "").err().expect(text).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
