//! Dynamic pressure at the ports of a cylinder.              theory: docs/theory/hydraulics/connector.md
//!
//! p_chamber - p_port = rho/2 v^2 ((A/A_h)^2 - 1)                                    thesis (100)-(104)
//!
//! Departs from the source: (100), (103) misplace squares (E8); the program, like us, subtracts it from the
//! chamber pressure to get the port's. It is a loss-free Bernoulli term and stays below 0.011 bar on this crane.

use hydrocrane_num::Real;

parameters! {
    pub struct Connector {
        /// rho/2 ((A/A_h)^2 - 1) at the piston side and at the rod side, Pa s^2/m^2.
        piston_side,
        rod_side,
    }
}

impl<T: Real> Connector<T> {
    /// Dynamic pressures (Pa) at the ports of both chambers from the piston velocity (m/s).
    #[inline(always)]
    pub fn dynamic_pressures(&self, velocity: T) -> (T, T) {
        let v2 = velocity.square();
        (self.piston_side * v2, self.rod_side * v2)
    }
}

/// The coefficient of [`Connector`] from density and the areas of chamber and connector.
pub fn dynamic_pressure_coefficient<T: Real>(density: T, area: T, connector_area: T) -> T {
    density * 0.5 * ((area / connector_area).square() - 1.0)
}

#[cfg(test)]
mod tests {
    #[test]
    fn ratio_ten_at_half_a_metre_per_second_is_12_5_bar_not_25() {
        let pressure = super::dynamic_pressure_coefficient(1000.0, 100.0, 1.0) * 0.25;
        assert!((pressure / 12.5e5 - 1.0).abs() < 2e-4);
    }
}
