//! The Jacobian of a chain that hydraulic axes move, stored as its nonzero blocks: a block arrow.
//!
//! The border is formed by the coordinates q and their rates. Each axis has states of its own, which depend on each other and
//! on the axis's coordinate, but not on another axis. With f_c the force of axis c and m_c the accelerations by that force:
//! ```text
//! q''        by all q, all q', and m_c times the derivatives of f_c by p1, p2, z
//! xs', vs'   by xs, vs
//! p1', p2'   by q_c, q_c', p1, p2, xs
//! z'         by q_c, q_c', p1, p2, z
//! ```
//! An axis may have a further state that acts on its pressures (`opening.rs`).
//! (s I - J) k = r is therefore solved axis by axis: spool, pressures, bristles, each as a linear function of the rate of its
//! coordinate. Coordinates follow from their rates. The Schur complement, a system of the rates, is left (`schur.rs`).

use crate::linear::axis::{AxisDerivatives, AxisStates, Row, ScalarOver, MAX_BORDER};
use crate::linear::opening::{opening, AxisOpening};
use crate::linear::shared::{SharedDerivatives, SharedStates};
use hydrocrane_num::Real;

/// Which states belong to which axis, and which to all of them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct StateBlocks {
    pub axes: Vec<AxisStates>,
    pub shared: SharedStates,
}

/// The force of an axis with the change of the accelerations by it along a direction.
#[derive(Debug, Clone, Copy, Default)]
pub struct ForceAlong<T> {
    pub force: Row<T>,
    pub response: [T; MAX_BORDER],
}

/// df/dx in blocks.
#[derive(Debug, Clone)]
pub struct BlockArrow<T> {
    pub joints: usize,
    /// Static friction enters by its secant F/v instead of its tangent. Fixed steps need this where friction changes its sign
    /// within a step. The derivatives are then not exact.
    pub secants: bool,
    /// Derivatives of the accelerations by coordinates and by rates, `[row][column]`, including those by way of the forces.
    pub by_q: [[T; MAX_BORDER]; MAX_BORDER],
    pub by_qd: [[T; MAX_BORDER]; MAX_BORDER],
    pub cylinders: [AxisDerivatives<T>; MAX_BORDER],
    /// Of a derivative of the matrix along a direction: see [`BlockArrow::along`].
    pub along: Option<Box<[ForceAlong<T>; MAX_BORDER]>>,
    /// `None` where no axis has an opening.
    pub openings: Option<Box<[AxisOpening<T>; MAX_BORDER]>>,
    /// `None` without shared states.
    pub shared: Option<Box<SharedDerivatives<T>>>,
}

impl<T: Copy> BlockArrow<T> {
    #[inline(always)]
    pub(crate) fn cylinders(&self) -> &[AxisDerivatives<T>] {
        &self.cylinders[..self.joints]
    }

    /// Derivatives that belong to shared states; left out of programs for the smallest chains alone.
    #[inline(always)]
    pub(crate) fn shared(&self) -> Option<&SharedDerivatives<T>> {
        if cfg!(feature = "chains") {
            self.shared.as_deref()
        } else {
            None
        }
    }

    /// Derivatives of and by openings, likewise.
    #[inline(always)]
    pub(crate) fn openings(&self) -> Option<&[AxisOpening<T>]> {
        if cfg!(feature = "chains") {
            self.openings.as_ref().map(|openings| &openings[..self.joints])
        } else {
            None
        }
    }

    /// Index of the first shared state, their number, and that of the acting ones.
    #[inline(always)]
    fn shared_at(&self) -> [usize; 3] {
        let SharedStates { first, count, acting } = self.shared().map_or(SharedStates::default(), |shared| shared.at);
        [first, count, acting]
    }
}

impl<T: Real> BlockArrow<T> {
    /// All zero, one axis per coordinate of the border.
    pub fn new(blocks: &StateBlocks) -> Self {
        let joints = blocks.axes.len();
        let mut cylinders = [AxisDerivatives::default(); MAX_BORDER];
        cylinders.iter_mut().zip(&blocks.axes).for_each(|(own, at)| own.at = *at);
        let square = [[T::c(0.0); MAX_BORDER]; MAX_BORDER];
        let shared = (blocks.shared.count > 0).then(|| Box::new(SharedDerivatives::new(blocks.shared)));
        let opens = blocks.axes.iter().any(|at| at.opening.is_some());
        let openings = opens.then(|| Box::new([AxisOpening::default(); MAX_BORDER]));
        BlockArrow { joints, secants: false, by_q: square, by_qd: square, cylinders, along: None, openings, shared }
    }

    /// The same blocks with `f` applied to every derivative.
    pub fn map<U: Real>(&self, f: impl Fn(T) -> U) -> BlockArrow<U> {
        BlockArrow {
            joints: self.joints,
            secants: self.secants,
            by_q: self.by_q.map(|row| row.map(&f)),
            by_qd: self.by_qd.map(|row| row.map(&f)),
            cylinders: self.cylinders.map(|c| AxisDerivatives {
                at: c.at,
                p1: c.p1.map(&f),
                p2: c.p2.map(&f),
                z: c.z.map(&f),
                spool: c.spool.map(|row| row.map(&f)),
                force: c.force.map(&f),
                response: c.response.map(&f),
            }),
            along: None,
            openings: self.openings.as_ref().map(|openings| Box::new(openings.map(|own| own.map(&f)))),
            shared: self.shared.as_ref().map(|shared| Box::new(shared.map(&f))),
        }
    }

    /// The derivative of this matrix along a direction, for products with it, from the `value` of each number and its `derivative`
    /// along the direction. Accelerations by an axis's states are the products m f: both factors change, (m f)' = m f' + m' f.
    pub fn along<U: Real>(&self, value: impl Fn(T) -> U, derivative: impl Fn(T) -> U) -> BlockArrow<U> {
        let mut matrix = self.map(&derivative);
        for (of, own) in matrix.cylinders.iter_mut().zip(&self.cylinders) {
            of.response = own.response.map(&value);
        }
        matrix.along = Some(Box::new(
            self.cylinders
                .map(|own| ForceAlong { force: own.force.map(&value), response: own.response.map(&derivative) }),
        ));
        matrix
    }

    /// y += J k without the rows of the coordinates, whose derivative is the rate itself.
    #[inline(always)]
    pub fn add_product<K: ScalarOver<T>>(&self, k: &[K], y: &mut [K]) {
        let n = self.joints;
        for j in 0..n {
            for i in 0..n {
                y[n + j] += k[i] * self.by_q[j][i] + k[n + i] * self.by_qd[j][i];
            }
        }
        for (c, own) in self.cylinders().iter().enumerate() {
            let at = &own.at;
            let local = Row::local(n, c, at, k);
            let force = local.p1 * own.force.p1 + local.p2 * own.force.p2 + local.z * own.force.z;
            for j in 0..n {
                y[n + j] += force * own.response[j];
            }
            if let Some(ForceAlong { force: f, response }) = self.along.as_ref().map(|along| &along[c]) {
                let force = local.p1 * f.p1 + local.p2 * f.p2 + local.z * f.z;
                for j in 0..n {
                    y[n + j] += force * response[j];
                }
            }
            y[at.p1] += own.p1.directional(&local);
            y[at.p2] += own.p2.directional(&local);
            if let Some(z) = at.z {
                y[z] += own.z.directional(&local);
            }
            if let Some((o, own)) = opening(self.openings(), c, at) {
                own.add_product((o, at), &local, self.shared_at(), k, y);
            }
            let (xs, vs) = (k[at.xs], k[at.vs]);
            y[at.xs] += xs * own.spool[0][0] + vs * own.spool[0][1];
            y[at.vs] += xs * own.spool[1][0] + vs * own.spool[1][1];
        }
        if let Some(shared) = self.shared() {
            shared.add_product(self.cylinders(), k, y);
        }
    }

    /// Row-major, `n x n` for the `n` states.
    pub fn write_dense(&self, n: usize, jacobian: &mut [T]) {
        jacobian.fill(T::c(0.0));
        let joints = self.joints;
        for j in 0..joints {
            jacobian[j * n + joints + j] = T::c(1.0);
            let row = &mut jacobian[(joints + j) * n..][..n];
            row[..joints].copy_from_slice(&self.by_q[j][..joints]);
            row[joints..2 * joints].copy_from_slice(&self.by_qd[j][..joints]);
            for own in self.cylinders() {
                let (at, force) = (&own.at, &own.force);
                for (column, derivative) in [(Some(at.p1), force.p1), (Some(at.p2), force.p2), (at.z, force.z)] {
                    if let Some(column) = column {
                        row[column] = own.response[j] * derivative;
                    }
                }
            }
        }
        for (c, own) in self.cylinders().iter().enumerate() {
            let at = &own.at;
            for (row, derivatives) in [(Some(at.p1), &own.p1), (Some(at.p2), &own.p2), (at.z, &own.z)] {
                if let Some(row) = row {
                    derivatives.write(joints, c, at, &mut jacobian[row * n..][..n]);
                }
            }
            for (row, derivatives) in [(at.xs, own.spool[0]), (at.vs, own.spool[1])] {
                jacobian[row * n + at.xs] = derivatives[0];
                jacobian[row * n + at.vs] = derivatives[1];
            }
        }
        if let Some(shared) = self.shared() {
            shared.write_dense(self.cylinders(), n, jacobian);
        }
        for (c, own) in self.cylinders().iter().enumerate() {
            if let Some((o, derivatives)) = opening(self.openings(), c, &own.at) {
                derivatives.write_dense(o, c, self.cylinders(), self.shared_at(), n, jacobian);
            }
        }
    }
}
