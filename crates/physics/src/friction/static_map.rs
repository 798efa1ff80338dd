//! Static friction map.                                        theory: docs/theory/friction/static_map.md
//!
//! F = sign(v) [F_C + (F_S - F_C) exp(-|v/v_sigma|^delta_sigma)] + k_v |v|^delta_v sign(v)   thesis (107)-(113)
//!
//! Departs from the source: the sign passes through zero over a stated velocity, so a solver can cross it; the
//! printed text loses the sign of the first terms (E16). [`printed`] is the program's law (E15): it adds F_S in
//! full on top of F_C, with exponent 1 and linear viscosity, and jumps at v = 0.

use super::StaticParameters;
use hydrocrane_num::{functions::smooth, Real};

/// Friction force, N; `width`: velocity over which the sign changes, m/s.
#[inline(always)]
pub fn force<T: Real>(p: &StaticParameters<T>, width: T, v: T) -> T {
    smooth::soft_sign(v, width) * p.stribeck(v) + p.viscous(v)
}

/// The program's friction force, N. Takes the extending set for both directions, as the program has one. `width`:
/// velocity over which the sign changes, m/s; without it the sign jumps, as the program's does.
#[inline(always)]
pub fn printed<T: Real>(p: &StaticParameters<T>, width: Option<T>, v: T) -> T {
    let zero = T::c(0.0);
    let fading = smooth::exp_neg(v.abs() / p.stribeck_velocity_extending);
    let rest = p.coulomb_extending + p.breakaway_extending * fading;
    let signed = match width {
        Some(width) => smooth::soft_sign(v, width) * rest,
        None => T::select(zero.lt(v), rest, T::select(v.lt(zero), -rest, zero)),
    };
    p.viscous_extending * v + signed
}

#[cfg(test)]
mod tests {
    use super::super::rottne;
    use super::*;

    #[test]
    fn static_friction_never_drives() {
        for i in -2000..=2000 {
            let v = f64::from(i) * 1e-4;
            assert!(force(&rottne(), 1e-3, v) * v >= 0.0);
            for width in [None, Some(1e-3)] {
                assert!(printed(&rottne(), width, v) * v >= 0.0);
            }
        }
    }

    #[test]
    fn limits_of_the_map() {
        let p = rottne();
        assert_eq!(force(&p, 1e-3, 0.0), 0.0);
        assert!((p.stribeck(0.0) - 340.0).abs() < 1e-9);
        assert!((force(&p, 1e-6, -0.05) + 280.0 + 12000.0 * 0.05f64.powf(1.5)).abs() < 1e-6);
    }

    #[test]
    fn printed_law_breaks_away_at_the_sum_of_both_forces() {
        let p = StaticParameters {
            coulomb_extending: 100.0,
            breakaway_extending: 750.0,
            stribeck_velocity_extending: 0.005,
            viscous_extending: 3500.0,
            ..rottne()
        };
        assert!((printed(&p, None, 1e-12) - 850.0).abs() < 1e-6);
        assert_eq!(printed(&p, None, 0.0), 0.0);
    }

    #[test]
    fn a_width_changes_the_printed_law_near_rest_alone() {
        let p = rottne();
        assert!((printed(&p, Some(1e-3), 5e-4) / printed(&p, None, 5e-4) - 0.5f64.tanh()).abs() < 0.02);
        for v in [-0.05, 0.02] {
            assert!((printed(&p, Some(1e-3), v) - printed(&p, None, v)).abs() < 1e-9);
        }
    }
}
