//! The actuator as built against SciPy's integration of independently written equations
//! (`tests/oracle/rig_oracle.py`).
use rig::{Drive, Extras, Input, Output, Rig};
use serde_json::Value;

const GOLDEN: &str = include_str!("../../../tests/oracle/rig_golden.json");

/// `offset + Σ amplitude·sin(2π·frequency·t + phase)`, and its derivative.
fn wave(value: &Value, t: f64) -> (f64, f64) {
    let number = |v: &Value| v.as_f64().expect("a number");
    let mut sum = (number(&value["offset"]), 0.0);
    for term in value["terms"].as_array().expect("terms") {
        let [amplitude, frequency, phase] = [0, 1, 2].map(|k| number(&term[k]));
        let w = std::f64::consts::TAU * frequency;
        sum.0 += amplitude * (w * t + phase).sin();
        sum.1 += amplitude * w * (w * t + phase).cos();
    }
    sum
}

/// The oracle's parameters are those of the actuator as built, name by name.
#[test]
fn the_oracle_has_the_same_parameters() {
    let golden: Value = serde_json::from_str(GOLDEN).expect("JSON");
    let ours = serde_json::to_value(Extras::AS_BUILT).expect("JSON");
    for (group, fields) in ours.as_object().expect("groups") {
        for (field, value) in fields.as_object().expect("fields") {
            if value.is_f64() {
                assert_eq!(golden["extras"][group][field], *value, "{group}.{field}");
            } else {
                assert_eq!(
                    *value,
                    Value::Bool(group != "damping"),
                    "{group}.{field}: the oracle knows no switch but that of the damping"
                );
            }
        }
    }
}

/// The output of a column of the golden file.
fn column(name: &str, y: &Output) -> f64 {
    match name {
        "F" => y.F,
        "F_mean" => y.F_mean,
        "i_d" => y.i_d,
        "i_q" => y.i_q,
        "theta_m" => y.theta_m,
        "w_m" => y.w_m,
        "z" => y.presliding,
        "x" => y.x_rod,
        "x_dot" => y.x_rod_dot,
        "T_w" => y.T_winding,
        "T_h" => y.T_housing,
        "tau_e" => y.tau_e,
        other => panic!("column {other}"),
    }
}

/// Every column to 1 % of its peak (temperatures: of their change) through stiction, presliding and
/// play, with all extras on. The substeps leave far less, see what is printed; the bound is what is
/// promised.
#[test]
fn stiction_and_backlash_agree_with_scipy() {
    let golden: Value = serde_json::from_str(GOLDEN).expect("JSON");
    let (h, every) = (
        golden["step"].as_f64().expect("s"),
        golden["every"].as_u64().expect("steps"),
    );
    for case in golden["cases"].as_array().expect("cases") {
        let drive = match case["drive"].as_str() {
            Some("motion") => Drive::Motion,
            _ => Drive::Force,
        };
        let p = machine_file::Machine::reference().emla.lift;
        let mut extras = Extras::AS_BUILT;
        extras.damping.on = case["damping"] == Value::Bool(true);
        extras.switching.offset = case["offset"].as_f64().unwrap_or(0.0);
        let rig = Rig::new(p, extras, drive).expect("valid");
        let input = |t: f64| {
            let (x, x_dot) = wave(&case["x"], t);
            Input {
                v_d: wave(&case["v_d"], t).0,
                v_q: wave(&case["v_q"], t).0,
                v_dc: golden["v_dc"].as_f64(),
                T_ambient: golden["T_ambient"].as_f64().expect("K"),
                x,
                x_dot,
                F_ext: wave(&case["F_ext"], t).0,
                F_hold: case["F_hold"].as_f64().expect("N"),
                ..Input::default()
            }
        };
        let T = [0, 1].map(|k| case["T_start"][k].as_f64().expect("K"));
        let first = Input {
            x_dot: 0.0,
            ..input(0.0)
        };
        let mut s = rig.start(&first, T).expect("finite");
        let names: Vec<&str> = golden["columns"]
            .as_array()
            .expect("columns")
            .iter()
            .map(|c| c.as_str().expect("name"))
            .collect();
        let rows = case["rows"].as_array().expect("rows");
        let (mut worst, mut peak) = (vec![0.0_f64; names.len()], vec![0.0_f64; names.len()]);
        for (n, row) in (0..).zip(rows) {
            let y = rig.output(&s, &input(n as f64 * every as f64 * h));
            for (k, name) in names.iter().enumerate() {
                let expected = row[k].as_f64().expect("a number");
                let zero = if name.starts_with("T_") {
                    rows[0][k].as_f64().expect("K")
                } else {
                    0.0
                };
                worst[k] = worst[k].max((column(name, &y) - expected).abs());
                peak[k] = peak[k].max((expected - zero).abs());
            }
            for j in 0..every {
                let t = (n * every + j) as f64 * h;
                s = rig.step(&s, &input(t), t, h).expect("finite");
            }
        }
        for (k, name) in names.iter().enumerate() {
            println!(
                "{:?} {name}: {:.2e} of {:.4e}",
                drive,
                worst[k] / peak[k],
                peak[k]
            );
        }
        for (k, name) in names.iter().enumerate() {
            assert!(
                worst[k] <= 0.01 * peak[k],
                "{drive:?} {name}: {} of {}",
                worst[k],
                peak[k]
            );
        }
    }
}
