//! A fair comparison of control laws, for the subcommand `tournament`: the gains of every law are
//! tuned by the same tuner, budget and cost on some drawn machines, and the tuned laws are compared
//! on other machines.
//!
//! The gains of a law are tuned as factors on the shipped values, each from an eighth to eight:
//! first the shipped gains and evenly spread points by successive halving, then points around the
//! best so far. After each half every law also tries the best gains of every other one, so that none
//! is behind for gains that another has found. The cost of gains is the median plus the worst known error over the tuning machines
//! and paths. A run that is not kept makes the cost infinite, and the remaining runs are skipped, as
//! they are once gains are clearly behind the best so far. Gains that would be the best must also do
//! what the shipped ones of their law do of a sample of what is asked of a machine.
//!
//! Few machines do not show what fails one of a hundred. So the gains that were the best one after the
//! other are tried on further machines, and those with the fewest failures are taken.

mod contestants;
mod rows;
mod shipping;

pub use contestants::{CONTESTANTS, Contestant, Model, TUNING_PATHS};
pub use rows::{Row, rows};
pub use shipping::{Asked, Sample};

use anyhow::{Context, Result};
use cosim::{Experiment, Setting, System, start_value};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::Serialize;

use crate::analyses::identification::run::Identified;
use crate::runs::ended_run::{EndedRun, Fate};
use crate::runs::grid::{Case, Spread};
use crate::runs::run_store::RunStore;
use crate::setup::start_values::{Law, trajectory_settings};

type NamedValues = Vec<(String, f64)>;

/// Largest factor on a gain; its inverse is the smallest.
const RANGE: f64 = 8.0;
/// Part of the budget that is spread evenly.
const SPREAD: f64 = 0.5;
/// Standard deviation of a step from the best so far, in parts of the logarithm of [`RANGE`], and
/// the factor by which it shrinks over the rest of the budget.
const STEP: f64 = 0.3;
const SHRINKS: f64 = 0.2;
/// Numbers of machines on which the spread candidates are compared before all machines are used;
/// after each of these rounds one of [`ONE_OF`] candidates goes on.
const ROUNDS: [usize; 2] = [1, 3];
const ONE_OF: usize = 3;
/// A candidate is behind once its cost exceeds that of the best one on the same machines by this
/// factor.
const BEHIND: f64 = 1.2;

/// The machine and what all laws share.
pub struct Tournament<'a> {
    pub system: &'a System,
    pub base: &'a Experiment,
    pub store: &'a RunStore,
    /// Identified machines, for the laws that use them.
    pub identified: Identified,
    /// What gains must do besides being accurate.
    pub sample: Sample,
    /// Machines on which the gains are tuned, and those on which the best ones are tried.
    pub tuning: &'a [Case],
    pub trial: &'a [Case],
}

/// The tuned gains of a law.
#[derive(Debug, Serialize)]
pub struct Tuned {
    pub law: String,
    /// Names and values of the gains that were tuned.
    pub gains: Vec<(String, f64)>,
    /// Median plus worst known error over the tuning runs, m; None where every candidate lost a run.
    pub cost: Option<f64>,
    /// Candidates that lost none of their runs, skipped runs not counted.
    pub kept: usize,
    /// Candidates that were tried.
    pub tried: usize,
    /// What the best ones had to do besides being accurate.
    pub asked: Vec<Asked>,
    /// Number of gains that were the best one after the other, and of those that were tried in the end.
    pub bests: usize,
    pub trials: usize,
    /// Runs of the trial that were stopped or lost.
    pub failures: usize,
    /// Start values of the controller.
    #[serde(skip)]
    pub settings: Vec<Setting>,
}

/// Gains that are tried.
struct Candidate {
    k: u64,
    /// Logarithm of the factor on each group of gains, relative to that of [`RANGE`].
    logs: Vec<f64>,
    /// Known errors of the runs so far, m.
    errors: Vec<f64>,
}

/// A law while it is tuned.
struct Tuning<'a> {
    contestant: &'a Contestant,
    /// What is asked of its best gains, since its shipped ones do it.
    asked: Vec<Asked>,
    /// Those that were the best one after the other.
    bests: Vec<Candidate>,
    /// Candidates so far, and those that lost a run.
    tried: u64,
    lost: usize,
}

impl Tuning<'_> {
    fn best_logs(&self) -> Option<&[f64]> {
        self.bests.last().map(|best| &best.logs[..])
    }
}

/// The best gains of a law, with those that it shares with a rival as that one has them.
fn borrowed(own: &Tuning, (groups, theirs): (&[&[&str]], &[f64])) -> Vec<f64> {
    let gains = own.contestant.gains.iter().enumerate();
    let log = |(k, group): (usize, &&[&str])| {
        let shared = groups.iter().position(|other| other == group);
        let kept = own.best_logs().map_or(0.0, |best| best[k]);
        shared.map_or(kept, |j| theirs[j])
    };
    gains.map(log).collect()
}

impl Tournament<'_> {
    /// The run of a case on a path, from the store where it is there. A law that needs an
    /// identified machine has the nominal one where the identification failed.
    fn kept_run(
        &self,
        name: &str,
        contestant: &Contestant,
        settings: &[Setting],
        case: &Case,
        path: &str,
    ) -> Result<EndedRun> {
        let mut law = settings.to_vec();
        let file = match contestant.model {
            Model::Nominal => None,
            Model::Identified => {
                let identified = self.identified.get(&case.label);
                let found = identified.context("a machine that was not identified")?;
                let file = found.as_ref().map(|found| found.file.display().to_string());
                file.ok()
            }
            Model::True => {
                let plant = self.system.port("hdrm.machine_file")?;
                let drawn = case.settings.iter().find(|setting| setting.port == plant);
                Some(drawn.context("a machine that was not drawn")?.value.clone())
            }
        };
        if let Some(file) = file {
            law.push(self.system.setting("controller.machine_file", file)?);
        }
        law.extend(trajectory_settings(self.system, path)?);
        let experiment = case.apply((self.system, self.base), &law)?;
        let name = format!("{name} {} {path}", case.label);
        self.store.run(&name, self.system, &experiment)
    }

    /// Simulated time of a run of the shipped `contestant` on `case`, s: made to estimate how long
    /// the tournament takes.
    pub fn sample_run(&self, contestant: &Contestant, case: &Case) -> Result<f64> {
        let mut law = self.scaled(contestant, &[])?.1.settings(self.system)?;
        law.extend(trajectory_settings(self.system, TUNING_PATHS[0])?);
        let experiment = case.apply((self.system, self.base), &law)?;
        Ok(EndedRun::run(self.system, &experiment)?.time)
    }

    /// The gains of `contestant` with these logarithms of factors, and its law with them.
    fn scaled(&self, contestant: &Contestant, logs: &[f64]) -> Result<(NamedValues, Law)> {
        let mut law = Law::new(contestant.name, contestant.mode);
        let mut gains = Vec::new();
        for (group, log) in contestant.gains.iter().zip(logs) {
            for gain in *group {
                let port = self.system.port(&format!("controller.{gain}"))?;
                let shipped = start_value(self.system, &self.base.settings, port)?;
                let value = shipped * (log * RANGE.ln()).exp();
                law = law.with(gain, value);
                gains.push(((*gain).into(), value));
            }
        }
        Ok((gains, law))
    }

    /// Whether a law with these gains does what is `asked` for.
    fn ships(&self, contestant: &Contestant, logs: &[f64], asked: &[Asked]) -> Result<bool> {
        let (_, law) = self.scaled(contestant, logs)?;
        for asked in asked {
            let machine = (self.system, self.base);
            if !(self.sample).is_met_by(*asked, machine, &law, self.store)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Runs a candidate on cases and tuning paths: None once a run is not kept. It has the errors so
    /// far once they are behind the errors of `best`.
    fn judge(
        &self,
        contestant: &Contestant,
        mut candidate: Candidate,
        cases: &[Case],
        best: &[f64],
    ) -> Result<Option<Candidate>> {
        let law = self.scaled(contestant, &candidate.logs)?.1;
        let law = law.settings(self.system)?;
        let name = format!("tune {} {}", contestant.name, candidate.k);
        candidate.errors.clear();
        for case in cases {
            let one = |path: &&str| self.kept_run(&name, contestant, &law, case, path);
            let ended: Vec<EndedRun> = TUNING_PATHS.par_iter().map(one).collect::<Result<_>>()?;
            if ended.iter().any(|run| run.fate != Fate::Kept) {
                return Ok(None);
            }
            candidate.errors.extend(ended.iter().map(EndedRun::cost));
            if is_behind(&candidate.errors, best) {
                break;
            }
        }
        Ok(Some(candidate))
    }

    /// Tunes all `contestants` with `budget` candidates each, besides what they try of
    /// each other; `done` is called after each candidate.
    pub fn tune(
        &self,
        contestants: &[&Contestant],
        budget: u64,
        done: impl Fn() + Sync,
    ) -> Result<Vec<Tuned>> {
        let mut field: Vec<Tuning> = (contestants.par_iter())
            .map(|&contestant| self.spread(contestant, budget, &done))
            .collect::<Result<_>>()?;
        self.exchange(&mut field, &done)?;
        field.par_iter_mut().try_for_each(|tuning| {
            for k in spread_count(budget)..budget {
                let groups = tuning.contestant.gains.len();
                let logs = candidate_logs(groups, k, budget, tuning.best_logs());
                self.challenge(tuning, logs)?;
                done();
            }
            anyhow::Ok(())
        })?;
        self.exchange(&mut field, &done)?;
        field.par_iter().map(|tuning| self.tuned(tuning)).collect()
    }

    /// The first half of the budget: candidates that are spread evenly, by successive halving.
    fn spread<'a>(
        &self,
        contestant: &'a Contestant,
        budget: u64,
        done: impl Fn(),
    ) -> Result<Tuning<'a>> {
        let (groups, tried) = (contestant.gains.len(), spread_count(budget));
        let mut asked = Vec::new();
        for one in Asked::ALL {
            if self.ships(contestant, &vec![0.0; groups], &[one])? {
                asked.push(one);
            }
        }
        let new_candidate = |k: u64| Candidate {
            k,
            logs: candidate_logs(groups, k, budget, None),
            errors: Vec::new(),
        };
        let mut lost = 0;
        let mut field: Vec<_> = (0..tried).map(new_candidate).collect();
        let mut wanted = field.len();
        for machines in [ROUNDS[0], ROUNDS[1], self.tuning.len()] {
            let mut ranked = Vec::new();
            for candidate in field {
                let is_new = candidate.errors.is_empty();
                if ranked.len() < wanted {
                    let cases = &self.tuning[..machines.min(self.tuning.len())];
                    let kept = self.judge(contestant, candidate, cases, &[])?;
                    lost += usize::from(kept.is_none());
                    ranked.extend(kept);
                }
                if is_new {
                    done();
                }
            }
            ranked.sort_by(|a, b| cost(&a.errors).total_cmp(&cost(&b.errors)));
            wanted = ranked.len().div_ceil(ONE_OF);
            field = ranked;
        }
        let mut bests = Vec::new();
        for candidate in field {
            if self.ships(contestant, &candidate.logs, &asked)? {
                bests.push(candidate);
                break;
            }
        }
        Ok(Tuning {
            contestant,
            asked,
            bests,
            tried,
            lost,
        })
    }

    /// Every law tries the best gains of every other one.
    fn exchange(&self, field: &mut [Tuning], done: impl Fn() + Sync) -> Result<()> {
        let best = |tuning: &Tuning| tuning.best_logs().map(<[f64]>::to_vec);
        let bests: Vec<_> = field.iter().map(|t| (t.contestant, best(t))).collect();
        field
            .par_iter_mut()
            .enumerate()
            .try_for_each(|(k, tuning)| {
                let (before, after) = (&bests[..k], &bests[k + 1..]);
                for (rival, theirs) in before.iter().chain(after) {
                    let logs = theirs
                        .as_ref()
                        .map(|theirs| borrowed(tuning, (rival.gains, theirs)));
                    if let Some(logs) = logs.filter(|logs| tuning.best_logs() != Some(logs)) {
                        self.challenge(tuning, logs)?;
                    }
                    done();
                }
                Ok(())
            })
    }

    /// Tries gains, which become the best if they are better on all cases.
    fn challenge(&self, tuning: &mut Tuning, logs: Vec<f64>) -> Result<()> {
        let next = Candidate {
            k: tuning.tried,
            logs,
            errors: Vec::new(),
        };
        tuning.tried += 1;
        let best = tuning.bests.last().map_or(&[][..], |best| &best.errors);
        let Some(found) = self.judge(tuning.contestant, next, self.tuning, best)? else {
            tuning.lost += 1;
            return Ok(());
        };
        let is_whole = found.errors.len() >= best.len();
        let is_better = is_whole && (best.is_empty() || cost(&found.errors) < cost(best));
        if is_better && self.ships(tuning.contestant, &found.logs, &tuning.asked)? {
            tuning.bests.push(found);
        }
        Ok(())
    }

    /// The gains that fail least in the trial, the last of them that was the best; what is shipped where
    /// no gains kept all their runs.
    fn tuned(&self, tuning: &Tuning) -> Result<Tuned> {
        let contestant = tuning.contestant;
        let mut trials = Vec::new();
        for best in tuning.bests.iter().rev() {
            let settings = self
                .scaled(contestant, &best.logs)?
                .1
                .settings(self.system)?;
            let runs = self.report((contestant, &settings), self.trial, &TUNING_PATHS, || ())?;
            let failures = runs.iter().filter(|run| run.fate != Fate::Kept).count();
            trials.push((failures, best));
            if failures == 0 {
                break;
            }
        }
        let least = trials.iter().min_by_key(|(failures, _)| *failures);
        let shipped = vec![0.0; contestant.gains.len()];
        let logs = least.map_or(&shipped, |(_, best)| &best.logs);
        let (gains, law) = self.scaled(contestant, logs)?;
        let tried = usize::try_from(tuning.tried)?;
        Ok(Tuned {
            law: contestant.name.into(),
            gains,
            cost: least.map(|(_, best)| cost(&best.errors)),
            kept: tried - tuning.lost,
            tried,
            asked: tuning.asked.clone(),
            bests: tuning.bests.len(),
            trials: trials.len(),
            failures: least.map_or(0, |(failures, _)| *failures),
            settings: law.settings(self.system)?,
        })
    }

    /// The runs of `contestant` with these settings on every case and path, case by case; `done` is called
    /// after each.
    pub fn report(
        &self,
        (contestant, settings): (&Contestant, &[Setting]),
        cases: &[Case],
        paths: &[&str],
        done: impl Fn() + Sync,
    ) -> Result<Vec<EndedRun>> {
        let name = format!("report {}", contestant.name);
        let one = |k: usize| {
            let (case, path) = (&cases[k / paths.len()], paths[k % paths.len()]);
            let run = self.kept_run(&name, contestant, settings, case, path)?;
            done();
            Ok(run)
        };
        let runs = 0..cases.len() * paths.len();
        runs.into_par_iter().map(one).collect()
    }
}

/// Median plus worst of errors, m.
fn cost(errors: &[f64]) -> f64 {
    let Spread { median, worst } = Spread::from_values(errors.iter().copied());
    median + worst
}

/// Whether errors are clearly worse than those of the best candidate on the same runs.
fn is_behind(errors: &[f64], best: &[f64]) -> bool {
    let best = best.get(..errors.len());
    best.is_some_and(|best| cost(errors) > BEHIND * cost(best))
}

/// Number of candidates of `budget` that are spread evenly.
fn spread_count(budget: u64) -> u64 {
    (SPREAD * budget as f64).ceil() as u64
}

/// Candidate `k` of `budget`: a number between −1 and 1 for each group of gains, see [`Candidate`].
/// The first has the shipped gains; then a Kronecker lattice (Roberts' generalised golden ratio)
/// spreads evenly; the rest are steps around `best` that become smaller.
fn candidate_logs(groups: usize, k: u64, budget: u64, best: Option<&[f64]>) -> Vec<f64> {
    if k == 0 {
        return vec![0.0; groups];
    }
    let (spread, number) = (spread_count(budget) as f64, k as f64);
    if let (Some(best), true) = (best, number >= spread) {
        let rest = (number - spread) / (budget as f64 - spread).max(1.0);
        let step = STEP * SHRINKS.powf(rest);
        let mut random = ChaCha8Rng::seed_from_u64(k);
        let around = |log: &f64| {
            let normal: f64 = StandardNormal.sample(&mut random);
            (log + step * normal).clamp(-1.0, 1.0)
        };
        return best.iter().map(around).collect();
    }
    // The root of g^(n + 1) = g + 1, by fixed-point iteration.
    let power = 1.0 / (groups as f64 + 1.0);
    let golden = (0..60).fold(1.5_f64, |g, _| (g + 1.0).powf(power));
    let part = |j: usize| (0.5 + number * golden.powi(-(j as i32 + 1))).fract();
    (0..groups).map(|j| 2.0 * part(j) - 1.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A law takes from a rival what both have, and keeps the rest of its own.
    #[test]
    fn gains_of_rivals_are_tried_as_far_as_they_go() {
        let own = Tuning {
            contestant: &CONTESTANTS[0],
            asked: Vec::new(),
            bests: vec![Candidate {
                k: 0,
                logs: vec![0.1, 0.2, 0.3, 0.4, 0.5],
                errors: Vec::new(),
            }],
            tried: 1,
            lost: 0,
        };
        let theirs = [0.6, 0.7, 0.8, 0.9, 1.0];
        let of = |k: usize| borrowed(&own, (CONTESTANTS[k].gains, &theirs));
        assert_eq!(CONTESTANTS[1].name, "adaptive");
        assert_eq!(of(1), [0.6, 0.7, 0.8, 0.4, 0.9]);
        assert_eq!(CONTESTANTS[6].name, "cascade");
        assert_eq!(of(6), [0.6, 0.7, 0.3, 1.0, 0.5]);
    }

    /// A candidate is behind if its cost exceeds 1.2 times that of the best on the same runs; none is
    /// behind without a best candidate.
    #[test]
    fn a_candidate_that_is_behind_ends_early() {
        let best = [1.0, 3.0, 2.0, 1.0, 1.0, 1.0, 9.0, 9.0];
        assert!((cost(&best[..4]) - 4.5).abs() < 1e-12);
        let [near, far] = [1.19, 1.21].map(|factor| best.map(|error| factor * error));
        assert!(is_behind(&far[..2], &best) && !is_behind(&near[..2], &best));
        assert!(!is_behind(&far, &[]) && !is_behind(&best, &best));
    }

    /// What is shipped comes first; a fifth of the evenly spread points, 10 of 50, lies in each fifth
    /// of every gain's range, to 4; later ones stay within the range and close in on the best.
    #[test]
    fn candidates_spread_and_then_close_in() {
        let budget = 100;
        assert_eq!(candidate_logs(4, 0, budget, None), [0.0; 4]);
        for gain in 0..4 {
            let mut fifths = [0; 5];
            for k in 1..=50 {
                let log = candidate_logs(4, k, budget, None)[gain];
                fifths[(2.5 * (log + 1.0)) as usize] += 1;
            }
            assert!(
                fifths.iter().all(|n| (6..=14).contains(n)),
                "{gain}: {fifths:?}"
            );
        }
        let best = [0.9, -0.3, 0.0, 1.0];
        let away = |k: u64| {
            let candidate = candidate_logs(4, k, budget, Some(&best));
            assert!(candidate.iter().all(|log| log.abs() <= 1.0));
            let distance = candidate.iter().zip(best).map(|(a, b)| (a - b).abs());
            distance.sum::<f64>()
        };
        let mean = |from: u64| (from..from + 20).map(away).sum::<f64>() / 20.0;
        assert!(mean(80) < 0.6 * mean(50), "{} {}", mean(80), mean(50));
    }
}
