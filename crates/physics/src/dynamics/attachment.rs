//! Attachment of a load that lies still to the moving tip.      theory: docs/theory/dynamics/attachment.md
//!
//! M+ q'+ = M- q'-,      M+ = M- + m J^T J                           thesis (59) on both sides of the impact
//! loss = 1/2 (q'- - q'+)^T M- (q'- - q'+) + 1/2 m |J q'+|^2         Carnot: the energy of the lost velocities
//!
//! The load is a point mass at the tip as everywhere. The impact lasts no time: pressures, spools and bristles stay.
//! Letting a load go needs no law, its velocity is that of the tip.

use super::equations_of_motion::RigidChain;
use super::space::Space;
use hydrocrane_num::{linear::small, Real};

/// What follows from an attachment.
#[derive(Debug, Clone, Copy)]
pub struct Attachment<T, const N: usize> {
    /// Joint rates just after it, rad/s or m/s.
    pub rates: [T; N],
    /// Kinetic energy that became heat, J; zero or more.
    pub loss: T,
}

/// The tip of the `chain`, which moves with joint rates `qd` and carries `payload` kg, takes up `load` kg more that lie still.
pub fn attach<T: Real, C: RigidChain<T, N>, const N: usize>(
    chain: &C,
    pose: &C::Pose,
    qd: &[T; N],
    payload: T,
    load: T,
) -> Attachment<T, N> {
    let before = chain.mass_matrix(pose, payload);
    let after = chain.mass_matrix(pose, payload + load);
    let rates = small::solve_spd(&after, &momentum(&before, qd));
    let lost: [T; N] = hydrocrane_num::array::from_fn(|j| qd[j] - rates[j]);
    let of_crane = dot(&lost, &momentum(&before, &lost));
    let v = chain.tip_velocity(pose, &rates);
    Attachment { rates, loss: (of_crane + load * C::Space::dot(v, v)) * 0.5 }
}

fn momentum<T: Real, const N: usize>(mass_matrix: &[[T; N]; N], qd: &[T; N]) -> [T; N] {
    hydrocrane_num::array::from_fn(|j| dot(&mass_matrix[j], qd))
}

fn dot<T: Real, const N: usize>(a: &[T; N], b: &[T; N]) -> T {
    (0..N).fold(T::c(0.0), |sum, j| sum + a[j] * b[j])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::energy::kinetic;
    use crate::dynamics::{Body, Mechanics};
    use crate::geometry::chain::ChainPose;
    use crate::geometry::frames::Joint;
    use hydrocrane_num::Vec2;

    const PAYLOAD: f64 = 40.0;
    const QD: [f64; 3] = [0.21, -0.34, 0.17];

    /// Two turning links and a telescope, none of them alike.
    fn crane() -> Mechanics<f64, 3> {
        let joint = |at, direction, revolute: bool| {
            let sense = if revolute { 1.0 } else { 0.0 };
            Joint { at: Vec2::c(at), direction: Vec2::c(direction), offset: 0.3, zero: 0.0, sense, revolute }
        };
        let body = |mass, x, inertia| Body { mass, x, z: 0.05, inertia };
        Mechanics {
            joints: [
                joint([0.0, 0.7], [0.0, 0.0], true),
                joint([2.3, 0.1], [0.0, 0.0], true),
                joint([0.4, 0.0], [1.0, 0.0], false),
            ],
            bodies: [body(120.0, 1.1, 38.0), body(60.0, 0.5, 9.0), body(25.0, 0.6, 4.0)],
            tip: Vec2::c([1.2, -0.1]),
            gravity: Vec2::c([0.0, 9.81]),
        }
    }

    fn pose() -> ChainPose<f64, 3> {
        crane().pose(&[0.4, -1.1, 0.3])
    }

    fn attached(load: f64) -> Attachment<f64, 3> {
        attach(&crane(), &pose(), &QD, PAYLOAD, load)
    }

    #[test]
    fn the_impulse_acts_at_the_tip_and_is_what_the_load_gains() {
        let load = 150.0;
        let (m, pose) = (crane(), pose());
        let after = attached(load);
        let mass_matrix = m.equations(&pose, &QD, PAYLOAD).mass_matrix;
        let lost: [f64; 3] = hydrocrane_num::array::from_fn(|j| QD[j] - after.rates[j]);
        let gained = m.tip_velocity(&pose, &after.rates) * load;
        for (j, momentum) in momentum(&mass_matrix, &lost).into_iter().enumerate() {
            let impulse = m.column(&pose, j, m.tip_position(&pose)).dot(gained);
            assert!((momentum - impulse).abs() < 1e-12 * impulse.abs().max(1.0), "joint {j}: {momentum} {impulse}");
        }
    }

    #[test]
    fn the_loss_is_the_drop_of_kinetic_energy_and_that_of_the_relative_motion() {
        let (m, pose) = (crane(), pose());
        for load in [1.0, 100.0, 1e4] {
            let after = attached(load);
            let drop = kinetic(&m, &pose, &QD, PAYLOAD) - kinetic(&m, &pose, &after.rates, PAYLOAD + load);
            assert!(after.loss > 0.0);
            assert!((after.loss - drop).abs() < 1e-12 * kinetic(&m, &pose, &QD, PAYLOAD), "{load} kg");

            // 1/2 v^T (1/m + J M^-1 J^T)^-1 v with v the velocity of the tip past the load.
            let mass_matrix = m.equations(&pose, &QD, PAYLOAD).mass_matrix;
            let columns: [Vec2<f64>; 3] = hydrocrane_num::array::from_fn(|j| m.column(&pose, j, m.tip_position(&pose)));
            let mobility = |along: [f64; 3]| {
                let rates = small::solve_spd(&mass_matrix, &along);
                (0..3).fold(Vec2::default(), |v, j| v + columns[j] * rates[j])
            };
            let (x, z) = (mobility(columns.map(|c| c.x)), mobility(columns.map(|c| c.z)));
            let inverse_mass = [[x.x + 1.0 / load, x.z], [z.x, z.z + 1.0 / load]];
            let v = m.tip_velocity(&pose, &QD);
            let impulse = small::solve_spd(&inverse_mass, &[v.x, v.z]);
            let relative = 0.5 * (impulse[0] * v.x + impulse[1] * v.z);
            assert!((after.loss - relative).abs() < 1e-11 * relative, "{load} kg: {} {relative}", after.loss);
        }
    }

    #[test]
    fn a_light_load_changes_little_and_a_heavy_one_stops_the_tip() {
        let v = crane().tip_velocity(&pose(), &QD);
        let light = attached(1e-6);
        assert!(light.rates.iter().zip(&QD).all(|(after, before)| (after - before).abs() < 1e-7));
        assert!((light.loss - 0.5e-6 * v.dot(v)).abs() < 1e-12, "a light load is simply thrown to the tip's speed");
        let heavy = crane().tip_velocity(&pose(), &attached(1e12).rates);
        assert!(heavy.dot(heavy).sqrt() < 1e-8);
        assert!(attached(0.0).loss < 1e-25);
    }
}
