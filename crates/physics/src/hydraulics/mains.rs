//! The mains: oil and hoses between pump and valves.           theory: docs/theory/hydraulics/mains.md
//!
//! V = V_0 + C p                     the hoses widen                                       Watton (2009), chapter 3
//! p' = q / (V/E(p) + C)             from d(rho V)/dt = rho q and d rho/rho = dp/E
//! U = V w(p) + C p^2/2              energy in the oil and in the walls
//!
//! | symbol | meaning | unit |
//! | V_0, C | volume without pressure, its growth with pressure | m^3, m^3/Pa |
//! | q      | sum of the flows into the mains                   | m^3/s       |
//! | w      | elastic energy of the oil per volume              | J/m^3       |
//!
//! Limits of validity: one pressure everywhere (lines short against a quarter of a wave), walls that give way at once.

use hydrocrane_num::Real;

parameters! {
    pub struct Mains {
        /// V_0, m^3
        volume,
        /// C, m^3/Pa
        compliance,
    }
}

impl<T: Real> Mains<T> {
    /// Rise of the pressure per volume that flows in, Pa/m^3, with the oil's bulk modulus (Pa) at the pressure `p` (Pa).
    #[inline(always)]
    pub fn stiffness(&self, bulk: T, p: T) -> T {
        T::c(1.0) / ((self.volume + self.compliance * p) / bulk + self.compliance)
    }

    /// J, from the oil's energy per volume at the pressure `p` (Pa).
    #[inline(always)]
    pub fn energy(&self, energy_density: T, p: T) -> T {
        (self.volume + self.compliance * p) * energy_density + self.compliance * p.square() * 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hoses_soften_the_mains() {
        let stiff = Mains { volume: 2e-3, compliance: 0.0 };
        let soft = Mains { volume: 2e-3, compliance: 2e-3 / 1.2e9 };
        assert!((stiff.stiffness(1.2e9, 0.0) - 1.2e9 / 2e-3).abs() < 1.0);
        assert!((soft.stiffness(1.2e9, 0.0) / stiff.stiffness(1.2e9, 0.0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn pressing_oil_in_stores_its_work() {
        // Oil of constant modulus: w = E (exp(p/E) - 1) - p; the work of the inflow is (p + w) q.
        let (bulk, mains) = (1.2e9, Mains { volume: 2e-3, compliance: 3e-13 });
        let density = |p: f64| bulk * ((p / bulk).exp() - 1.0) - p;
        let (mut p, mut work) = (0.0, 0.0);
        let q = 1e-9;
        for _ in 0..20_000 {
            let middle = p + 0.5 * q * mains.stiffness(bulk, p);
            work += (middle + density(middle)) * q;
            p += q * mains.stiffness(bulk, middle);
        }
        assert!((mains.energy(density(p), p) / work - 1.0).abs() < 1e-6);
    }
}
