//! The machine for the other crates: typed, checked, SI units, names resolved to indices.
//!
//! Nothing here knows physics. `hydrocrane-plant` turns a [`Machine`] into the parameter structs of the laws. Numbers
//! in the equations of motion have the type `T`, so that a machine can be read with derivatives ([`crate::Number`]);
//! all others are plain. Pairs of a friction parameter are (extending, retracting).

pub(crate) mod chain;
pub(crate) mod circuit;
pub(crate) mod pressure_source;

use crate::keys::{self, TIP_AXES};
pub use crate::model::chain::*;
pub use crate::model::circuit::*;
pub use crate::model::pressure_source::*;
use crate::number::Number;
pub use crate::text::document::Place;
use std::borrow::Cow;
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

/// A complete machine: a chain of links, each moved by one cylinder, in the plane of x and z or, where a joint has an axis of its own
/// (`Joint::axis`), in space with y to the left.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine<T = f64> {
    pub name: String,
    pub title: String,
    pub description: String,
    pub environment: Environment<T>,
    /// Chain order; `links[0]` is the fixed base, whose frame is the inertial frame (x forward, z normal to what it stands on).
    pub links: Vec<Link<T>>,
    /// Chain order; `joints[i]` connects `links[i]` to `links[i + 1]`.
    pub joints: Vec<Joint<T>>,
    /// `cylinders[i]` moves `joints[i]`.
    pub cylinders: Vec<Cylinder<T>>,
    pub fluid: Fluid<T>,
    pub supply: Supply<T>,
    pub payload: Payload<T>,
    /// The crane tip: a point of one link.
    pub tip: Point<T>,
    pub equilibrium: Equilibrium<T>,
    pub errata: Errata,
    pub sensors: Vec<Sensor>,
    /// Polygons in the inertial frame that controllers keep the tip out of: name and corners (x, z), m.
    pub keep_out: Vec<(String, Vec<[f64; 2]>)>,
    /// The ground under the tip and its load; `None` without ground.
    pub ground: Option<Ground<T>>,
    pub control: Control,
    /// One entry per value of the file, in file order.
    pub provenance: Arc<Vec<Provenance>>,
    /// Names and choices of the file with the dotted paths of their keys, in the order in which they are read.
    pub words: Arc<Vec<(String, String)>>,
    /// Allowed but unusual values, in the order in which they are read; those found from geometry and weights are last.
    pub warnings: Vec<Unusual>,
}

impl<T: Number> Machine<T> {
    /// Mass of all links but the base, kg.
    pub fn moving_mass(&self) -> f64 {
        self.links.iter().skip(1).map(|link| link.mass.plain()).sum()
    }
}

/// Where the machine stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment<T = f64> {
    /// Gravitational acceleration, m/s^2 (positive).
    pub gravity: T,
    /// Angle by which the front of the base is raised, rad from x towards z; gravity acts along -z where it is zero.
    pub slope: T,
}

impl<T> Machine<T> {
    /// Whether a joint moves out of the plane of x and z.
    pub fn is_spatial(&self) -> bool {
        self.joints.iter().any(|joint| joint.axis.is_some())
    }
}

impl Machine {
    /// Whether the first joint slews: it turns all others about the vertical axis of the machine's frame, and these move in one plane
    /// along it. A machine in space that does not has no such plane.
    pub fn slews(&self) -> bool {
        let upright = |joint: &Joint| matches!(joint.turning_axis(), [0.0, 0.0, _]);
        let across = |joint: &Joint| matches!(joint.turning_axis(), [0.0, _, 0.0]);
        self.joints.split_first().is_some_and(|(first, rest)| upright(first) && rest.iter().all(across))
    }

    /// Where a tip at (x, y, z) can be in the plane in which regions lie, (x, z), m: of a machine that slews, with the first joint turned back to
    /// zero, before the axis or behind it.
    pub fn sections(&self, [x, y, z]: [f64; 3]) -> [[f64; 2]; 2] {
        if !self.slews() {
            return [[x, z]; 2];
        }
        let [axis_x, axis_y, _] = self.joints[0].at_in_space();
        let aside = self.joints[1..].iter().map(|joint| joint.aside).sum::<f64>() + self.tip.aside;
        let (dx, dy) = (x - axis_x, y - axis_y);
        let along = libm::sqrt((dx * dx + dy * dy - aside * aside).max(0.0));
        [[axis_x + along, z], [axis_x - along, z]]
    }

    /// Axes of the stick that moves the tip: forward, up, and across where the machine slews.
    pub fn tip_axes(&self) -> &'static [&'static str] {
        if self.slews() {
            &TIP_AXES
        } else {
            &TIP_AXES[..2]
        }
    }

    /// A digest of the values and choices that the file states (FNV-1a, 64 bits), whatever their order and notation, and
    /// however many files they stand in.
    pub fn contents(&self) -> String {
        let bits = |value: &f64| format!("{:x}", value.to_bits());
        let values = self.provenance.iter().map(|entry| (&entry.key, entry.value.si.iter().map(bits).collect()));
        let words = self.words.iter().map(|(key, word)| (key, vec![word.clone()]));
        let mut stated: Vec<(&String, Vec<String>)> = values.chain(words).collect();
        stated.sort();
        let digest = |digest: u64, byte: u8| (digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        format!("{:016x}", format!("{stated:?}").bytes().fold(0xcbf2_9ce4_8422_2325, digest))
    }
}

/// A value outside its usual range.
#[derive(Debug, Clone, PartialEq)]
pub struct Unusual {
    /// Dotted path of the value.
    pub key: String,
    /// Its place: `crane.toml:12:8`, or the override.
    pub place: String,
    /// The value and the usual range.
    pub text: String,
    /// The likely intention.
    pub cure: String,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Cylinder<T = f64> {
    pub name: String,
    /// Index of the joint this cylinder moves (equal to its own index).
    pub joint: usize,
    /// Pin of the barrel.
    pub barrel_pin: Point<T>,
    pub rod_pin: RodPin<T>,
    /// Equal cylinders in parallel, a whole number; diameters, dead volumes, leakage, end stop and friction are those of one.
    pub count: T,
    /// Whether it is a motor that drives the pinion: oil passes from side to side, and these stay as large as they are. `bore` is then that
    /// of a piston that takes as much oil for the same travel of the rack.
    pub motor: bool,
    pub bore: T,
    pub rod_diameter: T,
    /// Travel between the end positions, m; the piston position x runs over +-stroke/2.
    pub stroke: T,
    /// Distance of the pins with the piston at mid-stroke, m.
    pub mid_length: T,
    /// Lowest piston position before the rod face meets the barrel, m; `None` if the file gives no rod length.
    pub rod_contact: Option<T>,
    /// Dead volumes at the piston side and the rod side, m^3, and their values as the thesis printed them.
    pub dead_volume: [T; 2],
    pub printed_dead_volume: Option<[T; 2]>,
    /// Bore of the connectors, m; `None`: no connector pressure rise.
    pub port_diameter: Option<T>,
    pub leakage: Leakage<T>,
    pub end_stop: EndStop<T>,
    /// Pressure that its chambers are rated for, Pa; `None` if not stated.
    pub pressure_rating: Option<f64>,
    pub valve: Valve<T>,
    pub ports: CylinderPorts<T>,
    pub friction: Friction<T>,
}

/// Parts at the ports of a cylinder, of the piston side and of the rod side.
#[derive(Debug, Clone, PartialEq)]
pub struct CylinderPorts<T = f64> {
    pub holding: [Option<LoadHolding<T>>; 2],
    /// Between the ports and the valve.
    pub lines: [Option<Line<T>>; 2],
    /// Between the ports and the tank.
    pub valves: [PortValves<T>; 2],
    /// Relief valves from each port to the other one.
    pub crossover: [Option<PortRelief<T>>; 2],
    /// Of the hoses to the ports.
    pub leaks: [Option<HoseLeak<T>>; 2],
}

impl<T> CylinderPorts<T> {
    /// Ports without any part.
    pub fn plain() -> Self {
        CylinderPorts {
            holding: [None, None],
            lines: [None, None],
            valves: hydrocrane_num::array::from_fn(|_| PortValves { relief: None, anti_cavitation: None }),
            crossover: [None, None],
            leaks: [None, None],
        }
    }
}

impl<T: Number> Cylinder<T> {
    /// Areas of the piston side and the rod side, m^2, of all cylinders in parallel together.
    pub fn areas(&self) -> [T; 2] {
        let circle = |diameter: T| diameter * FRAC_PI_4 * diameter;
        let piston = circle(self.bore);
        [piston, piston - circle(self.rod_diameter)].map(|area| area * self.count)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub enum RodPin<T = f64> {
    Point(Point<T>),
    /// The rod pulls the common pin of a four-bar torque linkage.
    FourBar(FourBar<T>),
    /// The rod is a rack on a pinion of this pitch radius (m) on the joint; the piston is at mid-stroke where the joint is at `zero`.
    Rack(T),
}

/// Four-bar torque linkage: rocker on the parent link, coupler to the child link, joined in the common pin.
#[derive(Debug, Clone, PartialEq)]
pub struct FourBar<T = f64> {
    pub rocker_pivot: Point<T>,
    pub coupler_pivot: Point<T>,
    pub rocker_length: T,
    pub coupler_length: T,
    /// +1: the common pin lies left of the line rocker pivot -> coupler pivot (x right, z up); -1: right.
    pub side: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Leakage<T = f64> {
    /// Annular gaps: gap height m, length of the piston gap m, length of the rod gland m.
    Gap { gap: T, piston_length: T, gland_length: T, printed_external_from_piston_side: bool },
    /// Conductances, m^3/(s Pa).
    Conductance { internal: T, external: T },
}

#[derive(Debug, Clone, PartialEq)]
pub struct EndStop<T = f64> {
    /// Length over which the stop acts before the end of the stroke, m.
    pub zone: T,
    /// N/m
    pub stiffness: T,
    /// N s/m at full compression
    pub damping: T,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Valve<T = f64> {
    pub name: String,
    pub kind: ValveKind,
    /// Largest spool displacement, m.
    pub stroke: T,
    /// Flow through one metering edge at full stroke and `edge_pressure_drop`, m^3/s.
    pub nominal_flow: T,
    /// Pressure drop across one metering edge at `nominal_flow`, Pa.
    pub edge_pressure_drop: T,
    pub transition_pressure: T,
    /// Thresholds of the printed three-branch law and the ports it serves (A, B).
    pub printed_blend: Option<PrintedBlend<T>>,
    pub spool: SpoolDynamics<T>,
    /// m
    pub overlap: T,
    /// Curves of the edges supply to A, A to tank, supply to B and B to tank; `None`: in proportion to the spool beyond the overlap.
    pub metering: [Option<EdgeCurve<T>>; 4],
    /// Of the edges from port A and from port B to the tank: separate spools that hold a return pressure.
    pub meter_out: [Option<MeterOut<T>>; 2],
    /// Laminar leakage conductance per closed edge, m^3/(s Pa).
    pub leakage: T,
    /// Areas of the edges from port A and from port B to the tank, over those from the supply.
    pub return_ratio: [T; 2],
    /// A check valve keeps oil from flowing back into the mains.
    pub load_check: bool,
    pub compensator: Compensator<T>,
    /// s; `None`: the compensator follows at once.
    pub compensator_time_constant: Option<T>,
    /// s
    pub delay: f64,
    /// Signal chain from a controller's command to the spool.
    pub command: SignalChain,
}

/// How a spool follows its command: a second-order lag with limits.
#[derive(Debug, Clone, PartialEq)]
pub struct SpoolDynamics<T = f64> {
    /// rad/s
    pub natural_frequency: T,
    pub damping_ratio: T,
    /// m/s
    pub velocity_limit: Option<T>,
    /// m/s^2
    pub acceleration_limit: Option<T>,
}

/// Area of a metering edge over the displacement of the spool.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeCurve<T = f64> {
    /// Share of the stroke, and share of `full`.
    pub points: Vec<[f64; 2]>,
    /// Area over that of the nominal flow at the nominal drop.
    pub full: T,
}

impl<T> EdgeCurve<T> {
    /// Share of the stroke up to which the edge is closed.
    pub fn dead_band(&self) -> f64 {
        self.points.iter().take_while(|point| point[1] == 0.0).last().map_or(0.0, |point| point[0])
    }
}

impl<T: Number> Valve<T> {
    /// Largest area of an edge from the supply, over that of the nominal flow.
    pub fn largest_feed(&self) -> f64 {
        let feeds = [&self.metering[0], &self.metering[2]];
        feeds.map(|curve| curve.as_ref().map_or(1.0, |curve| curve.full.plain())).into_iter().fold(0.0, f64::max)
    }

    /// Flow from the supply at full stroke with this pressure drop over the edge, m^3/s.
    pub fn feed_at(&self, drop: f64) -> f64 {
        self.largest_feed() * self.nominal_flow.plain() * libm::sqrt(drop / self.edge_pressure_drop.plain())
    }

    /// Displacement of the spool up to which both edges from the supply are closed, m.
    pub fn closed_zone(&self) -> T {
        let closed = |curve: &Option<EdgeCurve<T>>| match curve {
            Some(curve) => self.stroke * curve.dead_band(),
            None => self.overlap,
        };
        closed(&self.metering[0]).min(closed(&self.metering[2]))
    }
}

/// Signal chain between a controller's command u and the spool command (thesis Figures 18 and 60):
/// limited(offset + gain * u beyond the dead band), `delay` later. Identity by default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignalChain {
    /// m of spool stroke
    pub offset: f64,
    pub gain: f64,
    /// Dead band: smaller commands have no effect, larger ones count from here, m.
    pub dead_band: f64,
    /// Limits of the spool command, m.
    pub low: f64,
    pub high: f64,
    /// Half width of the hysteresis between command and spool, m.
    pub play: f64,
    /// s
    pub delay: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct PrintedBlend<T = f64> {
    pub low: T,
    pub high: T,
    pub ports: [bool; 2],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValveKind {
    FourThree,
    /// Extending, port B is connected to the supply instead of the tank.
    Regenerative,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Friction<T = f64> {
    pub model: FrictionModel,
    pub coulomb: [T; 2],
    /// Largest force at rest (Coulomb plus the Stribeck rise), N.
    pub breakaway: [T; 2],
    pub stribeck_velocity: [T; 2],
    pub stribeck_exponent: [T; 2],
    /// N (s/m)^viscous_exponent
    pub viscous: [T; 2],
    pub viscous_exponent: [T; 2],
    /// Velocity over which the static map changes its sign, m/s; `None`: the law's own choice.
    pub smoothing_velocity: Option<T>,
    /// LuGre bristle stiffness sigma_0, N/m (0 with the static model).
    pub bristle_stiffness: T,
    /// LuGre bristle damping sigma_1, N s/m.
    pub bristle_damping: T,
    /// v_d of sigma_1(v) = sigma_1 exp(-(v/v_d)^2), m/s; `None`: constant.
    pub bristle_damping_velocity: Option<T>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrictionModel {
    Static,
    LuGre,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Fluid<T = f64> {
    /// Density at zero gauge pressure, kg/m^3.
    pub density: T,
    /// E = 1/2 bulk_max log10(c1 p / bulk_reference_pressure + c2)   (96). A constant modulus E is c1 = 0, c2 = 100.
    pub bulk_modulus_max: T,
    pub bulk_c1: T,
    pub bulk_c2: T,
    pub bulk_reference_pressure: T,
    pub cavitation: Cavitation<T>,
    /// Dynamic viscosity, Pa s, and the value the thesis printed in its place.
    pub viscosity: T,
    pub printed_leakage_viscosity: Option<T>,
}

impl<T: Number> Fluid<T> {
    /// Bulk modulus (96) at the pressure `p` (Pa), Pa.
    pub fn modulus_at(&self, p: f64) -> f64 {
        let [max, c1, c2, reference] =
            [self.bulk_modulus_max, self.bulk_c1, self.bulk_c2, self.bulk_reference_pressure].map(T::plain);
        0.5 * max * libm::log10(c1 * p / reference + c2)
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cavitation<T = f64> {
    /// Below zero gauge pressure free gas expands by Boyle's law; pressure stays above `vacuum` (gauge, Pa, negative).
    FreeGas { vacuum: T },
    /// The modulus of |p|, as in the printed program: pressures may fall without bound.
    None,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Payload<T = f64> {
    /// Point mass at the tip, kg.
    pub mass: T,
    /// From the tip down to the underside of a load, m, and its growth with the root of the mass, m/kg^(1/2): what the
    /// ground touches.
    pub hang: T,
    pub hang_growth: T,
    /// What pictures show at the tip.
    pub tool: &'static str,
}

/// Flat ground with flat supports on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground<T = f64> {
    /// Of its surface in the inertial frame, m.
    pub height: T,
    /// N/m
    pub stiffness: T,
    /// Growth of the normal force with the speed of sinking, s/m.
    pub damping: T,
    /// Coulomb's coefficient.
    pub friction: T,
    pub supports: Vec<Support<T>>,
}

/// A flat support that stands on the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Support<T = f64> {
    pub name: String,
    /// Of its surface in the inertial frame, m.
    pub height: T,
    /// It has its full height between these, m.
    pub from: T,
    pub to: T,
    /// Length over which the surface rises from the ground on either side of that, m.
    pub edge: T,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium<T = f64> {
    /// Gauge pressure of the chamber that carries less, Pa.
    pub back_pressure: T,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    pub name: String,
    /// What is measured, e.g. `joint.boom.q` or `cylinder.lift.p1`.
    pub measures: String,
    pub kind: String,
    /// Numeric properties by key, SI.
    pub properties: Vec<(String, f64)>,
    /// Path and place of its range, or of what it measures if it has none.
    pub key: String,
    pub place: Place,
}

/// Names that data sheets have for the range of an analogue sensor.
pub(crate) const RANGES: [&str; 3] = ["range", "full-scale", "span"];

impl Sensor {
    pub fn property(&self, key: &str) -> Option<f64> {
        self.properties.iter().find(|(name, _)| name == key).map(|(_, value)| *value)
    }

    /// A property that is zero where nobody states it.
    pub fn share(&self, key: &str) -> f64 {
        self.property(key).unwrap_or(0.0)
    }

    /// Its range as the data sheet states it; zero without one.
    pub fn range(&self) -> f64 {
        RANGES.into_iter().find_map(|key| self.property(key)).unwrap_or(0.0)
    }

    /// Lowest and highest reading; `None` for sensors that turn on and on.
    pub fn limits(&self) -> Option<[f64; 2]> {
        let (range, middle) = (self.range(), self.share("offset"));
        match self.kind.as_str() {
            "incremental-encoder" => None,
            "pressure-transmitter" => Some([0.0, range]),
            "load-cell" => Some([-range, range]),
            _ => Some([middle - 0.5 * range, middle + 0.5 * range]),
        }
    }
}

/// Defaults of the sampled controllers.
#[derive(Debug, Clone, PartialEq)]
pub struct Control {
    /// Time between samples, s.
    pub period: Option<f64>,
    /// Per controller its gains by key, SI.
    pub gains: Vec<(String, Vec<(String, f64)>)>,
    pub thesis: ThesisSteps,
    /// Tip control estimates all chamber pressures and reads none.
    pub estimates_pressures: bool,
    /// Joint that holds the tip's height in the stick mode `height`; `None`: the telescope, else the last one.
    pub height_joint: Option<usize>,
}

/// The steps of the thesis's controller that its program leaves out (Table 6): whether they are executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ThesisSteps {
    /// Step 6: the set-point stays in the working area.
    pub working_area: bool,
    /// Step 8: a penalty chooses the telescope, which otherwise stays at zero.
    pub penalty: bool,
}

impl Control {
    /// A gain of a controller: that of the file, else its declared default; `None` where it follows from other values.
    pub fn gain(&self, controller: &str, key: &str) -> Option<f64> {
        self.stated(controller, key).or_else(|| keys::default_gain(controller, key))
    }

    /// A gain of a controller, if the file states it.
    pub fn stated(&self, controller: &str, key: &str) -> Option<f64> {
        let (_, gains) = self.gains.iter().find(|(name, _)| name == controller)?;
        gains.iter().find(|(name, _)| name == key).map(|(_, value)| *value)
    }
}

/// Each correction of the thesis as a switch: `true` = corrected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Errata {
    pub gravity_sign: bool,
    pub inertia_about: bool,
    pub orifice_law: bool,
    pub extension_leakage: bool,
    pub extension_dead_volume: bool,
    pub leakage_viscosity: bool,
    pub end_stop: bool,
    pub friction_map: bool,
    pub ik_quadrant: bool,
    pub ik_unreachable: bool,
    pub ik_extension: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ProvenanceClass {
    Measured,
    Fitted,
    Literature,
    Assumed,
    Setting,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// Dotted path of the value.
    pub key: String,
    pub class: ProvenanceClass,
    pub source: String,
    pub value: Recorded,
}

/// A value of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// SI; points of a list one after the other.
    pub si: Vec<f64>,
    /// SI unit of each value, or one for all; empty for a plain number.
    pub units: Vec<Cow<'static, str>>,
    pub form: Form,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Form {
    #[default]
    One,
    /// One value that stands for both of a pair.
    Shared,
    /// A pair or a point.
    Two,
    List,
}
