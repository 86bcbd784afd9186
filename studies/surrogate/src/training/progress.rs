//! The run of the command `train`: splits the data, iterates, stops early, keeps the best network,
//! and resumes from a checkpoint. The command `plots` takes its test rows.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use emla::{Ranges, Split, SurrogateFile, TrainingRecord};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::measurement::data::Data;
use crate::training::lm::{self, Outcome, Samples};
use crate::training::network::{Shape, column_range, scaled};

/// Largest number of epochs.
pub const EPOCHS: u32 = 1000;
/// Number of epochs in a row without a new smallest validation error that ends the training.
const FAILURES: u32 = 30;

/// Scaled and split data.
#[derive(Clone, Debug)]
pub struct TrainingData {
    /// Ranges of the columns.
    pub ranges: Ranges,
    /// 70 %, 20 % and 10 % of the rows.
    pub samples: Split<Samples>,
    data: Data,
}

impl TrainingData {
    /// Scales all rows by `mapminmax`, then splits them 70:20:10 by seed: by rows, or by profiles
    /// if the data name these.
    pub fn new(data: Data, seed: u64) -> Self {
        let ranges = Ranges {
            tau_e: column_range(&data.inputs, 0),
            w_m: column_range(&data.inputs, 1),
            f_ext: column_range(&data.targets, 0),
            x_dot: column_range(&data.targets, 1),
        };
        let inputs = scaled(&data.inputs, [ranges.tau_e, ranges.w_m]);
        let targets = scaled(&data.targets, [ranges.f_ext, ranges.x_dot]);
        let (order, ends) = shuffled(&data, seed);
        let part = |rows: &[usize]| Samples {
            inputs: rows.iter().map(|&r| inputs[r]).collect(),
            targets: rows.iter().map(|&r| targets[r]).collect(),
        };
        let samples = Split {
            training: part(&order[..ends[0]]),
            validation: part(&order[ends[0]..ends[1]]),
            test: part(&order[ends[1]..]),
        };
        Self {
            ranges,
            samples,
            data,
        }
    }

    /// Replaces the rows of each part by their means in `cells` × `cells` cells of torque and
    /// speed: dense data lose noise, and all of the map has the same weight.
    pub fn cell_means(self, cells: u32) -> Self {
        let samples = self.each(|s| s.cell_means(cells));
        Self { samples, ..self }
    }

    fn mse(&self, shape: &Shape, weights: &[f64]) -> Split<f64> {
        self.each(|s| s.mse(shape, weights))
    }

    fn each<T>(&self, f: impl Fn(&Samples) -> T) -> Split<T> {
        let samples = &self.samples;
        Split {
            training: f(&samples.training),
            validation: f(&samples.validation),
            test: f(&samples.test),
        }
    }
}

/// Inputs and targets of the rows that a training with this seed would test.
pub fn test_rows(data: &Data, seed: u64) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    let (order, ends) = shuffled(data, seed);
    let rows = order[ends[1]..].iter();
    rows.map(|&row| (data.inputs[row], data.targets[row]))
        .unzip()
}

/// Rows in the order of the split, and the ends of its first two parts.
fn shuffled(data: &Data, seed: u64) -> (Vec<usize>, [usize; 2]) {
    let rows = data.inputs.len();
    let rng = &mut ChaCha8Rng::seed_from_u64(seed);
    if data.profiles.is_empty() {
        let mut order: Vec<usize> = (0..rows).collect();
        order.shuffle(rng);
        return (order, [rows * 7 / 10, rows * 9 / 10]);
    }
    let mut profiles = data.profiles.clone();
    profiles.sort_unstable();
    profiles.dedup();
    profiles.shuffle(rng);
    let mut order = Vec::with_capacity(rows);
    let mut ends = [rows; 2];
    for (k, profile) in profiles.iter().enumerate() {
        for (end, tenths) in ends.iter_mut().zip([7, 9]) {
            if k == profiles.len() * tenths / 10 {
                *end = order.len();
            }
        }
        order.extend((0..rows).filter(|&row| data.profiles[row] == *profile));
    }
    (order, ends)
}

/// State of a training run, and content of its checkpoint file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    widths: Vec<usize>,
    seed: u64,
    data_sha256: String,
    /// Iterations taken.
    pub epoch: u32,
    mu: f64,
    weights: Vec<f64>,
    best_weights: Vec<f64>,
    best_epoch: u32,
    failures: u32,
    /// Mean squared errors before the first epoch and after each.
    pub curve: Vec<Split<f64>>,
    /// Why the training ended; none while it goes on.
    pub stop: Option<String>,
    /// Time spent, s.
    pub seconds: f64,
}

impl Progress {
    /// A new run.
    pub fn start(widths: &[usize], seed: u64, prepared: &TrainingData) -> Self {
        let shape = Shape::new(widths);
        let weights = shape.initial_weights(seed);
        Self {
            widths: widths.to_vec(),
            seed,
            data_sha256: prepared.data.sha256.clone(),
            epoch: 0,
            mu: lm::MU_START,
            best_weights: weights.clone(),
            best_epoch: 0,
            failures: 0,
            curve: vec![prepared.mse(&shape, &weights)],
            weights,
            stop: None,
            seconds: 0.0,
        }
    }

    /// A run from its checkpoint, which must belong to the same data and seed.
    pub fn resume(
        path: &Path,
        widths: &[usize],
        seed: u64,
        prepared: &TrainingData,
    ) -> Result<Self> {
        let name = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        let mut progress: Self =
            serde_json::from_str(&text).with_context(|| format!("{name}: not a checkpoint"))?;
        if progress.data_sha256 != prepared.data.sha256 {
            bail!(
                "{name}: belongs to other data (sha256 {})",
                progress.data_sha256
            );
        }
        if (progress.seed, &progress.widths[..]) != (seed, widths) {
            bail!(
                "{name}: belongs to seed {} and widths {:?}",
                progress.seed,
                progress.widths
            );
        }
        let shape = Shape::new(widths);
        for weights in [&progress.weights, &progress.best_weights] {
            if weights.len() != shape.weights() || weights.iter().any(|w| !w.is_finite()) {
                bail!("{name}: {} finite weights are needed", shape.weights());
            }
        }
        // A run that used up its epochs may be given more.
        if progress.failures < FAILURES {
            progress.stop = None;
        }
        Ok(progress)
    }

    /// Writes the checkpoint; an interruption cannot damage it.
    pub fn save(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string(self).context("cannot write the checkpoint as JSON")?;
        Ok(output_file::write(path, text)?)
    }

    /// Takes one iteration, and decides whether the training ends.
    pub fn epoch(&mut self, prepared: &TrainingData, epochs: u32) {
        let clock = Instant::now();
        let shape = Shape::new(&self.widths);
        let training = &prepared.samples.training;
        let outcome = lm::iterate(&shape, training, &mut self.weights, &mut self.mu);
        self.stop = match outcome {
            Outcome::Stepped => None,
            Outcome::FlatGradient => Some(format!("gradient below {:e}", lm::GRADIENT_MIN)),
            Outcome::MuMax => Some(format!("mu above {:e}", lm::MU_MAX)),
        };
        if self.stop.is_none() {
            self.epoch += 1;
            let mse = prepared.mse(&shape, &self.weights);
            let best = self.curve[self.best_epoch as usize].validation;
            if mse.validation < best {
                self.best_weights.clone_from(&self.weights);
                self.best_epoch = self.epoch;
                self.failures = 0;
            } else if mse.validation > best {
                self.failures += 1;
            }
            self.curve.push(mse);
            if self.failures >= FAILURES {
                self.stop = Some(format!("{FAILURES} validation failures"));
            } else if self.epoch >= epochs {
                self.stop = Some(format!("{epochs} epochs"));
            }
        }
        self.seconds += clock.elapsed().as_secs_f64();
    }

    /// One line of text: epoch, mu, the three errors, time left if it runs to the last epoch.
    pub fn line(&self, epochs: u32) -> String {
        let mse = self.curve[self.curve.len() - 1];
        let left = self.seconds / f64::from(self.epoch.max(1)) * f64::from(epochs - self.epoch);
        format!(
            "epoch {:4}  mu {:.0e}  mse training {:.3e}  validation {:.3e}  test {:.3e}  \
             failures {:2}  at most {:.0?} left",
            self.epoch,
            self.mu,
            mse.training,
            mse.validation,
            mse.test,
            self.failures,
            Duration::from_secs(left as u64),
        )
    }

    /// The best network so far, with the record of its training.
    pub fn network(&self, prepared: &TrainingData) -> SurrogateFile {
        let shape = Shape::new(&self.widths);
        let correlation = |column: usize| {
            prepared.each(|s| {
                let y = shape.evaluate(&self.best_weights, &s.inputs);
                let pairs = y.iter().zip(&s.targets);
                correlation(pairs.map(|(y, t)| [y[column], t[column]]))
            })
        };
        SurrogateFile {
            training: TrainingRecord {
                data: prepared.data.origin.clone(),
                data_sha256: self.data_sha256.clone(),
                seed: self.seed,
                epochs: self.epoch,
                best_epoch: self.best_epoch,
                stop: self.stop.clone().unwrap_or_else(|| "interrupted".into()),
                rows: prepared.each(|s| s.inputs.len() as u32),
                mse: self.curve[self.best_epoch as usize],
                r_f: correlation(0),
                r_x_dot: correlation(1),
                curve: self.curve.clone(),
            },
            ranges: prepared.ranges,
            layers: shape.to_layers(&self.best_weights),
            efficiency_bound: None,
        }
    }
}

/// Pearson's correlation R of pairs.
fn correlation(pairs: impl Iterator<Item = [f64; 2]> + Clone) -> f64 {
    let n = pairs.clone().count() as f64;
    let [a, b] = pairs
        .clone()
        .fold([0.0; 2], |s, p| [s[0] + p[0] / n, s[1] + p[1] / n]);
    let [aa, ab, bb] = pairs.fold([0.0; 3], |s, p| {
        let (x, y) = (p[0] - a, p[1] - b);
        [s[0] + x * x, s[1] + x * y, s[2] + y * y]
    });
    ab / (aa * bb).sqrt()
}
