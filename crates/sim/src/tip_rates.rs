//! Redundancy of the tip over slices, without the number of joints in the type.

use hydrocrane_control::reference::redundancy::{resolve, Preference, Task};

/// Arguments of [`resolve_rates`]; slices have one entry per joint, `bounds` one pair.
pub struct RateRequest<'a> {
    /// Row-major `2 x n`.
    pub jacobian: &'a [f64],
    /// Velocity of the tip, m/s, which may be reduced.
    pub velocity: [f64; 2],
    /// Correction of the tip, m/s, which is not reduced.
    pub correction: [f64; 2],
    pub weights: &'a [f64],
    pub preferred: &'a [f64],
    pub bounds: &'a [f64],
}

/// Joint rates and the share of the velocity that they reach; `None` for a number of joints that no controller
/// supports.
pub fn resolve_rates(request: &RateRequest) -> Option<(Vec<f64>, f64)> {
    match request.weights.len() {
        1 => Some(sized::<1>(request)),
        2 => Some(sized::<2>(request)),
        3 => Some(sized::<3>(request)),
        4 => Some(sized::<4>(request)),
        5 => Some(sized::<5>(request)),
        6 => Some(sized::<6>(request)),
        _ => None,
    }
}

fn sized<const N: usize>(request: &RateRequest) -> (Vec<f64>, f64) {
    let jacobian: [[f64; N]; 2] =
        hydrocrane_num::array::from_fn(|r| hydrocrane_num::array::from_fn(|i| request.jacobian[r * N + i]));
    let prefer = Preference {
        weights: hydrocrane_num::array::from_fn(|i| request.weights[i]),
        rates: hydrocrane_num::array::from_fn(|i| request.preferred[i]),
        bounds: hydrocrane_num::array::from_fn(|i| [request.bounds[2 * i], request.bounds[2 * i + 1]]),
    };
    let motion = resolve(&jacobian, &Task { velocity: request.velocity, correction: request.correction }, &prefer);
    (motion.rates.to_vec(), motion.scale)
}
