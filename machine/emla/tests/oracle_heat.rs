//! A warm drive against SciPy's DOP853 (`tests/oracle/heat_oracle.py`): temperatures, losses and
//! heat over half a second of motoring and generating, resistance and magnets following their
//! temperatures.
use emla::{Drive, Electric, Emla, Input};
use machine_file::Machine;
use serde::Deserialize;

use super::golden::{Row, Wave};

#[derive(Deserialize)]
struct Golden {
    air: f64,
    start: [f64; 2],
    F_hold: f64,
    x: Wave,
    rows: Vec<Row<[f64; 5]>>,
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
    let first = input(0.0, golden.rows[0].volts[0]);
    let mut s = emla.start_at(&first, golden.start).expect("finite");
    let mut worst = [0.0_f64; 5];
    let mut k = 0;
    for row in &golden.rows {
        for &v in &row.volts {
            let t = f64::from(k) * 1e-3;
            s = emla
                .step(&s, |after| input(t + after, v), t, 1e-3)
                .expect("finite");
            k += 1;
        }
        let held = *row.volts.last().expect("voltages");
        let y = emla.output(&s, &input(f64::from(k) * 1e-3, held));
        let found = [y.T_winding, y.T_housing, y.E_loss, y.E_inverter, y.E_heat];
        for (worst, (a, b)) in worst.iter_mut().zip(found.iter().zip(row.state)) {
            *worst = worst.max((a - b).abs());
        }
    }
    let last = golden.rows.last().expect("rows").state;
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
