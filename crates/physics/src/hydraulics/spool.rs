//! Spool dynamics.                                               theory: docs/theory/hydraulics/spool.md
//!
//! x_s'' + 2 zeta omega_n x_s' + omega_n^2 x_s = omega_n^2 u                      thesis (76)-(82)
//!
//! The optional limits of speed and acceleration are those of Figure 44: each integrator's input saturates.
//! The delay of that figure acts on the command, before the equation.

use hydrocrane_num::{Dual, Real};

parameters! {
    pub struct Spool {
        /// omega_n, rad/s
        natural_frequency,
        /// zeta
        damping_ratio,
        /// m/s; infinite: no limit.
        velocity_limit,
        /// m/s^2; infinite: no limit.
        acceleration_limit,
    }
}

impl<T: Real> Spool<T> {
    /// (dx_s/dt, dv_s/dt) from spool position (m), spool velocity state (m/s) and command (m).
    #[inline(always)]
    pub fn rates(&self, position: T, velocity: T, command: T) -> (T, T) {
        let w = self.natural_frequency;
        let acceleration = w * w * (command - position) - self.damping_ratio * w * velocity * 2.0;
        (
            velocity.clamp(-self.velocity_limit, self.velocity_limit),
            acceleration.clamp(-self.acceleration_limit, self.acceleration_limit),
        )
    }

    /// Derivative of dv_s/dt by the command, 1/s^2.
    #[inline(always)]
    pub fn acceleration_by_command(&self, position: T, velocity: T, command: T) -> T {
        let constant = Dual::<T, 1>::constant;
        let rates = self.map(&mut |number| constant(*number)).rates(
            constant(position),
            constant(velocity),
            Dual::variable(command, 0),
        );
        rates.1.derivative[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_saturate_and_no_limit_is_linear() {
        let free = Spool {
            natural_frequency: 100.0,
            damping_ratio: 0.5,
            velocity_limit: f64::INFINITY,
            acceleration_limit: f64::INFINITY,
        };
        assert_eq!(free.rates(0.0, 2.0, 0.01), (2.0, 100.0 - 200.0));
        let limited = Spool { velocity_limit: 1.0, acceleration_limit: 50.0, ..free };
        assert_eq!(limited.rates(0.0, 2.0, 0.01), (1.0, -50.0));
        // At a limit of its acceleration no command moves the spool faster.
        assert_eq!(free.acceleration_by_command(0.0, 2.0, 0.01), 1e4);
        assert_eq!(limited.acceleration_by_command(0.0, 2.0, 0.01), 0.0);
        assert_eq!(limited.acceleration_by_command(0.0, 0.0, 0.004), 1e4);
    }
}
