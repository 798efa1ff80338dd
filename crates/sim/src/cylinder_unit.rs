//! One cylinder with its valve: the laws of `physics` in order, from its local state to force and rates.

use hydrocrane_num::{Dual, Real};
use hydrocrane_physics::friction::{lugre::LuGre, static_map, StaticParameters};
use hydrocrane_physics::hydraulics::chamber::Chambers;
use hydrocrane_physics::hydraulics::connector::Connector;
use hydrocrane_physics::hydraulics::end_stop::EndStop;
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::leakage::Leakage;
use hydrocrane_physics::hydraulics::spool::Spool;
use hydrocrane_physics::hydraulics::spool_valve::{EdgeFlows, PortPressures, SpoolValve};

/// Which friction law acts, with its parameters.
#[derive(Debug, Clone, Copy)]
pub enum FrictionLaw<T> {
    Static { map: StaticParameters<T>, width: T },
    Printed { map: StaticParameters<T> },
    LuGre { map: StaticParameters<T>, bristle: LuGre<T> },
}

/// Speed below which a secant of friction is that of this speed, m/s.
const CREEP: f64 = 1e-9;

/// Parameters of one cylinder and its valve.
#[derive(Debug, Clone, Copy)]
pub struct CylinderUnit<T> {
    pub chambers: Chambers<T>,
    pub valve: SpoolValve<T>,
    pub spool: Spool<T>,
    pub leakage: Leakage<T>,
    pub connector: Connector<T>,
    pub end_stop: EndStop<T>,
    pub friction: FrictionLaw<T>,
}

/// Pressures that all valves share, Pa.
#[derive(Debug, Clone, Copy)]
pub struct Mains<T> {
    pub supply: T,
    pub tank: T,
}

/// What a cylinder's laws depend on besides its spool velocity.
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
}

/// Everything the laws say of a cylinder at one state.
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
    /// Leakage from chamber 1 to 2 and from chamber 2 outside, m^3/s.
    pub internal_leakage: T,
    pub external_leakage: T,
    /// Pressures at the valve's ports, Pa.
    pub ports: PortPressures<T>,
    /// Damping force of the end stops, N, positive outward.
    pub stop_damping: T,
    /// Power stored in the bristles, W.
    pub bristle_power: T,
}

impl<T: Real> FrictionLaw<T> {
    /// (force, z', power into the bristles)
    #[inline(always)]
    fn evaluate(&self, v: T, z: T) -> (T, T, T) {
        let none = T::c(0.0);
        match self {
            FrictionLaw::Static { map, width } => (static_map::force(map, *width, v), none, none),
            FrictionLaw::Printed { map } => (static_map::printed(map, v), none, none),
            FrictionLaw::LuGre { map, bristle } => {
                let f = bristle.evaluate(map, v, z);
                (f.force, f.deflection_rate, bristle.stiffness * z * f.deflection_rate)
            }
        }
    }

    /// Friction at constant velocity, N.
    pub fn steady(&self, v: T) -> T {
        match self {
            FrictionLaw::LuGre { map, .. } => {
                let sign = T::select(v.lt(T::c(0.0)), T::c(-1.0), T::c(1.0));
                map.stribeck(v) * sign + map.viscous(v)
            }
            _ => self.evaluate(v, T::c(0.0)).0,
        }
    }

    /// Slope of a map less the secant F/v through standstill; zero with bristles, which are no map.
    pub fn tangent_less_secant(&self, v: T) -> T {
        if self.has_bristle() {
            return T::c(0.0);
        }
        let moving = T::c(CREEP).lt(v.abs());
        let at = Dual::<T, 1>::variable(T::select(moving, v, T::c(CREEP)), 0);
        let friction = self.map(&mut Dual::constant).evaluate(at, Dual::constant(T::c(0.0))).0;
        friction.derivative[0] - friction.value / at.value
    }

    pub fn has_bristle(&self) -> bool {
        matches!(self, FrictionLaw::LuGre { .. })
    }
}

impl<T: Real> CylinderUnit<T> {
    #[inline(always)]
    pub fn rates(&self, fluid: &Fluid<T>, mains: &Mains<T>, s: &LocalState<T>) -> LocalRates<T> {
        let (rise_1, rise_2) = self.connector.rises(s.v);
        let ports = PortPressures { supply: mains.supply, tank: mains.tank, a: s.p1 - rise_1, b: s.p2 - rise_2 };
        let edges = self.valve.flows(s.spool, &ports);
        let (internal_leakage, external_leakage) = self.leakage.flows(s.p1, s.p2, mains.tank);
        let inflow = (edges.port_a() - internal_leakage, internal_leakage - external_leakage - edges.port_b());
        let (p1_rate, p2_rate) = self.chambers.pressure_rates(fluid, s.x, s.v, (s.p1, s.p2), inflow);

        let (friction, z_rate, bristle_power) = self.friction.evaluate(s.v, s.z);
        let (stop_spring, stop_damping) = self.end_stop.force(s.x, s.v);
        let force = self.chambers.force(s.p1, s.p2) + stop_spring + stop_damping - friction;
        LocalRates {
            force,
            friction,
            p1_rate,
            p2_rate,
            z_rate,
            edges,
            internal_leakage,
            external_leakage,
            ports,
            stop_damping,
            bristle_power,
        }
    }
}

impl<T: Copy> CylinderUnit<T> {
    /// The same cylinder with `f` of every number.
    pub fn map<U>(&self, f: &mut impl FnMut(T) -> U) -> CylinderUnit<U> {
        CylinderUnit {
            chambers: self.chambers.map(f),
            valve: self.valve.map(f),
            spool: self.spool.map(f),
            leakage: self.leakage.map(f),
            connector: self.connector.map(f),
            end_stop: self.end_stop.map(f),
            friction: self.friction.map(f),
        }
    }
}

impl<T: Copy> FrictionLaw<T> {
    fn map<U>(&self, f: &mut impl FnMut(T) -> U) -> FrictionLaw<U> {
        match self {
            FrictionLaw::Static { map, width } => FrictionLaw::Static { map: map.map(f), width: f(*width) },
            FrictionLaw::Printed { map } => FrictionLaw::Printed { map: map.map(f) },
            FrictionLaw::LuGre { map, bristle } => FrictionLaw::LuGre { map: map.map(f), bristle: bristle.map(f) },
        }
    }
}
