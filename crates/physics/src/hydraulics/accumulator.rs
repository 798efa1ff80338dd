//! Gas accumulator on the mains.                               theory: docs/theory/hydraulics/accumulator.md
//!
//! V_g = V_0 (P_0/P)^(1/n)              gas, polytropic                            Watton (2009), chapter 3
//! V_a = V_0 - V_g,  V_a' = V_g/(n P)   oil in it, and its growth with pressure
//!
//! | symbol | meaning | unit |
//! | V_0, P_0 | volume of the gas without oil, its absolute pressure then            | m^3, Pa |
//! | P        | absolute pressure of the gas: that of the mains, P_0 where they have less | Pa |
//! | n        | polytropic exponent                                                 | -  |
//!
//! Where the mains reach the precharge, P leaves P_0 along a parabola of +-p_round. Limits of validity: the gas takes each pressure
//! at once and by one exponent, so that no heat is lost between charge and discharge; no resistance of its port.

use super::mains::Mains;
use hydrocrane_num::{functions::smooth, Real};

parameters! {
    pub struct Accumulator {
        /// V_0, m^3
        volume,
        /// P_0 as gauge pressure, Pa
        precharge,
        /// n
        exponent,
    }
}

/// Of the air around, Pa.
const ATMOSPHERE: f64 = 1.013_25e5;
/// p_round, Pa
const ROUNDING: f64 = 1e5;
/// Equal parts of the range above the precharge over which energy is integrated.
const PARTS: usize = 16;
/// Abscissae and weights of Gauss's rule on five points of (-1, 1).
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

impl<T: Real> Accumulator<T> {
    /// Volume (m^3) and absolute pressure (Pa) of the gas with the mains at `p` (Pa).
    #[inline(always)]
    fn gas(&self, p: T) -> (T, T) {
        let empty = self.precharge + ATMOSPHERE;
        let pressure = empty + smooth::rounded_positive_part(p - self.precharge, ROUNDING);
        let ratio = (-((pressure / empty).ln() / self.exponent)).exp();
        (self.volume * ratio, pressure)
    }

    /// Oil in it, m^3.
    #[inline(always)]
    pub fn oil(&self, p: T) -> T {
        self.volume - self.gas(p).0
    }

    /// Growth of that with pressure, m^3/Pa.
    #[inline(always)]
    pub fn growth(&self, p: T) -> T {
        let (gas, pressure) = self.gas(p);
        let follows = ((p - self.precharge + ROUNDING) * (0.5 / ROUNDING)).clamp(T::c(0.0), T::c(1.0));
        gas / (self.exponent * pressure) * follows
    }

    /// Mains that take up, at the pressure `p` (Pa) and about it, what these `mains` and the accumulator do.
    #[inline(always)]
    pub fn with_mains(&self, mains: &Mains<T>, p: T) -> Mains<T> {
        let growth = self.growth(p);
        Mains { volume: mains.volume + self.oil(p) - growth * p, compliance: mains.compliance + growth }
    }

    /// Work that the oil has done on the gas, J: the integral of p dV_a.
    pub fn energy(&self, p: T) -> T {
        let (begins, full) = (self.precharge - ROUNDING, self.precharge + ROUNDING);
        let rounded = self.work(begins, p.clamp(begins, full));
        let beyond = p.max(full) - full;
        (0..PARTS).fold(rounded, |sum, part| {
            let at = |parts: usize| full + beyond * (parts as f64 / PARTS as f64);
            sum + self.work(at(part), at(part + 1))
        })
    }

    /// The same from one pressure to another, Pa.
    fn work(&self, from: T, to: T) -> T {
        let (middle, half) = ((from + to) * 0.5, (to - from) * 0.5);
        GAUSS.iter().fold(T::c(0.0), |sum, (at, weight)| {
            let p = middle + half * *at;
            sum + p * self.growth(p) * half * *weight
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::Dual;

    const LITRE: Accumulator<f64> = Accumulator { volume: 1e-3, precharge: 90e5, exponent: 1.4 };

    #[test]
    fn the_gas_follows_its_law_and_holds_no_oil_below_its_precharge() {
        assert_eq!([LITRE.oil(0.0), LITRE.oil(88e5), LITRE.growth(88e5)], [0.0; 3]);
        let ratio = (90e5 + ATMOSPHERE) / (180e5 + ATMOSPHERE);
        assert!((LITRE.oil(180e5) / (1e-3 * (1.0 - ratio.powf(1.0 / 1.4))) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn its_growth_is_the_slope_of_its_oil_and_its_energy_their_work() {
        for p in [80e5, 89.3e5, 90e5, 90.9e5, 91.1e5, 120e5, 300e5] {
            let lifted = LITRE.lift::<Dual<f64, 1>>();
            let at = Dual::variable(p, 0);
            let (oil, energy) = (lifted.oil(at), lifted.energy(at));
            assert!((oil.derivative[0] - LITRE.growth(p)).abs() <= 1e-12 * LITRE.growth(90e5), "{p}");
            assert!((energy.derivative[0] - p * LITRE.growth(p)).abs() < 1e-7 * p * LITRE.growth(90e5), "{p}");
        }
        // Isothermal, in closed form: p V_a less the integral of V_a dp.
        let slow = Accumulator { exponent: 1.0, ..LITRE };
        let (empty, full) = (90e5 + ATMOSPHERE, 200e5 + ATMOSPHERE);
        let exact = 1e-3 * (empty * (full / empty).ln() - ATMOSPHERE * (1.0 - empty / full));
        // The rounding of +-1 bar moves it by less.
        assert!((slow.energy(200e5) / exact - 1.0).abs() < 1e-4, "{} {exact}", slow.energy(200e5));
    }

    #[test]
    fn it_softens_the_mains_by_its_oil_and_its_growth() {
        let (mains, bulk, p) = (Mains { volume: 0.4e-3, compliance: 4e-13 }, 1.2e9, 150e5);
        let together = LITRE.with_mains(&mains, p).stiffness(bulk, p);
        let capacity = (mains.volume + mains.compliance * p + LITRE.oil(p)) / bulk + mains.compliance + LITRE.growth(p);
        assert!((together * capacity - 1.0).abs() < 1e-12);
        assert!(
            (LITRE.with_mains(&mains, 50e5).stiffness(bulk, 50e5) / mains.stiffness(bulk, 50e5) - 1.0).abs() < 1e-12
        );
    }
}
