//! Levenberg–Marquardt against NumPy, and against itself with other threads and other forms.

use serde_json::Value;
use surrogate::training::Form;
use surrogate::training::lm::{self, Outcome, Samples};
use surrogate::training::network::Shape;

struct Case {
    shape: Shape,
    samples: Samples,
    first: Vec<f64>,
    golden: Value,
}

fn cases() -> Vec<Case> {
    let text = include_str!("../../../tests/oracle/surrogate_lm.json");
    let golden: Value = serde_json::from_str(text).expect("JSON");
    let widths: Vec<usize> = serde_json::from_value(golden["widths"].clone()).expect("widths");
    let case = |golden: &Value| Case {
        shape: Shape::new(&widths),
        samples: Samples {
            inputs: serde_json::from_value(golden["inputs"].clone()).expect("inputs"),
            targets: serde_json::from_value(golden["targets"].clone()).expect("targets"),
        },
        first: numbers(&golden["first_weights"]),
        golden: golden.clone(),
    };
    golden["cases"]
        .as_array()
        .expect("cases")
        .iter()
        .map(case)
        .collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    serde_json::from_value(value.clone()).expect("numbers")
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// Oracle: `tests/oracle/surrogate_lm.py`. The normal matrix's condition is at most
/// |J|²/(R·mu) ~ 1e7 on these paths, so rounding grows to some 1e-9 over the iterations.
#[test]
fn path_matches_numpy() {
    for (k, case) in cases().iter().enumerate() {
        let automatic = Form::cheaper(&case.shape, case.samples.inputs.len());
        assert_eq!(automatic, [Form::Weights, Form::Residuals][k]);
        for form in [Form::Weights, Form::Residuals] {
            let (mut weights, mut mu) = (case.first.clone(), lm::MU_START);
            for (n, step) in case.golden["path"]
                .as_array()
                .expect("path")
                .iter()
                .enumerate()
            {
                let outcome =
                    lm::iterate_in(form, &case.shape, &case.samples, &mut weights, &mut mu);
                assert_eq!(outcome, Outcome::Stepped);
                let error = largest_difference(&weights, &numbers(&step["weights"]));
                assert!(error < 1e-8, "case {k}, {form:?}, iteration {n}: {error:e}");
                let mu_error = (mu / step["mu"].as_f64().expect("mu") - 1.0).abs();
                assert!(mu_error < 1e-12, "case {k}, iteration {n}: mu = {mu:e}");
            }
        }
    }
}

/// Oracle: complex steps in the same script, exact to rounding.
#[test]
fn jacobian_matches_complex_steps() {
    for case in cases() {
        let views = case.shape.views(&case.first, &case.samples.inputs);
        for r in [0_usize, 7] {
            let mut row = vec![0.0; case.shape.weights()];
            case.shape.jacobian_row(&views, r / 2, r % 2, &mut row);
            let exact = numbers(&case.golden["jacobian_rows"][r.to_string()]);
            let error = largest_difference(&row, &exact);
            assert!(error < 1e-14, "row {r}: {error:e}");
        }
    }
}

fn random_samples(count: usize) -> Samples {
    let point = |k: usize| [(1.7 * k as f64).sin(), (0.9 * k as f64 + 0.3).cos()];
    let target = |[x, y]: [f64; 2]| [0.6 * x * y + 0.1, 0.5 * (x - y).sin()];
    let inputs: Vec<_> = (0..count).map(point).collect();
    Samples {
        targets: inputs.iter().map(|&x| target(x)).collect(),
        inputs,
    }
}

/// Oracle: central differences of the paper's network, over random directions of all weights.
/// Truncation h²·f'''/6 and rounding ε/h are both near 1e-10 at h = 1e-5; slopes are of order 1 to
/// 10.
#[test]
fn full_jacobian_matches_finite_differences() {
    let shape = Shape::new(&emla::WIDTHS);
    let weights: Vec<f64> = shape.initial_weights(3).iter().map(|w| 0.5 * w).collect();
    let samples = random_samples(5);
    let views = shape.views(&weights, &samples.inputs);
    for direction in 1..6 {
        let along: Vec<f64> = (0..weights.len())
            .map(|k| (0.37 * (k * direction) as f64).sin())
            .collect();
        let moved = |h: f64| {
            let w: Vec<f64> = weights.iter().zip(&along).map(|(w, d)| w + h * d).collect();
            shape.evaluate(&w, &samples.inputs)
        };
        let (ahead, behind) = (moved(1e-5), moved(-1e-5));
        for n in 0..5 {
            for o in 0..2 {
                let mut row = vec![0.0; weights.len()];
                shape.jacobian_row(&views, n, o, &mut row);
                let slope: f64 = row.iter().zip(&along).map(|(j, d)| j * d).sum();
                let difference = (ahead[n][o] - behind[n][o]) / 2e-5;
                assert!(
                    (slope - difference).abs() < 1e-6 * (1.0 + slope.abs()),
                    "sample {n}, output {o}: {slope} vs {difference}"
                );
            }
        }
    }
}

/// The bits of a step of the paper's network must not depend on the number of threads; 300 samples
/// make several tiles in either form.
#[test]
fn threads_do_not_change_a_bit() {
    let shape = Shape::new(&emla::WIDTHS);
    let samples = random_samples(300);
    let run = |form: Form, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        pool.install(|| {
            let (mut weights, mut mu) = (shape.initial_weights(9), lm::MU_START);
            lm::iterate_in(form, &shape, &samples, &mut weights, &mut mu);
            weights
        })
    };
    for form in [Form::Residuals, Form::Weights] {
        let one = run(form, 1);
        for threads in [2, 3] {
            assert!(run(form, threads) == one, "{form:?} with {threads} threads");
        }
    }
}
