//! The network during training, of any widths, with tanh in the hidden layers and linear outputs:
//! its outputs and their derivatives by the weights, for the other modules of `training`.
//!
//! All weights stand in one vector, layer by layer: the matrix (one row per neuron), then the
//! bias. `[paper]` Eq. (eq:dnn_structure).

use emla::{LayerFile, MinMax};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Samples per task; fixed, so that no result depends on the number of threads.
const CHUNK: usize = 64;

/// Shape of a network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shape {
    widths: Vec<usize>,
    /// Where each layer's weights begin; one more entry for the end.
    starts: Vec<usize>,
}

/// Inputs and derivatives of one layer for a set of samples.
#[derive(Clone, Debug)]
pub struct LayerView {
    /// Inputs of the layer, one row per sample.
    pub(crate) inputs: Vec<f64>,
    /// For each network output: its derivative by the layer's weighted sums, one row per sample.
    pub(crate) deltas: Vec<Vec<f64>>,
}

impl Shape {
    /// Layers of these widths, from the inputs to the outputs.
    pub fn new(widths: &[usize]) -> Self {
        let mut starts = vec![0];
        for (k, w) in widths.windows(2).enumerate() {
            starts.push(starts[k] + (w[0] + 1) * w[1]);
        }
        Self {
            widths: widths.to_vec(),
            starts,
        }
    }

    /// Number of weights, biases included.
    pub fn weights(&self) -> usize {
        self.starts[self.layers()]
    }

    pub(crate) fn layers(&self) -> usize {
        self.widths.len() - 1
    }

    pub(crate) fn outputs(&self) -> usize {
        self.widths[self.layers()]
    }

    /// Number of inputs and outputs of layer `l`.
    pub(crate) fn size(&self, l: usize) -> (usize, usize) {
        (self.widths[l], self.widths[l + 1])
    }

    /// Matrix and bias of layer `l`.
    fn layer<'a>(&self, weights: &'a [f64], l: usize) -> (&'a [f64], &'a [f64]) {
        let (inputs, outputs) = self.size(l);
        weights[self.starts[l]..self.starts[l + 1]].split_at(inputs * outputs)
    }

    /// First weights by Nguyen and Widrow, as MATLAB's `initnw`: rows of random direction and
    /// length 2·0.7·S^(1/R), the active regions spread over the input range [−1, 1]; the last layer
    /// is uniform in [−1, 1].
    pub fn initial_weights(&self, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut uniform = move || rng.random_range(-1.0..1.0);
        let mut weights = Vec::with_capacity(self.weights());
        for l in 0..self.layers() {
            let (inputs, outputs) = self.size(l);
            if l + 1 == self.layers() {
                weights.extend((0..(inputs + 1) * outputs).map(|_| uniform()));
                continue;
            }
            let length = 2.0 * 0.7 * (outputs as f64).powf(1.0 / inputs as f64);
            let mut bias = Vec::with_capacity(outputs);
            for j in 0..outputs {
                let row: Vec<f64> = (0..inputs).map(|_| uniform()).collect();
                let norm = row.iter().map(|x| x * x).sum::<f64>().sqrt();
                let place = 2.0 * j as f64 / (outputs.max(2) - 1) as f64 - 1.0;
                bias.push(length * place * row[0].signum());
                weights.extend(row.iter().map(|x| x * length / norm));
            }
            weights.extend(bias);
        }
        weights
    }

    /// Outputs for each row of `inputs`.
    pub fn evaluate(&self, weights: &[f64], inputs: &[[f64; 2]]) -> Vec<[f64; 2]> {
        assert_eq!(
            (self.widths[0], self.outputs()),
            (2, 2),
            "two inputs, two outputs"
        );
        inputs
            .par_chunks(CHUNK)
            .flat_map_iter(|chunk| {
                chunk.iter().map(|x| {
                    let a = self.activations(weights, x);
                    let y = &a[self.layers()];
                    [y[0], y[1]]
                })
            })
            .collect()
    }

    /// Inputs of every layer, and the outputs last, for one sample.
    fn activations(&self, weights: &[f64], x: &[f64]) -> Vec<Vec<f64>> {
        let mut a = vec![x.to_vec()];
        for l in 0..self.layers() {
            let (matrix, bias) = self.layer(weights, l);
            let sums = matrix
                .chunks_exact(a[l].len())
                .zip(bias)
                .map(|(row, b)| dot(row, &a[l]) + b);
            let last = l + 1 == self.layers();
            a.push(sums.map(|z| if last { z } else { z.tanh() }).collect());
        }
        a
    }

    /// Derivatives of output `o` by the weighted sums of every layer: backpropagation of a one.
    fn deltas(&self, weights: &[f64], a: &[Vec<f64>], o: usize) -> Vec<Vec<f64>> {
        let layers = self.layers();
        let mut deltas = vec![Vec::new(); layers];
        deltas[layers - 1] = (0..self.outputs())
            .map(|j| f64::from(u8::from(j == o)))
            .collect();
        for l in (1..layers).rev() {
            let (matrix, _) = self.layer(weights, l);
            let mut back = vec![0.0; self.size(l).0];
            for (row, d) in matrix.chunks_exact(back.len()).zip(&deltas[l]) {
                for (b, w) in back.iter_mut().zip(row) {
                    *b += w * d;
                }
            }
            for (b, y) in back.iter_mut().zip(&a[l]) {
                *b *= 1.0 - y * y;
            }
            deltas[l - 1] = back;
        }
        deltas
    }

    /// Layer inputs and deltas of all samples: everything the Jacobian is made of, since
    /// ∂y_o/∂W_l = delta_{l,o} ⊗ input_l and ∂y_o/∂b_l = delta_{l,o}.
    pub fn views(&self, weights: &[f64], inputs: &[[f64; 2]]) -> Vec<LayerView> {
        let samples: Vec<_> = inputs
            .par_iter()
            .with_min_len(CHUNK)
            .map(|x| {
                let a = self.activations(weights, x);
                let d: Vec<_> = (0..self.outputs())
                    .map(|o| self.deltas(weights, &a, o))
                    .collect();
                (a, d)
            })
            .collect();
        let delta = |l: usize, o: usize| samples.iter().flat_map(move |(_, d)| &d[o][l]);
        let gather = |l: usize| LayerView {
            inputs: samples.iter().flat_map(|(a, _)| &a[l]).copied().collect(),
            deltas: (0..self.outputs())
                .map(|o| delta(l, o).copied().collect())
                .collect(),
        };
        (0..self.layers()).into_par_iter().map(gather).collect()
    }

    /// One row of the Jacobian: derivatives of output `o` of sample `n` by all weights.
    pub fn jacobian_row(&self, views: &[LayerView], n: usize, o: usize, row: &mut [f64]) {
        for (l, view) in views.iter().enumerate() {
            let (inputs, outputs) = self.size(l);
            let x = &view.inputs[n * inputs..][..inputs];
            let delta = &view.deltas[o][n * outputs..][..outputs];
            let (matrix, bias) =
                row[self.starts[l]..self.starts[l + 1]].split_at_mut(inputs * outputs);
            for (part, d) in matrix.chunks_exact_mut(inputs).zip(delta) {
                for (cell, x) in part.iter_mut().zip(x) {
                    *cell = d * x;
                }
            }
            bias.copy_from_slice(delta);
        }
    }

    /// `Jᵀ·r` for residual weights `r[n]` = one number per output of sample n.
    pub fn jacobian_transposed_times(&self, views: &[LayerView], r: &[[f64; 2]]) -> Vec<f64> {
        let layer = |l: usize| {
            let (inputs, outputs) = self.size(l);
            let mut sum = vec![0.0; (inputs + 1) * outputs];
            let (matrix, bias) = sum.split_at_mut(inputs * outputs);
            for (n, r) in r.iter().enumerate() {
                let x = &views[l].inputs[n * inputs..][..inputs];
                for j in 0..outputs {
                    let delta = &views[l].deltas;
                    let terms = r.iter().zip(delta);
                    let d: f64 = terms.map(|(r, d)| r * d[n * outputs + j]).sum();
                    bias[j] += d;
                    for (cell, x) in matrix[j * inputs..][..inputs].iter_mut().zip(x) {
                        *cell += d * x;
                    }
                }
            }
            sum
        };
        let parts: Vec<Vec<f64>> = (0..self.layers()).into_par_iter().map(layer).collect();
        parts.concat()
    }

    /// Layers as the network file keeps them.
    pub fn to_layers(&self, weights: &[f64]) -> Vec<LayerFile> {
        (0..self.layers())
            .map(|l| {
                let (matrix, bias) = self.layer(weights, l);
                let rows = matrix.chunks_exact(self.size(l).0).map(<[f64]>::to_vec);
                LayerFile {
                    weights: rows.collect(),
                    bias: bias.to_vec(),
                }
            })
            .collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four partial sums, in a fixed order, so that the loop vectorises.
    let mut sums = [0.0; 4];
    let (a4, a_rest) = a.as_chunks::<4>();
    let (b4, b_rest) = b.as_chunks::<4>();
    for (a, b) in a4.iter().zip(b4) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Range of one column of `rows`.
pub fn column_range(rows: &[[f64; 2]], column: usize) -> MinMax {
    let values = || rows.iter().map(|row| row[column]);
    MinMax {
        min: values().fold(f64::INFINITY, f64::min),
        max: values().fold(f64::NEG_INFINITY, f64::max),
    }
}

/// `mapminmax` of both columns.
pub fn scaled(rows: &[[f64; 2]], ranges: [MinMax; 2]) -> Vec<[f64; 2]> {
    rows.iter()
        .map(|&[a, b]| [ranges[0].scale(a), ranges[1].scale(b)])
        .collect()
}
