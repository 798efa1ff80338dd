//! Dense LU factorisation with row pivoting, for the iteration matrix of implicit methods (f64).
//!
//! Unknowns are eliminated from the last to the first, column by column: a crane's cylinder states come last and
//! touch no other cylinder, so eliminating them first leaves most of the matrix zero, and zeros are skipped.

/// A factored square matrix.
#[derive(Debug, Clone, Default)]
pub struct Lu {
    n: usize,
    /// Column-major, rows and columns in reverse order.
    lu: Vec<f64>,
    pivot: Vec<usize>,
    inverse_diagonal: Vec<f64>,
}

impl Lu {
    /// Factors the row-major `n x n` matrix `a`; `false` where a pivot vanishes or is not finite.
    pub fn factor(&mut self, n: usize, a: &[f64]) -> bool {
        self.n = n;
        self.lu.resize(n * n, 0.0);
        self.pivot.resize(n, 0);
        self.inverse_diagonal.resize(n, 0.0);
        for (i, row) in a.chunks_exact(n).rev().enumerate() {
            for (j, value) in row.iter().rev().enumerate() {
                self.lu[j * n + i] = *value;
            }
        }
        (0..n).all(|k| self.eliminate(k))
    }

    fn eliminate(&mut self, k: usize) -> bool {
        let n = self.n;
        let magnitude = |row: usize| self.lu[k * n + row].abs();
        let best = (k + 1..n).fold(k, |best, row| if magnitude(row) > magnitude(best) { row } else { best });
        let pivot = self.lu[k * n + best];
        if pivot == 0.0 || !pivot.is_finite() {
            return false;
        }
        self.pivot[k] = best;
        if best != k {
            for column in self.lu.chunks_exact_mut(n) {
                column.swap(k, best);
            }
        }
        let inverse = 1.0 / pivot;
        self.inverse_diagonal[k] = inverse;
        let (head, tail) = self.lu.split_at_mut((k + 1) * n);
        let factors = &mut head[k * n + k + 1..];
        factors.iter_mut().for_each(|f| *f *= inverse);
        for column in tail.chunks_exact_mut(n) {
            let (top, below) = column.split_at_mut(k + 1);
            if top[k] != 0.0 {
                subtract(below, top[k], factors);
            }
        }
        true
    }

    /// Replaces `b` by the solution of `a x = b`.
    pub fn solve(&self, b: &mut [f64]) {
        let n = self.n;
        b.reverse();
        for k in 0..n {
            b.swap(k, self.pivot[k]);
        }
        for k in 0..n {
            let (done, rest) = b.split_at_mut(k + 1);
            if done[k] != 0.0 {
                subtract(rest, done[k], &self.lu[k * n + k + 1..(k + 1) * n]);
            }
        }
        for k in (0..n).rev() {
            let (rest, solved) = b.split_at_mut(k);
            solved[0] *= self.inverse_diagonal[k];
            subtract(rest, solved[0], &self.lu[k * n..k * n + k]);
        }
        b.reverse();
    }
}

/// y -= a x
fn subtract(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y -= a * x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_system_that_needs_pivoting() {
        let a = [0.0, 2.0, 1.0, 1.0, -1.0, 0.0, 3.0, 0.5, -2.0];
        let x = [1.0, -2.0, 3.0];
        let mut b: Vec<f64> = a.chunks(3).map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum()).collect();
        let mut lu = Lu::default();
        assert!(lu.factor(3, &a));
        lu.solve(&mut b);
        for (x, y) in x.iter().zip(&b) {
            assert!((x - y).abs() < 1e-14);
        }
    }

    #[test]
    fn reports_a_singular_matrix() {
        assert!(!Lu::default().factor(2, &[1.0, 2.0, 2.0, 4.0]));
        assert!(!Lu::default().factor(1, &[f64::NAN]));
    }
}
