//! Solves algebraic loops, outputs that depend directly on each other, by Newton's method: for each
//! exchange, and for steps that the schedule `standard` repeats (`--solve-loops`).
//!
//! The unknowns `y` are the values that the outputs of a loop pass on; `g(y)` are the outputs after
//! the inputs were set to `y`. The solution is `g(y) = y`. The derivatives of `g` with respect to
//! an unknown are directional derivatives if all FMUs that receive it have them, else finite
//! differences. Nothing here allocates unless it fails.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use anyhow::{Result, bail};
use fmi_description::Access;

use crate::instance::finite::are_finite;
use crate::instance::{At, Instance};
use crate::wiring::{Port, Wiring};
use fmi_import::batch::Batch;

/// Iterations after which a loop counts as unsolved.
const MAX_ITERATIONS: usize = 50;
/// Residual relative to 1 plus the value, up to which a loop is solved.
const ROUNDING: f64 = 1e-14;
/// The same once iterations no longer reduce the residual.
const TOLERANCE: f64 = 1e-10;
/// Change of an unknown for finite differences, relative to 1 plus the value: the square root of
/// the rounding.
const CHANGE: f64 = 1.5e-8;
/// Pivot relative to the largest element, up to which a loop has no unique solution: finite
/// differences are accurate to about [`CHANGE`].
const SINGULAR: f64 = 1e-7;

/// The exchange or step through which the outputs of loops depend on each other.
pub(crate) trait LoopStage {
    /// Values passed, by slot.
    fn values(&mut self) -> &mut [f64];
    /// Set the inputs to the values, then read the outputs.
    fn write_and_read(&mut self) -> Result<()>;
    /// Undo [`LoopStage::write_and_read`], values included.
    fn rewind(&mut self) -> Result<()> {
        Ok(())
    }
    /// The instances, if their directional derivatives are those of the values passed.
    fn differentiable_instances(&self) -> Option<&[Instance]> {
        None
    }
}

/// Directional derivative of the outputs of one component in the direction of an unknown.
#[derive(Debug)]
struct Influence {
    component: usize,
    outputs_and_inputs: [Batch; 2],
    /// Derivatives of the inputs with respect to the unknown.
    seeds: Vec<f64>,
    /// Indices of the outputs among the unknowns.
    rows: Vec<usize>,
    rates: Vec<f64>,
}

/// The influences of an unknown on the outputs `ports`, one for each component that receives it;
/// None if one of these has no directional derivatives.
fn influences(wiring: &Wiring, ports: &[Port], unknown: Port) -> Option<Vec<Influence>> {
    let links = wiring.links.iter().filter(|link| link.from == unknown);
    if links.clone().any(|link| link.is_initial) {
        return None;
    }
    let mut inputs: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
    for link in links {
        let (variable, seed) = (link.to.variable, link.transformation.apply_rate(1.0));
        let inputs = inputs.entry(link.to.component).or_default();
        match inputs.iter_mut().find(|(own, _)| *own == variable) {
            Some((_, sum)) => *sum += seed,
            None => inputs.push((variable, seed)),
        }
    }
    let mut found = Vec::new();
    for (component, inputs) in inputs {
        let own = (0..ports.len()).filter(|k| ports[*k].component == component);
        let rows: Vec<_> = own.collect();
        if rows.is_empty() {
            continue;
        }
        let capabilities = &wiring.description(component).capabilities;
        if !capabilities.directional_derivatives {
            return None;
        }
        found.push(Influence {
            component,
            outputs_and_inputs: [
                wiring.batch(component, rows.iter().map(|k| ports[*k].variable)),
                wiring.batch(component, inputs.iter().map(|(variable, _)| *variable)),
            ],
            seeds: inputs.iter().map(|(_, seed)| *seed).collect(),
            rates: vec![0.0; rows.len()],
            rows,
        });
    }
    Some(found)
}

/// The unknowns of the loops of a stage, with the workspace of the solver.
#[derive(Debug)]
pub(crate) struct Unknowns {
    names: Vec<String>,
    slots: Vec<usize>,
    y: Vec<f64>,
    residual: Vec<f64>,
    /// Directional derivatives for each unknown; None where finite differences are needed.
    influences: Vec<Option<Vec<Influence>>>,
    /// Jacobian of `y − g(y)`, row by row, with the residual as the last column.
    rows: Vec<Vec<f64>>,
    /// Iterations of the last solution.
    iterations: usize,
    /// Scale of each column.
    sizes: Vec<f64>,
}

impl Unknowns {
    /// The unknowns of these outputs, which must be Real; None if there are no outputs.
    pub fn new(
        wiring: &Wiring,
        slots: &BTreeMap<Port, usize>,
        outputs: impl Iterator<Item = Port>,
    ) -> Result<Option<Self>> {
        let ports: Vec<Port> = outputs.collect();
        let (n, names) = (ports.len(), ports.iter().map(|port| wiring.name(*port)));
        let is_no_real = |port: &&Port| wiring.access(**port) != Access::Real;
        if let Some(port) = ports.iter().find(is_no_real) {
            bail!(
                "`{}` is in an algebraic loop and not Real: such a loop cannot be solved",
                wiring.name(*port)
            );
        }
        Ok((n > 0).then(|| Self {
            names: names.collect(),
            slots: ports.iter().map(|port| slots[port]).collect(),
            y: vec![0.0; n],
            residual: vec![0.0; n],
            influences: (ports.iter())
                .map(|port| influences(wiring, &ports, *port))
                .collect(),
            rows: vec![vec![0.0; n + 1]; n],
            iterations: 0,
            sizes: vec![0.0; n],
        }))
    }

    /// Solve the loops of a stage whose outputs have just been read. Afterwards its inputs are set
    /// to the solution, and its outputs belong to it.
    pub fn solve(&mut self, stage: &mut dyn LoopStage, at: At) -> Result<()> {
        for (y, slot) in self.y.iter_mut().zip(&self.slots) {
            *y = stage.values()[*slot];
        }
        let mut before = f64::INFINITY;
        for iterations in 0..MAX_ITERATIONS {
            self.iterations = iterations;
            self.evaluate(stage)?;
            let residual = self.largest();
            // Rounding allows no better solution.
            let is_best = residual <= TOLERANCE && residual > 0.5 * before;
            if residual <= ROUNDING || is_best {
                return Ok(());
            }
            before = residual;
            self.differentiate(stage, at)?;
            if !eliminate(&mut self.rows, &mut self.sizes) {
                return self.fail(at, "they have no solution, or more than one");
            }
            for (y, row) in self.y.iter_mut().zip(&self.rows) {
                *y += row[row.len() - 1];
            }
            if !are_finite(&self.y) {
                return self.fail(at, "Newton's method leaves the range of numbers");
            }
        }
        self.fail(at, "Newton's method does not find a solution")
    }

    /// Compute the residual `g(y) − y`.
    fn evaluate(&mut self, stage: &mut dyn LoopStage) -> Result<()> {
        stage.rewind()?;
        self.put(stage);
        stage.write_and_read()?;
        let found = self.slots.iter().map(|slot| stage.values()[*slot]);
        for ((residual, y), found) in self.residual.iter_mut().zip(&self.y).zip(found) {
            *residual = found - y;
        }
        // The values passed on are those that were set.
        self.put(stage);
        Ok(())
    }

    fn put(&self, stage: &mut dyn LoopStage) {
        for (y, slot) in self.y.iter().zip(&self.slots) {
            stage.values()[*slot] = *y;
        }
    }

    /// Largest residual, relative to 1 plus the value.
    fn largest(&self) -> f64 {
        let all = self.residual.iter().zip(&self.y);
        all.map(|(residual, y)| residual.abs() / (1.0 + y.abs()))
            .fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) })
    }

    /// Compute the Jacobian at `y`, column by column.
    fn differentiate(&mut self, stage: &mut dyn LoopStage, at: At) -> Result<()> {
        for (row, residual) in self.rows.iter_mut().zip(&self.residual) {
            row[self.slots.len()] = *residual;
        }
        for j in 0..self.slots.len() {
            if let (Some(all), Some(instances)) =
                (&mut self.influences[j], stage.differentiable_instances())
            {
                for (i, row) in self.rows.iter_mut().enumerate() {
                    row[j] = f64::from(i == j);
                }
                for one in all {
                    let batches = one.outputs_and_inputs.each_ref();
                    let instance = &instances[one.component];
                    instance.directional(batches, &one.seeds, &mut one.rates, at)?;
                    for (i, rate) in one.rows.iter().zip(&one.rates) {
                        self.rows[*i][j] -= rate;
                    }
                }
                continue;
            }
            stage.rewind()?;
            let moved = self.y[j] + CHANGE * (1.0 + self.y[j].abs());
            let change = moved - self.y[j];
            self.put(stage);
            stage.values()[self.slots[j]] = moved;
            stage.write_and_read()?;
            for (i, row) in self.rows.iter_mut().enumerate() {
                let before = self.residual[i] + self.y[i];
                let slope = (stage.values()[self.slots[i]] - before) / change;
                row[j] = f64::from(i == j) - slope;
            }
        }
        Ok(())
    }

    #[cold]
    fn fail(&self, at: At, why: &str) -> Result<()> {
        let residuals = self.names.iter().zip(self.residual.iter().zip(&self.y));
        let residuals = residuals.map(|(name, (residual, y))| {
            format!("`{name}` is {y} and would become {}", y + residual)
        });
        let residuals: Vec<_> = residuals.collect();
        bail!(
            "algebraic loop {at}: after {} iterations {}; {why}",
            self.iterations,
            residuals.join(", ")
        )
    }
}

/// Solve linear equations by Gaussian elimination with scaling of rows and columns and partial
/// pivoting. Each row ends with its right side, which becomes the solution; `sizes` is workspace,
/// one per column. False if there is no unique solution. (`nalgebra` would allocate a permutation
/// in each solution.)
fn eliminate(rows: &mut [Vec<f64>], sizes: &mut [f64]) -> bool {
    let n = rows.len();
    let largest = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0, |a: f64, x| a.max(x.abs()));
    for row in rows.iter_mut() {
        let size = largest(&mut row[..n].iter().copied());
        row.iter_mut().for_each(|x| *x /= size);
    }
    for (j, size) in sizes.iter_mut().enumerate() {
        *size = largest(&mut rows.iter().map(|row| row[j]));
        rows.iter_mut().for_each(|row| row[j] /= *size);
    }
    for k in 0..n {
        let largest = (k..n).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs()));
        rows.swap(k, largest.unwrap_or(k));
        // Also false for a NaN.
        if rows[k][k].abs().partial_cmp(&SINGULAR) != Some(Ordering::Greater) {
            return false;
        }
        let (above, below) = rows.split_at_mut(k + 1);
        for row in below {
            let factor = row[k] / above[k][k];
            for (x, pivot) in row[k..].iter_mut().zip(&above[k][k..]) {
                *x -= factor * pivot;
            }
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| rows[k][j] * rows[j][n]).sum();
        rows[k][n] = (rows[k][n] - known) / rows[k][k];
    }
    for (row, size) in rows.iter_mut().zip(sizes) {
        row[n] /= *size;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_are_solved_with_pivots_and_singular_ones_are_detected() {
        let mut rows = vec![
            vec![0.0, 2.0, 0.0, 4.0],
            vec![1.0, 0.0, 1.0, 3.0],
            vec![1.0, 0.0, -1.0, 1.0],
        ];
        assert!(eliminate(&mut rows, &mut [0.0; 3]));
        let solution: Vec<_> = rows.iter().map(|row| row[3]).collect();
        assert_eq!(solution, [2.0, 2.0, 1.0]);
        // Units may lie far apart: x = 2e-12, y = 3.
        let mut rows = vec![vec![1e12, 1.0, 5.0], vec![1e9, -1e-3, -1e-3]];
        assert!(eliminate(&mut rows, &mut [0.0; 2]));
        assert!((rows[0][2] / 2e-12 - 1.0).abs() < 1e-14 && (rows[1][2] - 3.0).abs() < 1e-14);
        let mut rows = vec![vec![1.0, 2.0, 1.0], vec![2.0, 4.0, 1.0]];
        assert!(!eliminate(&mut rows, &mut [0.0; 2]));
    }
}
