//! Measures small calls; included by the bench programs of the crates.
//!
//! Without arguments each call is timed in batches and one line of JSON is printed:
//! `{"name":…,"unit":"ns","median":…,"least":…}`. With `--count NAME N` the call NAME runs N times
//! and nothing is printed: for an instruction counter around the program. `cargo xtask bench` uses
//! both.

use std::time::Instant;

const BATCHES: usize = 31;
/// Length of one batch, s.
const BATCH: f64 = 2e-3;

/// What the command line asks for.
pub struct Bench {
    count: Option<(String, u64)>,
}

impl Bench {
    /// Reads the command line; what cargo adds to it is ignored.
    pub fn from_arguments() -> Self {
        let arguments: Vec<String> = std::env::args().collect();
        let at = arguments.iter().position(|a| a == "--count");
        let count = at.map(|at| {
            let number = arguments[at + 2].parse().expect("--count NAME N");
            (arguments[at + 1].clone(), number)
        });
        Self { count }
    }

    /// Measures one call.
    pub fn call(&self, name: &str, mut call: impl FnMut()) {
        if let Some((chosen, count)) = &self.count {
            if chosen == name {
                (0..*count).for_each(|_| call());
            }
            return;
        }
        let mut batch = |calls: u32| {
            let start = Instant::now();
            (0..calls).for_each(|_| call());
            start.elapsed().as_secs_f64()
        };
        let mut calls = 1;
        while batch(calls) < 0.5 * BATCH {
            calls *= 2;
        }
        let mut times: Vec<f64> = (0..BATCHES)
            .map(|_| 1e9 * batch(calls) / f64::from(calls))
            .collect();
        times.sort_by(f64::total_cmp);
        let (median, least) = (times[BATCHES / 2], times[0]);
        println!(r#"{{"name":"{name}","unit":"ns","median":{median:.1},"least":{least:.1}}}"#);
    }
}
