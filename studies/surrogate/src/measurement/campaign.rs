//! The campaign on the rig: profiles to train on, profiles held out, and how far its data can be
//! trusted.

use anyhow::Result;
use emla::maps;
use machine_file::Emla;
use rayon::prelude::*;

use crate::measurement::data::Row;
use crate::measurement::profile::{Kind, Profile};
use crate::measurement::rig_run::run;
use crate::measurement::windows::{Window, windows};

/// Number of the campaign's profiles, and the length of each, s.
pub const PROFILES: u32 = 480;
/// See [`PROFILES`].
pub const SECONDS: f64 = 3.0;
/// Kinds of the campaign's profiles, in turn. [`Kind::Work`] is not among them: what a network
/// knows of it, it knows from the others.
const TRAINING: [Kind; 5] = [
    Kind::Steps,
    Kind::Sweep,
    Kind::Strokes,
    Kind::Steps,
    Kind::Creep,
];
/// Kinds that are held out.
const HELD_OUT: [Kind; 6] = [
    Kind::Steps,
    Kind::Sweep,
    Kind::Strokes,
    Kind::Creep,
    Kind::Work,
    Kind::Work,
];
/// Temperatures at which the campaign's profiles begin, K.
const TRAINED_AT: [f64; 4] = [278.0, 298.0, 328.0, 358.0];
/// Those of the held-out profiles, K.
const HELD_OUT_AT: [f64; 5] = [288.0, 313.0, 343.0, 303.0, 328.0];

/// The profiles to train on.
pub fn training_profiles(count: u32, seconds: f64, seed: u64) -> Vec<Profile> {
    profiles(&TRAINING, &TRAINED_AT, count, seconds, seed)
}

/// Profiles that nothing was trained on, of each kind in turn; their seeds lie beyond those of any
/// campaign.
pub fn held_out_profiles(count: u32, seconds: f64, seed: u64) -> Vec<Profile> {
    profiles(&HELD_OUT, &HELD_OUT_AT, count, seconds, seed ^ (1 << 40))
}

fn profiles(kinds: &[Kind], at: &[f64], count: u32, seconds: f64, seed: u64) -> Vec<Profile> {
    (0..count as usize)
        .map(|k| Profile {
            kind: kinds[k % kinds.len()],
            seed: (seed << 16) + k as u64,
            seconds,
            T: at[k % at.len()],
        })
        .collect()
}

/// Windows of each profile; the sensors of each are set up anew, with the seed `sensors` of it.
pub fn measure(
    p: &Emla,
    profiles: &[Profile],
    sensors: impl Fn(&Profile) -> u64 + Sync,
) -> Result<Vec<Vec<Window>>> {
    profiles
        .par_iter()
        .map(|profile| Ok(windows(p, &run(profile, sensors(profile))?)))
        .collect()
}

/// Compliance between nut and rod by a campaign's own data, m/N: the least squares of `travel·w_m −
/// ẋ = c Ḟ`.
pub fn compliance(p: &Emla, campaign: &[Vec<Window>]) -> f64 {
    let travel = maps::travel_per_radian(p);
    let all = || campaign.iter().flatten();
    let moved: f64 = all()
        .map(|w| w.F_dot * (travel * w.row.w_m - w.row.x_dot))
        .sum();
    moved / all().map(|w| w.F_dot * w.F_dot).sum::<f64>()
}

/// Rows of a campaign, and the number of each one's profile. Their torque is that of the magnets of `p`.
/// The rod's speed is that of the nut: what the change of the force bends on the way is added, so
/// that rows of changing and of steady loads lie on one map.
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

/// Force errors of rows, N, root mean square: what the sensors alone leave even where a map is
/// perfect, and by how much two runs of one profile differ for the same map. An error of the torque
/// counts as the force that it stands for.
#[derive(Clone, Copy, Debug)]
pub struct Trust {
    /// Against what is true of the windows.
    pub floor: f64,
    /// Between two runs of a profile with the sensors set up anew, over √2.
    pub repeatability: f64,
}

impl Trust {
    /// Of a campaign; `again` are its first profiles run once more.
    pub fn of(p: &Emla, campaign: &[Vec<Window>], again: &[Vec<Window>]) -> Self {
        let per_torque = 1.0 / maps::travel_per_radian(p);
        let inertia = maps::inertia(p, 1.0);
        let all = || campaign.iter().flatten();
        let floor = rms(all().map(|w| {
            let tau = w.truth.tau_e - inertia * w.truth.w_m_dot;
            w.row.f_ext - w.truth.F - per_torque * (w.row.tau_e - tau)
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
