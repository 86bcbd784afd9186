//! Least squares, look-up map, free run, intervals and bounds, each against what is known of it.
#![allow(non_snake_case)] // symbols

use emla::{EfficiencyBound, maps};
use machine_file::{Emla, Heat};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use surrogate::judgement::conformal::{Coverage, Point, SHARE, calibrate};
use surrogate::judgement::free_run::simulate;
use surrogate::judgement::resampling::{binomial, bootstrap};
use surrogate::measurement::profile::{Desired, SAMPLE};
use surrogate::prediction::least_squares::Fit;
use surrogate::prediction::lookup::LookUp;
use surrogate::prediction::model::Model;

/// Oracle: the certified parameters and residual of Misra1a, NIST Statistical Reference
/// Datasets. Central differences move the minimum by their (1e-4)² share.
#[test]
fn misra1a_gives_the_certified_parameters() {
    let x = [
        77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1,
        760.0,
    ];
    let y = [
        10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47,
        81.78,
    ];
    let model = |b: &[f64; 2], (x, y): &(f64, f64)| b[0] * (1.0 - f64::exp(-b[1] * x)) - y;
    let rows: Vec<_> = x.into_iter().zip(y).map(|row| vec![row]).collect();
    let fit = Fit::new([500.0, 1e-4], [200.0, 5e-4], &rows, model);
    let certified = [238.942_129_18, 5.501_564_318_1e-4];
    for (found, certified) in fit.values.iter().zip(certified) {
        assert!((found / certified - 1.0).abs() < 1e-6, "{fit:?}");
    }
    let residual = (0.124_551_388_94_f64 / 14.0).sqrt();
    assert!((fit.rms / residual - 1.0).abs() < 1e-9, "{fit:?}");
}

/// Oracle: the mean of numbers in groups, `Var = Σ_g (Σ e)²/n² · G/(G − 1)`; by hand, with the
/// groups {1, 3}, {6}, {10}: mean 5, sums of errors −6, 1, 5, variance 62/16·3/2.
#[test]
fn rows_of_a_group_count_once() {
    let of = |groups: &[Vec<f64>]| Fit::new([0.0], [1.0], groups, |b, y| b[0] - y);
    let fit = of(&[vec![1.0, 3.0], vec![6.0], vec![10.0]]);
    assert!((fit.values[0] - 5.0).abs() < 1e-9, "{fit:?}");
    let expected = 1.959_964 * (62.0_f64 / 16.0 * 1.5).sqrt();
    assert!((fit.half[0] / expected - 1.0).abs() < 1e-9, "{fit:?}");
    let alone = of(&[1.0, 3.0, 6.0, 10.0].map(|y| vec![y]));
    assert!(alone.half[0] < 0.95 * fit.half[0]);
}

/// Oracle: a lost force that is bilinear in torque and speed, of which cell means at mean
/// places give back the value but for the covariance of the two within a cell.
#[test]
fn a_bilinear_loss_comes_back_in_both_directions() {
    let travel = 4e-4;
    let lost = |tau: f64, w: f64| 300.0 + 12.0 * tau + 3.0 * w + 0.05 * tau * w;
    let grid = (0..200).flat_map(|a| (0..150).map(move |b| (a, b)));
    let rows: Vec<[f64; 3]> = grid
        .map(|(a, b)| {
            let (tau, w) = (-30.0 + 0.3 * f64::from(a), 2.0 + f64::from(b));
            let F = tau / travel - lost(tau, w);
            if (a + b) % 2 == 0 {
                [tau, w, F]
            } else {
                [-tau, -w, -F]
            }
        })
        .collect();
    let map = LookUp::new(travel, &rows);
    for (tau, w) in [(11.0, 40.0), (-17.0, 90.0), (3.3, 120.0)] {
        let expected = tau / travel - lost(tau, w);
        assert!((map.force(tau, w) - expected).abs() < 1.0, "{tau} {w}");
        assert_eq!(map.force(-tau, -w), -map.force(tau, w));
    }
}

/// 100 numbers of variance 1/12: the interval of their mean is ±1.96/√1200 = ±0.057; the
/// bootstrap's own error is some 5 % of it.
#[test]
fn the_interval_is_that_of_the_mean() {
    let mean = |drawn: &[usize]| drawn.iter().map(|&k| k as f64 / 99.0).sum::<f64>() / 100.0;
    let [value, low, high] = bootstrap(100, mean);
    assert!((value - 0.5).abs() < 1e-12);
    for side in [value - low, high - value] {
        assert!((side / 0.057 - 1.0).abs() < 0.15, "{low} {high}");
    }
}

/// Oracle: with none or all of n the other end is `1 − 0.025^(1/n)` or `0.025^(1/n)`; with one
/// of two, `(1 − √0.975, √0.975)`.
#[test]
fn the_share_has_its_closed_forms() {
    let close = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-9;
    let end = 0.025_f64.powf(1.0 / 30.0);
    assert!(close(binomial(0, 30), [0.0, 1.0 - end]));
    assert!(close(binomial(30, 30), [end, 1.0]));
    let root = 0.975_f64.sqrt();
    assert!(
        close(binomial(1, 2), [1.0 - root, root]),
        "{:?}",
        binomial(1, 2)
    );
}

/// Oracle: without friction, with a constant speed v, load F and resistance, by hand: `i = F
/// t/(3/2 p λ)` with the nut's travel t, and the energy of T seconds is `(F v + 3/2 R i²) T`.
#[test]
fn the_energy_of_a_steady_stroke_is_by_hand() {
    let lift = machine_file::Machine::reference().emla.lift;
    let p = Emla {
        C_m: 0.0,
        tau_C: 0.0,
        eta_gear: 1.0,
        C_s: 0.0,
        C_act: 0.0,
        core: None,
        inverter: None,
        temperature: Some(machine_file::Temperature {
            reference: 293.15,
            copper: 0.0,
            magnet: 0.0,
        }),
        ..lift
    };
    let (F, v) = (23e3, -0.031);
    let desired = vec![Desired { x_dot: v, load: F }; 3001];
    let course = simulate(&Model::physics(p), &desired, 340.0);
    let i = F * maps::travel_per_radian(&p) / (1.5 * f64::from(p.p) * p.lambda_m);
    let copper = 1.5 * p.R_s * i * i;
    let energy = SAMPLE * course[1..].iter().map(|s| s.P_in).sum::<f64>();
    let expected = 3.0 * (F * v + copper);
    assert!(
        (energy / expected - 1.0).abs() < 1e-6,
        "{energy} {expected}"
    );
    assert!((course[7].i_q / i - 1.0).abs() < 1e-6);
    // The housing cools through its resistance to the air; after 3 s still as at the start.
    let heat = p.heat.unwrap_or(Heat::TYPICAL);
    let cooling = (340.0 - 293.15) / (heat.R_ha * heat.C_h);
    let fallen = 340.0 - course[3000].T_housing;
    assert!((fallen / (3.0 * cooling) - 1.0).abs() < 0.02, "{fallen}");
}

/// Profiles of 40 points whose errors are exponential with a mean that is exponential itself
/// and common to the profile.
fn profiles(count: usize, seed: u64) -> Vec<Vec<Point>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut exponential = move || -f64::ln(1.0 - rng.random::<f64>());
    (0..count)
        .map(|_| {
            let size = 0.01 * exponential();
            let mut point = |_| Point {
                error: size * exponential(),
                out: 0.0,
                cut: 0.0,
            };
            (0..40).map(&mut point).collect()
        })
        .collect()
}

/// Oracle: of a product of two exponentials `P(xy > z) = 2√z K_1(2√z)`, which is 0.1 at z =
/// 2.658 (table of the Bessel function: K_1(3.2606) = 0.030668). Without power the half width is
/// the error's quantile. Its standard error over 2000 profiles is some 4 %; new profiles are
/// covered with 90 %.
#[test]
fn the_bound_is_the_quantile_of_a_known_distribution() {
    let bound = calibrate(&profiles(4000, 11));
    assert!((bound.factor / 0.02658 - 1.0).abs() < 0.1, "{bound:?}");
    let coverage = Coverage::new(&bound, &profiles(3000, 12), 13);
    let [low, high] = coverage.interval();
    assert!(low < SHARE && SHARE < high, "{coverage:?}");
    assert!((coverage.shares[0] - SHARE).abs() < 0.01, "{coverage:?}");
    let narrow = EfficiencyBound {
        factor: 0.8 * bound.factor,
        ..bound
    };
    let coverage = Coverage::new(&narrow, &profiles(3000, 12), 13);
    assert!(coverage.interval()[1] < SHARE, "{coverage:?}");
}
