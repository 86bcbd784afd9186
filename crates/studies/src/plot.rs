//! A picture of a recorded run: the signals of a CSV file over time, those of one unit in one panel.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use cosim::package::read;
use cosim::signals::matches_pattern;

use crate::report::chart::{Curve, Figure, Panel, wheel};

/// Points of a curve that are drawn at most.
const POINTS: usize = 4000;

/// A file of signals over time.
struct Table {
    names: Vec<String>,
    /// Unit of each column; `?` where nobody says it.
    units: Vec<String>,
    /// Column by column, the first is time.
    columns: Vec<Vec<f64>>,
}

/// Draw the signals of `csv` that match one of `patterns` (all without any) as PNG and SVG into `folder`; the files' names.
pub fn draw(csv: &Path, patterns: &[String], folder: &Path) -> Result<[PathBuf; 2]> {
    let table = Table::read(csv)?;
    let is_chosen = |name: &str| patterns.iter().any(|p| matches_pattern(p, name));
    let mut panels: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (k, name) in table.names.iter().enumerate().skip(1) {
        if patterns.is_empty() || is_chosen(name) {
            panels.entry(&table.units[k]).or_default().push(k);
        }
    }
    ensure!(
        !panels.is_empty(),
        "`{}` has no signal that matches {}; it has {}",
        csv.display(),
        patterns.join(", "),
        table.names[1..].join(", ")
    );
    let stem = csv.file_stem().unwrap_or_default().to_string_lossy();
    let figure = Figure {
        name: stem.clone().into_owned(),
        title: stem.into_owned(),
        panels: panels
            .iter()
            .map(|(unit, of)| table.panel(unit, of))
            .collect(),
    };
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    figure.save(folder)
}

impl Table {
    fn read(csv: &Path) -> Result<Self> {
        let text = String::from_utf8(read(csv)?);
        let text = text.with_context(|| format!("`{}` is not UTF-8 text", csv.display()))?;
        let units = read(&csv.with_extension("units.csv")).unwrap_or_default();
        Self::parse(&text, &String::from_utf8_lossy(&units))
            .with_context(|| format!("`{}`", csv.display()))
    }

    fn parse(text: &str, units: &str) -> Result<Self> {
        let mut lines = text.lines();
        let names: Vec<String> = lines
            .next()
            .unwrap_or("")
            .split(',')
            .map(String::from)
            .collect();
        ensure!(
            names[0] == "time" && names.len() > 1,
            "its first line must be time and the names of signals, separated by commas"
        );
        let units: BTreeMap<&str, &str> = units.lines().filter_map(|l| l.split_once(',')).collect();
        let unit = |name: &String| (*units.get(name.as_str()).unwrap_or(&"?")).to_string();
        let mut columns = vec![Vec::new(); names.len()];
        for (row, line) in (2..).zip(lines) {
            let values: Result<Vec<f64>, _> = line.split(',').map(str::parse).collect();
            match values {
                Ok(values) if values.len() == names.len() => {
                    let pairs = columns.iter_mut().zip(values);
                    pairs.for_each(|(column, value)| column.push(value));
                }
                _ => bail!("line {row}: `{line}` must be {} numbers", names.len()),
            }
        }
        let units = names.iter().map(unit).collect();
        Ok(Self {
            names,
            units,
            columns,
        })
    }

    fn panel(&self, unit: &str, of: &[usize]) -> Panel {
        let stride = self.columns[0].len().div_ceil(POINTS).max(1);
        let curve = |(i, k): (usize, &usize)| {
            let points = self.columns[0].iter().zip(&self.columns[*k]);
            let points = points.step_by(stride).map(|(t, v)| (*t, *v)).collect();
            Curve::new(&self.names[*k], wheel(i, of.len()), points)
        };
        Panel::over_time(unit, of.iter().enumerate().map(curve).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "time,a.x,a.F,b.x\n0,1,2,3\n0.5,4,5,6\n";
    const UNITS: &str = "signal,unit\ntime,s\na.x,m\na.F,N\n";

    #[test]
    fn columns_get_their_units_and_rows_are_whole() {
        let table = Table::parse(TEXT, UNITS).unwrap();
        assert_eq!(table.units, ["s", "m", "N", "?"]);
        assert_eq!(table.columns[3], [3.0, 6.0]);
        for (text, expected) in [
            ("x,y\n1,2\n", "first line"),
            ("time\n1\n", "first line"),
            ("time,a.x\n0,1\n1\n", "line 3: `1` must be 2 numbers"),
            ("time,a.x\n0,one\n", "line 2: `0,one`"),
        ] {
            let error = Table::parse(text, "").err().expect(text).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn chosen_signals_are_drawn_beside_the_file() {
        let folder = std::env::temp_dir().join(format!("studies-plot-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let csv = folder.join("run.csv");
        std::fs::write(&csv, TEXT).unwrap();
        let files = draw(&csv, &["a.*".into()], &folder).unwrap();
        let svg = std::fs::read_to_string(&files[1]).unwrap();
        assert!(svg.contains("a.F") && !svg.contains("b.x"));
        assert!(std::fs::metadata(&files[0]).unwrap().len() > 1000);
        let error = draw(&csv, &["c.*".into()], &folder)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("c.*") && error.contains("a.x, a.F, b.x"),
            "{error}"
        );
        std::fs::remove_dir_all(folder).unwrap();
    }
}
