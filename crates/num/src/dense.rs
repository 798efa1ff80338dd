//! Dense LU factorisation with row pivoting, for the iteration matrix of implicit methods (f64, row-major).

/// A factored square matrix.
#[derive(Debug, Clone, Default)]
pub struct Lu {
    n: usize,
    lu: Vec<f64>,
    pivot: Vec<usize>,
}

impl Lu {
    /// Factors the row-major `n x n` matrix `a`; `false` where a pivot vanishes or is not finite.
    pub fn factor(&mut self, n: usize, a: &[f64]) -> bool {
        self.n = n;
        self.lu.clear();
        self.lu.extend_from_slice(a);
        self.pivot.resize(n, 0);
        (0..n).all(|k| self.eliminate(k))
    }

    fn eliminate(&mut self, k: usize) -> bool {
        let n = self.n;
        let magnitude = |row: usize| self.lu[row * n + k].abs();
        let best = (k + 1..n).fold(k, |best, row| if magnitude(row) > magnitude(best) { row } else { best });
        let pivot = self.lu[best * n + k];
        if pivot == 0.0 || !pivot.is_finite() {
            return false;
        }
        self.pivot[k] = best;
        if best != k {
            for j in 0..n {
                self.lu.swap(k * n + j, best * n + j);
            }
        }
        let (head, tail) = self.lu.split_at_mut((k + 1) * n);
        let pivot_row = &head[k * n..];
        for row in tail.chunks_exact_mut(n) {
            let factor = row[k] / pivot;
            row[k] = factor;
            // Most of a crane's matrix is zero: its cylinders do not see each other.
            if factor != 0.0 {
                for j in k + 1..n {
                    row[j] -= factor * pivot_row[j];
                }
            }
        }
        true
    }

    /// Replaces `b` by the solution of `a x = b`.
    pub fn solve(&self, b: &mut [f64]) {
        let n = self.n;
        for k in 0..n {
            b.swap(k, self.pivot[k]);
        }
        for i in 1..n {
            let (done, rest) = b.split_at_mut(i);
            rest[0] -= dot(&self.lu[i * n..i * n + i], done);
        }
        for i in (0..n).rev() {
            let (head, tail) = b.split_at_mut(i + 1);
            let row = &self.lu[i * n..(i + 1) * n];
            head[i] = (head[i] - dot(&row[i + 1..], tail)) / row[i];
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_system_that_needs_pivoting() {
        let a = [0.0, 2.0, 1.0, 1.0, -1.0, 0.0, 3.0, 0.5, -2.0];
        let x = [1.0, -2.0, 3.0];
        let mut b: Vec<f64> = a.chunks(3).map(|row| dot(row, &x)).collect();
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
