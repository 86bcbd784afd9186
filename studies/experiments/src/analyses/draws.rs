//! Many machines drawn at random under one law: how many are kept, stopped and lost, and how large
//! the rods' forces become.

use anyhow::Result;
use cosim::{Experiment, System, Verdict};
use rayon::prelude::*;
use serde::Serialize;

use crate::runs::ended_run::{EndedRun, Fate};
use crate::runs::grid::Case;
use crate::runs::run_store::RunStore;
use crate::setup::start_values::{Law, trajectory_settings};

/// What rods may have at most, over their rated force or the controller's limit of it.
pub const FORCE: f64 = 1.2;

/// A drawn machine and what became of it.
#[derive(Clone, Debug, Serialize)]
pub struct Draw {
    /// Name of the case.
    pub case: String,
    /// What became of it.
    #[serde(flatten)]
    pub run: EndedRun,
}

/// How many ended how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Counts {
    /// The tip followed to the end.
    pub kept: usize,
    /// The controller stopped the machine.
    pub stopped: usize,
    /// The machine swung, was far off, or failed.
    pub lost: usize,
    /// A rod had more than [`FORCE`] times what it may be asked for.
    pub forced: usize,
}

impl Counts {
    /// Of these runs.
    pub fn of<'a>(runs: impl IntoIterator<Item = &'a EndedRun>) -> Self {
        let mut counts = Self::default();
        for run in runs {
            match run.fate {
                Fate::Kept => counts.kept += 1,
                Fate::Stopped => counts.stopped += 1,
                Fate::Lost => counts.lost += 1,
            }
            counts.forced += usize::from(run.force > FORCE);
        }
        counts
    }
}

/// Run `law` on every case on all cores, each kept in `store`; `done` is called after each.
///
/// # Errors
/// A law or a case that the system does not have, or a store that cannot be written.
pub fn run(
    (system, base): (&System, &Experiment),
    law: &Law,
    cases: &[Case],
    trajectory: &str,
    store: &RunStore,
    done: impl Fn() + Sync,
) -> Result<Vec<Draw>> {
    let common = [
        law.settings(system)?,
        trajectory_settings(system, trajectory)?,
    ]
    .concat();
    let one = |case: &Case| {
        let experiment = case.apply((system, base), &common)?;
        let name = format!("{} {trajectory} {}", law.name, case.label);
        let run = store.run(&name, system, &experiment)?;
        done();
        Ok(Draw {
            case: case.label.clone(),
            run,
        })
    };
    cases.into_par_iter().map(one).collect()
}

/// A run that was lost, and a force beyond what rods may be given, spoil the verdict.
pub fn judge(draws: &[Draw], verdict: &mut Verdict) {
    let all = draws.len();
    let counts = Counts::of(draws.iter().map(|draw| &draw.run));
    let mut object = |count: usize, what: &str, first: &dyn Fn(&EndedRun) -> bool| {
        if let Some(draw) = draws.iter().find(|draw| first(&draw.run)) {
            verdict.object(format!(
                "{count} of {all} machines {what}, first {} {}",
                draw.case, draw.run.why
            ));
        }
    };
    object(counts.lost, "are lost", &|t| t.fate == Fate::Lost);
    let text = format!("have rods with more than {FORCE} x the largest force asked for");
    object(counts.forced, &text, &|t| t.force > FORCE);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fates_and_forces_are_counted_apart() {
        let draw = |fate, force| Draw {
            case: format!("{force}"),
            run: EndedRun {
                fate,
                why: String::new(),
                rmse: None,
                force,
                load: 0.0,
                swing: 0.0,
                time: 1.0,
            },
        };
        let draws = [
            draw(Fate::Kept, 0.9),
            draw(Fate::Kept, 1.3),
            draw(Fate::Stopped, 1.1),
            draw(Fate::Lost, 3.0),
        ];
        let counts = Counts::of(draws.iter().map(|d| &d.run));
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
