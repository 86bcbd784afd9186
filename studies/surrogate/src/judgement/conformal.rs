//! A bound on the error of the network's efficiency that holds with a given probability whatever
//! the errors' distribution (conformal prediction), for `surrogate calibrate` and `compare`.

use anyhow::{Context as _, Result};
use emla::{Drive, EfficiencyBound, Electric, Emla, State, Surrogate, Thermal};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::judgement::free_run::DrivenProfile;
use crate::judgement::resampling::binomial;
use crate::measurement::windows::Window;

/// Probability that the bound holds.
pub const SHARE: f64 = 0.9;
/// Powers, W, and floors of the shapes from which the narrowest bound is chosen.
const POWERS: [f64; 6] = [25.0, 50.0, 100.0, 200.0, 400.0, 800.0];
const FLOORS: [f64; 6] = [0.02, 0.05, 0.1, 0.2, 0.4, 0.8];

/// The network's efficiency in a window, as [`emla::Output`] has it, compared with the true one.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// True efficiency less that of the network.
    pub error: f64,
    /// Power that the network gives, W.
    pub out: f64,
    /// Power that its guards hold back, W.
    pub cut: f64,
}

impl Point {
    fn needed(&self, bound: &EfficiencyBound) -> f64 {
        bound.needed_factor(self.error, self.out, self.cut)
    }
}

/// Points of every profile: its windows in quadrants I and IV, by the measured torque and speed.
pub fn points(
    p: machine_file::Emla,
    network: &Surrogate,
    driven: &[DrivenProfile],
) -> Result<Vec<Vec<Point>>> {
    let electric = Electric {
        temperature: true,
        ..Electric::default()
    };
    let emla = Emla::new(p, Drive::Motion).context("the actuator")?;
    let emla = emla
        .with_electric(electric)
        .with_surrogate(network.clone(), 1.0);
    let u = emla::Input {
        v_dc: Some(p.link_voltage()),
        ..emla::Input::default()
    };
    let point = |w: &Window| {
        let thermal = Thermal {
            T_winding: w.row.T_winding,
            T_housing: w.row.T_housing,
            ..Thermal::default()
        };
        let mut s = State {
            i_d: w.row.i_d,
            i_q: w.row.i_q,
            w_m: w.row.w_m,
            thermal,
            ..State::default()
        };
        let tau_e = emla.output(&s, &u).tau_e;
        s.residual = emla.residual(tau_e, w.row.w_m);
        let y = emla.output(&s, &u);
        let travel = emla::maps::travel_per_radian(&p);
        let truth = w.truth.efficiency().filter(|_| y.efficiency_valid)?;
        Some(Point {
            error: truth - y.efficiency_net,
            out: (y.F_net * y.x_dot_net).abs(),
            cut: (emla.force_held_back(network, tau_e, w.row.w_m) * travel * w.row.w_m).abs(),
        })
    };
    let profiles = driven.iter();
    Ok(profiles
        .map(|driven| driven.windows.iter().filter_map(point).collect())
        .collect())
}

/// Calibrates the bound. Half of the profiles choose its shape, the narrowest one; the other half
/// determine its factor.
///
/// The factor is the smallest score at which the mean, over the K profiles and one more whose
/// scores are infinite, of each profile's share of scores up to it reaches [`SHARE`]. A window
/// drawn uniformly from a new profile then has a score below the factor with this probability:
/// Dunn, Wasserman and Ramdas (2023, *Distribution-free prediction sets for two-layer hierarchical
/// models*), pooling CDFs.
pub fn calibrate(profiles: &[Vec<Point>]) -> EfficiencyBound {
    let profiles = with_points(profiles);
    let every_other = |first: usize| -> Vec<&[Point]> {
        profiles.iter().skip(first).step_by(2).copied().collect()
    };
    let [shaping, scoring] = [every_other(0), every_other(1)];
    let with_factor = |power: f64, floor: f64, profiles: &[&[Point]]| {
        let bound = EfficiencyBound {
            share: SHARE,
            factor: 1.0,
            power,
            floor,
            profiles: profiles.len() as u32,
        };
        let factor = quantile(profiles, |point| point.needed(&bound));
        EfficiencyBound { factor, ..bound }
    };
    let shapes = POWERS
        .iter()
        .flat_map(|&power| FLOORS.iter().map(move |&floor| (power, floor)));
    let width = |&(power, floor): &(f64, f64)| {
        let bound = with_factor(power, floor, &shaping);
        mean(&shaping, |point| bound.half_width(point.out, point.cut))
    };
    let (power, floor) = shapes
        .min_by(|a, b| width(a).total_cmp(&width(b)))
        .expect("some shapes");
    with_factor(power, floor, &scoring)
}

fn with_points(profiles: &[Vec<Point>]) -> Vec<&[Point]> {
    let profiles = profiles.iter().map(Vec::as_slice);
    profiles.filter(|points| !points.is_empty()).collect()
}

/// The factor, see [`calibrate`].
fn quantile(profiles: &[&[Point]], score: impl Fn(&Point) -> f64) -> f64 {
    let mut scores: Vec<[f64; 2]> = Vec::new();
    for points in profiles {
        let weight = 1.0 / (points.len() as f64 * (profiles.len() + 1) as f64);
        scores.extend(points.iter().map(|point| [score(point), weight]));
    }
    scores.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let mut sum = 0.0;
    for [score, weight] in scores {
        sum += weight;
        if sum >= SHARE {
            return score;
        }
    }
    f64::INFINITY
}

/// Mean over profiles of the means over their points.
fn mean(profiles: &[&[Point]], value: impl Fn(&Point) -> f64) -> f64 {
    let mean = |points: &&[Point]| points.iter().map(&value).sum::<f64>() / points.len() as f64;
    profiles.iter().map(mean).sum::<f64>() / profiles.len() as f64
}

/// How often a bound holds on profiles that it was not calibrated on.
#[derive(Clone, Copy, Debug)]
pub struct Coverage {
    /// Profiles that have points.
    pub(crate) profiles: usize,
    /// Profiles whose window lies inside the bound, of which one window is drawn by seed.
    pub(crate) inside: usize,
    /// Share of windows inside, and of profiles with all of their windows inside.
    pub shares: [f64; 2],
    /// Half the width, mean over profiles.
    pub(crate) half: f64,
}

impl Coverage {
    /// The coverage of a bound; `seed` draws one window of each profile.
    pub fn new(bound: &EfficiencyBound, profiles: &[Vec<Point>], seed: u64) -> Self {
        let profiles = with_points(profiles);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let holds = |point: &Point| point.needed(bound) <= bound.factor;
        let mut drawn = |points: &&&[Point]| holds(&points[rng.random_range(0..points.len())]);
        let whole = profiles.iter().filter(|points| points.iter().all(holds));
        Self {
            profiles: profiles.len(),
            inside: profiles.iter().filter(&mut drawn).count(),
            shares: [
                mean(&profiles, |point| f64::from(u8::from(holds(point)))),
                whole.count() as f64 / profiles.len() as f64,
            ],
            half: mean(&profiles, |point| bound.half_width(point.out, point.cut)),
        }
    }

    /// The 95 % binomial interval of the share of drawn windows.
    pub fn interval(&self) -> [f64; 2] {
        binomial(self.inside, self.profiles)
    }
}
