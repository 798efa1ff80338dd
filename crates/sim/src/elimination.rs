//! (s I - J) k = r for the Jacobian of a crane, cylinder by cylinder. `s` is the inverse of a time.
//!
//! With k_q = (r_q + k_q')/s every own state of a cylinder is a linear function of its joint's rate,
//! k_own = own(r) + slope k_q', by a 2 x 2 inverse for the spool, one for the pressures and a number for the bristles.
//! What is left is a system of the joint rates, whose matrix is inverted: one product per right-hand side.

use crate::bordered::{Bordered, CylinderSlopes, Row};
use crate::model::MAX_JOINTS;
use hydrocrane_num::{small, Field};
use std::ops::{Add, Mul, Sub};

type Square<T> = [[T; 2]; 2];

/// The factored matrix `s I - J`.
#[derive(Debug, Clone, Default)]
pub struct Elimination<T> {
    /// 1/s
    time: T,
    /// Of the system of the joint rates.
    rates: [[T; MAX_JOINTS]; MAX_JOINTS],
    own: [Own<T>; MAX_JOINTS],
}

/// One cylinder, eliminated.
#[derive(Debug, Clone, Copy, Default)]
struct Own<T> {
    /// Inverses of the diagonal blocks.
    spool: Square<T>,
    pressures: Square<T>,
    bristles: T,
    /// Change of p1, p2, z and of the net force with the joint's rate.
    slope: [T; 3],
    force_slope: T,
}

/// Numbers that can be reckoned with slopes of type `S`.
pub trait Over<S>: Field + Add<S, Output = Self> + Sub<S, Output = Self> + Mul<S, Output = Self> {}

impl<S, T: Field + Add<S, Output = T> + Sub<S, Output = T> + Mul<S, Output = T>> Over<S> for T {}

/// Calls a method with the number of joints as a constant.
macro_rules! sized {
    ($joints:expr, $object:ident.$method:ident($($argument:expr),*)) => {
        match $joints {
            1 => $object.$method::<1, _>($($argument),*),
            #[cfg(feature = "chains")]
            2 => $object.$method::<2, _>($($argument),*),
            #[cfg(feature = "chains")]
            3 => $object.$method::<3, _>($($argument),*),
            #[cfg(feature = "chains")]
            4 => $object.$method::<4, _>($($argument),*),
            #[cfg(feature = "chains")]
            5 => $object.$method::<5, _>($($argument),*),
            _ => $object.$method::<MAX_JOINTS, _>($($argument),*),
        }
    };
}

impl<T: Field> Elimination<T> {
    /// Factors `shift I - J`; the mask tells where every number came out finite.
    #[inline(always)]
    pub fn factor<S: Copy>(&mut self, jacobian: &Bordered<S>, shift: T) -> T::Mask
    where
        T: Over<S>,
    {
        sized!(jacobian.joints, self.factor_sized(jacobian, shift))
    }

    /// Replaces `r` by the solution.
    #[inline(always)]
    pub fn solve<S: Copy>(&self, jacobian: &Bordered<S>, r: &mut [T])
    where
        T: Over<S>,
    {
        sized!(jacobian.joints, self.solve_sized(jacobian, r));
    }

    /// [`Self::factor`] of a chain of `N` joints.
    #[inline(always)]
    pub fn factor_sized<const N: usize, S: Copy>(&mut self, jacobian: &Bordered<S>, shift: T) -> T::Mask
    where
        T: Over<S>,
    {
        self.time = T::c(1.0) / shift;
        let mut matrix = [[T::c(0.0); N]; N];
        for j in 0..N {
            for i in 0..N {
                matrix[j][i] = T::c(0.0) - jacobian.by_qd[j][i] - self.time * jacobian.by_q[j][i];
            }
        }
        for c in 0..N {
            let slopes = &jacobian.cylinders[c];
            let own = Own::new(slopes, shift, self.time);
            for j in 0..N {
                matrix[j][c] -= own.force_slope * slopes.response[j];
            }
            matrix[c][c] += shift;
            self.own[c] = own;
        }
        let inverse = small::inverse(matrix);
        let mut sound = T::c(0.0).finite();
        for j in 0..N {
            for i in 0..N {
                self.rates[j][i] = inverse[j][i];
                sound = sound & inverse[j][i].finite();
            }
        }
        sound
    }

    /// [`Self::solve`] for a chain of `N` joints.
    #[inline(always)]
    pub fn solve_sized<const N: usize, S: Copy>(&self, jacobian: &Bordered<S>, r: &mut [T])
    where
        T: Over<S>,
    {
        // Positions as far as they are known without the rates.
        let (mut still, mut driving) = ([T::c(0.0); N], [T::c(0.0); N]);
        for j in 0..N {
            still[j] = r[j] * self.time;
        }
        for j in 0..N {
            driving[j] = r[N + j];
            for i in 0..N {
                driving[j] += still[i] * jacobian.by_q[j][i];
            }
        }
        for c in 0..N {
            let slopes = &jacobian.cylinders[c];
            let force = self.own[c].solve(slopes, still[c], r);
            for j in 0..N {
                driving[j] += force * slopes.response[j];
            }
        }
        for j in 0..N {
            let mut rate = T::c(0.0);
            for i in 0..N {
                rate += self.rates[j][i] * driving[i];
            }
            r[N + j] = rate;
            r[j] = still[j] + self.time * rate;
            let (at, slope) = (&jacobian.cylinders[j].at, &self.own[j].slope);
            r[at.p1] += slope[0] * rate;
            r[at.p2] += slope[1] * rate;
            if let Some(z) = at.z {
                r[z] += slope[2] * rate;
            }
        }
    }
}

impl<T: Field> Own<T> {
    #[inline(always)]
    fn new<S: Copy>(s: &CylinderSlopes<S>, shift: T, time: T) -> Self
    where
        T: Over<S>,
    {
        let zero = T::c(0.0);
        let spool =
            inverse([[shift - s.spool[0][0], zero - s.spool[0][1]], [zero - s.spool[1][0], shift - s.spool[1][1]]]);
        let pressures = inverse([[shift - s.p1.p1, zero - s.p1.p2], [zero - s.p2.p1, shift - s.p2.p2]]);
        let bristles = T::c(1.0) / (shift - s.z.z);
        let [p1, p2] = product(&pressures, time * s.p1.q + s.p1.qd, time * s.p2.q + s.p2.qd);
        let z = bristles * (time * s.z.q + s.z.qd + p1 * s.z.p1 + p2 * s.z.p2);
        let force_slope = p1 * s.force.p1 + p2 * s.force.p2 + z * s.force.z;
        Own { spool, pressures, bristles, slope: [p1, p2, z], force_slope }
    }

    /// Solves for the own states with the joint's rate at zero and its position at `still`; gives the net force.
    #[inline(always)]
    fn solve<S: Copy>(&self, s: &CylinderSlopes<S>, still: T, r: &mut [T]) -> T
    where
        T: Over<S>,
    {
        let at = &s.at;
        let [xs, vs] = product(&self.spool, r[at.xs], r[at.vs]);
        let [p1, p2] = product(&self.pressures, r[at.p1] + known(&s.p1, still, xs), r[at.p2] + known(&s.p2, still, xs));
        (r[at.xs], r[at.vs], r[at.p1], r[at.p2]) = (xs, vs, p1, p2);
        let mut force = p1 * s.force.p1 + p2 * s.force.p2;
        if let Some(z) = at.z {
            r[z] = self.bristles * (r[z] + known(&s.z, still, xs) + p1 * s.z.p1 + p2 * s.z.p2);
            force += r[z] * s.force.z;
        }
        force
    }
}

/// What an output sees of a joint's position and of the spool.
#[inline(always)]
fn known<S: Copy, T: Over<S>>(row: &Row<S>, still: T, xs: T) -> T {
    still * row.q + xs * row.xs
}

#[inline(always)]
fn inverse<T: Field>(m: Square<T>) -> Square<T> {
    let inverse = T::c(1.0) / (m[0][0] * m[1][1] - m[0][1] * m[1][0]);
    [[m[1][1] * inverse, -m[0][1] * inverse], [-m[1][0] * inverse, m[0][0] * inverse]]
}

#[inline(always)]
fn product<T: Field>(m: &Square<T>, a: T, b: T) -> [T; 2] {
    [m[0][0] * a + m[0][1] * b, m[1][0] * a + m[1][1] * b]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{build, EquilibriumMode, Model};
    use hydrocrane_machine::{load, OverrideValue};
    use std::sync::Arc;

    /// Chains of one and three joints, with and without bristles, regenerative valves, cylinders on four-bars.
    fn models() -> Vec<Arc<dyn Model>> {
        let without_bristles = [("friction.lift.model".to_string(), OverrideValue::Text("static".to_string()))];
        let mut machines: Vec<_> =
            ["rottne-f9-lab", "hiab-xs031", "single-cylinder"].map(|name| load(name, &[])).into_iter().collect();
        machines.push(load("rottne-f9-lab", &without_bristles));
        machines.into_iter().map(|m| build(&m.expect("a bundled machine")).expect("it can be built")).collect()
    }

    /// Slopes at a moving state far from rest.
    fn slopes(model: &dyn Model) -> (Bordered<f64>, usize) {
        let q: Vec<f64> = model.joint_limits().iter().map(|l| 0.6 * l.lower + 0.4 * l.upper).collect();
        let mut x = model.equilibrium(&q, EquilibriumMode::Hold, 50.0).expect("a pose inside the limits");
        let n = x.len();
        for (i, scale) in model.layout().scales.iter().enumerate().skip(q.len()) {
            x[i] += 0.4 * scale * (1.0 + i as f64).sin();
        }
        let mut slopes = Bordered::new(model.layout());
        let u = vec![0.01; q.len()];
        model.linearise(&x, &u, 50.0, &mut vec![0.0; n], &mut slopes);
        (slopes, n)
    }

    #[test]
    fn the_solution_satisfies_every_row_of_the_dense_system() {
        for model in models() {
            let (slopes, n) = slopes(model.as_ref());
            let mut jacobian = vec![0.0; n * n];
            slopes.write_dense(n, &mut jacobian);
            for shift in [1.0, 1e2, 1e4, 1e7] {
                let mut elimination = Elimination::default();
                assert!(elimination.factor(&slopes, shift));
                for unit in 0..n {
                    let right = |i: usize| if i == unit { model.layout().scales[i] } else { 0.0 };
                    let mut k: Vec<f64> = (0..n).map(right).collect();
                    elimination.solve(&slopes, &mut k);
                    for i in 0..n {
                        let terms = (0..n).map(|j| -jacobian[i * n + j] * k[j]).chain([shift * k[i], -right(i)]);
                        let (sum, size) =
                            terms.fold((0.0, 0.0f64), |(sum, size), term| (sum + term, size + term.abs()));
                        assert!(sum.abs() <= 1e-12 * size, "shift {shift}, unit {unit}, row {i}: {sum} of {size}");
                    }
                }
            }
        }
    }

    #[test]
    fn products_are_those_of_the_dense_matrix() {
        for model in models() {
            let (slopes, n) = slopes(model.as_ref());
            let mut jacobian = vec![0.0; n * n];
            slopes.write_dense(n, &mut jacobian);
            let k: Vec<f64> = (0..n).map(|i| model.layout().scales[i] * (2.0 * i as f64).cos()).collect();
            let mut product = vec![0.0; n];
            slopes.add_product(&k, &mut product);
            // The product leaves out q' = q'.
            for i in slopes.joints..n {
                let terms = (0..n).map(|j| jacobian[i * n + j] * k[j]);
                let (sum, size) = terms.fold((0.0, 0.0f64), |(sum, size), term| (sum + term, size + term.abs()));
                assert!((product[i] - sum).abs() <= 1e-13 * size, "{i}");
            }
            assert!(product[..slopes.joints].iter().all(|v| *v == 0.0));
        }
    }

    #[test]
    fn a_matrix_that_cannot_be_solved_is_refused() {
        let model = &models()[0];
        let (mut slopes, _) = slopes(model.as_ref());
        slopes.by_q[0][0] = f64::NAN;
        assert!(!Elimination::default().factor(&slopes, 1e3));
    }
}
