//! A machine with `N` joints, ready to be asked.

#[cfg(feature = "batch")]
use crate::batch::{self, Kernel};
use crate::controllers::{self, nominal_cylinder};
use crate::crane_step::Precision;
use crate::cylinder_unit::FrictionLaw;
use crate::drawing::{self, Shape};
use crate::equilibrium::{resting_position, EquilibriumMode};
use crate::errors::{BuildError, PoseError, StrokeError};
use crate::from_machine::plant;
use crate::inverse::joint_from_stroke;
use crate::laws::{Laws, Moment};
use crate::layout::{Layout, Unit};
use crate::limits::{Drivetrain, JointLimits};
use crate::model::{Model, Passivity};
use crate::outputs::{self, OutputInfo};
use crate::plant::Plant;
use crate::{monitored, reference, warnings, workspace};
use hydrocrane_control::controller::Controller;
use hydrocrane_control::drive::FRICTION_SPEED;
use hydrocrane_control::feed_forward::{steady_speed, Mains};
use hydrocrane_control::inverse_kinematics::{self, Printed, TooFewRevolute};
use hydrocrane_machine::Machine;
use hydrocrane_num::{portable, small};
use hydrocrane_ode::BlockArrow;
use hydrocrane_physics::hydraulics::fluid::OilTables;
use std::sync::OnceLock;

pub struct Crane<const N: usize> {
    machine: Machine,
    laws: Laws<N>,
    /// Made when first asked for: only energies and densities need them.
    oil: OnceLock<OilTables>,
    layout: Layout,
    precision: Precision,
    limits: Vec<JointLimits>,
    /// Coordinates between which every state is admissible.
    safe: [[f64; 2]; N],
    outputs: Vec<OutputInfo>,
}

/// Speed up to which passivity of friction is checked, m/s: beyond any hydraulic cylinder's.
const FASTEST_PISTON: f64 = 1.0;
/// Share of a mass matrix entry that must be left after elimination: four digits beyond rounding.
const LEAST_PIVOT: f64 = 1e-12;
/// Share of a joint's range at either end where admissibility is looked at closely.
const EDGE: f64 = 1e-3;

impl<const N: usize> Crane<N> {
    pub fn new(machine: &Machine) -> Result<Self, BuildError> {
        let plant = plant::<N>(machine)?;
        let units: Vec<Unit> = (machine.joints.iter().zip(&machine.cylinders).zip(&plant.cylinders))
            .map(|((j, c), p)| Unit {
                joint: j.name.clone(),
                cylinder: c.name.clone(),
                revolute: matches!(j.kind, hydrocrane_machine::model::JointKind::Revolute(_)),
                bristle: p.friction.has_bristle(),
                spool: (c.valve.stroke, c.valve.natural_frequency),
            })
            .collect();
        let layout = Layout::new(&units);
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
            let limits = crane.drivetrain(i).limits()?;
            crane.limits.push(limits);
        }
        crane.safe = crane.safe_ranges();
        crane.check_mass_matrix()?;
        crane.require_finite()?;
        Ok(crane)
    }

    /// Whether rounding leaves anything of the lighter links, in the middle of all ranges.
    fn check_mass_matrix(&self) -> Result<(), BuildError> {
        let mechanics = &self.plant().mechanics;
        let middle = self.limit_pairs().map(|[lower, upper]| 0.5 * (lower + upper));
        let mass_matrix = mechanics.equations(&mechanics.pose(&middle), &[0.0; N], 0.0).mass_matrix;
        if small::least_pivot(&mass_matrix) > LEAST_PIVOT {
            return Ok(());
        }
        let heavy = |i: &usize| mechanics.bodies[*i].inertia.abs().max(mechanics.bodies[*i].mass);
        let heaviest = (0..N).max_by(|a, b| heavy(a).total_cmp(&heavy(b))).unwrap_or(0);
        Err(BuildError::Unresolvable(self.machine.links[heaviest + 1].name.clone()))
    }

    /// A file can hold numbers that are fine one by one and overflow together; one look at the middle tells.
    fn require_finite(&self) -> Result<(), BuildError> {
        let mut x = vec![0.0; self.layout.len()];
        for (i, limits) in self.limits.iter().enumerate() {
            x[self.layout.q(i)] = 0.5 * (limits.lower + limits.upper);
            x[self.layout.p1(i)] = 0.5 * self.plant().mains.supply;
            x[self.layout.p2(i)] = 0.4 * self.plant().mains.supply;
        }
        let mut dx = vec![0.0; x.len()];
        self.derivative(&x, &[0.0; N], self.machine.payload.mass, &mut dx);
        match dx.iter().position(|d| !d.is_finite()) {
            Some(i) => Err(BuildError::NotFinite(self.layout.names[i].clone())),
            None => Ok(()),
        }
    }

    pub(crate) fn plant(&self) -> &Plant<f64, N> {
        self.laws.plant()
    }

    fn oil(&self) -> &OilTables {
        self.oil.get_or_init(|| OilTables::new(self.plant().fluid))
    }

    fn drivetrain(&self, i: usize) -> Drivetrain<'_> {
        Drivetrain {
            joint: &self.plant().mechanics.joints[i],
            actuation: &self.plant().actuations[i],
            description: &self.machine.joints[i],
            cylinder: &self.machine.cylinders[i],
        }
    }

    /// The joints' ranges but for their edges: on its branch a piston goes one way only, so that what is admissible at both
    /// ends is so between them. Nothing is known where it is not.
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
    fn fits(&self, q: &[f64; N]) -> bool {
        self.plant().admissible(&self.plant().mechanics.pose(q))
    }

    /// The pose in which the crane comes to rest that was put into pose `q`: another one where the supply cannot press a
    /// piston so far into its end stop.
    fn on_the_stops(&self, mut q: [f64; N], payload: f64) -> [f64; N] {
        let (plant, back) = (self.plant(), self.machine.equilibrium.back_pressure);
        for c in 0..N {
            let load = plant.static_force(&q, payload)[c];
            let (position, _) = plant.strokes(&plant.mechanics.pose(&q))[c];
            let rest = resting_position(&plant.cylinders[c], position, load, back, plant.mains.supply);
            if rest != position {
                q[c] = self.drivetrain(c).joint_from_stroke(&self.limits[c], rest);
            }
        }
        q
    }

    /// A crane can rest on the ground, and no deeper in it than its own weight and that of the load press it.
    fn require_above_the_ground(&self, q: &[f64; N], payload: f64) -> Result<(), PoseError> {
        let mechanics = &self.plant().mechanics;
        let Some(ground) = &self.plant().ground else { return Ok(()) };
        let pose = mechanics.pose(q);
        let force = mechanics.contact(ground, &pose, &[0.0; N], payload).force;
        let mass = mechanics.bodies.iter().map(|body| body.mass).sum::<f64>() + payload;
        let (pushed, weight) = (force.z.hypot(force.x), mass * mechanics.gravity.abs());
        if pushed <= weight {
            return Ok(());
        }
        let tip = mechanics.tip_position(&pose);
        let (surface, _) = ground.surface(tip.x);
        Err(PoseError::InTheGround { tip: tip.z, hang: ground.hang(payload), surface, pushed, weight })
    }

    fn write_outputs(&self, oil: Option<&OilTables>, x: &[f64], payload: f64, out: &mut [f64]) {
        let energy_density = |p| oil.map_or(f64::NAN, |oil| oil.energy_density(p));
        outputs::evaluate(self.plant(), &self.layout, energy_density, x, payload, out);
    }

    fn limit_pairs(&self) -> [[f64; 2]; N] {
        std::array::from_fn(|i| [self.limits[i].lower, self.limits[i].upper])
    }
}

/// The first `N` numbers of a slice, as an array.
fn array<const N: usize>(x: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| x[i])
}

impl<const N: usize> Model for Crane<N> {
    fn machine(&self) -> &Machine {
        &self.machine
    }
    fn layout(&self) -> &Layout {
        &self.layout
    }
    fn joint_limits(&self) -> &[JointLimits] {
        &self.limits
    }
    fn stroke_limits(&self) -> Vec<[f64; 2]> {
        (0..N).map(|i| self.drivetrain(i).stroke_range(&self.limits[i])).collect()
    }

    fn strokes(&self, q: &[f64], x: &mut [f64], gain: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        for (c, (position, slope)) in self.plant().strokes(&pose).into_iter().enumerate() {
            x[c] = position;
            gain[c] = slope;
        }
    }

    fn joints_from_strokes(&self, x: &[f64], q: &mut [f64]) -> Result<(), StrokeError> {
        for i in 0..N {
            q[i] = joint_from_stroke(&self.drivetrain(i), &self.limits[i], x[i])?;
        }
        Ok(())
    }

    fn cylinder_slopes(&self, q: &[f64], slopes: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        for c in 0..N {
            let parent = pose.link(c);
            let turned = portable::atan2(parent.sin, parent.cos) + self.plant().actuations[c].slope(&pose.joints[c]);
            let (sin, cos) = portable::sin_cos(turned);
            slopes[c] = portable::atan2(sin, cos);
        }
    }

    fn centres_of_gravity(&self, q: &[f64], centres: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        for (i, body) in self.plant().mechanics.bodies.iter().enumerate() {
            let r = pose.links[i].point(body.centre_of_gravity());
            centres[2 * i..2 * i + 2].copy_from_slice(&[r.x, r.z]);
        }
    }

    fn tip(&self, q: &[f64]) -> [f64; 2] {
        let tip = self.plant().mechanics.tip_position(&self.plant().mechanics.pose(&array::<N>(q)));
        [tip.x, tip.z]
    }

    fn tip_jacobian(&self, q: &[f64], jacobian: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        let tip = self.plant().mechanics.tip_position(&pose);
        for j in 0..N {
            let column = pose.column(j, tip);
            jacobian[j] = column.x;
            jacobian[N + j] = column.z;
        }
    }

    fn inverse_kinematics(&self, tip: [f64; 2], held: f64) -> Result<Vec<Vec<f64>>, TooFewRevolute> {
        let errata = &self.machine.errata;
        let printed = Printed {
            quadrant: !errata.ik_quadrant,
            unreachable: !errata.ik_unreachable,
            extension: !errata.ik_extension,
        };
        let held = std::array::from_fn(|i| if self.plant().mechanics.joints[i].revolute { 0.0 } else { held });
        let found = inverse_kinematics::solve(&self.plant().mechanics, &self.limit_pairs(), tip, &held, printed)?;
        Ok(found.into_iter().map(|q| q.to_vec()).collect())
    }

    fn drawing(&self, q: &[f64]) -> Vec<Shape> {
        drawing::draw(self.machine(), self.plant(), &array::<N>(q))
    }
    fn workspace(&self) -> Vec<Vec<[f64; 2]>> {
        workspace::boundary(&self.plant().mechanics, &self.limit_pairs())
    }

    fn equations(&self, q: &[f64], qd: &[f64], payload: f64, mass: &mut [f64], bias: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        let e = self.plant().mechanics.equations(&pose, &array::<N>(qd), payload);
        for j in 0..N {
            mass[j * N..(j + 1) * N].copy_from_slice(&e.mass_matrix[j]);
        }
        bias.copy_from_slice(&e.bias);
    }

    fn forward_dynamics(&self, q: &[f64], qd: &[f64], force: &[f64], payload: f64, qdd: &mut [f64]) {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        let e = self.plant().mechanics.equations(&pose, &array::<N>(qd), payload);
        let gains = self.plant().strokes(&pose);
        let mut driving = std::array::from_fn(|j| gains[j].1 * force[j] - e.bias[j]);
        self.plant().add_contact(&pose, &array::<N>(qd), payload, &mut driving);
        qdd.copy_from_slice(&small::solve_spd(&e.mass_matrix, &driving));
    }

    fn static_force(&self, q: &[f64], payload: f64, force: &mut [f64]) {
        force.copy_from_slice(&self.plant().static_force(&array::<N>(q), payload));
    }
    fn piston_speeds(&self, q: &[f64], payload: f64, speeds: &mut [f64]) {
        let load = self.plant().static_force(&array::<N>(q), payload);
        let strokes = self.spool_strokes();
        for c in 0..N {
            let cylinder = nominal_cylinder(&self.plant().cylinders[c], strokes[c]);
            let mains = Mains { supply: self.plant().mains.supply, tank: self.plant().mains.tank };
            for (speed, sense) in speeds[2 * c..2 * c + 2].iter_mut().zip([-1.0, 1.0]) {
                *speed =
                    steady_speed(&cylinder, &mains, load[c] + cylinder.steady_friction(sense * FRICTION_SPEED), sense);
            }
        }
    }

    fn tip_velocity(&self, q: &[f64], qd: &[f64]) -> [f64; 2] {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        let v = self.plant().mechanics.tip_velocity(&pose, &array::<N>(qd));
        [v.x, v.z]
    }

    fn attach(&self, q: &[f64], qd: &[f64], payload: f64, load: f64, rates: &mut [f64]) -> f64 {
        let pose = self.plant().mechanics.pose(&array::<N>(q));
        let attachment = self.plant().mechanics.attach(&pose, &array::<N>(qd), payload, load);
        rates.copy_from_slice(&attachment.rates);
        attachment.loss
    }

    fn energies(&self, q: &[f64], qd: &[f64], payload: f64) -> (f64, f64) {
        let m = &self.plant().mechanics;
        let pose = m.pose(&array::<N>(q));
        (m.kinetic_energy(&pose, &array::<N>(qd), payload), m.potential_energy(&pose, payload))
    }

    fn ground_energy(&self, q: &[f64], payload: f64) -> f64 {
        let mechanics = &self.plant().mechanics;
        let tip = mechanics.tip_position(&mechanics.pose(&array::<N>(q)));
        self.plant().ground.as_ref().map_or(0.0, |ground| ground.energy(tip, payload))
    }

    fn orifice_flow(&self, cylinder: usize, spool: f64, pressure_drop: f64) -> f64 {
        self.plant().cylinders[cylinder].valve.edge_a.flow(spool, pressure_drop)
    }
    fn bulk_modulus(&self, p: f64) -> f64 {
        self.plant().fluid.bulk_modulus(p)
    }
    fn density(&self, p: f64) -> f64 {
        self.oil().density(p)
    }
    fn steady_friction(&self, cylinder: usize, v: f64) -> f64 {
        self.plant().cylinders[cylinder].friction.steady(v)
    }
    fn passivity(&self) -> Vec<Passivity> {
        let laws = self.plant().cylinders.iter().zip(&self.machine.cylinders);
        laws.filter_map(|(unit, c)| match &unit.friction {
            FrictionLaw::LuGre { map, bristle } => Some(Passivity {
                cylinder: c.name.clone(),
                fails_at: bristle.passivity_limit(map, FASTEST_PISTON),
                checked_to: FASTEST_PISTON,
            }),
            _ => None,
        })
        .collect()
    }

    fn derivative(&self, x: &[f64], u: &[f64], payload: f64, dx: &mut [f64]) {
        self.laws.derivative(Moment { layout: &self.layout, x, u, payload }, dx);
    }

    fn linearise(&self, x: &[f64], u: &[f64], payload: f64, dx: &mut [f64], slopes: &mut BlockArrow<f64>) {
        self.laws.linearise(Moment { layout: &self.layout, x, u, payload }, dx, slopes);
    }

    fn update_input(&self, x: &[f64], u: &[f64], dx: &mut [f64], slopes: &mut BlockArrow<f64>) {
        self.laws.update_input(x, u, dx, slopes);
    }

    fn powers(&self, x: &[f64], payload: f64, powers: &mut [f64]) {
        self.laws.powers(&self.layout, self.oil(), x, payload, powers);
    }

    fn reference_derivative(&self, x: &[f64], u: &[f64], payload: f64) -> Option<Vec<f64>> {
        reference::state_derivative(&self.machine, x, u, payload)
    }

    fn command_slope(&self, rate: &[f64], slope: &mut [f64]) {
        slope.fill(0.0);
        for c in 0..N {
            let w = self.plant().cylinders[c].spool.natural_frequency;
            slope[self.layout.vs(c)] = w * w * rate[c];
        }
    }

    fn error_size(&self, reached: &[f64], error: &[f64]) -> f64 {
        self.precision.mean_square(&self.plant().fluid, &self.layout, reached, |i| error[i]).sqrt()
    }

    fn admissible(&self, x: &[f64]) -> bool {
        let q: [f64; N] = std::array::from_fn(|i| x[self.layout.q(i)]);
        q.iter().zip(&self.safe).all(|(q, [lower, upper])| lower <= q && q <= upper) || self.fits(&q)
    }

    #[cfg(feature = "batch")]
    fn kernel(&self, wanted: Option<&str>) -> Box<dyn Kernel> {
        batch::kernel(self.plant(), &self.layout, wanted)
    }

    fn output_info(&self) -> &[OutputInfo] {
        &self.outputs
    }
    fn outputs(&self, x: &[f64], payload: f64, out: &mut [f64]) {
        self.write_outputs(Some(self.oil()), x, payload, out);
    }
    fn outputs_without_oil(&self, x: &[f64], payload: f64, out: &mut [f64]) {
        self.write_outputs(None, x, payload, out);
    }
    fn equilibrium(&self, q: &[f64], mode: EquilibriumMode, payload: f64) -> Result<Vec<f64>, PoseError> {
        if let Some(place) = warnings::outside_limits(self, q) {
            return Err(PoseError::OutsideLimits(place));
        }
        let q = self.on_the_stops(array::<N>(q), payload);
        self.require_above_the_ground(&q, payload)?;
        self.plant().rest(&self.machine, &self.layout, &q, mode, payload)
    }
    fn controller(&self, name: &str) -> Result<Box<dyn Controller>, String> {
        controllers::build(self, name)
    }
    fn monitored(&self, controller: Box<dyn Controller>, delay: f64) -> Box<dyn Controller> {
        monitored::monitored(self, controller, delay)
    }

    fn spool_strokes(&self) -> Vec<f64> {
        self.machine.cylinders.iter().map(|c| c.valve.stroke).collect()
    }
}
