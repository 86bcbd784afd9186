//! One axis compared with its ratings, for the sizing `study`: RMS, peaks, torque, temperatures.
#![allow(non_snake_case)] // symbols of the equations

use std::f64::consts::TAU;

use anyhow::{Context, Result};
use cosim::io::numbers::short;
use cosim::{Experiment, System, Verdict};
use machine_file::{Heat, Ratings};
use serde::Serialize;

use super::motor::Motor;
use super::recorded::{Columns, Size, start_values};
use crate::measures::heat::{Cycle, HeatNetwork, Temperatures};

/// Time over which the cycle is repeated, s.
const HOUR: f64 = 3600.0;
/// Part of the peak torque by which a sample may exceed the peak envelope: current and voltage are
/// sampled.
const SLACK: f64 = 0.01;

/// The number with five significant digits.
fn five_digits(number: f64) -> String {
    short(format!("{number:.4e}").parse().unwrap_or(number))
}

/// Winding temperature that insulation of class F withstands (IEC 60085: 155 °C), K.
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
    /// Continuous torque at the root mean square of the speed, N·m.
    pub continuous: f64,
    /// Share of the time in which the torque drives beyond the peak envelope.
    pub beyond_peak: f64,
    /// Temperatures after an hour of repetitions.
    pub temperatures: Temperatures,
    /// Whether the actuator has heat capacities and resistances of its own.
    pub is_own_heat: bool,
    /// What the actuator is rated for.
    pub ratings: Ratings,
    /// Constants of the envelopes.
    pub motor: Motor,
    /// Motor speed, rad/s, and torque, N·m, over the motion, thinned.
    #[serde(skip)]
    pub points: Vec<(f64, f64)>,
}

impl Axis {
    /// Evaluates actuator `k`; `lowest` is the least voltage of the link that feeds it, V, where a
    /// component reports it.
    pub(super) fn new(
        system: &System,
        experiment: &Experiment,
        k: usize,
        columns: &Columns,
        lowest: Option<f64>,
        ratings: &Ratings,
    ) -> Result<Self> {
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
        let [p, R_s, L_q, lambda_m, i_max, v_max, v_dc] =
            start_values(system, experiment, k, names)?
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
        let [tau, w, i_d, i_q, F, copper, core, ..] = columns.values;
        let both = || tau.iter().copied().zip(w.iter().copied());
        let speed = Size::new(w.iter().copied());
        let drives_beyond = |(tau, w): &(f64, f64)| {
            tau * w > 0.0 && tau.abs() > motor.peak(*w) + SLACK * motor.peak(0.0)
        };
        let heat = ["C_w", "R_wh", "C_h", "R_ha"].map(|name| format!("heat.{name}"));
        let [C_w, R_wh, C_h, R_ha] = heat.each_ref().map(String::as_str);
        let network = start_values(system, experiment, k, [C_w, R_wh, C_h, R_ha, "T_ambient"])?;
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
        Ok(Self {
            actuator: name.clone(),
            torque: Size::new(tau.iter().copied()),
            speed,
            current: Size::new(i_d.iter().zip(i_q).map(|(d, q)| d.hypot(*q))),
            force: Size::new(F.iter().copied()),
            power: Size::new(both().map(|(tau, w)| tau * w)),
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

    /// The rows of the table: name, unit, value, rating where there is one.
    pub(crate) fn rows(&self) -> [(&'static str, &'static str, f64, Option<f64>); 16] {
        let Self { ratings, .. } = self;
        let rpm = 60.0 / TAU;
        let t = &self.temperatures;
        let free = |name, unit, value| (name, unit, value, None);
        let rated = |name, unit, value, rating| (name, unit, value, Some(rating));
        let lasting = 100.0 * self.torque.rms / self.continuous.max(1e-9);
        let force = 100.0 * self.force.peak / ratings.force_max;
        let beyond = 100.0 * self.beyond_peak;
        let [greatest, limit, winding, housing] =
            [t.winding_max, WINDING_LIMIT, t.winding, t.housing].map(|T| T - 273.15);
        let (top, stall) = (rpm * self.speed.peak, self.motor.peak(0.0));
        let [torque, current] = [self.torque, self.current];
        let i_max = self.motor.current;
        [
            rated("motor torque, rms", "N.m", torque.rms, self.continuous),
            rated("motor torque, peak", "N.m", torque.peak, stall),
            free("motor speed, rms", "rpm", rpm * self.speed.rms),
            rated("motor speed, peak", "rpm", top, ratings.motor_speed_rpm),
            rated("motor power, rms", "W", self.power.rms, ratings.motor_power),
            free("motor power, peak", "W", self.power.peak),
            free("phase current, rms of the peak value", "A", current.rms),
            rated("phase current, peak", "A", current.peak, i_max),
            free("rod force, rms", "N", self.force.rms),
            rated("rod force, peak", "N", self.force.peak, ratings.force_max),
            rated("torque rms of what may last", "%", lasting, 100.0),
            rated("rod force peak of the rating", "%", force, 100.0),
            rated("beyond the peak envelope, of the time", "%", beyond, 0.0),
            rated("winding, greatest in an hour", "degC", greatest, limit),
            free("winding after an hour", "degC", winding),
            free("housing after an hour", "degC", housing),
        ]
    }

    /// Makes the verdict bad for each rating that is exceeded.
    pub(super) fn judge(&self, verdict: &mut Verdict) {
        for (name, unit, value, rating) in self.rows() {
            if let Some(rating) = rating
                && value > rating
            {
                verdict.object(format!(
                    "{}: {name} = {} {unit}, more than {} {unit}",
                    self.actuator,
                    five_digits(value),
                    five_digits(rating)
                ));
            }
        }
    }
}
