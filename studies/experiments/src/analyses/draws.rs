//! Many machines drawn at random and run under one law, for the subcommand `draws`: how many runs
//! are kept, stopped and lost (the tournament counts so too), and how large the rod forces become.

use anyhow::Result;
use cosim::{Experiment, System, Verdict};
use rayon::prelude::*;
use serde::Serialize;

use crate::runs::ended_run::{EndedRun, Fate};
use crate::runs::grid::{Case, Spread};
use crate::runs::run_store::RunStore;
use crate::setup::start_values::{Law, trajectory_settings};

/// Largest acceptable rod force, over its rated force or the controller's limit of it.
pub const FORCE_BOUND: f64 = 1.2;

/// The run of a drawn machine.
#[derive(Clone, Debug, Serialize)]
pub struct DrawnRun {
    /// Label of the machine's case.
    pub case: String,
    #[serde(flatten)]
    pub run: EndedRun,
}

/// Number of runs by outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Counts {
    pub kept: usize,
    pub stopped: usize,
    pub lost: usize,
    /// Runs in which a rod force exceeded [`FORCE_BOUND`], whatever their outcome.
    pub forced: usize,
}

impl Counts {
    pub fn from_runs<'a>(runs: impl IntoIterator<Item = &'a EndedRun>) -> Self {
        let mut counts = Self::default();
        for run in runs {
            match run.fate {
                Fate::Kept => counts.kept += 1,
                Fate::Stopped => counts.stopped += 1,
                Fate::Lost => counts.lost += 1,
            }
            counts.forced += usize::from(run.force > FORCE_BOUND);
        }
        counts
    }
}

/// Runs `law` on every case in parallel and keeps each run in `store`; `done` is called after each.
pub fn run(
    (system, base): (&System, &Experiment),
    law: &Law,
    cases: &[Case],
    trajectory: &str,
    store: &RunStore,
    done: impl Fn() + Sync,
) -> Result<Vec<DrawnRun>> {
    let mut common = law.settings(system)?;
    common.extend(trajectory_settings(system, trajectory)?);
    let one = |case: &Case| {
        let experiment = case.apply((system, base), &common)?;
        let name = format!("{} {trajectory} {}", law.name, case.label);
        let run = store.run(&name, system, &experiment)?;
        done();
        let case = case.label.clone();
        Ok(DrawnRun { case, run })
    };
    cases.into_par_iter().map(one).collect()
}

/// Medians of the known error of each lap, m, and the last one's over the first one's of all runs that
/// were kept; None of a path without several laps.
pub fn laps(draws: &[DrawnRun]) -> Option<(Vec<f64>, Spread)> {
    let laps: Vec<&[f64]> = draws.iter().map(|draw| &draw.run.laps[..]).collect();
    let count = laps
        .iter()
        .map(|laps| laps.len())
        .max()
        .filter(|n| *n > 1)?;
    let of_lap = |k: usize| laps.iter().filter_map(move |laps| laps.get(k).copied());
    let medians = (0..count).map(|k| Spread::from_values(of_lap(k)).median);
    let ratios = of_lap(count - 1)
        .zip(of_lap(0))
        .map(|(last, first)| last / first);
    Some((medians.collect(), Spread::from_values(ratios)))
}

/// Makes the verdict bad where runs are lost or a rod force exceeds [`FORCE_BOUND`].
pub fn judge(draws: &[DrawnRun], verdict: &mut Verdict) {
    let all = draws.len();
    let counts = Counts::from_runs(draws.iter().map(|draw| &draw.run));
    let mut object = |count: usize, what: &str, is_affected: &dyn Fn(&EndedRun) -> bool| {
        if let Some(draw) = draws.iter().find(|draw| is_affected(&draw.run)) {
            verdict.object(format!(
                "{count} of {all} machines {what}, first {} {}",
                draw.case, draw.run.why
            ));
        }
    };
    object(counts.lost, "are lost", &|run| run.fate == Fate::Lost);
    let text = format!("have rods with more than {FORCE_BOUND} x the largest force asked for");
    object(counts.forced, &text, &|run| run.force > FORCE_BOUND);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of runs that were not kept there are no laps.
    #[test]
    fn laps_are_compared_with_the_first() {
        let draw = |laps: &[f64]| DrawnRun {
            case: String::new(),
            run: EndedRun {
                laps: laps.to_vec(),
                ..EndedRun::default()
            },
        };
        let draws = [draw(&[4.0, 3.0, 1.0]), draw(&[]), draw(&[2.0, 1.0, 3.0])];
        let (medians, ratios) = laps(&draws).expect("laps");
        assert_eq!(medians, [3.0, 2.0, 2.0]);
        assert_eq!((ratios.median, ratios.worst), (0.875, 1.5));
        assert!(laps(&[draw(&[1.0])]).is_none());
    }

    #[test]
    fn fates_and_forces_are_counted_apart() {
        let draw = |fate, force| DrawnRun {
            case: format!("{force}"),
            run: EndedRun {
                fate,
                force,
                ..EndedRun::default()
            },
        };
        let draws = [
            draw(Fate::Kept, 0.9),
            draw(Fate::Kept, 1.3),
            draw(Fate::Stopped, 1.1),
            draw(Fate::Lost, 3.0),
        ];
        let counts = Counts::from_runs(draws.iter().map(|d| &d.run));
        let expected = Counts {
            kept: 2,
            stopped: 1,
            lost: 1,
            forced: 2,
        };
        assert_eq!(counts, expected);
        let mut verdict = Verdict::default();
        judge(&draws, &mut verdict);
        let texts: Vec<_> = verdict.findings().iter().map(|f| &*f.text).collect();
        assert!(
            texts[0].contains("1 of 4 machines are lost, first 3"),
            "{texts:?}"
        );
        assert!(texts[1].contains("2 of 4 machines") && texts[1].contains("first 1.3"));
        let mut good = Verdict::default();
        judge(&draws[..1], &mut good);
        assert!(!good.is_bad());
    }
}
