//! Time of one Levenberg–Marquardt iteration of the paper's network, s: `lm_iteration ROWS
//! REPEATS`.
//!
//! `tests/oracle/surrogate_bench.py` runs it side by side with NumPy and SciPy.

use std::time::Instant;

use surrogate::training::lm::{self, Samples};
use surrogate::training::network::Shape;

fn main() {
    let mut arguments = std::env::args()
        .skip(1)
        .map(|a| a.parse::<usize>().expect("a number"));
    let (rows, repeats) = (
        arguments.next().unwrap_or(3000),
        arguments.next().unwrap_or(3),
    );
    let shape = Shape::new(&emla::WIDTHS);
    let inputs: Vec<[f64; 2]> = (0..rows)
        .map(|k| [(1.7 * k as f64).sin(), (0.9 * k as f64 + 0.3).cos()])
        .collect();
    let targets = inputs
        .iter()
        .map(|[x, y]| [0.6 * x * y + 0.1, 0.5 * (x - y).sin()])
        .collect();
    let samples = Samples { inputs, targets };
    let first = shape.initial_weights(1);
    for _ in 0..repeats {
        let (mut weights, mut mu) = (first.clone(), 1.0);
        let clock = Instant::now();
        let outcome = lm::iterate(&shape, &samples, &mut weights, &mut mu);
        println!("{:.4}", clock.elapsed().as_secs_f64());
        assert!(
            outcome == lm::Outcome::Stepped && mu == 0.1,
            "more than one trial step"
        );
    }
}
