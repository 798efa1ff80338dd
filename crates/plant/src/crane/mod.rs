//! A machine with `N` joints, ready for evaluation.

pub(crate) mod drawing;
pub(crate) mod dynamics;
pub(crate) mod hydraulics;
pub(crate) mod inverse;
pub(crate) mod kinematics;
pub mod limits;
pub(crate) mod load_pressure;
pub(crate) mod sensor_ranges;
pub(crate) mod state_space;
pub mod statics;
pub(crate) mod workspace;

use crate::crane::limits::{JointActuation, JointLimits};
use crate::equations::from_machine::plant;
use crate::equations::laws::{Laws, Moment};
use crate::equations::outputs::{self, OutputInfo};
use crate::equations::plant::Plant;
use crate::errors::{BuildError, PoseError};
use crate::layout::{Layout, PumpUnit, Unit};
use crate::oil;
use crate::precision::Precision;
use crate::resting::equilibrium::resting_position;
use hydrocrane_machine::model::Cylinder;
use hydrocrane_machine::Machine;
use hydrocrane_num::{linear::small, portable};
use hydrocrane_physics::dynamics::equations_of_motion::RigidChain;
use hydrocrane_physics::hydraulics::fluid::{ElasticEnergy, OilTables};
use std::sync::{Arc, OnceLock};

pub struct Crane<const N: usize> {
    pub(crate) machine: Machine,
    pub(crate) laws: Laws<N>,
    /// Built on first use: only energies and densities need them.
    pub(crate) oil: OnceLock<Arc<OilTables>>,
    pub(crate) layout: Layout,
    pub(crate) precision: Precision,
    pub(crate) limits: Vec<JointLimits>,
    /// Ranges of coordinates in which every state is admissible.
    pub(crate) safe: [[f64; 2]; N],
    pub(crate) outputs: Vec<OutputInfo>,
}

/// Least remainder of a mass matrix entry after elimination, as a share: four digits above rounding.
const LEAST_PIVOT: f64 = 1e-12;
/// Share of a joint's range at either end where admissibility is checked in detail.
const EDGE: f64 = 1e-3;

impl<const N: usize> Crane<N> {
    pub fn new(machine: &Machine) -> Result<Self, BuildError> {
        let plant = plant::<f64, N>(machine)?;
        let units: Vec<Unit> = (machine.joints.iter().zip(&machine.cylinders).zip(&plant.cylinders))
            .map(|((j, c), p)| Unit {
                joint: j.name.clone(),
                cylinder: c.name.clone(),
                revolute: matches!(j.kind, hydrocrane_machine::model::JointKind::Revolute(_)),
                bristle: p.friction.has_bristle(),
                opening: p.compensator_lag().is_some(),
                spool: (c.valve.stroke, c.valve.spool.natural_frequency),
            })
            .collect();
        let pump = machine.supply.mains.as_ref().map(|mains| PumpUnit {
            names: mains.pumps().map(|pump| pump.name.clone()).collect(),
            senses: mains.load_sensing.is_some(),
            swivels: mains.pump.control.is_some(),
            returns: mains.tank_line.is_some(),
        });
        let measured = machine.supply.measured;
        let plain = |c: &Cylinder| {
            let (curves, out) = (&c.valve.metering, &c.valve.meter_out);
            let metered = curves.iter().any(Option::is_some) || out.iter().any(Option::is_some);
            c.valve.compensator.is_none()
                && !metered
                && c.ports.holding.iter().all(Option::is_none)
                && !c.has_port_valves()
                && !c.has_crossover_relief()
                && !c.valve.load_check
                && !c.has_line_resistance()
                && !c.has_elastic_line()
                && !c.motor
                && !c.has_hose_leak()
        };
        let mobile = measured || pump.is_some() || !machine.cylinders.iter().all(plain);
        if (mobile || machine.is_spatial()) && !cfg!(feature = "chains") {
            return Err(BuildError::Pump);
        }
        let layout = Layout::new(&units, pump.as_ref(), measured);
        let mut crane = Crane {
            laws: Laws::new(&plant, &layout),
            oil: OnceLock::new(),
            precision: Precision::new(&layout, 1.0),
            layout,
            limits: Vec::with_capacity(N),
            safe: [[f64::INFINITY, f64::NEG_INFINITY]; N],
            outputs: outputs::info(machine),
            machine: machine.clone(),
        };
        for i in 0..N {
            let limits = crane.actuation_of(i).limits()?;
            crane.limits.push(limits);
        }
        crane.safe = crane.safe_ranges();
        crane.check_mass_matrix()?;
        crane.require_finite()?;
        for unusual in [crane.low_settings(), crane.short_ranges()].concat() {
            // A machine that is built again already has its warnings.
            if !crane.machine.warnings.contains(&unusual) {
                crane.machine.warnings.push(unusual);
            }
        }
        Ok(crane)
    }

    /// Whether the lighter links are resolved beyond rounding, in the middle of all ranges.
    fn check_mass_matrix(&self) -> Result<(), BuildError> {
        let mechanics = &self.plant().mechanics;
        let middle = self.limit_pairs().map(|[lower, upper]| 0.5 * (lower + upper));
        let mass_matrix = self.plant().equations(&mechanics.pose(&middle), &[0.0; N], 0.0).mass_matrix;
        if small::least_pivot(&mass_matrix) > LEAST_PIVOT {
            return Ok(());
        }
        let heavy = |i: &usize| mechanics.bodies[*i].inertia.abs().max(mechanics.bodies[*i].mass);
        let heaviest = (0..N).max_by(|a, b| heavy(a).total_cmp(&heavy(b))).unwrap_or(0);
        Err(BuildError::Unresolvable(self.machine.links[heaviest + 1].name.clone()))
    }

    /// Numbers of a file can be valid separately and overflow together; one evaluation in the middle shows this.
    fn require_finite(&self) -> Result<(), BuildError> {
        let mut x = vec![0.0; self.layout.len()];
        for (i, limits) in self.limits.iter().enumerate() {
            x[self.layout.q(i)] = 0.5 * (limits.lower + limits.upper);
            x[self.layout.p1(i)] = 0.5 * self.plant().supply_pressures.supply;
            x[self.layout.p2(i)] = 0.4 * self.plant().supply_pressures.supply;
        }
        if let Some(p) = self.layout.mains() {
            x[p] = self.plant().supply_pressures.supply;
        }
        let mut dx = vec![0.0; x.len()];
        let at = Moment { layout: &self.layout, x: &x, u: &[0.0; N], payload: self.machine.payload.mass };
        self.laws.derivative(at, &mut dx);
        match dx.iter().position(|d| !d.is_finite()) {
            Some(i) => Err(BuildError::NotFinite(self.layout.names[i].clone())),
            None => Ok(()),
        }
    }

    /// All parameters of the laws.
    pub fn plant(&self) -> &Plant<f64, N> {
        self.laws.plant()
    }

    pub(crate) fn oil(&self) -> &OilTables {
        self.oil.get_or_init(|| oil::tables(&self.plant().fluid))
    }

    pub(crate) fn actuation_of(&self, i: usize) -> JointActuation<'_> {
        JointActuation {
            joint: &self.plant().mechanics.joints[i],
            actuation: &self.plant().actuations[i],
            description: &self.machine.joints[i],
            cylinder: &self.machine.cylinders[i],
        }
    }

    /// The joint ranges without their edges. The stroke is monotone in q, so admissible ends imply an admissible range.
    /// Empty if an end is not admissible.
    fn safe_ranges(&self) -> [[f64; 2]; N] {
        let inner = self.limit_pairs().map(|[lower, upper]| {
            let edge = EDGE * (upper - lower);
            [lower + edge, upper - edge]
        });
        let fits = |end: usize| self.fits(&inner.map(|range| range[end]));
        if fits(0) && fits(1) {
            inner
        } else {
            [[f64::INFINITY, f64::NEG_INFINITY]; N]
        }
    }

    /// Whether every piston is inside its cylinder and every linkage closes.
    pub(crate) fn fits(&self, q: &[f64; N]) -> bool {
        self.plant().admissible(&self.plant().mechanics.pose(q))
    }

    /// The pose of rest of a crane that is placed at `q`. It differs from `q` if the supply pressure cannot press a
    /// piston so far into its end stop.
    pub(crate) fn on_the_stops(&self, mut q: [f64; N], payload: f64) -> [f64; N] {
        let (plant, back) = (self.plant(), self.machine.equilibrium.back_pressure);
        for c in 0..N {
            let load = plant.static_force(&q, payload)[c];
            let (position, _) = plant.strokes(&plant.mechanics.pose(&q))[c];
            let rest = resting_position(&plant.cylinders[c], position, load, back, plant.supply_pressures.supply);
            if rest != position {
                q[c] = self.actuation_of(c).joint_from_stroke(&self.limits[c], rest);
            }
        }
        q
    }

    /// Checks that the crane is no deeper in the ground than its weight and that of the load can press it.
    pub(crate) fn require_above_the_ground(&self, q: &[f64; N], payload: f64) -> Result<(), PoseError> {
        let mechanics = &self.plant().mechanics;
        let Some(ground) = &self.plant().ground else { return Ok(()) };
        let pose = mechanics.pose(q);
        let force = mechanics.contact(ground, &pose, &[0.0; N], payload).force;
        let mass = mechanics.bodies.iter().map(|body| body.mass).sum::<f64>() + payload;
        let (pushed, weight) = (portable::hypot(force.z, force.x), mass * self.machine.environment.gravity);
        if pushed <= weight {
            return Ok(());
        }
        let tip = mechanics.tip_position(&pose);
        let (x, hang) = ground.underside(tip, payload);
        let (surface, _) = ground.surface(x);
        Err(PoseError::InTheGround { tip: tip.z, hang, surface, pushed, weight })
    }

    pub(crate) fn write_outputs(&self, oil: Option<&OilTables>, x: &[f64], payload: f64, out: &mut [f64]) {
        let energy_density = oil.map(|oil| |p| oil.energy_density(p));
        outputs::write(self.plant(), energy_density, &self.laws.evaluated(&self.layout, x, payload), out);
    }

    /// Lowest and highest coordinate of each joint.
    pub fn limit_pairs(&self) -> [[f64; 2]; N] {
        hydrocrane_num::array::from_fn(|i| [self.limits[i].lower, self.limits[i].upper])
    }
}

/// The first `N` numbers of a slice, as an array.
pub(crate) fn array<const N: usize>(x: &[f64]) -> [f64; N] {
    hydrocrane_num::array::from_fn(|i| x[i])
}
