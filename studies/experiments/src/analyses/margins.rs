//! How far a law is from instability: the factor by which delay, loop gain, mounting, inertia or the
//! rate of adaptation may change before the machine swings, over poses and payloads.
//!
//! Each point is a run: the machine rests in a pose where a push moves it, or follows a path, whose
//! motion also frees what sticks at rest. It is stable where no rod swings, at the end nor, far more,
//! on the way. The factor is found by bisection on such runs, not by linearisation:
//! adaptation, play, stiction and the inverter's hold count as they are. So a limit cycle counts as
//! unstable, and a factor says nothing about those beyond the largest that is tried.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use cosim::{Experiment, Setting, System, Verdict, start_value};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::measures::run::motion_end;
use crate::runs::ended_run::Fate;
use crate::runs::run_store::RunStore;
use crate::setup::start_values::{Law, add_settings, trajectory_settings};

/// Length of a run in a pose, s, and when the push begins: what a push leaves in the measure, 5 % of
/// the rated force, falls with its time constant of 2 s, to a fifth of [`UNSTABLE`] at the end.
const END: f64 = 8.0;
const PUSH_START: f64 = 1.0;
/// Rest after a path, s: what the path's own accelerations leave in the measure falls to a tenth.
const REST: f64 = 5.0;
/// Push downwards, N, and how long it lasts, s.
const PUSH: f64 = -1000.0;
const PUSH_DURATION: f64 = 0.05;
/// A rod whose force swings at the end with this root mean square over the rated force is unstable:
/// some 1 kN of amplitude.
const UNSTABLE: f64 = 0.01;
/// Largest factor that is tried, and halvings of the logarithm between it, [`FACTOR`] and 1: to
/// 2^(1/8), 9 %, below [`FACTOR`], and to 4^(1/8), 19 %, above.
const MOST: f64 = 8.0;
const HALVINGS: u32 = 3;
/// Most steps of delay that are added: the sensors have no more.
const STEPS: u32 = 3;
/// What a law is asked for.
pub const FACTOR: f64 = 2.0;
/// Steps of delay that it is to bear.
pub const DELAY: f64 = 2.0;

/// Where the machine is: name, and joint angles in degrees of a pose in which it rests; else it
/// follows the path of that name.
pub type Place = (&'static str, Option<[f64; 6]>);
/// Poses and paths.
pub const PLACES: [Place; 5] = [
    ("triangular", None),
    ("six-joints", None),
    ("start", Some([0.0, 40.0, -80.0, 0.0, -50.0, 0.0])),
    ("reach", Some([0.0, 20.0, -40.0, 0.0, -50.0, 0.0])),
    ("folded", Some([30.0, 55.0, -110.0, 0.0, -40.0, 0.0])),
];
/// Payloads, kg: an empty hook and the nominal one.
pub const PAYLOADS: [f64; 2] = [1.0, 300.0];

/// What is changed, and to which side.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Change {
    /// Steps of delay of the readings, added.
    Delay,
    /// Gain of the loop from motion to force.
    Gain,
    /// Mounting softer.
    Softer,
    /// Mounting stiffer.
    Stiffer,
    /// All inertias larger.
    Heavier,
    /// All inertias smaller.
    Lighter,
    /// Adaptation faster.
    Adaptation,
}

/// All changes, with their names.
pub const CHANGES: [(Change, &str); 7] = [
    (Change::Delay, "delay, steps more"),
    (Change::Gain, "loop gain x"),
    (Change::Softer, "mounting softer /"),
    (Change::Stiffer, "mounting stiffer x"),
    (Change::Heavier, "inertia x"),
    (Change::Lighter, "inertia /"),
    (Change::Adaptation, "adaptation faster x"),
];

impl Change {
    /// Variables that it multiplies, and whether by the factor or by its inverse.
    fn variables(self) -> (&'static [&'static str], bool) {
        const MOUNT: [&str; 3] = [
            "emla_1.compliance.mount",
            "emla_2.compliance.mount",
            "emla_3.compliance.mount",
        ];
        match self {
            Self::Delay => (&[], true),
            Self::Gain => (
                &[
                    "controller.kappa_KA",
                    "controller.pd_actuator_damping",
                    "controller.pd_wrist_damping[1]",
                    "controller.pd_wrist_damping[2]",
                    "controller.pd_wrist_damping[3]",
                ],
                true,
            ),
            Self::Softer => (&MOUNT, false),
            Self::Stiffer => (&MOUNT, true),
            Self::Heavier => (&["hdrm.inertia_scale"], true),
            Self::Lighter => (&["hdrm.inertia_scale"], false),
            Self::Adaptation => (&["controller.gamma"], false),
        }
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
        let (names, is_product) = self.variables();
        let by = if is_product { factor } else { 1.0 / factor };
        names.iter().map(|name| scaled(name, by, 0.0)).collect()
    }

    /// Its name in [`CHANGES`].
    #[must_use]
    pub fn name(self) -> &'static str {
        let named = CHANGES.iter().find(|(change, _)| *change == self);
        named.expect("all changes have names").1
    }

    fn is_of(self, law: &Law) -> bool {
        self != Self::Adaptation || law.name.starts_with("adaptive")
    }

    /// What a law is asked for.
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

/// How far a law is from instability in one place with one payload.
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
    /// Smallest that was not, and why; none up to the largest that is tried.
    pub beyond: Option<(f64, Limit)>,
}

/// The largest factor, or number of steps, that is stable, and the smallest that is not with its limit.
type Border = (f64, Option<(f64, Limit)>);

/// Bisects the logarithm of a factor from 1 to [`FACTOR`], or from there to [`MOST`], so that what a
/// law is asked for is tried itself; `limit` tells what a factor meets, the one of 1 meets none.
fn bisect(limit: &dyn Fn(f64) -> Result<Option<Limit>>) -> Result<Border> {
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

/// Counts steps up to [`STEPS`] until `limit` tells of one.
fn count(limit: &dyn Fn(f64) -> Result<Option<Limit>>) -> Result<Border> {
    for steps in (1..=STEPS).map(f64::from) {
        if let Some(limit) = limit(steps)? {
            return Ok((steps - 1.0, Some((steps, limit))));
        }
    }
    Ok((f64::from(STEPS), None))
}

/// Margins of `laws` in these places with these payloads, on all cores.
///
/// # Errors
/// A system that lacks what is changed, or a store that cannot be written.
pub fn run(
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
                let of_law = CHANGES.iter().filter(|(change, _)| change.is_of(law));
                points.extend(of_law.map(|(change, what)| (law, place, *payload, *change, *what)));
            }
        }
    }
    let one = |(law, place, payload, change, what): (&Law, &Place, f64, Change, &str)| {
        let mut settings = law.settings(system)?;
        let mut set = |name: &str, value: f64| -> Result<()> {
            settings.push(system.setting(name, value)?);
            Ok(())
        };
        for (name, value) in [
            ("hdrm.payload.mass", payload),
            ("hdrm.push.force[2]", PUSH),
            ("hdrm.push.start", PUSH_START),
            ("hdrm.push.duration", PUSH_DURATION),
        ] {
            set(name, value)?;
        }
        if let Some(pose) = place.1 {
            for (k, angle) in (1..).zip(pose) {
                set(&format!("hdrm.zeta_start[{k}]"), angle * PI / 180.0)?;
            }
            set("controller.settle_time", 10.0 * END)?;
        } else {
            settings.extend(trajectory_settings(system, place.0)?);
        }
        let mut nominal = add_settings(system, base, settings)?;
        nominal.stop = Some(match place.1 {
            Some(_) => END,
            None => {
                let end = motion_end(system, &nominal.start(system)?);
                end.with_context(|| format!("path {} has no end", place.0))? + REST
            }
        });
        let limit = |factor: f64, change: Option<Change>| {
            let mut experiment = nominal.clone();
            if let Some(change) = change {
                experiment
                    .settings
                    .extend(change.settings(system, &nominal, factor)?);
            }
            let what = if change.is_some() { what } else { "as it is" };
            let name = format!("{} {} {payload} {what} {factor:.4}", law.name, place.0);
            let run = store.run(&name, system, &experiment)?;
            let is_stable = run.fate == Fate::Kept && run.swing < UNSTABLE;
            Ok(match is_stable {
                true => None,
                false if run.load > 1.0 => Some(Limit::Force),
                false => Some(Limit::Stability),
            })
        };
        let changed = |factor| limit(factor, Some(change));
        let (stable, beyond) = match (limit(1.0, None)?, change) {
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

/// The least margin of each law and change that ends at `limit` or not at all, in the order of the
/// runs.
pub fn least(margins: &[Margin], limit: Limit) -> Vec<&Margin> {
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

/// Margins of stability below what a law is asked for spoil the verdict. Where a rod's force ends
/// them, no law could do better: that is noted.
pub fn judge(margins: &[Margin], verdict: &mut Verdict) {
    for limit in [Limit::Stability, Limit::Force] {
        for margin in least(margins, limit) {
            let target = margin.change.target();
            if margin.stable >= target {
                continue;
            }
            let what = margin.change.name();
            let Margin {
                law,
                place,
                payload,
                stable,
                ..
            } = margin;
            let text = format!("{law}: up to {what} {stable:.2}, {place} with {payload} kg");
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

    /// A rod's force is nobody's instability.
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
