//! The actuator against SciPy's DOP853 (`tests/oracle/emla_oracle.py`: flux states, gear constraint solved
//! apart) over 2 s of motoring, generating and load reversal, in both drive modes.
#![allow(non_snake_case)]

use emla::{Drive, Emla, Input, InputPath, State};
use machine::Machine;
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, TAU};

const GOLDEN: &str = include_str!("../../../tests/oracle/emla_golden.json");

#[derive(Deserialize)]
struct Golden {
    h: f64,
    every: usize,
    columns: Vec<String>,
    cases: Cases,
}

#[derive(Deserialize)]
struct Cases {
    motion: Case,
    force: Case,
}

#[derive(Deserialize)]
struct Case {
    x: Wave,
    #[serde(default)]
    F_ext: Wave,
    F_hold: f64,
    volts: Vec<[f64; 2]>,
    rows: Vec<[f64; 6]>,
}

/// `offset + Σ amplitude·sin(2π·frequency·t + phase)`.
#[derive(Default, Deserialize)]
struct Wave {
    offset: f64,
    terms: Vec<[f64; 3]>,
}

impl Wave {
    fn at(&self, t: f64, order: i32) -> f64 {
        let offset = if order == 0 { self.offset } else { 0.0 };
        let term = |&[amplitude, frequency, phase]: &[f64; 3]| {
            let w = TAU * frequency;
            amplitude * w.powi(order) * (w * t + phase + f64::from(order) * FRAC_PI_2).sin()
        };
        offset + self.terms.iter().map(term).sum::<f64>()
    }
}

/// Largest deviations from the golden rows.
#[derive(Debug, Default)]
struct Worst {
    F: f64,
    F_mean: f64,
    current: f64,
    speed: f64,
    position: f64,
}

fn path(case: &Case, t: f64, [v_d, v_q]: [f64; 2]) -> InputPath {
    let derivative = |order: i32| Input {
        x_dot: case.x.at(t, order + 1),
        F_ext: case.F_ext.at(t, order),
        ..Input::default()
    };
    InputPath {
        u: Input {
            v_d,
            v_q,
            x: case.x.at(t, 0),
            F_hold: case.F_hold,
            ..derivative(0)
        },
        derivatives: [derivative(1), derivative(2), derivative(3)],
    }
}

fn compare(golden: &Golden, case: &Case, drive: Drive) -> Worst {
    assert_eq!(golden.columns, ["F", "F_mean", "i_d", "i_q", "w_m", "x"]);
    let emla = Emla::new(Machine::reference().emla, drive).expect("reference");
    let mut s: State = emla.start(&path(case, 0.0, [0.0; 2]).u).expect("finite");
    let mut worst = Worst::default();
    let grow = |worst: &mut f64, a: f64, b: f64| *worst = worst.max((a - b).abs());
    for k in 0..=case.volts.len() {
        let t = k as f64 * golden.h;
        let v = case.volts.get(k).copied().unwrap_or_default();
        let path = path(case, t, v);
        if k % golden.every == 0 {
            let [F, F_mean, i_d, i_q, w_m, x] = case.rows[k / golden.every];
            let y = emla.output(&s, &path.u);
            grow(&mut worst.F, y.F, F);
            grow(&mut worst.F_mean, y.F_mean, F_mean);
            grow(&mut worst.current, y.i_d, i_d);
            grow(&mut worst.current, y.i_q, i_q);
            grow(&mut worst.speed, y.w_m, w_m);
            grow(&mut worst.position, y.x_rod, x);
        }
        if k < case.volts.len() {
            s = emla.step(&s, &path, t, golden.h).expect("finite");
        }
    }
    worst
}

/// Wanted: 0.2 N of 53 kN; held here to a tenth of it (measured 0.007 N). RK4's error here comes from the kinks of the gear factor where the
/// load changes sign, and (free rod) from the fast rod mode, 11 500/s.
#[test]
fn force_follows_the_independent_integration() {
    let golden: Golden = serde_json::from_str(GOLDEN).expect("golden file");
    for (case, drive) in [
        (&golden.cases.motion, Drive::Motion),
        (&golden.cases.force, Drive::Force),
    ] {
        let worst = compare(&golden, case, drive);
        println!("{drive:?}: {worst:?}");
        assert!(
            worst.F < 0.02 && worst.F_mean < 0.02,
            "{drive:?}: {worst:?}"
        );
        assert!(worst.current < 2e-5, "{drive:?}: {worst:?}");
        assert!(worst.speed < 3e-5, "{drive:?}: {worst:?}");
        assert!(worst.position < 1e-10, "{drive:?}: {worst:?}");
    }
}
