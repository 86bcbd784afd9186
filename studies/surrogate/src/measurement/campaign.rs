//! The campaign of runs on the rig: profiles to train on, held-out profiles, rows of data and their
//! errors. For the commands, the judgement, `report` and `experiments`.

use anyhow::Result;
use emla::maps;
use machine_file::Emla;
use rayon::prelude::*;

use crate::measurement::data::Row;
use crate::measurement::profile::Kind::{self, Creep, Steps, Strokes, Sweep, Work};
use crate::measurement::profile::Profile;
use crate::measurement::rig_run::run;
use crate::measurement::windows::{Window, windows};

/// Number of the campaign's profiles.
pub const PROFILES: u32 = 480;
/// Length of each, s.
pub const SECONDS: f64 = 3.0;
/// Kinds of the campaign's profiles, in turn. [`Kind::Work`] is held out.
const TRAINING: [Kind; 5] = [Steps, Sweep, Strokes, Steps, Creep];
const HELD_OUT: [Kind; 6] = [Steps, Sweep, Strokes, Creep, Work, Work];
/// Temperatures at which the campaign's profiles begin, K.
const TRAINING_T: [f64; 4] = [278.0, 298.0, 328.0, 358.0];
/// Temperatures at which the held-out profiles begin, K.
const HELD_OUT_T: [f64; 5] = [288.0, 313.0, 343.0, 303.0, 328.0];

/// The profiles to train on.
pub fn training_profiles(count: u32, seconds: f64, seed: u64) -> Vec<Profile> {
    profiles(&TRAINING, &TRAINING_T, count, seconds, seed)
}

/// Profiles that are never trained on, of each kind in turn; their seeds lie beyond those of any
/// campaign.
pub fn held_out_profiles(count: u32, seconds: f64, seed: u64) -> Vec<Profile> {
    profiles(&HELD_OUT, &HELD_OUT_T, count, seconds, seed ^ (1 << 40))
}

fn profiles(kinds: &[Kind], T: &[f64], count: u32, seconds: f64, seed: u64) -> Vec<Profile> {
    (0..count as usize)
        .map(|k| Profile {
            kind: kinds[k % kinds.len()],
            seed: (seed << 16) + k as u64,
            seconds,
            T: T[k % T.len()],
        })
        .collect()
}

/// Runs the profiles on the rig, and returns the windows of each; `sensor_seed` draws a profile's
/// sensor errors.
pub fn measure(
    p: &Emla,
    profiles: &[Profile],
    sensor_seed: impl Fn(&Profile) -> u64 + Sync,
) -> Result<Vec<Vec<Window>>> {
    profiles
        .par_iter()
        .map(|profile| Ok(windows(p, &run(profile, sensor_seed(profile))?)))
        .collect()
}

/// Runs the whole campaign of `seed`.
pub fn training_campaign(p: &Emla, seed: u64) -> Result<Vec<Vec<Window>>> {
    let profiles = training_profiles(PROFILES, SECONDS, seed);
    measure(p, &profiles, |profile| profile.seed)
}

/// Compliance c between nut and rod, m/N: the least squares of `travel·w_m − ẋ = c Ḟ` over a
/// campaign.
pub fn compliance(p: &Emla, campaign: &[Vec<Window>]) -> f64 {
    let travel = maps::travel_per_radian(p);
    let all = || campaign.iter().flatten();
    let moved: f64 = all()
        .map(|w| w.F_dot * (travel * w.row.w_m - w.row.x_dot))
        .sum();
    moved / all().map(|w| w.F_dot * w.F_dot).sum::<f64>()
}

/// Rows of a campaign, and the number of each one's profile. Their torque is computed with the
/// magnets of `p`. The speed in a row is the nut's, not the rod's: the rod's plus compliance · Ḟ.
/// So rows under changing and under steady load lie on one map.
pub fn rows(p: &Emla, campaign: &[Vec<Window>]) -> (Vec<Row>, Vec<u32>) {
    let compliance = compliance(p, campaign);
    let row = |w: &Window| Row {
        x_dot: w.row.x_dot + compliance * w.F_dot,
        tau_e: w.torque(p),
        ..w.row
    };
    let numbered = (0_u32..).zip(campaign);
    numbered
        .flat_map(|(k, windows)| windows.iter().map(move |w| (row(w), k)))
        .unzip()
}

/// Root mean square of the force error of a row, N, that even a perfect map leaves; a torque error
/// is converted to force.
#[derive(Clone, Copy, Debug)]
pub struct RowErrors {
    /// Relative to the true values: the sensors' noise floor.
    pub floor: f64,
    /// Between two runs of a profile with different sensor errors, divided by √2.
    pub repeatability: f64,
}

impl RowErrors {
    /// The errors of a campaign; `again` is a second run of its first profiles.
    pub fn new(p: &Emla, campaign: &[Vec<Window>], again: &[Vec<Window>]) -> Self {
        let per_torque = 1.0 / maps::travel_per_radian(p);
        let inertia = maps::inertia(p, 1.0);
        let all = || campaign.iter().flatten();
        let floor = rms(all().map(|w| {
            let tau = w.truth.tau_e - inertia * w.truth.motion.w_m_dot;
            w.row.f_ext - w.truth.motion.F - per_torque * (w.row.tau_e - tau)
        }));
        let pairs = campaign.iter().zip(again).flat_map(|(a, b)| {
            a.iter()
                .flat_map(move |a| b.iter().find(|b| b.t == a.t).map(|b| (a, b)))
        });
        let difference = rms(pairs
            .map(|(a, b)| a.row.f_ext - b.row.f_ext - per_torque * (a.row.tau_e - b.row.tau_e)));
        Self {
            floor,
            repeatability: difference / 2.0_f64.sqrt(),
        }
    }
}

/// Root mean square; NaN of nothing.
pub fn rms(errors: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = errors.fold((0.0, 0.0), |(sum, count), e| (sum + e * e, count + 1.0));
    f64::sqrt(sum / count)
}
