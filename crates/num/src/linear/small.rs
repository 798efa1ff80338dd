//! Linear algebra for the few unknowns of a crane, generic over the number type.

use crate::{Field, Real};

/// Solves `a x = b` for a symmetric positive definite `a` by `L D L^T`, without pivoting and without a root.
/// Only the lower triangle of `a` is read.
pub fn solve_spd<T: Real, const N: usize>(a: &[[T; N]; N], b: &[T; N]) -> [T; N] {
    Spd::new(a).solve(b)
}

/// A factored symmetric positive definite matrix `L D L^T`.
#[derive(Debug, Clone, Copy)]
pub struct Spd<T, const N: usize> {
    /// Unit lower triangle.
    l: [[T; N]; N],
    inverse_d: [T; N],
}

impl<T: Real, const N: usize> Spd<T, N> {
    /// Reads the lower triangle of `a` only.
    #[inline(always)]
    pub fn new(a: &[[T; N]; N]) -> Self {
        let (l, inverse_d) = factor_spd(a);
        Spd { l, inverse_d }
    }

    #[inline(always)]
    pub fn solve(&self, b: &[T; N]) -> [T; N] {
        let mut x = *b;
        for i in 0..N {
            for j in 0..i {
                x[i] -= self.l[i][j] * x[j];
            }
        }
        for i in 0..N {
            x[i] = x[i] * self.inverse_d[i];
        }
        for i in (0..N).rev() {
            for j in i + 1..N {
                x[i] -= self.l[j][i] * x[j];
            }
        }
        x
    }
}

/// The inverse of a general matrix by elimination with row pivoting; of a singular one, numbers that are not finite.
/// For matrices so small that a product with the inverse is quicker than a chain of substitutions.
#[inline(always)]
pub fn inverse<T: Field, const N: usize>(mut a: [[T; N]; N]) -> [[T; N]; N] {
    let mut out = [[T::c(0.0); N]; N];
    for i in 0..N {
        out[i][i] = T::c(1.0);
    }
    for k in 0..N {
        for row in k + 1..N {
            let larger = a[k][k].nearer_zero(a[row][k]);
            swap_where(larger, &mut a, k, row);
            swap_where(larger, &mut out, k, row);
        }
        let inverse = T::c(1.0) / a[k][k];
        for j in 0..N {
            a[k][j] = a[k][j] * inverse;
            out[k][j] = out[k][j] * inverse;
        }
        for i in 0..N {
            if i != k {
                let factor = a[i][k];
                for j in 0..N {
                    a[i][j] -= factor * a[k][j];
                    out[i][j] -= factor * out[k][j];
                }
            }
        }
    }
    out
}

/// Swaps two rows where the mask holds.
#[inline(always)]
fn swap_where<T: Field, const N: usize>(mask: T::Mask, a: &mut [[T; N]; N], i: usize, j: usize) {
    for column in 0..N {
        let (upper, lower) = (a[i][column], a[j][column]);
        a[i][column] = T::select(mask, lower, upper);
        a[j][column] = T::select(mask, upper, lower);
    }
}

/// Smallest pivot of `L D L^T` as a share of its diagonal entry: what rounding leaves of a symmetric matrix. Zero, negative
/// or NaN where it is not positive definite.
pub fn least_pivot<const N: usize>(a: &[[f64; N]; N]) -> f64 {
    let (_, inverse_d) = factor_spd(a);
    let shares = (0..N).map(|j| 1.0 / (inverse_d[j] * a[j][j]));
    shares.fold(1.0, |least, share| if share < least || share.is_nan() { share } else { least })
}

/// Unit lower triangle `L` and the inverses of the pivots `D`.
#[inline(always)]
fn factor_spd<T: Real, const N: usize>(a: &[[T; N]; N]) -> ([[T; N]; N], [T; N]) {
    let mut l = [[T::c(0.0); N]; N];
    let mut d = [T::c(0.0); N];
    let mut inverse_d = d;
    for j in 0..N {
        let mut pivot = a[j][j];
        for k in 0..j {
            pivot -= l[j][k] * l[j][k] * d[k];
        }
        d[j] = pivot;
        inverse_d[j] = T::c(1.0) / pivot;
        for i in j + 1..N {
            let mut s = a[i][j];
            for k in 0..j {
                s -= l[i][k] * l[j][k] * d[k];
            }
            l[i][j] = s * inverse_d[j];
        }
    }
    (l, inverse_d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_symmetric_positive_definite_system() {
        let a = [[4.0, 1.0, 0.5], [1.0, 3.0, -0.2], [0.5, -0.2, 2.0]];
        let x = [1.0, -2.0, 3.0];
        let b = crate::array::from_fn(|i| (0..3).map(|j| a[i][j] * x[j]).sum());
        let y = solve_spd(&a, &b);
        for i in 0..3 {
            assert!((x[i] - y[i]).abs() < 1e-14);
        }
    }

    #[test]
    fn inverts_a_matrix_that_needs_pivoting_and_leaves_nothing_finite_of_a_singular_one() {
        let a = [[0.0, 2.0, 1.0], [1.0, -1.0, 0.0], [3.0, 0.5, -2.0]];
        let b = inverse(a);
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| a[i][k] * b[k][j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
        for singular in [[[1.0, 2.0], [2.0, 4.0]], [[0.0; 2]; 2], [[1.0, f64::NAN], [0.0, 1.0]]] {
            assert!(inverse(singular).iter().flatten().any(|v: &f64| !v.is_finite()), "{singular:?}");
        }
    }

    #[test]
    fn the_least_pivot_tells_how_near_to_singular_a_matrix_is() {
        assert!((least_pivot(&[[4.0, 0.0], [0.0, 1e-9]]) - 1.0).abs() < 1e-15);
        assert!((least_pivot(&[[1.0, 1.0], [1.0, 1.0 + 1e-6]]) - 1e-6).abs() < 1e-11);
        assert!(least_pivot(&[[1.0, 2.0], [2.0, 1.0]]) < 0.0);
        assert_eq!(least_pivot(&[[1.0, 1.0], [1.0, 1.0]]), 0.0);
        assert!(least_pivot(&[[f64::NAN, 0.0], [0.0, 1.0]]).is_nan());
    }
}
