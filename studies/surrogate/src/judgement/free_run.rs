//! Judges models on whole held-out profiles in free-running simulation, for `surrogate compare`: a
//! model is given a temperature at the start and the desired speeds and loads, and predicts
//! current, losses, temperatures and energy. `surrogate calibrate` uses the profiles as driven.

use anyhow::Result;
use emla::maps;
use machine_file::{Emla, Heat};
use rayon::prelude::*;

use crate::judgement::resampling::bootstrap;
use crate::measurement::profile::{Desired, Profile, SAMPLE};
use crate::measurement::rig_run::run;
use crate::measurement::windows::{
    Motion, SAMPLES, Window, data_sheet, mean, steady_torque, windows,
};
use crate::prediction::model::{EFFICIENCY_SPEED, Model};

/// Samples on either side over which the desired acceleration is averaged, so that changes within a
/// window do not show.
const AROUND: usize = SAMPLES / 2;

/// Measured force, N, below which both powers are too small for a meaningful efficiency.
const EFFICIENCY_FORCE: f64 = 5e3;

/// A profile driven on the rig.
pub struct DrivenProfile {
    pub(crate) profile: Profile,
    pub(crate) windows: Vec<Window>,
    /// Energy taken from the DC side, J.
    energy: f64,
    /// Integral of the power's magnitude at the nut, J: the reference for errors of the energy.
    moved: f64,
}

/// Drives the profiles on the rig; the sensors of each have its own seed.
pub fn drive(p: &Emla, profiles: &[Profile]) -> Result<Vec<DrivenProfile>> {
    let drive = |profile: &Profile| {
        let run = run(profile, profile.seed)?;
        let travel = maps::travel_per_radian(p);
        let [first, last] = [&run[0].truth, &run[run.len() - 1].truth];
        let power = run.iter().map(|s| (s.truth.F * travel * s.truth.w_m).abs());
        Ok(DrivenProfile {
            profile: *profile,
            windows: windows(p, &run),
            energy: last.E_in - first.E_in,
            moved: SAMPLE * power.skip(1).sum::<f64>(),
        })
    };
    profiles.par_iter().map(drive).collect()
}

/// A model's prediction at one sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample {
    /// Quadrature current, A.
    pub i_q: f64,
    /// Power at the nut, W.
    pub P_out: f64,
    /// Power lost, W.
    pub P_loss: f64,
    /// Power from the DC side, W.
    pub P_in: f64,
    /// Temperature of the housing, K.
    pub T_housing: f64,
}

/// Simulates a model along desired speeds and loads, starting at the temperature `T`, K, in air of
/// the data sheet's reference temperature, with the data sheet's thermal parameters.
/// ```text
/// C_w Ṫ_w = P_copper − (T_w − T_h)/R_wh,   C_h Ṫ_h = P_mech + (T_w − T_h)/R_wh − (T_h − T_air)/R_ha
/// ```
/// The motor follows the desired speed exactly. All electrical losses heat the winding.
pub fn simulate(model: &Model, desired: &[Desired], T: f64) -> Vec<Sample> {
    let p = model.params();
    let (travel, inertia) = (maps::travel_per_radian(p), maps::inertia(p, 1.0));
    let heat = p.heat.unwrap_or(Heat::TYPICAL);
    let air = data_sheet(p).reference;
    let mut T = [T; 2];
    let last = desired.len() - 1;
    (0..desired.len())
        .map(|k| {
            // The state at sample k belongs to the desired value of the step before it.
            let at = |k: usize| &desired[(k + 1).min(last)];
            let (before, after) = (k.saturating_sub(AROUND), k + AROUND);
            let rise = (at(after).x_dot - at(before).x_dot) / ((after - before) as f64 * SAMPLE);
            let motion = Motion {
                F: at(k).load,
                w_m: at(k).x_dot / travel,
                w_m_dot: rise / travel,
                T,
            };
            let demand = model.demand(&motion);
            let P_out = motion.F * at(k).x_dot;
            let friction = demand.tau * motion.w_m - P_out;
            let stored = inertia * motion.w_m_dot * motion.w_m;
            let sample = Sample {
                i_q: demand.i_q,
                P_out,
                P_loss: friction + demand.electrical,
                P_in: demand.tau * motion.w_m + stored + demand.electrical,
                T_housing: T[1],
            };
            let over = (T[0] - T[1]) / heat.R_wh;
            T[0] += SAMPLE / heat.C_w * (demand.electrical - over);
            T[1] += SAMPLE / heat.C_h * (friction + over - (T[1] - air) / heat.R_ha);
            sample
        })
        .collect()
}

/// Errors of a model over one profile.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    /// In the order of [`QUANTITIES`]: mean squares over windows of current, A², force by the
    /// measured current and speed, N², and efficiency, NaN where no window counts; and the square
    /// of the error of the energy from the DC side over the energy moved at the nut.
    squares: [f64; 4],
}

/// The quantities that are judged, with the unit they are printed in and the factor to it.
pub const QUANTITIES: [(&str, f64); 4] = [
    ("current, A", 1.0),
    ("force, N", 1.0),
    ("efficiency, %", 1e2),
    ("energy, %", 1e2),
];

impl Errors {
    /// The errors of a model that knows the temperature at the start, or assumes the data sheet's.
    pub(crate) fn new(model: &Model, driven: &DrivenProfile, knows_temperature: bool) -> Self {
        let p = model.params();
        let travel = maps::travel_per_radian(p);
        let start = if knows_temperature {
            driven.profile.T
        } else {
            data_sheet(p).reference
        };
        let course = simulate(model, &driven.profile.desired(), start);
        let (mut sums, mut counts) = ([0.0; 3], [0.0; 3]);
        let mut add = |k: usize, error: f64| {
            sums[k] += error * error;
            counts[k] += 1.0;
        };
        for w in &driven.windows {
            let mean = |value: fn(&Sample) -> f64| mean(w.first, |k| value(&course[k]));
            add(0, mean(|s| s.i_q) - w.truth.i_q);
            let i = [w.row.i_d, w.row.i_q];
            let tau = steady_torque(p, i, mean(|s| s.T_housing), w.w_m_dot);
            add(1, model.force(tau, w.row.w_m) - w.truth.motion.F);
            let slower = w.row.x_dot.abs().min(travel * w.row.w_m.abs());
            let counts = slower > EFFICIENCY_SPEED && w.row.f_ext.abs() > EFFICIENCY_FORCE;
            if let Some(truth) = w.truth.efficiency().filter(|_| counts) {
                let (out, loss) = (mean(|s| s.P_out), mean(|s| s.P_loss));
                add(2, rig::efficiency(out, loss, out) - truth);
            }
        }
        let energy = SAMPLE * course.iter().skip(1).map(|s| s.P_in).sum::<f64>();
        let energy_error = (energy - driven.energy) / driven.moved;
        let [current, force, efficiency] = [0, 1, 2].map(|k: usize| sums[k] / counts[k]);
        Self {
            squares: [current, force, efficiency, energy_error * energy_error],
        }
    }
}

/// Root of the mean, over the profiles of these indices, of a quantity's mean squares; profiles
/// without windows for it are left out.
fn root_mean_square(errors: &[Errors], profiles: &[usize], quantity: usize) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for square in profiles.iter().map(|&k| errors[k].squares[quantity]) {
        if square.is_finite() {
            (sum, count) = (sum + square, count + 1.0);
        }
    }
    f64::sqrt(sum / count)
}

/// Root mean square of a quantity's errors over profiles, of [`QUANTITIES`], with its 95 %
/// interval.
pub(crate) fn overall(errors: &[Errors], quantity: usize) -> [f64; 3] {
    let value = |profiles: &[usize]| root_mean_square(errors, profiles, quantity);
    bootstrap(errors.len(), value)
}

/// The same divided by that of another model on the same profiles, which are drawn together.
pub(crate) fn ratio(errors: &[Errors], other: &[Errors], quantity: usize) -> [f64; 3] {
    bootstrap(errors.len(), |profiles| {
        root_mean_square(errors, profiles, quantity) / root_mean_square(other, profiles, quantity)
    })
}
