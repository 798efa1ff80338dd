//! Dense systems of linear equations of any size, over any field.

use crate::Field;

/// The inverse of a square matrix, for systems without structure: lanes may each swap rows of their own.
#[derive(Debug, Clone, Default)]
pub struct Inverse<T> {
    n: usize,
    /// Row-major.
    rows: Vec<T>,
}

impl<T: Field> Inverse<T> {
    /// Inverts the row-major `n x n` matrix `a` by elimination with row pivoting; the mask tells where every number came out
    /// finite.
    #[inline(always)]
    pub fn of(&mut self, n: usize, a: &[T]) -> T::Mask {
        let mut a = a.to_vec();
        self.n = n;
        self.rows = vec![T::c(0.0); n * n];
        self.rows.iter_mut().step_by(n + 1).for_each(|one| *one = T::c(1.0));
        for k in 0..n {
            for row in k + 1..n {
                let larger = a[k * n + k].nearer_zero(a[row * n + k]);
                swap_where(larger, &mut a, n, k, row);
                swap_where(larger, &mut self.rows, n, k, row);
            }
            let inverse = T::c(1.0) / a[k * n + k];
            for row in (0..n).filter(|row| *row != k) {
                let factor = a[row * n + k] * inverse;
                subtract(&mut a, n, row, factor, k);
                subtract(&mut self.rows, n, row, factor, k);
            }
            for j in 0..n {
                a[k * n + j] = a[k * n + j] * inverse;
                self.rows[k * n + j] = self.rows[k * n + j] * inverse;
            }
        }
        self.rows.iter().fold(T::c(0.0).finite(), |sound, number| sound & number.finite())
    }

    /// Replaces `b` by the solution of `a x = b`.
    #[inline(always)]
    pub fn solve(&self, b: &mut [T]) {
        let known = b.to_vec();
        for (x, row) in b.iter_mut().zip(self.rows.chunks_exact(self.n)) {
            *x = T::c(0.0);
            for (entry, known) in row.iter().zip(&known) {
                *x += *entry * *known;
            }
        }
    }
}

/// Swaps two rows where the mask holds.
#[inline(always)]
fn swap_where<T: Field>(mask: T::Mask, a: &mut [T], n: usize, i: usize, j: usize) {
    for column in 0..n {
        let (upper, lower) = (a[i * n + column], a[j * n + column]);
        a[i * n + column] = T::select(mask, lower, upper);
        a[j * n + column] = T::select(mask, upper, lower);
    }
}

/// row i -= factor row k
#[inline(always)]
fn subtract<T: Field>(a: &mut [T], n: usize, i: usize, factor: T, k: usize) {
    for column in 0..n {
        let from = a[k * n + column];
        a[i * n + column] -= factor * from;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Complex;

    #[test]
    fn solves_a_system_that_needs_pivoting() {
        let a = [0.0, 2.0, 1.0, 1.0, -1.0, 0.0, 3.0, 0.5, -2.0];
        let x = [1.0, -2.0, 3.0];
        let mut b: Vec<f64> = a.chunks(3).map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum()).collect();
        let mut inverse = Inverse::default();
        assert!(inverse.of(3, &a));
        inverse.solve(&mut b);
        for (x, y) in x.iter().zip(&b) {
            assert!((x - y).abs() < 1e-14);
        }
    }

    #[test]
    fn solves_a_complex_system() {
        let a = [Complex::new(0.0, 0.0), Complex::new(2.0, 1.0), Complex::new(1.0, -1.0), Complex::new(0.5, 0.0)];
        let x = [Complex::new(1.0, 2.0), Complex::new(-0.5, 0.25)];
        let mut b = [a[0] * x[0] + a[1] * x[1], a[2] * x[0] + a[3] * x[1]];
        let mut inverse = Inverse::default();
        assert!(inverse.of(2, &a));
        inverse.solve(&mut b);
        for (x, y) in x.iter().zip(&b) {
            assert!((x.re - y.re).abs() < 1e-14 && (x.im - y.im).abs() < 1e-14);
        }
    }

    #[test]
    fn reports_a_singular_matrix() {
        assert!(!Inverse::default().of(2, &[1.0, 2.0, 2.0, 4.0]));
        assert!(!Inverse::default().of(1, &[f64::NAN]));
    }
}
