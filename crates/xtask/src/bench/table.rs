//! The table of measurements: medians over the rounds, and ratios of others' costs to ours.

use std::fs;
use std::process::Command;

use cargo_fmu::process::output;
use serde::Deserialize;

use super::inputs::{TABLE_ON_ALL_CORES, TABLE_ON_ONE_CORE};

/// A row and those it is compared with, by the beginnings of their names; the ratio is theirs over
/// its own.
const COMPARISONS: [(&str, &str); 8] = [
    ("forward dynamics", "Pinocchio"),
    ("forward dynamics", "MuJoCo"),
    ("manipulator step of 1 ms (RK4)", "MuJoCo"),
    (
        "set of 4 + step + get of 4, Rust",
        "set of 4 + step + get of 4, C",
    ),
    (
        "MuJoCo step of 1 ms, RK4",
        "coupled step of 1 ms, cosim, no recording",
    ),
    ("coupled step of 1 ms, cosim,", "coupled step of 1 ms, FMPy"),
    (
        "coupled step of 1 ms, cosim,",
        "coupled step of 1 ms, cosim with CSV",
    ),
    (TABLE_ON_ALL_CORES, TABLE_ON_ONE_CORE),
];

/// What a program has measured, in a line of JSON.
#[derive(Debug, Deserialize, PartialEq)]
pub struct Measurement {
    /// What was measured.
    pub name: String,
    /// Unit of both numbers.
    pub unit: String,
    /// Median.
    pub median: f64,
    /// Least value.
    pub least: f64,
}

/// Values of one row, from all rounds.
#[derive(Default)]
pub struct Row {
    name: String,
    unit: String,
    medians: Vec<f64>,
    least: f64,
}

/// Add a measurement to the row of its name.
pub fn note(rows: &mut Vec<Row>, measured: Measurement) {
    let Measurement {
        name,
        unit,
        median,
        least,
    } = measured;
    let known = rows.iter().position(|row| row.name == name);
    let at = known.unwrap_or_else(|| {
        rows.push(Row {
            name,
            unit,
            medians: Vec::new(),
            least,
        });
        rows.len() - 1
    });
    let row = &mut rows[at];
    row.medians.push(median);
    row.least = row.least.min(least);
}

impl Row {
    fn median(&self) -> f64 {
        let mut sorted = self.medians.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    }
}

/// The table as text, with the machine it is from.
pub fn table(rows: &[Row]) -> String {
    let mut lines = vec![
        machine(),
        format!(
            "| {:<72} | {:>12} | {:>12} | unit |",
            "measurement", "median", "least"
        ),
        format!("|:{:-<72}-|-{:->12}:|-{:->12}:|:-----|", "", "", ""),
    ];
    for row in rows {
        let (name, unit) = (&row.name, &row.unit);
        lines.push(format!(
            "| {name:<72} | {:>12.1} | {:>12.1} | {unit:<4} |",
            row.median(),
            row.least
        ));
    }
    lines.push(String::new());
    for (base, others) in COMPARISONS {
        let Some(base) = rows.iter().find(|row| row.name.starts_with(base)) else {
            continue;
        };
        for other in rows.iter().filter(|row| row.name.starts_with(others)) {
            let (median, least) = (other.median() / base.median(), other.least / base.least);
            lines.push(format!(
                "- {} / {}: {median:.2} (least: {least:.2})",
                other.name, base.name
            ));
        }
    }
    for row in rows.iter().filter(|row| row.name.contains(", cosim")) {
        let (median, best) = (1e6 / row.median(), 1e6 / row.least);
        lines.push(format!(
            "- {}: {median:.0} x real time (best: {best:.0})",
            row.name
        ));
    }
    lines.join("\n") + "\n"
}

/// Processor, load and compiler of this run.
fn machine() -> String {
    let first = |file: &str, key: &str| {
        let text = fs::read_to_string(file).unwrap_or_default();
        let line = text.lines().find(|line| line.starts_with(key));
        line.map(|l| l.rsplit(": ").next().unwrap_or(l).to_string())
    };
    let processor = first("/proc/cpuinfo", "model name").unwrap_or_else(|| "unknown".to_string());
    let load = first("/proc/loadavg", "").unwrap_or_default();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let rustc = output(Command::new("rustc").arg("--version")).unwrap_or_default();
    let (os, arch) = (std::env::consts::OS, std::env::consts::ARCH);
    format!(
        "{processor}, {cores} cores, {os} {arch}, load average at the end: {load}; {}\n",
        rustc.trim()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_holds_medians_and_ratios() {
        let mut rows = Vec::new();
        for (ours, theirs) in [(3.0, 30.0), (1.0, 10.0), (2.0, 40.0)] {
            for (name, median) in [("forward dynamics", ours), ("Pinocchio tree", theirs)] {
                let (name, unit) = (name.to_string(), "ns".to_string());
                let least = median;
                note(
                    &mut rows,
                    Measurement {
                        name,
                        unit,
                        median,
                        least,
                    },
                );
            }
        }
        let text = table(&rows);
        assert!(
            text.contains("Pinocchio tree / forward dynamics: 15.00 (least: 10.00)"),
            "{text}"
        );
    }
}
