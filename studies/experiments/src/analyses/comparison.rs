//! Compares control laws in a world, for the subcommand `table` and the report: every law runs on
//! every case and trajectory, and of each law the median and the worst run are reported.

use anyhow::Result;
use cosim::{Experiment, System, Verdict};
use serde::Serialize;

use super::met;
use crate::measures::tracking::{Sag, Tracking};
use crate::runs::grid::{self, Case, Cell, Grid, Plan, Spread};
use crate::setup::start_values::Law;
use crate::worlds::BENDING_TARGET;

/// Largest median and worst known RMSE that the adaptive controller may have in the real world, m.
const TARGETS: [f64; 2] = [0.3e-3, 0.7e-3];
/// How many times smaller its median has to be than that of the best rival with integral.
const AHEAD: f64 = 1.5;

/// One run.
pub type TrackingCell = Cell<Tracking>;

/// Runs every law on every case and these trajectories in parallel; the cells come law by law.
/// `done` is called after each run. A failed run keeps its error and the others go on. Fails if the
/// controller does not have a law, or a start value of a case is set already.
pub fn run(
    system: &System,
    base: &Experiment,
    laws: &[Law],
    cases: &[Case],
    trajectories: &[&'static str],
    done: impl Fn() + Sync,
) -> Result<Vec<TrackingCell>> {
    let measure = |plan: &Plan| {
        let (tracking, recorded) = Tracking::record(system, &plan.experiment, &[])?;
        Ok((tracking, recorded.outcome.verdict()))
    };
    let grid = Grid::new(system, base, laws, cases)
        .with_trajectories(trajectories)
        .replacing_bound();
    let mut cells = grid.run(measure, done)?;
    cells.sort_by_key(|cell| laws.iter().position(|law| law.name == cell.law));
    Ok(cells)
}

/// A law over all cases of one trajectory or of all.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Law.
    pub law: String,
    /// RMSE of the known error, m; see [`Tracking`] for this and the other errors.
    pub known: Spread,
    /// Largest known error, m.
    pub known_max: Spread,
    /// RMSE at the true joint angles, m.
    pub joints: Spread,
    /// RMSE of the plant's tip, m.
    pub plant: Spread,
    /// RMSE of the plant's tip without its mean, m.
    pub plant_varying: Spread,
    /// RMS of the orientation's error, rad.
    pub orientation: Spread,
    /// Largest known error over largest speed, s.
    pub rho: Spread,
    /// Largest distance of a bending plant's tip from its place if nothing bent, m.
    pub sag: Option<Spread>,
    /// Largest error against that place, m: dimensions as drawn count in it.
    pub rigid_max: Option<Spread>,
    /// Root mean square of that error without its mean, m.
    pub rigid_varying: Option<Spread>,
    /// Number of runs.
    pub runs: usize,
    /// Number of runs that failed.
    pub failed: usize,
}

impl Summary {
    fn from_cells<'a>(law: &str, cells: impl Iterator<Item = &'a TrackingCell> + Clone) -> Self {
        let spread = |quantity: &dyn Fn(&Tracking) -> f64| {
            let value = |c: &TrackingCell| c.result.as_ref().map_or(f64::INFINITY, quantity);
            Spread::from_values(cells.clone().map(value))
        };
        let mut measured = cells.clone().filter_map(|c| c.result.as_ref().ok());
        let bends = measured.any(|t| t.sag.is_some());
        let bent = |quantity: &dyn Fn(&Sag) -> f64| {
            bends.then(|| spread(&|t| t.sag.as_ref().map_or(f64::INFINITY, quantity)))
        };
        Self {
            law: law.into(),
            known: spread(&|t| t.known.rmse),
            known_max: spread(&|t| t.known.max),
            joints: spread(&|t| t.joints.rmse),
            plant: spread(&|t| t.plant.rmse),
            plant_varying: spread(&|t| t.plant.varying),
            orientation: spread(&|t| t.orientation[0]),
            rho: spread(&Tracking::rho),
            sag: bent(&|b| b.max),
            rigid_max: bent(&|b| b.rigid.max),
            rigid_varying: bent(&|b| b.rigid.varying),
            runs: cells.clone().count(),
            failed: grid::count_failed(cells),
        }
    }
}

/// Each law over the cases of `trajectory`, or of all, in the order of the runs.
pub fn summaries(cells: &[TrackingCell], trajectory: Option<&str>) -> Vec<Summary> {
    let mut laws: Vec<&str> = Vec::new();
    for cell in cells {
        if !laws.contains(&cell.law.as_str()) {
            laws.push(&cell.law);
        }
    }
    let summary = |law: &str| {
        let its = |c: &&TrackingCell| c.law == law && trajectory.is_none_or(|t| t == c.trajectory);
        Summary::from_cells(law, cells.iter().filter(its))
    };
    laws.into_iter().map(summary).collect()
}

/// Compares the law `adaptive` with its targets and with the best of the laws `rivals`; the text is
/// for people. A target that is missed makes the verdict bad.
pub(crate) fn judge(
    cells: &[TrackingCell],
    adaptive: &str,
    rivals: &[&str],
    verdict: &mut Verdict,
) -> String {
    let rows = summaries(cells, None);
    let Some(own) = rows.iter().find(|r| r.law == adaptive) else {
        return String::new();
    };
    let mut check = |what: &str, value: f64, target: f64, is_met: bool| {
        let missed = || format!("{adaptive}: {what} {value:.3}, but the target is {target}");
        met(is_met, verdict, missed)
    };
    let Spread { median, worst } = own.known;
    let errors = [("median", median), ("worst", worst)].into_iter();
    let errors = errors.zip(TARGETS).map(|((name, error), target)| {
        let (mm, target_mm) = (1e3 * error, 1e3 * target);
        let what = format!("{name} known error in mm");
        let met = check(&what, mm, target_mm, error <= target);
        format!("{name} {mm:.3} mm (target {target_mm:.1}: {met})")
    });
    let mut text = format!(
        "{adaptive}, known error over {} runs: {}\n",
        own.runs,
        Vec::from_iter(errors).join(", ")
    );
    let rivals = rows.iter().filter(|r| rivals.contains(&r.law.as_str()));
    if let Some(best) = rivals.min_by(|a, b| a.known.median.total_cmp(&b.known.median)) {
        let ahead = best.known.median / median;
        let what = "times ahead of the best rival";
        text += &format!(
            "best rival with integral: {}, median {:.3} mm, worst {:.3} mm; {adaptive} is ahead by {ahead:.2} times in the median \
             (target {AHEAD}: {})\n",
            best.law,
            1e3 * best.known.median,
            1e3 * best.known.worst,
            check(what, ahead, AHEAD, ahead >= AHEAD)
        );
    }
    text
}

/// Compares the worst case of each law in the bending world with the bound on the distance between
/// the reference and the tip of the controller's own rigid kinematics; the text is for people. A
/// bound that is exceeded makes the verdict bad.
pub(crate) fn judge_bending(cells: &[TrackingCell], verdict: &mut Verdict) -> String {
    let line = |row: &Summary| {
        let [worst, bound] = [row.known_max.worst, BENDING_TARGET].map(|v| 1e3 * v);
        let law = &row.law;
        let met = met(row.known_max.worst <= BENDING_TARGET, verdict, || {
            format!("{law}: {worst:.3} mm from the rigid tip, more than the bound of {bound:.0} mm")
        });
        format!("{law}: at most {worst:.3} mm from the rigid tip (bound {bound:.0} mm: {met})\n")
    };
    summaries(cells, None).iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measures::tracking::PositionError;

    fn cell(law: &str, rmse: f64) -> TrackingCell {
        let known = PositionError {
            rmse,
            max: rmse,
            ..PositionError::default()
        };
        Cell {
            trajectory: "cubic",
            law: law.into(),
            case: "seed 1".into(),
            result: Ok(Tracking {
                known,
                ..Tracking::default()
            }),
            verdict: Verdict::default(),
        }
    }

    #[test]
    fn a_target_that_is_not_met_spoils_the_verdict() {
        let found = |own: f64| {
            let cells = [cell("adaptive", own), cell("pd_integral", 0.5e-3)];
            let mut verdict = Verdict::default();
            let text = judge(&cells, "adaptive", &["pd_integral"], &mut verdict);
            (text, verdict)
        };
        let (text, verdict) = found(0.2e-3);
        assert!(!text.contains("NOT met") && !verdict.is_bad(), "{text}");
        let (text, verdict) = found(0.4e-3);
        let findings = verdict.findings().len();
        assert_eq!(
            (text.matches("NOT met").count(), findings),
            (2, 2),
            "{text}"
        );
        let mut verdict = Verdict::default();
        let text = judge_bending(&[cell("pd", 3e-3), cell("adaptive", 1e-3)], &mut verdict);
        assert!(text.contains("(bound 2 mm: NOT met)") && text.contains("2 mm: met"));
        assert_eq!(verdict.findings().len(), 1, "{verdict}");
    }
}
