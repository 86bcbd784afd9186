//! The normal matrix of a Levenberg–Marquardt step (`lm`) and its Cholesky factor, in square tiles.
//!
//! The step `−(JᵀJ + c·I)⁻¹·Jᵀe` equals `−Jᵀ·(J·Jᵀ + c·I)⁻¹·e`. The cheaper one is solved. `J·Jᵀ`
//! never needs J: rows of J are sums over layers of outer products, so
//! `(J·Jᵀ)_{(n,o),(m,p)} = Σ_l (delta_{l,o,n}·delta_{l,p,m})·(input_{l,n}·input_{l,m} + 1)`,
//! some 25 times fewer operations than the plain product for the paper's network.
//!
//! Work is cut into tiles whose size does not depend on the number of threads, each done by one
//! thread with `faer`'s sequential kernels: the result has the same bits for any number of threads.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;

use crate::training::network::{LayerView, Shape};

const TILE: usize = 256;
/// Samples whose Jacobian rows are held at once in the `JᵀJ` form.
const SAMPLES_AT_ONCE: usize = 512;

/// The lower tiles of a symmetric matrix, column after column.
#[derive(Clone)]
pub struct TiledMatrix {
    /// First row of each tile row; one more entry for the end.
    starts: Vec<usize>,
    columns: Vec<Vec<Mat<f64>>>,
}

/// The two forms of the normal matrix, which give the same step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `JᵀJ`, one row per weight.
    Weights,
    /// `J·Jᵀ`, one row per residual.
    Residuals,
}

impl Form {
    /// The form with fewer operations: with R residuals and W weights, `W²R + W³/3` for forming and
    /// factoring `JᵀJ`, `R³/3` and the tiles of `kernel_tile` for `J·Jᵀ`.
    pub fn cheaper(shape: &Shape, samples: usize) -> Self {
        let outputs = shape.outputs() as f64;
        let (w, n) = (shape.weights() as f64, samples as f64);
        let r = outputs * n;
        let pair = |l| {
            let (inputs, width) = shape.size(l);
            inputs as f64 + outputs * outputs * width as f64
        };
        let kernel = n * n * (0..shape.layers()).map(pair).sum::<f64>();
        let cubic = |x: f64| x * x * x / 3.0;
        if kernel + cubic(r) < w * w * r + cubic(w) {
            Self::Residuals
        } else {
            Self::Weights
        }
    }
}

/// The matrix is not positive definite to working precision.
#[derive(Clone, Copy, Debug)]
pub struct NotPositiveDefinite;

impl TiledMatrix {
    /// `J·Jᵀ`; residuals of a tile of samples are ordered output after output.
    pub fn residuals(shape: &Shape, views: &[LayerView], samples: usize) -> Self {
        let outputs = shape.outputs();
        let per_tile = TILE / outputs;
        let starts = starts(samples, per_tile);
        let tile = |i: usize, j: usize| kernel_tile(shape, views, &starts, i, j);
        let columns = fill(starts.len() - 1, tile);
        let starts = starts.iter().map(|s| s * outputs).collect();
        Self { starts, columns }
    }

    /// `JᵀJ`.
    pub fn weights(shape: &Shape, views: &[LayerView], samples: usize) -> Self {
        let starts = starts(shape.weights(), TILE);
        let zero =
            |i: usize, j: usize| Mat::zeros(starts[i + 1] - starts[i], starts[j + 1] - starts[j]);
        let mut columns = fill(starts.len() - 1, zero);
        for first in (0..samples).step_by(SAMPLES_AT_ONCE) {
            let count = SAMPLES_AT_ONCE.min(samples - first);
            let rows = jacobian(shape, views, first, count);
            let size = (count * shape.outputs(), shape.weights());
            let rows = MatRef::from_row_major_slice(&rows, size.0, size.1);
            each_tile(&mut columns, |i, j, tile| {
                let block = |k: usize| rows.subcols(starts[k], starts[k + 1] - starts[k]);
                let (left, right) = (block(i), block(j));
                product(tile, Accum::Add, left.transpose(), right, 1.0);
            });
        }
        Self { starts, columns }
    }

    /// Replaces the matrix A by the Cholesky factor of A + c·I.
    pub fn factor(&mut self, c: f64) -> Result<(), NotPositiveDefinite> {
        for k in 0..self.columns.len() {
            let (done, later) = self.columns.split_at_mut(k + 1);
            let (head, panel) = done[k].split_first_mut().expect("a diagonal tile");
            for d in 0..head.nrows() {
                head[(d, d)] += c;
            }
            factor_diagonal(head)?;
            panel.par_iter_mut().for_each(|tile| {
                // A·L⁻ᵀ = (L⁻¹·Aᵀ)ᵀ
                let transposed = tile.as_mut().transpose_mut();
                solve_lower_triangular_in_place(head.as_ref(), transposed, Par::Seq);
            });
            let panel = &*panel;
            each_tile(later, |i, j, tile| {
                let (left, right) = (panel[i].as_ref(), panel[j].transpose());
                product(tile, Accum::Add, left, right, -1.0);
            });
        }
        Ok(())
    }

    /// Solves with the factor, in place.
    pub fn solve(&self, x: &mut [f64]) {
        let tiles = self.columns.len();
        let range = |k: usize| self.starts[k]..self.starts[k + 1];
        for k in 0..tiles {
            let (solved, rest) = x.split_at_mut(self.starts[k + 1]);
            let head = &mut solved[self.starts[k]..];
            let factor = &self.columns[k][0];
            solve_lower_triangular_in_place(factor.as_ref(), column(head), Par::Seq);
            for (i, tile) in self.columns[k].iter().enumerate().skip(1) {
                let below = range(k + i);
                let target = &mut rest[below.start - self.starts[k + 1]..][..below.len()];
                subtract(tile.as_ref(), head, target);
            }
        }
        for k in (0..tiles).rev() {
            let (solved, rest) = x.split_at_mut(self.starts[k + 1]);
            let head = &mut solved[self.starts[k]..];
            for (i, tile) in self.columns[k].iter().enumerate().skip(1) {
                let below = range(k + i);
                let source = &rest[below.start - self.starts[k + 1]..][..below.len()];
                subtract(tile.transpose(), source, head);
            }
            let factor = self.columns[k][0].transpose();
            solve_upper_triangular_in_place(factor, column(head), Par::Seq);
        }
    }
}

fn column(x: &mut [f64]) -> faer::MatMut<'_, f64> {
    let n = x.len();
    faer::MatMut::from_column_major_slice_mut(x, n, 1)
}

/// Writes `factor·A·B` into `to`, or adds it.
fn product(to: &mut Mat<f64>, accum: Accum, a: MatRef<'_, f64>, b: MatRef<'_, f64>, factor: f64) {
    matmul(to.as_mut(), accum, a, b, factor, Par::Seq);
}

/// `y −= A·x`.
fn subtract(a: MatRef<'_, f64>, x: &[f64], y: &mut [f64]) {
    let x = MatRef::from_column_major_slice(x, x.len(), 1);
    matmul(column(y), Accum::Add, a, x, -1.0, Par::Seq);
}

fn factor_diagonal(tile: &mut Mat<f64>) -> Result<(), NotPositiveDefinite> {
    let n = tile.nrows();
    let scratch = factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    let none = Default::default();
    factor::cholesky_in_place(tile.as_mut(), none, Par::Seq, stack, Default::default())
        .map_err(|_| NotPositiveDefinite)?;
    // A NaN in the matrix passes the factorisation's comparisons.
    if (0..n).all(|d| tile[(d, d)].is_finite()) {
        Ok(())
    } else {
        Err(NotPositiveDefinite)
    }
}

fn starts(total: usize, step: usize) -> Vec<usize> {
    let mut starts: Vec<usize> = (0..total).step_by(step).collect();
    starts.push(total);
    starts
}

/// All lower tiles, each by one task.
fn fill(tiles: usize, tile: impl Fn(usize, usize) -> Mat<f64> + Sync) -> Vec<Vec<Mat<f64>>> {
    (0..tiles)
        .into_par_iter()
        .map(|j| (j..tiles).into_par_iter().map(|i| tile(i, j)).collect())
        .collect()
}

/// Visits the lower tiles of the last columns; `i ≥ j` count from the first of these.
fn each_tile(columns: &mut [Vec<Mat<f64>>], visit: impl Fn(usize, usize, &mut Mat<f64>) + Sync) {
    columns.par_iter_mut().enumerate().for_each(|(j, column)| {
        column
            .par_iter_mut()
            .enumerate()
            .for_each(|(i, tile)| visit(j + i, j, tile));
    });
}

/// Rows of the Jacobian, sample after sample.
fn jacobian(shape: &Shape, views: &[LayerView], first: usize, count: usize) -> Vec<f64> {
    let outputs = shape.outputs();
    let mut rows = vec![0.0; count * outputs * shape.weights()];
    rows.par_chunks_mut(shape.weights())
        .enumerate()
        .for_each(|(r, row)| {
            shape.jacobian_row(views, first + r / outputs, r % outputs, row);
        });
    rows
}

/// One tile of `J·Jᵀ`: `Σ_l (X_l·X_lᵀ + 1) ∘ (D_{l,o}·D_{l,p}ᵀ)` for each pair of outputs.
fn kernel_tile(
    shape: &Shape,
    views: &[LayerView],
    starts: &[usize],
    i: usize,
    j: usize,
) -> Mat<f64> {
    let rows = |data, k: usize, width: usize| {
        let (first, count) = (starts[k], starts[k + 1] - starts[k]);
        let all: &Vec<f64> = data;
        MatRef::from_row_major_slice(&all[first * width..][..count * width], count, width)
    };
    let (n, m) = (starts[i + 1] - starts[i], starts[j + 1] - starts[j]);
    let outputs = shape.outputs();
    let mut tile = Mat::<f64>::zeros(outputs * n, outputs * m);
    let mut x = Mat::<f64>::zeros(n, m);
    let mut d = Mat::<f64>::zeros(n, m);
    for (l, view) in views.iter().enumerate() {
        let (inputs, width) = shape.size(l);
        let (left, right) = (rows(&view.inputs, i, inputs), rows(&view.inputs, j, inputs));
        product(&mut x, Accum::Replace, left, right.transpose(), 1.0);
        for o in 0..outputs {
            for p in 0..outputs {
                let left = rows(&view.deltas[o], i, width);
                let right = rows(&view.deltas[p], j, width);
                product(&mut d, Accum::Replace, left, right.transpose(), 1.0);
                for c in 0..m {
                    let target = &mut tile.col_as_slice_mut(p * m + c)[o * n..][..n];
                    let (x, d) = (x.col_as_slice(c), d.col_as_slice(c));
                    for ((t, x), d) in target.iter_mut().zip(x).zip(d) {
                        *t += (x + 1.0) * d;
                    }
                }
            }
        }
    }
    tile
}

/// Order of the residuals in [`TiledMatrix::residuals`]: sample and output of each row.
pub fn residual_order(shape: &Shape, samples: usize) -> Vec<(usize, usize)> {
    let outputs = shape.outputs();
    let starts = starts(samples, TILE / outputs);
    let tile = |s: &[usize]| {
        let (first, end) = (s[0], s[1]);
        (0..outputs).flat_map(move |o| (first..end).map(move |n| (n, o)))
    };
    starts.windows(2).flat_map(tile).collect()
}
