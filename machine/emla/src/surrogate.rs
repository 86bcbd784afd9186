//! The surrogate: a trained network `(tau_e, w_m) → (F, x_dot)`, limited to its trained range;
//! this model and the controller blend it in, and the study `surrogate` trains and judges it.
//!
//! `[paper]` Eqs. (eq:dnn_prediction_efficiency), first line, and (eq:dnn_structure). The network
//! 2-64-48-32-16-8-2 is trained on one direction of motion, in steady sliding, in a box of torque
//! and speed. As it is meaningless elsewhere, two guards are added to the paper's map:
//!
//! - torque and |speed| are clamped to the trained box;
//! - the other direction follows by odd symmetry, blended through standstill:
//!   `F = (1+s)/2·N(tau,|w|) − (1−s)/2·N(−tau,|w|)`, `s = tanh(w_m/2)`.
//!
//! A map compared with the network must pass through the same guards ([`Surrogate::guard`]). All
//! processors give the same bits ([`network`]); the error of tanh changes F by less than 1e-8 N.

mod file;
mod network;
mod shipped;

use crate::tanh::tanh;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use file::{
    EfficiencyBound, LayerFile, MinMax, Ranges, Split, SurrogateError, SurrogateFile,
    TrainingRecord, WIDTHS,
};
use network::{Layer, Network};

/// Motor speed over which the two directions are blended, rad/s.
const FOLD_SPEED: f64 = 2.0;

/// Outputs of the network at one operating point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[allow(non_snake_case)]
pub struct SurrogateOutput {
    /// Force on the load F, N, positive when it pushes.
    pub F: f64,
    /// Rod speed, m/s.
    pub x_dot: f64,
    /// Whether the point is in the trained box, so that no guard changed it.
    pub in_trained_range: bool,
}

/// A trained network, checked; cheap to clone, immutable.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "SurrogateFile", into = "SurrogateFile")]
pub struct Surrogate(Source);

#[derive(Clone, Debug)]
enum Source {
    /// The embedded network, trained on a simulation (the virtual testbed), not on measurements.
    Shipped,
    Loaded(Arc<LoadedNetwork>),
}

#[derive(Debug)]
struct LoadedNetwork {
    network: Network,
    ranges: Ranges,
    training: TrainingRecord,
    bound: Option<EfficiencyBound>,
}

impl Surrogate {
    /// The shipped network, compiled from `parameters/surrogate.json`.
    pub fn reference() -> Self {
        Self(Source::Shipped)
    }

    /// Reads a network file.
    pub fn from_json(text: &str) -> Result<Self, SurrogateError> {
        let file: SurrogateFile =
            serde_json::from_str(text).map_err(|e| SurrogateError::Json(e.to_string()))?;
        Self::new(file)
    }

    /// A network file that [`from_json`](Self::from_json) reads back bit for bit.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("texts and numbers")
    }

    /// Checks shapes, finite numbers and ranges of a network file, and builds the network.
    pub fn new(file: SurrogateFile) -> Result<Self, SurrogateError> {
        file.check()?;
        let mut network = Network::ZERO;
        fill(&mut network.l1, &file.layers[0]);
        fill(&mut network.l2, &file.layers[1]);
        fill(&mut network.l3, &file.layers[2]);
        fill(&mut network.l4, &file.layers[3]);
        fill(&mut network.l5, &file.layers[4]);
        fill(&mut network.l6, &file.layers[5]);
        let SurrogateFile {
            training,
            ranges,
            efficiency_bound: bound,
            ..
        } = file;
        Ok(Self(Source::Loaded(Arc::new(LoadedNetwork {
            network,
            ranges,
            training,
            bound,
        }))))
    }

    /// The contents of a network file for this network.
    pub fn file(&self) -> SurrogateFile {
        let n = self.network();
        SurrogateFile {
            training: self.training(),
            ranges: *self.ranges(),
            layers: vec![
                layer(&n.l1),
                layer(&n.l2),
                layer(&n.l3),
                layer(&n.l4),
                layer(&n.l5),
                layer(&n.l6),
            ],
            efficiency_bound: self.efficiency_bound(),
        }
    }

    /// Bound on the error of its efficiency, if one was calibrated.
    pub fn efficiency_bound(&self) -> Option<EfficiencyBound> {
        match &self.0 {
            Source::Shipped => shipped::BOUND,
            Source::Loaded(read) => read.bound,
        }
    }

    /// Scaling and trained box.
    #[inline]
    pub fn ranges(&self) -> &Ranges {
        match &self.0 {
            Source::Shipped => &shipped::RANGES,
            Source::Loaded(read) => &read.ranges,
        }
    }

    /// Where the weights come from.
    pub fn training(&self) -> TrainingRecord {
        match &self.0 {
            Source::Shipped => shipped::training(),
            Source::Loaded(read) => read.training.clone(),
        }
    }

    #[inline]
    fn network(&self) -> &Network {
        match &self.0 {
            Source::Shipped => &shipped::NETWORK,
            Source::Loaded(read) => &read.network,
        }
    }

    /// Force and rod speed at an air-gap torque `tau_e`, N·m, and a motor speed `w_m`, rad/s, of
    /// either sign. NaN gives NaN. Does not allocate.
    pub fn evaluate(&self, tau_e: f64, w_m: f64) -> SurrogateOutput {
        let fold = Fold::new(w_m);
        // Away from standstill the other direction has no weight: one evaluation is enough.
        let [forward, reverse] = if fold.reverse == 0.0 {
            let [forward] = self.sliding([[tau_e, w_m]]);
            [forward, [0.0; 2]]
        } else if fold.forward == 0.0 {
            let [reverse] = self.sliding([[-tau_e, -w_m]]);
            [[0.0; 2], reverse]
        } else {
            self.sliding([[tau_e, w_m.abs()], [-tau_e, w_m.abs()]])
        };
        self.fold_directions(fold, [tau_e, w_m], [forward, reverse])
    }

    /// Blends the outputs of both directions.
    #[inline]
    fn fold_directions(
        &self,
        fold: Fold,
        [tau_e, w_m]: [f64; 2],
        [fwd, rev]: [[f64; 2]; 2],
    ) -> SurrogateOutput {
        SurrogateOutput {
            F: fold.apply(fwd[0], rev[0]),
            x_dot: fold.apply(fwd[1], rev[1]),
            in_trained_range: self.in_trained_range(tau_e, w_m),
        }
    }

    /// [`evaluate`](Self::evaluate) at three points `[tau_e, w_m]`, with the same bits. Up to three
    /// directions of motion are evaluated together and so load the weights once.
    pub fn evaluate_three(&self, points: [[f64; 2]; 3]) -> [SurrogateOutput; 3] {
        let folds = points.map(|[_, w_m]| Fold::new(w_m));
        let (mut directions, mut n) = ([[0.0; 2]; 6], 0);
        for (fold, [tau_e, w_m]) in folds.iter().zip(points) {
            for (weight, tau) in [(fold.forward, tau_e), (fold.reverse, -tau_e)] {
                directions[n] = [tau, w_m.abs()];
                n += usize::from(weight != 0.0);
            }
        }
        // At least one direction of each point has a weight.
        match n {
            3 => self.slide::<3>(&mut directions[..3]),
            4 => self.slide::<2>(&mut directions[..4]),
            5 => {
                self.slide::<3>(&mut directions[..3]);
                self.slide::<2>(&mut directions[3..5]);
            }
            _ => self.slide::<3>(&mut directions),
        }
        let mut found = directions.into_iter();
        let mut next = |weight| match weight {
            0.0 => [0.0; 2],
            _ => found.next().expect("as many as were asked for"),
        };
        std::array::from_fn(|i| {
            let fold = folds[i];
            let directions = [next(fold.forward), next(fold.reverse)];
            self.fold_directions(fold, points[i], directions)
        })
    }

    /// [`sliding`](Self::sliding) in place, `B` points at a time.
    fn slide<const B: usize>(&self, points: &mut [[f64; 2]]) {
        for points in points.as_chunks_mut::<B>().0 {
            *points = self.sliding(*points);
        }
    }

    pub(crate) fn is_shared_with(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Source::Shipped, Source::Shipped) => true,
            (Source::Loaded(a), Source::Loaded(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }

    /// Applies the network's guards to a map of (tau_e, w_m) for positive speed: clamps to the
    /// trained box and extends by odd symmetry.
    pub fn guard(&self, tau_e: f64, w_m: f64, map: impl Fn(f64, f64) -> f64) -> f64 {
        let ranges = self.ranges();
        let w = ranges.w_m.clamp(w_m.abs());
        let fold = Fold::new(w_m);
        let weighed = |weight, tau| match weight {
            0.0 => 0.0,
            _ => map(ranges.tau_e.clamp(tau), w),
        };
        fold.apply(weighed(fold.forward, tau_e), weighed(fold.reverse, -tau_e))
    }

    /// Whether the point, mirrored to positive speed, is in the trained box.
    pub fn in_trained_range(&self, tau_e: f64, w_m: f64) -> bool {
        let ranges = self.ranges();
        let tau = if w_m < 0.0 { -tau_e } else { tau_e };
        ranges.tau_e.contains(tau) && ranges.w_m.contains(w_m.abs())
    }

    /// [F, x_dot] of points (tau_e, w_m ≥ 0), clamped to the trained box.
    fn sliding<const B: usize>(&self, points: [[f64; 2]; B]) -> [[f64; 2]; B] {
        let r = self.ranges();
        let inside = |range: &MinMax, value| range.scale(range.clamp(value));
        let x = points.map(|[tau, w]| [inside(&r.tau_e, tau), inside(&r.w_m, w)]);
        let y = self.network().evaluate(x);
        y.map(|[f, v]| [r.f_ext.unscale(f), r.x_dot.unscale(v)])
    }
}

/// Weights of the two directions of motion: (1 ± s)/2, `s = tanh(w_m/2)`.
#[derive(Clone, Copy)]
struct Fold {
    forward: f64,
    reverse: f64,
}

impl Fold {
    fn new(w_m: f64) -> Self {
        let s = tanh(w_m / FOLD_SPEED);
        Self {
            forward: (1.0 + s) / 2.0,
            reverse: (1.0 - s) / 2.0,
        }
    }

    fn apply(self, forward: f64, reverse: f64) -> f64 {
        self.forward * forward - self.reverse * reverse
    }
}

impl PartialEq for Surrogate {
    fn eq(&self, other: &Self) -> bool {
        self.is_shared_with(other) || self.file() == other.file()
    }
}

impl TryFrom<SurrogateFile> for Surrogate {
    type Error = SurrogateError;

    fn try_from(file: SurrogateFile) -> Result<Self, SurrogateError> {
        Self::new(file)
    }
}

impl From<Surrogate> for SurrogateFile {
    fn from(surrogate: Surrogate) -> Self {
        surrogate.file()
    }
}

/// Transposes a checked layer of a file into its fixed shape.
fn fill<const IN: usize, const OUT: usize>(layer: &mut Layer<IN, OUT>, file: &LayerFile) {
    for (j, row) in file.weights.iter().enumerate() {
        for (i, w) in row.iter().enumerate() {
            layer.weights[i][j] = *w;
        }
        layer.bias[j] = file.bias[j];
    }
}

/// The inverse of [`fill`].
fn layer<const IN: usize, const OUT: usize>(layer: &Layer<IN, OUT>) -> LayerFile {
    let row = |j| layer.weights.iter().map(|weights| weights[j]).collect();
    LayerFile {
        weights: (0..OUT).map(row).collect(),
        bias: layer.bias.to_vec(),
    }
}

#[cfg(test)]
#[path = "../tests/unit/surrogate.rs"]
mod tests;
