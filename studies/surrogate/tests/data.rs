//! A user's CSV: what is read, and what is refused with which words.

use std::collections::BTreeSet;

use surrogate::measurement::data::{FEWEST_ROWS, Row, parse_csv, to_csv};
use surrogate::training::lm::Samples;
use surrogate::training::progress::TrainingData;

fn rows(count: usize) -> Vec<Row> {
    let row = |k: usize| {
        let k = k as f64;
        Row {
            tau_e: 0.5 * k,
            w_m: k + 1.0,
            f_ext: 100.0 * k,
            x_dot: 0.001 * k,
            ..Row::default()
        }
    };
    (0..count).map(row).collect()
}

fn csv() -> String {
    to_csv(&rows(FEWEST_ROWS), &[], "made up")
}

fn refusal(text: &str) -> String {
    format!(
        "{:#}",
        parse_csv("rig.csv", text).expect_err("must be refused")
    )
}

#[test]
fn written_rows_are_read_back() {
    let data = parse_csv("rig.csv", &csv()).expect("valid");
    assert_eq!(data.inputs[3], [1.5, 4.0]);
    assert_eq!(data.targets[3], [300.0, 0.003]);
    assert_eq!(data.origin, "made up");
    assert_eq!(data.sha256.len(), 64);
}

/// Any order of columns, further columns, no units, comments in between.
#[test]
fn a_users_layout_is_read() {
    let mut text = String::from("time,x_dot,F_ext,w_m,tau_e\n# warm\n");
    for k in 0..FEWEST_ROWS {
        text += &format!("{k}, {}, {}, {}, {}\n", 0.1 + k as f64, 7 * k, k + 2, 3 * k);
    }
    let data = parse_csv("rig.csv", &text).expect("valid");
    assert_eq!((data.inputs[2], data.targets[2]), ([6.0, 4.0], [14.0, 2.1]));
}

#[test]
fn refusals_name_file_line_and_column() {
    let text = csv();
    assert_eq!(
        refusal(&text.replace("w_m [rad/s]", "speed")),
        "rig.csv, line 2: column w_m [rad/s] is missing"
    );
    assert_eq!(
        refusal(&text.replace("w_m [rad/s]", "w_m [rpm]")),
        "rig.csv, line 2, column w_m: unit [rpm] where [rad/s] is needed"
    );
    let broken = |from: &str, to: &str| refusal(&text.replacen(from, to, 1));
    assert_eq!(
        broken(
            "0,0,0,0,1.5,4,300,0.003,0,0,0",
            "0,0,0,0,1.5,4,three,0.003,0,0,0"
        ),
        "rig.csv, line 6, column F_ext: `three` is not a finite number"
    );
    assert_eq!(
        broken(
            "0,0,0,0,1.5,4,300,0.003,0,0,0",
            "0,0,0,0,NaN,4,300,0.003,0,0,0"
        ),
        "rig.csv, line 6, column tau_e: `NaN` is not a finite number"
    );
    assert_eq!(
        broken(
            "0,0,0,0,1.5,4,300,0.003,0,0,0",
            "0,0,0,0,1.5,4,300,0.003,0,0"
        ),
        "rig.csv: not a table: CSV error: record 4 (line: 6, byte: 202): found record with 10 fields, \
         but the previous record has 11 fields"
    );
}

#[test]
fn too_few_rows_and_constant_columns_are_refused() {
    assert_eq!(
        refusal(&to_csv(&rows(FEWEST_ROWS - 1), &[], "short")),
        "rig.csv, after line 2: 49 rows, at least 50 are needed"
    );
    let mut held = rows(FEWEST_ROWS);
    held.iter_mut().for_each(|row| row.x_dot = 0.02);
    assert_eq!(
        refusal(&to_csv(&held, &[], "held")),
        "rig.csv, after line 2, column x_dot: constant (0.02 in every row), nothing can be learnt \
         from it"
    );
    assert!(refusal("").contains("column tau_e [N.m] is missing"));
}

/// What a row of motion backwards says, its mirror image says of motion forwards.
#[test]
fn motion_backwards_is_mirrored() {
    let text = csv().replacen(
        "0,0,0,0,1.5,4,300,0.003,0,0,0",
        "0,0,0,0,-1.5,-4,-300,-0.003,0,0,0",
        1,
    );
    let (mirrored, plain) = (parse_csv("rig.csv", &text), parse_csv("rig.csv", &csv()));
    let (mirrored, plain) = (mirrored.expect("valid"), plain.expect("valid"));
    assert_ne!(text, csv());
    assert_eq!(mirrored.inputs, plain.inputs);
    assert_eq!(mirrored.targets, plain.targets);
}

/// Of 20 profiles 14 are trained on, 4 stop the training and 2 test it; no profile is in two parts.
/// Force 100·k tells a row's profile.
#[test]
fn profiles_are_held_out_whole() {
    let numbers: Vec<u32> = (0..100).map(|k| k / 5).collect();
    let data = parse_csv("rig.csv", &to_csv(&rows(100), &numbers, "made up")).expect("valid");
    assert_eq!(data.profiles[7], 1);
    let range = TrainingData::new(data.clone(), 3).ranges.f_ext;
    let samples = TrainingData::new(data, 3).samples;
    let parts = [samples.training, samples.validation, samples.test].map(|part| {
        let profile = |t: &[f64; 2]| (range.unscale(t[0]) / 500.0 + 1e-9) as u32;
        part.targets.iter().map(profile).collect::<BTreeSet<_>>()
    });
    assert_eq!(parts.each_ref().map(BTreeSet::len), [14, 4, 2]);
    assert_eq!(parts.iter().flatten().collect::<BTreeSet<_>>().len(), 20);
    let wrong = "# c\nprofile,tau_e,w_m,F_ext,x_dot\n-1,1,1,1,1\n";
    assert_eq!(
        refusal(wrong),
        "rig.csv, line 3, column profile: `-1` must be a whole number from 0 on"
    );
}

/// Three samples in one cell of 2 × 2, one in another: means by hand.
#[test]
fn samples_are_averaged_by_cell() {
    let samples = Samples {
        inputs: vec![[0.2, 0.1], [0.9, -0.5], [0.4, 0.3], [0.6, 0.8]],
        targets: vec![[1.0, 2.0], [7.0, 8.0], [3.0, 4.0], [8.0, 0.0]],
    };
    let means = samples.cell_means(2);
    assert_eq!(means.targets, [[7.0, 8.0], [4.0, 2.0]]);
    let expected = [[0.9, -0.5], [0.4, 0.4]];
    for (found, expected) in means.inputs.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() < 1e-15);
    }
}
