//! Solves (s I - J) k = r for a block arrow J by the Schur complement of its border. `s` is the inverse of a time.
//!
//! With k_q = (r_q + k_q')/s every own state of an axis is a linear function of its coordinate's rate,
//! k_own = own(r) + by_rate k_q', by a 2 x 2 inverse for the spool, one for the pressures and a number for the bristles.
//! The Schur complement, a system of the rates, is left. Its matrix is inverted, so a right-hand side costs one product.
//! States that all axes share border the whole (`shared.rs`).

use crate::linear::axis::{AxisDerivatives, Row, ScalarOver, MAX_BORDER};
use crate::linear::block_arrow::BlockArrow;
use crate::linear::opening::{opening, AxisOpening, Eliminated};
use crate::linear::shared::SharedFactors;
use hydrocrane_num::{linear::small, Field};

type Square<T> = [[T; 2]; 2];

/// The factored matrix `s I - J`.
#[derive(Debug, Clone, Default)]
pub struct SchurFactors<T> {
    /// 1/s
    time: T,
    /// Inverse of the Schur complement.
    rates: [[T; MAX_BORDER]; MAX_BORDER],
    own: [Own<T>; MAX_BORDER],
    shared: SharedFactors<T>,
}

/// Factors of one axis.
#[derive(Debug, Clone, Copy, Default)]
struct Own<T> {
    /// Inverses of the diagonal blocks.
    spool: Square<T>,
    pressures: Square<T>,
    bristles: T,
    /// Derivatives of p1, p2, z, the opening and of the net force by the rate of the coordinate.
    by_rate: [T; 4],
    force_derivative: T,
    /// 1/(s - do'/do), where there is an opening.
    opening: T,
}

/// Calls a method with the size of the border as a constant.
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
            _ => $object.$method::<MAX_BORDER, _>($($argument),*),
        }
    };
}

impl<T: Field> SchurFactors<T> {
    /// Factors `shift I - J`; the mask is true where every number is finite.
    #[inline(always)]
    pub fn factor<S: Copy>(&mut self, jacobian: &BlockArrow<S>, shift: T) -> T::Mask
    where
        T: ScalarOver<S>,
    {
        sized!(jacobian.joints, self.factor_sized(jacobian, shift))
    }

    /// Replaces `r` by the solution.
    #[inline(always)]
    pub fn solve<S: Copy>(&self, jacobian: &BlockArrow<S>, r: &mut [T])
    where
        T: ScalarOver<S>,
    {
        sized!(jacobian.joints, self.solve_sized(jacobian, r));
    }

    /// [`Self::factor`] for a border of `N` coordinates.
    #[inline(always)]
    pub fn factor_sized<const N: usize, S: Copy>(&mut self, jacobian: &BlockArrow<S>, shift: T) -> T::Mask
    where
        T: ScalarOver<S>,
    {
        let sound = self.factor_arrow::<N, _>(jacobian, shift);
        let Some(shared) = jacobian.shared() else { return sound };
        let mut factors = std::mem::take(&mut self.shared);
        let left = factors.factor(
            jacobian.cylinders(),
            jacobian.openings(),
            shared,
            shift,
            #[inline(always)]
            |r| self.solve_arrow::<N, _>(jacobian, r),
        );
        self.shared = factors;
        sound & left
    }

    #[inline(always)]
    fn factor_arrow<const N: usize, S: Copy>(&mut self, jacobian: &BlockArrow<S>, shift: T) -> T::Mask
    where
        T: ScalarOver<S>,
    {
        self.time = T::c(1.0) / shift;
        let mut matrix = [[T::c(0.0); N]; N];
        for j in 0..N {
            for i in 0..N {
                matrix[j][i] = T::c(0.0) - jacobian.by_qd[j][i] - self.time * jacobian.by_q[j][i];
            }
        }
        for c in 0..N {
            let derivatives = &jacobian.cylinders[c];
            let opening = opening(jacobian.openings(), c, &derivatives.at).map(|(_, own)| own);
            let own = Own::new(derivatives, opening, shift, self.time);
            for j in 0..N {
                matrix[j][c] -= own.force_derivative * derivatives.response[j];
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

    /// [`Self::solve`] for a border of `N` coordinates.
    #[inline(always)]
    pub fn solve_sized<const N: usize, S: Copy>(&self, jacobian: &BlockArrow<S>, r: &mut [T])
    where
        T: ScalarOver<S>,
    {
        self.solve_arrow::<N, _>(jacobian, r);
        if let Some(shared) = jacobian.shared() {
            self.shared.solve(jacobian.cylinders(), jacobian.openings(), shared, r);
        }
    }

    #[inline(always)]
    fn solve_arrow<const N: usize, S: Copy>(&self, jacobian: &BlockArrow<S>, r: &mut [T])
    where
        T: ScalarOver<S>,
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
            let derivatives = &jacobian.cylinders[c];
            let force = self.own[c].solve(derivatives, opening(jacobian.openings(), c, &derivatives.at), still[c], r);
            for j in 0..N {
                driving[j] += force * derivatives.response[j];
            }
        }
        for j in 0..N {
            let mut rate = T::c(0.0);
            for i in 0..N {
                rate += self.rates[j][i] * driving[i];
            }
            r[N + j] = rate;
            r[j] = still[j] + self.time * rate;
            let (at, by_rate) = (&jacobian.cylinders[j].at, &self.own[j].by_rate);
            r[at.p1] += by_rate[0] * rate;
            r[at.p2] += by_rate[1] * rate;
            if let Some(z) = at.z {
                r[z] += by_rate[2] * rate;
            }
            if let Some((o, _)) = opening(jacobian.openings(), j, at) {
                r[o] += by_rate[3] * rate;
            }
        }
    }
}

impl<T: Field> Own<T> {
    #[inline(always)]
    fn new<S: Copy>(s: &AxisDerivatives<S>, opening: Option<&AxisOpening<S>>, shift: T, time: T) -> Self
    where
        T: ScalarOver<S>,
    {
        let zero = T::c(0.0);
        let spool =
            inverse([[shift - s.spool[0][0], zero - s.spool[0][1]], [zero - s.spool[1][0], shift - s.spool[1][1]]]);
        let mut block = [[shift - s.p1.p1, zero - s.p1.p2], [zero - s.p2.p1, shift - s.p2.p2]];
        let mut by_joint = [time * s.p1.q + s.p1.qd, time * s.p2.q + s.p2.qd];
        let opened = match opening {
            Some(own) => Some((&own.by_axis, Eliminated::new(own, shift))),
            None => None,
        };
        if let Some((row, Eliminated { on_pressures, .. })) = &opened {
            for (side, on) in on_pressures.iter().enumerate() {
                block[side][0] -= *on * row.p1;
                block[side][1] -= *on * row.p2;
                by_joint[side] += *on * (time * row.q + row.qd);
            }
        }
        let pressures = inverse(block);
        let bristles = T::c(1.0) / (shift - s.z.z);
        let [p1, p2] = product(&pressures, by_joint[0], by_joint[1]);
        let z = bristles * (time * s.z.q + s.z.qd + p1 * s.z.p1 + p2 * s.z.p2);
        let force_derivative = p1 * s.force.p1 + p2 * s.force.p2 + z * s.force.z;
        let (mut by_rate, mut opening) = ([p1, p2, z, zero], zero);
        if let Some((row, Eliminated { inverse, .. })) = opened {
            opening = inverse;
            by_rate[3] = inverse * (time * row.q + row.qd + p1 * row.p1 + p2 * row.p2);
        }
        Own { spool, pressures, bristles, by_rate, force_derivative, opening }
    }

    /// Solves for the own states with the coordinate's rate at zero and the coordinate at `still`; gives the force.
    #[inline(always)]
    fn solve<S: Copy>(
        &self,
        s: &AxisDerivatives<S>,
        opening: Option<(usize, &AxisOpening<S>)>,
        still: T,
        r: &mut [T],
    ) -> T
    where
        T: ScalarOver<S>,
    {
        let at = &s.at;
        let [xs, vs] = product(&self.spool, r[at.xs], r[at.vs]);
        let mut right = [r[at.p1] + known(&s.p1, still, xs), r[at.p2] + known(&s.p2, still, xs)];
        if let Some((o, own)) = opening {
            r[o] = self.opening * (r[o] + known(&own.by_axis, still, xs));
            right = [right[0] + r[o] * own.on_pressures[0], right[1] + r[o] * own.on_pressures[1]];
        }
        let [p1, p2] = product(&self.pressures, right[0], right[1]);
        if let Some((o, own)) = opening {
            r[o] += self.opening * (p1 * own.by_axis.p1 + p2 * own.by_axis.p2);
        }
        (r[at.xs], r[at.vs], r[at.p1], r[at.p2]) = (xs, vs, p1, p2);
        let mut force = p1 * s.force.p1 + p2 * s.force.p2;
        if let Some(z) = at.z {
            r[z] = self.bristles * (r[z] + known(&s.z, still, xs) + p1 * s.z.p1 + p2 * s.z.p2);
            force += r[z] * s.force.z;
        }
        force
    }
}

/// Change of an output by given changes of the coordinate and of the spool.
#[inline(always)]
fn known<S: Copy, T: ScalarOver<S>>(row: &Row<S>, still: T, xs: T) -> T {
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
