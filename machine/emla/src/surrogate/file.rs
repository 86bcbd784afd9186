//! The JSON file of a network and its checks: the study `surrogate` writes it, the FMUs read it.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Neurons per layer, from the inputs (tau_e, w_m) to the outputs (F, x_dot).
pub const WIDTHS: [usize; 7] = [2, 64, 48, 32, 16, 8, 2];

/// Why a network file was refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SurrogateError {
    /// Not JSON, an unknown or missing field, or a value of the wrong type.
    #[error("surrogate network: {0}")]
    Json(String),
    /// Sizes that do not fit the network.
    #[error("surrogate network: `{field}` has {found} elements, {expected} are needed")]
    Shape {
        /// Which field.
        field: String,
        /// How many elements the file has.
        found: usize,
        /// How many the network needs.
        expected: usize,
    },
    /// A weight, bound or error that is NaN or infinite.
    #[error("surrogate network: `{field}` = {value} is not finite")]
    NotFinite {
        /// Which field.
        field: String,
        /// Its value.
        value: f64,
    },
    /// A range whose ends are the wrong way round, equal or negative where they must not be.
    #[error("surrogate network: `{field}` = [{min}, {max}]: {rule}")]
    Range {
        /// Which field.
        field: &'static str,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
        /// The rule that is broken.
        rule: &'static str,
    },
}

/// Smallest and largest value of a column in the training data, which is scaled to [−1, 1].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MinMax {
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

impl MinMax {
    /// `y = 2·(x − min)/(max − min) − 1`.
    #[must_use]
    pub fn scale(self, x: f64) -> f64 {
        2.0 * (x - self.min) / (self.max - self.min) - 1.0
    }

    /// `x = (y + 1)·(max − min)/2 + min`.
    #[must_use]
    pub fn unscale(self, y: f64) -> f64 {
        (y + 1.0) * (self.max - self.min) / 2.0 + self.min
    }

    /// The nearest value in the range; NaN stays NaN.
    #[must_use]
    pub fn clamp(self, x: f64) -> f64 {
        x.clamp(self.min, self.max)
    }

    /// Whether `x` is in the range, ends included.
    #[must_use]
    pub fn contains(self, x: f64) -> bool {
        (self.min..=self.max).contains(&x)
    }

    fn check(self, field: &'static str) -> Result<(), SurrogateError> {
        finite(&format!("{field}.min"), self.min)?;
        finite(&format!("{field}.max"), self.max)?;
        self.require(field, self.min < self.max, "min must lie below max")
    }

    fn require(
        self,
        field: &'static str,
        holds: bool,
        rule: &'static str,
    ) -> Result<(), SurrogateError> {
        let Self { min, max } = self;
        let refusal = SurrogateError::Range {
            field,
            min,
            max,
            rule,
        };
        holds.then_some(()).ok_or(refusal)
    }
}

/// Ranges of the four columns: the scaling, and for the inputs the trained box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ranges {
    /// Air-gap torque, N·m.
    pub tau_e: MinMax,
    /// Motor speed, rad/s; never negative (the other direction follows by symmetry).
    pub w_m: MinMax,
    /// Force on the load, N, positive when it pushes against an extending rod.
    #[serde(rename = "F_ext")]
    pub f_ext: MinMax,
    /// Rod speed, m/s.
    pub x_dot: MinMax,
}

/// One affine layer as in the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerFile {
    /// One row per neuron, one column per input.
    pub weights: Vec<Vec<f64>>,
    /// One number per neuron.
    pub bias: Vec<f64>,
}

/// One number for each part of the split data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Split<T> {
    /// Rows the weights were fitted to.
    pub training: T,
    /// Rows that stopped the training.
    pub validation: T,
    /// Rows used only to assess the quality.
    pub test: T,
}

/// Where the weights come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingRecord {
    /// Origin of the data in words: a simulation or measurements.
    pub data: String,
    /// SHA-256 of the data file, hexadecimal.
    pub data_sha256: String,
    /// Seed of the split and of the first weights.
    pub seed: u64,
    /// Accepted Levenberg–Marquardt steps until the stop.
    pub epochs: u32,
    /// Epoch whose weights these are: the smallest validation error.
    pub best_epoch: u32,
    /// Why the training stopped.
    pub stop: String,
    /// Number of rows.
    pub rows: Split<u32>,
    /// Mean squared error of both outputs, scaled to [−1, 1].
    pub mse: Split<f64>,
    /// Correlation of predicted and true force.
    #[serde(rename = "R_F")]
    pub r_f: Split<f64>,
    /// Correlation of predicted and true rod speed.
    #[serde(rename = "R_x_dot")]
    pub r_x_dot: Split<f64>,
    /// Learning curve: mean squared errors before the first epoch and after each.
    pub curve: Vec<Split<f64>>,
}

/// Bound on the difference between the network's efficiency and that of the actuator as built: a
/// pointwise conformal bound, calibrated by profiles. In a new profile of the same kind, a randomly
/// drawn window has its true efficiency within the bound with the probability `share`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EfficiencyBound {
    /// Probability.
    pub share: f64,
    /// Half width at zero power.
    pub factor: f64,
    /// Power scale P_0 over which the width falls, W: losses that do not grow with the power.
    pub power: f64,
    /// Part of `factor` that remains at large powers.
    pub floor: f64,
    /// Number of the profiles that it was calibrated on.
    pub profiles: u32,
}

impl EfficiencyBound {
    /// Half width at the network's power `out`, W, if its guards cut off the power `cut`, W; `cut`
    /// counts in full, so the bound widens outside the trained box:
    /// ```text
    /// (factor (P_0 + floor·P_out) + cut)/(P_0 + P_out)
    /// ```
    pub fn half_width(&self, out: f64, cut: f64) -> f64 {
        (self.factor * (self.power + self.floor * out) + cut) / (self.power + out)
    }

    /// The smallest `factor` whose bound includes the error `error` of the efficiency.
    pub fn needed_factor(&self, error: f64, out: f64, cut: f64) -> f64 {
        let beyond = error.abs() * (self.power + out) - cut;
        beyond.max(0.0) / (self.power + self.floor * out)
    }
}

/// The whole file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurrogateFile {
    /// Where the weights come from.
    pub training: TrainingRecord,
    /// Scaling and trained box.
    pub ranges: Ranges,
    /// The six layers, from the inputs on.
    pub layers: Vec<LayerFile>,
    /// Bound on the error of its efficiency, if calibrated. Always written, because the binary
    /// format of saved states cannot leave out fields.
    #[serde(default)]
    pub efficiency_bound: Option<EfficiencyBound>,
}

impl SurrogateFile {
    pub(super) fn check(&self) -> Result<(), SurrogateError> {
        let ranges = &self.ranges;
        ranges.tau_e.check("ranges.tau_e")?;
        ranges.w_m.check("ranges.w_m")?;
        ranges.f_ext.check("ranges.F_ext")?;
        ranges.x_dot.check("ranges.x_dot")?;
        let rule = "the network is trained on one direction, speeds must not be negative";
        (ranges.w_m).require("ranges.w_m", ranges.w_m.min >= 0.0, rule)?;
        length("layers", self.layers.len(), WIDTHS.len() - 1)?;
        for (k, (layer, widths)) in self.layers.iter().zip(WIDTHS.windows(2)).enumerate() {
            layer.check(k, widths[0], widths[1])?;
        }
        if let Some(bound) = self.efficiency_bound {
            let EfficiencyBound {
                share,
                factor,
                power,
                floor,
                ..
            } = bound;
            let rule = "must be positive and finite";
            let fields = [
                ("efficiency_bound.share", share),
                ("efficiency_bound.factor", factor),
                ("efficiency_bound.power", power),
                ("efficiency_bound.floor", floor),
            ];
            for (field, value) in fields {
                finite(field, value)?;
                if value <= 0.0 {
                    return Err(SurrogateError::Range {
                        field,
                        min: value,
                        max: f64::INFINITY,
                        rule,
                    });
                }
            }
        }
        let record = &self.training;
        let named = [
            ("mse", &record.mse),
            ("R_F", &record.r_f),
            ("R_x_dot", &record.r_x_dot),
        ];
        let curve = record.curve.iter().map(|split| ("curve", split));
        for (name, split) in named.into_iter().chain(curve) {
            for value in [split.training, split.validation, split.test] {
                finite(&format!("training.{name}"), value)?;
            }
        }
        Ok(())
    }
}

impl LayerFile {
    fn check(&self, k: usize, inputs: usize, outputs: usize) -> Result<(), SurrogateError> {
        let name = format!("layers[{k}].weights");
        length(&name, self.weights.len(), outputs)?;
        length(&format!("layers[{k}].bias"), self.bias.len(), outputs)?;
        for (j, row) in self.weights.iter().enumerate() {
            length(&format!("{name}[{j}]"), row.len(), inputs)?;
            for (i, &w) in row.iter().enumerate() {
                finite(&format!("{name}[{j}][{i}]"), w)?;
            }
        }
        for (j, &b) in self.bias.iter().enumerate() {
            finite(&format!("layers[{k}].bias[{j}]"), b)?;
        }
        Ok(())
    }
}

fn length(field: &str, found: usize, expected: usize) -> Result<(), SurrogateError> {
    if found == expected {
        return Ok(());
    }
    Err(SurrogateError::Shape {
        field: field.into(),
        found,
        expected,
    })
}

fn finite(field: &str, value: f64) -> Result<(), SurrogateError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(SurrogateError::NotFinite {
        field: field.into(),
        value,
    })
}
