//! The link and a published cell against SciPy's integration of independently written equations
//! (`tests/oracle/dclink_oracle.py`).
use dclink::{Battery, DcLink, Input, POINTS, Pack, Params, State};
use serde_json::Value;

const GOLDEN: &str = include_str!("../../../tests/oracle/dclink_golden.json");

fn golden() -> Value {
    serde_json::from_str(GOLDEN).expect("JSON")
}

fn number(v: &Value) -> f64 {
    v.as_f64().expect("a number")
}

fn numbers<const N: usize>(v: &Value) -> [f64; N] {
    std::array::from_fn(|k| number(&v[k]))
}

/// The link that the oracle integrates.
fn link(golden: &Value, case: &Value) -> DcLink {
    let p = &golden["parameters"];
    let of = |name: &str| number(&p[name]);
    let mut params = Params::REFERENCE;
    params.battery = Battery {
        cells: 200,
        capacity: of("capacity"),
        ocv: numbers::<POINTS>(&p["ocv"]),
        R_0: of("R_0"),
        R: numbers(&p["R"]),
        tau: numbers(&p["tau"]),
        discharge_limit: of("discharge_limit"),
        charge_limit: of("charge_limit"),
        soc_low: of("soc_low"),
        soc_high: of("soc_high"),
        heat_capacity: of("heat_capacity"),
        heat_resistance: of("heat_resistance"),
        soc_start: number(&case["soc_start"]),
        T_start: of("T_start"),
    };
    (params.link.C, params.link.R) = (of("C"), of("R_line"));
    (params.brake.R, params.brake.v_on, params.brake.v_off) =
        (of("R_brake"), of("v_on"), of("v_off"));
    (params.precharge.R, params.precharge.share) = (of("R_precharge"), of("share"));
    params.precharge.on = case["precharge"] == true;
    DcLink::new(params).expect("valid")
}

/// `offset + Σ amplitude·sin(2π·frequency·t + phase)`.
fn wave(load: &Value, t: f64) -> f64 {
    let terms = load.as_array().expect("terms");
    let sines = terms[1..].iter().map(|term| {
        let [amplitude, frequency, phase] = numbers(term);
        amplitude * (std::f64::consts::TAU * frequency * t + phase).sin()
    });
    number(&terms[0]) + sines.sum::<f64>()
}

/// The state's value of a column of the golden file.
fn column(name: &str, s: &State, link: &DcLink) -> f64 {
    match name {
        "soc" => s.soc,
        "v_1" => s.v[0],
        "v_2" => s.v[1],
        "v_dc" => s.v_c,
        "T" => s.T,
        "battery" => s.energy.battery,
        "load" => s.energy.load,
        "brake" => s.energy.brake,
        "loss" => s.energy.loss,
        "i" => link.output(s).i_battery,
        "braking" => f64::from(s.mode.braking),
        "ready" => f64::from(s.mode.ready),
        other => panic!("column {other}"),
    }
}

/// Pack within and at its limits, chopper, precharge: every column agrees to 1e-6 of its largest
/// magnitude, in which the charge and the temperature count by their change. The method's own bound
/// is 3e-7 of a step response, and most of what is compared is none.
#[test]
fn pack_chopper_and_precharge_agree_with_scipy() {
    let golden = golden();
    let h = number(&golden["h"]);
    let shares: [f64; 3] = numbers(&golden["shares"]);
    for (name, case) in golden["cases"].as_object().expect("cases") {
        let link = link(&golden, case);
        let load = |k: u32| {
            let sum = wave(&case["load"], f64::from(k) * h);
            Input {
                i_load: shares.map(|share| share * sum),
                T_ambient: number(&golden["parameters"]["T_ambient"]),
            }
        };
        let start = link.start(&load(0));
        let columns = case["columns"].as_array().expect("columns");
        let rows = case["rows"].as_array().expect("rows");
        let (mut s, mut k) = (start, 0);
        let mut worst = vec![0.0_f64; columns.len()];
        let mut size = vec![0.0_f64; columns.len()];
        for row in rows {
            let t = number(&row[0]);
            while f64::from(k) < t / h - 0.5 {
                s = link
                    .step(&s, &load(k), f64::from(k) * h, h)
                    .expect("finite");
                k += 1;
            }
            for (c, column_name) in columns.iter().enumerate().skip(1) {
                let column_name = column_name.as_str().expect("a name");
                let zero = match column_name {
                    "soc" | "T" => column(column_name, &start, &link),
                    _ => 0.0,
                };
                let expected = number(&row[c]);
                size[c] = size[c].max((expected - zero).abs());
                worst[c] = worst[c].max((column(column_name, &s, &link) - expected).abs());
            }
        }
        for (c, column_name) in columns.iter().enumerate().skip(1) {
            println!("{name} {column_name}: {:e} of {:e}", worst[c], size[c]);
            assert!(
                worst[c] <= 1e-6 * size[c],
                "{name}, {column_name}: {:e} of {:e}",
                worst[c],
                size[c]
            );
        }
        assert!(number(&case["events"]) >= 2.0, "{name} has events");
    }
}

/// `Modelica.Electrical.Batteries.Examples.CCCV_CellRC` of the Modelica Standard Library 4.0.0: a
/// cell of 5 A·h with two RC elements, charged with 25 A to 4.2 V and then at 4.2 V. The pack's
/// equations, integrated by Runge–Kutta of order 4 in steps of 0.05 s (errs by (h/τ)⁴/120 = 5e-12
/// with τ = 10 s); straight lines of the table bend where its points are passed, which costs at
/// most a step's worth of slope. The library's text says that the cell is nearly full, and the
/// charger changes over, before 0.9·3600 s/5 = 648 s.
#[test]
fn the_cell_of_the_modelica_standard_library_is_charged_as_there() {
    let golden = golden();
    let cell = &golden["cell"];
    let of = |name: &str| number(&cell[name]);
    let mut battery = Params::REFERENCE.battery;
    battery.cells = 1;
    battery.capacity = of("charge") / 3600.0;
    battery.ocv = numbers::<POINTS>(&cell["ocv"]);
    (battery.R_0, battery.R, battery.tau) = (of("R_0"), numbers(&cell["R"]), numbers(&cell["tau"]));

    let pack = Pack::new(&battery);

    type Cell = [f64; 3];
    let inner = |x: &Cell| pack.open_circuit(x[0]) - x[1] - x[2];
    let drawn = |x: &Cell, is_held: bool| {
        if is_held {
            (inner(x) - of("V")) / battery.R_0
        } else {
            -of("I")
        }
    };
    let rates = |x: &Cell, is_held: bool| {
        let i = drawn(x, is_held);
        let [v_1, v_2] = pack.pair_rates([x[1], x[2]], i);
        [pack.soc_rate(i), v_1, v_2]
    };
    let moved = |x: &Cell, k: &Cell, h: f64| [0, 1, 2].map(|n| x[n] + h * k[n]);
    let stepped = |x: &Cell, is_held: bool, h: f64| {
        let k_1 = rates(x, is_held);
        let k_2 = rates(&moved(x, &k_1, h / 2.0), is_held);
        let k_3 = rates(&moved(x, &k_2, h / 2.0), is_held);
        let k_4 = rates(&moved(x, &k_3, h), is_held);
        [0, 1, 2].map(|n| x[n] + h / 6.0 * (k_1[n] + 2.0 * k_2[n] + 2.0 * k_3[n] + k_4[n]))
    };
    let terminal = |x: &Cell, is_held: bool| inner(x) - battery.R_0 * drawn(x, is_held);

    let (h, mut x, mut is_held, mut switch) = (0.05, [of("soc_start"), 0.0, 0.0], false, 0.0);
    let rows = cell["rows"].as_array().expect("rows");
    let (mut k, mut next) = (0_u32, 0);
    while next < rows.len() {
        let t = f64::from(k) * h;
        let end = stepped(&x, is_held, h);
        if !is_held && terminal(&end, false) > of("V") {
            let (mut low, mut high) = (0.0, h);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if terminal(&stepped(&x, false, middle), false) > of("V") {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            (switch, is_held) = (t + high, true);
            x = stepped(&stepped(&x, false, high), true, h - high);
        } else {
            x = end;
        }
        k += 1;
        if f64::from(k) * h > number(&rows[next][0]) - 0.5 * h {
            let [t, soc, v, i] = numbers(&rows[next]);
            let found = [x[0], terminal(&x, is_held), -drawn(&x, is_held)];
            for (found, expected, size) in [
                (found[0], soc, 1.0),
                (found[1], v, 4.2),
                (found[2], i, 25.0),
            ] {
                assert!(
                    (found - expected).abs() < 1e-6 * size,
                    "t = {t} s: {found} {expected}"
                );
            }
            next += 1;
        }
    }
    assert!((switch - of("switch")).abs() < 1e-4, "{switch}");
    assert!(switch < 648.0 && x[0] > 0.9999, "{switch} {}", x[0]);
}
