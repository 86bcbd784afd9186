//! A warm drive against SciPy's DOP853 (`tests/oracle/heat_oracle.py`): temperatures, losses and
//! heat over half a second of motoring and generating, resistance and magnets following their
//! temperatures.
use emla::{Drive, Electric, Emla, Input};
use machine::Machine;
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, TAU};

#[derive(Deserialize)]
struct Golden {
    air: f64,
    start: [f64; 2],
    F_hold: f64,
    x: Wave,
    volts: Vec<[f64; 2]>,
    rows: Vec<[f64; 5]>,
}

/// `offset + Σ amplitude·sin(2π·frequency·t + phase)`.
#[derive(Deserialize)]
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

/// Temperatures, as rises since the start, and energies agree to 1e-6 of the largest of their kind.
#[test]
fn a_warm_drive_follows_the_independent_integration() {
    let text = include_str!("../../../tests/oracle/heat_golden.json");
    let golden: Golden = serde_json::from_str(text).expect("golden file");
    let emla = Emla::new(Machine::reference().emla.lift, Drive::Motion)
        .expect("reference")
        .with_electric(Electric {
            heat: true,
            temperature: true,
            ..Electric::default()
        });
    let input = |t: f64, [v_d, v_q]: [f64; 2]| Input {
        v_d,
        v_q,
        T_ambient: golden.air,
        x: golden.x.at(t, 0),
        x_dot: golden.x.at(t, 1),
        F_hold: golden.F_hold,
        ..Input::default()
    };
    let first = input(0.0, golden.volts[0]);
    let mut s = emla.start_at(&first, golden.start).expect("finite");
    let mut worst = [0.0_f64; 5];
    for (k, &v) in golden.volts.iter().enumerate() {
        let t = k as f64 * 1e-3;
        s = emla
            .step(&s, |after| input(t + after, v), t, 1e-3)
            .expect("finite");
        if (k + 1) % 50 == 0 {
            let y = emla.output(&s, &input(t + 1e-3, v));
            let found = [y.T_winding, y.T_housing, y.E_loss, y.E_inverter, y.E_heat];
            for (worst, (a, b)) in worst.iter_mut().zip(found.iter().zip(golden.rows[k / 50])) {
                *worst = worst.max((a - b).abs());
            }
        }
    }
    let last = golden.rows.last().expect("rows");
    let scale = [
        (last[0] - golden.start[0]).abs(),
        (last[1] - golden.start[1]).abs(),
        last[2],
        last[3],
        last[4],
    ];
    let relative: Vec<f64> = worst.iter().zip(scale).map(|(w, s)| w / s).collect();
    println!("{relative:?} of {scale:?}");
    assert!(
        relative.iter().all(|r| *r < 1e-6),
        "{relative:?} of {scale:?}"
    );
}
