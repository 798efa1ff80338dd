//! The static friction map as a function of its parameters, with derivatives, for identification.

use hydrocrane_num::Dual;
use hydrocrane_physics::friction::{static_map, StaticParameters};

/// Numbers of a map: six pairs (extending, retracting) in the order of a machine file.
pub const MAP_PARAMETERS: usize = 12;
const VARIABLES: usize = MAP_PARAMETERS + 1;

/// Velocity over which the sign changes, m/s: far below any measurable piston velocity.
const SIGN_WIDTH: f64 = 1e-9;

/// Friction force and its derivatives at one velocity.
#[derive(Debug, Clone, Copy)]
pub struct MapPoint {
    /// N, against positive velocity
    pub force: f64,
    /// dF/dv, N s/m
    pub slope: f64,
    /// dF/dp
    pub gradient: [f64; MAP_PARAMETERS],
}

/// Evaluates the map at velocity `v`, m/s, for `parameters`: Coulomb force, break-away force, Stribeck velocity and
/// exponent, viscous coefficient and exponent, each a pair.
pub fn map_point(parameters: &[f64; MAP_PARAMETERS], v: f64) -> MapPoint {
    type D = Dual<f64, VARIABLES>;
    let p: [D; MAP_PARAMETERS] = hydrocrane_num::array::from_fn(|i| D::variable(parameters[i], i + 1));
    let map = StaticParameters {
        coulomb_extending: p[0],
        coulomb_retracting: p[1],
        breakaway_extending: p[2],
        breakaway_retracting: p[3],
        stribeck_velocity_extending: p[4],
        stribeck_velocity_retracting: p[5],
        stribeck_exponent_extending: p[6],
        stribeck_exponent_retracting: p[7],
        viscous_extending: p[8],
        viscous_retracting: p[9],
        viscous_exponent_extending: p[10],
        viscous_exponent_retracting: p[11],
        // The exponents are parameters like the others.
        gaussian: false,
        three_halves: false,
    };
    let force = static_map::force(&map, D::constant(SIGN_WIDTH), D::variable(v, 0));
    let [slope, gradient @ ..] = force.derivative;
    MapPoint { force: force.value, slope, gradient }
}
