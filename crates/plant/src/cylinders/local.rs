//! The local state of a cylinder, and what its laws give there.

use crate::cylinders::in_chains::in_chains;
use hydrocrane_num::Real;
use hydrocrane_physics::hydraulics::edge_flows::{EdgeFlows, PortPressures};

/// Local state: what the laws of a cylinder depend on besides its spool velocity.
#[derive(Debug, Clone, Copy, Default)]
pub struct LocalState<T> {
    /// Piston position (m) and velocity (m/s).
    pub x: T,
    pub v: T,
    pub p1: T,
    pub p2: T,
    /// Spool position, m.
    pub spool: T,
    /// Bristle deflection, m (zero without LuGre).
    pub z: T,
    /// Opening of the compensator, if it follows late.
    pub opening: Option<T>,
}

impl<T: Copy> LocalState<T> {
    /// The same with `f` of every number.
    #[inline(always)]
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> LocalState<U> {
        let LocalState { x, v, p1, p2, spool, z, opening } = *self;
        let opening = in_chains(opening).map(&f);
        LocalState { x: f(x), v: f(v), p1: f(p1), p2: f(p2), spool: f(spool), z: f(z), opening }
    }
}

/// All results of the laws of a cylinder at one state.
#[derive(Debug, Clone, Copy, Default)]
pub struct LocalRates<T> {
    /// Net force on the rod, N, positive outward: pressures and end stops less friction.
    pub force: T,
    /// N, positive against positive velocity
    pub friction: T,
    /// Pa/s
    pub p1_rate: T,
    pub p2_rate: T,
    /// m/s
    pub z_rate: T,
    pub edges: EdgeFlows<T>,
    /// From each port through its own valves to the tank, m^3/s.
    pub relieved: [T; 2],
    /// From the piston-side port through a cross-over relief valve to the rod-side port, m^3/s.
    pub crossed: T,
    /// From the hose of each port to the outside, m^3/s.
    pub lost: [T; 2],
    /// Leakage from chamber 1 to 2 and from chamber 2 outside, m^3/s.
    pub internal_leakage: T,
    pub external_leakage: T,
    /// Pressures at the valve's ports, behind the lines, Pa, and those before them above that.
    pub ports: PortPressures<T>,
    pub line_drops: [T; 2],
    /// Of the hoses below those of the chambers, Pa: where they leak behind a valve that holds the load.
    pub hose_drops: [T; 2],
    /// Damping force of the end stops, N, positive outward.
    pub stop_damping: T,
    /// Power stored in the bristles, W.
    pub bristle_power: T,
}

/// Those that the state derivative takes. Few, since each is handed from function to function.
#[derive(Debug, Clone, Copy)]
pub struct StateRates<T> {
    /// Net force on the rod, N, positive outward.
    pub force: T,
    /// Pa/s
    pub p1_rate: T,
    pub p2_rate: T,
    /// m/s
    pub z_rate: T,
    /// Flows from the supply and to the tank, m^3/s.
    pub drawn: T,
    pub returned: T,
}

impl<T: Copy> StateRates<T> {
    /// The same with `f` of every number.
    #[inline(always)]
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> StateRates<U> {
        let StateRates { force, p1_rate, p2_rate, z_rate, drawn, returned } = *self;
        StateRates {
            force: f(force),
            p1_rate: f(p1_rate),
            p2_rate: f(p2_rate),
            z_rate: f(z_rate),
            drawn: f(drawn),
            returned: f(returned),
        }
    }
}

impl<T: Copy> LocalRates<T> {
    /// The same with `f` of every number.
    #[inline(always)]
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> LocalRates<U> {
        let (e, p) = (&self.edges, &self.ports);
        LocalRates {
            force: f(self.force),
            friction: f(self.friction),
            p1_rate: f(self.p1_rate),
            p2_rate: f(self.p2_rate),
            z_rate: f(self.z_rate),
            edges: EdgeFlows {
                supply_to_a: f(e.supply_to_a),
                a_to_tank: f(e.a_to_tank),
                supply_to_b: f(e.supply_to_b),
                b_to_tank: f(e.b_to_tank),
            },
            relieved: [f(self.relieved[0]), f(self.relieved[1])],
            crossed: f(self.crossed),
            lost: [f(self.lost[0]), f(self.lost[1])],
            internal_leakage: f(self.internal_leakage),
            external_leakage: f(self.external_leakage),
            ports: PortPressures {
                supply: f(p.supply),
                load: f(p.load),
                tank: f(p.tank),
                a: f(p.a),
                b: f(p.b),
                opening: in_chains(p.opening).map(&f),
            },
            line_drops: [f(self.line_drops[0]), f(self.line_drops[1])],
            hose_drops: [f(self.hose_drops[0]), f(self.hose_drops[1])],
            stop_damping: f(self.stop_damping),
            bristle_power: f(self.bristle_power),
        }
    }
}

impl<T: Real> LocalRates<T> {
    /// Flow into the piston side and out of the rod side, m^3/s: that of the spool valve less that of the ports' own valves, from
    /// port to port, and out of hoses that leak.
    #[inline(always)]
    pub fn through_ports(&self) -> (T, T) {
        let (a, b) = (self.edges.port_a() - self.relieved[0], self.edges.port_b() + self.relieved[1]);
        if cfg!(feature = "chains") {
            (a - self.crossed - self.lost[0], b - self.crossed + self.lost[1])
        } else {
            (a - self.crossed, b - self.crossed)
        }
    }

    /// Those that the state derivative takes.
    #[inline(always)]
    pub fn of_states(&self) -> StateRates<T> {
        StateRates {
            force: self.force,
            p1_rate: self.p1_rate,
            p2_rate: self.p2_rate,
            z_rate: self.z_rate,
            drawn: self.edges.supply(),
            returned: self.returned(),
        }
    }

    /// Flow to the tank, m^3/s: through the spool valve, the ports' own valves, and past the rod.
    #[inline(always)]
    pub fn returned(&self) -> T {
        self.edges.tank() + self.relieved[0] + self.relieved[1] + self.external_leakage
    }

    /// Pressures around the valve, those of its ports before the lines to the cylinder.
    #[inline(always)]
    pub fn at_valve(&self) -> PortPressures<T> {
        let before = |port: usize, behind: T| behind + self.line_drops[port] - self.hose_drops[port];
        PortPressures { a: before(0, self.ports.a), b: before(1, self.ports.b), ..self.ports }
    }
}
