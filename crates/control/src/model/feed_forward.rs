//! Piston speed through the valve and back.                   theory: docs/theory/control/valve.md
//!
//! Steady speed under a force F with the spool at x:   v = |x| sqrt(s),
//!     s = (force of the connected pressures - F) sense / (A_1^3/C_a^2 + A_2^3/C_b^2)      C of an edge to the tank: r C
//! and no faster than a compensator before the spool lets the fed edge, v <= |x| C g(p_c)/A,
//! because p_1 = p_a -+ (A_1/C_a)^2 s and p_2 = p_b +- (A_2/C_b)^2 s behind the pressures p_a and p_b (supply or tank) that the edges open to.
//!
//! Speed at given pressures, not yet steady, with the load's force changing at F':
//!     v (A_1^2 E_1/V_1 + A_2^2 E_2/V_2) = A_1 E_1/V_1 (q_1 - q_int) + A_2 E_2/V_2 (q_2 - q_int + q_ext) - F'
//! from A_1 p_1' - A_2 p_2' = F' with (94), (95): both metering edges act, each with the stiffness of its chamber. After
//! opening a valve the two pressures take some tenths of a second to reach their steady level; this law holds meanwhile.

use crate::model::controller_model::{ControllerModel, CylinderModel};
use hydrocrane_num::portable;
use hydrocrane_physics::hydraulics::compensator::Compensator;
use hydrocrane_physics::hydraulics::edge_flows::{EdgeFlows, PortPressures};
use hydrocrane_physics::hydraulics::fluid::Fluid;
use hydrocrane_physics::hydraulics::parts::AnyParts;

/// Highest pressure, in supply pressures: a load beyond that is carried by no valve.
pub const MOST: f64 = 2.0;
/// Share of [`Steady::span`] that counts as the least force left.
const LEAST_LEFT: f64 = 0.02;

/// Supply and tank pressure, Pa.
#[derive(Debug, Clone, Copy)]
pub struct SupplyPressures {
    pub supply: f64,
    pub tank: f64,
}

impl<const N: usize> ControllerModel<N> {
    pub fn supply_pressures(&self) -> SupplyPressures {
        SupplyPressures { supply: self.supply, tank: self.tank }
    }
}

/// Signed piston speed at full stroke towards `sense` (+1 or -1) in steady motion under `force` (N, positive where
/// the cylinder pushes outward); zero where the supply cannot move it.
pub fn steady_speed(c: &CylinderModel, supply_pressures: &SupplyPressures, force: f64, sense: f64) -> f64 {
    Steady::new(c, supply_pressures).speed(force, sense)
}

/// What the steady speed of a cylinder needs to know of valve and supply.
#[derive(Debug, Clone, Copy)]
pub struct Steady {
    /// Forces of the supply pressures towards either sense, retracting and extending, N.
    supply_pressures: [f64; 2],
    /// Speeds per root of the force that is left, retracting and extending, m/(s sqrt(N)).
    per_root: [f64; 2],
    /// Speeds that the compensator allows, retracting and extending, m/s; infinite without one.
    compensated: [f64; 2],
}

impl Steady {
    pub fn new(c: &CylinderModel, supply_pressures: &SupplyPressures) -> Self {
        let a = [c.chambers.area_1, c.chambers.area_2];
        let ratios = c.ratios_at_full_stroke();
        // Pressures that chamber 1 and chamber 2 would have without any drop over their edges.
        let returned = |port| c.valve.meter_out(port).map_or(supply_pressures.tank, |of| of.pressure);
        let behind = if c.valve.regenerative > 0.0 { supply_pressures.supply } else { returned(1) };
        let forces = [(returned(0), supply_pressures.supply), (supply_pressures.supply, behind)]
            .map(|(p1, p2)| p1 * a[0] - p2 * a[1]);
        let opening = c.stroke - c.valve.overlap;
        let compensated = match c.valve.compensator {
            Compensator::Before(setting) => [
                c.valve.edge_b.flow(opening * ratios[0][1], setting) / a[1],
                c.valve.edge_a.flow(opening * ratios[1][0], setting) / a[0],
            ],
            _ => [f64::INFINITY; 2],
        };
        Steady {
            supply_pressures: forces,
            per_root: ratios.map(|ratios| opening / portable::sqrt(c.resistance(ratios))),
            compensated,
        }
    }

    /// From full pressure on the one side to full pressure on the other, N.
    pub fn span(&self) -> f64 {
        self.supply_pressures[1] - self.supply_pressures[0]
    }

    /// Forces of the supply pressure towards either sense, lowest and highest, N.
    pub fn forces(&self) -> [f64; 2] {
        self.supply_pressures
    }

    /// dv/dF at the speed `v` (m/s) under `force` (N), m/(s N); zero where a compensator keeps the speed.
    pub fn per_force(&self, v: f64, force: f64) -> f64 {
        let sense = v.signum();
        if self.speed(force, sense).abs() == self.compensated[usize::from(v > 0.0)] {
            return 0.0;
        }
        let left = (self.supply_pressures[usize::from(v > 0.0)] - force) * sense;
        -0.5 * v.abs() / left.max(LEAST_LEFT * self.span())
    }

    /// Forces under which either sense has some speed left, lowest and highest, N.
    pub fn movable(&self) -> [f64; 2] {
        let least = LEAST_LEFT * self.span();
        [self.supply_pressures[0] + least, self.supply_pressures[1] - least]
    }

    /// Mean of the steady speeds at full stroke without a load, m/s.
    pub fn speed_unloaded(&self) -> f64 {
        0.5 * (self.speed(0.0, 1.0) - self.speed(0.0, -1.0))
    }

    /// As [`steady_speed`].
    pub fn speed(&self, force: f64, sense: f64) -> f64 {
        let side = usize::from(sense > 0.0);
        let drive = (self.supply_pressures[side] - force) * sense;
        sense * (self.per_root[side] * portable::sqrt(drive.max(0.0))).min(self.compensated[side])
    }
}

/// A cylinder at one sample: position (m) and chamber pressures (Pa).
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    pub stroke: f64,
    pub p: [f64; 2],
}

/// What happens to a cylinder within a time (s): by how much its force changes (N), and where its spool is (m).
#[derive(Debug, Clone, Copy)]
pub struct Ahead {
    pub time: f64,
    pub force: f64,
    pub spool: f64,
}

/// What a cylinder's oil and valve can do at one moment: all that the speed for any spool needs.
#[derive(Debug, Clone, Copy)]
pub struct Capacity {
    /// Of the oil between closed edges, N/m.
    pub stiffness: f64,
    /// Piston speed with closed edges, m/s.
    pub closed: f64,
    /// Piston speeds at full stroke, retracting and extending, m/s.
    pub full: [f64; 2],
    /// What the edges at port A and at port B give of that, m/s.
    pub by_edge: [[f64; 2]; 2],
    /// Shares of the force that either chamber takes.
    pub carried: [f64; 2],
}

impl Capacity {
    /// What the edges at port A and at port B give of the speed `gained` (m/s) at full stroke towards one side over that with closed edges.
    pub fn shares(&self, side: usize, gained: Option<f64>) -> [f64; 2] {
        let Some(gained) = gained else { return self.carried };
        let by = &self.by_edge[side];
        // What a chamber that is being filled lacks to its steady speed comes through both.
        let lacking = gained - by[0] - by[1];
        hydrocrane_num::array::from_fn(|port| (by[port] + lacking * self.carried[port]) / gained)
    }
}

impl CylinderModel {
    /// A_1 E_1/V_1 and A_2 E_2/V_2, Pa/m. Volumes are kept positive for measurements beyond the stroke.
    fn chamber_rates(&self, fluid: &Fluid<f64>, m: &Moment) -> [f64; 2] {
        let (v1, v2) = self.chambers.volumes::<AnyParts>(m.stroke);
        let least = 1e-3 * self.chambers.mid_volume_1;
        [
            self.chambers.area_1 * fluid.bulk_modulus(m.p[0]) / v1.max(least),
            self.chambers.area_2 * fluid.bulk_modulus(m.p[1]) / v2.max(least),
        ]
    }

    /// At these pressures and constant force.
    pub fn capacity(&self, fluid: &Fluid<f64>, supply_pressures: &SupplyPressures, m: &Moment) -> Capacity {
        let [r1, r2] = self.chamber_rates(fluid, m);
        let stiffness = r1 * self.chambers.area_1 + r2 * self.chambers.area_2;
        let ports = ports(supply_pressures, m);
        let per_stiffness = 1.0 / stiffness;
        let speed = |edges: EdgeFlows<f64>| {
            let [q1, q2] = self.flows(&edges, &ports);
            (r1 * q1 + r2 * q2) * per_stiffness
        };
        let closed = self.valve.closed(&ports);
        let open = [-self.stroke, self.stroke].map(|spool| self.valve.flows(spool, &ports));
        let by_edge = open.map(|open| {
            let [one, two] = [open.port_a() - closed.port_a(), open.port_b() - closed.port_b()];
            [r1 * one * per_stiffness, r2 * two * per_stiffness]
        });
        let carried = [r1 * self.chambers.area_1, r2 * self.chambers.area_2].map(|part| part * per_stiffness);
        Capacity { stiffness, closed: speed(closed), full: open.map(speed), by_edge, carried }
    }

    /// Into chamber 1 and out of chamber 2, leakage included, m^3/s.
    fn flows(&self, edges: &EdgeFlows<f64>, ports: &PortPressures<f64>) -> [f64; 2] {
        let (internal, external) = self.leakage.flows(ports.a, ports.b, ports.tank);
        [edges.port_a() - internal, edges.port_b() - internal + external]
    }

    /// Changes of p_1 and p_2 (Pa) for one newton that the oil between closed edges carries more.
    pub fn pressures_per_force(&self, fluid: &Fluid<f64>, m: &Moment) -> [f64; 2] {
        let [r1, r2] = self.chamber_rates(fluid, m);
        let stiffness = r1 * self.chambers.area_1 + r2 * self.chambers.area_2;
        [r1 / stiffness, -r2 / stiffness]
    }

    /// The pressures after a time. The oil between closed edges takes the change of the force, and the level takes one implicit step,
    /// z = t z'(z), along the secant of z': chambers that fill within the time come to their steady level. A chamber at vacuum ends its fall:
    /// the other one carries the force.
    pub fn ahead(&self, fluid: &Fluid<f64>, supply_pressures: &SupplyPressures, m: &Moment, ahead: &Ahead) -> Moment {
        let [a1, a2] = [self.chambers.area_1, self.chambers.area_2];
        let most = MOST * supply_pressures.supply;
        let bounded = |p: [f64; 2]| Moment { stroke: m.stroke, p: p.map(|p| p.max(fluid.vacuum).min(most)) };
        let share = self.pressures_per_force(fluid, m);
        let loaded = bounded(hydrocrane_num::array::from_fn(|i| m.p[i] + ahead.force * share[i]));
        let [least, highest] =
            [fluid.vacuum, most].map(|bound| [(bound - loaded.p[0]) / a2, (bound - loaded.p[1]) / a1]);
        let within = |z: f64| z.max(least[0].max(least[1])).min(highest[0].min(highest[1]));
        let at = |z: f64| bounded([loaded.p[0] + a2 * within(z), loaded.p[1] + a1 * within(z)]);
        let rate = |z: f64| self.level_rate(fluid, supply_pressures, &at(z), ahead.spool);
        let first = rate(0.0);
        let far = within(ahead.time * first);
        let falls = if far == 0.0 { 0.0 } else { ((first - rate(far)) / far).max(0.0) };
        at(ahead.time * first / (1.0 + ahead.time * falls))
    }

    /// Rate of the level z of the pressures, p_1' = A_2 z' and p_2' = A_1 z', at constant force with the spool at `spool` (m), Pa/(m^2 s).
    pub fn level_rate(&self, fluid: &Fluid<f64>, supply_pressures: &SupplyPressures, m: &Moment, spool: f64) -> f64 {
        let [r1, r2] = self.chamber_rates(fluid, m);
        let [a1, a2] = [self.chambers.area_1, self.chambers.area_2];
        let ports = ports(supply_pressures, m);
        let [q1, q2] = self.flows(&self.valve.flows(spool, &ports), &ports);
        r1 * r2 * (a2 * q1 - a1 * q2) / (a1 * a2 * (r1 * a1 + r2 * a2))
    }
}

fn ports(supply_pressures: &SupplyPressures, m: &Moment) -> PortPressures<f64> {
    let SupplyPressures { supply, tank } = *supply_pressures;
    PortPressures { supply, load: tank, tank, a: m.p[0], b: m.p[1], opening: None }
}
