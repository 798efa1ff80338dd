//! The quantities that keys of machine and scenario files expect.

use crate::units::{Dimension, Quantity};

macro_rules! quantities {
    ($($function:ident = $name:literal in $unit:literal;)*) => {
        $(pub fn $function() -> Quantity { Quantity::new($name, $unit) })*

        /// Name of the quantity that has this dimension, where one of the above does.
        pub fn name_of(dimension: Dimension) -> Option<&'static str> {
            [$($function()),*].iter().find(|quantity| quantity.dimension == dimension).map(|quantity| quantity.name)
        }
    };
}

quantities! {
    length = "length" in "m";
    angle = "angle" in "rad";
    time = "time" in "s";
    mass = "mass" in "kg";
    inertia = "moment of inertia" in "kg m^2";
    acceleration = "acceleration" in "m/s^2";
    velocity = "velocity" in "m/s";
    angular_frequency = "angular frequency" in "rad/s";
    force = "force" in "N";
    stiffness = "stiffness" in "N/m";
    damping = "damping coefficient" in "N s/m";
    pressure = "pressure" in "Pa";
    volume = "volume" in "m^3";
    flow = "volume flow" in "m^3/s";
    conductance = "leakage conductance" in "m^3/(s Pa)";
    density = "density" in "kg/m^3";
    viscosity = "dynamic viscosity" in "Pa s";
    voltage = "voltage" in "V";
}

/// N (s/m)^exponent: a friction force over a power of the velocity.
pub fn viscous_friction(exponent: f64) -> Quantity {
    Quantity::new("viscous friction coefficient", &format!("N s^{exponent}/m^{exponent}"))
}
