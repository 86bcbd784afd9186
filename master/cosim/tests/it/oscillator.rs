//! The master on two coupled FMUs that make a mass–spring–damper: m x'' + d x' + k x = 0.

use cosim::io::csv::Log;
use cosim::master::{Jitter, Master, Schedule};
use cosim::run::observer::Observer;
use cosim::run::signals::matching;
use cosim::run::simulate::{self, Experiment};
use cosim::structure::system::{Setting, System};

use super::support::{assert_contains, oscillator, scratch, settings, stepping, system};

const M: f64 = 1.7;
const K: f64 = 23.0;
const X0: f64 = 0.31;
const V0: f64 = -0.83;

fn parameters(system: &System, d: f64) -> Vec<Setting> {
    let texts = [
        format!("mass.m={M}"),
        format!("spring.k={K}"),
        format!("spring.d={d}"),
        format!("mass.x_start={X0}"),
        format!("mass.x_dot_start={V0}"),
    ];
    settings(system, &texts.each_ref().map(String::as_str)).unwrap()
}

/// Position and velocity of the coupled FMUs after `n` steps of `h`.
fn coupled(system: &System, schedule: Schedule, d: f64, h: f64, n: u32) -> (f64, f64) {
    let mut master = Master::new(system, &parameters(system, d), stepping(h, schedule)).unwrap();
    for _ in 0..n {
        master.step().unwrap();
    }
    let [x, v] = read(system, &master, ["mass.x", "mass.x_dot"]);
    (x, v)
}

/// Present values of variables.
fn read<const N: usize>(system: &System, master: &Master, names: [&str; N]) -> [f64; N] {
    names.map(|name| master.number(system.port(name).unwrap()).unwrap())
}

/// Closed form of the damped oscillator at `t` after the start.
fn exact(d: f64, t: f64) -> f64 {
    let (a, w) = (d / (2.0 * M), (K / M - (d / (2.0 * M)).powi(2)).sqrt());
    (-a * t).exp() * (X0 * (w * t).cos() + (V0 + a * X0) / w * (w * t).sin())
}

/// Ratio of the errors of steps `h` and `h/2` after 2 s.
fn error_ratio(system: &System, schedule: Schedule, d: f64) -> f64 {
    let error = |h: f64, n: u32| (coupled(system, schedule, d, h, n).0 - exact(d, 2.0)).abs();
    error(1.0 / 512.0, 1024) / error(1.0 / 1024.0, 2048)
}

/// Gauss–Seidel passes the mean of F over x + x_dot·s, which is exact to second order for the
/// spring, to first for the damper (it sees a held x_dot); Jacobi holds F: first order; with
/// derivatives F is linear over the step: second order. Halving h divides the error by 2^order up
/// to terms of relative size h·w = 0.7 %; 5 % are allowed, and orders 1 and 2 differ by 100 %.
#[test]
fn schedules_converge_to_the_closed_form_with_their_order() {
    let system = system("order", &oscillator()).unwrap();
    for (schedule, d, order) in [
        (Schedule::GaussSeidel, 0.0, 2),
        (Schedule::GaussSeidel, 0.9, 1),
        (Schedule::Jacobi, 0.9, 1),
        (Schedule::JacobiDerivatives, 0.9, 2),
    ] {
        let (ratio, expected) = (
            error_ratio(&system, schedule, d),
            f64::from(2i32.pow(order)),
        );
        assert!(
            (ratio / expected - 1.0).abs() < 0.05,
            "{schedule:?}, d = {d}: error ratio {ratio}, expected {expected}"
        );
    }
}

/// Each schedule is a linear map of (x, v) that can be written down; 100 steps of it agree to
/// rounding: each of the some 10 products and sums of a step is rounded, so 100·10·ε of the largest
/// state, 3.2.
#[test]
fn every_step_is_the_map_that_the_schedule_says() {
    let (h, d) = (0.01, 0.9);
    let system = system("map", &oscillator()).unwrap();
    for schedule in [
        Schedule::GaussSeidel,
        Schedule::Jacobi,
        Schedule::JacobiDerivatives,
    ] {
        let (mut x, mut v) = (X0, V0);
        for _ in 0..100 {
            let force = -K * x - d * v;
            let (a, jerk) = match schedule {
                Schedule::GaussSeidel => ((-K * (x + 0.5 * h * v) - d * v) / M, 0.0),
                Schedule::Jacobi | Schedule::Standard => (force / M, 0.0),
                Schedule::JacobiDerivatives => (force / M, (-K * v - d * force / M) / M),
            };
            (x, v) = (
                x + h * v + h * h * (a / 2.0 + h * jerk / 6.0),
                v + h * (a + h * jerk / 2.0),
            );
        }
        let (x_fmu, v_fmu) = coupled(&system, schedule, d, h, 100);
        let tolerance = 1000.0 * f64::EPSILON * 3.2;
        assert!(
            (x_fmu - x).abs() < tolerance && (v_fmu - v).abs() < tolerance,
            "{schedule:?}: {x_fmu} {x}, {v_fmu} {v}"
        );
    }
}

/// In a Gauss–Seidel step the spring delivers F̄·v, the mass receives F̄·(v + v')/2 with v' = v + h
/// F̄/m: the residual is −h F̄²/(2m). Held force: F̄·v − F (v + v')/2 with v' = v + h F/m.
#[test]
fn power_residuals_are_those_of_the_schedule() {
    let (h, d) = (0.01, 0.9);
    let system = system("residual", &oscillator()).unwrap();
    for schedule in [Schedule::GaussSeidel, Schedule::Jacobi] {
        let mut master =
            Master::new(&system, &parameters(&system, d), stepping(h, schedule)).unwrap();
        let (mut energy, mut peak) = (0.0, 0.0f64);
        for _ in 0..50 {
            let [x, v] = read(&system, &master, ["mass.x", "mass.x_dot"]);
            let (held, mean) = (-K * x - d * v, -K * (x + 0.5 * h * v) - d * v);
            let given = if schedule == Schedule::GaussSeidel {
                mean
            } else {
                held
            };
            let power = mean * v - given * (v + 0.5 * h * given / M);
            energy += power * h;
            peak = peak.max(power.abs());
            master.step().unwrap();
            let residual = &master.residuals()[0];
            assert_eq!(residual.bond, "spring.F");
            // Rounding of powers of some 8 N · 1.2 m/s, and of v over the run (1e-13).
            assert!(
                (residual.power - power).abs() < 1e-11,
                "{schedule:?}: {} W, expected {power} W",
                residual.power
            );
        }
        let residual = &master.residuals()[0];
        assert!((residual.energy - energy).abs() < 1e-11 && (residual.peak - peak).abs() < 1e-11);
        assert!(residual.turnover > 1.0, "{} J", residual.turnover);
    }
}

#[test]
fn initialization_passes_start_values_through_the_connections() {
    let system = system("start", &oscillator()).unwrap();
    let master = Master::new(
        &system,
        &parameters(&system, 0.9),
        stepping(0.01, Schedule::GaussSeidel),
    )
    .unwrap();
    let [mean, x_ddot] = read(&system, &master, ["spring.F_mean", "mass.x_ddot"]);
    let force = -K * X0 - 0.9 * V0;
    assert!(
        (mean - force).abs() < 1e-14 * 10.0,
        "F_mean is made in initialization only"
    );
    assert!((x_ddot - force / M).abs() < 1e-14 * 10.0);
}

#[test]
fn runs_in_parallel_threads_are_bit_equal() {
    let system = system("threads", &oscillator()).unwrap();
    let run = || coupled(&system, Schedule::GaussSeidel, 0.9, 0.001, 2000);
    let alone = run();
    let results: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|_| scope.spawn(run)).collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    });
    assert!(results.iter().all(|r| *r == alone));
}

/// Get all, set all, step all: the spring gets x and v, the mass the force of the point before,
/// held over the step: x' = x + h v + h² a/2, v' = v + h a, a = F/m, F' = −k x' − d v' only at the
/// next read.
#[test]
fn the_standard_schedule_passes_what_was_read_before_anything_was_set() {
    let (h, d) = (0.01, 0.9);
    let system = system("standard", &oscillator()).unwrap();
    let (mut x, mut v) = (X0, V0);
    // In initialization the spring has got the start values; its force of the second step is made
    // of those set for the first.
    let mut force = -K * x - d * v;
    for _ in 0..100 {
        let (a, next) = (force / M, -K * x - d * v);
        (x, v) = (x + h * v + h * h * a / 2.0, v + h * a);
        force = next;
    }
    let (x_fmu, v_fmu) = coupled(&system, Schedule::Standard, d, h, 100);
    let tolerance = 1000.0 * f64::EPSILON * 3.2;
    assert!(
        (x_fmu - x).abs() < tolerance && (v_fmu - v).abs() < tolerance,
        "{x_fmu} {x}, {v_fmu} {v}"
    );
}

fn experiment(system: &System, step: f64, stop: Option<f64>) -> Experiment {
    Experiment {
        stop,
        settings: parameters(system, 0.0),
        ..Experiment::new(stepping(step, Schedule::Jacobi))
    }
}

/// Run with all outputs in a file; its text, the text of the units, the simulated time.
fn logged(system: &System, name: &str, experiment: &Experiment) -> (String, String, f64) {
    let path = scratch(&format!("{name}.csv"));
    let ports = matching(system, &["*".into()]).unwrap();
    let mut log = Log::create(&path, system, &ports, None, experiment.stepping, false).unwrap();
    let (master, stop) = (experiment.start(system), experiment.stop(system));
    let outcome = simulate::run(system, master.unwrap(), stop.unwrap(), &|_, _| (), |m| {
        log.observe(m)
    });
    log.finish().unwrap();
    let text = |path| std::fs::read_to_string(path).unwrap();
    let units = text(scratch(&format!("{name}.units.csv")));
    (text(path), units, outcome.unwrap().simulated)
}

fn numbers(line: &str) -> Vec<f64> {
    line.split(',').map(|v| v.parse().unwrap()).collect()
}

#[test]
fn csv_holds_a_row_per_communication_point_and_the_units_beside_it() {
    let system = system("csv", &oscillator()).unwrap();
    let (text, units, simulated) = logged(&system, "csv", &experiment(&system, 0.1, None));
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[0],
        "time,spring.F,spring.F_mean,mass.x,mass.x_dot,mass.x_ddot,mass.is_left,mass.steps"
    );
    assert!(
        units.starts_with("signal,unit\ntime,s\nspring.F,N\n"),
        "{units}"
    );
    assert_eq!(
        lines.len(),
        1 + 21,
        "2 s of the default experiment in steps of 0.1 s"
    );
    assert_eq!(numbers(lines[1])[..5], [0.5, -K * X0, -K * X0, X0, V0]);
    let last = numbers(lines[21]);
    assert_eq!(last[0], 0.5 + 20.0 * 0.1, "t = t_0 + k h, not a sum");
    assert!((simulated - 2.0).abs() < 1e-12);
}

/// Held force over the steps: the last row is the map of two whole steps of 0.3 s and one of 0.1 s.
#[test]
fn the_last_step_is_shortened_to_end_at_the_stop_time() {
    let system = system("rest", &oscillator()).unwrap();
    let (text, _, simulated) = logged(&system, "rest", &experiment(&system, 0.3, Some(1.2)));
    let last = numbers(text.lines().last().unwrap());
    assert_eq!((last[0], simulated), (1.2, 0.7));
    let (mut x, mut v) = (X0, V0);
    for h in [0.3, 0.3, 0.1] {
        let a = -K * x / M;
        (x, v) = (x + h * v + h * h * a / 2.0, v + h * a);
    }
    assert!((last[3] - x).abs() < 1e-14 * 10.0, "{} {x}", last[3]);
}

/// Points that jitter makes up to 0.045 s late, and a stop 0.01 s after the last of them on the grid.
#[test]
fn jitter_leaves_the_last_step_its_rest() {
    let system = system("jitter", &oscillator()).unwrap();
    for seed in 0..20 {
        let (part, lost) = (0.9, 0.1);
        let mut experiment = experiment(&system, 0.1, Some(0.81));
        experiment.stepping.jitter = Some(Jitter { seed, part, lost });
        let (text, _, simulated) = logged(&system, "jitter", &experiment);
        let times: Vec<f64> = text.lines().skip(1).map(|row| numbers(row)[0]).collect();
        assert!(
            times.is_sorted() && times.last() == Some(&0.81),
            "{times:?}"
        );
        assert!((simulated - 0.31).abs() < 1e-12);
    }
}

/// Held force with ω h > 2: each step multiplies the state by a factor < −1, so that x jumps from
/// side to side until the mass refuses the force. The error names the step that is too long, the
/// signal and the time from which on it diverges.
#[test]
fn a_diverging_loop_is_named_where_it_begins() {
    let system = system("diverging", &oscillator()).unwrap();
    let settings = settings(&system, &["spring.k=900", "mass.x_start=1e-9"]).unwrap();
    let experiment = Experiment {
        settings,
        ..experiment(&system, 0.1, Some(100.0))
    };
    let master = experiment.start(&system).unwrap();
    let error = simulate::run(&system, master, 100.0, &|_, _| (), |_| Ok(())).unwrap_err();
    let text = format!("{error:#}");
    assert_contains(
        &text,
        &[
            "`mass.x` diverges from t = 1.3 s",
            "communication step of 0.1 s is too long",
            "mass",
            "fmi2SetReal",
        ],
    );
}
