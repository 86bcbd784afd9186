//! The limit of the required force: a load beyond it for a while, and what comes after.

use crate::coupled::{Case, Loop, Schedule};
use vdc::{Mode, Trajectory};

const H: f64 = 1e-3;
/// Rated force of the lift rod, N: it holds the machine at rest with 41 143 N.
const RATED: f64 = 40e3;
const FACTOR: f64 = 1.2;
/// How fast the ground is lifted, m/s², between these times, s: along a squared sine, which at its
/// peak asks the lift rod for a third of its force more.
const LIFTED: f64 = 3.3;
const LIFTING: [f64; 2] = [0.5, 1.5];

/// Vertical tip error, m, and required force and force of the lift rod, N, at each step of 5 s.
fn run(force_limit: f64) -> Vec<[f64; 3]> {
    let mut case = Case {
        mode: Mode::Modular,
        integral: true,
        trajectory: Trajectory::Triangular,
        ..Case::nominal()
    };
    case.machine.controller.settle_time = 100.0;
    case.machine.ratings.lift.force_max = RATED;
    let mut machine = Loop::new(&case);
    machine.settings.force_limit = force_limit;
    let mut rows = Vec::new();
    for k in 0..5000 {
        let t = f64::from(k) * H;
        let share = ((t - LIFTING[0]) / (LIFTING[1] - LIFTING[0])).clamp(0.0, 1.0);
        let wave = (std::f64::consts::PI * share).sin();
        machine.base.0.base_acceleration[1] = LIFTED * wave * wave;
        machine.step(Schedule::Staged, t, H);
        let y = &machine.last;
        rows.push([y.tip_error[1], y.f_required[1], machine.set.0.F[1]]);
    }
    rows
}

fn largest(rows: &[[f64; 3]], of: impl Fn(&[f64; 3]) -> f64) -> f64 {
    rows.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
}

/// The load is beyond the limit for a while, so the rod gives way: the tip sinks, with the required
/// force at the limit and not beyond; the rod has that, and for the rest friction and the inertia of
/// the rotor that it turns back. Then the tip comes back, and the integral, which rested, carries it
/// above its place by no more than a tenth of the way that it sank.
#[test]
fn a_force_beyond_the_limit_is_not_asked_for_and_nothing_winds_up() {
    let [free, limited] = [0.0, FACTOR].map(run);
    let most = FACTOR * RATED;
    let of = |k: usize| [&free, &limited].map(|rows| largest(rows, |row| row[k].abs()));
    let [asked, given] = [of(1), of(2)];
    println!("asked {asked:?} N, given {given:?} N, at most {most} N");
    assert!(given[0] > 1.1 * most, "the load is beyond the limit");
    assert_eq!(asked[1], most);
    assert!(given[1] < 1.15 * most, "{given:?} N");

    let sunk = [&free, &limited].map(|rows| largest(rows, |row| row[0]));
    let above = [&free, &limited].map(|rows| largest(rows, |row| -row[0]));
    let rest = limited.last().expect("steps")[0];
    println!("sunk {sunk:?} m, above {above:?} m, at the end {rest} m");
    assert!(sunk[1] > 10.0 * sunk[0], "the limit counts: {sunk:?} m");
    assert!(above[1] < 0.1 * sunk[1], "{above:?} m");
    assert!(rest.abs() < 1e-5, "{rest} m");
}
