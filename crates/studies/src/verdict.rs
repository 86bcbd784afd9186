//! What a run of the machine says of itself: what saturated and for what share of the time, which ratings were exceeded, whether the tip
//! error stayed below a bound, and whether there was a reference at all.

use anyhow::{Context, Result};
use cosim::system::System;
use cosim::verdict::Verdict;
use cosim::wiring::Port;
use fmu_description::Kind;

use crate::machine_file::MachineFile;
use crate::tip::TipError;

/// Share of the time from which on saturation spoils a run.
const SATURATED: f64 = 0.01;

/// How a value is made of the signals.
#[derive(Clone, Copy)]
enum Quantity {
    /// Magnitude of one.
    Magnitude(usize),
    /// Length of the vector of two.
    Length(usize, usize),
    /// Distance from the middle of a range.
    From(usize, f64),
}

/// What reaching a limit means.
#[derive(Clone, Copy, PartialEq)]
enum Meaning {
    /// The machine gives no more than this.
    Saturation,
    /// It can give more, but is not built for it at any time.
    Rating,
    /// It can give more, but is not built for it on average: the root mean square counts.
    RatedMean,
}

/// A limit and how the run came to it.
struct Limit {
    /// For people, with the unit of the limit.
    name: String,
    unit: &'static str,
    quantity: Quantity,
    meaning: Meaning,
    /// Largest value that is not yet beyond.
    limit: f64,
    worst: f64,
    beyond: u64,
    squares: f64,
    /// Time of the first sample beyond, s.
    since: f64,
}

/// Watches a run of the machine.
pub struct Watch {
    ports: Vec<Port>,
    limits: Vec<Limit>,
    samples: u64,
}

impl Watch {
    /// Of a system whose parameters have the values that `parameter` gives; the machine's limits come from the file that the manipulator
    /// runs with.
    pub fn new(
        system: &System,
        parameter: &dyn Fn(Port) -> Result<f64>,
        file: &MachineFile,
    ) -> Result<Self> {
        let machine = &file.machine;
        let (mut found, mut drives) = (Found::default(), 0);
        for k in 0..system.fmus.len() {
            let limits = ["v_max", "i_max"].map(|limit| system.port_of(k, limit));
            if let [Ok(v_max), Ok(i_max)] = limits {
                let name = &system.structure.components[k].name;
                let [v_max, i_max] = [parameter(v_max)?, parameter(i_max)?];
                let mut of =
                    |variable| Ok::<_, anyhow::Error>(found.index(system.port_of(k, variable)?));
                let voltage = Quantity::Length(of("v_d")?, of("v_q")?);
                let current = Quantity::Length(of("i_d")?, of("i_q")?);
                let [force, speed, torque] = ["F", "w_m", "tau_e"].map(of);
                let [force, speed, torque] = [force?, speed?, torque?].map(Quantity::Magnitude);
                // An actuator of another maker has no axis: in the order of the system.
                let axis = match system.port_of(k, "axis") {
                    Ok(axis) => parameter(axis)? as usize,
                    Err(_) => drives + 1,
                };
                drives += 1;
                let of_machine = machine.ratings.in_order();
                let ratings = of_machine
                    .get(axis.wrapping_sub(1))
                    .with_context(|| format!("`axis` of {name} = {axis} must be 1, 2 or 3"))?;
                let rpm = ratings.motor_speed_rpm * std::f64::consts::TAU / 60.0;
                use Meaning::{RatedMean, Rating, Saturation};
                found.limit(
                    format!("voltage of {name}"),
                    "V",
                    voltage,
                    Saturation,
                    v_max,
                );
                found.limit(
                    format!("current of {name}"),
                    "A",
                    current,
                    Saturation,
                    i_max,
                );
                found.limit(
                    format!("force of {name}"),
                    "N",
                    force,
                    Rating,
                    ratings.force_max,
                );
                found.limit(
                    format!("motor speed of {name}"),
                    "rad/s",
                    speed,
                    Rating,
                    rpm,
                );
                found.limit(
                    format!("motor torque of {name}"),
                    "N.m",
                    torque,
                    RatedMean,
                    ratings.motor_torque,
                );
            }
        }
        let arm = system.port("f_hold[1]")?.component;
        let limits = &machine.limits;
        let strokes = [limits.stroke_1, limits.stroke_2, limits.stroke_3];
        let rods = ["slew", "lift", "tilt"].into_iter().zip(strokes).zip(1..);
        let rods = rods.zip(machine.ratings.in_order());
        for (((rod, [min, max]), i), ratings) in rods {
            let x = found.index(system.port_of(arm, &format!("x[{i}]"))?);
            let stroke = Quantity::From(x, 0.5 * (min + max));
            let half = 0.5 * (max - min);
            found.limit(
                format!("stroke of {rod} from its middle"),
                "m",
                stroke,
                Meaning::Saturation,
                half,
            );
            let x_dot = found.index(system.port_of(arm, &format!("x_dot[{i}]"))?);
            let speed = Quantity::Magnitude(x_dot);
            found.limit(
                format!("rod speed of {rod}"),
                "m/s",
                speed,
                Meaning::Rating,
                ratings.rod_speed_max,
            );
        }
        for (i, max) in (1..).zip(limits.tau_wrist_max) {
            let torque = found.index(system.port_of(arm, &format!("tau_wrist[{i}]"))?);
            let torque = Quantity::Magnitude(torque);
            found.limit(
                format!("wrist torque {i}"),
                "N.m",
                torque,
                Meaning::Saturation,
                max,
            );
        }
        Ok(Self {
            ports: found.ports,
            limits: found.limits,
            samples: 0,
        })
    }

    /// The variables that it watches.
    pub fn ports(&self) -> &[Port] {
        &self.ports
    }

    /// Add their values, in the order of the ports, at the time `t`, s.
    pub fn add(&mut self, t: f64, values: &[f64]) {
        self.samples += 1;
        for limit in &mut self.limits {
            limit.add(t, values);
        }
    }

    /// What was seen so far.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        for limit in &self.limits {
            limit.judge(self.samples, &mut verdict);
        }
        verdict
    }
}

/// Limits and the signals that they need, while they are being collected.
#[derive(Default)]
struct Found {
    ports: Vec<Port>,
    limits: Vec<Limit>,
}

impl Found {
    fn index(&mut self, port: Port) -> usize {
        self.ports.push(port);
        self.ports.len() - 1
    }

    fn limit(
        &mut self,
        name: String,
        unit: &'static str,
        quantity: Quantity,
        meaning: Meaning,
        limit: f64,
    ) {
        self.limits
            .push(Limit::new(name, unit, quantity, meaning, limit));
    }
}

impl Quantity {
    fn of(self, values: &[f64]) -> f64 {
        match self {
            Self::Magnitude(k) => values[k].abs(),
            Self::Length(a, b) => values[a].hypot(values[b]),
            Self::From(k, middle) => (values[k] - middle).abs(),
        }
    }
}

impl Limit {
    fn new(
        name: String,
        unit: &'static str,
        quantity: Quantity,
        meaning: Meaning,
        limit: f64,
    ) -> Self {
        Self {
            name,
            unit,
            quantity,
            meaning,
            limit,
            worst: 0.0,
            beyond: 0,
            squares: 0.0,
            since: 0.0,
        }
    }

    /// Add the sample at time `t`, s.
    fn add(&mut self, t: f64, values: &[f64]) {
        let value = self.quantity.of(values);
        self.worst = self.worst.max(value);
        self.squares += value * value;
        if value >= self.limit {
            if self.beyond == 0 {
                self.since = t;
            }
            self.beyond += 1;
        }
    }

    #[expect(clippy::cast_precision_loss, reason = "2^53 steps are never reached")]
    fn judge(&self, samples: u64, verdict: &mut Verdict) {
        let Self {
            name, unit, worst, ..
        } = self;
        let limit = (1e4 * self.limit).round() / 1e4;
        if self.meaning == Meaning::RatedMean {
            let rms = (self.squares / samples.max(1) as f64).sqrt();
            if rms > self.limit {
                verdict.object(format!(
                    "{name}: root mean square {rms:.4} {unit}, more than the rated {limit} {unit}"
                ));
            }
            return;
        }
        if self.beyond == 0 {
            return;
        }
        let share = self.beyond as f64 / samples as f64;
        let when = format!(
            "for {:.2} % of the time, first at t = {:.3} s",
            100.0 * share,
            self.since
        );
        if self.meaning == Meaning::Rating {
            verdict.object(format!(
                "{name}: up to {worst:.4} {unit}, more than the rated {limit} {unit} {when}"
            ));
        } else if share > SATURATED {
            verdict.object(format!("{name}: at its limit of {limit} {unit} {when}"));
        } else {
            verdict.note(format!("{name}: at its limit of {limit} {unit} {when}"));
        }
    }
}

/// The tip error beside the bound that the user has set, m.
pub fn tracking(tip: &TipError, max_error: Option<f64>) -> Verdict {
    let mut verdict = Verdict::default();
    if let Some(bound) = max_error
        && tip.motion.max > bound
    {
        let (max, bound) = (1e3 * tip.motion.max, 1e3 * bound);
        verdict.object(format!(
            "tip error: up to {max:.4} mm, more than {bound} mm"
        ));
    }
    verdict
}

/// Whether the controller has a reference to follow where parameters have the values that `parameter` gives.
pub fn reference(system: &System, parameter: &dyn Fn(Port) -> Result<f64>) -> Result<Verdict> {
    let mut verdict = Verdict::default();
    let port = system.port("trajectory")?;
    let Kind::Enumeration(items) = &system.variable(port).kind else {
        return Ok(verdict);
    };
    let external = items.iter().find(|item| item.name == "external");
    let chosen = parameter(port)?;
    let wiring = system.wiring()?;
    let inputs = system.elements(port.component, "reference.position", 3)?;
    let is_driven = inputs
        .into_iter()
        .any(|input| wiring.driver(input).is_some());
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

    fn judged(meaning: Meaning, values: &[f64]) -> Verdict {
        let mut limit = Limit::new("x".into(), "N", Quantity::Magnitude(0), meaning, 2.0);
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
    fn quantities_are_magnitudes() {
        assert_eq!(Quantity::Length(0, 1).of(&[-3.0, 4.0]), 5.0);
        assert_eq!(Quantity::From(0, 0.3).of(&[0.1]), 0.3 - 0.1);
        assert_eq!(Quantity::Magnitude(0).of(&[-1.0]), 1.0);
    }

    #[test]
    fn the_largest_tip_error_is_compared_with_the_bound() {
        let mut tip = TipError::new(0.0);
        tip.add(1.0, 2e-3);
        assert!(!tracking(&tip, None).is_bad() && !tracking(&tip, Some(2e-3)).is_bad());
        assert!(tracking(&tip, Some(1.9e-3)).is_bad());
    }
}
