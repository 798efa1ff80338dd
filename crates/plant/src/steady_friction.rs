//! The static friction map of parameters that are still sought, with its derivatives: what identification fits.

use hydrocrane_num::Dual;
use hydrocrane_physics::friction::{static_map, StaticParameters};

/// Numbers of a map: six pairs (extending, retracting) in the order of a machine file.
pub const MAP_PARAMETERS: usize = 12;
const VARIABLES: usize = MAP_PARAMETERS + 1;

/// Velocity over which the sign changes, m/s: far below what a piston can be measured to move at.
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
    let p: [D; MAP_PARAMETERS] = std::array::from_fn(|i| D::variable(parameters[i], i + 1));
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

#[cfg(test)]
mod tests {
    use super::*;

    const ROTTNE: [f64; MAP_PARAMETERS] = [160.0, 280.0, 340.0, 400.0, 2e-3, 2e-3, 2.0, 2.0, 8000.0, 12000.0, 1.5, 1.5];

    #[test]
    fn slopes_are_those_of_differences() {
        for v in [-0.1, -2e-3, -1e-4, 1e-4, 3e-3, 0.1] {
            let here = map_point(&ROTTNE, v);
            for i in 0..MAP_PARAMETERS {
                let step = 1e-5 * ROTTNE[i];
                let [mut low, mut high] = [ROTTNE; 2];
                low[i] -= step;
                high[i] += step;
                let difference = (map_point(&high, v).force - map_point(&low, v).force) / (2.0 * step);
                assert!((difference - here.gradient[i]).abs() <= 1e-6 * (1.0 + difference.abs()), "{i} at {v}");
            }
            let step = 1e-5 * v.abs();
            let difference = (map_point(&ROTTNE, v + step).force - map_point(&ROTTNE, v - step).force) / (2.0 * step);
            assert!((difference - here.slope).abs() <= 1e-5 * (1.0 + difference.abs()), "slope at {v}");
        }
    }

    #[test]
    fn a_direction_has_its_own_parameters() {
        let extending = map_point(&ROTTNE, 0.01);
        let retracting = map_point(&ROTTNE, -0.01);
        for i in 0..MAP_PARAMETERS {
            let other = if i % 2 == 0 { retracting } else { extending };
            assert_eq!(other.gradient[i], 0.0);
        }
        assert!(extending.force > 0.0 && retracting.force < 0.0);
    }
}
