//! The Rosenbrock method Rodas5P for stiff equations, for `Method::Stiff`: linearly implicit, so
//! that a step solves linear equations without iteration.
//!
//! Rodas5P by G. Steinebach, *Construction of Rosenbrock–Wanner method Rodas5P and numerical
//! benchmarks within the Julia Differential Equations package*, BIT Numerical Mathematics 63
//! (2023): order 5 with an error estimate of order 4, L-stable, of order 4 for parabolic equations,
//! for which other methods lose order. Its dense output is of order 4.

use super::algorithm::{Algorithm, Step, add, vectors};
use super::band_matrix::BandMatrix;
use super::sparsity_pattern::SparsityPattern;
use super::system::System;

/// Step of the time difference: 2⁻²⁴ of the internal step, at least 2⁻³⁰ of the time (rounding).
const LATER: [f64; 2] = [1.0 / (1 << 24) as f64, 1.0 / (1 << 30) as f64];
/// Relative step of state differences, √ε: truncation and rounding errors are about equal.
const AWAY: f64 = 1.0 / (1 << 26) as f64;

const GAMMA: f64 = 0.21193756319429014;
/// Coefficients of the earlier stages in the states of a stage. The last two stages start from the
/// states of the one before, plus its solution.
#[rustfmt::skip]
const A: [&[f64]; 6] = [
    &[],
    &[3.0],
    &[2.849394379747939, 0.45842242204463923],
    &[-6.954028509809101, 2.489845061869568, -10.358996098473584],
    &[2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641],
    &[-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946],
];
/// Coefficients of the earlier stages in the right side of a stage, over dt.
#[rustfmt::skip]
const C: [&[f64]; 8] = [
    &[],
    &[-14.155112264123755],
    &[-17.97296035885952, -2.859693295451294],
    &[147.12150275711716, -1.41221402718213, 71.68940251302358],
    &[165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306],
    &[24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471],
    &[30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783, -19.097331116725623, -28.087943162872662],
    &[37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047, -40.06618937091002, -54.66780262877968, -9.48861652309627],
];
/// Times of the stages, over dt.
#[rustfmt::skip]
const TIMES: [f64; 8] = [0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1.0, 1.0, 1.0];
/// Coefficients of ∂f/∂t, over dt.
#[rustfmt::skip]
const D: [f64; 8] = [GAMMA, -0.42387512638858027, -0.3384627126235924, 1.8046452872882734, 2.325825639765069, 0.0, 0.0, 0.0];
/// Coefficients of the dense output.
#[rustfmt::skip]
const H: [[f64; 8]; 3] = [
    [25.948786856663858, -2.5579724845846235, 10.433815404888879, -2.3679251022685204, 0.524948541321073, 1.1241088310450404,
        0.4272876194431874, -0.17202221070155493],
    [-9.91568850695171, -0.9689944594115154, 3.0438037242978453, -24.495224566215796, 20.176138334709044, 15.98066361424651,
        -6.789040303419874, -6.710236069923372],
    [11.419903575922262, 2.8879645146136994, 72.92137995996029, 80.12511834622643, -52.072871366152654, -59.78993625266729,
        -0.15582684282751913, 4.883087185713722],
];

/// The Jacobian and the solutions of the stages.
pub(crate) struct Rosenbrock {
    pattern: SparsityPattern,
    groups: Vec<Vec<usize>>,
    places: Vec<usize>,
    /// −∂f/∂x + 1/(γ dt), each state relative to its nominal value.
    band: BandMatrix,
    /// The element on the diagonal, for states whose rate depends on no other state; else NaN.
    alone: Vec<f64>,
    /// In the order of the pattern.
    jacobian: Vec<f64>,
    stages: [Vec<f64>; 8],
    /// f and ∂f/∂t at the start of the step.
    rates: [Vec<f64>; 2],
    seed: Vec<f64>,
    right: Vec<f64>,
    ordered: Vec<f64>,
}

impl Rosenbrock {
    pub(crate) fn new(pattern: SparsityPattern) -> Self {
        let n = pattern.len();
        let (places, lower, upper) = pattern.order();
        Self {
            groups: pattern.groups(),
            places,
            band: BandMatrix::new(n, lower, upper),
            alone: vec![0.0; n],
            jacobian: vec![0.0; pattern.non_zeros()],
            pattern,
            stages: vectors(n),
            rates: vectors(n),
            seed: vec![0.0; n],
            right: vec![0.0; n],
            ordered: vec![0.0; n],
        }
    }

    /// Computes the Jacobian by groups of columns: with directional derivatives or differences.
    fn differentiate<S: System>(&mut self, system: &mut S, step: &Step) -> Result<(), S::Error> {
        let Step { s, x, nominal, .. } = step;
        let Self {
            seed,
            right,
            rates: [rate, _],
            ..
        } = self;
        for group in &self.groups {
            seed.fill(0.0);
            group.iter().for_each(|&j| seed[j] = 1.0);
            let is_exact = system.directional(*s, x, seed, right)?;
            if !is_exact {
                seed.copy_from_slice(x);
                for &j in group {
                    seed[j] += AWAY * x[j].abs().max(nominal[j]);
                }
                system.derivative(*s, seed, right)?;
            }
            for &j in group {
                for (place, i) in self.pattern.column(j) {
                    self.jacobian[place] = match is_exact {
                        true => right[i],
                        false => (right[i] - rate[i]) / (seed[j] - x[j]),
                    };
                }
            }
        }
        Ok(())
    }

    /// Factorizes 1/(γ dt) − ∂f/∂x.
    fn factorize(&mut self, dt: f64, nominal: &[f64]) -> bool {
        self.band.clear();
        self.alone.fill(1.0 / (GAMMA * dt));
        for j in 0..self.pattern.len() {
            let column = self.places[j];
            for (place, i) in self.pattern.column(j) {
                let rate = self.jacobian[place];
                *self.band.at(self.places[i], column) = -rate * nominal[j] / nominal[i];
                match i == j {
                    true => self.alone[i] -= rate,
                    false if rate != 0.0 => self.alone[i] = f64::NAN,
                    false => {}
                }
            }
            *self.band.at(column, column) += 1.0 / (GAMMA * dt);
        }
        self.band.factorize()
    }
}

impl Algorithm for Rosenbrock {
    const HAS_JACOBIAN: bool = true;

    fn begin<S: System>(&mut self, system: &mut S, step: &Step) -> Result<&[f64], S::Error> {
        let &Step {
            t, s, dt, ref x, ..
        } = step;
        let [rate, dot] = &mut self.rates;
        system.derivative(s, x, rate)?;
        let later = (s + (LATER[0] * dt).max(LATER[1] * (t + s).abs())) - s;
        system.derivative(s + later, x, dot)?;
        dot.iter_mut()
            .zip(&*rate)
            .for_each(|(dot, rate)| *dot = (*dot - rate) / later);
        self.differentiate(system, step)?;
        Ok(&self.rates[0])
    }

    fn step<S: System>(&mut self, system: &mut S, step: &mut Step) -> Result<bool, S::Error> {
        let (s, dt, end, nominal) = (step.s, step.dt, &mut step.end, &step.nominal);
        if !self.factorize(dt, nominal) {
            return Ok(false);
        }
        for k in 0..8 {
            match A.get(k) {
                Some(row) => {
                    end.copy_from_slice(&step.x);
                    add(end, row.iter().copied(), &self.stages);
                }
                None => add(end, [1.0], &self.stages[k - 1..]),
            }
            match k {
                0 => self.right.copy_from_slice(&self.rates[0]),
                _ => system.derivative(s + TIMES[k] * dt, end, &mut self.right)?,
            }
            add(&mut self.right, [D[k] * dt], &self.rates[1..]);
            add(&mut self.right, C[k].iter().map(|c| c / dt), &self.stages);
            for (i, place) in self.places.iter().enumerate() {
                self.ordered[*place] = self.right[i] / nominal[i];
            }
            self.band.solve(&mut self.ordered);
            // Swapped rows mix the rounding errors of all states, but a rate of zero stays zero.
            for (i, place) in self.places.iter().enumerate() {
                self.stages[k][i] = match self.alone[i].is_nan() {
                    true => nominal[i] * self.ordered[*place],
                    false => self.right[i] / self.alone[i],
                };
            }
        }
        step.error.copy_from_slice(&self.stages[7]);
        add(end, [1.0], &self.stages[7..]);
        Ok(true)
    }

    fn dense_output<S: System>(&mut self, _: &mut S, step: &mut Step) -> Result<(), S::Error> {
        for (to, row) in step.dense.iter_mut().zip(H) {
            to.fill(0.0);
            add(to, row, &self.stages);
        }
        Ok(())
    }
}
