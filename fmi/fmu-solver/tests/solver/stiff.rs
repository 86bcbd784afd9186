//! Stiff problems: closed forms, and two of the literature by SciPy.

use crate::problem::{Answer, Problem, solver};
use fmu_solver::{Counts, Method, Solver, SparsityPattern, System};

/// At each time: the states, by golden.py.
#[rustfmt::skip]
const ROBERTSON: [(f64, [f64; 3]); 3] = [
    (0.4, [0.9851721138609895, 3.3863953789749015e-05, 0.01479402218522051]),
    (40.0, [0.7158270687194024, 9.185534764557661e-06, 0.2841637457458296]),
    (4000.0, [0.18320225777672142, 8.942371252776661e-07, 0.8167968479861502]),
];
#[rustfmt::skip]
const VAN_DER_POL: [(f64, [f64; 2]); 3] = [
    (400.0, [1.6932094268309064, -0.0009069343138535582]),
    (800.0, [1.0839233646424995, -0.006195233865027993]),
    (1000.0, [-1.8636462548081905, 0.0007535430865435049]),
];

/// Cells, tolerance, and the right-hand sides and Jacobians that SciPy's BDF needs for the rod
/// below, by golden.py.
#[rustfmt::skip]
const BDF: [(usize, f64, u64); 6] = [
    (64, 1e-4, 65), (64, 1e-6, 127), (64, 1e-8, 227), (1000, 1e-4, 65), (1000, 1e-6, 127), (1000, 1e-8, 227),
];

fn robertson(_: f64, x: &[f64], dx: &mut [f64]) -> Answer {
    let (a, b, c) = (0.04 * x[0], 1e4 * x[1] * x[2], 3e7 * x[1] * x[1]);
    (dx[0], dx[1], dx[2]) = (b - a, a - b - c, c);
    Ok(())
}

fn van_der_pol(_: f64, x: &[f64], dx: &mut [f64]) -> Answer {
    (dx[0], dx[1]) = (x[1], 1e3 * ((1.0 - x[0] * x[0]) * x[1]) - x[0]);
    Ok(())
}

/// The largest error over the sizes, at the given times one after the other.
fn error<const N: usize>(
    f: fn(f64, &[f64], &mut [f64]) -> Answer,
    mut x: [f64; N],
    sizes: [f64; N],
    golden: &[(f64, [f64; N])],
    tolerance: f64,
) -> (f64, Counts) {
    let mut solver = Solver::new(
        Method::Stiff(SparsityPattern::full(N)),
        sizes.to_vec(),
        0,
        f64::INFINITY,
    );
    solver.set_tolerance(tolerance);
    let (mut t, mut first, mut worst) = (0.0, 0.0, 0.0_f64);
    for (time, exact) in golden {
        solver
            .advance(&mut Problem::new(f), (t, time - t), &mut x, &mut first)
            .unwrap();
        t = *time;
        for i in 0..N {
            worst = worst.max((x[i] - exact[i]).abs() / sizes[i].max(exact[i].abs()));
        }
    }
    (worst, solver.counts())
}

/// The errors of the internal steps add up: bound by the tolerance times their number. Reactions
/// damp them; the oscillator's jump moves in time with them, of which the golden times are far
/// enough away.
#[test]
fn the_tolerance_is_kept_for_stiff_problems_of_the_literature() {
    for tolerance in [1e-5, 1e-7, 1e-9] {
        let (worst, counts) = error(
            robertson,
            [1.0, 0.0, 0.0],
            [1.0, 1e-5, 1.0],
            &ROBERTSON,
            tolerance,
        );
        assert!(
            worst < tolerance * counts.steps as f64,
            "{tolerance:e}: {worst:e} {counts:?}"
        );
        assert!(counts.steps < 600, "{counts:?}");
        let (worst, counts) = error(
            van_der_pol,
            [2.0, 0.0],
            [1.0, 1e-3],
            &VAN_DER_POL,
            tolerance,
        );
        assert!(
            worst < tolerance * counts.steps as f64,
            "{tolerance:e}: {worst:e} {counts:?}"
        );
        assert!(counts.steps < 2500, "{counts:?}");
    }
}

/// x₁' = −10⁶ (x₁ − cos t) − sin t, x₁ = cos t (Prothero and Robinson): a method that is not
/// L-stable or that errs in ∂f/∂t is off by far more than the tolerance.
#[test]
fn a_slow_solution_among_fast_ones_is_followed() {
    let near = |s: f64, x: &[f64], dx: &mut [f64]| {
        dx[0] = -1e6 * (x[0] - s.cos()) - s.sin();
        Ok(())
    };
    for start in [1.0, 3.0] {
        let mut x = [start];
        let mut solver = solver(
            &Method::Stiff(SparsityPattern::full(1)),
            1,
            0,
            f64::INFINITY,
            1e-8,
        );
        solver
            .advance(&mut Problem::new(near), (0.0, 10.0), &mut x, &mut 0.0)
            .unwrap();
        assert!((x[0] - 10.0_f64.cos()).abs() < 1e-7, "{x:?}");
        assert!(solver.counts().steps < 120, "{:?}", solver.counts());
    }
}

/// Conduction in a rod of n cells with isolated ends. The discrete Laplacian's eigenvector of
/// wave number k, cos(π k (i + ½)/n), decays at λ = 4 n² sin²(π k/(2 n)).
struct Rod {
    n: usize,
    is_exact: bool,
    evaluations: u64,
}

impl Rod {
    fn slope(&self, x: &[f64], dx: &mut [f64]) {
        let share = (self.n * self.n) as f64;
        for i in 0..self.n {
            let left = if i > 0 { x[i - 1] - x[i] } else { 0.0 };
            let right = if i + 1 < self.n { x[i + 1] - x[i] } else { 0.0 };
            dx[i] = share * (left + right);
        }
    }

    fn exact(&self, t: f64) -> Vec<f64> {
        let n = self.n as f64;
        let wave = |k: f64, i: usize| {
            let half = std::f64::consts::FRAC_PI_2 * k / n;
            (half * (2 * i + 1) as f64).cos() * (-4.0 * n * n * half.sin().powi(2) * t).exp()
        };
        (0..self.n)
            .map(|i| 2.0 + wave(1.0, i) + 0.5 * wave(4.0, i))
            .collect()
    }
}

impl System for Rod {
    type Error = String;

    fn derivative(&mut self, _s: f64, x: &[f64], dx: &mut [f64]) -> Answer {
        self.evaluations += 1;
        self.slope(x, dx);
        Ok(())
    }

    fn directional(
        &mut self,
        _s: f64,
        _x: &[f64],
        seed: &[f64],
        change: &mut [f64],
    ) -> Result<bool, String> {
        if self.is_exact {
            self.slope(seed, change);
        }
        Ok(self.is_exact)
    }
}

/// The tolerance is kept, whatever the number of cells, and the number of evaluations hardly
/// depends on it: the fastest rate is 4 n². It is at most 1.5 times what SciPy's BDF needs. With
/// directional derivatives three evaluations a Jacobian are saved.
#[test]
fn a_rod_follows_its_closed_form() {
    for n in [8, 64, 1000] {
        let near =
            (0..n).flat_map(|i: usize| (i.saturating_sub(1)..(i + 2).min(n)).map(move |j| (i, j)));
        let method = Method::Stiff(SparsityPattern::new(n, near));
        for tolerance in [1e-4, 1e-6, 1e-8] {
            let evaluations = [false, true].map(|is_exact| {
                let mut rod = Rod {
                    n,
                    is_exact,
                    evaluations: 0,
                };
                let mut solver = solver(&method, n, 0, f64::INFINITY, tolerance);
                let mut x = rod.exact(0.0);
                solver
                    .advance(&mut rod, (0.0, 0.1), &mut x, &mut 0.0)
                    .unwrap();
                let error = (x.iter().zip(rod.exact(0.1)))
                    .map(|(a, b)| (a - b).abs())
                    .fold(0.0, f64::max);
                let counts = solver.counts();
                assert!(
                    error < 2.0 * tolerance,
                    "{n} {tolerance:e}: {error:e} {counts:?}"
                );
                assert_eq!(
                    rod.evaluations,
                    7 * (counts.steps + counts.rejected)
                        + counts.jacobians * if is_exact { 2 } else { 5 }
                );
                if is_exact {
                    let effort = rod.evaluations + counts.jacobians;
                    let bdf = BDF.iter().find(|row| (row.0, row.1) == (n, tolerance));
                    println!("{n} cells, {tolerance:e}: {effort}, error {error:.1e}; BDF {bdf:?}");
                    assert!(
                        bdf.is_none_or(|row| 2 * effort <= 3 * row.2),
                        "{effort} {bdf:?}"
                    );
                }
                rod.evaluations
            });
            assert!(
                evaluations[1] < evaluations[0] && evaluations[0] < 500,
                "{n} {tolerance:e}: {evaluations:?}"
            );
        }
    }
}

/// Oracle: a state without a rate keeps its bits, and so does one that decays and is zero, whatever
/// fast states beside them do, which read them and differ from them by orders of magnitude.
#[test]
fn a_rate_of_zero_stays_zero() {
    let f = |_: f64, x: &[f64], dx: &mut [f64]| -> Answer {
        dx[0] = -1e6 * (x[0] - 1e5 * x[1].cos()) + 3e7 * x[2] - 4e8 * x[3];
        dx[1] = 0.7 * x[2] - 1e-7 * x[0] + 2.0 * x[3];
        (dx[2], dx[3]) = (0.0, -5.0 * x[3]);
        Ok(())
    };
    for nominal in [[1.0; 4], [1e5, 1.0, 1e-3, 1e-6]] {
        let mut solver = Solver::new(
            Method::Stiff(SparsityPattern::full(4)),
            nominal.to_vec(),
            0,
            f64::INFINITY,
        );
        let (mut x, mut first) = ([0.0, 0.3, 0.1, 0.0], 0.0);
        for k in 0..70 {
            let t = f64::from(k) * 0.01;
            solver
                .advance(&mut Problem::new(f), (t, 0.01), &mut x, &mut first)
                .unwrap();
        }
        assert_eq!((x[2], x[3]), (0.1, 0.0), "{x:?}");
    }
}
