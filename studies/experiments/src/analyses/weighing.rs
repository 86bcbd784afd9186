//! Payloads that the controller does not know, each run with and without weighing of the hook, for
//! the subcommand `weighing`: what weighing costs where it is wrong, and brings where it is right.

use anyhow::Result;
use cosim::{Experiment, System, Verdict, start_value};
use rayon::prelude::*;
use serde::Serialize;

use crate::runs::ended_run::{EndedRun, Fate};
use crate::runs::run_store::RunStore;
use crate::setup::start_values::{Law, add_settings, trajectory_settings};

/// Payloads, kg.
pub(crate) const PAYLOADS: [f64; 7] = [0.0, 20.0, 50.0, 100.0, 200.0, 300.0, 380.0];
/// Distances of the centre of mass from where the controller has it, along each axis, m.
const SHIFTS: [f64; 2] = [0.25, 0.5];
/// Length of a run, s: the pose is held for 4 s, in which the hook is weighed.
const END: f64 = 13.75;
/// Largest error over that without weighing.
const WORSE: f64 = 1.1;

/// A payload in both runs.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Weighed {
    /// Mass, kg.
    pub(crate) payload: f64,
    /// Centre of mass less the nominal one, m.
    pub(crate) shift: [f64; 3],
    pub(crate) with: EndedRun,
    pub(crate) without: EndedRun,
}

impl Weighed {
    /// Error with weighing over that without; None unless both runs were kept.
    pub(crate) fn ratio(&self) -> Option<f64> {
        Some(self.with.rmse? / self.without.rmse?)
    }

    /// Whether weighing ends worse, or with an error of more than [`WORSE`] times.
    fn is_worse(&self) -> bool {
        let rank = |run: &EndedRun| match run.fate {
            Fate::Kept => 0,
            Fate::Stopped => 1,
            Fate::Lost => 2,
        };
        rank(&self.with) > rank(&self.without) || self.ratio().is_some_and(|ratio| ratio > WORSE)
    }
}

/// The nominal centre, the same shifted along each axis, and to the corners of a cube, m.
pub(crate) fn shifts() -> Vec<[f64; 3]> {
    let along = |axis: usize, by: f64| std::array::from_fn(|i| if i == axis { by } else { 0.0 });
    let mut shifts = vec![[0.0; 3]];
    for by in SHIFTS {
        shifts.extend((0..3).flat_map(|axis| [along(axis, by), along(axis, -by)]));
    }
    let corner = |k: u32| {
        std::array::from_fn(|i| {
            if k >> i & 1 == 1 {
                SHIFTS[1]
            } else {
                -SHIFTS[1]
            }
        })
    };
    shifts.extend((0..8).map(corner));
    shifts
}

/// Runs every payload at every place with and without weighing, in parallel; `done` is called after
/// each.
pub(crate) fn run(
    (system, base): (&System, &Experiment),
    law: &Law,
    payloads: &[f64],
    shifts: &[[f64; 3]],
    store: &RunStore,
    done: impl Fn() + Sync,
) -> Result<Vec<Weighed>> {
    let points: Vec<_> = payloads
        .iter()
        .flat_map(|payload| shifts.iter().map(move |shift| (*payload, *shift)))
        .collect();
    let time = system.port("controller.weighing_time")?;
    let one = |(payload, shift): (f64, [f64; 3])| {
        let mut settings = law.settings(system)?;
        settings.extend(trajectory_settings(system, "triangular")?);
        settings.push(system.setting("hdrm.payload.mass", payload)?);
        for (k, by) in (1..).zip(shift) {
            let name = format!("hdrm.payload.com[{k}]");
            let nominal = start_value(system, &base.settings, system.port(&name)?)?;
            settings.push(system.setting(&name, nominal + by)?);
        }
        let mut weighs = add_settings(system, base, settings)?;
        weighs.stop = Some(END);
        let mut does_not = weighs.clone();
        does_not
            .settings
            .push(system.setting(&system.name(time), 0.0)?);
        let run = |what: &str, experiment: &Experiment| {
            let name = format!("{} {payload} kg {shift:?} {what}", law.name);
            store.run(&name, system, experiment)
        };
        let (with, without) = (run("weighed", &weighs)?, run("not weighed", &does_not)?);
        done();
        Ok(Weighed {
            payload,
            shift,
            with,
            without,
        })
    };
    points.into_par_iter().map(one).collect()
}

/// Makes the verdict bad where a payload ends worse than without weighing.
pub(crate) fn judge(weighed: &[Weighed], verdict: &mut Verdict) {
    let mut worse = weighed.iter().filter(|w| w.is_worse());
    let Some(first) = worse.next() else { return };
    let run = |run: &EndedRun| match run.rmse {
        Some(rmse) => format!("{:.3} mm", 1e3 * rmse),
        None => format!("{:?} ({})", run.fate, run.why).to_lowercase(),
    };
    verdict.object(format!(
        "{} of {} payloads end worse than without weighing, or with more than {WORSE} times its error, first {} kg, shifted by {:?} m: {} instead of {}",
        1 + worse.count(),
        weighed.len(),
        first.payload,
        first.shift,
        run(&first.with),
        run(&first.without)
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A worse fate counts, and a larger error of a payload that is kept; runs that end alike without
    /// an error do not.
    #[test]
    fn what_weighing_makes_worse_is_told() {
        let run = |fate, rmse| EndedRun {
            fate,
            rmse,
            ..EndedRun::default()
        };
        let kept = |rmse| run(Fate::Kept, Some(rmse));
        let [stopped, lost] = [Fate::Stopped, Fate::Lost].map(|fate| run(fate, None));
        for (with, without, is_worse) in [
            (kept(1.09e-3), kept(1e-3), false),
            (kept(1.11e-3), kept(1e-3), true),
            (kept(9e-3), stopped.clone(), false),
            (stopped.clone(), kept(1e-3), true),
            (lost.clone(), stopped.clone(), true),
            (lost.clone(), lost, false),
        ] {
            let weighed = Weighed {
                payload: 20.0,
                shift: [0.0, 0.5, 0.0],
                with,
                without,
            };
            let mut verdict = Verdict::default();
            judge(&[weighed], &mut verdict);
            assert_eq!(verdict.is_bad(), is_worse, "{verdict}");
        }
    }

    #[test]
    fn each_place_is_another_one() {
        let shifts = shifts();
        assert_eq!(shifts.len(), 1 + 2 * 6 + 8);
        for (k, shift) in shifts.iter().enumerate() {
            assert!(!shifts[..k].contains(shift), "{shift:?}");
        }
    }
}
