//! Rosenbrock methods as data.   theory: docs/theory/integration.md

/// The coefficients of a method with `S` stages. With W = I/(h gamma) - J, stage i solves
///     W k_i = f(x + sum_j a_ij k_j) + sum_j C_ij/h k_j
/// and x_new = x + sum_j m_j k_j, error sum_j e_j k_j. What is left out of a row is zero.
pub struct Tableau<const S: usize> {
    pub gamma: f64,
    pub a: [&'static [f64]; S],
    /// How the argument of each stage follows: [`arguments`] of `a`.
    pub arguments: [Argument; S],
    pub c: [&'static [f64]; S],
    /// m
    pub weights: [f64; S],
    /// e
    pub error: [f64; S],
}

/// The argument x + sum_j a_ij k_j of a stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Argument {
    /// The start of the step.
    Start,
    /// Summed up.
    Sum,
    /// That of the stage before and its increment.
    Continued,
    /// That of the stage before, which has evaluated f there.
    Same,
}

/// How the argument of each stage follows from the rows of `a`.
pub const fn arguments<const S: usize>(a: [&[f64]; S]) -> [Argument; S] {
    let mut found = [Argument::Start; S];
    let mut i = 1;
    while i < S {
        let (before, own) = (a[i - 1], a[i]);
        let (mut equal, mut j) = (own.len() >= before.len(), 0);
        while equal && j < before.len() {
            equal = own[j] == before[j];
            j += 1;
        }
        let continued = equal && own.len() == i && before.len() + 1 == i && own[i - 1] == 1.0;
        found[i] = if continued {
            Argument::Continued
        } else if equal && own.len() == before.len() {
            Argument::Same
        } else {
            Argument::Sum
        };
        i += 1;
    }
    found
}

#[cfg(test)]
impl<const S: usize> Tableau<S> {
    /// The method in the form of its order conditions, k_i = h f(x + sum alpha_ij k_j) + h J sum gamma_ij k_j: the
    /// matrices alpha and gamma, and weights b from those of the increments u = gamma k.
    fn untransformed(&self, weights: [f64; S]) -> ([[f64; S]; S], [[f64; S]; S], [f64; S]) {
        let entry = |row: &[f64], j: usize| row.get(j).copied().unwrap_or(0.0);
        // I/gamma - C is the inverse of the matrix gamma, both lower triangular.
        let mut gamma = [[0.0; S]; S];
        for column in 0..S {
            for row in column..S {
                let unit = f64::from(u8::from(row == column));
                let sum = (column..row).map(|j| entry(self.c[row], j) * gamma[j][column]).sum::<f64>();
                gamma[row][column] = self.gamma * (unit + sum);
            }
        }
        let times =
            |left: &[f64]| hydrocrane_num::array::from_fn(|j| (0..S).map(|i| entry(left, i) * gamma[i][j]).sum());
        (self.a.map(times), gamma, times(&weights))
    }

    /// Residuals of the conditions of order three, and of the remaining ones of order four, for the weights `m`.
    pub fn missed(&self, m: [f64; S]) -> ([f64; 4], [f64; 4]) {
        let (alpha, gamma, b) = self.untransformed(m);
        let both: [[f64; S]; S] =
            hydrocrane_num::array::from_fn(|i| hydrocrane_num::array::from_fn(|j| alpha[i][j] + gamma[i][j]));
        let (a, beta) = (row_sums(&alpha), row_sums(&both));
        let sum = |v: [f64; S]| (0..S).map(|i| b[i] * v[i]).sum::<f64>();
        let squares = a.map(|a| a * a);
        let inner = applied(&alpha, beta);
        (
            [
                sum([1.0; S]) - 1.0,
                sum(beta) - 1.0 / 2.0,
                sum(squares) - 1.0 / 3.0,
                sum(applied(&both, beta)) - 1.0 / 6.0,
            ],
            [
                sum(a.map(|a| a.powi(3))) - 1.0 / 4.0,
                sum(hydrocrane_num::array::from_fn(|i| a[i] * inner[i])) - 1.0 / 8.0,
                sum(applied(&both, squares)) - 1.0 / 12.0,
                sum(applied(&both, applied(&both, beta))) - 1.0 / 24.0,
            ],
        )
    }

    /// For equations that depend on time: where in the step each stage evaluates them, and its weight of h df/dt.
    pub fn times(&self) -> ([f64; S], [f64; S]) {
        let (alpha, gamma, _) = self.untransformed(self.weights);
        (row_sums(&alpha), row_sums(&gamma))
    }
}

#[cfg(test)]
fn applied<const S: usize>(m: &[[f64; S]; S], v: [f64; S]) -> [f64; S] {
    m.map(|row| row.iter().zip(v).map(|(m, v)| m * v).sum())
}

#[cfg(test)]
fn row_sums<const S: usize>(m: &[[f64; S]; S]) -> [f64; S] {
    applied(m, [1.0; S])
}
