//! Cylinder chambers: volumes and pressure build-up.           theory: docs/theory/hydraulics/chamber.md
//!
//! V_1 = V_d1 + A_1 (s/2 + x),     V_2 = V_d2 + A_2 (s/2 - x)                        thesis (84)-(87)
//! V_1 = V_d1,                     V_2 = V_d2                                         of a motor
//! p_1' = E(p_1)/V_1 (q_1 - q_int - A_1 v)                                           thesis (94), (105)
//! p_2' = E(p_2)/V_2 (-q_2 + q_int - q_ext + A_2 v)                                  thesis (95), (106)
//!
//! With hoses to the valve of volume V_l and compliance C_l, V + V_l stands for V, and E/V gives way to the law of a volume with elastic
//! walls ([`super::mains`]).
//!
//! A motor takes the oil A v through, and its sides stay as large as they are.
//!
//! with s the stroke, x the piston position from mid-stroke, q_int here from chamber 1 to 2 (the thesis's
//! (97) counts it the other way, E12).

use super::mains::Mains;
use super::parts::{AnyParts, Parts};
use hydrocrane_num::Real;

parameters! {
    pub struct Chambers {
        /// Piston-side and rod-side area, m^2.
        area_1,
        area_2,
        /// Volumes at mid-stroke, dead volume and lines included, m^3.
        mid_volume_1,
        mid_volume_2,
        /// Growth of the lines with pressure, m^3/Pa.
        compliance_1,
        compliance_2,
        ;
        /// Whether the lines grow.
        elastic: bool,
        /// Whether these are the sides of a motor.
        motor: bool,
    }
}

impl<T: Real> Chambers<T> {
    /// m^3
    #[inline(always)]
    pub fn volumes<P: Parts>(&self, x: T) -> (T, T) {
        if P::EXPECTED && self.motor {
            return (self.mid_volume_1, self.mid_volume_2);
        }
        (self.mid_volume_1 + self.area_1 * x, self.mid_volume_2 - self.area_2 * x)
    }

    /// Pressure force on the piston, N, positive outward.
    #[inline(always)]
    pub fn force(&self, p1: T, p2: T) -> T {
        p1 * self.area_1 - p2 * self.area_2
    }

    /// Both chambers with their lines.
    #[inline(always)]
    fn elastic_volumes(&self, x: T) -> [Mains<T>; 2] {
        let (v1, v2) = self.volumes::<AnyParts>(x);
        [Mains { volume: v1, compliance: self.compliance_1 }, Mains { volume: v2, compliance: self.compliance_2 }]
    }

    /// Rise of each pressure per volume that flows in, Pa/m^3, from the bulk moduli and the pressures (Pa).
    #[inline(always)]
    pub fn stiffness<P: Parts>(&self, bulk: (T, T), x: T, p: (T, T)) -> (T, T) {
        if P::EXPECTED && self.elastic {
            let [one, two] = self.elastic_volumes(x);
            return (one.stiffness(bulk.0, p.0), two.stiffness(bulk.1, p.1));
        }
        let (v1, v2) = self.volumes::<P>(x);
        (bulk.0 / v1, bulk.1 / v2)
    }

    /// Energy stored in the oil and in the walls of the lines, J, from the oil's energy per volume in both chambers and the pressures (Pa).
    pub fn energy(&self, energy_density: (T, T), x: T, p: (T, T)) -> T {
        if self.elastic {
            let [one, two] = self.elastic_volumes(x);
            return one.energy(energy_density.0, p.0) + two.energy(energy_density.1, p.1);
        }
        let (v1, v2) = self.volumes::<AnyParts>(x);
        v1 * energy_density.0 + v2 * energy_density.1
    }

    /// Flows that a motor takes out of its first side and gives into its second at the speed `v` (m/s), m^3/s: this oil carries its energy
    /// on. A piston moves the wall instead.
    #[inline(always)]
    pub fn taken_through(&self, v: T) -> (T, T) {
        if AnyParts::EXPECTED && self.motor {
            (self.area_1 * v, self.area_2 * v)
        } else {
            (T::c(0.0), T::c(0.0))
        }
    }

    /// (p_1', p_2') in Pa/s from the bulk moduli and the pressures (Pa), the flows into each chamber (m^3/s) and the piston's motion.
    #[inline(always)]
    pub fn pressure_rates<P: Parts>(&self, bulk: (T, T), x: T, v: T, p: (T, T), inflow: (T, T)) -> (T, T) {
        let (stiffness_1, stiffness_2) = self.stiffness::<P>(bulk, x, p);
        (stiffness_1 * (inflow.0 - self.area_1 * v), stiffness_2 * (inflow.1 + self.area_2 * v))
    }
}
