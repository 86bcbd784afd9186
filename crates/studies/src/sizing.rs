//! Whether motors and actuators fit what they do: root mean squares and peaks beside ratings, torque over speed under the continuous and the
//! peak envelope, temperatures over an hour of repetitions, and how power, force, energy and efficiency follow the payload at the tip.
#![allow(non_snake_case)] // symbols of the equations

use std::f64::consts::TAU;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use cosim::master::instantiate;
use cosim::run::Experiment;
use cosim::slave::At;
use cosim::system::System;
use cosim::verdict::Verdict;
use cosim::wiring::Port;
use machine::Ratings;
use serde::Serialize;

use crate::duty::{Cycle, Network, Temperatures};
use crate::energy;
use crate::experiment::{Recorded, over};
use crate::machine_file::MachineFile;
use crate::report::chart::{Curve, Figure, Panel, wheel};

/// Outputs of an actuator that are recorded.
const OUTPUTS: [&str; 9] = [
    "tau_e",
    "w_m",
    "i_d",
    "i_q",
    "F",
    "loss.copper",
    "loss.core",
    "energy.in",
    "energy.out",
];
/// Time over which the cycle is repeated, s.
pub const HOUR: f64 = 3600.0;
/// Winding temperature that insulation of class F stands (IEC 60085: 155 °C), K.
const WINDING_LIMIT: f64 = 428.15;
/// Part of an envelope by which a sample may lie above it: sampling of current and voltage.
const SLACK: f64 = 0.01;

/// What the envelopes are made of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Motor {
    /// Pole pairs.
    pub pole_pairs: f64,
    /// Stator resistance, Ω.
    pub resistance: f64,
    /// Quadrature-axis inductance, H.
    pub inductance: f64,
    /// Flux linkage of the magnets, Wb.
    pub flux: f64,
    /// Largest current, peak, A.
    pub current: f64,
    /// Largest voltage, peak, V: the least of `v_max` and of what the DC link leaves, v_dc/√3.
    pub voltage: f64,
}

impl Motor {
    /// Largest torque at the motor speed `w`, rad/s, N·m, without current in the direct axis: of the current limit, and of the voltage limit
    /// `(R i + ω_e λ)² + (ω_e L_q i)² = v²`. 0 beyond the speed at which the voltage induced is the largest.
    pub fn peak(&self, w: f64) -> f64 {
        let w_e = self.pole_pairs * w.abs();
        let (R, X, induced) = (self.resistance, w_e * self.inductance, w_e * self.flux);
        let (square, cross) = (R * R + X * X, R * induced);
        let left = self.voltage * self.voltage - induced * induced;
        let i = ((cross * cross + square * left).max(0.0).sqrt() - cross) / square;
        1.5 * self.pole_pairs * self.flux * i.clamp(0.0, self.current)
    }

    /// Torque that may last at the motor speed `w`, rad/s, N·m: the rated torque up to the rated power, under the peak.
    pub fn continuous(&self, w: f64, ratings: &Ratings) -> f64 {
        let by_power = ratings.motor_power / w.abs().max(1e-9);
        ratings.motor_torque.min(by_power).min(self.peak(w))
    }
}

/// Root mean square and greatest magnitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Size {
    /// Root mean square.
    pub rms: f64,
    /// Greatest magnitude.
    pub peak: f64,
}

impl Size {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut squares, mut count, mut peak) = (0.0, 0.0, 0.0_f64);
        for value in values {
            squares += value * value;
            count += 1.0;
            peak = peak.max(value.abs());
        }
        let rms = if count > 0.0 {
            f64::sqrt(squares / count)
        } else {
            0.0
        };
        Self { rms, peak }
    }
}

/// One axis over the motion.
#[derive(Clone, Debug, Serialize)]
pub struct Axis {
    /// Component.
    pub actuator: String,
    /// Motor torque, N·m.
    pub torque: Size,
    /// Motor speed, rad/s.
    pub speed: Size,
    /// Phase current (peak value of the sine), A.
    pub current: Size,
    /// Rod force, N.
    pub force: Size,
    /// Mechanical power of the motor, W.
    pub power: Size,
    /// Torque that may last at the root mean square of the speed, N·m.
    pub continuous: f64,
    /// Share of the time in which the torque drives beyond the peak envelope.
    pub beyond_peak: f64,
    /// Temperatures after an hour of repetitions.
    pub temperatures: Temperatures,
    /// Whether the actuator itself tells of its heat capacities and resistances.
    pub is_own_heat: bool,
    /// Envelopes' constants.
    pub motor: Motor,
    /// Motor speed, rad/s, and torque, N·m, over the motion, thinned.
    #[serde(skip)]
    pub points: Vec<(f64, f64)>,
}

/// What the metrics of arXiv 2409.16186 are for one actuator, over the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Metrics {
    /// Root mean square of the power delivered to the load, W.
    pub power: f64,
    /// Root mean square of the rod force, N.
    pub force: f64,
    /// Electrical energy, taken less given back, J.
    pub energy: f64,
    /// Work over electrical energy while work is done.
    pub efficiency: f64,
}

/// How the metrics follow the payload.
#[derive(Clone, Debug, Serialize)]
pub struct Sensitivity {
    /// Component.
    pub actuator: String,
    /// At the payload as it is.
    pub metrics: Metrics,
    /// Change per kilogram, by a central difference.
    pub per_kg: Metrics,
}

/// All axes of one case.
#[derive(Clone, Debug, Serialize)]
pub struct Sizing {
    /// Ratings that the axes are compared with.
    pub ratings: Ratings,
    /// The axes.
    pub axes: Vec<Axis>,
    /// By payload; empty where it was not varied.
    pub payload: Vec<Sensitivity>,
}

/// The recorded outputs of one actuator over the motion.
struct Columns<'a> {
    times: &'a [f64],
    values: Vec<&'a [f64]>,
    winding: &'a [f64],
}

/// Run the experiment, and twice more with the payload `payload_step`, kg, less and more where that is not 0.
pub fn run(system: &System, experiment: &Experiment, payload_step: f64) -> Result<Sizing> {
    let ratings = MachineFile::of(system, &experiment.settings)?
        .machine
        .ratings;
    let actuators = energy::actuators(system);
    ensure!(!actuators.is_empty(), "no component is an actuator");
    let recorded = recorded(system, experiment, &actuators)?;
    let lowest = lowest_voltage(system, &recorded)?;
    let mut axes = Vec::new();
    for k in &actuators {
        let columns = columns(system, &recorded, *k)?;
        axes.push(axis(system, experiment, *k, &columns, lowest, &ratings)?);
    }
    let mut payload = Vec::new();
    if payload_step != 0.0 {
        payload = sensitivity(system, experiment, &actuators, &recorded, payload_step)?;
    }
    Ok(Sizing {
        ratings,
        axes,
        payload,
    })
}

fn recorded(system: &System, experiment: &Experiment, actuators: &[usize]) -> Result<Recorded> {
    let mut ports = Vec::new();
    for k in actuators {
        for name in OUTPUTS {
            ports.push(system.port_of(*k, name)?);
        }
        ports.extend(system.port_of(*k, "T_winding").ok());
    }
    ports.extend(system.port("v_dc_mean")); // of what feeds them, if anything does
    Recorded::of(system, experiment, &ports)
}

fn columns<'a>(system: &System, recorded: &'a Recorded, k: usize) -> Result<Columns<'a>> {
    let of = |name: &str| recorded.motion(system.port_of(k, name)?);
    Ok(Columns {
        times: &recorded.recording.times[recorded.motion_start()..],
        values: OUTPUTS.iter().map(|name| of(name)).collect::<Result<_>>()?,
        winding: of("T_winding").unwrap_or_default(),
    })
}

/// Least voltage of the link over the motion, V, where a component tells it.
fn lowest_voltage(system: &System, recorded: &Recorded) -> Result<Option<f64>> {
    let Ok(port) = system.port("v_dc_mean") else {
        return Ok(None);
    };
    Ok(recorded.motion(port)?.iter().copied().reduce(f64::min))
}

/// Values of parameters or inputs of a component under the start values of `experiment`; None where it has not all of them.
fn given<const N: usize>(
    system: &System,
    experiment: &Experiment,
    k: usize,
    names: [&str; N],
) -> Result<Option<[f64; N]>> {
    let ports: Vec<Port> = names
        .iter()
        .filter_map(|n| system.port_of(k, n).ok())
        .collect();
    if ports.len() < N {
        return Ok(None);
    }
    let instance = instantiate(system, k, &experiment.settings)?;
    instance.enter_initialization(experiment.stepping.start)?;
    let mut found = [0.0; N];
    for (value, port) in found.iter_mut().zip(ports) {
        *value = instance.number(port.variable, At::Initialization)?;
    }
    Ok(Some(found))
}

fn axis(
    system: &System,
    experiment: &Experiment,
    k: usize,
    columns: &Columns,
    lowest: Option<f64>,
    ratings: &Ratings,
) -> Result<Axis> {
    let names = [
        "p",
        "R_s",
        "L_q",
        "lambda_m",
        "i_max",
        "v_max",
        "inverter.v_dc",
    ];
    let name = &system.structure.components[k].name;
    let [p, R_s, L_q, lambda_m, i_max, v_max, v_dc] = given(system, experiment, k, names)?
        .with_context(|| format!("{name} must have the parameters {}", names.join(", ")))?;
    let v_dc = lowest.unwrap_or(if v_dc > 0.0 { v_dc } else { f64::INFINITY });
    let motor = Motor {
        pole_pairs: p,
        resistance: R_s,
        inductance: L_q,
        flux: lambda_m,
        current: i_max,
        voltage: v_max.min(v_dc / 3.0_f64.sqrt()),
    };
    let [tau, w, i_d, i_q, F, copper, core] = [0, 1, 2, 3, 4, 5, 6].map(|n| columns.values[n]);
    let both = || tau.iter().copied().zip(w.iter().copied());
    let speed = Size::of(w.iter().copied());
    let drives_beyond = |(tau, w): &(f64, f64)| {
        tau * w > 0.0 && tau.abs() > motor.peak(*w) + SLACK * motor.peak(0.0)
    };
    let network = given(
        system,
        experiment,
        k,
        [
            "heat.C_w",
            "heat.R_wh",
            "heat.C_h",
            "heat.R_ha",
            "T_ambient",
        ],
    )?;
    let own = network.map(|[winding, inside, housing, outside, ambient]| Network {
        winding,
        inside,
        housing,
        outside,
        ambient,
    });
    let step = match columns.times {
        [first, .., last] => (last - first) / (columns.times.len() - 1) as f64,
        _ => experiment.stepping.step,
    };
    let cycle = Cycle {
        step,
        copper,
        winding: columns.winding,
        iron: core,
    };
    let stride = tau.len().div_ceil(2000).max(1);
    Ok(Axis {
        actuator: name.clone(),
        torque: Size::of(tau.iter().copied()),
        speed,
        current: Size::of(i_d.iter().zip(i_q).map(|(d, q)| d.hypot(*q))),
        force: Size::of(F.iter().copied()),
        power: Size::of(both().map(|(tau, w)| tau * w)),
        continuous: motor.continuous(speed.rms, ratings),
        beyond_peak: both().filter(drives_beyond).count() as f64 / tau.len().max(1) as f64,
        temperatures: own.unwrap_or(Network::TYPICAL).after(&cycle, HOUR),
        is_own_heat: own.is_some(),
        motor,
        points: both().map(|(tau, w)| (w, tau)).step_by(stride).collect(),
    })
}

/// The metrics of one actuator.
fn metrics(columns: &Columns) -> Metrics {
    let (taken, work) = (columns.values[7], columns.values[8]);
    let rates = |c: &[f64]| -> Vec<f64> {
        let steps = columns.times.windows(2).zip(c.windows(2));
        steps.map(|(t, e)| (e[1] - e[0]) / (t[1] - t[0])).collect()
    };
    let rise = |c: &[f64]| c[c.len() - 1] - c[0];
    let working = energy::while_working(taken, work);
    let (done, _) = energy::both_ways(work);
    Metrics {
        power: Size::of(rates(work).into_iter()).rms,
        force: Size::of(columns.values[4].iter().copied()).rms,
        energy: rise(taken),
        efficiency: if working > 0.0 { done / working } else { 0.0 },
    }
}

impl Metrics {
    /// Each of both numbers put through `f`.
    fn with(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            power: f(self.power, other.power),
            force: f(self.force, other.force),
            energy: f(self.energy, other.energy),
            efficiency: f(self.efficiency, other.efficiency),
        }
    }
}

/// Partial derivatives by the mass of the payload, which the manipulator carries and the controller does not know of.
fn sensitivity(
    system: &System,
    experiment: &Experiment,
    actuators: &[usize],
    as_it_is: &Recorded,
    step: f64,
) -> Result<Vec<Sensitivity>> {
    let mass = system.port("payload.mass")?;
    let [payload] = given(system, experiment, mass.component, ["payload.mass"])?
        .context("the manipulator must have a payload")?;
    ensure!(
        step > 0.0 && step <= payload,
        "the step of the payload, {step} kg, must be above 0 and at most the payload itself, {payload} kg"
    );
    let other = |mass: f64| {
        let setting = system.setting("payload.mass", mass)?;
        let experiment = over(system, experiment, vec![setting])?;
        recorded(system, &experiment, actuators)
    };
    let (less, more) = (other(payload - step)?, other(payload + step)?);
    let mut found = Vec::new();
    for k in actuators {
        let of = |recorded| Ok::<_, anyhow::Error>(metrics(&columns(system, recorded, *k)?));
        found.push(Sensitivity {
            actuator: system.structure.components[*k].name.clone(),
            metrics: of(as_it_is)?,
            per_kg: of(&more)?.with(of(&less)?, |more, less| (more - less) / (2.0 * step)),
        });
    }
    Ok(found)
}

impl Axis {
    /// What is told of it: name, unit, value, rating where there is one.
    fn rows(&self, ratings: &Ratings) -> [(&'static str, &'static str, f64, Option<f64>); 16] {
        let rpm = 60.0 / TAU;
        let t = &self.temperatures;
        [
            (
                "motor torque, rms",
                "N.m",
                self.torque.rms,
                Some(self.continuous),
            ),
            (
                "motor torque, peak",
                "N.m",
                self.torque.peak,
                Some(self.motor.peak(0.0)),
            ),
            ("motor speed, rms", "rpm", rpm * self.speed.rms, None),
            (
                "motor speed, peak",
                "rpm",
                rpm * self.speed.peak,
                Some(ratings.motor_speed_rpm),
            ),
            (
                "motor power, rms",
                "W",
                self.power.rms,
                Some(ratings.motor_power),
            ),
            ("motor power, peak", "W", self.power.peak, None),
            (
                "phase current, rms of the peak value",
                "A",
                self.current.rms,
                None,
            ),
            (
                "phase current, peak",
                "A",
                self.current.peak,
                Some(self.motor.current),
            ),
            ("rod force, rms", "N", self.force.rms, None),
            (
                "rod force, peak",
                "N",
                self.force.peak,
                Some(ratings.force_max),
            ),
            (
                "torque rms of what may last",
                "%",
                100.0 * self.torque.rms / self.continuous.max(1e-9),
                Some(100.0),
            ),
            (
                "rod force peak of the rating",
                "%",
                100.0 * self.force.peak / ratings.force_max,
                Some(100.0),
            ),
            (
                "beyond the peak envelope, of the time",
                "%",
                100.0 * self.beyond_peak,
                Some(0.0),
            ),
            (
                "winding, greatest in an hour",
                "degC",
                t.winding_max - 273.15,
                Some(WINDING_LIMIT - 273.15),
            ),
            ("winding after an hour", "degC", t.winding - 273.15, None),
            ("housing after an hour", "degC", t.housing - 273.15, None),
        ]
    }

    fn judge(&self, ratings: &Ratings, verdict: &mut Verdict) {
        for (name, unit, value, rating) in self.rows(ratings) {
            if let Some(rating) = rating
                && value > rating
            {
                verdict.object(format!(
                    "{}: {name} = {value:.4} {unit}, more than {rating:.4} {unit}",
                    self.actuator
                ));
            }
        }
    }
}

impl Sizing {
    /// What is beyond a rating.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        for axis in &self.axes {
            axis.judge(&self.ratings, &mut verdict);
        }
        verdict
    }

    /// The axes as a table for people.
    pub fn text(&self, title: &str) -> String {
        let mut text = format!("{title}\n{:<44}", "over the motion: value (rating)");
        text += &self
            .axes
            .iter()
            .map(|a| format!("{:>24}", a.actuator))
            .collect::<String>();
        text += "\n";
        let rows: Vec<_> = self.axes.iter().map(|a| a.rows(&self.ratings)).collect();
        for n in 0..rows.first().map_or(0, |r| r.len()) {
            text += &format!("{:<44}", format!("{}, {}", rows[0][n].0, rows[0][n].1));
            for row in &rows {
                let rating = row[n].3.map_or(String::new(), |r| format!(" ({r:.1})"));
                text += &format!("{:>24}", format!("{:.2}{rating}", row[n].2));
            }
            text += "\n";
        }
        if self.axes.iter().any(|a| !a.is_own_heat) {
            text += "temperatures by typical heat capacities and resistances: the actuators tell of none\n";
        }
        if !self.payload.is_empty() {
            text += "sensitivity to the payload at the tip, change per kilogram (value)\n";
            text += &format!(
                "{:<14}{:>26}{:>26}{:>26}{:>26}\n",
                "", "power rms, W/kg", "force rms, N/kg", "energy, J/kg", "efficiency, %/kg"
            );
            for s in &self.payload {
                let cell =
                    |slope: f64, value: f64| format!("{:>26}", format!("{slope:.4} ({value:.2})"));
                let (d, m) = (&s.per_kg, &s.metrics);
                text += &format!("{:<14}", s.actuator);
                text +=
                    &(cell(d.power, m.power) + &cell(d.force, m.force) + &cell(d.energy, m.energy));
                text += &(cell(100.0 * d.efficiency, 100.0 * m.efficiency) + "\n");
            }
        }
        text
    }
}

impl Axis {
    /// The motion's points and both envelopes over motor speed in rev/min.
    fn panel(&self, ratings: &Ratings) -> Panel {
        let rpm = 60.0 / TAU;
        let fastest = ratings.motor_speed_rpm.max(rpm * self.speed.peak) / rpm;
        let speeds = (-100..=100).map(|k| f64::from(k) * fastest / 100.0);
        let envelope = |of: &dyn Fn(f64) -> f64, sign: f64| {
            speeds
                .clone()
                .map(|w| (rpm * w, sign * of(w)))
                .collect::<Vec<_>>()
        };
        let peak = |w| self.motor.peak(w);
        let lasting = |w| self.motor.continuous(w, ratings);
        let points = self.points.iter().map(|(w, tau)| (rpm * w, *tau)).collect();
        Panel {
            x_label: "motor speed, rev/min".into(),
            y_label: format!("motor torque of {}, N.m", self.actuator),
            floor: None,
            curves: vec![
                Curve::new("peak", wheel(0, 3), envelope(&peak, 1.0)),
                Curve::new("peak, other way", wheel(0, 3), envelope(&peak, -1.0)),
                Curve::new("continuous", wheel(1, 3), envelope(&lasting, 1.0)),
                Curve::new(
                    "continuous, other way",
                    wheel(1, 3),
                    envelope(&lasting, -1.0),
                ),
                Curve::new("motion", wheel(2, 3), points),
            ],
        }
    }
}

impl Sizing {
    /// Torque over speed of each axis as PNG and SVG in `folder`; the files' names.
    pub fn draw(&self, case: &str, folder: &Path) -> Result<[PathBuf; 2]> {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        let panels = self.axes.iter().map(|axis| axis.panel(&self.ratings));
        let figure = Figure {
            name: format!("sizing_{}", case.replace(' ', "_")),
            title: format!("Torque and speed, {case} trajectory"),
            panels: panels.collect(),
        };
        figure.save(folder)
    }
}

/// A row of each quantity of each axis of each case.
pub fn write_csv(cases: &[(String, Sizing)], to: &mut impl Write) -> std::io::Result<()> {
    writeln!(to, "trajectory,actuator,quantity,unit,value,rating")?;
    for (case, sizing) in cases {
        for axis in &sizing.axes {
            for (name, unit, value, rating) in axis.rows(&sizing.ratings) {
                let rating = rating.map_or(String::new(), |r| r.to_string());
                writeln!(
                    to,
                    "{case},{},\"{name}\",{unit},{value},{rating}",
                    axis.actuator
                )?;
            }
        }
        for s in &sizing.payload {
            let d = &s.per_kg;
            for (name, unit, value) in [
                ("power rms by payload", "W/kg", d.power),
                ("force rms by payload", "N/kg", d.force),
                ("energy by payload", "J/kg", d.energy),
                ("efficiency by payload", "1/kg", d.efficiency),
            ] {
                writeln!(to, "{case},{},\"{name}\",{unit},{value},", s.actuator)?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOTOR: Motor = Motor {
        pole_pairs: 4.0,
        resistance: 0.4,
        inductance: 3e-3,
        flux: 0.12,
        current: 70.0,
        voltage: 300.0,
    };

    /// At each speed the peak torque's current meets the current or the voltage limit, by the voltage equation itself.
    #[test]
    fn the_peak_is_at_a_limit() {
        let mut by_voltage = 0;
        for k in 0..60 {
            let w = 10.0 * f64::from(k);
            let i = MOTOR.peak(w) / (1.5 * MOTOR.pole_pairs * MOTOR.flux);
            let w_e = MOTOR.pole_pairs * w;
            let v = (MOTOR.resistance * i + w_e * MOTOR.flux).hypot(w_e * MOTOR.inductance * i);
            assert!(i <= 70.0 && v <= 300.0 * (1.0 + 1e-12), "{w}: {i} {v}");
            assert!(i == 70.0 || (v / 300.0 - 1.0).abs() < 1e-12, "{w}: {i} {v}");
            by_voltage += u32::from(i < 70.0);
        }
        assert!(0 < by_voltage && by_voltage < 60);
        assert_eq!(MOTOR.peak(700.0), 0.0);
        assert_eq!(MOTOR.peak(-100.0), MOTOR.peak(100.0));
    }

    #[test]
    fn sizes_are_root_mean_square_and_peak() {
        let size = Size::of([3.0, -4.0, 0.0, 5.0].into_iter());
        assert_eq!((size.rms, size.peak), (12.5_f64.sqrt(), 5.0));
        assert_eq!(Size::of(std::iter::empty()), Size::default());
    }

    #[test]
    fn metrics_are_of_power_force_energy_and_efficiency() {
        let (idle, force) = ([0.0; 3], [2.0, -2.0, 2.0]);
        let (taken, work) = ([0.0, 8.0, 6.0], [0.0, 4.0, 3.0]);
        let columns = Columns {
            times: &[0.0, 2.0, 4.0],
            values: vec![
                &idle, &idle, &idle, &idle, &force, &idle, &idle, &taken, &work,
            ],
            winding: &[],
        };
        let expected = Metrics {
            power: (0.5 * (4.0 + 0.25_f64)).sqrt(),
            force: 2.0,
            energy: 6.0,
            efficiency: 0.5,
        };
        assert_eq!(metrics(&columns), expected);
    }
}
