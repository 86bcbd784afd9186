//! Derivatives of the outputs against JAX (`tests/oracle/derivatives.py`: a model of its own,
//! differentiated automatically, losses of the mechanics from the balance of power) at random
//! states, in both drive modes, inside and beyond the voltage limit.
use std::collections::BTreeMap;

use emla::{Drive, Emla, Input, Output, Residual, State, Surrogate};
use machine_file::Machine;
use serde::Deserialize;

const GOLDEN: &str = include_str!("../../../tests/oracle/derivatives.json");
/// Blending factor of the test; the golden file holds alpha·dF.
const ALPHA: f64 = 0.5;

#[derive(Deserialize)]
struct Golden {
    emla: Vec<Case>,
}

type Named = BTreeMap<String, f64>;

#[derive(Deserialize)]
struct Case {
    drive: Drive,
    state: Named,
    u: Named,
    du: Named,
    u_dot: Named,
    along: Named,
    rate: Named,
}

fn input(named: &Named) -> Input {
    Input {
        v_d: named["v_d"],
        v_q: named["v_q"],
        x: named["x"],
        x_dot: named["x_dot"],
        F_ext: named["F_ext"],
        ..Input::default()
    }
}

fn state(named: &Named) -> State {
    State {
        i_d: named["i_d"],
        i_q: named["i_q"],
        theta_m: named["theta_m"],
        w_m: named["w_m"],
        x: named["x"],
        x_dot: named["x_dot"],
        residual: Residual {
            dF: named["alpha_dF"] / ALPHA,
            ..Residual::default()
        },
        ..State::default()
    }
}

/// An output by its name in the FMU's Rust structure, and the size of the numbers that its
/// derivatives are made of, per second or along the direction: what the rounding is measured with.
type Row = (&'static str, fn(&Output) -> f64, f64);

const ROWS: &[Row] = &[
    ("F", |y| y.F, 1e7),
    ("F_phys", |y| y.F_phys, 1e7),
    ("x_rod", |y| y.x_rod, 1.0),
    ("x_rod_dot", |y| y.x_rod_dot, 1e4),
    ("i_d", |y| y.i_d, 1e5),
    ("i_q", |y| y.i_q, 1e5),
    ("theta_m", |y| y.theta_m, 1e2),
    ("w_m", |y| y.w_m, 1e4),
    ("tau_e", |y| y.tau_e, 1e5),
    ("P_in", |y| y.P_in, 1e8),
    ("P_out", |y| y.P_out, 1e8),
    ("P_copper", |y| y.P_copper, 1e6),
    ("P_core", |y| y.P_core, 1e6),
    ("P_inverter", |y| y.P_inverter, 1e6),
    ("P_loss", |y| y.P_loss, 1e8),
    ("P_mech", |y| y.P_mech, 1e8),
    ("E_stored", |y| y.E_stored, 1e6),
    ("E_in", |y| y.E_in, 1e5),
    ("E_out", |y| y.E_out, 1e5),
    ("E_loss", |y| y.E_loss, 1e5),
];

/// Worst error of a derivative relative to its row's size and to itself.
fn worst(found: &Output, expected: &Named) -> (f64, &'static str) {
    let error = |&(name, get, size): &Row| {
        let expected = expected.get(name)?;
        let scale = size + expected.abs();
        Some(((get(found) - expected).abs() / scale, name))
    };
    let errors = ROWS.iter().filter_map(error);
    errors.fold((0.0, ""), |a, b| if b.0 > a.0 { b } else { a })
}

/// Tolerance: both codes round some 100 operations, 100 ε of the numbers above. A forgotten term is
/// larger by ten orders.
#[test]
fn derivatives_equal_those_of_jax() {
    let golden: Golden = serde_json::from_str(GOLDEN).expect("golden file");
    let tolerance = 100.0 * f64::EPSILON;
    let mut largest: f64 = 0.0;
    for (k, case) in golden.emla.iter().enumerate() {
        let emla = Emla::new(Machine::reference().emla.lift, case.drive)
            .expect("reference")
            .with_surrogate(Surrogate::reference(), ALPHA);
        let (s, u) = (state(&case.state), input(&case.u));
        for (what, found, expected) in [
            (
                "along",
                emla.output_along(&s, &u, &input(&case.du)),
                &case.along,
            ),
            (
                "rate",
                emla.output_dot(&s, &u, &input(&case.u_dot)),
                &case.rate,
            ),
        ] {
            let (error, name) = worst(&found, expected);
            largest = largest.max(error);
            assert!(
                error < tolerance,
                "case {k}, {what}: {name} off by {error:e}"
            );
        }
    }
    println!("largest error of {} states: {largest:e}", golden.emla.len());
    assert!(golden.emla.len() >= 40);
}
