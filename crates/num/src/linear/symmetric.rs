//! Eigenvalues of small symmetric matrices.

use crate::portable;

/// Sweeps over all pairs at most: convergence is quadratic, and the sizes are those of chains.
const SWEEPS: usize = 6;
/// Square of the share of the geometric mean of both diagonal elements down to which an element beside them counts: a smaller one moves
/// no eigenvalue of a positive definite matrix by more than this rounding of itself (Demmel and Veselic, SIAM J. Matrix Anal. Appl. 13, 1992).
const LEAST: f64 = f64::EPSILON * f64::EPSILON;

/// Eigenvalues of the symmetric matrix `a` and its eigenvectors as columns `v[i][m]`, orthonormal, by cyclic Jacobi rotations
/// (Golub and Van Loan, Matrix Computations, section 8.5). The order is that in which the diagonal ends.
pub fn eigen<const N: usize>(mut a: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut v = crate::array::from_fn(|i| crate::array::from_fn(|j| f64::from(u8::from(i == j))));
    for _ in 0..SWEEPS {
        let mut turned = false;
        for p in 0..N {
            for q in p + 1..N {
                turned |= rotate(&mut a, &mut v, p, q);
            }
        }
        if !turned {
            break;
        }
    }
    (crate::array::from_fn(|i| a[i][i]), v)
}

/// Turns rows and columns `p` and `q` so that `a[p][q]` vanishes; false where it is negligible.
fn rotate<const N: usize>(a: &mut [[f64; N]; N], v: &mut [[f64; N]; N], p: usize, q: usize) -> bool {
    if a[p][q] * a[p][q] <= LEAST * (a[p][p] * a[q][q]).abs() {
        return false;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let tangent = theta.signum() / (theta.abs() + portable::sqrt(theta * theta + 1.0));
    let cosine = 1.0 / portable::sqrt(tangent * tangent + 1.0);
    let sine = tangent * cosine;
    for row in a.iter_mut().chain(v.iter_mut()) {
        (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
    }
    for k in 0..N {
        (a[p][k], a[q][k]) = (cosine * a[p][k] - sine * a[q][k], sine * a[p][k] + cosine * a[q][k]);
    }
    true
}

/// Lower triangle L of the positive definite `a` = L L'; not finite where it is not.
pub fn cholesky<const N: usize>(a: &[[f64; N]; N]) -> [[f64; N]; N] {
    let mut l = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            let sum = a[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            l[i][j] = if i == j { portable::sqrt(sum) } else { sum / l[j][j] };
        }
    }
    l
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: [[f64; 4]; 4] =
        [[4.0, 1.0, -0.5, 0.2], [1.0, 3.0, 0.7, 0.0], [-0.5, 0.7, 900.0, 5.0], [0.2, 0.0, 5.0, 2.0]];

    #[test]
    fn vectors_are_orthonormal_and_make_the_matrix_diagonal() {
        let (values, v) = eigen(A);
        for m in 0..4 {
            for n in 0..4 {
                let product: f64 = (0..4).map(|i| v[i][m] * v[i][n]).sum();
                assert!((product - f64::from(u8::from(m == n))).abs() < 1e-14);
            }
            for i in 0..4 {
                let image: f64 = (0..4).map(|j| A[i][j] * v[j][m]).sum();
                assert!((image - values[m] * v[i][m]).abs() < 1e-11, "{m} {i}");
            }
        }
    }

    #[test]
    fn a_triangle_times_itself_is_the_matrix_and_one_of_no_definite_matrix_is_not_finite() {
        let l = cholesky(&A);
        for i in 0..4 {
            for j in 0..4 {
                let product: f64 = (0..4).map(|k| l[i][k] * l[j][k]).sum();
                assert!((product - A[i][j]).abs() < 1e-12);
            }
        }
        assert!(cholesky(&[[1.0, 2.0], [2.0, 1.0]])[1][1].is_nan());
    }
}
