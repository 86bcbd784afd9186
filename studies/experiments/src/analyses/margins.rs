//! Stability margins of a law, for the subcommand `margins` and the report: how far delay, loop
//! gain, mounting, inertia or the rate of adaptation may change before the machine swings, leaves
//! its path or overloads a rod, in several poses and on paths, with two payloads.
//!
//! Each point is a run: the machine rests in a pose and is pushed, or follows a path, whose motion
//! also frees what sticks at rest. It is stable if no rod swings at the end of the run, nor strongly
//! on the way. The factor is found by bisection on such runs, not by linearisation: adaptation,
//! play, stiction and the inverter's hold count as they are. So a limit cycle counts as unstable,
//! and nothing is said of factors beyond the largest that is tried.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use cosim::{Experiment, Setting, System, Verdict, start_value};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::measures::run::motion_end;
use crate::runs::ended_run::Fate;
use crate::runs::run_store::RunStore;
use crate::setup::start_values::{BY_RATES, Law, add_settings, trajectory_settings};

/// Length of a run in a pose, s, and when the push begins; the last second counts.
const END: f64 = 8.0;
const PUSH_START: f64 = 1.0;
/// Rest after a path, s.
const REST: f64 = 5.0;
/// Push downwards, N, and how long it lasts, s.
const PUSH: f64 = -300.0;
const PUSH_DURATION: f64 = 0.05;
/// Largest factor that is tried, and halvings of the logarithm between it, [`FACTOR`] and 1: to
/// 2^(1/8), 9 %, below [`FACTOR`], and to 4^(1/8), 19 %, above.
const MOST: f64 = 8.0;
const HALVINGS: u32 = 3;
/// Most steps of delay that are added: the sensors have no more.
const STEPS: u32 = 3;
/// Factor, and steps of delay, that a law has to tolerate.
const FACTOR: f64 = 2.0;
const DELAY: f64 = 2.0;

/// Where the machine is: a pose in which it rests, by name and joint angles in degrees, or the name
/// of a path that it follows.
pub(crate) type Place = (&'static str, Option<[f64; 6]>);
/// All paths and poses; at [`BY_RATES`] commanded rates of zero are followed.
pub(crate) const PLACES: [Place; 6] = [
    ("triangular", None),
    ("six-joints", None),
    ("start", Some([0.0, 40.0, -80.0, 0.0, -50.0, 0.0])),
    ("reach", Some([0.0, 20.0, -40.0, 0.0, -50.0, 0.0])),
    ("folded", Some([30.0, 55.0, -110.0, 0.0, -40.0, 0.0])),
    (BY_RATES, Some([0.0, 40.0, -80.0, 0.0, -50.0, 0.0])),
];
/// Payloads, kg: an empty hook and the nominal one.
pub(crate) const PAYLOADS: [f64; 2] = [1.0, 300.0];

/// What is changed, and in which direction.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Change {
    /// More steps of delay of the readings.
    Delay,
    /// Higher gain of the loop from motion to force.
    Gain,
    /// Softer mounting.
    Softer,
    /// Stiffer mounting.
    Stiffer,
    /// Larger inertias.
    Heavier,
    /// Smaller inertias.
    Lighter,
    /// Faster adaptation.
    Adaptation,
}

/// Stiffness of the actuators' mountings.
const MOUNTING: &[&str] = &[
    "emla_1.compliance.mount",
    "emla_2.compliance.mount",
    "emla_3.compliance.mount",
];
/// Gains of the loop from motion to force.
const LOOP: &[&str] = &[
    "controller.kappa_KA",
    "controller.pd_actuator_damping",
    "controller.pd_wrist_damping[1]",
    "controller.pd_wrist_damping[2]",
    "controller.pd_wrist_damping[3]",
];
const INERTIA: &[&str] = &["hdrm.inertia_scale"];
/// The smaller it is, the faster is the adaptation.
const GAMMA: &[&str] = &["controller.gamma"];

/// All changes: name, variables that the change multiplies, and whether by the factor or by its
/// inverse.
pub const CHANGES: [(Change, &str, &[&str], bool); 7] = [
    (Change::Delay, "delay, steps more", &[], true),
    (Change::Gain, "loop gain x", LOOP, true),
    (Change::Softer, "mounting softer /", MOUNTING, false),
    (Change::Stiffer, "mounting stiffer x", MOUNTING, true),
    (Change::Heavier, "inertia x", INERTIA, true),
    (Change::Lighter, "inertia /", INERTIA, false),
    (Change::Adaptation, "adaptation faster x", GAMMA, false),
];

impl Change {
    /// Its row of [`CHANGES`].
    fn row(self) -> (Self, &'static str, &'static [&'static str], bool) {
        let row = CHANGES.into_iter().find(|(change, ..)| *change == self);
        row.expect("a row for each change")
    }

    /// The start values with this change by `factor`.
    fn settings(self, system: &System, base: &Experiment, factor: f64) -> Result<Vec<Setting>> {
        let scaled = |name: &str, by: f64, more: f64| {
            let nominal = start_value(system, &base.settings, system.port(name)?)?;
            system.setting(name, nominal * by + more)
        };
        if self == Self::Delay {
            return Ok(vec![scaled("sensors.delay", 1.0, factor)?]);
        }
        let (.., names, is_product) = self.row();
        let by = if is_product { factor } else { 1.0 / factor };
        names.iter().map(|name| scaled(name, by, 0.0)).collect()
    }

    pub(crate) fn name(self) -> &'static str {
        self.row().1
    }

    fn applies_to(self, law: &Law) -> bool {
        self != Self::Adaptation || law.name.starts_with("adaptive")
    }

    /// Factor, or steps of delay, that a law has to tolerate.
    #[must_use]
    pub fn target(self) -> f64 {
        if self == Self::Delay { DELAY } else { FACTOR }
    }
}

/// What ends a margin.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Limit {
    /// The machine swings, or leaves its path.
    Stability,
    /// A rod carries more than its rated force.
    Force,
}

/// Stability margin of a law in one place with one payload.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Margin {
    /// Law.
    pub law: String,
    /// Pose or path.
    pub place: String,
    /// Payload, kg.
    pub payload: f64,
    /// What is changed.
    pub change: Change,
    /// Largest factor, or number of steps, that was found stable; 0 where the machine is unstable
    /// without any change.
    pub stable: f64,
    /// Smallest that was not, and why; None if the largest that was tried is stable.
    pub beyond: Option<(f64, Limit)>,
}

/// Largest factor, or number of steps, that is stable, and the smallest that is not with its limit.
type Bracket = (f64, Option<(f64, Limit)>);

/// Bisects the logarithm of a factor from 1 to [`FACTOR`], or from there to [`MOST`], so that the
/// target itself is tried; `limit` is what a factor meets, and 1 meets none.
fn bisect(limit: &dyn Fn(f64) -> Result<Option<Limit>>) -> Result<Bracket> {
    let Some(mut met) = limit(MOST)? else {
        return Ok((MOST, None));
    };
    let (mut low, mut high) = match limit(FACTOR)? {
        None => (FACTOR, MOST),
        Some(limit) => {
            met = limit;
            (1.0, FACTOR)
        }
    };
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        match limit(middle)? {
            None => low = middle,
            Some(limit) => (high, met) = (middle, limit),
        }
    }
    Ok((low, Some((high, met))))
}

/// Adds steps up to [`STEPS`] until a limit is met.
fn count(limit: &dyn Fn(f64) -> Result<Option<Limit>>) -> Result<Bracket> {
    for steps in (1..=STEPS).map(f64::from) {
        if let Some(limit) = limit(steps)? {
            return Ok((steps - 1.0, Some((steps, limit))));
        }
    }
    Ok((f64::from(STEPS), None))
}

/// Margins of `laws` in these places with these payloads, in parallel; `done` is called after each.
pub(crate) fn run(
    (system, base): (&System, &Experiment),
    laws: &[Law],
    places: &[Place],
    payloads: &[f64],
    store: &RunStore,
    done: impl Fn() + Sync,
) -> Result<Vec<Margin>> {
    let mut points = Vec::new();
    for law in laws {
        for place in places {
            for payload in payloads {
                let changes = CHANGES.iter().filter(|(change, ..)| change.applies_to(law));
                points.extend(changes.map(|(change, ..)| (law, place, *payload, *change)));
            }
        }
    }
    let one = |(law, place, payload, change): (&Law, &Place, f64, Change)| {
        let placed = Placed::new((system, base), law, place, payload)?;
        let changed = |factor| placed.limit(Some(change), factor, store);
        let (stable, beyond) = match (placed.limit(None, 1.0, store)?, change) {
            (Some(limit), _) => (0.0, Some((1.0, limit))),
            (None, Change::Delay) => count(&changed)?,
            (None, _) => bisect(&changed)?,
        };
        done();
        Ok(Margin {
            law: law.name.clone(),
            place: place.0.into(),
            payload,
            change,
            stable,
            beyond,
        })
    };
    points.into_par_iter().map(one).collect()
}

/// Whether `law` tolerates every change at its target in these places with these payloads; a rod beyond its
/// rated force is no fault of the law's.
pub(crate) fn tolerates_all(
    (system, base): (&System, &Experiment),
    law: &Law,
    places: &[(Place, f64)],
    store: &RunStore,
) -> Result<bool> {
    let changes = CHANGES.map(|(change, ..)| change);
    let changes = || changes.into_iter().filter(|change| change.applies_to(law));
    let placed: Vec<_> = (places.iter())
        .map(|(place, payload)| Placed::new((system, base), law, place, *payload))
        .collect::<Result<_>>()?;
    let points: Vec<_> = (placed.iter())
        .flat_map(|placed| changes().map(move |change| (placed, change)))
        .collect();
    let limits = points.into_par_iter().map(|(placed, change)| {
        let limit = placed.limit(Some(change), change.target(), store)?;
        Ok(limit != Some(Limit::Stability))
    });
    Ok(limits
        .collect::<Result<Vec<bool>>>()?
        .into_iter()
        .all(|met| met))
}

/// A law in a place, where it is pushed, or on a path.
struct Placed<'a> {
    system: &'a System,
    nominal: Experiment,
    /// Law, place and payload.
    name: String,
}

impl<'a> Placed<'a> {
    fn new(
        (system, base): (&'a System, &Experiment),
        law: &Law,
        (place, pose): &Place,
        payload: f64,
    ) -> Result<Self> {
        let mut settings = law.settings(system)?;
        for (name, value) in [
            ("hdrm.payload.mass", payload),
            ("hdrm.push.force[2]", PUSH),
            ("hdrm.push.start", PUSH_START),
            ("hdrm.push.duration", PUSH_DURATION),
        ] {
            settings.push(system.setting(name, value)?);
        }
        if let Some(pose) = pose {
            for (k, angle) in (1..).zip(pose) {
                let name = format!("hdrm.zeta_start[{k}]");
                settings.push(system.setting(&name, angle * PI / 180.0)?);
            }
            settings.push(system.setting("controller.settle_time", 10.0 * END)?);
            if *place == BY_RATES {
                settings.push(system.setting("controller.trajectory", BY_RATES)?);
            }
        } else {
            settings.extend(trajectory_settings(system, place)?);
        }
        let mut nominal = add_settings(system, base, settings)?;
        nominal.stop = Some(if pose.is_some() {
            END
        } else {
            let end = motion_end(system, &nominal.start(system)?);
            end.with_context(|| format!("path {place} has no end"))? + REST
        });
        let name = format!("{} {place} {payload}", law.name);
        Ok(Self {
            system,
            nominal,
            name,
        })
    }

    /// What it meets with `change` by `factor`, or as it is.
    fn limit(
        &self,
        change: Option<Change>,
        factor: f64,
        store: &RunStore,
    ) -> Result<Option<Limit>> {
        let mut experiment = self.nominal.clone();
        if let Some(change) = change {
            let changed = change.settings(self.system, &self.nominal, factor)?;
            experiment.settings.extend(changed);
        }
        let what = change.map_or("as it is", Change::name);
        let name = format!("{} {what} {factor:.4}", self.name);
        let run = store.run(&name, self.system, &experiment)?;
        Ok(match run.fate == Fate::Kept {
            true => None,
            false if run.load > 1.0 => Some(Limit::Force),
            false => Some(Limit::Stability),
        })
    }
}

/// The least margin of each law and change that ends at `limit` or not at all, in the order of the
/// runs.
pub(crate) fn least(margins: &[Margin], limit: Limit) -> Vec<&Margin> {
    let mut least: Vec<&Margin> = Vec::new();
    for margin in margins {
        if margin.beyond.is_some_and(|(_, met)| met != limit) {
            continue;
        }
        let same = |m: &&mut &Margin| m.law == margin.law && m.change == margin.change;
        match least.iter_mut().find(same) {
            Some(known) if margin.stable < known.stable => *known = margin,
            Some(_) => {}
            None => least.push(margin),
        }
    }
    least
}

/// Makes the verdict bad where a stability margin is below its target. Where a rod's force ends the
/// margin, no law could do better: that is only noted.
pub(crate) fn judge(margins: &[Margin], verdict: &mut Verdict) {
    for limit in [Limit::Stability, Limit::Force] {
        for margin in least(margins, limit) {
            let target = margin.change.target();
            if margin.stable >= target {
                continue;
            }
            let text = format!(
                "{}: up to {} {:.2}, {} with {} kg",
                margin.law,
                margin.change.name(),
                margin.stable,
                margin.place,
                margin.payload
            );
            match limit {
                Limit::Stability => {
                    verdict.object(format!("{text}, it is stable, but {target} is asked for"));
                }
                Limit::Force => verdict.note(format!(
                    "{text}, it is stable; beyond, a rod carries more than its rated force"
                )),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is unstable from 2.6 on is found between 2.6/1.19 and 2.6·1.19, from 1.4 on to 1.09; what
    /// is stable everywhere has no bound. The limit is that of the border, not of the largest factor.
    #[test]
    fn bisection_closes_in_on_the_border() {
        let limit = |factor: f64| match factor {
            ..2.6 => None,
            2.6..4.0 => Some(Limit::Force),
            _ => Some(Limit::Stability),
        };
        for (border, width) in [(2.6, 1.19), (1.4, 1.0906)] {
            let scaled = |factor: f64| Ok(limit(2.6 / border * factor));
            let (low, beyond) = bisect(&scaled).expect("no error");
            let (high, met) = beyond.expect("a border");
            let is_around = low < border && high >= border && high / low < width;
            assert!(is_around && met == Limit::Force, "{low} {high}");
        }
        assert_eq!(bisect(&|_| Ok(None)).expect("no error"), (MOST, None));
        let steps = count(&|steps| Ok((steps > 1.5).then_some(Limit::Stability)));
        assert_eq!(
            steps.expect("no error"),
            (1.0, Some((2.0, Limit::Stability)))
        );
    }

    /// A margin that a rod's force ends does not count against the law.
    #[test]
    fn the_least_margin_is_judged() {
        let margin = |place: &str, stable, limit| Margin {
            law: "pd".into(),
            place: place.into(),
            payload: 300.0,
            change: Change::Gain,
            stable,
            beyond: Some((1.1 * stable, limit)),
        };
        let margins = [
            margin("start", 3.0, Limit::Stability),
            margin("reach", 1.5, Limit::Stability),
            margin("folded", 1.2, Limit::Force),
        ];
        let mut verdict = Verdict::default();
        judge(&margins, &mut verdict);
        let texts: Vec<_> = verdict.findings().iter().map(|f| &*f.text).collect();
        assert_eq!(
            texts[0],
            "pd: up to loop gain x 1.50, reach with 300 kg, it is stable, but 2 is asked for"
        );
        assert_eq!(
            texts[1],
            "pd: up to loop gain x 1.20, folded with 300 kg, it is stable; beyond, a rod carries more than its rated force"
        );
        let mut good = Verdict::default();
        judge(&[margins[0].clone(), margins[2].clone()], &mut good);
        assert!(!good.is_bad());
    }
}
