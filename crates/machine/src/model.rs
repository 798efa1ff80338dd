//! The machine as the rest of the program sees it: typed, checked, SI units, names resolved to indices.
//!
//! Nothing here knows physics. `hydrocrane-sim` turns a [`Machine`] into the parameter structs of the laws.
//! Pairs `[f64; 2]` of a friction parameter are (extending, retracting).

/// A complete machine: a planar chain of links, each moved by one cylinder.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    pub name: String,
    pub title: String,
    pub description: String,
    /// Gravitational acceleration, m/s^2 (positive; acts along -z).
    pub gravity: f64,
    /// Chain order; `links[0]` is the fixed base, whose frame is the inertial frame (x forward, z up).
    pub links: Vec<Link>,
    /// Chain order; `joints[i]` connects `links[i]` to `links[i + 1]`.
    pub joints: Vec<Joint>,
    /// `cylinders[i]` moves `joints[i]`.
    pub cylinders: Vec<Cylinder>,
    pub fluid: Fluid,
    pub supply: Supply,
    pub payload: Payload,
    /// The crane tip: a point of one link.
    pub tip: Point,
    pub equilibrium: Equilibrium,
    pub errata: Errata,
    pub sensors: Vec<Sensor>,
    /// Polygons in the inertial frame that controllers keep the tip out of: name and corners (x, z), m.
    pub keep_out: Vec<(String, Vec<[f64; 2]>)>,
    /// What carries the tip and its load from below; `None`: nothing does.
    pub ground: Option<Ground>,
    pub control: Control,
    /// One entry per value of the file, in file order.
    pub provenance: Vec<Provenance>,
    /// Values that are allowed and unusual, in the order in which they are read.
    pub warnings: Vec<Unusual>,
}

/// A value outside its usual range.
#[derive(Debug, Clone, PartialEq)]
pub struct Unusual {
    /// Dotted path of the value.
    pub key: String,
    /// Where it was written: `crane.toml:12:8`, or the override.
    pub place: String,
    /// What was found and what is usual.
    pub text: String,
    /// What was probably meant.
    pub cure: String,
}

/// A point fixed in a link: link index and (x, z) in its frame, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    pub link: usize,
    pub name: String,
    pub position: [f64; 2],
}

#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    pub name: String,
    /// Direction of the link's own axis in its frame, rad from x towards z.
    pub axis: f64,
    /// All bodies of the link together: mass, kg.
    pub mass: f64,
    /// Centre of gravity (x, z) in the link frame, m.
    pub centre_of_gravity: [f64; 2],
    /// Moment of inertia about the axis normal to the plane, kg m^2, taken about `inertia_about`.
    pub inertia: f64,
    pub inertia_about: InertiaAbout,
    /// Every named point of the link.
    pub points: Vec<Point>,
    /// Polyline of positions in the link frame, for drawings, m; empty: drawn through joints and points.
    pub outline: Vec<[f64; 2]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InertiaAbout {
    /// About the link frame's origin (its joint).
    Frame,
    CentreOfGravity,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    pub name: String,
    pub kind: JointKind,
    /// Position on the parent link where the child frame's origin sits (prismatic: at coordinate `zero`), m.
    pub at: [f64; 2],
    /// Coordinate (rad or m) at which the joint is in its neutral position.
    pub zero: f64,
    /// +1: a growing coordinate turns the child from x towards z (counter-clockwise seen with x right, z up)
    /// or moves it along `direction`; -1: the other way.
    pub sense: f64,
    /// Joint limits given in the file, overriding the derived ones.
    pub limits: Option<[f64; 2]>,
    /// Distance kept from a dead centre of the linkage, in the joint's unit.
    pub dead_centre_margin: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointKind {
    /// Child axis direction = parent axis direction + sense (q - zero)           [Relative]
    ///                      = parent axis direction + sense (q - zero - pi)      [Included]
    /// where a link's axis direction is its frame angle plus [`Link::axis`].
    Revolute(AngleConvention),
    /// The child frame keeps the parent's orientation; its origin is `at` + sense (q - zero) along `direction`
    /// (rad from x towards z, in the parent frame).
    Prismatic { direction: f64 },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleConvention {
    Relative,
    Included,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Cylinder {
    pub name: String,
    /// Index of the joint this cylinder moves (equal to its own index).
    pub joint: usize,
    /// Pin of the barrel.
    pub barrel_pin: Point,
    pub rod_pin: RodPin,
    pub bore: f64,
    pub rod_diameter: f64,
    /// Travel between the end positions, m; the piston position x runs over +-stroke/2.
    pub stroke: f64,
    /// Distance of the pins with the piston at mid-stroke, m.
    pub mid_length: f64,
    /// Lowest piston position before the rod face meets the barrel, m; `None` where the file gives no rod length.
    pub rod_contact: Option<f64>,
    /// Dead volumes at the piston side and the rod side, m^3, and their values as the thesis printed them.
    pub dead_volume: [f64; 2],
    pub printed_dead_volume: Option<[f64; 2]>,
    /// Bore of the connectors, m; `None`: no connector pressure rise.
    pub port_diameter: Option<f64>,
    pub leakage: Leakage,
    pub end_stop: EndStop,
    /// Pressure that its chambers are rated for, Pa; `None` where the file does not say.
    pub pressure_rating: Option<f64>,
    pub valve: Valve,
    pub friction: Friction,
}

#[derive(Debug, Clone, PartialEq)]
pub enum RodPin {
    Point(Point),
    /// The rod pulls the common pin of a four-bar torque linkage.
    FourBar(FourBar),
}

/// Four-bar torque linkage: rocker on the parent link, coupler to the child link, joined in the common pin.
#[derive(Debug, Clone, PartialEq)]
pub struct FourBar {
    pub rocker_pivot: Point,
    pub coupler_pivot: Point,
    pub rocker_length: f64,
    pub coupler_length: f64,
    /// +1: the common pin lies left of the line rocker pivot -> coupler pivot (x right, z up); -1: right.
    pub side: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Leakage {
    /// Annular gaps: gap height m, length of the piston gap m, length of the rod gland m.
    Gap { gap: f64, piston_length: f64, gland_length: f64, printed_external_from_piston_side: bool },
    /// Conductances, m^3/(s Pa).
    Conductance { internal: f64, external: f64 },
}

#[derive(Debug, Clone, PartialEq)]
pub struct EndStop {
    /// Length over which the stop acts before the end of the stroke, m.
    pub zone: f64,
    /// N/m
    pub stiffness: f64,
    /// N s/m at full compression
    pub damping: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Valve {
    pub name: String,
    pub kind: ValveKind,
    /// Largest spool displacement, m.
    pub stroke: f64,
    /// Flow through one metering edge at full stroke and `edge_pressure_drop`, m^3/s.
    pub nominal_flow: f64,
    /// Pressure drop across one metering edge at `nominal_flow`, Pa.
    pub edge_pressure_drop: f64,
    pub transition_pressure: f64,
    /// Thresholds of the printed three-branch law and the ports it serves (A, B).
    pub printed_blend: Option<PrintedBlend>,
    /// rad/s
    pub natural_frequency: f64,
    pub damping_ratio: f64,
    /// m
    pub overlap: f64,
    /// Laminar leakage conductance per closed edge, m^3/(s Pa).
    pub leakage: f64,
    pub velocity_limit: Option<f64>,
    pub acceleration_limit: Option<f64>,
    /// s
    pub delay: f64,
    /// What becomes of a controller's command on its way to the spool.
    pub command: SignalChain,
}

/// Signal chain between a controller's command u and the spool command (thesis Figures 18 and 60):
/// limited(offset + gain * u beyond the dead band), `delay` later. Identity by default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignalChain {
    /// m of spool stroke
    pub offset: f64,
    pub gain: f64,
    /// Commands up to this size do nothing; larger ones count from here, m.
    pub dead_band: f64,
    /// Limits of the spool command, m.
    pub low: f64,
    pub high: f64,
    /// s
    pub delay: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct PrintedBlend {
    pub low: f64,
    pub high: f64,
    pub ports: [bool; 2],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValveKind {
    FourThree,
    /// Extending, port B is connected to the supply instead of the tank.
    Regenerative,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Friction {
    pub model: FrictionModel,
    pub coulomb: [f64; 2],
    /// Largest force at rest (Coulomb plus the Stribeck rise), N.
    pub breakaway: [f64; 2],
    pub stribeck_velocity: [f64; 2],
    pub stribeck_exponent: [f64; 2],
    /// N (s/m)^viscous_exponent
    pub viscous: [f64; 2],
    pub viscous_exponent: [f64; 2],
    /// Velocity over which the static map changes its sign, m/s; `None`: the law's own choice.
    pub smoothing_velocity: Option<f64>,
    /// LuGre bristle stiffness sigma_0, N/m (0 with the static model).
    pub bristle_stiffness: f64,
    /// LuGre bristle damping sigma_1, N s/m.
    pub bristle_damping: f64,
    /// v_d of sigma_1(v) = sigma_1 exp(-(v/v_d)^2), m/s; `None`: constant.
    pub bristle_damping_velocity: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrictionModel {
    Static,
    LuGre,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Fluid {
    /// Density at zero gauge pressure, kg/m^3.
    pub density: f64,
    /// E = 1/2 bulk_max log10(c1 p / bulk_reference_pressure + c2)   (96). A constant modulus E is c1 = 0, c2 = 100.
    pub bulk_modulus_max: f64,
    pub bulk_c1: f64,
    pub bulk_c2: f64,
    pub bulk_reference_pressure: f64,
    pub cavitation: Cavitation,
    /// Dynamic viscosity, Pa s, and the value the thesis printed in its place.
    pub viscosity: f64,
    pub printed_leakage_viscosity: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cavitation {
    /// Below zero gauge pressure free gas expands by Boyle's law; pressure stays above `vacuum` (gauge, Pa, negative).
    FreeGas { vacuum: f64 },
    /// The modulus of |p|, as in the printed program: pressures may fall without bound.
    None,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Supply {
    pub pressure: f64,
    pub tank_pressure: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Payload {
    /// Point mass at the tip, kg.
    pub mass: f64,
    /// From the tip down to the underside of a load, m, and its growth with the root of the mass, m/kg^(1/2): what the
    /// ground touches.
    pub hang: f64,
    pub hang_growth: f64,
}

/// Flat ground with flat supports on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground {
    /// Of its surface in the inertial frame, m.
    pub height: f64,
    /// N/m
    pub stiffness: f64,
    /// Growth of the normal force with the speed of sinking, s/m.
    pub damping: f64,
    /// Coulomb's coefficient.
    pub friction: f64,
    pub supports: Vec<Support>,
}

/// A flat support that stands on the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    pub name: String,
    /// Of its surface in the inertial frame, m.
    pub height: f64,
    /// It has its full height between these, m.
    pub from: f64,
    pub to: f64,
    /// Length over which the surface rises from the ground on either side of that, m.
    pub edge: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Gauge pressure of the chamber that carries less, Pa.
    pub back_pressure: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    pub name: String,
    /// What is measured, e.g. `joint.boom.q` or `cylinder.lift.p1`.
    pub measures: String,
    pub kind: String,
    /// Numeric properties by key, SI.
    pub properties: Vec<(String, f64)>,
}

/// Defaults of the sampled controllers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Control {
    /// Time between samples, s.
    pub period: Option<f64>,
    /// Per controller its gains by key, SI.
    pub gains: Vec<(String, Vec<(String, f64)>)>,
    pub thesis: ThesisSteps,
}

/// The steps of the thesis's controller that its program leaves out (Table 6): whether they are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ThesisSteps {
    /// Step 6: the set-point stays in the working area.
    pub working_area: bool,
    /// Step 8: a penalty chooses the telescope, which otherwise stays at zero.
    pub penalty: bool,
}

impl Default for ThesisSteps {
    fn default() -> Self {
        ThesisSteps { working_area: true, penalty: false }
    }
}

impl Control {
    /// A gain of a controller, where the file gives it.
    pub fn gain(&self, controller: &str, key: &str) -> Option<f64> {
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

/// A value of the file as it was read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recorded {
    /// SI; points of a list one after the other.
    pub si: Vec<f64>,
    /// SI unit of each value, or one for all; empty for a plain number.
    pub units: Vec<String>,
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
