//! LuGre friction.                                                theory: docs/theory/friction/lugre.md
//!
//! z' = v - sigma_0 |v| z / g(v)                                                          thesis (116)
//! F  = sigma_0 z + sigma_1(v) z' + k_v |v|^delta_v sign(v)                               thesis (115)
//! sigma_1(v) = sigma_1 exp(-(v/v_d)^2)
//!
//! | symbol  | meaning | unit |
//! | z       | mean bristle deflection                      | m     |
//! | sigma_0 | bristle stiffness                            | N/m   |
//! | sigma_1 | bristle damping                              | N s/m |
//! | v_d     | velocity over which the damping fades; infinite: constant | m/s |
//!
//! Friction is passive with the storage sigma_0 z^2/2 at the velocity v if
//!     sigma_1(v)^2 |v| <= 4 g(v) (sigma_1(v) + F_v(v)/v),
//! which a constant sigma_1 breaks at some speed and a fading one need not. Departs from the source: viscous
//! friction keeps its exponent; the printed sigma_1 are negative (E19) and not usable. Seals without break-away force
//! have no bristles: F = F_v and z fades. A g below 1 mN counts as 1 mN.

use super::StaticParameters;
use hydrocrane_num::{functions::smooth, Real};

/// Least g, N: it bounds the rate at which the bristles relax, sigma_0 |v|/g.
const LEAST_FORCE: f64 = 1e-3;
/// Rate at which a deflection fades that was left when the friction was taken away, 1/s.
const FADING_RATE: f64 = 100.0;

parameters! {
    pub struct LuGre {
        /// sigma_0, N/m
        stiffness,
        /// sigma_1 at rest, N s/m
        damping,
        /// 1/v_d^2, s^2/m^2; zero: constant damping.
        fading,
    }
}

/// Friction at one state.
#[derive(Debug, Clone, Copy)]
pub struct Friction<T> {
    /// N, against positive velocity
    pub force: T,
    /// z', m/s
    pub deflection_rate: T,
}

impl<T: Real> LuGre<T> {
    #[inline(always)]
    pub fn evaluate(&self, p: &StaticParameters<T>, v: T, z: T) -> Friction<T> {
        let zero = T::c(0.0);
        let held = zero.lt(p.breakaway_extending + p.breakaway_retracting);
        let g = p.stribeck(v).max(T::c(LEAST_FORCE));
        let deflection_rate = T::select(held, v - self.stiffness * v.abs() / g * z, -z * FADING_RATE);
        let bristles = T::select(held, self.stiffness * z + self.damping_at(v) * deflection_rate, zero);
        Friction { force: bristles + p.viscous(v), deflection_rate }
    }

    /// sigma_1(v), N s/m
    #[inline(always)]
    pub fn damping_at(&self, v: T) -> T {
        self.damping * smooth::exp_neg(v * v * self.fading)
    }

    /// Energy stored in the bristles, J.
    pub fn energy(&self, z: T) -> T {
        self.stiffness * z.square() * 0.5
    }
}

impl LuGre<f64> {
    /// 4 g (sigma_1 + F_v/v) - sigma_1^2 |v|: friction is passive at velocity `v` where this is not negative.
    pub fn passivity_margin(&self, p: &StaticParameters<f64>, v: f64) -> f64 {
        let held = p.breakaway_extending + p.breakaway_retracting > 0.0;
        let sigma_1 = if held { self.damping_at(v) } else { 0.0 };
        let viscous = if v == 0.0 { 0.0 } else { p.viscous(v) / v };
        4.0 * p.stribeck(v).max(LEAST_FORCE) * (sigma_1 + viscous) - sigma_1 * sigma_1 * v.abs()
    }

    /// The lowest speed, up to `fastest`, at which passivity fails in either direction; `None`: it holds.
    pub fn passivity_limit(&self, p: &StaticParameters<f64>, fastest: f64) -> Option<f64> {
        const SAMPLES: usize = 4000;
        (1..=SAMPLES)
            .map(|i| fastest * i as f64 / SAMPLES as f64)
            .find(|&v| self.passivity_margin(p, v).min(self.passivity_margin(p, -v)) < 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::rottne;
    use super::*;
    use hydrocrane_num::{Dual, Field};

    /// Without Coulomb and break-away force.
    fn frictionless() -> StaticParameters<f64> {
        StaticParameters {
            coulomb_extending: 0.0,
            coulomb_retracting: 0.0,
            breakaway_extending: 0.0,
            breakaway_retracting: 0.0,
            ..rottne()
        }
    }

    #[test]
    fn without_break_away_force_viscous_friction_remains() {
        let lugre = LuGre { stiffness: 1.1e5, damping: 1500.0, fading: 100.0 };
        let lift = |x: f64| Dual::<f64, 2>::c(x);
        let (dual, map) = (lugre.map(&mut |x| lift(*x)), frictionless().map(&mut |x| lift(*x)));
        for v in [-0.3, -1e-9, -0.0, 0.0, 1e-300, 0.02] {
            for z in [-1e-3, 0.0, 2e-4] {
                let f = lugre.evaluate(&frictionless(), v, z);
                assert_eq!(f.force, rottne().viscous(v));
                assert_eq!(f.deflection_rate, -100.0 * z);
                assert_eq!(lugre.passivity_margin(&frictionless(), v).min(0.0), 0.0);
                let d = dual.evaluate(&map, Dual::variable(v, 0), Dual::variable(z, 1));
                let slopes = d.force.derivative.into_iter().chain(d.deflection_rate.derivative);
                assert!(slopes.into_iter().all(f64::is_finite), "v = {v}, z = {z}");
            }
        }
    }

    #[test]
    fn a_stribeck_curve_that_ends_at_zero_leaves_finite_slopes() {
        let map = StaticParameters { coulomb_extending: 0.0, coulomb_retracting: 0.0, ..rottne() };
        let lift = |x: f64| Dual::<f64, 2>::c(x);
        let lugre = LuGre { stiffness: 1.1e5, damping: 1500.0, fading: 100.0 }.map(&mut |x| lift(*x));
        for v in [-3.0, -0.1, 0.0, 0.1, 3.0] {
            let f = lugre.evaluate(&map.map(&mut |x| lift(*x)), Dual::variable(v, 0), Dual::variable(1e-9, 1));
            for number in [f.force, f.deflection_rate] {
                assert!(number.value.is_finite() && number.derivative.iter().all(|d| d.abs() < 1e12), "v = {v}: {f:?}");
            }
        }
    }

    #[test]
    fn steady_state_is_the_static_map() {
        let lugre = LuGre { stiffness: 1.1e5, damping: 1500.0, fading: 100.0 };
        for v in [-0.08f64, -0.001, 0.0005, 0.02] {
            let z = rottne().stribeck(v) * v.signum() / 1.1e5;
            let f = lugre.evaluate(&rottne(), v, z);
            assert!(f.deflection_rate.abs() < 1e-15);
            assert!((f.force - v.signum() * rottne().stribeck(v) - rottne().viscous(v)).abs() < 1e-9);
        }
    }

    #[test]
    fn passivity_condition_is_the_sign_of_the_dissipation() {
        // Dissipation is a quadratic form in (z, v); its smallest value over z is negative iff the margin is.
        let lugre = LuGre { stiffness: 1.1e5, damping: 5000.0, fading: 0.0 };
        for v in [0.01f64, 0.1, 0.2, 0.5, 1.0, 3.0] {
            let margin = lugre.passivity_margin(&rottne(), v);
            let dissipation = |z: f64| {
                let f = lugre.evaluate(&rottne(), v, z);
                f.force * v - 1.1e5 * z * f.deflection_rate
            };
            let least = (-4000..4000).map(|i| dissipation(f64::from(i) * 1e-5)).fold(f64::MAX, f64::min);
            assert_eq!(least < 0.0, margin < 0.0, "v = {v}: least {least}, margin {margin}");
        }
    }

    #[test]
    fn constant_damping_loses_passivity_at_speed_and_fading_damping_keeps_it() {
        let constant = LuGre { stiffness: 1.1e5, damping: 5000.0, fading: 0.0 };
        let limit = constant.passivity_limit(&rottne(), 2.0).expect("constant damping is not passive at 2 m/s");
        assert!(
            constant.passivity_margin(&rottne(), limit) < 0.0 || constant.passivity_margin(&rottne(), -limit) < 0.0
        );
        assert_eq!(LuGre { fading: 100.0, ..constant }.passivity_limit(&rottne(), 2.0), None);
    }
}
