//! End stops.                                                 theory: docs/theory/hydraulics/end_stop.md
//!
//! Over the last length l of the stroke, with depth d and s = d/l:
//!     F = -+ k d / (1 - s)  -  c s v
//!
//! | symbol | meaning | unit |
//! | k      | stiffness at first touch        | N/m   |
//! | l      | length of the stop's zone       | m     |
//! | c      | damping at full compression     | N s/m |
//!
//! Departs from the source: the program's spring k d is too soft (supply pressure drives the piston 22 mm into
//! a zone of 21.5 mm, to zero chamber volume, E14) and undamped. Here the force grows without bound at the end
//! of the stroke, so that no pressure reaches it. Past s = 0.98, where only trial states of a solver come, the
//! spring goes on straight. Spring energy: k l^2 (-s - ln(1 - s)).

use hydrocrane_num::{functions::smooth, Real};

parameters! {
    pub struct EndStop {
        /// Piston positions where the stops end, m.
        lower,
        upper,
        /// m
        zone,
        /// N/m
        stiffness,
        /// N s/m
        damping,
        ;
        /// The undamped linear spring of the program.
        printed: bool,
    }
}

/// Depth, relative to the zone, where the spring law goes on straight.
const STRAIGHT: f64 = 0.98;
/// Slope of s / (1 - s) there.
const STRAIGHT_SLOPE: f64 = 1.0 / ((1.0 - STRAIGHT) * (1.0 - STRAIGHT));

impl<T: Real> EndStop<T> {
    /// Force of the stops on the piston, N, positive outward: (spring, damper).
    #[inline(always)]
    pub fn force(&self, x: T, v: T) -> (T, T) {
        let (inner, outer) = self.depths(x);
        if self.printed {
            let spring = self.stiffness * self.zone * (inner - outer);
            return (spring, T::c(0.0));
        }
        let spring = self.stiffness * self.zone * (hyperbola(inner) - hyperbola(outer));
        let depth = (inner + outer).min(T::c(1.0));
        (spring, -self.damping * depth * v)
    }

    /// Energy in the spring, J.
    pub fn energy(&self, x: T) -> T {
        let (inner, outer) = self.depths(x);
        let scale = self.stiffness * self.zone.square();
        if self.printed {
            return scale * (inner.square() + outer.square()) * 0.5;
        }
        scale * (hyperbola_integral(inner) + hyperbola_integral(outer))
    }

    /// Relative depths into the lower and the upper stop.
    #[inline(always)]
    fn depths(&self, x: T) -> (T, T) {
        let per_zone = T::c(1.0) / self.zone;
        (
            smooth::positive_part(self.lower + self.zone - x) * per_zone,
            smooth::positive_part(x - (self.upper - self.zone)) * per_zone,
        )
    }
}

/// s / (1 - s), straight past [`STRAIGHT`].
#[inline(always)]
fn hyperbola<T: Real>(s: T) -> T {
    let inside = s.min(T::c(STRAIGHT));
    let rest = T::c(1.0) - inside;
    inside / rest + (s - inside) * STRAIGHT_SLOPE
}

/// Integral of [`hyperbola`] from zero.
fn hyperbola_integral<T: Real>(s: T) -> T {
    let inside = s.min(T::c(STRAIGHT));
    let over = s - inside;
    let straight = over * (STRAIGHT / (1.0 - STRAIGHT)) + over.square() * (0.5 * STRAIGHT_SLOPE);
    -inside - (T::c(1.0) - inside).ln() + straight
}

#[cfg(test)]
mod tests {
    use super::*;
    use hydrocrane_num::{Dual, Field};

    fn stop(printed: bool) -> EndStop<f64> {
        EndStop { lower: -0.165, upper: 0.165, zone: 0.0215, stiffness: 5e6, damping: 5e4, printed }
    }

    #[test]
    fn force_is_minus_the_slope_of_its_energy() {
        for printed in [false, true] {
            for x in [-0.1649, -0.15, 0.0, 0.144, 0.16, 0.17] {
                let e = stop(printed).lift::<Dual<f64, 1>>().energy(Dual::variable(x, 0));
                let (spring, _) = stop(printed).force(x, 0.0);
                assert!((spring + e.derivative[0]).abs() <= 1e-9 * spring.abs(), "{x}");
            }
        }
    }

    #[test]
    fn holds_the_piston_where_the_printed_spring_does_not() {
        let supply_force = 140e5 * 7.854e-3;
        let (held, _) = stop(false).force(0.165 - 0.0215 * 0.4, 0.0);
        assert!(-held > supply_force);
        assert!(-stop(true).force(0.165, 0.0).0 < supply_force);
    }

    #[test]
    fn value_and_slope_are_finite_everywhere_and_damping_dissipates() {
        for x in [-1.0, -0.165, -0.1435, 0.0, 0.1435, 0.165, 1.0] {
            let (s, d) = stop(false).lift::<Dual<f64, 1>>().force(Dual::variable(x, 0), Dual::c(0.3));
            assert!(s.value.is_finite() && s.derivative[0].is_finite() && d.derivative[0].is_finite());
            assert!(d.value * 0.3 <= 0.0);
        }
    }
}
