//! A grid of runs, control laws × cases × trajectories, on all cores, for most analyses of several
//! runs and the report. Each cell holds what was measured, or the error, and the verdict on its
//! run; functions count failed cells and bad verdicts and take the median and the worst.

use anyhow::{Error, Result};
use cosim::exchange::faults::Faults;
use cosim::master::Jitter;
use cosim::run::interrupt;
use cosim::{Experiment, Setting, System, Verdict};
use rayon::prelude::*;
use serde::Serialize;
use tip_path::SIX_JOINTS;

use crate::measures::run::FailedRun;
use crate::setup::start_values::{Law, add_settings, refuse_bound, trajectory_settings};

/// The controller's two trajectories of the paper.
pub const TRAJECTORIES: [&str; 2] = ["cubic", "triangular"];
/// The same with the path that moves all six joints.
pub const ALL_TRAJECTORIES: [&str; 3] = ["cubic", "triangular", SIX_JOINTS];

/// What differs from a nominal run: one row of a table.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in the tables.
    pub label: String,
    /// Start values.
    pub settings: Vec<Setting>,
    /// Noise on inputs.
    pub noise: Faults,
    /// Factor on the communication step.
    pub step: f64,
    /// How communication points deviate from their grid, if they do.
    pub jitter: Option<Jitter>,
    /// Seed that the case was drawn from, if it was.
    pub seed: Option<u64>,
}

impl Case {
    /// `base` in this case, without its noise, and with `more` start values; they may replace what
    /// the system binds. Fails if one of them is set in `base`.
    pub fn apply(&self, base: (&System, &Experiment), more: &[Setting]) -> Result<Experiment> {
        let (system, base) = base;
        let mut experiment = add_settings(system, base, [&self.settings, more].concat())?;
        experiment.stepping.step *= self.step;
        experiment.stepping.jitter = self.jitter;
        Ok(experiment)
    }

    /// A case with these start values.
    pub fn new(label: impl Into<String>, settings: Vec<Setting>) -> Self {
        Self {
            label: label.into(),
            settings,
            noise: Faults::default(),
            step: 1.0,
            jitter: None,
            seed: None,
        }
    }

    /// A case with start values that were drawn from a seed.
    pub fn from_seed(seed: u64, settings: Vec<Setting>) -> Self {
        Self {
            seed: Some(seed),
            ..Self::new(format!("seed {seed}"), settings)
        }
    }
}

/// One run of a grid.
pub struct Cell<T> {
    /// Trajectory.
    pub trajectory: &'static str,
    /// Name of the law.
    pub law: String,
    /// Name of the case.
    pub case: String,
    /// What was measured, or why the run failed.
    pub result: Result<T>,
    /// Limits and ratings that were exceeded, findings of the master, and the failure.
    pub verdict: Verdict,
}

/// The runs of an analysis.
pub struct Grid<'a> {
    system: &'a System,
    base: &'a Experiment,
    laws: &'a [Law],
    cases: &'a [Case],
    trajectories: &'a [&'static str],
    replaces_bound: bool,
}

/// A run of a grid before it is executed.
pub struct Plan<'a> {
    /// Trajectory.
    pub trajectory: &'static str,
    /// Name of the law.
    pub law: &'a str,
    /// Name of the case.
    pub case: &'a str,
    /// Start values, step, noise.
    pub experiment: Experiment,
}

impl<'a> Grid<'a> {
    /// Laws × cases on both trajectories of the paper; `base` is common to all runs.
    pub fn new(
        system: &'a System,
        base: &'a Experiment,
        laws: &'a [Law],
        cases: &'a [Case],
    ) -> Self {
        Self {
            system,
            base,
            laws,
            cases,
            trajectories: &TRAJECTORIES,
            replaces_bound: false,
        }
    }

    /// The grid on these trajectories instead.
    pub fn with_trajectories(mut self, trajectories: &'a [&'static str]) -> Self {
        self.trajectories = trajectories;
        self
    }

    /// Lets laws and cases replace what the system binds, such as the gains of a world.
    pub fn replacing_bound(mut self) -> Self {
        self.replaces_bound = true;
        self
    }

    /// Run all cells in parallel; the result is ordered by trajectory, then case, then law.
    /// `measure` executes one run, `done` is called after each. A cell that fails keeps its error
    /// and the others continue. Fails before the first run if something is varied that is set
    /// already, or that the system does not have.
    pub fn run<T: Send>(
        &self,
        measure: impl Fn(&Plan) -> Result<(T, Verdict)> + Sync,
        done: impl Fn() + Sync,
    ) -> Result<Vec<Cell<T>>> {
        let laws = self.laws.iter().map(|law| law.settings(self.system));
        let laws: Vec<_> = laws.collect::<Result<_>>()?;
        let mut plans = Vec::new();
        for trajectory in self.trajectories {
            let motion = trajectory_settings(self.system, trajectory)?;
            for case in self.cases {
                for (law, settings) in self.laws.iter().zip(&laws) {
                    let more = [&settings[..], &motion].concat();
                    if !self.replaces_bound {
                        refuse_bound(self.system, &[&case.settings, &more[..]].concat())?;
                    }
                    let mut experiment = case.apply((self.system, self.base), &more)?;
                    experiment.faults = case.noise.clone();
                    let (law, case) = (&law.name, &case.label);
                    plans.push(Plan {
                        trajectory,
                        law,
                        case,
                        experiment,
                    });
                }
            }
        }
        let one = |plan: Plan| {
            let measured = measure(&plan);
            done();
            let (result, verdict) = match measured {
                Ok((value, verdict)) => (Ok(value), verdict),
                Err(error) => {
                    let mut verdict = FailedRun::limits_before(&error);
                    verdict.object(format!("failed: {error:#}"));
                    (Err(error), verdict)
                }
            };
            Cell {
                trajectory: plan.trajectory,
                law: plan.law.into(),
                case: plan.case.into(),
                result,
                verdict,
            }
        };
        let cells = plans.into_par_iter().map(one).collect();
        interrupt::check()?;
        Ok(cells)
    }
}

impl<T> Cell<T> {
    /// The cell with `make` applied to what was measured.
    pub fn map<U>(self, make: impl FnOnce(T) -> U) -> Cell<U> {
        Cell {
            trajectory: self.trajectory,
            law: self.law,
            case: self.case,
            result: self.result.map(make),
            verdict: self.verdict,
        }
    }

    /// The failure, where it failed.
    pub fn error(&self) -> Option<&Error> {
        self.result.as_ref().err()
    }
}

/// Number of cells that failed.
pub fn count_failed<'a, T: 'a>(cells: impl IntoIterator<Item = &'a Cell<T>>) -> usize {
    cells.into_iter().filter(|c| c.result.is_err()).count()
}

/// A line for each cell that failed; `name` names the cell.
pub fn failure_lines<T>(cells: &[Cell<T>], name: impl Fn(&Cell<T>) -> String) -> String {
    let failed = cells.iter().filter_map(|c| Some((c, c.error()?)));
    failed
        .map(|(c, error)| format!("{}: {error:#}\n", name(c)))
        .collect()
}

/// The bad findings of all cells: each kind once, with their number and the first cell.
pub fn verdict<T>(cells: &[Cell<T>]) -> Verdict {
    // Findings that differ in their numbers only are of one kind.
    let same = |a: &str, b: &str| {
        let words = |text| str::split_whitespace(text).map(|word| word.trim_end_matches(','));
        let is_number = |word: &str| word.parse::<f64>().is_ok();
        let pairs = || words(a).zip(words(b));
        let alike = |(a, b): (&str, &str)| a == b || is_number(a) && is_number(b);
        words(a).count() == words(b).count() && pairs().all(alike)
    };
    let mut kinds: Vec<(&str, usize, String)> = Vec::new();
    for cell in cells {
        for finding in cell.verdict.findings().iter().filter(|f| f.is_bad) {
            let (kind, detail) = finding.text.split_once(": ").unwrap_or((&finding.text, ""));
            match kinds.iter_mut().find(|(known, ..)| same(known, kind)) {
                Some((_, count, _)) => *count += 1,
                None => {
                    let mut names = vec![cell.trajectory, &cell.law, &cell.case];
                    names.retain(|name| !name.is_empty());
                    kinds.push((kind, 1, format!("{}: {detail}", names.join(", "))));
                }
            }
        }
    }
    let mut verdict = Verdict::default();
    for (kind, count, first) in kinds {
        let all = cells.len();
        verdict.object(format!("{kind} in {count} of {all} runs, first in {first}"));
    }
    verdict
}

/// Median and largest value over runs. Callers count a failed run as infinite, the worst.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Median; the mean of the two middle values if the count is even.
    pub median: f64,
    /// Largest.
    pub worst: f64,
}

impl Spread {
    /// The spread of these values; NaN if there are none.
    pub fn from_values(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let n = values.len();
        let value = |k: usize| values.get(k).copied().unwrap_or(f64::NAN);
        Self {
            median: 0.5 * (value(n.saturating_sub(1) / 2) + value(n / 2)),
            worst: value(n.saturating_sub(1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_worst() {
        let odd = Spread::from_values([3.0, 1.0, 2.0]);
        assert_eq!((odd.median, odd.worst), (2.0, 3.0));
        let even = Spread::from_values([4.0, 1.0, 2.0, f64::INFINITY]);
        assert_eq!((even.median, even.worst), (3.0, f64::INFINITY));
        assert!(Spread::from_values([]).median.is_nan());
    }

    #[test]
    fn what_spoils_cells_is_counted_by_its_kind() {
        let cell = |law: &str, findings: &[&str]| {
            let mut verdict = Verdict::default();
            verdict.note("voltage of emla_2: at its limit".into());
            findings.iter().for_each(|f| verdict.object((*f).into()));
            Cell {
                trajectory: "cubic",
                law: law.into(),
                case: String::new(),
                result: Ok(()),
                verdict,
            }
        };
        let good = verdict(&[cell("adaptive", &[])]);
        assert!(!good.is_bad() && good.findings().is_empty());
        let found = verdict(&[
            cell("adaptive", &[]),
            cell("modular", &["force of emla_2: up to 190 kN"]),
            cell("pd", &["force of emla_2: up to 200 kN", "failed: a: burnt"]),
            cell(
                "pd",
                &["force of emla_3: up to 190 kN", "created 2e3 J, 1.5 %: x"],
            ),
            cell("pd", &["created 1 J, 1.2 %: y"]),
        ]);
        let texts: Vec<_> = found.findings().iter().map(|f| &*f.text).collect();
        assert_eq!(
            texts,
            [
                "force of emla_2 in 2 of 5 runs, first in cubic, modular: up to 190 kN",
                "failed in 1 of 5 runs, first in cubic, pd: a: burnt",
                "force of emla_3 in 1 of 5 runs, first in cubic, pd: up to 190 kN",
                "created 2e3 J, 1.5 % in 2 of 5 runs, first in cubic, pd: x",
            ]
        );
        assert!(found.is_bad());
    }
}
