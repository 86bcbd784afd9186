//! The actuator's efficiency map, as `surrogate map` writes it.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::Serialize;

use super::samples::Samples;

/// First line of the file.
const HEADER: &str = "load [N],x_dot [m/s],physics [1],hybrid [1],testbed [1]";

/// Efficiency over a grid of load and rod speed.
#[derive(Serialize)]
pub struct EfficiencyMap {
    /// N, ascending.
    loads: Vec<f64>,
    /// m/s, ascending.
    speeds: Vec<f64>,
    /// Row by row of load: physics, hybrid, virtual testbed.
    physics: Samples,
    hybrid: Samples,
    testbed: Samples,
}

impl EfficiencyMap {
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("`{}` cannot be read", path.display()))?;
        Self::parse(&text).with_context(|| format!("`{}`", path.display()))
    }

    fn parse(text: &str) -> Result<Self> {
        let mut lines = text.lines();
        ensure!(
            lines.next() == Some(HEADER),
            "it does not begin with `{HEADER}`: not an efficiency map of `surrogate map`"
        );
        let mut rows = Vec::new();
        for line in lines {
            let row: Result<Vec<f64>, _> = line.split(',').map(str::parse).collect();
            let row: Option<[f64; 5]> = row.ok().and_then(|r| r.try_into().ok());
            rows.push(row.with_context(|| format!("`{line}` is not five numbers"))?);
        }
        let axis = |k: usize| {
            let mut values: Vec<f64> = rows.iter().map(|row| row[k]).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values
        };
        let (loads, speeds) = (axis(0), axis(1));
        let expected = loads
            .iter()
            .flat_map(|l| speeds.iter().map(move |s| [*l, *s]));
        ensure!(
            rows.iter().map(|row| [row[0], row[1]]).eq(expected),
            "its rows are not a grid, load by load"
        );
        let column = |k: usize| Samples::new(rows.iter().map(|row| row[k]));
        Ok(Self {
            physics: column(2),
            hybrid: column(3),
            testbed: column(4),
            loads,
            speeds,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_a_full_grid() {
        let text = format!("{HEADER}\n1,0.1,0,0.2,0.3\n1,0.2,0,0.2,0.3\n2,0.1,0,0.2,0.3\n");
        let error = EfficiencyMap::parse(&text)
            .err()
            .expect("a corner is missing");
        assert!(error.to_string().contains("grid"), "{error}");
        let map = EfficiencyMap::parse(&(text + "2,0.2,0.5,0.2,0.3\n")).unwrap();
        assert_eq!((map.loads, map.speeds), (vec![1.0, 2.0], vec![0.1, 0.2]));
        assert_eq!(
            map.physics.values().collect::<Vec<_>>(),
            [0.0, 0.0, 0.0, 0.5]
        );
        assert!(EfficiencyMap::parse("load\n1,2").is_err());
    }
}
