//! `[cylinder]`, `[valve]`, `[friction]`, `[fluid]`, `[supply]`, `[pump]`, `[mains]` and `[equilibrium]`.

use super::Sign::{Any, NonNegative, Positive};
use super::{Key, Value};
use crate::units::quantities::{
    ACCELERATION, ANGULAR_FREQUENCY, ANGULAR_VELOCITY, COMPLIANCE, CONDUCTANCE, DAMPING, DENSITY, FLOW, FORCE,
    GRADIENT, KINEMATIC, LENGTH, NUMBER, PER_TURN, PRESSURE, STIFFNESS, TIME, TORQUE, VELOCITY, VISCOSITY, VOLUME,
};

/// Of groups of which a file gives one.
const PARTS: &str = "this group, or `stroke` and `closed-length`";
const TRAVEL: &str = "this group, or the lengths of the parts";
const GAPS: &str = "this group, or `internal-leakage` and `external-leakage`";
const CONDUCTANCES: &str = "this group, or `leakage-gap` and `gland-length`";

pub static CYLINDER: &[Key] = &[
    Key::text("joint").required().means("The joint that the cylinder moves."),
    Key::text("barrel").otherwise("required without `rack-radius`").means("Pin of the barrel, as `link.point`."),
    Key::text("rod").otherwise("this, `linkage` or `rack-radius`").means("Pin of the rod, as `link.point`."),
    Key::quantity("rack-radius", &[LENGTH], Positive)
        .otherwise("this, `rod` or `linkage`")
        .usual(&[("10 mm", "2 m", 100.0)])
        .means("Pitch radius of a pinion on a turning joint that the rod moves as a rack: the piston stands at radius times the angle from `zero`, with mid-stroke there. Pins and `closed-length` are left out.")
        .source("theory/geometry/stroke.md"),
    Key::table("linkage", LINKAGE)
        .otherwise("this, `rod` or `rack-radius`")
        .means("The four-bar through which the rod moves the joint."),
    Key::quantity("count", &[NUMBER], Positive)
        .defaults(&["1"])
        .means("Equal cylinders in parallel that move the joint by the same pins, fed by the same valve; a whole number up to 8. All values of `[cylinder]` and `[friction]` are those of one; valves, lines, leaks and outputs (forces, flows, areas) are those of all together."),
    Key::table("motor", MOTOR)
        .otherwise("a piston with `bore` and `rod-diameter`")
        .means("A motor that turns the joint through gears, in the place of piston and rod. It needs `rack-radius`, the pitch radius of the ring that it drives: its way, speed and force are those at this circle, and `stroke` is how far the joint may turn there. `dead-volume` is the oil of each side up to the valve.")
        .source("theory/hydraulics/chamber.md"),
    Key::quantity("bore", &[LENGTH], Positive)
        .otherwise("required without `motor`")
        .usual(&[("10 mm", "600 mm", 1e3)])
        .means("Diameter of the piston."),
    Key::quantity("rod-diameter", &[LENGTH], NonNegative)
        .otherwise("required without `motor`")
        .usual(&[("3 mm", "500 mm", 1e3)])
        .means("Diameter of the rod, below the bore; 0 for a rack between two pistons, whose sides are alike."),
    Key::quantity("barrel-length", &[LENGTH], Positive)
        .otherwise(PARTS)
        .usual(&[("20 mm", "20 m", 50.0)])
        .means("Length of the barrel; barrel less piston is the stroke.")
        .source("thesis (1)"),
    Key::quantity("piston-length", &[LENGTH], Positive)
        .otherwise("with `barrel-length` or `leakage-gap`")
        .usual(&[("2 mm", "1 m", 1e3)])
        .means("Length of the piston, below that of the barrel."),
    Key::quantity("rod-length", &[LENGTH], Positive)
        .otherwise(PARTS)
        .usual(&[("10 mm", "20 m", 50.0)])
        .means("Length of the rod.")
        .source("thesis (2)"),
    Key::quantity("barrel-offset", &[LENGTH], NonNegative)
        .otherwise(PARTS)
        .usual(&[("1 mm", "5 m", 200.0)])
        .means("Distance from the barrel's pin to the barrel."),
    Key::quantity("rod-offset", &[LENGTH], NonNegative)
        .otherwise(PARTS)
        .usual(&[("1 mm", "5 m", 200.0)])
        .means("Distance from the rod to the rod's pin."),
    Key::quantity("stroke", &[LENGTH], Positive)
        .otherwise(TRAVEL)
        .usual(&[("10 mm", "15 m", 60.0)])
        .means("Travel of the piston."),
    Key::quantity("closed-length", &[LENGTH], Positive)
        .otherwise(TRAVEL)
        .usual(&[("30 mm", "20 m", 50.0)])
        .means("Length from pin to pin, fully retracted."),
    Key::quantity("port-diameter", &[LENGTH], Positive)
        .otherwise("no dynamic pressure at the ports")
        .usual(&[("1 mm", "150 mm", 1e3)])
        .means("Diameter of the connectors."),
    Key::quantity("dead-length", &[LENGTH], Positive)
        .otherwise("this with `port-diameter`, or `dead-volume`")
        .usual(&[("1 mm", "20 m", 50.0)])
        .means("Length of a line with the port's diameter whose volume is the dead volume."),
    Key::pair("dead-volume", &[VOLUME], Positive)
        .otherwise("this, or `dead-length`")
        .usual(&[("0.1 ml", "50 l", 1e3)])
        .means("Dead volume of the chambers (piston side, rod side)."),
    Key::quantity("leakage-gap", &[LENGTH], Positive)
        .otherwise(GAPS)
        .usual(&[("0.5 um", "0.5 mm", 1e6)])
        .means("Annular gap around piston and gland; it needs `piston-length`.")
        .source("theory/hydraulics/leakage.md"),
    Key::quantity("gland-length", &[LENGTH], Positive)
        .otherwise(GAPS)
        .usual(&[("1 mm", "1 m", 1e3)])
        .means("Length of the gap around the rod.")
        .source("theory/hydraulics/leakage.md"),
    Key::quantity("internal-leakage", &[CONDUCTANCE], NonNegative)
        .otherwise(CONDUCTANCES)
        .usual(&[("0 m^3/(s Pa)", "1e-10 m^3/(s Pa)", 1e3)])
        .means("Leakage conductance between the chambers."),
    Key::quantity("external-leakage", &[CONDUCTANCE], NonNegative)
        .otherwise(CONDUCTANCES)
        .usual(&[("0 m^3/(s Pa)", "1e-10 m^3/(s Pa)", 1e3)])
        .means("Leakage conductance from the rod side to the outside."),
    Key::table("end-stop", END_STOP).required().means("The stops at both ends of the stroke."),
    Key::quantity("pressure-rating", &[PRESSURE], Positive)
        .otherwise("1.5 times the supply pressure of the file")
        .means("Pressure that the chambers are rated for; a run warns above it."),
    Key::table("printed", PRINTED_CYLINDER).otherwise("none").means("Values of the printed program, for `[errata]`."),
];

static LINKAGE: &[Key] = &[
    Key::text("rocker-pivot").required().means("Pivot of the rocker, a point of the parent as `link.point`."),
    Key::text("coupler-pivot").required().means("Pivot of the coupler, a point of the child as `link.point`."),
    Key::quantity("rocker-length", &[LENGTH], Positive)
        .required()
        .usual(&[("10 mm", "10 m", 100.0)])
        .means("Distance from the rocker's pivot to the rod's pin."),
    Key::quantity("coupler-length", &[LENGTH], Positive)
        .required()
        .usual(&[("10 mm", "10 m", 100.0)])
        .means("Distance from the coupler's pivot to the rod's pin."),
    Key::choice("side", &["left", "right"])
        .required()
        .means("Side of the rod's pin, looking from the rocker's pivot to the coupler's."),
];

static MOTOR: &[Key] = &[
    Key::quantity("displacement", &[VOLUME, PER_TURN], Positive)
        .required()
        .usual(&[("1 ml", "10 l", 10.0), ("1 ml/rev", "10 l/rev", 10.0)])
        .means("Volume per revolution of its shaft, as in \"23.6 cm3/rev\" or \"23.6 ml\"."),
    Key::quantity("gear-ratio", &[NUMBER], Positive)
        .required()
        .usual(&[("1", "2000", 10.0)])
        .means("Turns of its shaft for one turn of the joint."),
];

static END_STOP: &[Key] = &[
    Key::quantity("zone", &[LENGTH], Positive)
        .required()
        .usual(&[("0.5 mm", "500 mm", 100.0)])
        .means("Length at each end over which the stop acts, at most half the stroke."),
    Key::quantity("stiffness", &[STIFFNESS], Positive)
        .required()
        .usual(&[("100 kN/m", "10 MN/mm", 1e4)])
        .means("Stiffness of the stop."),
    Key::quantity("damping", &[DAMPING], NonNegative)
        .required()
        .usual(&[("100 N s/m", "100 MN s/m", 100.0)])
        .means("Damping of the stop."),
];

static PRINTED_CYLINDER: &[Key] = &[
    Key::pair("dead-volume", &[VOLUME], Positive)
        .otherwise("none")
        .usual(&[("0.1 ml", "50 l", 1e3)])
        .means("Dead volume that the printed program uses (piston side, rod side)."),
    Key::choice("external-leakage-from", &["piston-side", "rod-side"])
        .defaults(&["rod-side"])
        .means("Chamber that the external leakage of the printed program leaves."),
];

pub static VALVE: &[Key] = &[
    Key::text("cylinder").required().means("The cylinder that the valve feeds."),
    Key::choice("type", &["4/3", "regenerative"])
        .required()
        .means("`4/3`, or `regenerative`: port B is always connected to the supply."),
    Key::quantity("stroke", &[LENGTH], Positive)
        .required()
        .usual(&[("0.1 mm", "100 mm", 1e3)])
        .means("Largest displacement of the spool, both ways."),
    Key::quantity("nominal-flow", &[FLOW], Positive)
        .required()
        .usual(&[("0.1 l/min", "5000 l/min", 1e3)])
        .means("Flow at full stroke and nominal pressure drop."),
    Key::quantity("nominal-pressure-drop", &[PRESSURE], Positive)
        .otherwise("this, or `nominal-edge-pressure-drop`")
        .usual(&[("0.5 bar", "240 bar", 150.0)])
        .means("Nominal pressure drop over both edges in series.")
        .source("thesis (65)"),
    Key::quantity("nominal-edge-pressure-drop", &[PRESSURE], Positive)
        .otherwise("this, or `nominal-pressure-drop`; with a compensator before the spool its setting")
        .usual(&[("0.5 bar", "120 bar", 300.0)])
        .means("Nominal pressure drop over one edge."),
    Key::quantity("transition-pressure", &[PRESSURE], Positive)
        .required()
        .usual(&[("0.001 bar", "50 bar", 100.0)])
        .means("Pressure drop at which the flow becomes turbulent."),
    Key::quantity("natural-frequency", &[ANGULAR_FREQUENCY], Positive)
        .required()
        .usual(&[("1 Hz", "1000 Hz", 100.0)])
        .means("Natural frequency of the spool."),
    Key::quantity("damping-ratio", &[NUMBER], Positive)
        .required()
        .usual(&[("0.05", "10", 100.0)])
        .means("Damping ratio of the spool."),
    Key::quantity("overlap", &[LENGTH], NonNegative)
        .defaults(&["0 m"])
        .usual(&[("1 um", "20 mm", 1e3)])
        .means("Half width of the closed zone."),
    Key::quantity("leakage", &[CONDUCTANCE], NonNegative)
        .defaults(&["0 m^3/(s Pa)"])
        .usual(&[("0 m^3/(s Pa)", "1e-10 m^3/(s Pa)", 1e3)])
        .means("Leakage conductance of each edge."),
    Key::pair("return-area-ratio", &[NUMBER], Positive)
        .otherwise("1 for both ports")
        .usual(&[("0.05", "5", 10.0)])
        .means("Areas of the edges from port A and from port B to the tank, divided by those from the supply; with `4/3` only. A small ratio prevents a load from running away.")
        .source("theory/hydraulics/spool_valve.md"),
    Key::choice("load-check", &["yes", "no"])
        .defaults(&["no"])
        .means("Whether a check valve keeps oil from flowing back from the cylinder into the mains; with `4/3` only. A compensated section has one anyway.")
        .source("theory/hydraulics/spool_valve.md"),
    Key::choice("compensator", &["none", "before-spool", "behind-spool"])
        .defaults(&["none"])
        .means("Pressure compensator of the section; with `4/3` only. `before-spool` keeps the pressure drop over the metering edge at its setting, at any load. `behind-spool` gives all sections the same pressure drop, so that they share the flow of the pump (flow sharing).")
        .source("theory/hydraulics/compensator.md"),
    Key::quantity("compensator-setting", &[PRESSURE], Positive)
        .otherwise("required with `before-spool`, not allowed otherwise")
        .usual(&[("1 bar", "60 bar", 10.0)])
        .means("Pressure drop over the metering edge from the supply that the compensator keeps."),
    Key::quantity("compensator-time-constant", &[TIME], Positive)
        .otherwise("the compensator follows at once")
        .usual(&[("0.5 ms", "0.5 s", 10.0)])
        .means("Time constant with which the compensator follows. Its opening is then a state.")
        .source("theory/hydraulics/compensator.md"),
    Key::quantity("velocity-limit", &[VELOCITY], Positive)
        .otherwise("none")
        .usual(&[("1 mm/s", "100 m/s", 1e3)])
        .means("Largest velocity of the spool."),
    Key::quantity("acceleration-limit", &[ACCELERATION], Positive)
        .otherwise("none")
        .usual(&[("0.1 m/s^2", "1e6 m/s^2", 1e3)])
        .means("Largest acceleration of the spool."),
    Key::quantity("delay", &[TIME], NonNegative)
        .defaults(&["0 s"])
        .usual(&[("0.1 ms", "2 s", 30.0)])
        .means("Dead time from the command to the spool."),
    Key::pair("return-pressure", &[PRESSURE], NonNegative)
        .otherwise("the spool of the feed opens the edges to the tank too")
        .usual(&[("0.5 bar", "400 bar", 2.0)])
        .means("Pressures that ports A and B keep while they drain, by spools of their own (separate meter-out); with `4/3` only.")
        .source("theory/hydraulics/meter_out.md"),
    Key::quantity("return-pressure-range", &[PRESSURE], Positive)
        .defaults(&["5 bar"])
        .usual(&[("0.5 bar", "100 bar", 10.0)])
        .means("Rise beyond `return-pressure` that opens the edge fully."),
    Key::table("metering", METERING)
        .otherwise("every edge opens in proportion to the spool beyond the overlap")
        .means("Areas of the metering edges over the displacement of the spool.")
        .source("theory/hydraulics/metering.md"),
    Key::table("command", SIGNAL_CHAIN)
        .otherwise("the spool command is the controller's command")
        .means("The signal chain from a controller's command to the spool command."),
    Key::table("printed", PRINTED_VALVE).otherwise("none").means("Values of the printed program, for `[errata]`."),
];

/// Of the two ways to state a curve.
const AREA_OR_FLOW: &str = "this, or the other of `area` and `flow`";

static METERING: &[Key] = &[
    Key::table("supply-to-a", CURVE)
        .otherwise("in proportion")
        .means("From the supply to port A, as the piston extends."),
    Key::table("a-to-tank", CURVE).otherwise("in proportion").means("From port A to the tank, as it retracts."),
    Key::table("supply-to-b", CURVE)
        .otherwise("in proportion")
        .means("From the supply to port B, as it retracts; of a regenerative valve both ways."),
    Key::table("b-to-tank", CURVE)
        .otherwise("in proportion")
        .means("From port B to the tank, as it extends; with `4/3` only."),
];

static CURVE: &[Key] = &[
    Key::series("travel", &[NUMBER])
        .required()
        .means("Displacements of the spool as shares of its stroke, from 0 to 1, rising; 2 to 16 of them, a thousandth apart at least."),
    Key::series("area", &[NUMBER])
        .otherwise(AREA_OR_FLOW)
        .means("Areas there, as shares of the one that has the nominal flow at the nominal drop; from 0, not falling."),
    Key::series("flow", &[FLOW])
        .otherwise(AREA_OR_FLOW)
        .means("Flows there at the nominal drop over one edge; from 0, not falling."),
];

static SIGNAL_CHAIN: &[Key] = &[
    Key::quantity("offset", &[LENGTH], Any).defaults(&["0 m"]).means("Spool command at rest."),
    Key::quantity("gain", &[NUMBER], Any)
        .defaults(&["1"])
        .usual(&[("0.01", "100", 1e3)])
        .means("Spool command per controller's command outside the dead band."),
    Key::quantity("dead-band", &[LENGTH], NonNegative)
        .defaults(&["0 m"])
        .means("Half width of the dead band of the controller's command."),
    Key::quantity("low", &[LENGTH], Any).otherwise("minus the stroke").means("Lower limit of the spool command."),
    Key::quantity("high", &[LENGTH], Any).otherwise("the stroke").means("Upper limit of the spool command."),
    Key::quantity("hysteresis", &[NUMBER], NonNegative)
        .defaults(&["0"])
        .usual(&[("0.001", "0.15", 10.0)])
        .means("Hysteresis of the pilot stage: width of the loop between command and spool as a share of the stroke in one direction.")
        .source("theory/hydraulics/hysteresis.md"),
    Key::quantity("delay", &[TIME], NonNegative)
        .defaults(&["0 s"])
        .usual(&[("0.1 ms", "2 s", 30.0)])
        .means("Dead time of the chain, added to the valve's own."),
];

static PRINTED_VALVE: &[Key] = &[
    Key::quantity("blend-low", &[PRESSURE], NonNegative)
        .required()
        .usual(&[("0.001 bar", "50 bar", 100.0)])
        .means("Pressure drop at which the printed blend of laminar and turbulent flow begins."),
    Key::quantity("blend-high", &[PRESSURE], Positive)
        .required()
        .usual(&[("0.001 bar", "50 bar", 100.0)])
        .means("Pressure drop at which the blend ends."),
    Key::new("blend-ports", Value::Texts(&["A", "B"])).required().means("Ports with the printed blend."),
];

pub static FRICTION: &[Key] = &[
    Key::text("cylinder").required().means("The cylinder whose seals these are."),
    Key::choice("model", &["lugre", "static"])
        .required()
        .means("The LuGre model with a bristle state, or the static map.")
        .source("theory/friction/lugre.md"),
    Key::pair("coulomb", &[FORCE], NonNegative)
        .required()
        .usual(&[("0.1 N", "100 kN", 1e6)])
        .means("Coulomb friction (extending, retracting)."),
    Key::pair("breakaway", &[FORCE], NonNegative)
        .required()
        .usual(&[("0.1 N", "100 kN", 1e6)])
        .means("Break-away force (extending, retracting); it includes Coulomb friction."),
    Key::pair("stribeck-velocity", &[VELOCITY], Positive)
        .required()
        .usual(&[("0.01 mm/s", "1 m/s", 1e6)])
        .means("Velocity over which friction falls from break-away to Coulomb (extending, retracting)."),
    Key::pair("stribeck-exponent", &[NUMBER], Positive)
        .required()
        .usual(&[("0.1", "10", 1.0)])
        .means("Exponent of that fall (extending, retracting), at most 10."),
    Key::pair("viscous", &[], NonNegative)
        .required()
        .usual(&[("0.1", "1e7", 1e6)])
        .means("Viscous coefficient (extending, retracting) in N (s/m)^`viscous-exponent`."),
    Key::pair("viscous-exponent", &[NUMBER], Positive)
        .required()
        .usual(&[("0.1", "10", 1.0)])
        .means("Power of the velocity in the viscous force (extending, retracting), at most 10."),
    Key::quantity("smoothing-velocity", &[VELOCITY], Positive)
        .otherwise("1 mm/s; as printed the sign jumps")
        .usual(&[("0.001 mm/s", "0.1 m/s", 1e6)])
        .means("Static map: velocity over which the sign changes."),
    Key::quantity("bristle-stiffness", &[STIFFNESS], Positive)
        .otherwise("required for LuGre")
        .usual(&[("1000 N/m", "1000 MN/m", 1e6)])
        .means("LuGre: stiffness of the bristles."),
    Key::quantity("bristle-damping", &[DAMPING], NonNegative)
        .otherwise("required for LuGre")
        .usual(&[("0.1 N s/m", "10 MN s/m", 1e6)])
        .means("LuGre: damping of the bristles."),
    Key::quantity("bristle-damping-velocity", &[VELOCITY], Positive)
        .otherwise("constant damping")
        .usual(&[("0.1 mm/s", "10 m/s", 1e6)])
        .means("LuGre: velocity over which the damping fades."),
];

/// Of the two descriptions of the bulk modulus.
const VARYING: &str = "this group, or `bulk-modulus`";

pub static FLUID: &[Key] = &[
    Key::quantity("density", &[DENSITY], Positive)
        .required()
        .usual(&[("500 kg/m^3", "2000 kg/m^3", 100.0)])
        .means("Density at tank pressure."),
    Key::quantity("bulk-modulus", &[PRESSURE], Positive)
        .otherwise("this, or `bulk-modulus-max` with its coefficients")
        .usual(&[("100 MPa", "10 GPa", 10.0)])
        .means("Constant bulk modulus."),
    Key::quantity("bulk-modulus-max", &[PRESSURE], Positive)
        .otherwise(VARYING)
        .usual(&[("200 MPa", "20 GPa", 20.0)])
        .means("Scale of the pressure-dependent bulk modulus.")
        .source("thesis (96)"),
    Key::quantity("bulk-c1", &[NUMBER], NonNegative)
        .otherwise(VARYING)
        .usual(&[("0", "10000", 1e3)])
        .means("Growth of the bulk modulus with pressure.")
        .source("thesis (96)"),
    Key::quantity("bulk-c2", &[NUMBER], Positive)
        .otherwise(VARYING)
        .usual(&[("1.1", "1000", 1e3)])
        .means(
            "Sets the bulk modulus without pressure: half the decimal logarithm of `bulk-c2`, times `bulk-modulus-max`; above 1.",
        )
        .source("thesis (96)"),
    Key::quantity("bulk-reference-pressure", &[PRESSURE], Positive)
        .otherwise(VARYING)
        .usual(&[("10 bar", "2000 bar", 100.0)])
        .means("Pressure that the growth refers to.")
        .source("thesis (96)"),
    Key::choice("cavitation", &["free-gas", "none"])
        .required()
        .means("Whether gas fills chambers under vacuum; `none` as in the printed program."),
    Key::quantity("vacuum", &[PRESSURE], Any)
        .otherwise("required with `free-gas`")
        .usual(&[("0.5 bar", "1.1 bar", 10.0)])
        .means("Gauge pressure of vacuum, below zero: \"-1 bar\"."),
    Key::quantity("viscosity", &[VISCOSITY, KINEMATIC], Positive)
        .required()
        .usual(&[("0.0005 Pa s", "5 Pa s", 1e3), ("0.5 cSt", "5000 cSt", 1e3)])
        .means("Dynamic viscosity, or the kinematic one, as in \"46 cSt\", which counts times `density`. The grade of an oil, ISO VG 46, is its kinematic viscosity at 40 degrees Celsius."),
    Key::table("printed", PRINTED_FLUID).otherwise("none").means("Values of the printed program, for `[errata]`."),
];

static PRINTED_FLUID: &[Key] = &[Key::quantity("leakage-viscosity", &[VISCOSITY], Positive)
    .required()
    .usual(&[("0.0005 Pa s", "5 Pa s", 1e3)])
    .means("Viscosity that the printed program uses in the leakage law.")];

pub static SUPPLY: &[Key] = &[
    Key::quantity("pressure", &[PRESSURE], NonNegative)
        .required()
        .usual(&[("5 bar", "500 bar", 4.0)])
        .means("Supply pressure, gauge: constant, or the set pressure of the machine's pump."),
    Key::choice("measured", &["yes", "no"])
        .defaults(&["no"])
        .means("Whether the supply follows a measured pressure; `[supply]` of a scenario sets this. Controllers then assume `pressure`."),
    Key::quantity("tank-pressure", &[PRESSURE], NonNegative)
        .required()
        .usual(&[("0.01 bar", "50 bar", 40.0)])
        .means("Tank pressure, gauge, constant."),
];

/// For pumps that are not ideal.
const REAL_PUMP: &str = "required, except for `constant-pressure`";

pub static PUMP: &[Key] = &[
    Key::choice("type", &["constant-pressure", "fixed", "pressure-compensated", "load-sensing"])
        .required()
        .means("`constant-pressure` needs no other key. `fixed` always delivers its full flow; the flow that no valve takes passes the relief valve. `pressure-compensated` reduces its displacement at the supply pressure. `load-sensing` keeps its margin over the highest load pressure, up to the supply pressure.")
        .source("theory/hydraulics/pump.md"),
    Key::quantity("displacement", &[VOLUME, PER_TURN], Positive)
        .otherwise(REAL_PUMP)
        .usual(&[("1 ml", "1 l", 10.0), ("1 ml/rev", "1 l/rev", 10.0)])
        .means("Volume per revolution, as in \"28 cm3/rev\" or \"28 ml\"."),
    Key::quantity("speed", &[ANGULAR_VELOCITY], Positive)
        .otherwise(REAL_PUMP)
        .usual(&[("300 rpm", "4000 rpm", 10.0)])
        .means("Speed of the shaft: constant, or with `droop` that without a load. Overrides of a scenario's phases change it in time."),
    Key::quantity("rated-speed", &[ANGULAR_VELOCITY], Positive)
        .otherwise("`speed` of the file")
        .usual(&[("300 rpm", "4000 rpm", 10.0)])
        .means("Speed at which `volumetric-efficiency` is stated. The leakage follows from both, and stays where a phase or an override changes `speed`."),
    Key::quantity("droop", &[NUMBER], Positive)
        .otherwise("the speed is constant")
        .usual(&[("0.002", "0.3", 4.0)])
        .means("Share of its speed that the engine loses at `rated-torque`; in proportion to the torque, below 1.")
        .source("theory/hydraulics/pump.md"),
    Key::quantity("rated-torque", &[TORQUE], Positive)
        .otherwise("required with `droop`")
        .usual(&[("2 N m", "5000 N m", 10.0)])
        .means("Torque of the pump at which `droop` is stated."),
    Key::quantity("volumetric-efficiency", &[NUMBER], Positive)
        .otherwise(REAL_PUMP)
        .usual(&[("0.7", "1", 3.0)])
        .means("Volumetric efficiency at full displacement, supply pressure and `rated-speed`, at most 1."),
    Key::quantity("hydromechanical-efficiency", &[NUMBER], Positive)
        .otherwise(REAL_PUMP)
        .usual(&[("0.7", "1", 3.0)])
        .means("Hydromechanical efficiency at full displacement, at most 1."),
    Key::quantity("control-range", &[PRESSURE], Positive)
        .defaults(&["10 bar"])
        .usual(&[("1 bar", "50 bar", 10.0)])
        .means("Pressure drop below the set pressure at which the displacement is full."),
    Key::quantity("time-constant", &[TIME], Positive)
        .defaults(&["60 ms"])
        .usual(&[("5 ms", "1 s", 10.0)])
        .means("Time constant of the displacement."),
    Key::quantity("torque-limit", &[TORQUE], Positive)
        .otherwise("no limit")
        .usual(&[("5 N m", "5000 N m", 10.0)])
        .means("Largest torque that the pump takes from its shaft; it reduces its displacement to stay below."),
    Key::quantity("ls-margin", &[PRESSURE], Positive)
        .otherwise("required with `load-sensing`; with `fixed` the pump is not unloaded")
        .usual(&[("2 bar", "60 bar", 10.0)])
        .means("Pressure that the pump keeps above the highest load pressure. The excess flow of a `fixed` pump goes to the tank, so the pump idles at this pressure.")
        .source("theory/hydraulics/load_sensing.md"),
    Key::quantity("ls-time-constant", &[TIME], Positive)
        .defaults(&["20 ms"])
        .usual(&[("1 ms", "1 s", 10.0)])
        .means("Time constant of the load-sensing line between valves and pump."),
];

pub static MAINS: &[Key] = &[
    Key::quantity("volume", &[VOLUME], Positive)
        .required()
        .usual(&[("0.05 l", "100 l", 100.0)])
        .means("Oil in the lines between pump and valves.")
        .source("theory/hydraulics/mains.md"),
    Key::quantity("hose-compliance", &[COMPLIANCE], NonNegative)
        .defaults(&["0 m^3/Pa"])
        .usual(&[("0.001 ml/bar", "10 ml/bar", 100.0)])
        .means("Increase of that volume with pressure."),
    Key::quantity("relief-pressure", &[PRESSURE], Positive)
        .otherwise("1.15 times the supply pressure; with a fixed pump the supply pressure")
        .usual(&[("5 bar", "500 bar", 4.0)])
        .means("Pressure at which the main relief valve opens.")
        .source("theory/hydraulics/relief_valve.md"),
    Key::quantity("relief-gradient", &[GRADIENT], Positive)
        .defaults(&["10 l/(min bar)"])
        .usual(&[("0.1 l/(min bar)", "1000 l/(min bar)", 10.0)])
        .means("Flow of the relief valve per pressure above its opening pressure."),
];

pub static EQUILIBRIUM: &[Key] = &[Key::quantity("back-pressure", &[PRESSURE], NonNegative)
    .defaults(&["10 bar"])
    .usual(&[("0.01 bar", "200 bar", 5.0)])
    .means("Gauge pressure at rest in the chamber with less load.")];
