//! Redundancy of the tip over slices, without the number of joints in the type.

use hydrocrane_control::reference::redundancy::{resolve, Preference, Task};

/// Arguments of [`resolve_rates`]; slices have one entry per joint, `bounds` one pair.
pub struct RateWish<'a> {
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
pub fn resolve_rates(wish: &RateWish) -> Option<(Vec<f64>, f64)> {
    match wish.weights.len() {
        1 => Some(sized::<1>(wish)),
        2 => Some(sized::<2>(wish)),
        3 => Some(sized::<3>(wish)),
        4 => Some(sized::<4>(wish)),
        5 => Some(sized::<5>(wish)),
        6 => Some(sized::<6>(wish)),
        _ => None,
    }
}

fn sized<const N: usize>(wish: &RateWish) -> (Vec<f64>, f64) {
    let jacobian: [[f64; N]; 2] =
        hydrocrane_num::array::from_fn(|r| hydrocrane_num::array::from_fn(|i| wish.jacobian[r * N + i]));
    let prefer = Preference {
        weights: hydrocrane_num::array::from_fn(|i| wish.weights[i]),
        rates: hydrocrane_num::array::from_fn(|i| wish.preferred[i]),
        bounds: hydrocrane_num::array::from_fn(|i| [wish.bounds[2 * i], wish.bounds[2 * i + 1]]),
    };
    let motion = resolve(&jacobian, &Task { velocity: wish.velocity, correction: wish.correction }, &prefer);
    (motion.rates.to_vec(), motion.scale)
}
