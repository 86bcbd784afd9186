//! LU factorization of band matrices, for `rosenbrock`; a full matrix has the widest band.

/// A square band matrix, or its factors once it is factorized.
pub(crate) struct BandMatrix {
    n: usize,
    lower: usize,
    /// Upper bandwidth of the factor U, which is wider than that of the matrix: rows are swapped.
    upper: usize,
    width: usize,
    /// Row by row, each from `lower` left of the diagonal to `upper` right of it.
    values: Vec<f64>,
    pivots: Vec<usize>,
}

impl BandMatrix {
    /// A zero matrix of `n` rows, with `lower` diagonals below and `upper` above the main one.
    pub(crate) fn new(n: usize, lower: usize, upper: usize) -> Self {
        let upper = (lower + upper).min(n.saturating_sub(1));
        let width = lower + upper + 1;
        Self {
            n,
            lower,
            upper,
            width,
            values: vec![0.0; n * width],
            pivots: vec![0; n],
        }
    }

    pub(crate) fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// The element of row `i` and column `j`, which must lie in the band.
    #[inline]
    pub(crate) fn at(&mut self, i: usize, j: usize) -> &mut f64 {
        let place = self.place(i, j);
        &mut self.values[place]
    }

    #[inline]
    fn place(&self, i: usize, j: usize) -> usize {
        i * self.width + j + self.lower - i
    }

    /// Replaces the matrix by its LU factors, with partial pivoting; false if it is singular.
    pub(crate) fn factorize(&mut self) -> bool {
        for k in 0..self.n {
            let below = (k + self.lower).min(self.n - 1);
            let end = (k + self.upper).min(self.n - 1);
            let mut pivot = k;
            for i in k + 1..=below {
                if self.at(i, k).abs() > self.at(pivot, k).abs() {
                    pivot = i;
                }
            }
            self.pivots[k] = pivot;
            let length = end - k + 1;
            let (from, to) = (self.place(k, k), self.place(pivot, k));
            if pivot != k {
                let (head, tail) = self.values.split_at_mut(to);
                head[from..from + length].swap_with_slice(&mut tail[..length]);
            }
            let diagonal = self.values[from];
            if diagonal == 0.0 || !diagonal.is_finite() {
                return false;
            }
            for i in k + 1..=below {
                let row = self.place(i, k);
                let (head, tail) = self.values.split_at_mut(row);
                let factor = tail[0] / diagonal;
                tail[0] = factor;
                if factor != 0.0 {
                    let above = &head[from + 1..from + length];
                    for (a, b) in tail[1..length].iter_mut().zip(above) {
                        *a -= factor * b;
                    }
                }
            }
        }
        true
    }

    /// Replaces b by the solution of A x = b, after [`factorize`](Self::factorize).
    pub(crate) fn solve(&self, b: &mut [f64]) {
        for k in 0..self.n {
            b.swap(k, self.pivots[k]);
            let known = b[k];
            let below = (k + self.lower).min(self.n - 1);
            for (i, b) in b.iter_mut().enumerate().take(below + 1).skip(k + 1) {
                *b -= self.values[self.place(i, k)] * known;
            }
        }
        for k in (0..self.n).rev() {
            let row = &self.values[self.place(k, k)..];
            let known = &b[k + 1..=(k + self.upper).min(self.n - 1)];
            let sum = (row[1..].iter().zip(known)).fold(b[k], |sum, (u, x)| sum - u * x);
            b[k] = sum / row[0];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Oracle: the product of the matrix and a known solution. Numbers of a fixed sequence, some
    /// diagonals zero so that rows must be swapped. Backward stable: the residual of the solution
    /// is some n ε of the largest product of |A| |x|.
    #[test]
    fn the_solution_gives_back_the_right_side() {
        for (n, lower, upper) in [
            (1, 0, 0),
            (7, 6, 6),
            (40, 1, 1),
            (40, 3, 1),
            (40, 0, 2),
            (23, 2, 5),
        ] {
            let value = |i: usize, j: usize| {
                let is_inside = j + lower >= i && i + upper >= j;
                let zero = i == j && i % 3 == 1 && lower > 0;
                if is_inside && !zero {
                    ((7 * i + 13 * j) as f64).sin() + 0.1
                } else {
                    0.0
                }
            };
            let exact: Vec<f64> = (0..n).map(|i| (i as f64 * 0.7).cos()).collect();
            let mut b: Vec<f64> = (0..n)
                .map(|i| (0..n).map(|j| value(i, j) * exact[j]).sum())
                .collect();
            let wanted = b.clone();
            let mut a = BandMatrix::new(n, lower, upper);
            for i in 0..n {
                for j in i.saturating_sub(lower)..(i + upper + 1).min(n) {
                    *a.at(i, j) = value(i, j);
                }
            }
            assert!(a.factorize(), "{n} {lower} {upper}");
            a.solve(&mut b);
            for (i, wanted) in wanted.iter().enumerate() {
                let (got, size) = (0..n).fold((0.0, 0.0), |(sum, size), j| {
                    let product: f64 = value(i, j) * b[j];
                    (sum + product, size + product.abs())
                });
                let bound = 8.0 * n as f64 * f64::EPSILON * (size + 1.0);
                assert!(
                    (got - wanted).abs() < bound,
                    "{n} {lower} {upper}: {got} {wanted}"
                );
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        let mut a = BandMatrix::new(2, 1, 1);
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            *a.at(i, j) = 3.0;
        }
        assert!(!a.factorize());
    }
}
