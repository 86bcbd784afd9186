//! Whether motors and actuators fit what they do: root mean squares and peaks beside ratings, torque over speed under the continuous and the
//! peak envelope, temperatures over an hour of repetitions, and how power, force, energy and efficiency follow the payload at the tip.
#![allow(non_snake_case)] // symbols of the equations

mod motor;
mod payload;
mod text;

pub use motor::Motor;
pub use payload::{Metrics, Sensitivity};
pub(crate) use text::WINDING_LIMIT;
pub use text::write_csv;

use anyhow::{Context, Result, ensure};
use cosim::master::instantiate;
use cosim::run::Experiment;
use cosim::slave::At;
use cosim::system::System;
use cosim::wiring::Port;
use machine::{Machine, Ratings};
use serde::Serialize;

use crate::duty::{Cycle, Network, Temperatures};
use crate::energy;
use crate::experiment::Recorded;
use crate::machine_file::MachineFile;

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
/// Part of an envelope by which a sample may lie above it: sampling of current and voltage.
const SLACK: f64 = 0.01;

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
    /// What the actuator is rated for.
    pub ratings: Ratings,
    /// Envelopes' constants.
    pub motor: Motor,
    /// Motor speed, rad/s, and torque, N·m, over the motion, thinned.
    #[serde(skip)]
    pub points: Vec<(f64, f64)>,
}

/// All axes of one case.
#[derive(Clone, Debug, Serialize)]
pub struct Sizing {
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
    let machine = MachineFile::of(system, &experiment.settings)?.machine;
    let actuators = energy::actuators(system);
    ensure!(!actuators.is_empty(), "no component is an actuator");
    let recorded = recorded(system, experiment, &actuators)?;
    let lowest = lowest_voltage(system, &recorded)?;
    let mut axes = Vec::new();
    for k in &actuators {
        let columns = columns(system, &recorded, *k)?;
        let ratings = ratings_of(system, experiment, *k, axes.len(), &machine)?;
        axes.push(axis(system, experiment, *k, &columns, lowest, &ratings)?);
    }
    let mut by_payload = Vec::new();
    if payload_step != 0.0 {
        by_payload = payload::sensitivity(system, experiment, &actuators, &recorded, payload_step)?;
    }
    Ok(Sizing {
        axes,
        payload: by_payload,
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

/// Ratings of actuator `k`: of the axis that its parameter `axis` names; without one, of the place that it has among the actuators.
fn ratings_of(
    system: &System,
    experiment: &Experiment,
    k: usize,
    place: usize,
    machine: &Machine,
) -> Result<Ratings> {
    let index = match given(system, experiment, k, ["axis"])? {
        Some([axis]) => axis as usize - 1,
        None => place,
    };
    let ratings = machine.ratings.in_order();
    ensure!(
        index < ratings.len(),
        "the machine has ratings for {} actuators, but there are more",
        ratings.len()
    );
    Ok(*ratings[index])
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
        ratings: *ratings,
        motor,
        points: both().map(|(tau, w)| (w, tau)).step_by(stride).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_root_mean_square_and_peak() {
        let size = Size::of([3.0, -4.0, 0.0, 5.0].into_iter());
        assert_eq!((size.rms, size.peak), (12.5_f64.sqrt(), 5.0));
        assert_eq!(Size::of(std::iter::empty()), Size::default());
    }
}
