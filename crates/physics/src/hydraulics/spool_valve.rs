//! Spool valve: four metering edges between supply, tank and the ports A and B.
//!                                                        theory: docs/theory/hydraulics/spool_valve.md
//!
//! x_s > 0:  q_A = q(x_s, p_S - p_A),   q_B = q(x_s, p_B - p_0)                           thesis (66)
//! x_s < 0:  q_A = -q(-x_s, p_A - p_0), q_B = -q(-x_s, p_S - p_B)                         thesis (67)
//! regenerative, x_s > 0:               q_B = q(x_s, p_B - p_S)                           thesis (68)
//!
//! | symbol | meaning | sign |
//! | x_s    | spool position, m                          | positive extends the piston |
//! | q_A    | flow from port A into the cylinder, m^3/s  | positive into the chamber   |
//! | q_B    | flow out of the cylinder into port B       | positive out of the chamber |
//!
//! Overlap closes both directions within +-overlap. Leakage (75) is laminar over each edge; unlike (75), which
//! opens it on the closed edges only, it is always there, so the law stays smooth (an open edge drowns it).

use super::orifice::Orifice;
use hydrocrane_num::{smooth, Real};

/// Valve with its edges at port A and at port B (they differ only in the printed law).
#[derive(Debug, Clone, Copy)]
pub struct SpoolValve<T> {
    pub edge_a: Orifice<T>,
    pub edge_b: Orifice<T>,
    /// m
    pub overlap: T,
    /// Laminar conductance of an edge, m^3/(s Pa).
    pub leakage: T,
    pub regenerative: bool,
}

impl<T: Copy> SpoolValve<T> {
    /// The same valve with `f` of every number.
    pub fn map<U>(&self, f: &mut impl FnMut(T) -> U) -> SpoolValve<U> {
        SpoolValve {
            edge_a: self.edge_a.map(f),
            edge_b: self.edge_b.map(f),
            overlap: f(self.overlap),
            leakage: f(self.leakage),
            regenerative: self.regenerative,
        }
    }
}

/// Pressures around the valve, Pa.
#[derive(Debug, Clone, Copy, Default)]
pub struct PortPressures<T> {
    pub supply: T,
    pub tank: T,
    pub a: T,
    pub b: T,
}

/// Flow through each edge, m^3/s, in the direction its name reads.
#[derive(Debug, Clone, Copy, Default)]
pub struct EdgeFlows<T> {
    pub supply_to_a: T,
    pub a_to_tank: T,
    pub supply_to_b: T,
    pub b_to_tank: T,
}

impl<T: Real> SpoolValve<T> {
    #[inline(always)]
    pub fn flows(&self, spool: T, p: &PortPressures<T>) -> EdgeFlows<T> {
        let extend = smooth::positive_part(spool - self.overlap);
        let retract = smooth::positive_part(-spool - self.overlap);
        let drops = [p.supply - p.a, p.a - p.tank, p.supply - p.b, p.b - p.tank];

        // At most one edge of a port is open: one root per port serves both.
        let retracting = spool.lt(T::c(0.0));
        let per_opening_a = self.edge_a.flow_per_opening(T::select(retracting, drops[1], drops[0]));
        let to_b = if self.regenerative { drops[2] } else { T::select(retracting, drops[2], drops[3]) };
        let per_opening_b = self.edge_b.flow_per_opening(to_b);
        // A regenerative valve joins B to the supply in both directions.
        let (b_supply, b_tank) = if self.regenerative { (extend + retract, T::c(0.0)) } else { (retract, extend) };
        EdgeFlows {
            supply_to_a: extend * per_opening_a + self.leakage * drops[0],
            a_to_tank: retract * per_opening_a + self.leakage * drops[1],
            supply_to_b: b_supply * per_opening_b + self.leakage * drops[2],
            b_to_tank: b_tank * per_opening_b + self.leakage * drops[3],
        }
    }
}

impl<T: Real> EdgeFlows<T> {
    /// q_A: into the piston-side chamber.
    #[inline(always)]
    pub fn port_a(&self) -> T {
        self.supply_to_a - self.a_to_tank
    }
    /// q_B: out of the rod-side chamber.
    #[inline(always)]
    pub fn port_b(&self) -> T {
        self.b_to_tank - self.supply_to_b
    }
    /// Flow drawn from the pump.
    pub fn supply(&self) -> T {
        self.supply_to_a + self.supply_to_b
    }
    /// Flow returned to the tank.
    pub fn tank(&self) -> T {
        self.a_to_tank + self.b_to_tank
    }
}

#[cfg(test)]
mod tests {
    use super::super::orifice::OrificeLaw;
    use super::*;

    fn valve(regenerative: bool, overlap: f64) -> SpoolValve<f64> {
        let edge = Orifice {
            coefficient: 7.3e-7,
            transition_pressure: 3e5,
            laminar_curvature: smooth::root_curvature(3e5),
            blend_low: 2e5,
            blend_high: 4e5,
            law: OrificeLaw::TwoRegime,
        };
        SpoolValve { edge_a: edge, edge_b: edge, overlap, leakage: 0.0, regenerative }
    }

    const P: PortPressures<f64> = PortPressures { supply: 140e5, tank: 0.0, a: 60e5, b: 50e5 };

    #[test]
    fn table_2_signs_of_the_four_three_valve() {
        let up = valve(false, 0.0).flows(0.01, &P);
        assert!(up.port_a() > 0.0 && up.port_b() > 0.0 && up.supply_to_b == 0.0);
        let down = valve(false, 0.0).flows(-0.01, &P);
        assert!(down.port_a() < 0.0 && down.port_b() < 0.0);
    }

    #[test]
    fn table_2_signs_of_the_regenerative_valve() {
        // Extending, oil leaves B against the supply only if p_B exceeds it; here both chambers are fed.
        let fed = valve(true, 0.0).flows(0.01, &P);
        assert!(fed.port_a() > 0.0 && fed.port_b() < 0.0 && fed.tank() == 0.0);
        let pushed = valve(true, 0.0).flows(0.01, &PortPressures { b: 170e5, ..P });
        assert!(pushed.port_b() > 0.0);
        let retract = valve(true, 0.0).flows(-0.01, &P);
        assert!(retract.port_a() < 0.0 && retract.port_b() < 0.0);
    }

    #[test]
    fn closed_or_overlapped_valve_passes_nothing() {
        for (overlap, spool) in [(0.0, 0.0), (1e-3, 0.9e-3), (1e-3, -0.9e-3)] {
            let f = valve(false, overlap).flows(spool, &P);
            assert_eq!((f.port_a(), f.port_b()), (0.0, 0.0));
        }
    }

    #[test]
    fn leakage_feeds_both_ports_of_a_closed_valve_and_vanishes_in_the_sum() {
        let leaking = SpoolValve { leakage: 1e-13, ..valve(false, 0.0) };
        let f = leaking.flows(0.0, &P);
        assert!((f.port_a() - 1e-13 * (P.supply - 2.0 * P.a + P.tank)).abs() < 1e-20);
        // What the pump gives and the tank takes differs by what the ports take.
        assert!((f.supply() - f.tank() - (f.port_a() - f.port_b())).abs() < 1e-20);
    }
}
