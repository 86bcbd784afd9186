//! One axis beside what it is rated for: root mean squares, peaks, envelopes, temperatures.
#![allow(non_snake_case)] // symbols of the equations

use std::f64::consts::TAU;

use anyhow::{Context, Result};
use cosim::{Experiment, System, Verdict};
use machine_file::{Heat, Ratings};
use serde::Serialize;

use super::motor::Motor;
use super::recorded::{Columns, Size, parameters_of};
use crate::measures::heat::{Cycle, HeatNetwork, Temperatures};

/// Time over which the cycle is repeated, s.
pub const HOUR: f64 = 3600.0;
/// Part of an envelope by which a sample may lie above it: sampling of current and voltage.
const SLACK: f64 = 0.01;

/// Winding temperature that insulation of class F stands (IEC 60085: 155 °C), K.
pub const WINDING_LIMIT: f64 = 428.15;

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

pub(super) fn axis(
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
    let [p, R_s, L_q, lambda_m, i_max, v_max, v_dc] = parameters_of(system, experiment, k, names)?
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
    let network = parameters_of(
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
    let own = network.map(|[C_w, R_wh, C_h, R_ha, ambient]| {
        let heat = Heat {
            C_w,
            R_wh,
            C_h,
            R_ha,
        };
        HeatNetwork { heat, ambient }
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
        temperatures: own
            .unwrap_or(HeatNetwork::TYPICAL)
            .temperatures_after(&cycle, HOUR),
        is_own_heat: own.is_some(),
        ratings: *ratings,
        motor,
        points: both().map(|(tau, w)| (w, tau)).step_by(stride).collect(),
    })
}

impl Axis {
    /// What is told of it: name, unit, value, rating where there is one.
    pub fn rows(&self) -> [(&'static str, &'static str, f64, Option<f64>); 16] {
        let Self { ratings, .. } = self;
        let rpm = 60.0 / TAU;
        let t = &self.temperatures;
        let of = |name, unit, value| (name, unit, value, None);
        let rated = |name, unit, value, rating| (name, unit, value, Some(rating));
        let lasting = 100.0 * self.torque.rms / self.continuous.max(1e-9);
        let force = 100.0 * self.force.peak / ratings.force_max;
        let beyond = 100.0 * self.beyond_peak;
        let [greatest, limit, winding, housing] =
            [t.winding_max, WINDING_LIMIT, t.winding, t.housing].map(|T| T - 273.15);
        let top = rpm * self.speed.peak;
        [
            rated("motor torque, rms", "N.m", self.torque.rms, self.continuous),
            rated(
                "motor torque, peak",
                "N.m",
                self.torque.peak,
                self.motor.peak(0.0),
            ),
            of("motor speed, rms", "rpm", rpm * self.speed.rms),
            rated("motor speed, peak", "rpm", top, ratings.motor_speed_rpm),
            rated("motor power, rms", "W", self.power.rms, ratings.motor_power),
            of("motor power, peak", "W", self.power.peak),
            of(
                "phase current, rms of the peak value",
                "A",
                self.current.rms,
            ),
            rated(
                "phase current, peak",
                "A",
                self.current.peak,
                self.motor.current,
            ),
            of("rod force, rms", "N", self.force.rms),
            rated("rod force, peak", "N", self.force.peak, ratings.force_max),
            rated("torque rms of what may last", "%", lasting, 100.0),
            rated("rod force peak of the rating", "%", force, 100.0),
            rated("beyond the peak envelope, of the time", "%", beyond, 0.0),
            rated("winding, greatest in an hour", "degC", greatest, limit),
            of("winding after an hour", "degC", winding),
            of("housing after an hour", "degC", housing),
        ]
    }

    /// Objects to what is beyond a rating.
    pub fn judge(&self, verdict: &mut Verdict) {
        for (name, unit, value, rating) in self.rows() {
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
