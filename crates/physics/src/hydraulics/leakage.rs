//! Leakage past the piston and out at the rod.                 theory: docs/theory/hydraulics/leakage.md
//!
//! q_int = k_int (p_1 - p_2)     from chamber 1 to chamber 2                                 thesis (97)
//! q_ext = k_ext (p_2 - p_0)     from chamber 2 to the outside                               thesis (98)
//! k = pi (d/2 + s) s^3 / (6 mu L)                                                           thesis (99)
//!
//! | symbol | meaning | unit |
//! | d      | diameter of the inner cylinder of the annular gap | m |
//! | s, L   | height and length of the gap                      | m |
//! | mu     | dynamic viscosity                                 | Pa s |
//!
//! Departs from the source: the thesis calls mu a friction coefficient and s a radius, and sets mu = 0.6 (E11);
//! its program takes p_1 for p_2 in the external leakage of the extension cylinder (E9).

use hydrocrane_num::Real;

parameters! {
    pub struct Leakage {
        /// m^3/(s Pa)
        internal,
        external,
        ;
        /// Drive the external leakage by the piston-side pressure, as printed for one cylinder.
        external_from_piston_side: bool,
    }
}

impl<T: Real> Leakage<T> {
    /// (q_int from chamber 1 to 2, q_ext from chamber 2 to tank), m^3/s.
    #[inline(always)]
    pub fn flows(&self, p1: T, p2: T, tank: T) -> (T, T) {
        let driving = if self.external_from_piston_side { p1 } else { p2 };
        (self.internal * (p1 - p2), self.external * (driving - tank))
    }
}

/// Conductance of a laminar annular gap (99), m^3/(s Pa).
pub fn annular_gap_conductance<T: Real>(inner_diameter: T, gap: T, length: T, viscosity: T) -> T {
    let cube = gap * gap.square();
    (inner_diameter / 2.0 + gap) * core::f64::consts::PI * cube / (viscosity * 6.0 * length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conductances_of_the_printed_program() {
        let k_int = annular_gap_conductance(0.1, 1e-4, 0.1, 0.6);
        let k_ext = annular_gap_conductance(0.04, 1e-4, 0.01, 0.6);
        assert!((k_int / 4.37e-13 - 1.0).abs() < 2e-3 && (k_ext / 1.75e-12 - 1.0).abs() < 4e-3);
    }
}
