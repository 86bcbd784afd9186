//! A whole training run, small: same seed same weights, interruption and resumption.

use surrogate::measurement::data::{Row, parse_csv, to_csv};
use surrogate::training::progress::{Progress, TrainingData};

const WIDTHS: [usize; 4] = [2, 6, 5, 2];

fn prepared(seed: u64) -> TrainingData {
    let row = |k: u32| {
        let (a, b) = (
            (1.3 * f64::from(k)).sin(),
            0.5 + 0.5 * (0.7 * f64::from(k)).cos(),
        );
        let (tau_e, w_m) = (30.0 * a, 160.0 * b);
        let f_ext = 2300.0 * tau_e - 900.0 * (3.0 * b).sin();
        Row {
            tau_e,
            w_m,
            f_ext,
            x_dot: 0.000_424 * w_m,
            ..Row::default()
        }
    };
    let rows: Vec<Row> = (0..200).map(row).collect();
    TrainingData::new(
        parse_csv("made.csv", &to_csv(&rows, &[], "made up")).expect("valid"),
        seed,
    )
}

fn run(progress: &mut Progress, prepared: &TrainingData, epochs: u32) {
    while progress.stop.is_none() && progress.epoch < epochs {
        progress.epoch(prepared, 60);
    }
}

#[test]
fn same_seed_same_network_and_it_learns() {
    let train = |seed| {
        let data = prepared(seed);
        let mut progress = Progress::start(&WIDTHS, seed, &data);
        run(&mut progress, &data, 60);
        progress.network(&data)
    };
    let (a, b, other) = (train(5), train(5), train(6));
    assert_eq!(a.layers, b.layers);
    assert_ne!(a.layers, other.layers);
    let mse = a.training.mse;
    assert!(mse.test < 1e-5 && mse.training < 1e-5, "{mse:?}");
    let rows = a.training.rows;
    assert_eq!((rows.training, rows.validation, rows.test), (140, 40, 20));
}

#[test]
fn a_resumed_run_is_the_same_run() {
    let data = prepared(5);
    let mut whole = Progress::start(&WIDTHS, 5, &data);
    run(&mut whole, &data, 12);
    let mut part = Progress::start(&WIDTHS, 5, &data);
    run(&mut part, &data, 5);
    let file =
        std::env::temp_dir().join(format!("surrogate-checkpoint-{}.json", std::process::id()));
    part.save(&file).expect("saved");
    let mut part = Progress::resume(&file, &WIDTHS, 5, &data).expect("resumed");
    run(&mut part, &data, 12);
    part.seconds = whole.seconds;
    assert_eq!(part, whole);

    let refuse = |seed, data: &TrainingData| {
        format!(
            "{:#}",
            Progress::resume(&file, &WIDTHS, seed, data).expect_err("refused")
        )
    };
    assert!(refuse(6, &data).contains("belongs to seed 5"));
    std::fs::write(&file, "{}").expect("written");
    assert!(refuse(5, &data).contains("not a checkpoint"));
    std::fs::remove_file(&file).expect("removed");
}
