//! The quantities that keys of machine and scenario files expect.

use crate::units::{Dimension, Quantity};

/// A quantity by its name and SI unit; without a unit it is a plain number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    pub name: &'static str,
    pub unit: &'static str,
}

impl Kind {
    pub fn quantity(self) -> Quantity {
        if self.unit.is_empty() {
            Quantity::number()
        } else {
            Quantity::new(self.name, self.unit)
        }
    }
}

macro_rules! quantities {
    ($($constant:ident = $name:literal in $unit:literal;)*) => {
        $(pub const $constant: Kind = Kind { name: $name, unit: $unit };)*

        /// Name of the quantity that has this dimension, where one of the above does.
        pub fn name_of(dimension: Dimension) -> Option<&'static str> {
            [$($constant),*].iter().find(|kind| kind.quantity().dimension == dimension).map(|kind| kind.name)
        }
    };
}

quantities! {
    LENGTH = "length" in "m";
    ANGLE = "angle" in "rad";
    TIME = "time" in "s";
    MASS = "mass" in "kg";
    INERTIA = "moment of inertia" in "kg m^2";
    ACCELERATION = "acceleration" in "m/s^2";
    VELOCITY = "velocity" in "m/s";
    ANGULAR_FREQUENCY = "angular frequency" in "rad/s";
    FORCE = "force" in "N";
    STIFFNESS = "stiffness" in "N/m";
    DAMPING = "damping coefficient" in "N s/m";
    PRESSURE = "pressure" in "Pa";
    AREA = "area" in "m^2";
    VOLUME = "volume" in "m^3";
    FLOW = "volume flow" in "m^3/s";
    TORQUE = "torque" in "N m";
    COMPLIANCE = "volume per pressure" in "m^3/Pa";
    CONDUCTANCE = "leakage conductance" in "m^3/(s Pa)";
    DENSITY = "density" in "kg/m^3";
    VISCOSITY = "dynamic viscosity" in "Pa s";
    KINEMATIC = "kinematic viscosity" in "m^2/s";
    PER_TURN = "volume per turn" in "m^3/rad";
    VOLTAGE = "voltage" in "V";
}

/// Of the dimension of an angular frequency, so that messages do not name it.
pub const ANGULAR_VELOCITY: Kind = Kind { name: "angular velocity", unit: "rad/s" };
/// Of the dimension of a leakage conductance.
pub const GRADIENT: Kind = Kind { name: "flow per pressure", unit: "m^3/(s Pa)" };
pub const NUMBER: Kind = Kind { name: "plain number", unit: "" };

/// N (s/m)^exponent: a friction force over a power of the velocity.
pub fn viscous_friction(exponent: f64) -> Quantity {
    Quantity::new("viscous friction coefficient", format!("N s^{exponent}/m^{exponent}"))
}
