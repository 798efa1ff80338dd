//! `[link]`, `[joint]`, `[payload]`, `[ground]` and `[keep-out]`.

use super::Sign::{Any, NonNegative, Positive};
use super::{Key, Kind, Value};
use crate::units::quantities::{ANGLE, INERTIA, LENGTH, MASS, NUMBER, STIFFNESS};

const STATUS: &[&str] = &["active", "inactive"];
const WITH_MASS: &str = "with `mass`";
const OF_ACTIVE: &str = "required unless `inactive`";

pub static LINK: &[Key] = &[
    Key::quantity("axis", &[ANGLE], Any)
        .defaults(&["0 deg"])
        .usual(&[("0 deg", "720 deg", 100.0)])
        .means("Direction of the link's own axis in its frame."),
    Key::quantity("mass", &[MASS], Positive)
        .otherwise("required, except for the base and for links made of bodies")
        .usual(&[("0.1 kg", "20 t", 1e3)])
        .means("Mass without the bodies fixed on the link."),
    Key::new("centre-of-gravity", Value::Point)
        .otherwise(WITH_MASS)
        .usual(&[("0 m", "30 m", 30.0)])
        .means("Centre of gravity in the link's frame."),
    Key::quantity("inertia", &[INERTIA], NonNegative)
        .otherwise("with `mass`; the base needs none")
        .usual(&[("0.0001 kg m^2", "1e7 kg m^2", 1e3)])
        .means("Moment of inertia about the axis y through the point that `inertia-about` names."),
    MOMENT_X,
    MOMENT_Z,
    PRODUCT_XY,
    PRODUCT_XZ,
    PRODUCT_YZ,
    Key::choice("inertia-about", &["frame", "centre-of-gravity"])
        .otherwise("with `mass`")
        .means("Whether `inertia` is about the origin of the frame or the centre of gravity."),
    Key::new("outline", Value::Points)
        .otherwise("a line through the points")
        .usual(&[("0 m", "30 m", 30.0)])
        .means("Points of the line that drawings show."),
    Key::table("point", POINT).otherwise("none").means("Named points of the link, in its frame."),
    Key::tables("body", BODY).otherwise("none").means("A further body fixed on the link."),
];

static POINT: &[Key] =
    &[Key::new("<point>", Value::Point).usual(&[("0 m", "30 m", 30.0)]).means("A point of the link, in its frame.")];

static BODY: &[Key] = &[
    Key::quantity("mass", &[MASS], Positive).required().usual(&[("1 g", "20 t", 1e3)]).means("Mass of the body."),
    Key::new("centre-of-gravity", Value::Point)
        .required()
        .usual(&[("0 m", "30 m", 30.0)])
        .means("Centre of gravity of the body, in the link's frame."),
    Key::quantity("inertia", &[INERTIA], NonNegative)
        .required()
        .usual(&[("1e-6 kg m^2", "1e7 kg m^2", 1e3)])
        .means("Moment of inertia of the body about the axis y through its own centre of gravity."),
    MOMENT_X,
    MOMENT_Z,
    PRODUCT_XY,
    PRODUCT_XZ,
    PRODUCT_YZ,
];

const IN_SPACE: &str = "required where a joint before it has an `axis`";

const MOMENT_X: Key = Key::quantity("inertia-x", &[INERTIA], NonNegative)
    .otherwise(IN_SPACE)
    .usual(&[("1e-6 kg m^2", "1e7 kg m^2", 1e3)])
    .means("Moment of inertia about the axis x through the centre of gravity.");
const MOMENT_Z: Key = Key::quantity("inertia-z", &[INERTIA], NonNegative)
    .otherwise(IN_SPACE)
    .usual(&[("1e-6 kg m^2", "1e7 kg m^2", 1e3)])
    .means("Moment of inertia about the axis z through the centre of gravity.");
const PRODUCT_XY: Key = product("inertia-xy");
const PRODUCT_XZ: Key = product("inertia-xz");
const PRODUCT_YZ: Key = product("inertia-yz");

const fn product(name: &'static str) -> Key {
    Key::quantity(name, &[INERTIA], Any)
        .defaults(&["0 kg m^2"])
        .usual(&[("1e-6 kg m^2", "1e7 kg m^2", 1e3)])
        .means("Element of the tensor of inertia about the centre of gravity: the product of inertia with a minus sign, as in a URDF.")
}

pub static JOINT: &[Key] = &[
    Key::choice("type", &["revolute", "prismatic"]).required().means("Whether the joint turns or slides."),
    Key::text("parent").required().means("The link on the side of the base."),
    Key::text("child").required().means("The link that the joint moves."),
    Key::text("at").required().means("Name of the point of the parent where the joint lies."),
    Key::text("axis").otherwise("the joint moves in the plane of x and z").means(
        "Axis of a revolute joint, about which a growing angle turns by the right-hand rule, in the parent's frame: `x`, `y`, `z`, one of these with a minus, or three numbers as `(0, 0.6, 0.8)`. The frames of parent and child are parallel where the coordinate is `zero`.",
    ).source("theory/geometry/spatial_chain.md"),
    Key::choice("convention", &["included", "relative"]).otherwise("required for revolute joints without `axis`").means(
        "Angle of a revolute joint: `included` between the axes of the two links, or `relative` to the parent's axis.",
    ),
    Key::quantity("direction", &[ANGLE], Any)
        .otherwise("required for prismatic joints")
        .usual(&[("0 deg", "720 deg", 100.0)])
        .means("Direction, in the parent's frame, in which the coordinate of a prismatic joint grows."),
    Key::quantity("zero", &[ANGLE, LENGTH], Any)
        .defaults(&["0 deg", "0 m"])
        .usual(&[("0 deg", "720 deg", 100.0), ("0 m", "30 m", 30.0)])
        .means("Coordinate of the neutral position."),
    Key::choice("positive", &["counter-clockwise", "clockwise", "along", "against"])
        .otherwise("`counter-clockwise`; of prismatic joints `along`")
        .means(
            "Sense in which the coordinate grows: `counter-clockwise` (x towards z) or `clockwise`; \
             of prismatic joints `along` or `against` the direction.",
        ),
    Key::pair("limits", &[ANGLE, LENGTH], Any)
        .otherwise("derived from the cylinder's stroke")
        .usual(&[("0 deg", "720 deg", 100.0), ("0 m", "30 m", 30.0)])
        .means("Lower and upper limit of the coordinate."),
    Key::quantity("dead-centre-margin", &[ANGLE, LENGTH], NonNegative)
        .defaults(&["2 deg", "1 mm"])
        .usual(&[("0.01 deg", "45 deg", 1e3), ("0.01 mm", "500 mm", 1e3)])
        .means("Distance that the range of the joint keeps from a dead centre."),
];

pub static PAYLOAD: &[Key] = &[
    Key::quantity("mass", &[MASS], NonNegative)
        .defaults(&["0 kg"])
        .usual(&[("0.01 kg", "50 t", 1e3)])
        .means("Point mass at the tip."),
    Key::quantity("hang", &[LENGTH], NonNegative)
        .defaults(&["0 m"])
        .usual(&[("0 m", "20 m", 50.0)])
        .means("Distance of the load's underside below the tip; only `[ground]` uses it."),
    Key::quantity("hang-growth", &[Kind { name: "length per root of a mass", unit: "m/kg^0.5" }], NonNegative)
        .defaults(&["0 m/kg^0.5"])
        .usual(&[("0 m/kg^0.5", "1 m/kg^0.5", 100.0)])
        .means("Growth of that distance with the load: a load of mass m hangs `hang` + `hang-growth` sqrt(m) below the tip."),
    Key::choice("tool", &["hook", "grapple", "bucket"])
        .defaults(&["hook"])
        .means("What pictures show at the tip; its mass is part of the last link or of the payload."),
];

pub static GROUND: &[Key] = &[
    Key::quantity("height", &[LENGTH], Any)
        .required()
        .usual(&[("0 m", "30 m", 30.0)])
        .means("Height of the surface in the inertial frame, whose slope it has."),
    // The weight of 1 t sinks 5 cm.
    Key::quantity("stiffness", &[STIFFNESS], Positive)
        .defaults(&["200 kN/m"])
        .usual(&[("10 kN/m", "100 MN/m", 1e3)])
        .means("Normal force per depth; the default is firm soil.")
        .source("theory/dynamics/ground.md"),
    // At 0.2 m/s the ground pushes back twice as hard as at rest, and a load does not bounce.
    Key::quantity("damping", &[Kind { name: "damping per normal force", unit: "s/m" }], NonNegative)
        .defaults(&["5 s/m"])
        .usual(&[("0.1 s/m", "100 s/m", 100.0)])
        .means("Relative growth of the normal force per speed of sinking.")
        .source("theory/dynamics/ground.md"),
    Key::quantity("friction", &[NUMBER], NonNegative)
        .defaults(&["0.5"])
        .usual(&[("0.05", "2", 50.0)])
        .means("Coulomb's coefficient along the surface; the default is wood or steel on soil.")
        .source("theory/dynamics/ground.md"),
    Key::choice("status", STATUS).defaults(&["active"]).means("`inactive` removes a ground that the machine inherits."),
    Key::tables("support", SUPPORT).otherwise("none").means("A flat support on the ground; at most four."),
];

static SUPPORT: &[Key] = &[
    Key::quantity("height", &[LENGTH], Any).otherwise(OF_ACTIVE).usual(&[("0 m", "30 m", 30.0)]).means(
        "Height of the support's surface in the inertial frame, not below the ground; the highest surface counts.",
    ),
    Key::quantity("from", &[LENGTH], Any)
        .otherwise(OF_ACTIVE)
        .usual(&[("0 m", "50 m", 20.0)])
        .means("Coordinate x at which the full height begins."),
    Key::quantity("to", &[LENGTH], Any)
        .otherwise(OF_ACTIVE)
        .usual(&[("0 m", "50 m", 20.0)])
        .means("Coordinate x at which the full height ends."),
    Key::quantity("edge", &[LENGTH], Positive)
        .defaults(&["100 mm"])
        .usual(&[("5 mm", "2 m", 50.0)])
        .means("Length on either side over which the surface rises to its full height."),
    Key::choice("status", STATUS)
        .defaults(&["active"])
        .means("`inactive` removes a support that the machine inherits."),
];

pub static KEEP_OUT: &[Key] = &[
    Key::new("outline", Value::Points)
        .required()
        .usual(&[("0 m", "50 m", 20.0)])
        .means("Corners of a polygon in the plane of x and z of the inertial frame, three or more; the region turns with a crane that slews, and extends along y for any other machine in space."),
    Key::choice("status", STATUS).defaults(&["active"]).means("`inactive` removes a region that the machine inherits."),
];
