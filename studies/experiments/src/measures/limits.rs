//! Watches a machine's limits and ratings during a run and gives a verdict: which signals saturated
//! and for what share of the time, which ratings were exceeded, whether rods swing, what the
//! controller's supervisor did, whether there was a reference. Used by `measures::run`, `endurance`, `imported_run`.

use std::f64::consts::TAU;
use std::ops::Range;

use anyhow::{Context, Result};
use cosim::io::numbers::short;
use cosim::{Experiment, Port, System, Verdict};
use fmi_description::Kind;
use machine_file::AXES;

use self::Meaning::{RatedMean, Rating, Saturation, Supervision};
use crate::measures::swinging::{SwingWatch, reference_ports};
use crate::setup::machine_choice::MachineFile;

/// Share of the time above which saturation makes the verdict bad.
const SATURATED: f64 = 0.01;

/// The controller's output for the stage of its supervisor.
const STAGE: &str = "supervisor.state";
/// What the supervisor does at its stages from [`ACTS`] on.
const SUPERVISED: [&str; 3] = [
    "froze the adaptation",
    "froze the adaptation and lowered the gains",
    "stopped the machine",
];
/// First stage at which the supervisor acts, and the stage from which the verdict is bad.
const ACTS: f64 = 3.0;
const STOPS: f64 = 5.0;

/// What reaching a limit means.
#[derive(Clone, Copy, PartialEq)]
enum Meaning {
    /// The machine cannot exceed it.
    Saturation,
    /// The machine can exceed it but must not at any time.
    Rating,
    /// The machine can exceed it but must not on average: the root mean square counts.
    RatedMean,
    /// Stage of the controller's supervisor from which it acts.
    Supervision,
}

/// A limit and how close the run came to it.
#[derive(Clone)]
struct Limit {
    name: String,
    unit: &'static str,
    /// Indices of the watched signals; of two the length of their vector counts.
    signals: Range<usize>,
    /// Middle of the range of a single signal: the distance from it counts.
    middle: f64,
    meaning: Meaning,
    /// Value from which on the limit is reached.
    limit: f64,
    worst: f64,
    beyond: u64,
    squares: f64,
    /// Time of the first sample at or beyond the limit, s.
    since: f64,
}

/// Watches the limits and ratings of a machine while it runs.
#[derive(Clone, Default)]
pub struct LimitWatch {
    ports: Vec<Port>,
    limits: Vec<Limit>,
    swings: SwingWatch,
    /// Actuators, with the indices of their rods' forces.
    rods: Vec<(String, usize)>,
    reference: Range<usize>,
    samples: u64,
}

impl LimitWatch {
    /// A watch for a system whose parameters have the values that `parameter` returns. The limits
    /// come from the machine file of the manipulator; without one nothing is watched, and the
    /// verdict says so.
    pub fn new(
        system: &System,
        parameter: &dyn Fn(Port) -> Result<f64>,
        file: Option<&MachineFile>,
    ) -> Result<Self> {
        let mut watch = Self::default();
        let Some(MachineFile { machine, .. }) = file else {
            return Ok(watch);
        };
        let (mut drives, mut rated) = (0, Vec::new());
        for k in 0..system.fmus.len() {
            let name = &system.structure.components[k].name;
            if system.port_of(k, STAGE).is_ok() {
                let limit = Limit::new(format!("supervisor of {name}"), "", Supervision, ACTS);
                watch.add_limit(system, k, &[STAGE], limit)?;
            }
            let limits = ["v_max", "i_max"].map(|limit| system.port_of(k, limit));
            let [Ok(v_max), Ok(i_max)] = limits else {
                continue;
            };
            let [v_max, i_max] = [parameter(v_max)?, parameter(i_max)?];
            // Actuators of other makers have no axis: they count in the order of the system.
            let axis = match system.port_of(k, "axis") {
                Ok(axis) => parameter(axis)? as usize,
                Err(_) => drives + 1,
            };
            drives += 1;
            let ratings = machine.ratings.in_order();
            let ratings = ratings.get(axis.wrapping_sub(1));
            let ratings =
                ratings.with_context(|| format!("`axis` of {name} = {axis} must be 1, 2 or 3"))?;
            let speed = ratings.motor_speed_rpm * TAU / 60.0;
            let torque = ratings.motor_torque;
            let rows: [(_, _, &[&str], _, _); 5] = [
                ("voltage", "V", &["v_d", "v_q"], Saturation, v_max),
                ("current", "A", &["i_d", "i_q"], Saturation, i_max),
                ("force", "N", &["F"], Rating, ratings.force_max),
                ("motor speed", "rad/s", &["w_m"], Rating, speed),
                ("motor torque", "N.m", &["tau_e"], RatedMean, torque),
            ];
            for (what, unit, variables, meaning, limit) in rows {
                let title = format!("{what} of {name}");
                let row = Limit::new(title, unit, meaning, limit);
                watch.add_limit(system, k, variables, row)?;
                if what == "force" {
                    watch.rods.push((name.clone(), watch.ports.len() - 1));
                    rated.push(limit);
                }
            }
        }
        let arm = system.port("f_hold[1]")?.component;
        let limits = &machine.limits;
        let rods = AXES.into_iter().zip(limits.strokes()).zip(1..);
        for (((rod, [min, max]), i), ratings) in rods.zip(machine.ratings.in_order()) {
            let name = format!("stroke of {rod} from its middle");
            let stroke = Limit {
                middle: 0.5 * (min + max),
                ..Limit::new(name, "m", Saturation, 0.5 * (max - min))
            };
            watch.add_limit(system, arm, &[&format!("x[{i}]")], stroke)?;
            let name = format!("rod speed of {rod}");
            let speed = Limit::new(name, "m/s", Rating, ratings.rod_speed_max);
            watch.add_limit(system, arm, &[&format!("x_dot[{i}]")], speed)?;
        }
        watch.swings = SwingWatch::new(rated);
        for (i, max) in (1..).zip(limits.tau_wrist_max) {
            let torque = Limit::new(format!("wrist torque {i}"), "N.m", Saturation, max);
            watch.add_limit(system, arm, &[&format!("tau_wrist[{i}]")], torque)?;
        }
        let first = watch.ports.len();
        watch.ports.extend(reference_ports(system));
        watch.reference = first..watch.ports.len();
        Ok(watch)
    }

    /// Adds a limit on `variables` of a component.
    fn add_limit(
        &mut self,
        system: &System,
        component: usize,
        variables: &[&str],
        limit: Limit,
    ) -> Result<()> {
        let first = self.ports.len();
        for name in variables {
            self.ports.push(system.port_of(component, name)?);
        }
        let signals = first..self.ports.len();
        self.limits.push(Limit { signals, ..limit });
        Ok(())
    }

    /// The watched variables.
    pub fn ports(&self) -> &[Port] {
        &self.ports
    }

    /// Adds their values, in the order of the ports, at the time `t`, s.
    pub fn add(&mut self, t: f64, values: &[f64]) {
        self.samples += 1;
        for limit in &mut self.limits {
            limit.add(t, values);
        }
        let forces = self.rods.iter().map(|(_, signal)| values[*signal]);
        self.swings.add(t, forces, &values[self.reference.clone()]);
    }

    /// The findings so far, without that the supervisor stopped the machine where an alarm on its
    /// stage `is_told`.
    pub fn verdict(&self, is_told: impl Fn(Port) -> bool) -> Verdict {
        let mut verdict = Verdict::default();
        if self.limits.is_empty() {
            verdict.note(
                "limits and ratings are not watched: the manipulator has no `machine_file`".into(),
            );
        }
        for limit in &self.limits {
            let is_stop = limit.meaning == Supervision && limit.worst >= STOPS;
            if !(is_stop && is_told(self.ports[limit.signals.start])) {
                limit.judge(self.samples, &mut verdict);
            }
        }
        let names = self.rods.iter().map(|(name, _)| name);
        self.swings.judge(names, &mut verdict);
        verdict
    }
}

impl Limit {
    fn new(name: String, unit: &'static str, meaning: Meaning, limit: f64) -> Self {
        Self {
            name,
            unit,
            signals: 0..1,
            middle: 0.0,
            meaning,
            limit,
            worst: 0.0,
            beyond: 0,
            squares: 0.0,
            since: 0.0,
        }
    }

    fn magnitude(&self, values: &[f64]) -> f64 {
        match values[self.signals.clone()] {
            [a, b] => a.hypot(b),
            [a] => (a - self.middle).abs(),
            _ => unreachable!("a limit is on one signal or on two"),
        }
    }

    fn add(&mut self, t: f64, values: &[f64]) {
        let value = self.magnitude(values);
        self.worst = self.worst.max(value);
        self.squares += value * value;
        if value >= self.limit {
            if self.beyond == 0 {
                self.since = t;
            }
            self.beyond += 1;
        }
    }

    fn judge(&self, samples: u64, verdict: &mut Verdict) {
        let (name, unit) = (&self.name, self.unit);
        let limit = short((1e4 * self.limit).round() / 1e4);
        // Five digits, or as many as tell it from the limit.
        let shown = |value: f64| {
            let rounded = (4..16).map(|digits: usize| format!("{value:.digits$e}").parse());
            let differs = |x: &f64| *x != self.limit;
            short(rounded.flatten().find(differs).unwrap_or(value))
        };
        let samples = samples.max(1) as f64;
        let rms = (self.squares / samples).sqrt();
        let share = self.beyond as f64 / samples;
        let first = format!("first at t = {:.3} s", self.since);
        let when = format!("for {:.2} % of the time, {first}", 100.0 * share);
        let (is_bad, text) = match self.meaning {
            RatedMean if rms > self.limit => (
                true,
                format!(
                    "{name}: root mean square {} {unit}, more than the rated {limit} {unit}",
                    shown(rms)
                ),
            ),
            RatedMean => return,
            _ if self.beyond == 0 => return,
            Supervision => {
                let done = ((self.worst - ACTS) as usize).min(SUPERVISED.len() - 1);
                let text = format!("{name}: it {}, {first}", SUPERVISED[done]);
                (self.worst >= STOPS, text)
            }
            Rating => (
                true,
                format!(
                    "{name}: up to {} {unit}, more than the rated {limit} {unit} {when}",
                    shown(self.worst)
                ),
            ),
            Saturation => (
                share > SATURATED,
                format!("{name}: at its limit of {limit} {unit} {when}"),
            ),
        };
        match is_bad {
            true => verdict.object(text),
            false => verdict.note(text),
        }
    }
}

/// Checks that the controller has a reference to follow in `experiment`; `parameter` returns values
/// of parameters.
pub fn check_reference(
    system: &System,
    experiment: &Experiment,
    parameter: &dyn Fn(Port) -> Result<f64>,
) -> Result<Verdict> {
    let mut verdict = Verdict::default();
    let port = system.port("trajectory")?;
    let Kind::Enumeration(items) = &system.variable(port).kind else {
        return Ok(verdict);
    };
    let external = items.iter().find(|item| item.name == "external");
    let chosen = parameter(port)?;
    let wiring = system.wiring()?;
    let inputs = system.elements(port.component, "reference.position", 3)?;
    let given = experiment.given(system)?;
    let is_driven = inputs
        .into_iter()
        .any(|input| wiring.driver(input).is_some() || given.contains(&input));
    if external.is_some_and(|item| item.value as f64 == chosen) && !is_driven {
        let name = system.component_of(port);
        verdict.object(format!(
            "{name}.trajectory is external, but nothing drives {name}.reference.position: the tip keeps its place, and errors mean nothing"
        ));
    }
    Ok(verdict)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stop that an alarm tells is told once; what it did before stays.
    #[test]
    fn a_stop_is_told_once() {
        let port = Port::new(0, 0);
        for (stage, is_told, count) in [(5.0, true, 0), (5.0, false, 1), (4.0, true, 1)] {
            let limit = Limit::new("supervisor".into(), "", Supervision, ACTS);
            let (ports, limits) = (vec![port], vec![limit]);
            let mut watch = LimitWatch {
                ports,
                limits,
                ..LimitWatch::default()
            };
            watch.limits[0].add(1.0, &[stage]);
            let verdict = watch.verdict(|_| is_told);
            assert_eq!(verdict.findings().len(), count, "{stage}: {verdict}");
        }
    }

    fn judged(meaning: Meaning, values: &[f64]) -> Verdict {
        let mut limit = Limit::new("x".into(), "N", meaning, 2.0);
        for (k, value) in (0..).zip(values) {
            limit.add(f64::from(k), &[*value]);
        }
        let mut verdict = Verdict::default();
        limit.judge(values.len() as u64, &mut verdict);
        verdict
    }

    #[test]
    fn saturation_is_noted_and_spoils_a_run_from_one_percent_of_the_time_on() {
        let mut values = vec![0.0; 200];
        assert_eq!(judged(Meaning::Saturation, &values), Verdict::default());
        values[50] = -2.0;
        let once = judged(Meaning::Saturation, &values);
        assert!(!once.is_bad());
        assert!(
            once.to_string()
                .contains("0.50 % of the time, first at t = 50.000 s")
        );
        (values[60], values[70]) = (2.5, 3.0);
        assert!(judged(Meaning::Saturation, &values).is_bad());
    }

    #[test]
    fn a_supervisor_that_acts_is_noted_and_one_that_stops_spoils_a_run() {
        let of = |stages: &[f64]| {
            let mut limit = Limit::new("x".into(), "", Supervision, ACTS);
            for (k, stage) in (0..).zip(stages) {
                limit.add(f64::from(k), &[*stage]);
            }
            let mut verdict = Verdict::default();
            limit.judge(stages.len() as u64, &mut verdict);
            (verdict.to_string(), verdict.is_bad())
        };
        assert!(!of(&[1.0, 1.0]).0.contains("it "));
        assert!(!of(&[2.0, 2.0]).0.contains("it "));
        let (text, is_bad) = of(&[2.0, 3.0, 4.0]);
        assert!(
            text.contains("lowered the gains, first at t = 1.000 s") && !is_bad,
            "{text}"
        );
        let (text, is_bad) = of(&[2.0, 3.0, 4.0, 5.0, 7.0]);
        assert!(text.contains("stopped the machine") && is_bad, "{text}");
    }

    #[test]
    fn a_rating_is_never_to_be_exceeded_a_rated_mean_may_be_for_a_while() {
        let values = [0.0, 0.0, 0.0, 3.9];
        assert!(judged(Meaning::Rating, &values).is_bad());
        assert!(!judged(Meaning::RatedMean, &values).is_bad(), "1.95");
        assert!(
            judged(Meaning::RatedMean, &[0.0, 0.0, 0.0, 4.1]).is_bad(),
            "2.05"
        );
        assert!(!judged(Meaning::Rating, &[1.9]).is_bad());
    }

    #[test]
    fn what_counts_is_a_magnitude() {
        let of = |signals: Range<usize>, middle, values: &[f64]| {
            let limit = Limit::new("x".into(), "N", Meaning::Rating, 2.0);
            let limit = Limit {
                signals,
                middle,
                ..limit
            };
            limit.magnitude(values)
        };
        assert_eq!(of(0..2, 0.0, &[-3.0, 4.0]), 5.0);
        assert_eq!(of(0..1, 0.3, &[0.1]), 0.3 - 0.1);
        assert_eq!(of(1..2, 0.0, &[7.0, -1.0]), 1.0);
    }
}
