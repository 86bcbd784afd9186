//! The rows of the report.

use anyhow::{Context, Result};
use serde::Serialize;
use surrogate::judgement::resampling::bootstrap;

use crate::analyses::draws::Counts;
use crate::runs::ended_run::EndedRun;
use crate::runs::grid::Spread;

/// A law in the report.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub law: String,
    pub counts: Counts,
    /// Known error of the runs that were kept, m.
    pub error: Spread,
    /// Error relative to that of the reference law, geometric mean over the runs that both kept, and
    /// the bounds of its 95 % interval; None for the reference, or without such runs.
    pub ratio: Option<[f64; 3]>,
}

/// Rows of the report of laws with their runs: fewest failures first, then by the median; ratios are to
/// `reference`, or to the first law where that did not take part.
pub fn rows(results: &[(&str, Vec<&EndedRun>)], reference: &str) -> Result<Vec<Row>> {
    let (_, reference_runs) = (results.iter())
        .find(|(law, _)| *law == reference)
        .or(results.first())
        .context("no law took part")?;
    let row = |(law, ended): &(&str, Vec<&EndedRun>)| {
        let pairs = ended.iter().zip(reference_runs);
        let logs: Vec<f64> = pairs
            .filter_map(|(own, first)| Some((own.rmse? / first.rmse?).ln()))
            .collect();
        let is_compared = *law != reference && !logs.is_empty();
        Row {
            law: (*law).into(),
            counts: Counts::from_runs(ended.iter().copied()),
            error: Spread::from_values(ended.iter().filter_map(|run| run.rmse)),
            ratio: is_compared.then(|| mean_with_interval(&logs).map(f64::exp)),
        }
    };
    let mut rows: Vec<Row> = results.iter().map(row).collect();
    rows.sort_by(|a, b| {
        let failed = |row: &Row| row.counts.lost + row.counts.stopped;
        (failed(a).cmp(&failed(b))).then(a.error.median.total_cmp(&b.error.median))
    });
    Ok(rows)
}

/// Mean of `values` and its 95 % interval.
fn mean_with_interval(values: &[f64]) -> [f64; 3] {
    let sum = |drawn: &[usize]| drawn.iter().map(|&k| values[k]).sum::<f64>();
    bootstrap(values.len(), |drawn| sum(drawn) / drawn.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::ended_run::Fate;

    /// 100 numbers of variance 1/12: the interval of their mean is ±1.96/√1200 = ±0.057; the
    /// bootstrap's own error is some 5 % of it.
    #[test]
    fn the_interval_is_that_of_the_mean() {
        let values: Vec<f64> = (0..100).map(|k| f64::from(k) / 99.0).collect();
        let [mean, low, high] = mean_with_interval(&values);
        assert!((mean - 0.5).abs() < 1e-12);
        for side in [mean - low, high - mean] {
            assert!((side / 0.057 - 1.0).abs() < 0.15, "{low} {high}");
        }
    }

    /// Failures count before errors; a law with twice the error of the first on every run has that
    /// ratio, with no width.
    #[test]
    fn failures_come_before_errors() {
        let run = |rmse: Option<f64>| EndedRun {
            fate: if rmse.is_some() {
                Fate::Kept
            } else {
                Fate::Lost
            },
            rmse,
            ..EndedRun::lost(String::new())
        };
        let runs = [
            ("a", [Some(1e-3), Some(2e-3), Some(3e-3)].map(run)),
            ("b", [Some(1e-4), None, Some(1e-4)].map(run)),
            ("c", [Some(2e-3), Some(4e-3), Some(6e-3)].map(run)),
        ];
        let results: Vec<_> = (runs.iter())
            .map(|(law, runs)| (*law, runs.iter().collect()))
            .collect();
        let rows = rows(&results, "a").expect("laws");
        let order: Vec<_> = rows.iter().map(|row| row.law.as_str()).collect();
        assert_eq!(order, ["a", "c", "b"]);
        assert_eq!(rows[0].ratio, None);
        for bound in rows[1].ratio.expect("pairs") {
            assert!((bound - 2.0).abs() < 1e-12, "{bound}");
        }
    }
}
